//! Volumes from files: TIFF stacks, NRRD, MHD/RAW, NPY. The header is read and judged first; nothing is
//! allocated before its size is known to fit the file and the budget; voxels are then read in pieces,
//! each label turned into its phase and packed.

mod header;
mod mhd;
pub(in crate::universe) mod npy;
mod nrrd;
mod raw;
mod tiff;

use super::volume::{Volume, count};
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// What is wrong with a file of voxels, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {what}", .file.display())]
pub struct Error {
    /// The file.
    pub file: PathBuf,
    /// What is wrong.
    pub what: String,
    /// A way out.
    pub help: String,
}

impl Error {
    pub(in crate::universe) fn new(file: &Path, what: impl Display, help: impl Display) -> Self {
        Error { file: file.to_owned(), what: what.to_string(), help: help.to_string() }
    }

    pub(in crate::universe) fn io(file: &Path, e: &std::io::Error) -> Self {
        match e.kind() {
            std::io::ErrorKind::NotFound => Error::new(file, "no such file", "check the name"),
            std::io::ErrorKind::UnexpectedEof => Error::new(
                file,
                "the file ends before its last voxel",
                "it is cut off: copy or write it again",
            ),
            _ => Error::new(file, e, "the file cannot be read"),
        }
    }
}

/// Type of a voxel in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// Unsigned, 1 byte.
    U8,
    /// Signed, 1 byte.
    I8,
    /// Unsigned, 2 bytes.
    U16,
    /// Signed, 2 bytes.
    I16,
    /// Unsigned, 4 bytes.
    U32,
    /// Signed, 4 bytes.
    I32,
}

impl Sample {
    /// Bytes of a voxel.
    pub fn bytes(self) -> u64 {
        match self {
            Sample::U8 | Sample::I8 => 1,
            Sample::U16 | Sample::I16 => 2,
            Sample::U32 | Sample::I32 => 4,
        }
    }
}

/// How voxels lie in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Layout {
    /// Pages of a TIFF file.
    Tiff,
    /// One after the other from a byte on.
    Raw {
        offset: u64,
        gzip: bool,
        big_endian: bool,
        /// z runs fastest instead of x.
        z_fastest: bool,
    },
}

/// A file of voxels whose header has been read and judged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file asked for.
    pub file: PathBuf,
    /// The file that holds the voxels: the same, or one that its header names.
    pub data: PathBuf,
    /// Voxels along x, y, z.
    pub cells: [u64; 3],
    /// Type of a voxel.
    pub sample: Sample,
    layout: Layout,
}

/// Which label is which phase.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Labels {
    /// (first, last, phase), ascending, disjoint.
    ranges: Vec<(i64, i64, u8)>,
}

impl Labels {
    /// From ranges of labels, both ends included.
    ///
    /// # Errors
    /// A label that stands twice, or a range without labels.
    pub fn new(mut ranges: Vec<(i64, i64, u8)>) -> Result<Self, i64> {
        ranges.sort_unstable();
        if let Some(r) = ranges.iter().find(|r| r.0 > r.1) {
            return Err(r.0);
        }
        match ranges.windows(2).find(|w| w[1].0 <= w[0].1) {
            Some(w) => Err(w[1].0),
            None => Ok(Labels { ranges }),
        }
    }

    /// Phase of a label.
    pub fn phase(&self, label: i64) -> Option<u8> {
        let i = self.ranges.partition_point(|r| r.1 < label);
        self.ranges.get(i).filter(|r| r.0 <= label).map(|r| r.2)
    }

    /// Phases that there may be.
    fn phases(&self) -> usize {
        self.ranges.iter().map(|r| usize::from(r.2) + 1).max().unwrap_or(0)
    }
}

/// Opens a file by its ending (.tif, .tiff, .nrrd, .nhdr, .mhd, .mha, .npy) and reads its header.
///
/// # Errors
/// An unknown ending, a header that cannot be read or that promises more than the file holds.
pub fn open(file: &Path) -> Result<Source, Error> {
    let ending = file.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let source = match ending.as_str() {
        "tif" | "tiff" => tiff::open(file),
        "nrrd" | "nhdr" => nrrd::open(file),
        "mhd" | "mha" => mhd::open(file),
        "npy" => npy::open(file),
        _ => Err(Error::new(
            file,
            format!("`.{ending}` is no volume that is known here"),
            "TIFF stack (.tif), NRRD (.nrrd, .nhdr), MetaImage (.mhd, .mha), NumPy array (.npy)",
        )),
    }?;
    let [x, y, z] = source.cells;
    let Some(voxels) = count(source.cells) else {
        let what = format!("the header says {x} x {y} x {z} voxels");
        return Err(Error::new(file, what, "a volume has from 1 to 2^40 voxels"));
    };
    source.fits(voxels)?;
    Ok(source)
}

