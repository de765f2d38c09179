//! `docs/accuracy.md`: every number of it comes from the program. `LIGHTPRO_WRITE=1 cargo test --test
//! accuracy_page` renews page and pictures (some minutes); without it the cheap parts are computed again.
#![allow(missing_docs)]
#![allow(clippy::disallowed_methods)]

use lightpro::report::text::{digits, with_error};
use lightpro::scene::{Options as Reading, Scene, read, read_text};
use lightpro::study::accuracy::{self, Study};
use lightpro::study::compare::{Comparison, Entry, Options, compare};
use lightpro::study::sap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

const HEAD: &str = "# What accuracy costs

Written by `LIGHTPRO_WRITE=1 cargo test --test accuracy_page`. Every number below was computed by the program when the page was written; times are processor seconds of the machine that wrote it, ratios of times tell more.

```
lightpro run scene.xml --target reflectance:0.1%    stops when the figure is known so well (runs.md)
lightpro compare scene.xml                          the same sheet in every universe that it can be in
lightpro compare a.xml --with b.xml                 two scenes, figure by figure: hard spheres, a tomogram
lightpro compare a.xml --universes full,bodies,voxels --voxel \"0.5 um\"   one realisation, as it is and as voxels
lightpro study accuracy scene.xml                   sources of error, settings, times to a target
lightpro study convergence scene.xml --knob patches one setting, ever finer
lightpro study sap scenes/seed/fig10*.xml           patches of the sphere against the continuous law
```

## What `compare` says

Every figure and every curve (spectra, reflectance factor over polar angle, fluence over depth, lateral spread) of each universe is held against a reference: explicit Boolean realisations where they are among them, else full memory, else the first. `--reference` names another.

- **agree within m**: two one-sided tests (Schuirmann) against the margin m succeed; of a curve at every point. The margin is .005 in a reflectance (`--margin`); figures in per cent and of colour have 100 times that, whiteness and tint 400 times, reflectance factors of directions 5 times, lengths, numbers and coefficients 2 times as a share of their value.
- **differ by d**: a difference from 0 is shown, and not shown to be within the margin.
- **not decidable with so many histories**: neither; about how many times as many would decide it.

Both kinds of p-values are adjusted for all figures and universes (Holm; within a curve Bonferroni), so that with probability .95 no verdict of the report is wrong. Intervals are Student's t with Welch's degrees of freedom. The universes draw independent numbers. Each gets processor time as the root of what a history costs there, `--max-time` in all.

`prices.csv` has what the same standard error costs, and the time to a wanted error, bias counted in: √(b² + s²t₀/t). Where the bias b alone is larger it says never. `compare.json`, `compare.csv` and `verdicts.csv` are the same bytes for the same seed and histories; `prices.*` and the manifest, which tell times, are not.

## White fibres: what each memory is worth

White in-plane fibres, sheet of ten radii, diffuse light from the pores, held against explicit Boolean realisations:

";

/// White in-plane fibres of the design's table.
fn white(share: f64) -> Scene {
    let path = root().join("scenes/verify/white-fibres-none.xml");
    let text = std::fs::read_to_string(&path).unwrap();
    let text = text.replace("volume-fraction=\"0.3\"", &format!("volume-fraction=\"{share}\""));
    read_text(&text, &path, &Reading::default()).unwrap()
}

fn ladder(share: f64) -> Comparison {
    let entries: Vec<Entry> =
        ["none", "1", "4", "full", "boolean"].iter().map(|w| Entry::parse(w).unwrap()).collect();
    let time = Duration::from_secs(3600);
    let options = Options { time, histories: Some(500_000), ..Options::default() };
    compare(&white(share), &entries, &[], &options, |_| ()).unwrap()
}

fn ladder_rows(share: f64, c: &Comparison, out: &mut String) {
    let reference = &c.ran[c.reference];
    let boolean = reference.result.figure("reflectance", None).unwrap();
    let _ = writeln!(
        out,
        "| {share} | explicit | {} | | | 1 | {} |",
        with_error(boolean.value.unwrap(), boolean.error),
        seconds(c, "boolean")
    );
    for ran in c.ran.iter().filter(|r| r.name != reference.name) {
        let f = ran.result.figure("reflectance", None).unwrap();
        let claim = c.claims.iter().find(|k| k.universe == ran.name && k.figure == "reflectance").unwrap();
        let price = c.prices.iter().find(|p| p.universe == ran.name && p.figure == "reflectance").unwrap();
        let verdict = claim.to_string();
        let verdict = verdict.split(" (").next().unwrap();
        let verdict = verdict.split(" by ").next().unwrap();
        let _ = writeln!(
            out,
            "| {share} | {} | {} | {} | {verdict} | {} | {} |",
            ran.name,
            with_error(f.value.unwrap(), f.error),
            with_error(claim.difference, Some(claim.error)),
            digits(price.times_reference, 2),
            seconds(c, &ran.name)
        );
    }
}

