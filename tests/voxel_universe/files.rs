//! Volumes from files: every reader gives back what was written, and says what is wrong with a bad file.

use super::*;
use flate2::write::GzEncoder;
use lightpro::universe::voxel::read::{Error, Labels, open};
use lightpro::universe::voxel::write::{Grid, mhd, nrrd};
use std::io::Write;
use std::path::{Path, PathBuf};
use tiff::encoder::{Compression, TiffEncoder, colortype};

const CELLS: [usize; 3] = [7, 5, 3];
const GRID: Grid = Grid { cells: CELLS, edge: [1.0, 1.0, 2.0] };

/// Labels 0, 3 and 200, no two slices alike.
fn labels() -> Vec<u8> {
    let mut s = stream(9);
    (0..CELLS.iter().product()).map(|_| [0, 3, 200][(3.0 * s.uniform()) as usize]).collect()
}

fn map() -> Labels {
    Labels::new(vec![(0, 0, 0), (1, 10, 1), (200, 70_000, 2)]).unwrap()
}

/// The volume that the labels stand for; the first slice lowest.
fn expected(first_on_top: bool) -> Volume {
    let plane = CELLS[0] * CELLS[1];
    let all = labels();
    let slices: Vec<&[u8]> =
        if first_on_top { all.chunks(plane).rev().collect() } else { all.chunks(plane).collect() };
    let phase = |l: &u8| match l {
        0 => 0,
        3 => 1,
        _ => 2,
    };
    Volume::of(CELLS, &slices.concat().iter().map(phase).collect::<Vec<_>>()).unwrap()
}

fn same(file: &Path) {
    for first_on_top in [false, true] {
        let source = open(file).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(source.cells, CELLS.map(|n| n as u64));
        let v = source.load(&map(), first_on_top, 1000).unwrap_or_else(|e| panic!("{e}"));
        assert!(v == expected(first_on_top), "{}", file.display());
    }
}

fn put(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let file = folder.join(name);
    std::fs::write(&file, bytes).unwrap();
    file
}

fn slices(z: usize, slice: &mut [u8]) {
    slice.copy_from_slice(&labels()[z * slice.len()..][..slice.len()]);
}

#[test]
fn what_is_written_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for gzip in [false, true] {
        nrrd(&at("v.nrrd"), GRID, gzip, slices).unwrap();
        same(&at("v.nrrd"));
    }
    mhd(&at("v.mhd"), GRID, slices).unwrap();
    same(&at("v.mhd"));
}

#[test]
fn nrrd_of_other_programs() {
    let folder = tempfile::tempdir().unwrap();
    let big: Vec<u8> = labels().iter().flat_map(|&l| [0, l]).collect();
    let head = "NRRD0005\r\n# remark\r\ntype: unsigned short\r\ndimension: 3\r\nsizes: 7 5 3\r\nkey:=value: x\r\n\
                endian: big\r\nencoding: raw\r\n";
    put(folder.path(), "v.raw", &big);
    same(&put(folder.path(), "v.nhdr", format!("{head}data file: v.raw\r\n").as_bytes()));
    same(&put(folder.path(), "v.nrrd", &[head.as_bytes(), b"\r\n", &big].concat()));
}

#[test]
fn metaimage_in_one_file_and_with_a_skip() {
    let folder = tempfile::tempdir().unwrap();
    let wide: Vec<u8> = labels().iter().flat_map(|&l| i32::from(l).to_le_bytes()).collect();
    let head = "ObjectType = Image\nNDims = 3\nDimSize = 7 5 3\nElementType = MET_INT\n";
    let one = format!("{head}ElementDataFile = LOCAL\n");
    same(&put(folder.path(), "v.mha", &[one.as_bytes(), &wide].concat()));
    put(folder.path(), "v.bin", &[b"0123456789", &wide[..]].concat());
    let two = format!("{head}HeaderSize = 10\nElementDataFile = v.bin\n");
    same(&put(folder.path(), "v.mhd", two.as_bytes()));
}

fn npy(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut head = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}");
    while (head.len() + 11) % 64 != 0 {
        head.push(' ');
    }
    head.push('\n');
    let length = (head.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], head.as_bytes(), data].concat()
}

#[test]
fn numpy_arrays_in_both_orders() {
    let folder = tempfile::tempdir().unwrap();
    let all = labels();
    same(&put(folder.path(), "c.npy", &npy("|u1", "False", "(3, 5, 7)", &all)));
    // Fortran order: the first index, the slice, runs fastest.
    let mut turned = Vec::new();
    for x in 0..7 {
        for y in 0..5 {
            turned.extend((0..3).map(|z| all[x + 7 * (y + 5 * z)]));
        }
    }
    same(&put(folder.path(), "f.npy", &npy("|u1", "True", "(3, 5, 7)", &turned)));
    let big: Vec<u8> = all.iter().flat_map(|&l| u32::from(l).to_be_bytes()).collect();
    same(&put(folder.path(), "b.npy", &npy(">u4", "False", "(3, 5, 7)", &big)));
}

