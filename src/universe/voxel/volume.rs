//! A volume of voxels: one phase number each, packed into 1, 2, 4 or 8 bits.

/// Phase numbers of nx × ny × nz voxels: x runs fastest, z = 0 is the lowest slice.
#[derive(Clone, PartialEq, Eq)]
pub struct Volume {
    cells: [usize; 3],
    /// log₂ of the bits of a voxel.
    log_bits: u32,
    bytes: Vec<u8>,
}

/// A volume that cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VolumeError {
    /// A dimension is 0, or all together are more than a machine counts.
    #[error("a volume of {} x {} x {} voxels", .0[0], .0[1], .0[2])]
    Size([u64; 3]),
    /// No memory.
    #[error("no memory for {0} bytes of voxels")]
    Memory(u64),
}

impl Volume {
    /// A volume of phase 0, able to hold the numbers 0 … `phases` − 1 (at most 256).
    ///
    /// # Errors
    /// A dimension of 0, or no memory.
    pub fn new(cells: [u64; 3], phases: usize) -> Result<Self, VolumeError> {
        let log_bits = match phases {
            0..=2 => 0,
            3..=4 => 1,
            5..=16 => 2,
            _ => 3,
        };
        let size = || VolumeError::Size(cells);
        let total = count(cells).ok_or_else(size)?;
        let bytes = usize::try_from(total.div_ceil(8 >> log_bits)).map_err(|_| size())?;
        let mut data: Vec<u8> = Vec::new();
        data.try_reserve_exact(bytes).map_err(|_| VolumeError::Memory(bytes as u64))?;
        data.resize(bytes, 0);
        Ok(Volume { cells: cells.map(|n| n as usize), log_bits, bytes: data })
    }

    /// A volume from phase numbers, x fastest, lowest slice first.
    ///
    /// # Errors
    /// As [`Self::new`], or another number of voxels than the dimensions say.
    pub fn of(cells: [usize; 3], phases: &[u8]) -> Result<Self, VolumeError> {
        let wide = cells.map(|n| n as u64);
        if count(wide) != Some(phases.len() as u64) {
            return Err(VolumeError::Size(wide));
        }
        let most = phases.iter().max().map_or(0, |&p| usize::from(p));
        let mut v = Volume::new(wide, most + 1)?;
        for (i, &p) in phases.iter().enumerate() {
            v.set(i, p);
        }
        Ok(v)
    }

