//! Light that changes its wavelength: fluorescing slabs against closed forms and an integration of the
//! transfer equation, shifts, and a brightened sheet under three lights.
#![allow(missing_docs)]
#![allow(clippy::disallowed_methods)]

use lightpro::command::{Finished, RunArgs, finish};
use lightpro::math::gauss_legendre;
use lightpro::scene::{Options, read_text};
use std::path::Path;

fn read(text: &str, defines: &[(&str, &str)]) -> Result<lightpro::scene::Scene, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/conversion.xml");
    let defines = defines.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect();
    read_text(text, &path, &Options { defines, ..Options::default() }).map_err(|d| d.render(false))
}

fn run(text: &str, defines: &[(&str, &str)], histories: u64) -> Finished {
    let scene = read(text, defines).unwrap_or_else(|e| panic!("{e}"));
    let args = RunArgs { histories: Some(histories), ..RunArgs::default() };
    let done = finish(scene, &args, |_| true).unwrap();
    // The energy balance closes in every lane of every history, and over all lanes.
    assert!(done.outcome.worst_imbalance() < 1e-12, "{:e}", done.outcome.worst_imbalance());
    assert_eq!(done.outcome.troubled(), (0, 0));
    done
}

fn figure(done: &Finished, name: &str, nm: Option<f64>, component: Option<&str>) -> (f64, f64) {
    let same = |f: &&lightpro::report::Figure| {
        f.name == name && f.wavelength_nm == nm && f.component.as_deref() == component
    };
    let found = done.result.figures.iter().find(same);
    found.map_or((0.0, 0.0), |f| (f.value.unwrap(), f.error.unwrap_or(0.0)))
}

/// D(from → to) of reflected light.
fn bispectral(done: &Finished, from: f64, to: f64) -> (f64, f64) {
    figure(done, "bispectral_factor", Some(to), Some(&format!("excited at {from} nm")))
}

/// Index-matched slab of 100 µm: absorption, scattering (1/µm) and a dye of 0.01/µm about 360 nm that
/// emits about 480 nm.
fn slab(mu_a: f64, mu_s: f64, quantum_yield: f64) -> String {
    format!(
        r#"<scene name="dyed slab" version="1">
  <materials>
    <material id="air" index="1"/>
    <material id="dyed" index="1" absorption="{mu_a} 1/um">
      <scattering mu-s="{mu_s} 1/um" phase="isotropic"/>
      <fluorescence absorption="0.01 1/um" peak="360 nm" width="10 nm" emission="480 nm" emission-width="15 nm" quantum-yield="{quantum_yield}"/>
    </material>
  </materials>
  <universe kind="synthetic" outside="air"><slab z-min="0 um" z-max="100 um" material="dyed"/></universe>
  <source kind="collimated"/>
  <spectrum from="360 nm" to="600 nm" step="20 nm"/>
  <run histories="1000"/>
</scene>"#
    )
}

/// Power that one event at 360 nm sends to `to`: written out here, not asked of the program.
fn event(to: f64, quantum_yield: f64) -> f64 {
    let photons = |nm: f64| (-0.5 * ((nm - 480.0) / 15.0_f64).powi(2)).exp();
    let all: f64 = (0..13).map(|i| photons(360.0 + 20.0 * f64::from(i))).sum();
    quantum_yield * photons(to) / all * 360.0 / to
}

/// Reflected and transmitted light of an isotropic slab at depth steps: sources of power (1/µm) per layer
/// that scatter with albedo, by iteration. Returns fluxes up and down and the absorption per layer.
struct Layers {
    dz: f64,
    mu_s: f64,
    mu_a: f64,
}

const LAYERS: usize = 400;

impl Layers {
    /// `emitted`: isotropic power per volume in each layer (already first events). Fluxes and the scalar
    /// flux (path per volume) in every layer.
    fn solve(&self, emitted: &[f64]) -> ([f64; 2], Vec<f64>) {
        let mu = gauss_legendre(32, 0.0, 1.0);
        let t = (self.mu_s + self.mu_a) * self.dz;
        let mut fluence = vec![0.0; LAYERS];
        let mut out = [0.0; 2];
        for _ in 0..2000 {
            let source: Vec<f64> = (0..LAYERS).map(|k| emitted[k] + self.mu_s * fluence[k]).collect();
            let mut next = vec![0.0; LAYERS];
            out = [0.0; 2];
            for &(m, w) in &mu {
                let x = t / m;
                let (through, inside) = ((-x).exp(), if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 });
                for (side, up) in [(0, true), (1, false)] {
                    // Power per area in this cone of directions: half of the isotropic source goes each way.
                    let mut i = 0.0;
                    for step in 0..LAYERS {
                        let k = if up { LAYERS - 1 - step } else { step };
                        let own = 0.5 * w * source[k] * self.dz / m;
                        // Radiance-like quantity i (path per volume): di/ds = −(µ) i + source.
                        let mean = i * inside + own * if x > 0.0 { (1.0 - inside) / x } else { 0.5 };
                        next[k] += mean;
                        i = i * through + own * inside;
                    }
                    out[side] += i * m;
                }
            }
            let change = fluence.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            fluence = next;
            if change < 1e-14 {
                break;
            }
        }
        (out, fluence)
    }
}

