//! Measured surfaces that cut explicit bodies off: planes, facets of known slope, cut balls, the same sheet at
//! any displacement, files of every kind, and what is refused.
#![allow(missing_docs, clippy::disallowed_methods)]

mod figures;

use figures::figures;
use lightpro::math::DVec3;
use lightpro::rng::{Purpose, Stream};
use lightpro::scene::{Options, read_text};
use lightpro::universe::any::AnyUniverse;
use lightpro::universe::shape::height::HeightMap;
use lightpro::universe::topography::file;
use lightpro::universe::{Face, Next, Ray, Universe};
use std::io::Write;

fn scene(universe: &str, source: &str) -> String {
    format!(
        r#"<scene name="t" version="1">
  <materials><material id="air" index="1"/><material id="glass" index="1.5"/><material id="gel" index="1.3" absorption="0.002 1/um"/>
    <material id="black" index="1.5" absorption="1e4 1/um"/>
    <material id="milk" index="1.5"><scattering mu-s="0.4 1/um" g="0.5"/></material></materials>
  <universe kind="synthetic" outside="air">{universe}</universe>
  <source {source}/><spectrum at="550 nm"/><detect path="yes"/><run histories="65536"/>
</scene>"#
    )
}

fn folder_with(name: &str, heights: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(name), heights).unwrap();
    folder
}

/// A sine along x of rms height `rms`, with a cosine of half the period along y: `n` × `m` heights.
fn egg_box(n: usize, m: usize, rms: f64) -> String {
    let wave = |k: usize, n: usize, times: f64| (std::f64::consts::TAU * times * k as f64 / n as f64).sin();
    let row = |j: usize| {
        let of = |i: usize| format!("{:.6}", rms * (wave(i, n, 1.0) + wave(j, m, 2.0)));
        (0..n).map(of).collect::<Vec<_>>().join(" ")
    };
    (0..m).map(|j| row(j) + "\n").collect()
}

