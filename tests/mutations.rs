//! Every shipped file, damaged at random (seeded): each reader gives an answer within 2 s, in less than
//! 1 GiB, and never panics. Formats of which no file is shipped (TIFF, NPY, MHD, checkpoint) are made here.
#![allow(clippy::disallowed_methods, missing_docs)]

use lightpro::material::RefractiveIndex;
use lightpro::rng::{Purpose, Stream};
use lightpro::run::checkpoint;
use lightpro::scene::plan::Plan;
use lightpro::scene::{Options, read_text};
use lightpro::universe::voxel::read::{self, Labels};
use lightpro::universe::voxel::write::{Grid, mhd};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// Damaged copies of each file.
const COPIES: u64 = 25;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn collect(folder: &Path, endings: &[&str], files: &mut Vec<PathBuf>) {
    let mut list: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    list.sort();
    for path in list {
        if path.is_dir() {
            collect(&path, endings, files);
        } else if path.extension().is_some_and(|e| endings.iter().any(|x| e == *x)) {
            files.push(path);
        }
    }
}

/// What numbers and names turn into.
const PIECES: [&str; 22] = [
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-1",
    "0",
    "-0",
    "1e-320",
    "1e300",
    "99999999999999999999",
    "4294967296",
    "<",
    ">",
    "\"",
    "&",
    "<!DOCTYPE x>",
    "${x}",
    "\0",
    "é🦀",
    "um",
    "\n\n",
    ",,,,",
];

/// A damaged copy.
fn damaged(good: &[u8], rng: &mut Stream) -> Vec<u8> {
    let mut below = |n: usize| ((rng.uniform() * n.max(1) as f64) as usize).min(n.saturating_sub(1));
    let mut bytes = good.to_vec();
    for _ in 0..1 + below(4) {
        let at = below(bytes.len() + 1);
        let to = (at + 1 + below(30)).min(bytes.len());
        match below(8) {
            0 if at < bytes.len() => bytes[at] ^= 1 << below(8),
            1 if at < bytes.len() => bytes[at] = below(256) as u8,
            2 => drop(bytes.drain(at..to)),
            3 => bytes.truncate(at),
            4 => {
                let piece = bytes[at..to].to_vec();
                let k = below(bytes.len() + 1);
                bytes.splice(k..k, piece);
            }
            // A whole number in the file becomes something else.
            5 | 6 => {
                let digit = |b: &u8| b.is_ascii_digit() || *b == b'.';
                if let Some(from) = bytes[at..].iter().position(digit).map(|i| at + i) {
                    let end = bytes[from..].iter().position(|b| !digit(b)).map_or(bytes.len(), |i| from + i);
                    bytes.splice(from..end, PIECES[below(PIECES.len())].bytes());
                }
            }
            _ => drop(bytes.splice(at..at, PIECES[below(PIECES.len())].bytes())),
        }
    }
    // Damage that undoes itself is none.
    if bytes == good { vec![0] } else { bytes }
}

/// Damages `good` again and again and has each copy read: how many were accepted.
fn hold(name: &str, seed: u64, good: &[u8], read: impl Fn(&[u8]) -> bool + Send + 'static) -> u64 {
    assert!(read(good), "{name} itself is read");
    let mut rng = Stream::of(20_261_122, seed, good.len() as u64, Purpose::Probe);
    let copies: Vec<Vec<u8>> = (0..COPIES).map(|_| damaged(good, &mut rng)).collect();
    let (tell, told) = mpsc::channel();
    let work = copies.clone();
    let thread = std::thread::spawn(move || {
        for (i, bytes) in work.iter().enumerate() {
            let timed = || {
                let start = Instant::now();
                (read(bytes), start.elapsed())
            };
            let (mut accepted, mut time) = timed();
            if time > Duration::from_secs(2) {
                // Once more: another process may have had the machine.
                (accepted, time) = timed();
            }
            let _ = tell.send((i, accepted, time));
        }
    });
    let mut accepted = 0;
    for i in 0..copies.len() {
        match told.recv_timeout(Duration::from_secs(60)) {
            Ok((_, ok, time)) => {
                let copy = String::from_utf8_lossy(&copies[i]);
                assert!(time < Duration::from_secs(2), "{name}, copy {i}: {time:?}\n{copy}");
                accepted += u64::from(ok);
            }
            Err(e) => panic!("{name}, copy {i}: {e}\n{}", String::from_utf8_lossy(&copies[i])),
        }
    }
    thread.join().unwrap();
    accepted
}

