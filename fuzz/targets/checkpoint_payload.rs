//! What a checkpoint holds, past its checksum.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = lightpro::run::checkpoint::decode(bytes);
});
