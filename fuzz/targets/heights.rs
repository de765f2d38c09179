//! A map of heights: the first byte tells the kind of file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, rest)) = bytes.split_first() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let ending = ["npy", "tif", "csv", "gsf"][usize::from(*kind) % 4];
    let path = folder.path().join(format!("h.{ending}"));
    std::fs::write(&path, rest).expect("a file");
    if let Ok(h) = lightpro::universe::topography::file::read(&path) {
        let map = lightpro::universe::shape::height::HeightMap::measured(h.values, h.nodes, [1.0; 2], true, Some(0.0));
        let _ = map.map(|m| m.roughness());
    }
});
