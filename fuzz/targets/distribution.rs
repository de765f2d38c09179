//! A file of fibre statistics, through a scene that uses it.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("d.xml"), text).expect("a file");
    let scene = r#"<scene name="x" version="1"><materials><material id="air" index="1"/><material id="wall" index="1.5"/></materials>
<universe kind="statistical" memory="none" outside="air"><sheet thickness="100 um" pore="air"><layer>
<fibres from="d.xml" material="wall" grammage="60 g/m2"/></layer></sheet></universe></scene>"#;
    let options = lightpro::scene::Options::default();
    let _ = lightpro::scene::read_text(scene, &folder.path().join("scene.xml"), &options);
});
