//! Voxels that lie one after the other, plain or gzipped.

use super::{Error, Layout, Sample, Sink, Source};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};

/// Bytes read at once.
const PIECE: usize = 1 << 20;

pub fn load(source: &Source, sink: &mut Sink<'_>) -> Result<(), Error> {
    let Layout::Raw { offset, gzip, big_endian, z_fastest } = source.layout else { return Ok(()) };
    let fault = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::InvalidInput | std::io::ErrorKind::InvalidData => {
            Error::new(&source.data, format!("damaged gzip data: {e}"), "write the file again")
        }
        _ => Error::io(&source.data, &e),
    };
    let mut file = File::open(&source.data).map_err(fault)?;
    file.seek(SeekFrom::Start(offset)).map_err(fault)?;
    let mut reader: Box<dyn Read> =
        if gzip { Box::new(flate2::read::MultiGzDecoder::new(BufReader::new(file))) } else { Box::new(file) };
    sink.z_fastest = z_fastest;
    let size = source.sample.bytes() as usize;
    let mut left = source.cells.iter().product::<u64>();
    let mut piece = vec![0; PIECE];
    while left > 0 {
        let bytes = PIECE.min(usize::try_from(left).unwrap_or(PIECE).saturating_mul(size));
        reader.read_exact(&mut piece[..bytes]).map_err(fault)?;
        labels(&piece[..bytes], source.sample, big_endian, |label| sink.push(label));
        left -= (bytes / size) as u64;
    }
    Ok(())
}

fn labels(bytes: &[u8], sample: Sample, big: bool, mut push: impl FnMut(i64)) {
    let two = |b: &[u8]| if big { [b[0], b[1]] } else { [b[1], b[0]] };
    let four = |b: &[u8]| if big { [b[0], b[1], b[2], b[3]] } else { [b[3], b[2], b[1], b[0]] };
    match sample {
        Sample::U8 => bytes.iter().for_each(|&b| push(i64::from(b))),
        Sample::I8 => bytes.iter().for_each(|&b| push(i64::from(i8::from_ne_bytes([b])))),
        Sample::U16 => {
            bytes.chunks_exact(2).for_each(|b| push(i64::from(u16::from_be_bytes(two(b)))));
        }
        Sample::I16 => {
            bytes.chunks_exact(2).for_each(|b| push(i64::from(i16::from_be_bytes(two(b)))));
        }
        Sample::U32 => {
            bytes.chunks_exact(4).for_each(|b| push(i64::from(u32::from_be_bytes(four(b)))));
        }
        Sample::I32 => {
            bytes.chunks_exact(4).for_each(|b| push(i64::from(i32::from_be_bytes(four(b)))));
        }
    }
}