/// Flat surfaces at the faces of a slab that reaches beyond them are that slab, bit for bit; so is a surface
/// through balls in a slab, where nothing but the slab ends.
#[test]
fn flat_surfaces_are_planes() {
    let folder = folder_with("flat.txt", "0 0 0\n0 0 0\n");
    let cut = |bodies: &str, low: f64, high: f64| {
        format!(
            r#"{bodies}<topography file="flat.txt" pixel="3 um" level="{high} um" position="fixed"/>
<topography side="bottom" file="flat.txt" pixel="3 um" level="{low} um" position="fixed"/>"#
        )
    };
    let balls = r#"<sphere centre="0 0 40 um" radius="20 um" material="glass" priority="1"/>
<sphere centre="13 0 90 um" radius="9 um" material="air" priority="1"/>"#;
    for (source, bodies) in [
        (r#"kind="collimated" polar="0 deg""#, ""),
        (r#"kind="diffuse""#, ""),
        (r#"kind="diffuse""#, balls),
        (r#"kind="collimated" polar="50 deg" radius="30 um""#, balls),
    ] {
        let slab = |low: f64, high: f64| {
            format!(r#"<slab z-min="{low} um" z-max="{high} um" material="gel"/>{bodies}"#)
        };
        let plain = figures(folder.path(), &scene(&slab(0.0, 100.0), source), 20_000);
        let carved = figures(folder.path(), &scene(&cut(&slab(-7.0, 120.0), 0.0, 100.0), source), 20_000);
        assert_eq!(plain, carved, "{source} {bodies}");
    }
}

/// Fresnel's reflectance of unpolarised light, written once more.
fn fresnel(c: f64, n: f64) -> f64 {
    let t = (1.0 - (1.0 - c * c) / (n * n)).sqrt();
    let (s, p) = ((c - n * t) / (c + n * t), (n * c - t) / (n * c + t));
    0.5 * (s * s + p * p)
}

/// Black glass with the surface of a sine whose slopes neither shadow nor reflect twice: R is the mean over the
/// facets, each by the light that it catches. Along the grooves the same with the plane of incidence turned.
#[test]
fn a_sine_reflects_as_its_facets() {
    let n = 64;
    let heights: Vec<f64> =
        (0..n).map(|i| 0.5 * (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin()).collect();
    let line = heights.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let folder = folder_with("sine.csv", &line);
    let pixel = 0.2;
    let slopes: Vec<f64> =
        (0..heights.len()).map(|i| (heights[(i + 1) % heights.len()] - heights[i]) / pixel).collect();
    for (seed, (polar, azimuth)) in
        [(0.0_f64, 0.0_f64), (40.0, 0.0), (40.0, 90.0), (40.0, 37.0)].into_iter().enumerate()
    {
        let universe = format!(
            r#"<plane point="0 0 1 um" material="black"/><topography file="sine.csv" pixel="{pixel} um" lateral="periodic"/>"#
        );
        let source = format!(r#"kind="collimated" polar="{polar} deg" azimuth="{azimuth} deg""#);
        let text = scene(&universe, &source).replace("<run ", &format!(r#"<run seed="{}" "#, seed + 1));
        let found = figures(folder.path(), &text, 1_000_000);
        let (t, f) = (polar.to_radians(), azimuth.to_radians());
        let caught = |s: f64| t.cos() - s * t.sin() * f.cos();
        let of = |s: f64| fresnel(caught(s) / (1.0 + s * s).sqrt(), 1.5) * caught(s) / t.cos();
        let want = slopes.iter().map(|&s| of(s)).sum::<f64>() / f64::from(n);
        let z = (found[0].1 - want) / found[0].2;
        let even = (found[0].1 - fresnel(t.cos(), 1.5)) / found[0].2;
        println!(
            "{polar} {azimuth}: R {:.5}({:.5}), facets {want:.5}, z {z:.2}; off an even surface by {even:.1}",
            found[0].1, found[0].2
        );
        // Four at once at 1e-3. An even surface is 12 errors off across the grooves, 3 along them, and at normal
        // incidence the slopes change too little to be seen.
        assert!(z.abs() < 3.7 && (polar == 0.0 || azimuth == 90.0 || even > 3.0));
    }
}

/// A periodic surface of Gaussian heights and slopes, `n` × `n`: waves of random phase, each with its like a
/// quarter turn on, so that slopes are alike along x and y.
fn gaussian_surface(n: usize, waves: usize) -> Vec<f64> {
    let mut s = Stream::of(22, 0, 0, Purpose::Probe);
    let (mut heights, mut used) = (vec![0.0; n * n], Vec::new());
    while used.len() < 4 * waves {
        // Wave numbers of a Gaussian spectrum, some twelve pixels and more long.
        let (r, f) =
            ((-2.0 * (1.0 - s.uniform()).ln()).sqrt() * 0.03 * n as f64, std::f64::consts::TAU * s.uniform());
        let (p, q) = ((r * f.cos()).round(), (r * f.sin()).round());
        let phases = [s.uniform(), s.uniform()];
        if used.contains(&(p, q)) {
            continue; // two waves of one number would make one direction steeper
        }
        used.extend([(p, q), (-p, -q), (-q, p), (q, -p)]);
        for (k, h) in heights.iter_mut().enumerate() {
            let (x, y) = ((k % n) as f64 / n as f64, (k / n) as f64 / n as f64);
            for ((a, b), phase) in [(p, q), (-q, p)].into_iter().zip(phases) {
                *h += (std::f64::consts::TAU * (a * x + b * y + phase)).sin();
            }
        }
    }
    heights
}

/// What the microfacet law knows of a surface is its slopes. Black glass with an explicit Gaussian surface
/// reflects as the law of Gaussian slopes with the random walk between its facets, also where a tenth of the
/// light is masked; without the walk it does not.
#[test]
fn a_gaussian_surface_is_the_microfacet_law() {
    let n = 256;
    let heights = gaussian_surface(n, 100);
    let map = HeightMap::new(heights.clone(), [n, n], [1.0; 2]).unwrap();
    let (_, _, [x, y]) = map.roughness();
    assert!((x / y - 1.0).abs() < 1e-9, "{x} {y}");
    let slope = 0.15;
    let unit = slope / (x * x + y * y).sqrt();
    let rows = heights.chunks(n).map(|r| r.iter().map(|h| format!("{h:.7} ")).collect::<String>() + "\n");
    let folder = folder_with("gauss.txt", &rows.collect::<String>());
    for (polar, walked) in [(20, true), (60, true), (75, true), (75, false)] {
        let source = format!(r#"kind="collimated" polar="{polar} deg""#);
        let explicit = format!(
            r#"<plane point="0 0 99 um" material="black"/><topography file="gauss.txt" unit="{unit} um" pixel="1 um" lateral="periodic"/>"#
        );
        let bounce = if walked { "walk" } else { "off" };
        let law = scene(r#"<plane point="0 0 0 um" material="black" surface="r"/>"#, &source).replace(
            "</materials>",
            &format!(
                r#"</materials><surfaces><surface id="r" kind="rough" slopes="gaussian" m="{slope}" multiple-bounce="{bounce}"/></surfaces>"#
            ),
        );
        let a = &figures(folder.path(), &scene(&explicit, &source), 1_000_000)[0];
        let b = &figures(folder.path(), &law.replace("<run ", r#"<run seed="5" "#), 1_000_000)[0];
        let z = (a.1 - b.1) / (a.2 * a.2 + b.2 * b.2).sqrt();
        println!("{polar} deg: R {:.5}({:.5}), law ({bounce}) {:.5}({:.5}), z {z:.2}", a.1, a.2, b.1, b.2);
        assert!(if walked { z.abs() < 3.7 } else { z > 20.0 });
    }
}

/// Rough on both sides, clear or milky within, or with balls that the surfaces cut: what goes in comes out, no
/// ray is lost, and the sheet is the same whether its surfaces are mirrored halves or repeated whole.
#[test]
fn rough_sheets_lose_nothing() {
    let folder = folder_with("whole.txt", &egg_box(16, 32, 1.5));
    let balls = r#"<cell period="16 32 um" bottom="0 um" top="30 um"/><slab z-min="0 um" z-max="30 um" material="milk" priority="-1"/>
<sphere centre="8 8 22 um" radius="6 um" material="air"/><sphere centre="3 25 7 um" radius="5 um" material="glass"/>"#;
    for body in [
        r#"<slab z-min="0 um" z-max="30 um" material="glass"/>"#,
        r#"<slab z-min="0 um" z-max="30 um" material="milk"/>"#,
        balls,
    ] {
        let universe = format!(
            r#"{body}<topography file="whole.txt" pixel="1 um" level="22 um" lateral="periodic"/>
<topography side="bottom" file="whole.txt" pixel="1 um" level="6 um" lateral="periodic"/>"#
        );
        for source in [r#"kind="diffuse""#, r#"kind="collimated" polar="75 deg" azimuth="20 deg""#] {
            let found = figures(folder.path(), &scene(&universe, source), 100_000);
            let (r, t) = (found[0].1, found[1].1);
            println!("{source}: R {r:.5}, T {t:.5}");
            assert!((r + t - 1.0).abs() < 1e-12 && r > 0.05 && t > 0.05);
        }
    }
}

/// Half a period and its mirror are the whole; displaced by chance or lit by a wide beam, the sheet is the same.
#[test]
fn light_falls_evenly_on_a_map() {
    let n = 17;
    let wave = |i: usize| 1.2 * (std::f64::consts::PI * i as f64 / (n - 1) as f64).cos();
    let line = |k: usize| (0..k).map(|i| format!("{:.9}", wave(i))).collect::<Vec<_>>().join(" ");
    let folder = folder_with("half.txt", &line(n));
    std::fs::write(folder.path().join("whole.txt"), line(2 * n - 2)).unwrap();
    let universe = |rest: &str| {
        format!(
            r#"<slab z-min="0 um" z-max="30 um" material="milk"/><topography pixel="0.5 um" level="20 um" {rest}/>"#
        )
    };
    let source = r#"kind="collimated" polar="55 deg""#;
    let run = |rest: &str, source: &str| figures(folder.path(), &scene(&universe(rest), source), 200_000);
    let mirrored = run(r#"file="half.txt""#, source);
    assert_eq!(mirrored, run(r#"file="whole.txt" lateral="periodic""#, source));
    // A beam of 400 periods on a surface that stands still.
    let wide = run(r#"file="half.txt""#, r#"kind="collimated" polar="55 deg" radius="3 mm""#);
    for (a, b) in mirrored.iter().zip(&wide).filter(|(a, _)| a.2 > 0.0) {
        let z = (a.1 - b.1) / (a.2 * a.2 + b.2 * b.2).sqrt();
        println!(
            "{}: {:.5}({:.5}) displaced, {:.5}({:.5}) under a wide beam, z {z:.2}",
            a.0, a.1, a.2, b.1, b.2
        );
        assert!(z.abs() < 4.0);
    }
}

/// Rays thrown about a cell of balls under a rough surface: at every interface the medium told is that at the
/// point just behind it, half of the directions grazing.
#[test]
fn what_is_told_is_there() {
    let folder = folder_with("whole.txt", &egg_box(16, 32, 1.5));
    let universe = r#"<cell period="16 32 um" bottom="0 um" top="30 um"/><slab z-min="0 um" z-max="18 um" material="gel" priority="-1"/>
<sphere centre="8 8 22 um" radius="6 um" material="glass"/><sphere centre="3 25 7 um" radius="5 um" material="glass"/>
<topography file="whole.txt" pixel="1 um" level="20 um" lateral="periodic"/>"#;
    let text = scene(universe, r#"kind="diffuse""#);
    let read = read_text(&text, &folder.path().join("t.xml"), &Options::default()).unwrap();
    let plan = lightpro::scene::plan::Plan::new(&read).unwrap();
    let AnyUniverse::Topography(u) = &plan.universe else { panic!() };
    let u = u.still();
    let mut s = Stream::of(21, 0, 0, Purpose::Probe);
    let direction = |s: &mut Stream| {
        let (c, f) = (2.0 * s.uniform() - 1.0, std::f64::consts::TAU * s.uniform());
        let r = (1.0 - c * c).sqrt();
        DVec3::new(r * f.cos(), r * f.sin(), c)
    };
    let (mut met, mut checked, mut wrong) = (0_u64, 0_u64, 0_u64);
    while met < 200_000 {
        let mut dir = direction(&mut s);
        dir.z = -dir.z.abs();
        let mut ray = Ray { origin: DVec3::new(99.0 * s.uniform(), -99.0 * s.uniform(), plan.top), dir };
        let start = u.enter(&ray, &mut (), &mut s);
        let (mut place, mut medium) = (start.place, start.medium);
        for _ in 0..100 {
            match u.next(&ray, &mut place, &mut (), f64::INFINITY, &mut s) {
                Next::Interface(at) => {
                    met += 1;
                    assert!(at.normal.dot(ray.dir) < 0.0 && at.distance >= 0.0);
                    let there = ray.at(at.distance);
                    // Half way to the interface, and behind it by much more than rounding.
                    if at.distance > 1e-6 {
                        checked += 1;
                        wrong += u64::from(u.medium_at(ray.at(0.5 * at.distance)) != medium);
                    }
                    let cross = s.uniform() < 0.6;
                    let side = if cross { -1.0 } else { 1.0 };
                    let d = direction(&mut s);
                    let flat = d - at.normal * d.dot(at.normal);
                    let steep = if s.uniform() < 0.5 { 1e-6 } else { d.dot(at.normal).abs().max(1e-3) };
                    ray = Ray { origin: there, dir: (flat + at.normal * (side * steep)).normalize() };
                    if cross {
                        u.crossed(&mut ray, &mut place, &mut (), &at);
                        medium = at.beyond;
                    } else {
                        u.reflected(&ray, &mut place, &mut (), &at);
                    }
                }
                Next::Edge { face, .. } => {
                    assert!(medium == u.bodies().ambient() || face == Face::Bottom);
                    break;
                }
                other => panic!("{other:?} after {met}"),
            }
        }
    }
    println!("{met} interfaces, {checked} flights looked at, {wrong} in another medium than told");
    assert!(wrong == 0 && checked > met / 2);
}

/// Three columns, two rows, as every kind of file that is read.
#[test]
fn files_of_every_kind() {
    let want = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    let folder = tempfile::tempdir().unwrap();
    let npy = |descr: &str, fortran: &str, data: &[u8]| {
        let dict = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': (2, 3), }}");
        let mut out = b"\x93NUMPY\x01\x00".to_vec();
        out.extend((dict.len() as u16).to_le_bytes());
        [out, dict.into_bytes(), data.to_vec()].concat()
    };
    let of = |f: &dyn Fn(f64) -> Vec<u8>| want.iter().flat_map(|&x| f(x)).collect::<Vec<u8>>();
    let turned: Vec<u8> = [0, 3, 1, 4, 2, 5].iter().flat_map(|&i: &u16| i.to_le_bytes()).collect();
    let gsf = {
        let head = "Gwyddion Simple Field 1.0\nXRes = 3\nYRes = 2\nXReal = 6e-6\nYReal = 3e-6\nZUnits = m\n";
        let mut out = head.as_bytes().to_vec();
        out.extend(vec![0; 4 - head.len() % 4]);
        [out, of(&|x| (x as f32 * 1e-6).to_le_bytes().to_vec())].concat()
    };
    let tiff = {
        let mut out = std::io::Cursor::new(Vec::new());
        let data: Vec<f32> = want.iter().map(|&x| x as f32).collect();
        let mut encoder = tiff::encoder::TiffEncoder::new(&mut out).unwrap();
        encoder.write_image::<tiff::encoder::colortype::Gray32Float>(3, 2, &data).unwrap();
        out.into_inner()
    };
    let files: [(&str, Vec<u8>); 9] = [
        ("f8.npy", npy("<f8", "False", &of(&|x| x.to_le_bytes().to_vec()))),
        ("f4.npy", npy(">f4", "False", &of(&|x| (x as f32).to_be_bytes().to_vec()))),
        ("i2.npy", npy("<i2", "True", &turned)),
        ("u1.npy", npy("|u1", "False", &[0, 1, 2, 3, 4, 5])),
        ("a.csv", b"# um\n0,1,2\n3, 4, 5e0 # last\n\n".to_vec()),
        ("a.txt", b"0 1\t2\r\n3.0 4 5\r\n".to_vec()),
        ("semi.csv", b"0;1;2\n3;4;5\n".to_vec()),
        ("a.gsf", gsf),
        ("a.tif", tiff),
    ];
    for (name, bytes) in &files {
        let path = folder.path().join(name);
        std::fs::File::create(&path).unwrap().write_all(bytes).unwrap();
        let read = file::read(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(read.nodes, [3, 2], "{name}");
        let scale = read.scale.map_or(1.0, |s| s.1);
        for (got, want) in read.values.iter().zip(want) {
            assert!((got * scale - want).abs() < 1e-6, "{name}");
        }
        if let Some((pixel, unit)) = read.scale {
            assert!((pixel[0] - 2.0).abs() < 1e-12 && (pixel[1] - 1.5).abs() < 1e-12 && unit == 1e6);
        }
        // Every cut of a file is refused, but that of a text may be a shorter text.
        let text = name.ends_with(".csv") || name.ends_with(".txt");
        for n in 0..bytes.len() {
            std::fs::write(&path, &bytes[..n]).unwrap();
            assert!(text || file::read(&path).is_err(), "{name} cut at {n}");
        }
    }
}

/// A small page whose tags say that it is large: tags of 12 bytes, 256 the width and 257 the height.
fn grown_page(mut file: Vec<u8>) -> Vec<u8> {
    for at in 0..file.len() - 12 {
        for (tag, edge) in [(256_u16, 40_000_u32), (257, 5_000)] {
            let entry = &mut file[at..at + 12];
            if entry[..2] == tag.to_le_bytes()
                && entry[4..8] == 1_u32.to_le_bytes()
                && entry[8..] == 2_u32.to_le_bytes()
            {
                entry[2..4].copy_from_slice(&4_u16.to_le_bytes());
                entry[8..].copy_from_slice(&edge.to_le_bytes());
            }
        }
    }
    file
}

#[test]
fn damaged_files_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let told = |name: &str, bytes: &[u8], what: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let e = file::read(&path).unwrap_err();
        assert!(e.to_string().contains(what) && !e.help.is_empty(), "{e}");
    };
    told("a.png", b"", "`.png` is no map of heights");
    told("a.csv", b"0,1\n2\n", "line 2: 1 heights, the first row has 2");
    told("a.csv", b"0,1\n2,x\n", "line 2: `x` is no number");
    told("a.csv", b"# nothing\n", "0 x 0 heights");
    let array = |dict: &str| {
        [b"\x93NUMPY\x01\x00".as_slice(), &(dict.len() as u16).to_le_bytes(), dict.as_bytes()].concat()
    };
    told("a.npy", &array("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2, 2)}"), "3 dimensions");
    told("a.npy", &array("{'descr': '<c8', 'fortran_order': False, 'shape': (2, 2)}"), "type `<c8`");
    told(
        "a.npy",
        &array("{'descr': '<f8', 'fortran_order': False, 'shape': (20000, 10000)}"),
        "promises 200000000",
    );
    told(
        "a.npy",
        &array("{'descr': '<f8', 'fortran_order': False, 'shape': (2000000, 1000000)}"),
        "2000000 heights",
    );
    told("a.gsf", b"Gwyddion Simple Field 1.0\nXRes = 2\n\0\0\0", "YRes is missing");
    // A TIFF page of 40,000 x 5,000 heights in a file of some hundred bytes.
    let mut tall = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut tall).unwrap();
    encoder.write_image::<tiff::encoder::colortype::Gray8>(2, 2, &[0; 4]).unwrap();
    let grown: Vec<u8> = grown_page(tall.into_inner());
    told("a.tif", &grown, "the header promises 40000 x 5000 heights");
    told("a.gsf", b"Gwyddion Native", "no Gwyddion simple field");
}

/// What scenes get wrong, with the place and a way out.
#[test]
fn scenes_that_cannot_be() {
    let folder = folder_with("a.txt", "0 1 2\n3 4 5\n");
    std::fs::write(folder.path().join("hole.txt"), "0 1 2\n3 nan 5\n").unwrap();
    let told = |universe: &str, pieces: &[&str]| {
        let text = scene(universe, r#"kind="diffuse""#);
        let shown =
            read_text(&text, &folder.path().join("t.xml"), &Options::default()).unwrap_err().to_string();
        for piece in pieces.iter().chain(&["t.xml:5:", "help: "]) {
            assert!(shown.contains(piece), "`{piece}` not in\n{shown}");
        }
    };
    let slab = r#"<slab z-min="0 um" z-max="30 um" material="glass"/>"#;
    let top = r#"<topography file="a.txt" pixel="1 um" level="20 um"/>"#;
    told(&format!("{slab}{top}{top}"), &["a second surface on the top", "the first one"]);
    told(
        &format!(r#"{slab}<topography file="a.txt"/>"#),
        &["the size of a pixel is not known", "pixel=\"1 um\""],
    );
    told(&format!(r#"{slab}<topography file="a.txt" pixel="1 2 3 um"/>"#), &["expected one or two edges"]);
    told(&format!(r#"{slab}<topography file="no.txt" pixel="1 um"/>"#), &["no such file"]);
    told(
        &format!(r#"{slab}<topography file="hole.txt" pixel="1 um"/>"#),
        &["no height at column 1, row 1", "interpolate"],
    );
    told(
        &format!(r#"{slab}{top}<topography side="bottom" file="a.txt" pixel="1 um" level="18 um"/>"#),
        &["the lower surface reaches up to 20.5 um", "level"],
    );
    told(
        &format!(r#"{slab}{top}<topography side="bottom" file="a.txt" pixel="2 um" level="5 um"/>"#),
        &["the upper surface repeats every 4 x 2 um, the lower one every 8 x 4 um"],
    );
    told(
        &format!(r#"<cell period="5 um" bottom="0 um" top="30 um"/>{slab}{top}"#),
        &["the surface repeats every 4 x 2 um, the cell every 5 x 5 um"],
    );
    told(
        &format!(r#"<cell period="4 2 um" bottom="0 um" top="21 um"/>{slab}{top}"#),
        &["the surface from 17.5 to 22.5 um leaves the cell from 0 to 21 um"],
    );
    let ball = r#"<sphere centre="0 0 5 um" radius="4 um" material="glass"/>"#;
    told(
        &format!(r#"{ball}<topography file="a.txt" pixel="1 um" position="random"/>"#),
        &["bodies that stand alone cannot be displaced by chance", "position=\"fixed\""],
    );
}
