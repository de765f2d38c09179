//! The voxel universe: a labelled volume from a file.

use super::{Node, Reading};
use crate::scene::diagnostic::Diagnostic;
use crate::scene::document::Attribute;
use crate::scene::model::{Universe, Voxels};
use crate::universe::MediumId;
use crate::universe::voxel::read::{self, Labels};
use crate::universe::voxel::{Lateral, NormalRule, Phase, Rules, Steps, Volume};
use std::sync::Arc;

impl Reading<'_> {
    pub fn voxels(&mut self, e: Node<'_>) -> Option<Universe> {
        let outside = self.outside(e);
        let Some(own) = e.child("volume") else {
            if !e.own.misspelt.get() {
                let d = Diagnostic::error(e.own.place, "a voxel universe needs a <volume>");
                self.out.push(
                    d.help("as <volume file=\"stack.tif\" voxel=\"1 um\">, with a <label> for each value"),
                );
            }
            return None;
        };
        let (phases, labels) = self.labels(own);
        let edge = self.edges(own);
        let normals = self.normals(own);
        let mut rules = Rules {
            edge: edge.unwrap_or([1.0; 3]),
            lateral: if own.text("lateral") == Some("periodic") {
                Lateral::Periodic
            } else {
                Lateral::Mirror
            },
            normals,
            steps: if normals != NormalRule::Faces && own.text("steps") == Some("mirrored") {
                Steps::Mirrored
            } else {
                Steps::Passed
            },
            anywhere: true,
            outside,
        };
        let random = own.text("position").map(|p| p == "random");
        let most = own.count("max-voxels").unwrap_or(u64::MAX);
        let first_on_top = own.text("top") == Some("first");
        let file = own.attribute("file");
        // Nothing is read for a scene that is refused anyway.
        if self.out.error_count() > 0 || edge.is_none() {
            return None;
        }
        let mut volume = self.volume(file?, &labels, first_on_top, most)?;
        let coarser = own.count("coarser").unwrap_or(1);
        if coarser > 1 {
            match volume.coarser(coarser as usize) {
                Ok((large, times)) => {
                    volume = large;
                    rules.edge = std::array::from_fn(|k| rules.edge[k] * times[k]);
                }
                Err(e) => {
                    self.error(own.place("coarser"), e.to_string());
                    return None;
                }
            }
        }
        Some(Universe::Voxel(Voxels { volume: Arc::new(volume), phases, rules, random }))
    }

    fn edges(&mut self, own: Node<'_>) -> Option<[f64; 3]> {
        let list = own.list("voxel")?;
        match list[..] {
            [h] => Some([h; 3]),
            [x, y, z] => Some([x, y, z]),
            _ => {
                let message = format!("expected one or three edges, found {}", list.len());
                let d = Diagnostic::error(own.place("voxel"), message);
                self.out.push(d.help("as \"1 um\", or \"1 1 2 um\" for x, y and z"));
                None
            }
        }
    }

    fn normals(&mut self, own: Node<'_>) -> NormalRule {
        if own.text("normals") == Some("faces") {
            let d = Diagnostic::warning(own.place("normals"), "voxel faces as normals never converge");
            self.out.push(
                d.label("some 50 deg off, at any voxel size")
                    .help("normals=\"smoothed\", unless the bodies are boxes along the axes"),
            );
            return NormalRule::Faces;
        }
        NormalRule::Smoothed(own.number("smoothing").unwrap_or(2.0))
    }

    /// Phases (one for each pair of material and surface) and which label is which.
    fn labels(&mut self, own: Node<'_>) -> (Vec<Phase>, Labels) {
        let mut phases: Vec<Phase> = Vec::new();
        let mut ranges = Vec::new();
        for label in own.children("label") {
            let phase = Phase {
                medium: self.material(label, "material").unwrap_or(MediumId(0)),
                surface: self.surface_id(label, "surface"),
            };
            let number = phases.iter().position(|p| *p == phase).unwrap_or_else(|| {
                phases.push(phase);
                phases.len() - 1
            });
            let whole = |name: &str| label.text(name).and_then(|v| v.parse::<i64>().ok());
            let Some(first) = whole("value") else { continue };
            let last = whole("to").unwrap_or(first);
            if last < first {
                self.error(label.place("to"), format!("the range {first} to {last} holds no label"));
            }
            ranges.push((first, last, u8::try_from(number).unwrap_or(u8::MAX)));
        }
        if phases.len() > 255 {
            self.error(own.own.place, "more than 255 pairs of material and surface");
        }
        match Labels::new(ranges) {
            Ok(labels) => (phases, labels),
            Err(twice) => {
                let d = Diagnostic::error(own.own.place, format!("the label {twice} stands twice"));
                self.out.push(d.help("ranges of labels must not overlap"));
                (phases, Labels::default())
            }
        }
    }

    fn volume(&mut self, a: &Attribute, labels: &Labels, first_on_top: bool, most: u64) -> Option<Volume> {
        let (path, full) = self.located(a)?;
        let found = read::open(&full).and_then(|source| {
            // What a header names must lie where files may come from, too.
            let data = (source.data != full).then(|| source.data.clone());
            if let Some(data) = data {
                let Some((_, data_full)) = self.allowed(a, data) else { return Ok(None) };
                let volume = source.load(labels, first_on_top, most)?;
                let _ = self.note_file(&data_full);
                return Ok(Some(volume));
            }
            source.load(labels, first_on_top, most).map(Some)
        });
        match found {
            Ok(volume) => {
                let _ = self.note_file(&path);
                volume
            }
            Err(e) => {
                let d = Diagnostic::error(a.value_place, e.to_string());
                self.out.push(d.help(e.help));
                None
            }
        }
    }
}
