//! Which media a run knows: those of the scene, one for each component of a sheet (so that tallies can
//! tell two components of one material apart), and averages.

use crate::universe::MediumId;

/// Where a medium's optical constants come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Origin {
    /// A material of the scene, by index.
    Material(usize),
    /// Volume average over materials: (index, share).
    Average(Vec<(usize, f64)>),
}

/// All media of a run; [`MediumId`] indexes both lists.
#[derive(Clone, Debug)]
pub struct Media {
    /// Names for tallies.
    pub names: Vec<String>,
    /// Origins.
    pub origins: Vec<Origin>,
}

impl Media {
    /// The scene's own materials.
    pub fn of(materials: impl Iterator<Item = String>) -> Self {
        let names: Vec<String> = materials.collect();
        let origins = (0..names.len()).map(Origin::Material).collect();
        Media { names, origins }
    }

    /// A component's own medium.
    pub fn component(&mut self, name: &str, material: usize) -> MediumId {
        self.push(name, Origin::Material(material))
    }

    /// A volume average.
    pub fn average(&mut self, name: &str, parts: Vec<(usize, f64)>) -> MediumId {
        self.push(name, Origin::Average(parts))
    }

    fn push(&mut self, name: &str, origin: Origin) -> MediumId {
        // Names stay unique: figures and columns go by them.
        let mut unique = name.to_owned();
        let mut n = 2;
        while self.names.contains(&unique) {
            unique = format!("{name} {n}");
            n += 1;
        }
        self.names.push(unique);
        self.origins.push(origin);
        MediumId(self.names.len() as u16 - 1)
    }
}
