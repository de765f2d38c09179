//! Maps of heights from files: NumPy arrays, TIFF pages of floating point or whole numbers, text matrices,
//! Gwyddion simple fields (<http://gwyddion.net/documentation/user-guide-en/gsf.html>).
//!
//! A file holds rows of heights; its first row is the one at y = 0 (pictures show it on top). As in every
//! measurement the numbers may count anything: [`Heights`] keeps them as they are.

use crate::universe::voxel::read::{Error, npy};
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};

/// Most nodes of a map.
pub const MOST_NODES: u64 = 1 << 28;

/// Most bytes of a text.
const MOST_TEXT: u64 = 1 << 30;

const KNOWN: &str = "NumPy array (.npy), TIFF (.tif), text matrix (.csv, .txt), Gwyddion simple field (.gsf)";

/// Heights as a file holds them.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// Columns and rows.
    pub nodes: [usize; 2],
    /// Row by row.
    pub values: Vec<f64>,
    /// Edges of a pixel along x and y, µm, and what a value counts, µm, where the file says so.
    pub scale: Option<([f64; 2], f64)>,
}

/// Reads a map by the file's ending. Nothing is allocated before its size is known to fit the file.
///
/// # Errors
/// An unknown ending, a damaged file, more than [`MOST_NODES`] nodes.
pub fn read(file: &Path) -> Result<Heights, Error> {
    let ending = file.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match ending.as_str() {
        "npy" => array(file),
        "tif" | "tiff" => page(file),
        "csv" | "txt" | "tsv" | "dat" => matrix(file),
        "gsf" => field(file),
        _ => Err(Error::new(file, format!("`.{ending}` is no map of heights that is known here"), KNOWN)),
    }
}

/// The number of nodes, if a map may have so many.
fn count(file: &Path, columns: u64, rows: u64) -> Result<usize, Error> {
    let nodes = columns.checked_mul(rows).filter(|&n| (1..=MOST_NODES).contains(&n));
    nodes.map(|n| n as usize).ok_or_else(|| {
        Error::new(
            file,
            format!("{columns} x {rows} heights"),
            format!("a map has from 1 to {MOST_NODES}: cut out a part of it"),
        )
    })
}

/// The bytes of `nodes` values of `width` bytes from `offset` on.
fn bytes(file: &Path, offset: u64, nodes: usize, width: usize) -> Result<Vec<u8>, Error> {
    let mut opened = std::fs::File::open(file).map_err(|e| Error::io(file, &e))?;
    let length = opened.metadata().map_err(|e| Error::io(file, &e))?.len();
    let needed = nodes as u64 * width as u64;
    if length.saturating_sub(offset) < needed {
        let what = format!("the header promises {nodes} heights, {needed} bytes; {length} are there");
        return Err(Error::new(file, what, "the file is cut off: copy or write it again"));
    }
    opened.seek(SeekFrom::Start(offset)).map_err(|e| Error::io(file, &e))?;
    let mut out = vec![0; nodes * width];
    opened.read_exact(&mut out).map_err(|e| Error::io(file, &e))?;
    Ok(out)
}

fn array(file: &Path) -> Result<Heights, Error> {
    let h = npy::header(file, "write it with numpy.save(\"heights.npy\", heights)")?;
    let [rows, columns] = h.shape[..] else {
        let what = format!("an array of {} dimensions", h.shape.len());
        return Err(Error::new(file, what, "a map of heights has the shape (rows, columns)"));
    };
    let nodes = count(file, columns, rows)?;
    let width = match h.descr.trim_start_matches(['<', '>', '|', '=']) {
        "f4" | "i4" | "u4" => 4,
        "f8" => 8,
        "i2" | "u2" => 2,
        "i1" | "u1" => 1,
        _ => {
            let what = format!("an array of type `{}`", h.descr);
            return Err(Error::new(
                file,
                what,
                "heights are floating point or whole numbers: .astype(float)",
            ));
        }
    };
    let raw = bytes(file, h.offset, nodes, width)?;
    let kind = h.descr.trim_start_matches(['<', '>', '|', '=']).chars().next().unwrap_or('f');
    let big = h.descr.starts_with('>');
    let values: Vec<f64> = raw.chunks_exact(width).map(|b| number(b, kind, big)).collect();
    let nodes = [columns as usize, rows as usize];
    let values = if h.fortran { turned(&values, nodes) } else { values };
    Ok(Heights { nodes, values, scale: None })
}

/// Of an array whose columns follow each other.
fn turned(values: &[f64], [columns, rows]: [usize; 2]) -> Vec<f64> {
    (0..rows * columns).map(|k| values[k % columns * rows + k / columns]).collect()
}

fn number(bytes: &[u8], kind: char, big: bool) -> f64 {
    let mut b = [0_u8; 8];
    let n = bytes.len();
    for (i, &byte) in bytes.iter().enumerate() {
        b[if big { n - 1 - i } else { i }] = byte;
    }
    let low = u64::from_le_bytes(b);
    match (kind, n) {
        ('f', 4) => f64::from(f32::from_bits(low as u32)),
        ('f', _) => f64::from_bits(low),
        ('i', 1) => f64::from(low as u8 as i8),
        ('i', 2) => f64::from(low as u16 as i16),
        ('i', _) => f64::from(low as u32 as i32),
        _ => low as f64,
    }
}