/// D of the slab by integration: excitation transfer, then emission transfer.
fn integrated(mu_a: f64, mu_s: f64, to: f64, quantum_yield: f64) -> [f64; 2] {
    let dz = 100.0 / LAYERS as f64;
    let dye = 0.01;
    let first = Layers { dz, mu_s, mu_a: mu_a + dye };
    let extinction = mu_s + mu_a + dye;
    // Direct light: mean over the layer.
    let direct: Vec<f64> = (0..LAYERS)
        .map(|k| (-(k as f64) * dz * extinction).exp() * -(-extinction * dz).exp_m1() / (extinction * dz))
        .collect();
    let (_, fluence) = first.solve(&direct.iter().map(|d| mu_s * d).collect::<Vec<_>>());
    let emitted: Vec<f64> =
        (0..LAYERS).map(|k| event(to, quantum_yield) * dye * (direct[k] + fluence[k])).collect();
    Layers { dz, mu_s, mu_a }.solve(&emitted).0
}

/// The integration itself: conservative slabs give back all light, thin emitters half to each side.
#[test]
fn the_integration_is_sound() {
    let l = Layers { dz: 0.25, mu_s: 0.02, mu_a: 0.0 };
    let (out, _) = l.solve(&[0.01; LAYERS]);
    assert!((out[0] + out[1] - 1.0).abs() < 1e-6 && (out[0] - out[1]).abs() < 1e-9, "{out:?}");
    // No scattering: power emitted at depth z leaves upwards as ½ E2(µ z); ∫ over a slab = (1 − 2 E3(τ))/(4µ).
    let l = Layers { dz: 0.25, mu_s: 0.0, mu_a: 0.01 };
    let e3: f64 = gauss_legendre(200, 0.0, 1.0).iter().map(|(m, w)| w * m * (-1.0 / m).exp()).sum();
    let (out, _) = l.solve(&[1.0; LAYERS]);
    assert!((out[0] - (1.0 - 2.0 * e3) / (4.0 * 0.01)).abs() < 1e-3, "{out:?}");
}

#[test]
fn bispectral_factors_of_slabs() {
    for (mu_a, mu_s, quantum_yield) in [(0.0, 0.0, 1.0), (0.004, 0.0, 0.7), (0.001, 0.03, 0.7)] {
        let done = run(&slab(mu_a, mu_s, quantum_yield), &[], 200_000);
        for to in [460.0, 480.0, 500.0] {
            let (got, se) = bispectral(&done, 360.0, to);
            let want = integrated(mu_a, mu_s, to, quantum_yield)[0];
            println!("µa {mu_a} µs {mu_s} 360 → {to}: {got:.6} ± {se:.6}, wanted {want:.6}");
            assert!((got - want).abs() < 4.0 * se + 1e-5 && se < 0.02 * want, "{got} {want} ± {se}");
        }
        // Up the spectrum nothing goes.
        assert_eq!(bispectral(&done, 480.0, 360.0).0, 0.0);
    }
}

/// Without scattering: half of what is absorbed goes up, closed form. Photons come out as they should.
#[test]
fn quantum_yield_balances() {
    let quantum_yield = 0.6;
    let done = run(&slab(0.0, 0.0, quantum_yield), &[], 400_000);
    let absorbed = 1.0 - (-1.0_f64).exp();
    let mut photons = 0.0;
    let mut se2 = 0.0;
    for i in 1..13 {
        let to = 360.0 + 20.0 * f64::from(i);
        let (d, se) = bispectral(&done, 360.0, to);
        photons += d * to / 360.0;
        se2 += (se * to / 360.0).powi(2);
    }
    let want = 0.5 * quantum_yield * absorbed;
    println!("photons up {photons:.5} ± {:.5}, wanted {want:.5}", se2.sqrt());
    assert!((photons - want).abs() < 4.0 * se2.sqrt().max(1e-4));
    let power: f64 = (1..13).map(|i| event(360.0 + 20.0 * f64::from(i), quantum_yield)).sum();
    let (converted, se) = figure(&done, "converted", Some(360.0), None);
    assert!((converted - absorbed * power).abs() < 4.0 * se, "{converted} ± {se}");
    let (heat, se) = figure(&done, "absorptance", Some(360.0), None);
    assert!((heat - absorbed * (1.0 - power)).abs() < 4.0 * se, "{heat} ± {se}");
}