fn stack<C: colortype::ColorType>(file: &Path, how: Compression, data: &[C::Inner]) -> PathBuf
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let out = std::fs::File::create(file).unwrap();
    let mut encoder = TiffEncoder::new(out).unwrap().with_compression(how);
    for slice in data.chunks(35) {
        encoder.write_image::<C>(7, 5, slice).unwrap();
    }
    file.to_owned()
}

#[test]
fn tiff_stacks_plain_and_compressed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("v.tif");
    let wide: Vec<u16> = labels().iter().map(|&l| u16::from(l)).collect();
    for how in [Compression::Uncompressed, Compression::Lzw, Compression::Deflate(Default::default())] {
        same(&stack::<colortype::Gray8>(&file, how, &labels()));
        same(&stack::<colortype::Gray16>(&file, how, &wide));
    }
}

/// What is said of a file: it must name the file, what is wrong, and a way out.
fn said(file: &Path, most: u64, words: &[&str]) {
    let e: Error = match open(file) {
        Err(e) => e,
        Ok(source) => source.load(&map(), false, most).expect_err("should be refused"),
    };
    let text = format!("{e}; {}", e.help);
    println!("{text}");
    assert!(!e.help.is_empty() && text.contains(&*file.file_stem().unwrap().to_string_lossy()), "{text}");
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

#[test]
fn bad_files_are_refused_with_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let all = labels();
    said(&put(at, "v.png", b"x"), 1000, &[".png", "TIFF", "NRRD"]);
    said(&at.join("none.nrrd"), 1000, &["no such file"]);

    let head = |sizes: &str, kind: &str, encoding: &str| {
        format!("NRRD0004\ntype: {kind}\ndimension: 3\nsizes: {sizes}\nencoding: {encoding}\n\n")
    };
    let with = |name: &str, head: String, data: &[u8]| put(at, name, &[head.as_bytes(), data].concat());
    said(&with("a.nrrd", head("7 5 3", "float", "raw"), &all), 1000, &["float", "uint8"]);
    said(&with("b.nrrd", head("7 5 3", "uint8", "bzip2"), &all), 1000, &["bzip2", "gzip"]);
    said(&with("c.nrrd", head("7 5", "uint8", "raw"), &all), 1000, &["sizes", "three"]);
    said(&with("d.nrrd", head("7 5 300", "uint8", "raw"), &all), 1000, &["10500 bytes", "105 bytes"]);
    said(&with("e.nrrd", head("99999999 99999999 99999999", "uint8", "raw"), &all), 1000, &["2^40"]);
    said(&with("f.nrrd", head("4000 4000 4000", "uint8", "gzip"), &all), 1 << 62, &["64000000000 bytes"]);
    said(&with("g.nrrd", head("7 5 3", "uint8", "gzip"), &all), 1000, &["damaged gzip"]);
    said(&with("h.nrrd", head("7 5 3", "uint8", "raw"), &all), 100, &["105 voxels", "max-voxels"]);
    said(&with("i.nrrd", "PNG\n".into(), &all), 1000, &["no NRRD"]);
    said(&with("j.nrrd", head("7 5 3", "uint16", "raw"), &all), 1000, &["endian"]);
    let unknown: Vec<u8> = all.iter().map(|&l| if l == 3 { 77 } else { l }).collect();
    let number = format!("77 ({} voxels", unknown.iter().filter(|&&l| l == 77).count());
    said(
        &with("k.nrrd", head("7 5 3", "uint8", "raw"), &unknown),
        1000,
        &[&number, "without a material", "slice"],
    );
    // Gzip data that end early.
    let mut packed = GzEncoder::new(Vec::new(), flate2::Compression::none());
    packed.write_all(&all[..50]).unwrap();
    let packed = packed.finish().unwrap();
    said(&with("l.nrrd", head("7 5 3", "uint8", "gzip"), &packed), 1000, &["ends before its last voxel"]);

    let meta = "DimSize = 7 5 3\nElementType = MET_UCHAR\n";
    said(
        &with("a.mhd", format!("{meta}ElementDataFile = gone.raw\n"), b""),
        1000,
        &["gone.raw", "no such file"],
    );
    said(&with("b.mhd", format!("CompressedData = True\n{meta}"), b""), 1000, &["compressed", "NRRD"]);
    said(&with("c.mhd", "DimSize = 7 5 3\nElementType = MET_FLOAT\n".into(), b""), 1000, &["MET_FLOAT"]);
    said(&with("d.mhd", meta.into(), b""), 1000, &["ElementDataFile"]);
    said(&with("e.mhd", "hello".into(), b""), 1000, &["no MetaImage"]);

    said(&put(at, "a.npy", &npy("<f4", "False", "(3, 5, 7)", &all)), 1000, &["<f4", "astype"]);
    said(&put(at, "b.npy", &npy("|u1", "False", "(3, 5)", &all)), 1000, &["2 dimensions", "(slices, y, x)"]);
    said(&put(at, "c.npy", &npy("|u1", "False", "(3, 5, 8)", &all)), 1000, &["120 bytes", "105"]);
    said(&put(at, "d.npy", b"nonsense"), 1000, &["no NumPy array"]);

    said(&put(at, "a.tif", b"II*\0nonsense"), 1000, &["stack of grey pages"]);
    let file = at.join("b.tif");
    let mut encoder = TiffEncoder::new(std::fs::File::create(&file).unwrap()).unwrap();
    encoder.write_image::<colortype::Gray8>(7, 5, &all[..35]).unwrap();
    encoder.write_image::<colortype::Gray8>(5, 5, &all[..25]).unwrap();
    drop(encoder);
    said(&file, 1000, &["page 1 is 5 x 5", "7 x 5"]);
    let file = at.join("c.tif");
    let mut encoder = TiffEncoder::new(std::fs::File::create(&file).unwrap()).unwrap();
    encoder.write_image::<colortype::RGB8>(7, 5, &[0; 105]).unwrap();
    drop(encoder);
    said(&file, 1000, &["RGB"]);
    let file = at.join("d.tif");
    let mut encoder = TiffEncoder::new(std::fs::File::create(&file).unwrap()).unwrap();
    encoder.write_image::<colortype::Gray32Float>(7, 5, &[0.0; 35]).unwrap();
    drop(encoder);
    said(&file, 1000, &["floating point"]);
    let whole = std::fs::read(stack::<colortype::Gray8>(&at.join("e.tif"), Compression::Lzw, &all)).unwrap();
    said(&put(at, "f.tif", &whole[..whole.len() / 2]), 1000, &[]);
}