/// Whether a scene can be planned. A deposited sheet is laid down by its plan: work, not reading.
fn planned(scene: &lightpro::scene::Scene) -> bool {
    use lightpro::scene::Universe;
    matches!(&scene.universe, Universe::Realised(r) if r.deposit.is_some()) || Plan::new(scene).is_ok()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn few_megabytes() {
    let peak = lightpro::report::manifest::peak_memory_bytes().unwrap_or(0);
    assert!(peak < 1 << 30, "{peak} bytes of memory");
}

#[test]
fn scenes() {
    let mut files = Vec::new();
    collect(&root().join("scenes"), &["xml"], &mut files);
    // Parts that scenes include are no scenes.
    files.retain(|f| std::fs::read_to_string(f).unwrap().contains("<scene "));
    assert!(files.len() > 20);
    for file in files {
        let path = file.clone();
        let options = Options { allow_outside: true, ..Options::default() };
        hold(&file.display().to_string(), 0, &std::fs::read(&file).unwrap(), move |bytes| {
            match read_text(&text(bytes), &path, &options) {
                // A plan may refuse what no single attribute shows; it must answer.
                Ok(scene) => planned(&scene),
                Err(found) => {
                    assert!(found.error_count() > 0 && found.to_string().contains("error"));
                    false
                }
            }
        });
    }
    few_megabytes();
}

const AROUND: &str = r#"<scene name="x" version="1"><materials><material id="air" index="1"/>
  <material id="wall" index="1.5">FILLER</material></materials>
  <universe kind="statistical" memory="none" outside="air"><sheet thickness="100 um" pore="air"><layer>BODY</layer></sheet></universe>
</scene>"#;

#[test]
fn distributions() {
    let mut files = Vec::new();
    collect(&root().join("distributions"), &["xml"], &mut files);
    assert!(files.len() > 5);
    for file in files {
        // Files that it names are found where they stand.
        let beside = format!("{}/", root().join("distributions").display());
        let good = std::fs::read_to_string(&file).unwrap().replace("../", &beside).into_bytes();
        let folder = tempfile::tempdir().unwrap();
        let copy = folder.path().join("distribution.xml");
        let from = format!("from=\"{}\"", copy.display());
        let (filler, body) = match text(&good) {
            t if t.contains("kind=\"filler\"") => {
                (format!("<particles {from} volume-fraction=\"1 %\"/>"), "")
            }
            t if t.contains("kind=\"flakes\"") => {
                (String::new(), "<particles FROM material=\"wall\" volume-fraction=\"1 %\"/>")
            }
            _ => (String::new(), "<fibres FROM material=\"wall\" grammage=\"60 g/m2\"/>"),
        };
        let scene = AROUND.replace("FILLER", &filler).replace("BODY", &body.replace("FROM", &from));
        hold(&file.display().to_string(), 0, &good, move |bytes| {
            std::fs::write(&copy, bytes).unwrap();
            let options = Options { allow_outside: true, ..Options::default() };
            let found = read_text(&scene, &folder.path().join("scene.xml"), &options);
            found.is_ok_and(|scene| planned(&scene))
        });
    }
    few_megabytes();
}

#[test]
fn tables() {
    let mut files = Vec::new();
    collect(&root().join("distributions"), &["csv", "yml"], &mut files);
    assert!(files.len() > 30);
    for file in files {
        let yaml = file.extension().is_some_and(|e| e == "yml");
        hold(&file.display().to_string(), 0, &std::fs::read(&file).unwrap(), move |bytes| {
            let text = text(bytes);
            if yaml {
                let index = RefractiveIndex::from_rii(&text, "x");
                return index.map(|i| i.at(550.0).is_ok()).is_ok();
            }
            lightpro::spectrum::csv::rows::<1>(&text, "x").is_ok()
                | lightpro::spectrum::csv::rows::<2>(&text, "x").is_ok()
                | lightpro::spectrum::csv::rows::<3>(&text, "x").is_ok()
                | lightpro::spectrum::csv::rows::<4>(&text, "x").is_ok()
                | lightpro::spectrum::csv::read(&text, "x").is_ok()
        });
    }
    few_megabytes();
}

/// A reader of volumes for files of this name.
fn volume(folder: tempfile::TempDir, name: &'static str) -> impl Fn(&[u8]) -> bool + Send {
    move |bytes| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let labels = Labels::new(vec![(0, 255, 0)]).unwrap();
        read::open(&path).and_then(|s| s.load(&labels, false, 1_000_000)).is_ok()
    }
}

