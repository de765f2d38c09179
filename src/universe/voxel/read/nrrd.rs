//! NRRD (<http://teem.sourceforge.net/nrrd/format.html>): header in lines, data attached or in one
//! file beside it, encoding raw or gzip. The voxel size is the scene's; `spacings` is not used.

#![cfg_attr(not(test), warn(clippy::indexing_slicing))]

use super::header::{Lines, beside, three};
use super::{Error, Layout, Sample, Source};
use std::path::Path;

pub fn open(file: &Path) -> Result<Source, Error> {
    let mut lines = Lines::of(file)?;
    let first = lines.next()?.unwrap_or_default();
    if !first.starts_with("NRRD000") {
        return Err(Error::new(file, "this is no NRRD file", "a NRRD file begins with NRRD0004"));
    }
    let (mut cells, mut kind, mut encoding, mut endian, mut data) = (None, None, None, None, None);
    while let Some(line) = lines.next()? {
        if line.is_empty() {
            break;
        }
        // Remarks, and keys of the user (":=").
        let Some((name, value)) = line.split_once(": ").filter(|_| !line.starts_with('#')) else { continue };
        let value = value.trim().to_owned();
        match name.trim().to_ascii_lowercase().as_str() {
            "sizes" => cells = Some(three(file, "sizes", &value)?),
            "type" => kind = Some(value),
            "encoding" => encoding = Some(value),
            "endian" => endian = Some(value),
            "data file" | "datafile" => data = Some(value),
            "line skip" | "lineskip" | "byte skip" | "byteskip" if value != "0" => {
                let help = "write it again without skips, or as one file";
                return Err(Error::new(file, format!("`{name}: {value}` is not supported"), help));
            }
            _ => {}
        }
    }
    let missing =
        |what: &str| Error::new(file, format!("the header has no `{what}`"), "it is no complete NRRD");
    let sample = sample(file, &kind.ok_or_else(|| missing("type"))?)?;
    let encoding = encoding.ok_or_else(|| missing("encoding"))?;
    let gzip = match encoding.as_str() {
        "raw" => false,
        "gzip" | "gz" => true,
        other => {
            let help = "write it with encoding raw or gzip";
            return Err(Error::new(file, format!("the encoding `{other}` is not supported"), help));
        }
    };
    let big_endian = match endian.as_deref() {
        Some(e) => e == "big",
        None if sample.bytes() == 1 => false,
        None => return Err(missing("endian")),
    };
    if data.as_ref().is_some_and(|d| d.starts_with("LIST") || d.contains('%')) {
        return Err(Error::new(file, "data in several files", "write the volume as one file"));
    }
    let offset = if data.is_some() { 0 } else { lines.offset };
    Ok(Source {
        file: file.to_owned(),
        data: data.map_or_else(|| file.to_owned(), |d| beside(file, &d)),
        cells: cells.ok_or_else(|| missing("sizes"))?,
        sample,
        layout: Layout::Raw { offset, gzip, big_endian, z_fastest: false },
    })
}

fn sample(file: &Path, kind: &str) -> Result<Sample, Error> {
    Ok(match kind {
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Sample::U8,
        "signed char" | "int8" | "int8_t" => Sample::I8,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Sample::U16,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Sample::I16,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Sample::U32,
        "int" | "signed int" | "int32" | "int32_t" => Sample::I32,
        _ => {
            let help = "labels are whole numbers of 1, 2 or 4 bytes: uint8, uint16, int32 …";
            return Err(Error::new(file, format!("voxels of type `{kind}`"), help));
        }
    })
}
