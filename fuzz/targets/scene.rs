//! A scene and its plan.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    let options = lightpro::scene::Options::default();
    match lightpro::scene::read_text(text, std::path::Path::new("scene.xml"), &options) {
        Ok(scene) => drop(lightpro::scene::plan::Plan::new(&scene)),
        Err(found) => drop(found.to_string()),
    }
});
