//! The grammar of scenes and distribution files, version 1.

use super::attributes::*;
use super::{ChildRule, Kind, Presence, Range, Rule};
use crate::units::Quantity as Q;
use Kind::{Choice, File, Id, List, Number, Reference, Text};
use Presence::{Default, Optional, Required};
use std::f64::consts::PI;

const fn many(key: &'static str) -> ChildRule {
    ChildRule { key, required: false, many: true }
}
const fn some(key: &'static str) -> ChildRule {
    ChildRule { key, required: true, many: true }
}
const fn one(key: &'static str) -> ChildRule {
    ChildRule { key, required: true, many: false }
}
const fn maybe(key: &'static str) -> ChildRule {
    ChildRule { key, required: false, many: false }
}

/// All rules; the first is the root of a scene.
pub static RULES: &[Rule] = &[
    Rule {
        key: "scene",
        doc: "A whole scene.",
        attributes: &[&[
            w("name", Text, Required, "Title."),
            w("version", Choice(&["1"]), Required, "Version of this grammar."),
        ]],
        children: &[
            many("include"), many("define"), maybe("materials"), maybe("surfaces"), one("universe"), maybe("source"),
            maybe("spectrum"), maybe("detect"), maybe("optics"), maybe("effects"), maybe("run"), many("expect"),
        ],
    },
    Rule {
        key: "include",
        doc: "Takes in what stands in a file whose root is <scene-part>: elements of a scene that several scenes share. Materials and surfaces are added to those here.",
        attributes: &[&[w("file", File, Required, "The file.")]],
        children: &[],
    },
    Rule {
        key: "scene-part",
        doc: "Part of a scene, for <include file=…>.",
        attributes: &[],
        children: &[
            many("define"), maybe("materials"), maybe("surfaces"), maybe("universe"), maybe("source"),
            maybe("spectrum"), maybe("detect"), maybe("optics"), maybe("effects"), maybe("run"), many("expect"),
        ],
    },
    Rule {
        key: "define",
        doc: "A value for the placeholder ${name} in attribute values; -D name=value on the command line overrides it.",
        attributes: &[&[w("name", Id, Required, "Name."), w("value", Text, Required, "Value.")]],
        children: &[],
    },
    Rule { key: "materials", doc: "The component media.", attributes: &[], children: &[some("material")] },
    Rule {
        key: "material",
        doc: "A medium: refractive index, absorption, subsurface scattering.",
        attributes: &[MATERIAL, INDEX],
        children: &[many("scattering"), many("particles/mie"), many("fluorescence"), many("shift"), maybe("sap")],
    },
    Rule { key: "scattering", doc: "Scattering in the medium by coefficient and phase function.", attributes: &[SCATTERING], children: &[] },
    Rule {
        key: "particles/mie",
        doc: "Spheres too small for geometric optics (fillers, pigments): Mie scattering of the medium that holds them.",
        attributes: &[MIE, INDEX],
        children: &[maybe("diameter")],
    },
    Rule { key: "fluorescence", doc: "A dye that absorbs light and emits a share of the photons at longer wavelengths (optical brightener).", attributes: &[FLUORESCENCE], children: &[] },
    Rule { key: "shift", doc: "Raman or Brillouin scattering: light comes out with its wavenumber shifted, in all directions alike.", attributes: &[SHIFT], children: &[] },
    Rule { key: "surfaces", doc: "The surface laws.", attributes: &[], children: &[some("surface")] },
    Rule { key: "surface", doc: "A surface law.", attributes: &[SURFACE], children: &[maybe("sap")] },
    Rule { key: "sap", doc: "Sphere Area Partitioning of the surface's directions; without it the continuous law.", attributes: &[SAP], children: &[] },
    Rule {
        key: "universe",
        doc: "Where components are. Statistical: one <sheet> or one <mixture>. Synthetic: primitives and homogeneous layers, or a <sheet> of bodies known by their statistics, realised one by one (the same <sheet>: one attribute changes the universe). Voxel: one <volume>.",
        attributes: &[UNIVERSE],
        children: &[
            maybe("sheet"), maybe("realise"), maybe("cell"), maybe("mixture"), maybe("volume"), many("topography"), many("sphere"), many("ellipsoid"), many("cylinder"), many("piece"), many("box"), many("plane"), many("slab"),
        ],
    },
    Rule { key: "sheet", doc: "Layers from top (where light comes from) to bottom, from z = thickness down to z = 0.", attributes: &[SHEET], children: &[some("layer")] },
    Rule {
        key: "realise",
        doc: "Synthetic: how the bodies of a <sheet> are realised. How many histories share a realisation is a matter of <run>.",
        attributes: &[REALISE],
        children: &[],
    },
    Rule {
        key: "mixture",
        doc: "A Markov mixture: horizontal layers of random thickness of two or more phases, from z = thickness down to z = 0.",
        attributes: &[MIXTURE],
        children: &[some("phase")],
    },
    Rule { key: "cell", doc: "The bodies of a synthetic universe stand in a cell of a sheet that repeats itself sideways without end; `overlap` rules where they meet.", attributes: &[CELL], children: &[] },
    Rule { key: "topography", doc: "A measured surface z = h(x, y) that cuts the bodies of a synthetic universe off: beyond it there is only the medium outside.", attributes: &[TOPOGRAPHY], children: &[] },
    Rule {
        key: "volume",
        doc: "A labelled volume between z = 0 and its height, as a microtomogram is one.",
        attributes: &[VOLUME],
        children: &[some("label")],
    },
    Rule { key: "label", doc: "What a label, or a range of labels, stands for.", attributes: &[LABEL], children: &[] },
    Rule { key: "phase", doc: "A phase of a mixture.", attributes: &[PHASE], children: &[] },
    Rule {
        key: "layer",
        doc: "A layer: a medium and the bodies in it.",
        attributes: &[LAYER],
        children: &[many("fibres"), many("particles/body"), maybe("free-path"), maybe("types")],
    },
    Rule {
        key: "fibres",
        doc: "Fibres: cylinders of elliptic section, solid or hollow. Amount: exactly one of grammage, length-density, number-density, volume-fraction.",
        attributes: &[FIBRES, BODY],
        children: &[maybe("width"), maybe("flatness"), maybe("wall"), maybe("length"), maybe("profile")],
    },
    Rule {
        key: "particles/body",
        doc: "Spheres, ellipsoids or discs large enough for geometric optics. Amount: exactly one of grammage, number-density, volume-fraction.",
        attributes: &[PARTICLES, BODY],
        children: &[maybe("diameter"), maybe("thickness"), maybe("a"), maybe("b"), maybe("c"), maybe("profile")],
    },
    Rule {
        key: "free-path",
        doc: "Free path in the pore medium, given instead of densities (the Grace way).",
        attributes: &[&[
            w("law", Choice(&["exponential", "gamma", "histogram"]), Default("exponential"), "Law."),
            a("mean", Number(Q::Length), POS, Optional, "exponential, gamma: mean."),
            a("shape", Number(Q::Number), POS, Optional, "gamma: shape; 1 is exponential."),
            a("edges", List(Q::Length, None), NOT_NEG, Optional, "histogram: edges from 0, one more than `weights`."),
            a("weights", List(Q::Number, None), NOT_NEG, Optional, "histogram: weights."),
            w("file", File, Optional, "histogram: CSV with columns from, to, weight (um)."),
            a("contact", Number(Q::Number), NOT_NEG, Default("1"), "Factor on the probability that the component just left is met again (contact reduction)."),
        ]],
        children: &[],
    },
    Rule { key: "types", doc: "Which component is met, over relative depth; linear between rows.", attributes: &[], children: &[some("at")] },
    Rule {
        key: "at",
        doc: "A row of <types>.",
        attributes: &[&[
            a("depth", Number(Q::Fraction), SHARE, Required, "Relative depth from the top, ascending."),
            a("shares", List(Q::Fraction, None), SHARE, Required, "Probability of each component in the order of the layer, summing to 1."),
        ]],
        children: &[],
    },
    Rule { key: "profile", doc: "Density of the component over depth, judged at the centre of each body; linear between rows, scaled to the amount.", attributes: &[], children: &[some("at/density")] },
    Rule {
        key: "at/density",
        doc: "A row of <profile>.",
        attributes: &[&[
            a("depth", Number(Q::Fraction), SHARE, Required, "Relative depth from the top of the layer, ascending."),
            a("density", Number(Q::Number), NOT_NEG, Required, "Relative density of bodies there."),
        ]],
        children: &[],
    },
    Rule { key: "thickness", doc: "Law of the thickness.", attributes: &[LAW, LAW_LENGTH], children: &[many("part")] },
    Rule { key: "width", doc: "Law of the width.", attributes: &[LAW, LAW_LENGTH], children: &[many("part")] },
    Rule { key: "wall", doc: "Law of the wall thickness.", attributes: &[LAW, LAW_LENGTH], children: &[many("part")] },
    Rule { key: "length", doc: "Law of the length.", attributes: &[LAW, LAW_LENGTH], children: &[many("part")] },
    Rule { key: "diameter", doc: "Law of the diameter.", attributes: &[LAW, LAW_LENGTH], children: &[many("part")] },
    Rule { key: "a", doc: "Law of the first full axis.", attributes: &[LAW, LAW_LENGTH], children: &[many("part")] },
    Rule { key: "b", doc: "Law of the second full axis.", attributes: &[LAW, LAW_LENGTH], children: &[many("part")] },
    Rule { key: "c", doc: "Law of the third full axis.", attributes: &[LAW, LAW_LENGTH], children: &[many("part")] },
    Rule { key: "part", doc: "One law of a mixture.", attributes: &[PART, LAW, LAW_LENGTH], children: &[many("part")] },
    Rule { key: "flatness", doc: "Law of the flatness.", attributes: &[LAW, LAW_NUMBER], children: &[many("part/number")] },
    Rule { key: "part/number", doc: "One law of a mixture.", attributes: &[PART, LAW, LAW_NUMBER], children: &[many("part/number")] },
    Rule {
        key: "sphere",
        doc: "A ball.",
        attributes: &[EXPLICIT, CENTRE, &[a("radius", Number(Q::Length), POS, Required, "Radius.")]],
        children: &[],
    },
    Rule {
        key: "ellipsoid",
        doc: "An ellipsoid.",
        attributes: &[EXPLICIT, CENTRE, &[a("half-axes", List(Q::Length, Some(3)), POS, Required, "Half axes along `major`, across both, and along `axis`.")], AXES],
        children: &[],
    },
    Rule {
        key: "cylinder",
        doc: "A cylinder of circular or elliptic section, optionally hollow and bounded.",
        attributes: &[
            EXPLICIT,
            CENTRE,
            AXES,
            &[
                a("radius", Number(Q::Length), POS, Optional, "Radius of a circular section."),
                a("half-axes", List(Q::Length, Some(2)), POS, Optional, "Half axes of an elliptic section, instead of `radius`."),
                a("length", Number(Q::Length), POS, Optional, "Full length; without it unbounded."),
                a("wall", Number(Q::Length), POS, Optional, "Wall thickness of a hollow one."),
                w("lumen", Reference("material"), Optional, "Medium inside a hollow one; without it that outside."),
            ],
        ],
        children: &[],
    },
    Rule {
        key: "piece",
        doc: "A piece of a bent fibre: between two planes across its course the same elliptic section, whose centre rises along the course. Pieces with one `centre`, `axis` and `major` that share a plane go over into each other.",
        attributes: &[
            EXPLICIT,
            CENTRE,
            AXES,
            &[
                a("half-axes", List(Q::Length, Some(2)), POS, Required, "Half axes of the section: along `major`, and across it."),
                a("hollow", List(Q::Length, Some(2)), POS, Optional, "Half axes of the lumen; without it solid."),
                w("lumen", Reference("material"), Optional, "Medium of the lumen; without it that outside."),
                a("from", Number(Q::Length), ANY, Required, "Where it begins, along the axis from the centre."),
                a("to", Number(Q::Length), ANY, Required, "Where it ends."),
                a("height", Number(Q::Length), ANY, Default("0 um"), "How far the section's centre at `from` lies off the axis, across it and `major`."),
                a("slope", Number(Q::Number), ANY, Default("0"), "Rise of the section's centre over way along the axis."),
            ],
        ],
        children: &[],
    },
    Rule {
        key: "box",
        doc: "An axis-aligned box.",
        attributes: &[
            EXPLICIT,
            &[
                a("min", List(Q::Length, Some(3)), ANY, Required, "Lower corner."),
                a("max", List(Q::Length, Some(3)), ANY, Required, "Upper corner."),
            ],
        ],
        children: &[],
    },
    Rule {
        key: "plane",
        doc: "The half space behind a plane.",
        attributes: &[
            EXPLICIT,
            &[
                a("point", List(Q::Length, Some(3)), ANY, Default("0 0 0 um"), "A point on it."),
                a("normal", List(Q::Number, Some(3)), ANY, Default("0 0 1"), "Outward normal, any length."),
            ],
        ],
        children: &[],
    },
    Rule {
        key: "slab",
        doc: "A horizontal slab, unbounded sideways.",
        attributes: &[
            EXPLICIT,
            &[
                a("z-min", Number(Q::Length), ANY, Required, "Lower plane."),
                a("z-max", Number(Q::Length), ANY, Required, "Upper plane."),
            ],
        ],
        children: &[],
    },
    Rule { key: "source", doc: "Light.", attributes: &[SOURCE], children: &[] },
    Rule { key: "spectrum", doc: "Vacuum wavelengths: a list or a grid; without it 550 nm.", attributes: &[SPECTRUM], children: &[] },
    Rule { key: "detect", doc: "What is measured beside totals.", attributes: &[DETECT], children: &[many("halftone"), many("view")] },
    Rule {
        key: "view",
        doc: "BRDF (or, below 90 deg, BTDF) in one exact direction, by next-event estimation: where all refractive indices are equal and surfaces Lambertian. Light that nothing has turned is not seen.",
        attributes: &[&[
            a("polar", Number(Q::Angle), Range::closed(0.0, PI), Required, "Angle from the upward normal."),
            a("azimuth", Number(Q::Angle), Range::closed(-2.0 * PI, 2.0 * PI), Default("0 deg"), "Azimuth of where the light goes."),
        ]],
        children: &[],
    },
    Rule { key: "halftone", doc: "A line screen of ink upon the sheet: its reflectance, and the Yule–Nielsen factor n that it means.", attributes: &[HALFTONE], children: &[] },
    Rule { key: "optics", doc: "Figures of paper optics.", attributes: &[OPTICS], children: &[] },
    Rule { key: "effects", doc: "Decisions on effects other than those that the scene calls for.", attributes: &[], children: &[some("effect")] },
    Rule { key: "effect", doc: "An effect forced on (its steps are taken with neutral parameters) or off (what calls for it is left out, and every figure says so).", attributes: &[EFFECT], children: &[] },
    Rule { key: "run", doc: "How the scene is run.", attributes: &[RUN], children: &[] },
    Rule { key: "expect", doc: "An expected figure: makes the scene a test.", attributes: &[EXPECT], children: &[] },
    Rule { key: "distribution/fibres", doc: "Statistics of fibres, used by <fibres from=…>.", attributes: &[DISTRIBUTION], children: &[one("fibres")] },
    Rule { key: "distribution/flakes", doc: "Statistics of bodies, used by a layer's <particles from=…>.", attributes: &[DISTRIBUTION], children: &[one("particles/body")] },
    Rule { key: "distribution/filler", doc: "Statistics of Mie particles, used by a material's <particles from=…>.", attributes: &[DISTRIBUTION], children: &[one("particles/mie")] },
];