    /// Voxels along x, y, z.
    pub fn cells(&self) -> [usize; 3] {
        self.cells
    }

    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.cells.iter().product()
    }

    /// Never: every dimension is at least 1.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        self.bytes.len()
    }

    /// Bits of a voxel: 1, 2, 4 or 8.
    pub fn bits(&self) -> u32 {
        1 << self.log_bits
    }

    /// Phase of voxel number `i` = x + nx (y + ny z).
    #[inline]
    pub fn get(&self, i: usize) -> u8 {
        let low = 3 - self.log_bits;
        let shift = (i & ((1 << low) - 1)) << self.log_bits;
        let mask = (0xff_u16 >> (8 - (1 << self.log_bits))) as u8;
        (self.bytes[i >> low] >> shift) & mask
    }

    /// Sets voxel number `i`.
    #[inline]
    pub fn set(&mut self, i: usize, phase: u8) {
        let low = 3 - self.log_bits;
        let shift = (i & ((1 << low) - 1)) << self.log_bits;
        let mask = (0xff_u16 >> (8 - (1 << self.log_bits))) as u8;
        let byte = &mut self.bytes[i >> low];
        *byte = (*byte & !(mask << shift)) | ((phase & mask) << shift);
    }

    /// Phase of the voxel (x, y, z).
    pub fn at(&self, cell: [usize; 3]) -> u8 {
        self.get(cell[0] + self.cells[0] * (cell[1] + self.cells[1] * cell[2]))
    }

    /// The same space in `factor` times larger voxels (rounded, so that they fill it), each of the phase that most
    /// of its voxels have, and how many times larger along x, y, z. Of equals the voxel at or just beyond the
    /// middle decides.
    ///
    /// # Errors
    /// No memory.
    pub fn coarser(&self, factor: usize) -> Result<(Volume, [f64; 3]), VolumeError> {
        let [nx, ny, nz] = self.cells;
        let large = self.cells.map(|n| ((n + factor / 2) / factor.max(1)).max(1));
        let phases = (0..self.len()).map(|i| self.get(i)).max().map_or(1, |p| usize::from(p) + 1);
        let mut out = Volume::new(large.map(|n| n as u64), phases)?;
        // Small voxels of the large one `k` of `m` in a row of `n`: those whose middles lie in it.
        let row = |k: usize, m: usize, n: usize| (2 * k * n + m) / (2 * m)..(2 * (k + 1) * n + m) / (2 * m);
        let mut i = 0;
        for z in (0..large[2]).map(|k| row(k, large[2], nz)) {
            for y in (0..large[1]).map(|k| row(k, large[1], ny)) {
                for x in (0..large[0]).map(|k| row(k, large[0], nx)) {
                    let mut votes = [0_u32; 256];
                    for (z, y) in z.clone().flat_map(|z| y.clone().map(move |y| (z, y))) {
                        x.clone().for_each(|x| votes[usize::from(self.at([x, y, z]))] += 1);
                    }
                    let middle = [&x, &y, &z].map(|r| (r.start + r.end) / 2);
                    let most = votes.iter().max().copied().unwrap_or(0);
                    let own = self.at(middle);
                    let first = votes.iter().position(|v| *v == most).unwrap_or(0) as u8;
                    out.set(i, if votes[usize::from(own)] == most { own } else { first });
                    i += 1;
                }
            }
        }
        Ok((out, std::array::from_fn(|k| self.cells[k] as f64 / large[k] as f64)))
    }

    /// Number of voxels of each of the first `phases` phases.
    pub fn counts(&self, phases: usize) -> Vec<u64> {
        let mut all = [0_u64; 256];
        (0..self.len()).for_each(|i| all[usize::from(self.get(i))] += 1);
        all[..phases.min(256)].to_vec()
    }
}

impl std::fmt::Debug for Volume {
    /// The size alone: the voxels may be billions.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.cells;
        write!(f, "Volume({x} x {y} x {z}, {} bit)", self.bits())
    }
}

/// Number of voxels; `None` if a dimension is 0 or the product is beyond 2⁴⁰.
pub fn count(cells: [u64; 3]) -> Option<u64> {
    let total = cells[0].checked_mul(cells[1])?.checked_mul(cells[2])?;
    (total > 0 && total <= 1 << 40).then_some(total)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plate of eight slices stays a plate; the extent stays the same where the factor does not divide it.
    #[test]
    fn larger_voxels_hold_what_most_of_theirs_do() {
        let cells = [12, 10, 24];
        let plate = |i: usize| u8::from((8..16).contains(&(i / 120)));
        let v = Volume::of(cells, &(0..2880).map(plate).collect::<Vec<_>>()).unwrap();
        assert_eq!(v.coarser(1).unwrap(), (v.clone(), [1.0; 3]));
        for factor in [2, 4] {
            let (large, times) = v.coarser(factor).unwrap();
            let counts = large.counts(2);
            assert_eq!(counts[1] * 3, counts[0] + counts[1], "a third is plate");
            let lengths: Vec<f64> = (0..3).map(|k| times[k] * large.cells()[k] as f64).collect();
            assert_eq!(lengths, [12.0, 10.0, 24.0]);
        }
        assert_eq!(v.coarser(4).unwrap().0.cells(), [3, 3, 6]);
        assert_eq!(v.coarser(100).unwrap().0.cells(), [1, 1, 1]);
        // Two against six, and four against four: the voxel beyond the middle decides.
        let few = Volume::of([2, 2, 2], &[2, 2, 0, 0, 0, 0, 0, 0]).unwrap();
        assert_eq!(few.coarser(2).unwrap().0.get(0), 0);
        let half = Volume::of([2, 2, 2], &[1, 1, 1, 1, 2, 2, 2, 2]).unwrap();
        assert_eq!(half.coarser(2).unwrap().0.get(0), 2);
    }
}
