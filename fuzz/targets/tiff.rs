//! A volume of voxels as tiff.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("v.tif");
    std::fs::write(&path, bytes).expect("a file");
    let labels = lightpro::universe::voxel::read::Labels::new(vec![(0, 255, 0)]).expect("labels");
    let _ = lightpro::universe::voxel::read::open(&path).and_then(|s| s.load(&labels, false, 1_000_000));
});
