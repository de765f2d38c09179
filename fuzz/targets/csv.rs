//! Tables of numbers.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = lightpro::spectrum::csv::read(text, "x");
    let _ = lightpro::spectrum::csv::rows::<3>(text, "x");
});