/// A dye that emits nothing is an absorber.
#[test]
fn no_yield_is_absorption() {
    let dark = run(&slab(0.001, 0.02, 0.0), &[], 300_000);
    let plain = slab(0.001, 0.02, 0.0);
    let start = plain.find("<fluorescence").unwrap();
    let end = start + plain[start..].find("/>").unwrap() + 2;
    let text = (plain[..start].to_owned() + &plain[end..]).replace("0.001 1/um", "0.011 1/um");
    let absorber = run(&text, &[], 300_000);
    for name in ["reflectance", "transmittance"] {
        let (a, b) = (figure(&dark, name, Some(360.0), None), figure(&absorber, name, Some(360.0), None));
        let se = (a.1 * a.1 + b.1 * b.1).sqrt();
        assert!((a.0 - b.0).abs() < 3.0 * se, "{name}: {a:?} {b:?}");
    }
}

/// One Raman event sends the photon 2900 /cm down, as much up as down the slab.
#[test]
fn shifts() {
    let clear = |shift: &str, spectrum: &str| {
        let text = slab(0.0, 0.0, 0.0);
        let start = text.find("<scattering").unwrap();
        let end = text.find("</material>\n  </materials>").unwrap();
        (text[..start].to_owned() + shift + &text[end..])
            .replace(r#"from="360 nm" to="600 nm" step="20 nm""#, spectrum)
    };
    let raman = r#"<shift kind="raman" by="2900 1/cm" rate="1e-3 1/um"/>"#;
    let done = run(&clear(raman, r#"from="500 nm" to="600 nm" step="10 nm""#), &[], 200_000);
    // From 500 nm to 584.8 nm, in the bin of 580 nm, where half of it leaves upwards: it may shift again out
    // of the spectrum on its way (rate 1e-3, ∫ e^(−µz) ½ E2(µz)).
    let want: f64 = gauss_legendre(64, 0.0, 100.0)
        .iter()
        .map(|(z, w)| {
            let x = 1e-3 * z;
            let e2: f64 = gauss_legendre(64, 0.0, 1.0).iter().map(|(m, v)| v * (-x / m).exp()).sum();
            w * 1e-3 * (-x).exp() * 0.5 * e2
        })
        .sum::<f64>()
        * 500.0
        / 580.0;
    let (got, se) = bispectral(&done, 500.0, 580.0);
    println!("raman {got:.6} ± {se:.6}, wanted {want:.6}");
    assert!((got - want).abs() < 4.0 * se);
    let why = read(&clear(raman, r#"from="400 nm" to="700 nm" step="100 nm""#), &[]).unwrap_err();
    assert!(why.contains("too coarse") && why.contains("a step of at most 52.49 nm"), "{why}");
    let brillouin = r#"<shift kind="brillouin" by="0.5 1/cm" rate="1e-3 1/um"/>"#;
    let why = read(&clear(brillouin, r#"from="400 nm" to="700 nm" step="10 nm""#), &[]).unwrap_err();
    assert!(why.contains("a step of at most 0.0080 nm"), "{why}");
    let done = run(&clear(brillouin, r#"from="550 nm" to="550.3 nm" step="0.015 nm""#), &[], 100_000);
    let (down, up) = (bispectral(&done, 550.15, 550.165), bispectral(&done, 550.15, 550.135));
    assert!(
        down.0 > 0.0 && (down.0 - up.0).abs() < 5.0 * (down.1 * down.1 + up.1 * up.1).sqrt(),
        "{down:?} {up:?}"
    );
}

/// A brightener lifts whiteness under D65 much, under C (little ultraviolet) less, and not at all without
/// ultraviolet.
#[test]
fn a_brightened_sheet() {
    let text =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/brightened-sheet.xml"))
            .unwrap();
    let (bright, dull) = (run(&text, &[], 30_000), run(&text, &[("yield", "0")], 30_000));
    let gain = |component: &str, name: &str| {
        let (a, b) =
            (figure(&bright, name, None, Some(component)), figure(&dull, name, None, Some(component)));
        println!("{component}: {name} {:.2} ± {:.2} with, {:.2} ± {:.2} without", a.0, a.1, b.0, b.1);
        a.0 - b.0
    };
    let d65 = gain("D65", "whiteness_cie_d65_10");
    let c = gain("C", "whiteness_cie_c_2");
    let none = gain("D65, UV excluded", "whiteness_cie_d65_10");
    assert!(d65 > 8.0 && none.abs() < 2.0 && c > none && c < d65, "{d65} {c} {none}");
    // More light comes out at 440 nm under D65 than goes in there.
    let (total, _) = figure(&bright, "total_radiance_factor", Some(440.0), Some("D65"));
    let (own, _) = figure(&bright, "total_radiance_factor", Some(440.0), Some("D65, UV excluded"));
    assert!(total > own + 0.03, "{total} {own}");
}

#[test]
fn refusals() {
    let why = |from: &str, to: &str| read(&slab(0.0, 0.0, 1.0).replace(from, to), &[]).unwrap_err();
    let e = why(r#"to="600 nm" step="20 nm""#, r#"to="600 nm" step="5 nm""#);
    assert!(e.contains("at most 32 wavelengths, not 49") && e.contains("a step of 7.7 nm"), "{e}");
    let e = why(r#"to="600 nm""#, r#"to="460 nm""#);
    assert!(e.contains("of the emission lies beyond"), "{e}");
}
