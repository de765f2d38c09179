//! The same sheet in other universes: one attribute of the scene changes.

use crate::scene::{Depositing, Edges, Memory, Realised, Scene, StatisticalSheet, Universe};
use std::fmt;
use std::path::PathBuf;

/// How sheets are laid down where the scene does not say: the defaults of <realise model="deposited">.
const DEPOSITING: Depositing =
    Depositing { flexibility: 0.5, pressing: None, places: 16, cell: 1000.0, realisations: 8, gap: 0.5 };

/// The sheet with its amounts after overlaps, as explicit bodies and full memory count them: rungs that
/// forget need other densities for the same mass.
fn explicit(sheet: &StatisticalSheet) -> StatisticalSheet {
    StatisticalSheet { memory: Memory::Full, ..sheet.clone() }
}

/// A universe to run a sheet in.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// As the scene says.
    Written,
    /// Statistical (or a mixture), with this memory.
    Rung(Memory),
    /// Explicit realisations of the Boolean ensemble.
    Boolean,
    /// Explicit sheets of fibres laid down one by one, as the scene's <realise> says or with its defaults.
    Deposited,
    /// One realisation body by body in a periodic cell, as `realise` writes it; a scene of its own, which the
    /// caller makes.
    Bodies,
    /// The same realisation as labelled voxels.
    Voxels,
    /// Another scene.
    Other(PathBuf),
}

impl Entry {
    /// `scene`, `homogeneous`, `markov`, `none`, a number of flights, `full`, `boolean`, `deposited`, `bodies`
    /// or `voxels`.
    ///
    /// # Errors
    /// What is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        Ok(match text.trim() {
            "scene" => Entry::Written,
            "homogeneous" => Entry::Rung(Memory::Homogeneous),
            "markov" => Entry::Rung(Memory::Markov),
            "none" => Entry::Rung(Memory::None),
            "full" => Entry::Rung(Memory::Full),
            "boolean" => Entry::Boolean,
            "deposited" => Entry::Deposited,
            "bodies" => Entry::Bodies,
            "voxels" => Entry::Voxels,
            k => match k.parse::<u32>() {
                Ok(k) if (1..=1000).contains(&k) => Entry::Rung(Memory::Last(k)),
                _ => {
                    return Err(format!(
                        "no universe `{k}`: scene, homogeneous, markov, none, 1, 2, 4 …, full, boolean, deposited, bodies, \
                         voxels"
                    ));
                }
            },
        })
    }

    /// All that a scene may be compared in: every rung, and realisations.
    pub fn all(scene: &Scene) -> Vec<Entry> {
        let rungs = [Memory::Homogeneous, Memory::Markov, Memory::None, Memory::Last(1), Memory::Full];
        let mut out: Vec<Entry> = rungs.into_iter().map(Entry::Rung).collect();
        match scene.universe {
            Universe::Statistical(_) | Universe::Realised(_) => out.push(Entry::Boolean),
            Universe::Mixture(_) => {}
            Universe::Synthetic(_) | Universe::Voxel(_) => out = vec![Entry::Written],
        }
        out
    }

    /// The scene in this universe; expected values, which belong to the scene as written, are dropped.
    /// (Another scene is read by the caller.)
    ///
    /// # Errors
    /// A scene that is not known by statistics.
    pub fn of(&self, scene: &Scene) -> Result<Scene, String> {
        let mut out = scene.clone();
        out.expects.clear();
        let only = || format!("`{self}` needs a sheet that is known by its statistics");
        match self {
            Entry::Written | Entry::Other(_) => {}
            Entry::Bodies | Entry::Voxels => {
                return Err(format!("`{self}` is one realisation in files of its own: `lightpro realise`"));
            }
            Entry::Rung(memory) => match &scene.universe {
                Universe::Mixture(m) => {
                    out.universe = Universe::Mixture(crate::scene::Mixture { memory: *memory, ..m.clone() });
                }
                other => {
                    let mut sheet = other.sheet().ok_or_else(only)?.clone();
                    sheet.memory = *memory;
                    out.universe = Universe::Statistical(sheet);
                }
            },
            Entry::Boolean => {
                let spread = match &scene.universe {
                    Universe::Realised(r) => r.spread,
                    _ => None,
                };
                let sheet = explicit(scene.universe.sheet().ok_or_else(only)?);
                out.universe = Universe::Realised(Realised { sheet, spread, deposit: None });
            }
            Entry::Deposited => {
                let sheet = explicit(scene.universe.sheet().ok_or_else(only)?);
                if sheet.edges == Edges::Cut {
                    return Err("a deposited sheet is not cut: it has its own faces".to_owned());
                }
                let deposit = match &scene.universe {
                    Universe::Realised(Realised { deposit: Some(d), .. }) => *d,
                    _ => DEPOSITING,
                };
                out.universe = Universe::Realised(Realised { sheet, spread: None, deposit: Some(deposit) });
            }
        }
        Ok(out)
    }

    /// What the mean over its histories is exact for.
    pub fn exact(&self) -> bool {
        matches!(self, Entry::Boolean | Entry::Rung(Memory::Full))
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Entry::Written => f.write_str("scene"),
            Entry::Rung(Memory::Homogeneous) => f.write_str("homogeneous"),
            Entry::Rung(Memory::Markov) => f.write_str("markov"),
            Entry::Rung(Memory::None) => f.write_str("none"),
            Entry::Rung(Memory::Full) => f.write_str("full"),
            Entry::Rung(Memory::Last(k)) => write!(f, "{k}"),
            Entry::Boolean => f.write_str("boolean"),
            Entry::Deposited => f.write_str("deposited"),
            Entry::Bodies => f.write_str("bodies"),
            Entry::Voxels => f.write_str("voxels"),
            Entry::Other(path) => {
                write!(
                    f,
                    "{}",
                    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_and_written() {
        let words = "scene homogeneous markov none full boolean deposited bodies voxels 1 8";
        for word in words.split(' ') {
            assert_eq!(Entry::parse(word).unwrap().to_string(), word);
        }
        for bad in ["", "0", "-1", "half", "1e9"] {
            assert!(Entry::parse(bad).is_err(), "{bad}");
        }
    }
}
