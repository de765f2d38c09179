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
