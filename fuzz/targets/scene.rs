//! A scene and its plan.
#![no_main]

use lightpro::scene::Universe;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let options = lightpro::scene::Options::default();
    match lightpro::scene::read_text(text, std::path::Path::new("scene.xml"), &options) {
        // A deposited sheet is laid down by its plan: work, not reading.
        Ok(scene) if matches!(&scene.universe, Universe::Realised(r) if r.deposit.is_some()) => {}
        Ok(scene) => drop(lightpro::scene::plan::Plan::new(&scene)),
        Err(found) => drop(found.to_string()),
    }
});
