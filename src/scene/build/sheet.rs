//! The universe: statistical sheets and their components.

use super::{Node, Reading};
use crate::law::SizeLaw;
use crate::scene::diagnostic::Diagnostic;
use crate::scene::model::*;
use crate::universe::{MediumId, Overlap, SurfaceId};

impl Reading<'_> {
    pub fn universe(
        &mut self,
        e: Option<Node<'_>>,
        materials: &[Material],
        surfaces: &[Surface],
    ) -> Universe {
        let nothing = Universe::Synthetic(Synthetic {
            cell: None,
            ambient: MediumId(0),
            bodies: Vec::new(),
            skins: [None, None],
            random: None,
        });
        let Some(e) = e else { return nothing };
        match e.text("kind") {
            Some("synthetic") => {
                self.realised(e, materials, surfaces).unwrap_or_else(|| self.synthetic(e, materials))
            }
            Some("voxel") => self.voxels(e).unwrap_or(nothing),
            Some("statistical") => match e.child("sheet").ok_or_else(|| e.child("mixture")) {
                Err(Some(mixture)) => Universe::Mixture(self.markov_mixture(e, mixture, materials)),
                Ok(sheet) => {
                    e.children("realise").for_each(|r| r.use_all());
                    Universe::Statistical(self.statistical(e, sheet, memory(e), materials, surfaces))
                }
                Err(None) if e.own.misspelt.get() => nothing,
                Err(None) => {
                    self.out.push(
                        Diagnostic::error(
                            e.own.place,
                            "a statistical universe needs a <sheet>, or a <mixture>",
                        )
                        .help("primitives belong to kind=\"synthetic\""),
                    );
                    nothing
                }
            },
            _ => nothing,
        }
    }

    /// The medium around everything.
    pub fn outside(&mut self, e: Node<'_>) -> MediumId {
        if let Some(m) = self.material(e, "outside") {
            return m;
        }
        if let Some(i) = self.materials.iter().position(|m| m == "air") {
            return MediumId(u16::try_from(i).unwrap_or(0));
        }
        if !e.has("outside") {
            self.out.push(
                Diagnostic::error(e.own.place, "the medium around everything is not known")
                    .help("give `outside`, the id of a material, or define a material with id `air`"),
            );
        }
        MediumId(0)
    }

    /// A sheet of bodies in a synthetic universe: the same as a statistical one, realised body by body.
    fn realised(&mut self, e: Node<'_>, materials: &[Material], surfaces: &[Surface]) -> Option<Universe> {
        let sheet = e.child("sheet")?;
        let is_body = |c: Node<'_>| matches!(c.own.name.as_str(), "fibres" | "particles");
        if !sheet.children("layer").any(|l| l.all_children().any(is_body)) {
            return None;
        }
        for c in e.all_children().filter(|c| !matches!(c.own.name.as_str(), "sheet" | "realise")) {
            let d = Diagnostic::error(c.own.place, "a primitive beside a sheet that is realised");
            self.out.push(d.help("give the sheet, or the primitives, a scene of its own"));
            c.use_all();
        }
        if e.text("overlap") == Some("forbid") {
            let d = Diagnostic::error(e.place("overlap"), "the Boolean ensemble has bodies that overlap");
            self.out.push(d.help("overlap=\"union\" or overlap=\"priority\""));
        }
        let options = e.child("realise");
        let deposit = options.filter(|r| r.text("model") == Some("deposited")).map(|r| self.depositing(e, r));
        let spread = if deposit.is_none() { options.and_then(|r| r.number("spread")) } else { None };
        // What the same file says to the statistical universe; its mean is that of full memory.
        let _ = (memory(e), e.text("rate"));
        self.deposits = deposit.is_some();
        let nodes: Vec<Node<'_>> = sheet.children("layer").collect();
        let sheet = self.statistical(e, sheet, Memory::Full, materials, surfaces);
        if deposit.is_some() {
            self.check_deposited(e, &nodes, &sheet, materials);
        }
        Some(Universe::Realised(Realised { sheet, spread, deposit }))
    }

    /// A deposited sheet is one layer between two rough faces that its fibres make.
    fn check_deposited(
        &mut self,
        e: Node<'_>,
        layers: &[Node<'_>],
        sheet: &StatisticalSheet,
        materials: &[Material],
    ) {
        const OTHERWISE: &str = "<realise model=\"boolean\"/> realises several layers and faces with a surface, \
                                 kind=\"statistical\" takes them as well";
        if self.out.error_count() > 0 {
            return;
        }
        if let [_, second, ..] = layers {
            let d = Diagnostic::error(second.own.place, "a second layer of a deposited sheet")
                .label("fibres fall on each other, not on planes between layers")
                .other(e.own.place, "deposited here");
            self.out.push(d.help(OTHERWISE));
            return;
        }
        let ([node], [layer]) = (layers, sheet.layers.as_slice()) else { return };
        let index = |m: MediumId| materials.get(usize::from(m.0)).map(|m| &m.index);
        let (place, what) = if layer.surface != SurfaceId::SMOOTH {
            (node.place("surface"), "a surface on the face of a deposited sheet")
        } else if index(layer.pore) != index(sheet.outside) {
            (
                node.own.place,
                "the pores of a deposited sheet have another refractive index than what is outside",
            )
        } else {
            return;
        };
        let d = Diagnostic::error(place, what).label("its faces are those of its fibres: there is no plane");
        self.out.push(d.help(OTHERWISE));
    }

    fn depositing(&mut self, e: Node<'_>, r: Node<'_>) -> Depositing {
        if e.text("edges") == Some("cut") {
            let d = Diagnostic::error(e.place("edges"), "a deposited sheet is not cut: it has its own faces");
            self.out.push(d.help("leave `edges` out"));
        }
        Depositing {
            flexibility: r.number("flexibility").unwrap_or(0.5),
            places: r.count("places").map_or(16, |n| n as u32),
            pressing: r.number("pressing"),
            cell: r.number("cell").unwrap_or(1000.0),
            realisations: r.count("realisations").unwrap_or(8),
            gap: r.number("bond-gap").unwrap_or(0.5),
        }
    }

    fn statistical(
        &mut self,
        e: Node<'_>,
        sheet: Node<'_>,
        memory: Memory,
        materials: &[Material],
        surfaces: &[Surface],
    ) -> StatisticalSheet {
        let _ = sheet.text("name");
        let layers: Vec<(Node<'_>, Layer)> = self.layers(sheet);
        let backing = self.backing(e, sheet);
        let rate = if memory == Memory::None {
            e.text("rate").map(|r| if r == "boolean" { Rate::Boolean } else { Rate::Matched })
        } else {
            None
        };
        let edges = if e.text("edges") == Some("cut") { Edges::Cut } else { Edges::Contained };
        let start = if edges == Edges::Cut && e.text("start") == Some("pore") {
            StartIn::Pore
        } else {
            StartIn::Anywhere
        };
        let built = StatisticalSheet {
            memory,
            rate,
            overlap: match e.text("overlap") {
                Some("priority") => Overlap::Priority,
                Some("forbid") => Overlap::Forbid,
                _ => Overlap::Union,
            },
            edges,
            start,
            outside: self.outside(e),
            layers: Vec::new(),
            backing,
        };
        self.check_sheet(e, &built, &layers, materials, surfaces);
        StatisticalSheet { layers: layers.into_iter().map(|l| l.1).collect(), ..built }
    }

    /// `backing` on the sheet or on the universe.
    pub fn backing(&mut self, e: Node<'_>, sheet: Node<'_>) -> Option<f64> {
        if e.has("backing") && sheet.has("backing") {
            self.out.push(
                Diagnostic::error(sheet.place("backing"), "`backing` is given twice")
                    .other(e.place("backing"), "first here"),
            );
        }
        e.number("backing").or_else(|| sheet.number("backing"))
    }

    /// The layers with thicknesses filled in.
    pub fn layers<'a>(&mut self, sheet: Node<'a>) -> Vec<(Node<'a>, Layer)> {
        let nodes: Vec<Node<'a>> = sheet.children("layer").collect();
        let thickness = self.thicknesses(sheet, &nodes);
        nodes.into_iter().zip(thickness).map(|(n, t)| (n, self.layer(sheet, n, t))).collect()
    }

    fn thicknesses(&mut self, sheet: Node<'_>, layers: &[Node<'_>]) -> Vec<f64> {
        let own: Vec<Option<f64>> = layers.iter().map(|l| l.number("thickness")).collect();
        let known: f64 = own.iter().flatten().sum();
        let open: Vec<usize> = (0..layers.len()).filter(|i| !layers[*i].has("thickness")).collect();
        let total = sheet.number("thickness");
        let mut rest = 1.0;
        match (total, open.as_slice()) {
            (None, [i, ..]) if !sheet.has("thickness") && !sheet.own.misspelt.get() => {
                let d = Diagnostic::error(layers[*i].own.place, "the thickness of this layer is not known");
                self.out.push(d.help("give `thickness` here or on <sheet>"));
            }
            (Some(_), [_, second, ..]) => {
                let d = Diagnostic::error(layers[*second].own.place, "two layers have no thickness");
                self.out.push(d.help("only one layer can take what is left of the sheet's"));
            }
            (Some(total), [_]) if total > known => rest = total - known,
            (Some(total), [_]) => {
                let message =
                    format!("the other layers take {known} um of {total} um: nothing is left for one layer");
                self.error(sheet.place("thickness"), message);
            }
            (Some(total), []) if (total - known).abs() > 1e-9 * total && own.iter().all(Option::is_some) => {
                self.error(
                    sheet.place("thickness"),
                    format!("the layers sum to {known} um, the sheet is {total} um thick"),
                );
            }
            _ => {}
        }
        own.into_iter().map(|t| t.unwrap_or(rest)).collect()
    }

    fn layer(&mut self, sheet: Node<'_>, e: Node<'_>, thickness: f64) -> Layer {
        let _ = e.text("name");
        let pore = match e.one_of(self, &["pore", "material"], None) {
            Some(which) => self.material(e, which),
            None => self.material(sheet, "pore"),
        };
        if sheet.own.attribute("pore").is_some() {
            // Where every layer has its own the sheet's is a default that nobody takes: no fault.
            let _ = sheet.text("pore");
        }
        if pore.is_none() && !sheet.has("pore") && !sheet.own.misspelt.get() && !e.own.misspelt.get() {
            let d = Diagnostic::error(e.own.place, "the medium of this layer is not known");
            self.out.push(d.help("give `pore` here or on <sheet>, or `material` for a homogeneous layer"));
        }
        let pore = pore.unwrap_or(MediumId(0));
        let bodies: Vec<Node<'_>> =
            e.all_children().filter(|c| matches!(c.own.name.as_str(), "fibres" | "particles")).collect();
        if let (true, Some(first)) = (e.has("material"), bodies.first()) {
            self.out.push(
                Diagnostic::error(first.own.place, "a layer with `material` is homogeneous")
                    .other(e.place("material"), "given here")
                    .help("give the medium between bodies as `pore`"),
            );
        }
        let mut components: Vec<Component> = Vec::new();
        for b in bodies {
            let c = if b.own.name == "fibres" { self.fibres(b, pore) } else { self.particles(b, pore) };
            components.push(unique_name(c, &components));
        }
        let grace = self.grace(e, components.len());
        Layer { thickness, pore, surface: self.surface_id(e, "surface"), components, grace }
    }

    fn fibres(&mut self, own: Node<'_>, pore: MediumId) -> Component {
        let base = self.distribution(own, "fibres");
        let e = Node { base: base.as_ref(), ..own };
        let solid = e.text("wall") == Some("solid");
        // Mass of a fibre: with x = width ∝ x² if solid, ∝ x (perimeter) if hollow; independent of length.
        let width = self.needed_size(e, "width", if solid { 2.0 } else { 1.0 }, 0.0);
        let flatness = self.size(e, "flatness", if solid { 1.0 } else { 0.0 }, 0.0, Some(1.0));
        let wall = if solid { None } else { Some(self.needed_size(e, "wall", 1.0, 0.0)) };
        let length = self.size(e, "length", 1.0, 1.0, None);
        if length.is_none() && e.own.attribute("number-density").is_some() {
            self.out.push(
                Diagnostic::error(
                    e.place("number-density"),
                    "a number density of fibres needs their `length`",
                )
                .help("or give length-density, grammage or volume-fraction"),
            );
        }
        if length.is_none() && self.deposits {
            let d = Diagnostic::error(e.own.place, "fibres without end cannot fall on a sheet");
            self.out.push(d.help("give their `length`"));
        }
        let shape = Shape::Fibre {
            width,
            flatness: flatness.unwrap_or(SizeLaw::Constant(1.0)),
            wall,
            length: length.unwrap_or(SizeLaw::Constant(1000.0)),
            finite: e.text("ends") == Some("flat"),
        };
        let lumen = self.material(e, "lumen").unwrap_or(pore);
        let amounts = ["grammage", "length-density", "number-density", "volume-fraction"];
        let built = self.component(e, shape, lumen, &amounts);
        let bonded = e.number("bonded").unwrap_or(0.0);
        Component { coarseness: e.number("coarseness"), bonded, ..built }
    }

    fn particles(&mut self, own: Node<'_>, pore: MediumId) -> Component {
        let base = self.distribution(own, "flakes");
        let e = Node { base: base.as_ref(), ..own };
        let shape = match e.required(self, "shape") {
            Some("ellipsoid") => {
                Shape::Ellipsoid { axes: ["a", "b", "c"].map(|axis| self.needed_size(e, axis, 1.0, 0.0)) }
            }
            Some("disc") => Shape::Disc {
                diameter: self.needed_size(e, "diameter", 2.0, 1.0),
                thickness: self.needed_size(e, "thickness", 1.0, 0.0),
            },
            _ => Shape::Sphere { diameter: self.needed_size(e, "diameter", 3.0, 1.0) },
        };
        self.component(e, shape, pore, &["grammage", "number-density", "volume-fraction"])
    }

    fn component(
        &mut self,
        e: Node<'_>,
        shape: Shape,
        lumen: MediumId,
        amounts: &[&'static str],
    ) -> Component {
        let _ = e.required(self, "material");
        let material = self.material(e, "material").unwrap_or(MediumId(0));
        let (azimuth, tilt) = self.orientation(e);
        let file = |a: &str| std::path::Path::new(a).file_stem().map(|s| s.to_string_lossy().into_owned());
        let name = e.text("name").map(str::to_string).or_else(|| file(e.text("from")?));
        let amount = e.one_of(self, amounts, Some("an amount"));
        let x = amount.and_then(|a| e.number(a)).unwrap_or(1e-9);
        Component {
            name: name.unwrap_or_else(|| e.own.name.clone()),
            shape,
            material,
            lumen,
            surface: self.surface_id(e, "surface"),
            azimuth,
            tilt,
            roll: self.roll(e),
            amount: match amount {
                Some("length-density") => Amount::LengthDensity(x),
                Some("number-density") => Amount::NumberDensity(x),
                Some("volume-fraction") => Amount::VolumeFraction(x),
                _ => Amount::Grammage(x),
            },
            density: e.number("density").unwrap_or(1500.0),
            coarseness: None,
            profile: self.profile(e),
            bonded: 0.0,
        }
    }

    fn grace(&mut self, layer: Node<'_>, components: usize) -> Option<Grace> {
        let Some(e) = layer.child("free-path") else {
            if let Some(t) = layer.child("types") {
                self.error(t.own.place, "<types> needs a <free-path> beside it");
            }
            return None;
        };
        if components == 0 {
            self.error(e.own.place, "<free-path> in a layer without bodies: nothing would be met");
        }
        let law = e.text("law").unwrap_or("exponential");
        let why = format!("law `{law}`");
        let free_path = match law {
            "gamma" => {
                let (mean, shape) = (e.needed(self, "mean", &why), e.needed(self, "shape", &why));
                FreePath::Gamma { mean: mean.unwrap_or(1.0), shape: shape.unwrap_or(1.0) }
            }
            "histogram" => {
                let (edges, weights) = self.histogram(e).unwrap_or((vec![0.0, 1.0], vec![1.0]));
                if edges[0] != 0.0 {
                    self.error(e.own.place, "the histogram of a free path begins at 0");
                }
                FreePath::Empirical { edges, weights }
            }
            _ => FreePath::Exponential(e.needed(self, "mean", &why).unwrap_or(1.0)),
        };
        let types = self.types(layer.child("types"), components);
        Some(Grace { free_path, types, contact: e.number("contact").unwrap_or(1.0) })
    }

    /// Rows of `<profile>`.
    fn profile(&mut self, e: Node<'_>) -> Option<Vec<(f64, f64)>> {
        let profile = e.child("profile")?;
        let mut rows: Vec<(f64, f64)> = Vec::new();
        for row in profile.children("at") {
            let (Some(depth), Some(density)) = (row.number("depth"), row.number("density")) else { continue };
            if rows.last().is_some_and(|r| r.0 >= depth) {
                self.error(row.place("depth"), "depths must ascend");
            }
            rows.push((depth, density));
        }
        if rows.iter().all(|r| r.1 == 0.0) {
            self.error(profile.own.place, "a profile needs a density above 0 somewhere");
            return None;
        }
        Some(rows)
    }

    /// Rows of `<types>`; without them every component is equally likely.
    fn types(&mut self, e: Option<Node<'_>>, components: usize) -> Vec<(f64, Vec<f64>)> {
        let Some(e) = e else {
            return vec![(0.0, vec![1.0 / components.max(1) as f64; components])];
        };
        let mut rows: Vec<(f64, Vec<f64>)> = Vec::new();
        for row in e.children("at") {
            let (Some(depth), Some(shares)) = (row.number("depth"), row.list("shares")) else { continue };
            let sum: f64 = shares.iter().sum();
            if shares.len() != components {
                let message = format!("{} shares for {components} components of the layer", shares.len());
                self.error(row.place("shares"), message);
            } else if (sum - 1.0).abs() > 1e-9 {
                self.error(row.place("shares"), format!("the shares sum to {sum}, not to 1"));
            }
            if rows.last().is_some_and(|r| r.0 >= depth) {
                self.error(row.place("depth"), "depths must ascend");
            }
            rows.push((depth, shares));
        }
        rows
    }
}

/// The rung of the memory ladder.
pub fn memory(e: Node<'_>) -> Memory {
    match (e.text("memory"), e.count("memory")) {
        (Some("homogeneous"), _) => Memory::Homogeneous,
        (Some("markov"), _) => Memory::Markov,
        (Some("full"), _) => Memory::Full,
        (_, Some(k)) => Memory::Last(u32::try_from(k).unwrap_or(u32::MAX)),
        _ => Memory::None,
    }
}

/// Equal names would merge two rows of a tally: the second gets a number.
fn unique_name(c: Component, before: &[Component]) -> Component {
    let taken = |name: &str| before.iter().any(|b| b.name == name);
    if !taken(&c.name) {
        return c;
    }
    let name = (2..).map(|i| format!("{} {i}", c.name)).find(|n| !taken(n));
    Component { name: name.unwrap_or_default(), ..c }
}