impl Source {
    /// The file must be able to hold so many voxels: exactly where they lie plain, by the most that the
    /// compression can do elsewhere.
    fn fits(&self, voxels: u64) -> Result<(), Error> {
        let length = std::fs::metadata(&self.data).map_err(|e| Error::io(&self.data, &e))?.len();
        let needed = voxels.saturating_mul(self.sample.bytes());
        let (holds, plain) = match self.layout {
            Layout::Raw { offset, gzip: false, .. } => (length.saturating_sub(offset), true),
            // Deflate and LZW shorten to no less than a thousandth.
            _ => (length.saturating_mul(1500), false),
        };
        if needed <= holds {
            return Ok(());
        }
        let [x, y, z] = self.cells;
        let held =
            if plain { format!("{holds} bytes of voxels") } else { format!("{length} bytes, compressed") };
        Err(Error::new(
            &self.data,
            format!("the header promises {x} x {y} x {z} voxels, {needed} bytes; the file holds {held}"),
            "the file is cut off, or its header belongs to another volume",
        ))
    }

    /// Reads the voxels. `first_on_top`: the first slice of the file is the highest.
    ///
    /// # Errors
    /// More voxels than `most`, labels without a phase, a file that ends early or is damaged.
    pub fn load(&self, labels: &Labels, first_on_top: bool, most: u64) -> Result<Volume, Error> {
        let voxels = count(self.cells).unwrap_or(u64::MAX);
        if voxels > most {
            return Err(Error::new(
                &self.file,
                format!("{voxels} voxels, more than the {most} allowed"),
                "cut out a part, merge voxels, or raise `max-voxels` (a voxel takes 1 to 8 bits)",
            ));
        }
        let volume = Volume::new(self.cells, labels.phases())
            .map_err(|e| Error::new(&self.file, e, "cut out a part of the volume, or merge voxels"))?;
        let mut sink = Sink::new(volume, labels, first_on_top);
        match self.layout {
            Layout::Tiff => tiff::load(self, &mut sink)?,
            Layout::Raw { .. } => raw::load(self, &mut sink)?,
        }
        sink.finish(&self.file)
    }
}

/// Takes labels in the order of the file.
struct Sink<'a> {
    volume: Volume,
    labels: &'a Labels,
    /// Phases of the labels from [`LEAST`] on; 256: none.
    table: Vec<u16>,
    first_on_top: bool,
    z_fastest: bool,
    next: u64,
    /// Labels without phase: value, first place, number.
    unknown: Vec<(i64, u64, u64)>,
    more_unknown: bool,
}

/// Labels of at most two bytes are looked up.
const LEAST: i64 = -32_768;
const MOST: i64 = 65_535;

impl<'a> Sink<'a> {
    fn new(volume: Volume, labels: &'a Labels, first_on_top: bool) -> Self {
        let table = (LEAST..=MOST).map(|l| labels.phase(l).map_or(256, u16::from)).collect();
        Sink {
            volume,
            labels,
            table,
            first_on_top,
            z_fastest: false,
            next: 0,
            unknown: Vec::new(),
            more_unknown: false,
        }
    }

    #[inline]
    fn push(&mut self, label: i64) {
        let known = if (LEAST..=MOST).contains(&label) {
            u8::try_from(self.table[(label - LEAST) as usize]).ok()
        } else {
            self.labels.phase(label)
        };
        match known {
            Some(phase) if self.z_fastest || self.first_on_top => {
                let [x, y, z] = self.place(self.next);
                let [nx, ny, nz] = self.volume.cells();
                let z = if self.first_on_top { nz - 1 - z } else { z };
                self.volume.set(x + nx * (y + ny * z), phase);
            }
            Some(phase) => self.volume.set(self.next as usize, phase),
            None => self.not_known(label),
        }
        self.next += 1;
    }

    /// Voxel of a place in the file.
    #[inline]
    fn place(&self, i: u64) -> [usize; 3] {
        let [nx, ny, nz] = self.volume.cells().map(|n| n as u64);
        let place = if self.z_fastest {
            [i / nz / ny, i / nz % ny, i % nz]
        } else {
            [i % nx, i / nx % ny, i / nx / ny]
        };
        place.map(|p| p as usize)
    }

    #[cold]
    fn not_known(&mut self, label: i64) {
        if let Some(u) = self.unknown.iter_mut().find(|u| u.0 == label) {
            u.2 += 1;
        } else if self.unknown.len() < 8 {
            self.unknown.push((label, self.next, 1));
        } else {
            self.more_unknown = true;
        }
    }

    fn finish(self, file: &Path) -> Result<Volume, Error> {
        if self.unknown.is_empty() {
            return Ok(self.volume);
        }
        let mut found = self.unknown.clone();
        found.sort_unstable();
        let list: Vec<String> = found
            .iter()
            .map(|&(label, first, number)| {
                let [x, y, z] = self.place(first);
                format!("{label} ({number} voxels, the first at x {x}, y {y} of slice {z})")
            })
            .collect();
        let more = if self.more_unknown { " and more" } else { "" };
        Err(Error::new(
            file,
            format!("labels without a material: {}{more}", list.join(", ")),
            "add <label value=\"…\" material=\"…\"/> for each; `to` makes it a range",
        ))
    }
}
