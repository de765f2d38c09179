//! NumPy arrays (.npy, versions 1 to 3): shape (slices, y, x) of integers.

use super::{Error, Layout, Sample, Source};
use std::io::Read;
use std::path::Path;

const MAGIC: &[u8] = b"\x93NUMPY";

/// What the header of an array says.
pub struct Header {
    /// Type of an element, as NumPy writes it.
    pub descr: String,
    /// The first axis runs fastest, not the last.
    pub fortran: bool,
    /// Elements along each axis.
    pub shape: Vec<u64>,
    /// Byte where they begin.
    pub offset: u64,
}

/// Reads the header of an array; `write` tells how it is written well.
pub fn header(file: &Path, write: &str) -> Result<Header, Error> {
    let mut reader = std::fs::File::open(file).map_err(|e| Error::io(file, &e))?;
    let mut head = [0; 8];
    let cut = || Error::new(file, "this is no NumPy array", write);
    reader.read_exact(&mut head).map_err(|_| cut())?;
    if !head.starts_with(MAGIC) {
        return Err(cut());
    }
    let mut size = [0; 4];
    let width = if head[6] == 1 { 2 } else { 4 };
    reader.read_exact(&mut size[..width]).map_err(|_| cut())?;
    let length = u64::from(u32::from_le_bytes(size));
    if length > 1 << 20 {
        return Err(Error::new(file, "a header above 1 MiB", "write it again with numpy.save"));
    }
    let mut header = vec![0; length as usize];
    reader.read_exact(&mut header).map_err(|_| cut())?;
    let header = String::from_utf8_lossy(&header);
    let shape = value(&header, "shape")
        .unwrap_or("")
        .split(',')
        .filter_map(|n| n.trim().trim_end_matches('L').parse().ok())
        .collect();
    Ok(Header {
        descr: value(&header, "descr").unwrap_or("").to_owned(),
        fortran: value(&header, "fortran_order") == Some("True"),
        shape,
        offset: 8 + width as u64 + length,
    })
}

pub fn open(file: &Path) -> Result<Source, Error> {
    let Header { descr, fortran, shape, offset } =
        header(file, "write it with numpy.save(\"volume.npy\", labels)")?;
    let (sample, big_endian) = sample(file, &descr)?;
    let [z, y, x] = shape[..] else {
        return Err(Error::new(
            file,
            format!("an array of {} dimensions", shape.len()),
            "a volume has the shape (slices, y, x)",
        ));
    };
    Ok(Source {
        file: file.to_owned(),
        data: file.to_owned(),
        cells: [x, y, z],
        sample,
        layout: Layout::Raw { offset, gzip: false, big_endian, z_fastest: fortran },
    })
}

/// Value of a key of the header's dictionary, without quotes or parentheses.
fn value<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let rest = header.split_once(&format!("'{key}'"))?.1.trim_start().strip_prefix(':')?.trim_start();
    let (open, close) = match rest.chars().next()? {
        '(' => ('(', ')'),
        '\'' => ('\'', '\''),
        _ => return rest.split([',', '}']).next().map(str::trim),
    };
    rest.strip_prefix(open)?.split(close).next()
}

fn sample(file: &Path, descr: &str) -> Result<(Sample, bool), Error> {
    let kind = descr.trim_start_matches(['<', '>', '|', '=']);
    let sample = match kind {
        "u1" | "b1" => Sample::U8,
        "i1" => Sample::I8,
        "u2" => Sample::U16,
        "i2" => Sample::I16,
        "u4" => Sample::U32,
        "i4" => Sample::I32,
        _ => {
            return Err(Error::new(
                file,
                format!("an array of type `{descr}`"),
                "labels are whole numbers of 1, 2 or 4 bytes: labels.astype(numpy.uint8)",
            ));
        }
    };
    Ok((sample, descr.starts_with('>')))
}
