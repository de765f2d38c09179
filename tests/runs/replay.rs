//! One history again: the path of the run itself.

use crate::{lightpro, place, text, well};
use lightpro::report::RunResult;

/// Power that a history's path carries out of the top.
fn reflected(csv: &str) -> f64 {
    let rows = csv.lines().skip(1).map(|l| l.split(',').collect::<Vec<_>>());
    rows.filter(|r| r[1] == "leaves_top").map(|r| r[9].parse::<f64>().unwrap()).sum()
}

#[test]
fn replayed_histories_add_up_to_the_run() {
    let dir = place();
    let lp = |arguments: &[&str]| {
        let done = lightpro(dir.path()).args(arguments).output().unwrap();
        well(&done);
        text(&done.stdout)
    };
    lp(&["run", "scene.xml", "--quiet", "--histories", "40", "-o", "r"]);
    let json = std::fs::read_to_string(dir.path().join("r/result.json")).unwrap();
    let result = RunResult::from_json(&json).unwrap();
    for nm in [450.0, 650.0] {
        let mut sum = 0.0;
        for n in 0..40 {
            let said = lp(&["replay", "r", "--history", &n.to_string(), "--wavelength", &nm.to_string()]);
            assert!(said.trim_end().ends_with("sum 1"), "the ledger closes: {said}");
            sum +=
                reflected(&std::fs::read_to_string(dir.path().join(format!("r/history-{n}.csv"))).unwrap());
        }
        let figure = result.figure("reflectance", Some(nm)).unwrap().value.unwrap();
        assert_eq!(sum / 40.0, figure, "{nm} nm");
    }
    // The scene alone gives the same path as the run's folder.
    let from_run = lp(&["replay", "r", "--history", "7"]);
    assert_eq!(from_run, lp(&["replay", "scene.xml", "--history", "7", "-o", "."]));
    let read = |path: &str| std::fs::read_to_string(dir.path().join(path)).unwrap();
    for ending in ["txt", "csv", "vtp"] {
        assert_eq!(read(&format!("r/history-7.{ending}")), read(&format!("history-7.{ending}")));
    }
    assert_eq!(read("history-7.txt"), from_run);
    // As many lines as flights, two points each.
    let flights = read("history-7.csv").lines().filter(|l| l.contains(",flight,")).count();
    let vtp = read("history-7.vtp");
    assert!(vtp.contains(&format!("NumberOfPoints=\"{}\"", 2 * flights)) && flights > 1, "{vtp}");
    let refused = lightpro(dir.path()).args(["replay", "r", "--history", "40"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    let refused = lightpro(dir.path()).args(["replay", "r", "--history", "1", "--wavelength", "9"]).output();
    assert!(text(&refused.unwrap().stderr).contains("450, 650"));
}
