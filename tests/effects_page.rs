//! `docs/effects.md`: effect, what calls for it, its price, its tests; renewed with LIGHTPRO_WRITE=1.
#![allow(missing_docs)]

use lightpro::scene::effects::Kind;
use std::path::Path;

/// What the page says of an effect: law and source, what calls for it, which loop and at which price (measured
/// as in the page's text), and the tests (file, function) that hold it.
struct Row {
    kind: Kind,
    law: &'static str,
    called: &'static str,
    price: &'static str,
    tests: &'static [(&'static str, &'static str)],
}

const ROWS: &[Row] = &[
    Row {
        kind: Kind::Absorption,
        law: "1 − e^(−µa s) along the path (paper (15), (17), exact)",
        called: "κ, `absorption`, absorbing particles",
        price: "minimal loop: one e^(−x) a flight",
        tests: &[
            ("effects", "absorption_on_with_none_changes_no_byte"),
            ("effects", "forced_off_is_left_out_and_labels_every_figure"),
        ],
    },
    Row {
        kind: Kind::Fresnel,
        law: "power reflectance, Snell (paper (4)–(10)), complex indices",
        called: "indices that differ",
        price: "minimal loop: a surface event; equal indices are none",
        tests: &[("effects", "fresnel_without_a_step_changes_nothing")],
    },
    Row {
        kind: Kind::Dispersion,
        law: "n(λ) turns rays: a pass per wavelength",
        called: "`index-file`, more than one wavelength",
        price: "a pass per wavelength instead of one for all",
        tests: &[
            ("effects", "dispersion_on_with_constant_indices_changes_nothing"),
            ("effects", "dispersion_off_keeps_absorption"),
        ],
    },
    Row {
        kind: Kind::Rough,
        law: "microfacets, visible normals, Smith's masking",
        called: "`kind=\"rough\"` with m > 0",
        price: "minimal loop: a drawn facet a surface event",
        tests: &[("effects", "rough_surfaces_without_slope_change_nothing")],
    },
    Row {
        kind: Kind::Lambertian,
        law: "equal radiance",
        called: "`kind=\"lambertian\"`",
        price: "minimal loop: a drawn direction a surface event; no neutral parameter",
        tests: &[("effects", "in_the_scene_and_refusals")],
    },
    Row {
        kind: Kind::Subsurface,
        law: "Poisson events of rate µs; Henyey–Greenstein, Rayleigh, Mie, table (paper (12)–(14), (16))",
        called: "`<scattering>`, `<particles>` in a material",
        price: "minimal loop: a draw of the free path a flight, a turn an event",
        tests: &[("effects", "scattering_without_scatterers_changes_nothing")],
    },
    Row {
        kind: Kind::Sap,
        law: "patches of equal area (paper 3.3)",
        called: "`<sap>`, `branching=\"split\"`",
        price: "minimal loop: a draw of a patch and of a direction in it an event, 2.3 × the time of P1",
        tests: &[("effects", "patches_with_their_density_change_nothing")],
    },
    Row {
        kind: Kind::Polarisation,
        law: "Stokes–Mueller: Fresnel amplitudes with the phases of total reflection, Mie S11, S12, S33, S34, Rayleigh (Bohren & Huffman 1983)",
        called: "`polarisation` of the source, `analyser` of the detectors",
        price: "full loop: 5 × the time of P1",
        tests: &[
            ("effects", "polarisation_where_nothing_polarises_changes_nothing"),
            ("polarisation", "rayleigh_slabs_meet_successive_orders"),
            ("polarisation", "machine_and_cross_direction_differ"),
            ("tables/particles", "go_particles_polarised"),
        ],
    },
    Row {
        kind: Kind::Fluorescence,
        law: "bispectral (Donaldson) matrix, quantum yield; events of their own rate, power moves between wavelengths",
        called: "`<fluorescence>` in a material",
        price: "full loop, a pass per wavelength of excitation",
        tests: &[
            ("fluorescence", "no_yield_is_absorption"),
            ("fluorescence", "bispectral_factors_of_slabs"),
            ("fluorescence", "quantum_yield_balances"),
            ("fluorescence", "a_brightened_sheet"),
        ],
    },
    Row {
        kind: Kind::Shifts,
        law: "1/λ′ = 1/λ ∓ Δν, one photon for one",
        called: "`<shift kind=\"raman|brillouin\">` in a material",
        price: "full loop, a pass per wavelength of excitation",
        tests: &[("fluorescence", "shifts")],
    },
    Row {
        kind: Kind::Films,
        law: "Airy's formula, complex amplitudes (Born & Wolf § 7.6)",
        called: "`film-index` and `film-thickness` of a surface",
        price: "an interference formula a surface event and wavelength; R(λ) goes by weights",
        tests: &[("effects", "films_without_thickness_change_nothing"), ("spectra", "films_on_a_plate")],
    },
    Row {
        kind: Kind::Bounces,
        law: "random walk on Smith's microsurface (Heitz et al. 2016), or the white albedo given back",
        called: "`multiple-bounce` of a rough surface",
        price: "minimal loop: a height and a facet a bounce",
        tests: &[("effects", "walks_between_facets")],
    },
    Row {
        kind: Kind::Time,
        law: "Σ n s/c",
        called: "`<detect time=\"yes\">`",
        price: "full loop: 5 to 6 × the time of P1",
        tests: &[
            ("effects", "time_of_flight_changes_no_byte"),
            ("spectra", "time_of_flight_through_a_plate"),
        ],
    },
];

