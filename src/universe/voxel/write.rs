//! Volumes of labels to files, for other programs and for scenes: NRRD and MHD/RAW; VTI for ParaView.

use std::fs::File;
use std::io::{BufWriter, Result, Write};
use std::path::Path;

/// Size of a volume to be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Voxels along x, y, z.
    pub cells: [usize; 3],
    /// Edges of a voxel, µm.
    pub edge: [f64; 3],
}

impl Grid {
    /// All slices from z = 0 up, each filled by `slice` (x fastest).
    fn slices(&self, out: &mut impl Write, mut slice: impl FnMut(usize, &mut [u8])) -> Result<()> {
        let mut bytes = vec![0; self.cells[0] * self.cells[1]];
        for z in 0..self.cells[2] {
            slice(z, &mut bytes);
            out.write_all(&bytes)?;
        }
        Ok(())
    }
}

/// NRRD with the labels (1 byte each) in the same file, plain or gzipped. `slice` fills the labels of
/// slice z, counted from the bottom, x fastest.
///
/// # Errors
/// What writing gives.
pub fn nrrd(file: &Path, grid: Grid, gzip: bool, slice: impl FnMut(usize, &mut [u8])) -> Result<()> {
    let mut out = BufWriter::new(File::create(file)?);
    let ([x, y, z], [dx, dy, dz]) = (grid.cells, grid.edge);
    let encoding = if gzip { "gzip" } else { "raw" };
    write!(
        out,
        "NRRD0004\n# labels, written by lightpro; slices from the bottom of the sheet up\ntype: uint8\n\
         dimension: 3\nsizes: {x} {y} {z}\nspacings: {dx} {dy} {dz}\nunits: \"um\" \"um\" \"um\"\n\
         encoding: {encoding}\n\n"
    )?;
    if gzip {
        let mut packed = flate2::write::GzEncoder::new(out, flate2::Compression::best());
        grid.slices(&mut packed, slice)?;
        packed.finish()?.flush()
    } else {
        grid.slices(&mut out, slice)?;
        out.flush()
    }
}

/// MetaImage: `file` (.mhd) is the header, the labels go to the file of the same name ending in .raw.
///
/// # Errors
/// What writing gives.
pub fn mhd(file: &Path, grid: Grid, slice: impl FnMut(usize, &mut [u8])) -> Result<()> {
    let raw = file.with_extension("raw");
    let ([x, y, z], [dx, dy, dz]) = (grid.cells, grid.edge);
    let name = raw.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut header = BufWriter::new(File::create(file)?);
    write!(
        header,
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
         CompressedData = False\nDimSize = {x} {y} {z}\nElementSpacing = {dx} {dy} {dz}\n\
         ElementType = MET_UCHAR\nElementDataFile = {name}\n"
    )?;
    header.flush()?;
    let mut out = BufWriter::new(File::create(&raw)?);
    grid.slices(&mut out, slice)?;
    out.flush()
}

/// VTK ImageData (`.vti`) with the labels of the voxels as cell data, for ParaView: written slice by slice
/// beside another file.
#[derive(Debug)]
pub struct Vti {
    out: BufWriter<File>,
}

impl Vti {
    /// The head of the file; `bottom`: height of the lowest slice, µm.
    ///
    /// # Errors
    /// What writing gives.
    pub fn create(file: &Path, grid: Grid, bottom: f64) -> Result<Self> {
        let mut out = BufWriter::new(File::create(file)?);
        let ([x, y, z], [dx, dy, dz]) = (grid.cells, grid.edge);
        write!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<ImageData WholeExtent=\"0 {x} 0 {y} 0 {z}\" Origin=\"0 0 {bottom}\" \
             Spacing=\"{dx} {dy} {dz}\">\n<Piece Extent=\"0 {x} 0 {y} 0 {z}\"><CellData Scalars=\"label\">\
             <DataArray type=\"UInt8\" Name=\"label\" format=\"appended\" offset=\"0\"/></CellData></Piece>\n\
             </ImageData>\n<AppendedData encoding=\"raw\">_"
        )?;
        out.write_all(&((x * y * z) as u64).to_le_bytes())?;
        Ok(Vti { out })
    }

    /// The next slice, from the bottom up, x fastest.
    ///
    /// # Errors
    /// What writing gives.
    pub fn slice(&mut self, labels: &[u8]) -> Result<()> {
        self.out.write_all(labels)
    }

    /// The end of the file.
    ///
    /// # Errors
    /// What writing gives.
    pub fn finish(mut self) -> Result<()> {
        self.out.write_all(b"</AppendedData></VTKFile>\n")?;
        self.out.flush()
    }
}