#[test]
fn volumes() {
    let put = |name: &'static str, bytes: &[u8]| {
        for seed in 0..8 {
            hold(name, seed, bytes, volume(tempfile::tempdir().unwrap(), name));
        }
    };
    put("plate.nrrd", &std::fs::read(root().join("scenes/data/plate.nrrd")).unwrap());
    put("fibres.nrrd", &std::fs::read(root().join("scenes/data/fibres.nrrd")).unwrap());
    let mut npy = b"\x93NUMPY\x01\0".to_vec();
    let header = format!("{:<117}\n", "{'descr': '|u1', 'fortran_order': False, 'shape': (3, 5, 7), }");
    npy.extend((header.len() as u16).to_le_bytes());
    npy.extend(header.bytes().chain((0..105).map(|i| i as u8 % 3)));
    put("v.npy", &npy);
    let mut tiff = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
    for page in 0..3_u8 {
        let image: Vec<u8> = (0..35).map(|i| (i + page) % 3).collect();
        encoder.write_image::<tiff::encoder::colortype::Gray8>(7, 5, &image).unwrap();
    }
    put("v.tif", &tiff.into_inner());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.mhd");
    mhd(&path, Grid { cells: [7, 5, 3], edge: [1.0; 3] }, |z, out| out.fill(z as u8)).unwrap();
    let header = std::fs::read(&path).unwrap();
    hold("v.mhd", 0, &header, volume(folder, "v.mhd"));
    few_megabytes();
}

#[test]
fn checkpoints() {
    use lightpro::run::{Identity, Sums};
    use lightpro::stats::Fold;
    use lightpro::tally::Node;
    let identity = Identity {
        lightpro: "0".into(),
        scene: "s.xml".into(),
        defines: vec![("a".into(), "b".into())],
        effects: Vec::new(),
        allow_outside: false,
        files: vec![("s.xml".into(), 7)],
        seed: 1,
        histories: 100_000,
        range: 0..100_000,
        targets: vec!["reflectance:1%".into()],
    };
    let mut fold = Fold::default();
    for i in 0..7 {
        let node = Node::batch(i, vec![[f64::from(i); 4]; 3], 4096);
        fold.push(Sums { node: Node { single: vec![[0.0; 2]], ..node }, troubled: Vec::new() });
    }
    let good = checkpoint::to_bytes(&identity, &[fold]);
    for seed in 0..20 {
        assert_eq!(
            hold("checkpoint", seed, &good, |b| checkpoint::from_bytes(b).is_ok()),
            0,
            "its checksum sees it"
        );
    }
    // Past the checksum.
    let payload = {
        use std::io::Read;
        let mut out = Vec::new();
        flate2::read::ZlibDecoder::new(&good[32..]).read_to_end(&mut out).unwrap();
        out
    };
    let mut rng = Stream::of(20_261_122, 0, 99, Purpose::Probe);
    assert!(checkpoint::decode(&payload).is_ok());
    for _ in 0..20_000 {
        let _ = checkpoint::decode(&damaged(&payload, &mut rng));
    }
    few_megabytes();
}