const HEAD: &str = "# Effects

Written by `LIGHTPRO_WRITE=1 cargo test --test effects_page`.

A scene is simulated with the effects that it calls for, and with nothing else. `lightpro plan` names the line that
calls for each and says why the others are off; the same stands in `result.json` and in the manifest. A person may
decide otherwise, with a reason: `<effects><effect name=\"…\" state=\"on|off\" reason=\"…\"/></effects>` in the scene, or
`--effect name=on|off:reason`. Forced on, an effect's steps are taken with neutral parameters and change nothing (tests
below); forced off, what calls for it is left out and every figure says so. `lightpro study effects SCENE` toggles each:
what it changes in every figure, with an interval, and what it costs there.

There are two compiled loops for each universe. The minimal one carries one wavelength and knows nothing of
polarisation, of wavelengths that change, of weights between wavelengths, of time. The full one carries up to 32
wavelengths and has them, each behind a branch that is the same for a whole run. `benches/count.sh` counts the minimal
loop's instructions; they are pinned.

Prices are of `lightpro study effects scenes/verify/slab-p1-statistical.xml` (short histories, so that most of the full
loop's price is the room for 32 wavelengths that each history clears). Everything on that can be neutral there
(interfaces, dispersion, rough surfaces, polarisation, films, time) takes 4.3 × the time of the plan.

";

const SPECTRA: &str = "
## Spectra

The plan chooses, and says why:

| way | where | what it costs |
| --- | --- | --- |
| white | no path depends on wavelength (constant n, µs, p, R at smooth faces) | one pass, a weight per wavelength |
| weighted | µs(λ), p(λ) or R(λ) differ and directions do not: each wavelength draws in its turn, the others follow by bounded weights (balance heuristic) | one pass; errors grow where the wavelengths differ much. Copy paper with `weights=\"yes\"`, 31 wavelengths: 1.95 × the time of one, errors of R 1.6 to 3 × and of R∞ through a pile of 32 sheets 3 to 8 × those of as many histories at one wavelength; so not taken through piles by itself |
| one wavelength per history | n(λ) turns rays; polarised light, patches or facets with laws that differ; analog absorption; `weights=\"no\"` | a pass per wavelength: copy paper with walls of dispersive cellulose, 31 wavelengths, 30 × the time of one |
| one excitation per pass | events change the wavelength | a pass per wavelength of excitation |
";

fn page() -> String {
    let mut text = HEAD.to_owned();
    text += "| effect | law | what calls for it | price | tests |\n| --- | --- | --- | --- | --- |\n";
    for r in ROWS {
        let tests: Vec<String> = r.tests.iter().map(|(f, t)| format!("`{f}::{t}`")).collect();
        text += &format!(
            "| {} | {} | {} | {} | {} |\n",
            r.kind.name(),
            r.law,
            r.called,
            r.price,
            tests.join(", ")
        );
    }
    text + SPECTRA
}

#[test]
fn the_page_is_in_step() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let kinds: Vec<Kind> = ROWS.iter().map(|r| r.kind).collect();
    assert_eq!(kinds, Kind::ALL, "every effect has its row");
    for (file, name) in ROWS.iter().flat_map(|r| r.tests) {
        let source = std::fs::read_to_string(root.join(format!("tests/{file}.rs"))).unwrap();
        assert!(source.contains(&format!("#[test]\nfn {name}()")), "{file} has no test {name}");
    }
    let path = root.join("docs/effects.md");
    if std::env::var_os("LIGHTPRO_WRITE").is_some() {
        std::fs::write(&path, page()).unwrap();
    }
    assert!(std::fs::read_to_string(&path).unwrap_or_default() == page(), "docs/effects.md is out of step");
}
