//! The file `checkpoint` of a results folder: the sums of a run so far, as the nodes of their fold, and
//! what the run is, so that it can be taken up again or merged with other shards to the same bytes.
//!
//! Layout, little-endian: `LPCHECK` and the version of the format (1 byte), length of the packed
//! payload (u64), its FNV-1a hash (u64), length of the payload (u64), the payload packed by zlib.

#![cfg_attr(not(test), warn(clippy::indexing_slicing))]

use super::BATCH;
use super::simulate::State;
use super::sums::{Fate, RECORDS, Sums, Troubled};
use crate::scene::Scene;
use crate::stats;
use crate::tally::Node;
use crate::universe::Kept;
use flate2::{Compression, read::ZlibDecoder, write::ZlibEncoder};
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::ops::Range;
use std::path::PathBuf;

const MAGIC: &[u8; 7] = b"LPCHECK";
const VERSION: u8 = 4;

/// What a run is: two parts with the same identity (but for their ranges) are parts of one run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Version of the program.
    pub lightpro: String,
    /// The scene file, absolute.
    pub scene: PathBuf,
    /// `-D name=value`.
    pub defines: Vec<(String, String)>,
    /// Files outside the scene's folder may be read.
    pub allow_outside: bool,
    /// `--effect name=on|off:reason`.
    pub effects: Vec<String>,
    /// Names and hashes of all files that the scene is made of.
    pub files: Vec<(String, u64)>,
    /// Seed.
    pub seed: u64,
    /// Histories per wavelength group of the whole run.
    pub histories: u64,
    /// Histories of this part.
    pub range: Range<u64>,
    /// `--target figure:error`: the run may end before its last history.
    pub targets: Vec<String>,
}

impl Identity {
    /// Of a scene (with its overrides) and the part of its histories to run.
    pub fn of(
        scene: &Scene,
        defines: &[(String, String)],
        allow_outside: bool,
        range: Range<u64>,
    ) -> Identity {
        let path = std::path::absolute(&scene.path).unwrap_or_else(|_| scene.path.clone());
        let file = |(path, hash): &(PathBuf, u64)| {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
            (name.unwrap_or_default(), *hash)
        };
        Identity {
            lightpro: env!("CARGO_PKG_VERSION").to_owned(),
            scene: path,
            defines: defines.to_vec(),
            allow_outside,
            effects: scene.overrides.iter().filter(|o| o.flag).map(ToString::to_string).collect(),
            files: scene.files.iter().map(file).collect(),
            seed: scene.run.seed,
            histories: scene.run.histories,
            range,
            targets: Vec::new(),
        }
    }

    /// The same with stopping rules.
    pub fn with_targets(mut self, targets: Vec<String>) -> Identity {
        self.targets = targets;
        self
    }

    /// Why a part of `self` is no part of the run `other`; `None` where it is one. Ranges and the scene's
    /// place do not matter.
    pub fn differs(&self, other: &Identity) -> Option<String> {
        if self.lightpro != other.lightpro {
            return Some(format!("made by version {}, not {}", self.lightpro, other.lightpro));
        }
        if self.defines != other.defines {
            return Some("other -D values".to_owned());
        }
        if self.effects != other.effects {
            return Some("other effects forced".to_owned());
        }
        if self.targets != other.targets {
            return Some("other targets".to_owned());
        }
        if let Some((f, _)) = self.files.iter().zip(&other.files).find(|(a, b)| a.1 != b.1) {
            return Some(format!("the file {} has changed", f.0));
        }
        if self.files.len() != other.files.len() {
            return Some("the scene is made of other files".to_owned());
        }
        if (self.seed, self.histories) != (other.seed, other.histories) {
            let of = |i: &Identity| format!("{} histories of seed {}", i.histories, i.seed);
            return Some(format!("{}, not {}", of(self), of(other)));
        }
        None
    }
}

/// A run so far.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    /// What it is.
    pub identity: Identity,
    /// Sums.
    pub state: State,
}

/// FNV-1a, 64 bits.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

/// The bytes of a checkpoint file.
pub fn to_bytes(identity: &Identity, state: &[stats::Fold<Sums>]) -> Vec<u8> {
    let mut payload = Writer(Vec::new());
    payload.identity(identity);
    payload.number(state.len() as u64);
    for fold in state {
        payload.number(fold.next());
        payload.number(fold.nodes().len() as u64);
        fold.nodes().iter().for_each(|n| payload.node(n));
    }
    let payload = payload.0;
    let mut packer = ZlibEncoder::new(Vec::new(), Compression::fast());
    // Writing into memory does not fail.
    let packed = packer.write_all(&payload).and_then(|()| packer.finish()).unwrap_or_default();
    let mut out = Vec::with_capacity(packed.len() + 32);
    out.extend_from_slice(MAGIC);
    out.push(VERSION);
    for number in [packed.len() as u64, hash(&packed), payload.len() as u64] {
        out.extend_from_slice(&number.to_le_bytes());
    }
    out.extend_from_slice(&packed);
    out
}

