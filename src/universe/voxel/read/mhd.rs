//! MetaImage (.mhd with a raw file beside it, .mha with the data behind the header), uncompressed. The
//! voxel size is the scene's; `ElementSpacing` is not used.

#![cfg_attr(not(test), warn(clippy::indexing_slicing))]

use super::header::{Lines, beside, three};
use super::{Error, Layout, Sample, Source};
use std::path::Path;

pub fn open(file: &Path) -> Result<Source, Error> {
    let mut lines = Lines::of(file)?;
    let (mut cells, mut kind, mut data, mut big_endian, mut skip) = (None, None, None, false, 0);
    while let Some(line) = lines.next()? {
        let Some((name, value)) = line.split_once('=') else {
            return Err(Error::new(
                file,
                "this is no MetaImage header",
                "lines of a header read Name = value",
            ));
        };
        let value = value.trim().to_owned();
        match name.trim() {
            "DimSize" => cells = Some(three(file, "DimSize", &value)?),
            "ElementType" => kind = Some(sample(file, &value)?),
            "BinaryDataByteOrderMSB" | "ElementByteOrderMSB" => {
                big_endian = value.eq_ignore_ascii_case("true")
            }
            "CompressedData" if value.eq_ignore_ascii_case("true") => {
                let help = "write it uncompressed, or as gzipped NRRD";
                return Err(Error::new(file, "compressed data are not supported", help));
            }
            "ElementNumberOfChannels" if value != "1" => {
                let help = "a volume of labels has one channel";
                return Err(Error::new(file, format!("{value} channels"), help));
            }
            "HeaderSize" => {
                skip = value.parse().map_err(|_| {
                    Error::new(file, format!("`HeaderSize` is `{value}`"), "give the number of bytes to skip")
                })?;
            }
            // Always the last line.
            "ElementDataFile" => {
                data = Some(value);
                break;
            }
            _ => {}
        }
    }
    let missing =
        |what: &str| Error::new(file, format!("the header has no `{what}`"), "it is no complete MetaImage");
    let data = data.ok_or_else(|| missing("ElementDataFile"))?;
    if data.starts_with("LIST") || data.contains('%') {
        return Err(Error::new(file, "data in several files", "write the volume as one file"));
    }
    let local = data == "LOCAL";
    Ok(Source {
        file: file.to_owned(),
        data: if local { file.to_owned() } else { beside(file, &data) },
        cells: cells.ok_or_else(|| missing("DimSize"))?,
        sample: kind.ok_or_else(|| missing("ElementType"))?,
        layout: Layout::Raw {
            offset: if local { lines.offset } else { skip },
            gzip: false,
            big_endian,
            z_fastest: false,
        },
    })
}

fn sample(file: &Path, kind: &str) -> Result<Sample, Error> {
    Ok(match kind {
        "MET_UCHAR" => Sample::U8,
        "MET_CHAR" => Sample::I8,
        "MET_USHORT" => Sample::U16,
        "MET_SHORT" => Sample::I16,
        "MET_UINT" => Sample::U32,
        "MET_INT" => Sample::I32,
        _ => {
            let help = "labels are whole numbers: MET_UCHAR, MET_USHORT, MET_INT …";
            return Err(Error::new(file, format!("voxels of type `{kind}`"), help));
        }
    })
}
