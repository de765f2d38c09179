//! A checkpoint file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = lightpro::run::checkpoint::from_bytes(bytes);
});