/// Reads what [`to_bytes`] wrote.
///
/// # Errors
/// What is wrong with the file: no checkpoint, another version of the format, cut short, damaged.
pub fn from_bytes(bytes: &[u8]) -> Result<Checkpoint, String> {
    let mut head = Reader(bytes);
    if head.take(MAGIC.len()).ok() != Some(MAGIC) {
        return Err("not a checkpoint".to_owned());
    }
    let version = head.take(1)?.first().copied().unwrap_or_default();
    if version != VERSION {
        return Err(format!("format {version} of another version of the program (this one reads {VERSION})"));
    }
    let (packed_len, expected, len) = (head.number()?, head.number()?, head.number()?);
    if head.0.len() as u64 != packed_len {
        return Err(format!("{} bytes where {packed_len} should be", head.0.len()));
    }
    if hash(head.0) != expected {
        return Err("damaged: its checksum is wrong".to_owned());
    }
    // No more than zlib can pack into so many bytes.
    if len > packed_len.saturating_mul(1032) + 64 {
        return Err("damaged: its length is impossible".to_owned());
    }
    let mut payload = Vec::new();
    let read = ZlibDecoder::new(head.0).take(len + 1).read_to_end(&mut payload);
    if read.is_err() || payload.len() as u64 != len {
        return Err("damaged: it does not unpack".to_owned());
    }
    decode(&payload)
}

/// Reads an unpacked payload.
///
/// # Errors
/// What is wrong with it.
pub fn decode(payload: &[u8]) -> Result<Checkpoint, String> {
    let mut r = Reader(payload);
    let identity = r.identity()?;
    let aligned = identity.range.start.is_multiple_of(BATCH)
        && identity.range.start < identity.range.end
        && identity.range.end <= identity.histories;
    let groups = r.count(16)?;
    let mut state = State::new();
    for _ in 0..groups {
        let (next, nodes) = (r.number()?, r.count(16)?);
        let mut fold = stats::Fold::starting_at(identity.range.start / BATCH);
        for _ in 0..nodes {
            let node = r.node()?;
            let same = |n: &stats::Node<Sums>| n.value.node.sums.len() == node.value.node.sums.len();
            // Past the end of the range there is nothing; this also bounds the index.
            let end = node.first.checked_add(1u64.checked_shl(node.level).unwrap_or(0));
            let inside = end.is_some_and(|e| e <= identity.range.end.div_ceil(BATCH) && e > node.first);
            if !fold.nodes().iter().all(same) || !inside || fold.push_node(node).is_err() {
                return Err("damaged: its sums do not follow each other".to_owned());
            }
        }
        if fold.next() != next {
            return Err("damaged: sums are missing".to_owned());
        }
        state.push(fold);
    }
    if !aligned || !r.0.is_empty() || state.windows(2).any(|w| matches!(w, [a, b] if a.next() != b.next())) {
        return Err("damaged: its parts contradict each other".to_owned());
    }
    Ok(Checkpoint { identity, state })
}

/// Bytes of the payload of one group's sums of `cells` (lanes included) after `batches` batches, at most.
pub fn bytes_of(cells: u64, batches: u64) -> u64 {
    let levels = u64::from(64 - batches.leading_zeros());
    let replicas: u64 = (0..levels).map(|l| 1u64 << l.min(5)).sum();
    cells * 8 * (4 * levels + replicas)
}

struct Writer(Vec<u8>);

impl Writer {
    fn number(&mut self, n: u64) {
        self.0.extend_from_slice(&n.to_le_bytes());
    }
    fn float(&mut self, x: f64) {
        self.number(x.to_bits());
    }
    fn text(&mut self, t: &str) {
        self.number(t.len() as u64);
        self.0.extend_from_slice(t.as_bytes());
    }
    fn identity(&mut self, i: &Identity) {
        self.text(&i.lightpro);
        self.text(&i.scene.to_string_lossy());
        self.number(i.defines.len() as u64);
        for (name, value) in &i.defines {
            self.text(name);
            self.text(value);
        }
        self.number(u64::from(i.allow_outside));
        self.number(i.effects.len() as u64);
        i.effects.iter().for_each(|e| self.text(e));
        self.number(i.files.len() as u64);
        for (name, hash) in &i.files {
            self.text(name);
            self.number(*hash);
        }
        [i.seed, i.histories, i.range.start, i.range.end].into_iter().for_each(|n| self.number(n));
        self.number(i.targets.len() as u64);
        i.targets.iter().for_each(|t| self.text(t));
    }
    fn node(&mut self, n: &stats::Node<Sums>) {
        self.number(n.first);
        self.number(u64::from(n.level));
        // Every field by name: a new one that is not stored does not compile.
        let Sums { node, troubled } = &n.value;
        let Node {
            histories,
            batches,
            events,
            worst_imbalance,
            lost,
            capped,
            samples,
            single,
            kept: Kept { bodies, segments, bytes, pockets, steps, forced },
            sums,
            replicas,
        } = node;
        let kept = [bodies, segments, bytes, pockets, steps, forced];
        let counters = [histories, batches, events, lost, capped, samples].into_iter().chain(kept);
        counters.for_each(|n| self.number(*n));
        self.float(*worst_imbalance);
        self.number(single.len() as u64);
        single.iter().flatten().for_each(|x| self.float(*x));
        self.number(sums.len() as u64);
        sums.iter().flatten().for_each(|x| self.float(*x));
        self.number(replicas.len() as u64);
        for (replica, (samples, sums)) in replicas {
            self.number(u64::from(*replica));
            self.number(*samples);
            sums.iter().for_each(|x| self.float(*x));
        }
        self.number(troubled.len() as u64);
        for t in troubled {
            self.number(t.history);
            self.number(match t.fate {
                Fate::Lost => 0,
                Fate::Capped => 1,
            });
        }
    }
}

