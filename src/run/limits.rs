//! What a run will need, checked before it starts.

use super::{BATCH, checkpoint, simulate};
use crate::lpm::LANES;
use crate::scene::Scene;
use crate::scene::plan::Plan;
use std::time::Duration;

/// Need of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Bytes of memory, beside what the process holds already (the universe is built).
    pub memory: u64,
    /// Bytes on the disk: two checkpoints (the old one stays until the new one is whole), tables and plots.
    pub disk: u64,
}

/// Tables and plots of a run, generously.
const TABLES: u64 = 32 << 20;

/// Estimates the need of `batches` batches on so many threads.
///
/// # Errors
/// Detectors that cannot be made.
pub fn need(scene: &Scene, plan: &Plan, histories: u64, threads: u64) -> Result<Need, String> {
    let batches = histories.div_ceil(BATCH);
    let (mut sums, mut waiting, mut tally) = (0_u64, 0_u64, 0_u64);
    for group in &plan.groups {
        let layout = simulate::layout(scene, plan, group)?;
        let cells = layout.cells() as u64;
        let lanes = group.len() as u64;
        let width = if group.len() == 1 { 1 } else { LANES as u64 };
        sums += checkpoint::bytes_of(cells * lanes, batches);
        waiting += cells * lanes * 40;
        tally = tally.max(cells * (width * 40 + 12));
    }
    // Sums once in the folds, once more while a checkpoint is packed and once while results are made.
    Ok(Need { memory: 3 * sums + 2 * waiting + threads * tally, disk: 2 * sums + TABLES })
}

/// Resident memory of this process in bytes, where the system tells.
pub fn resident() -> Option<u64> {
    field(&std::fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// Memory that the machine can still give, in bytes, where it tells.
pub fn available() -> Option<u64> {
    field(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")
}

/// `name   1234 kB` in bytes.
fn field(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find(|l| l.starts_with(name))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok()?.checked_mul(1024)
}

/// A time: `90s`, `10m`, `2h`, `1d`, `200ms`, with or without space.
///
/// # Errors
/// What is expected.
pub fn duration(text: &str) -> Result<Duration, String> {
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("min", 60.0), ("h", 3600.0), ("d", 86400.0)];
    let x = measured(text, &units).ok_or("expected a time such as 90s, 10m, 2h or 1d")?;
    Duration::try_from_secs_f64(x).map_err(|e| e.to_string())
}

/// A size of memory: `500MB`, `8GiB`.
///
/// # Errors
/// What is expected.
pub fn size(text: &str) -> Result<u64, String> {
    let units = [
        ("B", 1.0),
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("TB", 1e12),
        ("KiB", 1024.0),
        ("MiB", 1_048_576.0),
        ("GiB", 1_073_741_824.0),
        ("TiB", 1_099_511_627_776.0),
    ];
    let x = measured(text, &units).filter(|x| *x < 1e18);
    x.map(|x| x as u64).ok_or_else(|| "expected a size such as 500MB or 8GiB".to_owned())
}

fn measured(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let text = text.trim();
    let split = text.find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E')?;
    let (number, unit) = text.split_at(split);
    let (_, factor) = units.iter().find(|(u, _)| u.eq_ignore_ascii_case(unit))?;
    let x: f64 = number.trim().parse().ok()?;
    (x.is_finite() && x >= 0.0).then_some(x * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_sizes_need_their_units() {
        assert_eq!(duration("10m"), Ok(Duration::from_secs(600)));
        assert_eq!(duration("1.5 h"), Ok(Duration::from_secs(5400)));
        assert_eq!(duration("200ms"), Ok(Duration::from_millis(200)));
        assert_eq!(size("8GiB"), Ok(8 << 30));
        assert_eq!(size("1e3 MB"), Ok(1_000_000_000));
        for bad in ["", "10", "m", "-1s", "nan s", "inf s", "10 parsecs", "1e999 s"] {
            assert!(duration(bad).is_err() && size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn system_files_are_read_as_they_are_written() {
        assert_eq!(field("VmPeak: 9 kB\nVmRSS:\t    1234 kB\n", "VmRSS:"), Some(1_263_616));
        assert_eq!(field("VmRSS: many kB\n", "VmRSS:"), None);
    }
}