/// No part of a good file, cut off anywhere or with any byte changed, makes a reader panic.
#[test]
fn damaged_files_are_refused_or_read_but_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    nrrd(&at.join("v.nrrd"), GRID, true, slices).unwrap();
    stack::<colortype::Gray8>(&at.join("v.tif"), Compression::Lzw, &labels());
    put(at, "v.npy", &npy("|u1", "False", "(3, 5, 7)", &labels()));
    mhd(&at.join("v.mhd"), GRID, slices).unwrap();
    let mut s = stream(1);
    for name in ["v.nrrd", "v.tif", "v.npy", "v.mhd"] {
        let whole = std::fs::read(at.join(name)).unwrap();
        for i in 0..400 {
            let mut bytes = whole.clone();
            if i % 4 == 0 {
                bytes.truncate((s.uniform() * whole.len() as f64) as usize);
            }
            for _ in 0..1 + i % 3 {
                if !bytes.is_empty() {
                    let k = (s.uniform() * bytes.len() as f64) as usize;
                    bytes[k] = (256.0 * s.uniform()) as u8;
                }
            }
            let file = put(at, &format!("x{name}"), &bytes);
            let _ = open(&file).and_then(|source| source.load(&map(), false, 100_000));
        }
    }
}

/// In a scene: the file by its place, labels and voxel size required, the way out told.
#[test]
fn scenes_with_bad_volumes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    nrrd(&folder.path().join("v.nrrd"), GRID, false, slices).unwrap();
    let scene = |volume: &str| {
        let text = format!(
            "<scene name=\"x\" version=\"1\"><materials><material id=\"air\" index=\"1\"/><material id=\"wall\" \
             index=\"1.5\"/></materials><universe kind=\"voxel\" outside=\"air\">{volume}</universe></scene>"
        );
        let path = folder.path().join("x.xml");
        match lightpro::scene::read_text(&text, &path, &Default::default()) {
            Ok(_) => String::new(),
            Err(d) => d.render(false),
        }
    };
    let labels = "<label value=\"0\" material=\"air\"/><label value=\"1\" to=\"255\" material=\"wall\"/>";
    let volume = |attributes: &str, labels: &str| scene(&format!("<volume {attributes}>{labels}</volume>"));
    assert_eq!(volume("file=\"v.nrrd\" voxel=\"1 um\"", labels), "");
    assert_eq!(volume("file=\"v.nrrd\" voxel=\"1 1 2 um\" lateral=\"periodic\"", labels), "");
    for (text, words) in [
        (scene(""), "needs a <volume>"),
        (volume("file=\"v.nrrd\"", labels), "needs the attribute `voxel`"),
        (volume("file=\"v.nrrd\" voxel=\"1 2 um\"", labels), "one or three edges"),
        (volume("file=\"v.nrrd\" voxel=\"1 um\"", ""), "needs a <label>"),
        (
            volume("file=\"v.nrrd\" voxel=\"1 um\"", &labels.replace("255", "100")),
            "labels without a material: 200",
        ),
        (volume("file=\"v.nrrd\" voxel=\"1 um\"", &format!("{labels}{labels}")), "stands twice"),
        (volume("file=\"w.nrrd\" voxel=\"1 um\"", labels), "no such file"),
        (volume("file=\"../v.nrrd\" voxel=\"1 um\"", labels), "outside the scene's folder"),
        (volume("file=\"v.nrrd\" voxel=\"1 um\" max-voxels=\"100\"", labels), "more than the 100 allowed"),
        (volume("file=\"v.nrrd\" voxel=\"1 um\" smoothing=\"9\"", labels), "out of range"),
    ] {
        assert!(text.contains(words), "`{words}` is not in:\n{text}");
    }
}
