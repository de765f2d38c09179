//! Philox4x64-10, a counter-based generator of another family than PCG (Salmon, Moraes, Dror & Shaw
//! 2011, SC'11, DOI 10.1145/2063384.2063405): a block cipher of the draw's number. It checks that no
//! result leans on the generator, and is slower.

const MULTIPLIER: [u64; 2] = [0xd2e7_470e_e14c_6c93, 0xca5a_8263_9512_1157];
const WEYL: [u64; 2] = [0x9e37_79b9_7f4a_7c15, 0xbb67_ae85_84ca_a73b];

/// A stream of the family.
#[derive(Clone, Copy)]
pub struct Philox {
    key: [u64; 2],
    /// Number of the next draw.
    draw: u64,
}

impl Philox {
    /// The stream of a key.
    pub fn new(key: [u64; 2]) -> Self {
        Philox { key, draw: 0 }
    }

    /// 64 random bits. Each block gives four draws; it is made for each of them, so that a stream stays small.
    #[cold]
    #[inline(never)]
    pub fn bits(&mut self) -> u64 {
        let draw = self.draw;
        self.draw = draw.wrapping_add(1);
        block([draw >> 2, 0, 0, 0], self.key)[(draw & 3) as usize]
    }
}

/// The four words of block `counter` under `key`: ten rounds.
pub fn block(counter: [u64; 4], key: [u64; 2]) -> [u64; 4] {
    let wide = |a: u64, b: u64| {
        let product = u128::from(a) * u128::from(b);
        ((product >> 64) as u64, product as u64)
    };
    let (mut c, mut k) = (counter, key);
    for _ in 0..10 {
        let (hi0, lo0) = wide(MULTIPLIER[0], c[0]);
        let (hi1, lo1) = wide(MULTIPLIER[1], c[2]);
        c = [hi1 ^ c[1] ^ k[0], lo1, hi0 ^ c[3] ^ k[1], lo0];
        k = [k[0].wrapping_add(WEYL[0]), k[1].wrapping_add(WEYL[1])];
    }
    c
}

#[cfg(test)]
mod tests {
    use super::block;

    /// Known answers of Random123 (`kat_vectors`).
    #[test]
    fn known_answers() {
        let cases = [
            (
                [0; 4],
                [0; 2],
                [0x1655_4d9e_ca36_314c, 0xdb20_fe9d_672d_0fdc, 0xd7e7_72ce_e186_176b, 0x7e68_b68a_ec7b_a23b],
            ),
            (
                [u64::MAX; 4],
                [u64::MAX; 2],
                [0x87b0_92c3_013f_e90b, 0x438c_3c67_be8d_0224, 0x9cc7_d7c6_9cd7_77b6, 0xa09c_aebf_594f_0ba0],
            ),
            (
                [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344, 0xa409_3822_299f_31d0, 0x082e_fa98_ec4e_6c89],
                [0x4528_21e6_38d0_1377, 0xbe54_66cf_34e9_0c6c],
                [0xa528_f454_03e6_1d95, 0x38c7_2dbd_566e_9788, 0xa5a1_610e_72fd_18b5, 0x57bd_43b5_e52b_7fe6],
            ),
        ];
        for (counter, key, expected) in cases {
            assert_eq!(block(counter, key), expected, "{counter:x?}");
        }
    }
}
