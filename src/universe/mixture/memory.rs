//! What a branch knows of the layers around it.
//!
//! The layers that a history has met are a stretch of depth without gaps, with the ray somewhere in it.
//! They are kept like beads on a string held between two fingers: the layer of the ray in the [`Known`]
//! itself, and from there one list of layers upwards and one downwards, nearest first. The lists are
//! linked nodes in an arena that is only ever appended to, never changed, so a copy of a [`Known`] keeps
//! its own string whatever its siblings find later, and crossing a plane is one step: the layer left
//! goes in front of one list, the layer entered comes off the other.
//!
//! A list is its head and its length: dropping the far end of the string, for rungs that remember the
//! last k layers, is a shorter length.

/// A plane between two layers, seen from the layer that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Height, µm.
    pub z: f64,
    /// Phase on the other side.
    pub beyond: u16,
}

/// A layer known in part or whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Layer {
    /// Its phase.
    pub phase: u16,
    /// Its upper plane, once drawn.
    pub up: Option<Plane>,
    /// Its lower plane, once drawn.
    pub down: Option<Plane>,
}

/// A layer in a list: its near plane is the far one of the layer before it.
#[derive(Clone, Copy, Debug)]
struct Node {
    far: Option<Plane>,
    next: u32,
}

/// Arena of layers met in a history.
#[derive(Debug, Default)]
pub struct Memory {
    nodes: Vec<Node>,
    /// Raised whenever the nodes are cleared: lists of before are known by it, and are empty.
    epoch: u64,
}

impl Memory {
    /// Clears the arena; nothing is freed. Branches that still wait keep the layer that they are in, and
    /// lose those beyond it.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.epoch += 1;
    }

    fn push(&mut self, far: Option<Plane>, rest: List) -> List {
        // More than 2³² layers: none of those beyond is kept.
        let Ok(head) = u32::try_from(self.nodes.len()) else { return List::EMPTY };
        self.nodes.push(Node { far, next: rest.head });
        List { head, len: rest.len + 1 }
    }

    fn pop(&self, list: List) -> Option<(Option<Plane>, List)> {
        if list.len == 0 {
            return None;
        }
        let node = self.nodes.get(list.head as usize)?;
        Some((node.far, List { head: node.next, len: list.len - 1 }))
    }
}

/// Layers on one side, nearest first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct List {
    head: u32,
    len: u32,
}

impl List {
    const EMPTY: List = List { head: 0, len: 0 };
}

/// What a branch knows: the layer that it is in, and layers above and below.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// The layer that the ray is in.
    pub layer: Layer,
    above: List,
    below: List,
    epoch: u64,
}

impl Known {
    /// Only this layer.
    pub fn only(layer: Layer, memory: &Memory) -> Self {
        Known { layer, above: List::EMPTY, below: List::EMPTY, epoch: memory.epoch }
    }

    /// Layers known, that of the ray counted.
    pub fn count(&self) -> u32 {
        1 + self.above.len + self.below.len
    }

    /// The ray crosses the upper (or lower) plane of its layer; at most `most` ≥ 1 layers stay known,
    /// those met last.
    pub fn cross(&mut self, upwards: bool, most: u32, memory: &mut Memory) {
        if self.epoch != memory.epoch {
            (self.above, self.below, self.epoch) = (List::EMPTY, List::EMPTY, memory.epoch);
        }
        let Layer { phase, up, down } = self.layer;
        let (met, left, ahead, behind) = if upwards {
            (up, down, &mut self.above, &mut self.below)
        } else {
            (down, up, &mut self.below, &mut self.above)
        };
        let Some(met) = met else { return };
        *behind = if most > 1 { memory.push(left, *behind) } else { List::EMPTY };
        let far = match memory.pop(*ahead) {
            Some((far, rest)) => {
                *ahead = rest;
                far
            }
            None => {
                // A new layer: the string grows at this end and is cut at the other.
                *ahead = List::EMPTY;
                behind.len = behind.len.min(most - 1);
                None
            }
        };
        let near = Some(Plane { z: met.z, beyond: phase });
        let (up, down) = if upwards { (far, near) } else { (near, far) };
        self.layer = Layer { phase: met.beyond, up, down };
    }
}