/// What is left to read.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (head, rest) = self.0.split_at_checked(n).ok_or("cut short")?;
        self.0 = rest;
        Ok(head)
    }
    fn number(&mut self) -> Result<u64, String> {
        let bytes = self.take(8)?.try_into().map_err(|_| "cut short".to_owned())?;
        Ok(u64::from_le_bytes(bytes))
    }
    /// A counter: sums of all that a file can hold stay within their range.
    fn counter(&mut self) -> Result<u64, String> {
        self.number().and_then(|n| {
            if n < 1 << 48 { Ok(n) } else { Err("damaged: a counter is impossible".to_owned()) }
        })
    }
    /// A number of things of at least `size` bytes each: not more than are left.
    fn count(&mut self, size: usize) -> Result<usize, String> {
        let n = usize::try_from(self.number()?).unwrap_or(usize::MAX);
        if n > self.0.len() / size { Err("damaged: a length beyond its end".to_owned()) } else { Ok(n) }
    }
    fn float(&mut self) -> Result<f64, String> {
        self.number().map(f64::from_bits)
    }
    fn floats<const K: usize>(&mut self) -> Result<[f64; K], String> {
        let mut out = [0.0; K];
        for x in &mut out {
            *x = self.float()?;
        }
        Ok(out)
    }
    fn text(&mut self) -> Result<String, String> {
        let n = self.count(1)?;
        String::from_utf8(self.take(n)?.to_vec()).map_err(|_| "damaged: a text is no text".to_owned())
    }
    fn list<T>(
        &mut self,
        size: usize,
        mut each: impl FnMut(&mut Self) -> Result<T, String>,
    ) -> Result<Vec<T>, String> {
        (0..self.count(size)?).map(|_| each(self)).collect()
    }
    fn identity(&mut self) -> Result<Identity, String> {
        Ok(Identity {
            lightpro: self.text()?,
            scene: PathBuf::from(self.text()?),
            defines: self.list(16, |r| Ok((r.text()?, r.text()?)))?,
            allow_outside: self.number()? != 0,
            effects: self.list(8, Self::text)?,
            files: self.list(16, |r| Ok((r.text()?, r.number()?)))?,
            seed: self.number()?,
            histories: self.number()?,
            range: self.number()?..self.number()?,
            targets: self.list(8, Self::text)?,
        })
    }
    fn node(&mut self) -> Result<stats::Node<Sums>, String> {
        let first = self.number()?;
        let level = u32::try_from(self.number()?).unwrap_or(u32::MAX);
        let mut node = Node {
            histories: self.counter()?,
            batches: self.counter()?,
            events: self.counter()?,
            lost: self.counter()?,
            capped: self.counter()?,
            samples: self.counter()?,
            ..Node::default()
        };
        let (bodies, segments, bytes, pockets) =
            (self.counter()?, self.counter()?, self.counter()?, self.counter()?);
        let (steps, forced) = (self.counter()?, self.counter()?);
        node.kept = Kept { bodies, segments, bytes, pockets, steps, forced };
        node.worst_imbalance = self.float()?;
        node.single = self.list(16, Self::floats)?;
        node.sums = self.list(32, Self::floats)?;
        let cells = node.sums.len();
        let replicas = self.list(16, |r| {
            let replica = u8::try_from(r.number()?).map_err(|_| "damaged: a replica too many".to_owned())?;
            let samples = r.counter()?;
            if cells > r.0.len() / 8 {
                return Err("cut short".to_owned());
            }
            Ok((replica, (samples, (0..cells).map(|_| r.float()).collect::<Result<Vec<_>, _>>()?)))
        })?;
        node.replicas = BTreeMap::from_iter(replicas);
        let troubled = self.list(16, |r| {
            let history = r.number()?;
            let fate = if r.number()? == 0 { Fate::Lost } else { Fate::Capped };
            Ok(Troubled { history, fate })
        })?;
        if troubled.len() > RECORDS {
            return Err("damaged: too many records".to_owned());
        }
        Ok(stats::Node { first, level, value: Sums { node, troubled } })
    }
}
