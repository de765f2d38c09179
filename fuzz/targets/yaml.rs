//! Refractive indices.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(index) = lightpro::material::RefractiveIndex::from_rii(text, "x") {
        let _ = index.at(550.0);
    }
});
