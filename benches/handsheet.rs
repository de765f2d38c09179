//! The handsheet scene, on one thread: all its wavelengths on one path, and one wavelength alone.
#![allow(missing_docs)]

mod common;

use common::{best_ns, report};
use divan::Bencher;
use divan::counter::ItemsCount;
use lightpro::command::{SceneArgs, load};
use lightpro::run::simulate;
use lightpro::scene::Scene;
use lightpro::scene::plan::Plan;
use std::path::Path;

const HISTORIES: u64 = 4096;

/// The scene and its plan; `one`: only the middle wavelength.
fn handsheet(one: bool) -> (Scene, Plan) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/handsheet.xml");
    let (mut scene, mut plan) = load(&SceneArgs { path, ..SceneArgs::default() }).unwrap();
    scene.run.histories = HISTORIES;
    if one {
        let all = plan.groups.concat();
        plan.groups = vec![vec![all[all.len() / 2]]];
    }
    (scene, plan)
}

fn one_thread() -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap()
}

/// Runs the scene; events.
fn events(scene: &Scene, plan: &Plan) -> u64 {
    simulate(scene, plan, |_| true).unwrap().events()
}

#[divan::bench(args = [false, true], sample_count = 10)]
fn histories(bencher: Bencher, one_wavelength: bool) {
    let (scene, plan) = handsheet(one_wavelength);
    let pool = one_thread();
    bencher.counter(ItemsCount::new(HISTORIES)).bench_local(|| pool.install(|| events(&scene, &plan)));
}

fn main() {
    divan::main();
    report(|| {
        let pool = one_thread();
        let mut rows = Vec::new();
        for one in [false, true] {
            let (scene, plan) = handsheet(one);
            let name = format!("handsheet, {} wavelengths", plan.groups.concat().len());
            let mut count = 0;
            let total = best_ns(1, || count = pool.install(|| events(&scene, &plan)));
            let groups = plan.groups.len() as u64;
            rows.push((format!("{name}, history"), total / (HISTORIES * groups) as f64));
            rows.push((format!("{name}, event"), total / count as f64));
        }
        rows
    });
}