fn seconds(c: &Comparison, universe: &str) -> String {
    let price = c.prices.iter().find(|p| p.universe == universe && p.figure == "reflectance").unwrap();
    match price.cpu_to_wanted {
        Some(s) => format!("{} s", digits(s, 2)),
        None => price.note.split(" ±").next().unwrap().to_owned(),
    }
}

/// Exact biases of patches: cheap, so computed again at every test.
fn bias_table() -> String {
    let mut out = String::from(
        "| nside | centre, random axis | centre, pole | uniform, random axis | uniform, pole | density |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    let rows = sap::biases(0.9, &sap::GRANULARITIES, 2).unwrap();
    for nside in sap::GRANULARITIES {
        let of = |directions: &str, axis: &str| {
            let r = rows
                .iter()
                .find(|r| r.nside == nside && r.directions == directions && r.axis == axis)
                .unwrap();
            if r.bias.abs() < 1e-12 { "0".to_owned() } else { digits(100.0 * r.bias, 3) }
        };
        let _ = writeln!(
            out,
            "| {nside} | {} | {} | {} | {} | {} |",
            of("centre", "random"),
            of("centre", "pole"),
            of("uniform", "random"),
            of("uniform", "pole"),
            of("density", "pole")
        );
    }
    out
}

fn light_table(scene: &str, figure: &str, histories: u64) -> String {
    let scene = read(&root().join(scene), &Reading::default()).unwrap();
    let rows = sap::light(&scene, &sap::GRANULARITIES, histories).unwrap();
    let rows: Vec<_> = rows.iter().filter(|r| r.figure == figure).collect();
    let base = rows.iter().find(|r| r.nside == 0).unwrap();
    let mut out = format!(
        "{}: {figure} {} by the continuous law; patches less that.\n\n| nside | centre | uniform | density | centre, rotated | density, rotated | the paper (all of it) | density, split: merit |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n",
        scene.name,
        with_error(base.value, Some(base.error))
    );
    for nside in sap::GRANULARITIES {
        let of = |directions: &str, frame: &str, populate: &str, branching: &str| {
            rows.iter().find(|r| {
                r.nside == nside
                    && r.directions == directions
                    && r.frame == frame
                    && r.populate == populate
                    && r.branching == branching
            })
        };
        let cell = |directions: &str, frame: &str, populate: &str| {
            of(directions, frame, populate, "sample")
                .map_or("–".to_owned(), |r| with_error(r.difference, Some(r.difference_error)))
        };
        let split = of("density", "resolved", "exact", "split");
        let _ = writeln!(
            out,
            "| {nside} | {} | {} | {} | {} | {} | {} | {} |",
            cell("centre", "resolved", "exact"),
            cell("uniform", "resolved", "exact"),
            cell("density", "resolved", "exact"),
            cell("centre", "rotated", "exact"),
            cell("density", "rotated", "exact"),
            cell("centre", "rotated", "centre"),
            split.map_or("–".to_owned(), |r| format!(
                "{} ({})",
                with_error(r.difference, Some(r.difference_error)),
                digits(r.merit, 2)
            ))
        );
    }
    out
}

fn studied(scene: &Scene, histories: u64, effects: bool) -> Study {
    let options =
        accuracy::Options { histories: Some(histories), each: 60.0, effects, ..accuracy::Options::default() };
    accuracy::study(scene, &options, |_| ()).unwrap()
}

const PICTURES: [(&str, &str); 4] = [
    ("f1_error_time", "Error against time: biased rungs reach a floor"),
    ("f2_pareto", "Error as run, and the front"),
    ("f4_budget", "Sources of error"),
    ("f9_rungs", "Rungs against full memory, and their price"),
];

fn page() -> String {
    let mut text = HEAD.to_owned();
    text += "| share | memory | R | difference | verdict | price of the same error, explicit = 1 | to ± .001 |\n| --- | --- | --- | --- | --- | --- | --- |\n";
    for share in [0.1, 0.3, 0.5] {
        ladder_rows(share, &ladder(share), &mut text);
    }
    text += "\nWithout memory the sheet comes out too dark, at any number of histories; full memory agrees with explicit sheets and costs a small part of them. Bodies that do **not** overlap are another matter: statistical rungs, full memory included, are an approximation there, and `compare --with` an explicit scene says by how much (`tests/compare.rs`: hard white spheres).\n\n";
    text += "## Where the error of a scene comes from\n\n`lightpro study accuracy scenes/verify/white-fibres-none.xml`:\n\n```\n";
    let s = studied(&white(0.3), 400_000, true);
    text += &s.to_string();
    text += "\n```\n\n";
    for (stem, title) in PICTURES {
        let files = s.files();
        for end in ["svg", "csv"] {
            let name = format!("{stem}.{end}");
            let content = &files.iter().find(|f| f.0 == name).unwrap().1;
            std::fs::write(root().join(format!("docs/figures/accuracy-{name}")), content).unwrap();
        }
        let _ = writeln!(text, "![{title}](figures/accuracy-{stem}.svg)\n");
    }
    text += "T1 to T5 and F1 to F9 are written as CSV, JSON and SVG with the numbers behind each picture. A source of error is `measured` (told from 0 by two standard errors), `bounded` (not told: twice the error), `assumed`, or `not assessed`; sources are never merged. The voxel size is bounded by what voxels of twice the size change; input data are assumed to be known to 1 % each, and `t2_inputs.csv` has the change by each, to be scaled with one's own uncertainties. Second-order extrapolation is given only where the ratio per doubling is between 3 and 5.\n\n";
    text += "## Do predicted times hold?\n\nA run of another seed to the hardest target in reach; its processor time, scaled by the error that it reached, over the prediction:\n\n| scene | target | predicted | measured | ratio | z of the value |\n| --- | --- | --- | --- | --- | --- |\n";
    for name in ["verify/white-fibres-full.xml", "verify/slab-p2.xml", "verify/hollow-fibres-full.xml"] {
        let scene = read(&root().join("scenes").join(name), &Reading::default()).unwrap();
        let held = studied(&scene, 200_000, false).held.unwrap();
        let _ = writeln!(
            text,
            "| `{name}` | {} | {} s | {} s | {:.2} | {:+.1} |",
            held.target,
            digits(held.predicted_cpu, 3),
            digits(held.cpu_of_target, 3),
            held.ratio,
            held.z
        );
    }
    text += "\n## Patches of the sphere\n\nBias of 1 − g of a Henyey–Greenstein law with g = .9 by exactly populated patches, (1 − g′)/(1 − g) − 1 in per cent, from integrals over the patches; in transport the forward direction is a pole of the patches:\n\n";
    text += &bias_table();
    let plot =
        sap::Study { biases: sap::biases(0.9, &sap::GRANULARITIES, 2).unwrap(), light: Vec::new() }.plot();
    std::fs::write(root().join("docs/figures/accuracy-sap_bias.svg"), plot.svg).unwrap();
    text += "\n![Bias of patches](figures/accuracy-sap_bias.svg)\n\nSecond order: a quarter per doubling from nside 8 on. Directions drawn from the density inside the patch have no bias.\n\n";
    text += &light_table("scenes/seed/fig11-gaussian-45-granularity-3.xml", "checkpoint", 200_000);
    text += "\n";
    text += &light_table("scenes/verify/slab-p2.xml", "reflectance", 200_000);
    text +=
        "\nMerit: 1/(error² · time) over that of the continuous law. ± is one standard error throughout.\n";
    text
}

#[test]
fn the_page_is_the_programs() {
    let path = root().join("docs/accuracy.md");
    if std::env::var_os("LIGHTPRO_WRITE").is_some() {
        let text = page();
        std::fs::write(&path, text).unwrap();
    }
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with(HEAD), "the text of the page is that of this test");
    assert!(text.contains(&bias_table()), "the biases of patches are computed again, and differ");
    for part in text.split("](figures/").skip(1) {
        let name = part.split(')').next().unwrap();
        assert!(root().join("docs/figures").join(name).is_file(), "{name}");
    }
    assert!(std::fs::read_to_string(root().join("README.md")).unwrap().contains("docs/accuracy.md"));
    // The ladder: without memory darker, full memory in agreement.
    for share in ["0.1", "0.3", "0.5"] {
        let row =
            |memory: &str| text.lines().find(|l| l.starts_with(&format!("| {share} | {memory} |"))).unwrap();
        assert!(row("none").contains("| differ |") && row("none").contains("never"), "{}", row("none"));
        assert!(row("full").contains("| agree within"), "{}", row("full"));
    }
    assert!(Path::new(&path).metadata().unwrap().len() > 5000);
}
