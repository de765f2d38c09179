//! `manifest.json`: all that is needed to repeat a run, and what the run cost.

use super::result::{EffectUsed, Ordered};
use crate::run::Health;
use serde::{Deserialize, Serialize};

/// The machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Host {
    /// Operating system.
    pub os: String,
    /// Instruction set.
    pub arch: String,
    /// Model of the processor, where the system tells.
    pub cpu: Option<String>,
    /// Number of logical processors.
    pub cores: u64,
}

impl Host {
    /// This machine.
    pub fn here() -> Host {
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
        let cpu = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| cpu_model(&text));
        Host { os: std::env::consts::OS.into(), arch: std::env::consts::ARCH.into(), cpu, cores }
    }
}

/// Value of the first line `model name : …`.
fn cpu_model(cpuinfo: &str) -> Option<String> {
    let line = cpuinfo.lines().find(|l| l.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Largest resident memory of this process so far in bytes, where the system tells.
pub fn peak_memory_bytes() -> Option<u64> {
    vm_hwm(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// `VmHWM: 1234 kB` in bytes.
fn vm_hwm(status: &str) -> Option<u64> {
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

/// A file that the run read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// Path as the scene names it.
    pub path: String,
    /// Hash of the content, with the name of its algorithm, e.g. `sha256:…`.
    pub hash: String,
}

/// Everything in `manifest.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the program.
    pub lightpro: String,
    /// The command as typed.
    pub command_line: Vec<String>,
    /// The scene as understood: all defaults filled in, all units written.
    pub scene: serde_json::Value,
    /// Files read, in the order of reading.
    pub files: Vec<InputFile>,
    /// Seed of the random streams.
    pub seed: u64,
    /// Effects: name → used or not, and why.
    pub effects: Ordered<EffectUsed>,
    /// The machine.
    pub host: Host,
    /// Counters of lost and capped histories, with their numbers for `lightpro replay`.
    #[serde(default)]
    pub health: Health,
    /// Threads that ran histories (the result does not depend on it).
    pub threads: u64,
    /// Processor time in s, over all threads.
    pub cpu_seconds: f64,
    /// Time on the clock in s.
    pub wall_seconds: f64,
    /// Largest resident memory in bytes, where the system tells.
    pub peak_memory_bytes: Option<u64>,
}

impl Manifest {
    /// Text of `manifest.json`.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("plain data is always JSON");
        text.push('\n');
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manifests_survive_the_round_trip() {
        let manifest = Manifest {
            lightpro: "0.1.0".into(),
            command_line: vec!["lightpro".into(), "run".into(), "a b.xml".into()],
            scene: serde_json::json!({"name": "x", "thickness_um": 100.0}),
            files: vec![InputFile { path: "wall.csv".into(), hash: "sha256:00".into() }],
            seed: u64::MAX,
            effects: Ordered(vec![("dispersion".into(), EffectUsed { on: true, why: "line 4".into() })]),
            host: Host::here(),
            health: Health::default(),
            threads: 2,
            cpu_seconds: 1.5,
            wall_seconds: 0.8,
            peak_memory_bytes: peak_memory_bytes(),
        };
        let back: Manifest = serde_json::from_str(&manifest.to_json()).unwrap();
        assert_eq!(back, manifest);
        assert!(manifest.host.cores >= 1 && !manifest.host.os.is_empty());
    }

    #[test]
    fn system_files_are_read_as_they_are_written() {
        assert_eq!(cpu_model("processor\t: 0\nmodel name\t: A B @ 2 GHz\n"), Some("A B @ 2 GHz".into()));
        assert_eq!(cpu_model(""), None);
        assert_eq!(vm_hwm("VmPeak:\t 9 kB\nVmHWM:\t    1234 kB\n"), Some(1_263_616));
        assert_eq!(vm_hwm("VmHWM:\t many kB\n"), None);
    }
}
