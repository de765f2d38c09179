//! TIFF stacks: one page a slice, grey, 8 or 16 bit (or 32), plain, LZW or deflate.

use super::{Error, Layout, Sample, Sink, Source};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

type Pages = Decoder<BufReader<File>>;

fn fault(file: &Path, e: &tiff::TiffError) -> Error {
    Error::new(
        file,
        e,
        "a stack of grey pages, plain, LZW or deflate, written by the usual programs, is read",
    )
}

fn pages(file: &Path) -> Result<Pages, Error> {
    let opened = File::open(file).map_err(|e| Error::io(file, &e))?;
    Decoder::new(BufReader::new(opened)).map_err(|e| fault(file, &e))
}

pub fn open(file: &Path) -> Result<Source, Error> {
    let mut pages = pages(file)?;
    let (first, sample) = page(file, &mut pages, 0)?;
    check_hyperstack(file, &mut pages)?;
    let mut slices = 1_u64;
    while pages.more_images() {
        pages.next_image().map_err(|e| fault(file, &e))?;
        let (size, other) = page(file, &mut pages, slices)?;
        if size != first || other != sample {
            return Err(Error::new(
                file,
                format!(
                    "page {slices} is {} x {} ({other:?}), the first one {} x {} ({sample:?})",
                    size.0, size.1, first.0, first.1
                ),
                "all slices are of one size and type; a preview page must be taken out",
            ));
        }
        slices += 1;
    }
    Ok(Source {
        file: file.to_owned(),
        data: file.to_owned(),
        cells: [u64::from(first.0), u64::from(first.1), slices],
        sample,
        layout: Layout::Tiff,
    })
}

/// Size and type of the page at hand.
fn page(file: &Path, pages: &mut Pages, number: u64) -> Result<((u32, u32), Sample), Error> {
    let size = pages.dimensions().map_err(|e| fault(file, &e))?;
    let colour = pages.colortype().map_err(|e| fault(file, &e))?;
    let formats = pages.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(|e| fault(file, &e))?;
    let format = formats.and_then(|f| f.first().copied()).unwrap_or(1);
    let sample = match (colour, format) {
        (ColorType::Gray(8), 1) => Sample::U8,
        (ColorType::Gray(8), 2) => Sample::I8,
        (ColorType::Gray(16), 1) => Sample::U16,
        (ColorType::Gray(16), 2) => Sample::I16,
        (ColorType::Gray(32), 1) => Sample::U32,
        (ColorType::Gray(32), 2) => Sample::I32,
        _ => {
            let floats = if format == 3 { ", floating point" } else { "" };
            return Err(Error::new(
                file,
                format!("page {number} is {colour:?}{floats}"),
                "labels are grey pages of 8, 16 or 32 bit whole numbers: convert the type, not the look",
            ));
        }
    };
    Ok((size, sample))
}

/// Some programs write stacks above 4 GiB as one page and raw data behind it.
fn check_hyperstack(file: &Path, pages: &mut Pages) -> Result<(), Error> {
    let text = pages.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default();
    let images = text.lines().find_map(|l| l.strip_prefix("images=")?.trim().parse::<u64>().ok());
    if images.is_some_and(|n| n > 1) && !pages.more_images() {
        return Err(Error::new(
            file,
            format!("one page that speaks of {} images", images.unwrap_or(0)),
            "a stack above 4 GiB in the form of its program: export it as NRRD, or as MHD with raw data",
        ));
    }
    Ok(())
}

pub fn load(source: &Source, sink: &mut Sink<'_>) -> Result<(), Error> {
    let file = &source.data;
    let mut pages = pages(file)?;
    let per_page = source.cells[0] * source.cells[1];
    for slice in 0..source.cells[2] {
        if slice > 0 {
            pages.next_image().map_err(|e| fault(file, &e))?;
        }
        let before = sink.next;
        let damaged = |e| Error::new(file, format!("page {slice}: {e}"), "write the file again");
        match pages.read_image().map_err(damaged)? {
            DecodingResult::U8(v) => v.into_iter().for_each(|x| sink.push(i64::from(x))),
            DecodingResult::I8(v) => v.into_iter().for_each(|x| sink.push(i64::from(x))),
            DecodingResult::U16(v) => v.into_iter().for_each(|x| sink.push(i64::from(x))),
            DecodingResult::I16(v) => v.into_iter().for_each(|x| sink.push(i64::from(x))),
            DecodingResult::U32(v) => v.into_iter().for_each(|x| sink.push(i64::from(x))),
            DecodingResult::I32(v) => v.into_iter().for_each(|x| sink.push(i64::from(x))),
            _ => {}
        }
        if sink.next - before != per_page {
            let what = format!("page {slice} holds {} voxels instead of {per_page}", sink.next - before);
            return Err(Error::new(file, what, "write the file again"));
        }
    }
    Ok(())
}