fn page(file: &Path) -> Result<Heights, Error> {
    let fault =
        |e: tiff::TiffError| Error::new(file, e, "a grey page of floating point or whole numbers is read");
    let opened = std::fs::File::open(file).map_err(|e| Error::io(file, &e))?;
    let length = opened.metadata().map_err(|e| Error::io(file, &e))?.len();
    let mut pages = Decoder::new(BufReader::new(opened)).map_err(fault)?;
    let (columns, rows) = pages.dimensions().map_err(fault)?;
    let colour = pages.colortype().map_err(fault)?;
    if !matches!(colour, ColorType::Gray(_)) {
        let help = "a picture of heights in colours has lost them: export the heights";
        return Err(Error::new(file, format!("the page is {colour:?}"), help));
    }
    let nodes = count(file, u64::from(columns), u64::from(rows))?;
    // Deflate and LZW shorten to no less than a thousandth.
    if length.saturating_mul(1500) < nodes as u64 {
        let what = format!("the header promises {columns} x {rows} heights; {length} bytes are there");
        return Err(Error::new(file, what, "the file is cut off: copy or write it again"));
    }
    let mut limits = Limits::default();
    limits.decoding_buffer_size = nodes * 8;
    let mut pages = pages.with_limits(limits);
    let values: Vec<f64> = match pages.read_image().map_err(fault)? {
        DecodingResult::F32(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::F64(v) => v,
        DecodingResult::U8(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U32(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I8(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I32(v) => v.into_iter().map(f64::from).collect(),
        _ => {
            return Err(Error::new(
                file,
                format!("the page is {colour:?}"),
                "32 bit floating point is usual",
            ));
        }
    };
    if pages.more_images() {
        return Err(Error::new(file, "more than one page", "a map of heights is one page"));
    }
    Ok(Heights { nodes: [columns as usize, rows as usize], values, scale: None })
}

fn matrix(file: &Path) -> Result<Heights, Error> {
    let opened = std::fs::File::open(file).map_err(|e| Error::io(file, &e))?;
    if opened.metadata().map_err(|e| Error::io(file, &e))?.len() > MOST_TEXT {
        return Err(Error::new(file, "a text above 1 GiB", "numpy.save writes it in a quarter of the room"));
    }
    let mut text = String::new();
    BufReader::new(opened).read_to_string(&mut text).map_err(|e| Error::io(file, &e))?;
    let (mut values, mut columns, mut rows) = (Vec::new(), 0, 0);
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() {
            continue;
        }
        let before = values.len();
        for word in line.split([',', ';', '\t', ' ']).map(str::trim).filter(|w| !w.is_empty()) {
            values.push(word.parse().map_err(|_| {
                let what =
                    format!("line {}: `{}` is no number", i + 1, word.chars().take(40).collect::<String>());
                Error::new(file, what, "a matrix of heights: a row a line, comments behind #")
            })?);
        }
        let found = values.len() - before;
        if rows > 0 && found != columns {
            let what = format!("line {}: {found} heights, the first row has {columns}", i + 1);
            return Err(Error::new(file, what, "every row has as many heights"));
        }
        (columns, rows) = (found, rows + 1);
    }
    count(file, columns as u64, rows)?;
    Ok(Heights { nodes: [columns, rows as usize], values, scale: None })
}

/// A Gwyddion simple field: a text header, zero bytes up to a multiple of four, 32 bit numbers.
fn field(file: &Path) -> Result<Heights, Error> {
    const MAGIC: &str = "Gwyddion Simple Field 1.0\n";
    let help = "export it again as a Gwyddion Simple Field";
    let mut head = Vec::new();
    let opened = std::fs::File::open(file).map_err(|e| Error::io(file, &e))?;
    opened.take(1 << 20).read_to_end(&mut head).map_err(|e| Error::io(file, &e))?;
    if !head.starts_with(MAGIC.as_bytes()) {
        return Err(Error::new(file, "this is no Gwyddion simple field", help));
    }
    let end = head.iter().position(|&b| b == 0);
    let end = end.ok_or_else(|| Error::new(file, "its header has no end", help))?;
    let text = String::from_utf8_lossy(&head[MAGIC.len()..end]);
    let value = |key: &str| {
        text.lines().filter_map(|l| l.split_once('=')).find(|(k, _)| k.trim() == key).map(|(_, v)| v.trim())
    };
    let whole = |key: &str| value(key).and_then(|v| v.parse::<u64>().ok());
    let (Some(columns), Some(rows)) = (whole("XRes"), whole("YRes")) else {
        return Err(Error::new(file, "XRes or YRes is missing", help));
    };
    let nodes = count(file, columns, rows)?;
    let raw = bytes(file, (end - end % 4 + 4) as u64, nodes, 4)?;
    let metres = |key: &str| value(key).is_none_or(|u| u == "m");
    let real = |key: &str| value(key).and_then(|v| v.parse::<f64>().ok());
    let scale = match (real("XReal"), real("YReal")) {
        (Some(x), Some(y)) if metres("XYUnits") && metres("ZUnits") => {
            Some(([x * 1e6 / columns as f64, y * 1e6 / rows as f64], 1e6))
        }
        _ => None,
    };
    let values = raw.chunks_exact(4).map(|b| number(b, 'f', false)).collect();
    Ok(Heights { nodes: [columns as usize, rows as usize], values, scale })
}
