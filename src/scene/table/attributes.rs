//! The attributes of elements, for the grammar of scenes and distribution files.

use super::{AttributeRule as A, Kind, Presence, Range};
use crate::units::Quantity as Q;
use Kind::{Choice, File, Id, Integer, List, Nside, Number, NumberOr, Reference, Text};
use Presence::{Default, Optional, Required};
use std::f64::consts::PI;

pub(super) const fn a(name: &'static str, kind: Kind, range: Range, presence: Presence, doc: &'static str) -> A {
    A { name, kind, range, presence, doc }
}
/// An attribute whose text is no number.
pub(super) const fn w(name: &'static str, kind: Kind, presence: Presence, doc: &'static str) -> A {
    a(name, kind, Range::ANY, presence, doc)
}
pub(super) const YES_NO: Kind = Choice(&["yes", "no"]);
pub(super) const POS: Range = Range::POSITIVE;
pub(super) const NOT_NEG: Range = Range::NOT_NEGATIVE;
pub(super) const SHARE: Range = Range::SHARE;
pub(super) const ANY: Range = Range::ANY;
pub(super) const NM: Range = Range::closed(1.0, 1e6);
pub(super) const SIZES: &[&str] = &[
    "constant", "uniform", "truncated-normal", "lognormal", "gamma", "weibull", "beta", "histogram", "mixture",
];

pub(super) const EFFECTS: &[&str] = &[
    "absorption", "fresnel-interfaces", "dispersion", "rough-surfaces", "lambertian-surfaces", "subsurface-scattering",
    "sphere-area-partitioning", "polarisation", "fluorescence", "wavenumber-shifts", "thin-films", "multiple-bounces", "time-of-flight",
];

pub(super) const INDEX: &[A] = &[
    a("index", Number(Q::Number), Range::above(0.0, 100.0), Optional, "Real refractive index n, the same at every wavelength."),
    a("kappa", Number(Q::Number), NOT_NEG, Optional, "Imaginary index κ ≥ 0 beside `index`; exp(−iωt), n + iκ."),
    w("index-file", File, Optional, "refractiveindex.info YAML file with n(λ) and, if it has it, κ(λ); instead of `index`."),
    w("extrapolate", Choice(&["no", "clamp"]), Default("no"), "`clamp` takes a table's end value outside its range and records a warning; otherwise that is an error."),
];

pub(super) const MATERIAL: &[A] = &[
    w("id", Id, Required, "Name that other elements refer to."),
    a("absorption", Number(Q::Coefficient), NOT_NEG, Optional, "Absorption coefficient beside that of κ (pulp, dye)."),
    w("absorption-file", File, Optional, "CSV of wavelength (nm) and absorption coefficient (1/um); instead of `absorption`."),
];

pub(super) const SCATTERING: &[A] = &[
    a("mu-s", Number(Q::Coefficient), NOT_NEG, Optional, "Scattering coefficient µs."),
    w("mu-s-file", File, Optional, "CSV of wavelength (nm) and scattering coefficient (1/um); instead of `mu-s`."),
    w("phase", Choice(&["isotropic", "hg", "two-term-hg", "rayleigh", "table"]), Optional, "Phase function; without it `hg` if `g` is given, else `isotropic`."),
    a("g", Number(Q::Number), Range::open(-1.0, 1.0), Optional, "Mean cosine of Henyey–Greenstein scattering."),
    a("w", Number(Q::Fraction), SHARE, Optional, "Share of the first term of `two-term-hg`."),
    a("g1", Number(Q::Number), Range::open(-1.0, 1.0), Optional, "Mean cosine of the first term of `two-term-hg`."),
    a("g2", Number(Q::Number), Range::open(-1.0, 1.0), Optional, "Mean cosine of the second term of `two-term-hg`."),
    w("file", File, Optional, "CSV of scattering angle (deg) and phase function, for `phase=\"table\"`."),
    w("extrapolate", Choice(&["no", "clamp"]), Default("no"), "As for `index-file`, for `mu-s-file`."),
    w("depolarises", YES_NO, Default("no"), "Polarised light: nothing of its state is left. Laws other than `rayleigh` know no state and must say so."),
];

pub(super) const FLUORESCENCE: &[A] = &[
    a("absorption", Number(Q::Coefficient), NOT_NEG, Optional, "Absorption coefficient of the dye at its `peak`."),
    a("peak", Number(Q::Wavelength), NM, Optional, "Wavelength of strongest absorption, with `absorption`."),
    a("width", Number(Q::Wavelength), POS, Default("25 nm"), "Standard deviation of the (Gaussian) absorption band."),
    w("absorption-file", File, Optional, "CSV of wavelength (nm) and absorption coefficient of the dye (1/um); 0 outside; instead of `absorption`."),
    a("emission", Number(Q::Wavelength), NM, Optional, "Wavelength of strongest emission (photons per nm)."),
    a("emission-width", Number(Q::Wavelength), POS, Default("30 nm"), "Standard deviation of the (Gaussian) emission band."),
    w("emission-file", File, Optional, "CSV of wavelength (nm) and emitted photons per nm in any unit; 0 outside; instead of `emission`."),
    a("quantum-yield", Number(Q::Fraction), SHARE, Default("1"), "Photons emitted over photons absorbed."),
];

pub(super) const SHIFT: &[A] = &[
    w("kind", Choice(&["raman", "brillouin"]), Required, "Down only (Stokes), or down and up with equal chance."),
    a("by", Number(Q::Coefficient), POS, Required, "Shift of the wavenumber, as 2900 1/cm."),
    a("rate", Number(Q::Coefficient), NOT_NEG, Required, "Events over path."),
];

pub(super) const MIE: &[A] = &[
    w("from", File, Optional, "Distribution file (kind `filler`) whose values are taken where none stand here."),
    w("name", Text, Optional, "Name, for messages."),
    w("shape", Choice(&["sphere", "fibril"]), Default("sphere"), "Spheres, or fibrils: cylinders without end, axes in all directions; probabilities of their diameters count length."),
    a("diameter", Number(Q::Length), POS, Optional, "Diameter of all particles; or a law in a child <diameter>."),
    a("volume-fraction", Number(Q::Fraction), Range::closed(0.0, 0.5), Optional, "Volume of the particles over volume of the medium with them in it."),
    a("mass-concentration", Number(Q::Density), NOT_NEG, Optional, "Mass of the particles over volume of the medium, instead of `volume-fraction`; needs `density`."),
    a("density", Number(Q::Density), POS, Optional, "Density of the particles."),
];

pub(super) const SURFACE: &[A] = &[
    w("id", Id, Required, "Name that other elements refer to; `smooth` is always there."),
    w("kind", Choice(&["smooth", "lambertian", "rough"]), Default("smooth"), "Where light goes: specular, totally diffuse, or facets with a slope distribution."),
    w("per-patch", YES_NO, Default("no"), "Lambertian: equal power per SAP patch (a reading of the paper) instead of equal radiance."),
    w("slopes", Choice(&["gaussian", "exponential", "ggx"]), Default("gaussian"), "Rough: slope distribution."),
    a("m", Number(Q::Number), Range::closed(0.0, 10.0), Optional, "Rough: rms slope (α for GGX); 0 is smooth."),
    w("multiple-bounce", Choice(&["off", "renormalised", "walk"]), Default("off"), "Rough: power lost to masked facets stands in the ledger, is given back by the white albedo of the same law, or goes on from facet to facet (random walk; gaussian and exponential slopes)."),
    w("ratio", Choice(&["fresnel", "paper-amplitude"]), Default("fresnel"), "Reflected share: Fresnel power, or |r| in place of |r|² (the curve of the paper's figure 12)."),
    a("reflectance", Number(Q::Fraction), SHARE, Optional, "Reflected share at every wavelength and angle, instead of `ratio`."),
    w("reflectance-file", File, Optional, "CSV of wavelength (nm) and reflectance; with more columns, headed by incidence angles in degrees from 0 to 90."),
    a("film-index", Number(Q::Number), Range::above(0.0, 100.0), Optional, "Thin film on the surface: its real index (interference by Airy's formula), instead of `ratio`."),
    a("film-thickness", Number(Q::Length), NOT_NEG, Optional, "Thickness of the film."),
    w("opaque", YES_NO, Default("no"), "What is not reflected is absorbed at the surface instead of refracted."),
    w("extrapolate", Choice(&["no", "clamp"]), Default("no"), "As for `index-file`, for `reflectance-file`."),
];

pub(super) const SAP: &[A] = &[
    a("nside", Nside, Range::closed(1.0, 1024.0), Required, "Granularity: 12 nside² patches."),
    w("populate", Choice(&["exact", "centre"]), Default("exact"), "Ratio of a patch: integral of the density, or density at the centre times area (the paper)."),
    w("directions", Choice(&["centre", "density", "uniform"]), Default("density"), "Direction that stands for a patch: its centre (the paper), drawn from the density, or uniform inside."),
    w("frame", Choice(&["rotated", "resolved"]), Default("resolved"), "Populated once and turned to the specular direction (the paper), or one per incidence bin."),
    w("roll", Choice(&["random", "fixed"]), Default("random"), "Roll about the pole: drawn at each event, or fixed (the paper)."),
];

pub(super) const UNIVERSE: &[A] = &[
    w("kind", Choice(&["statistical", "synthetic", "voxel"]), Required, "Components known by statistics, explicit, or a labelled volume."),
    a("memory", NumberOr(Q::Count, &["homogeneous", "markov", "none", "full"]), Range::closed(1.0, 1e9), Default("none"), "Statistical: rung of the memory ladder, from nothing remembered to everything; a number: the last so many flights and the bodies met on them (of a <mixture>: layers)."),
    w("rate", Choice(&["matched", "boolean"]), Optional, "Statistical, memory `none`: rate that keeps mass or surface; without it `matched` for bodies that light enters, `boolean` for opaque ones."),
    w("overlap", Choice(&["union", "priority", "forbid"]), Default("union"), "Statistical, realised and cells: where bodies overlap a point is solid if any wall covers it, or one body rules, or bodies do not overlap (an approximation of hard packing)."),
    w("edges", Choice(&["cut", "contained"]), Default("contained"), "Statistical: an unbounded medium cut by the faces, or bodies wholly between them."),
    w("start", Choice(&["anywhere", "pore"]), Default("anywhere"), "Edges `cut`, and cells of bodies: light enters inside bodies too, or through pores only."),
    w("outside", Reference("material"), Optional, "Medium around everything; without it the material with id `air`."),
    a("backing", Number(Q::Fraction), SHARE, Optional, "As on <sheet>."),
];

pub(super) const REALISE: &[A] = &[
    w("model", Choice(&["boolean", "deposited"]), Default("boolean"), "The exact ensemble of the rung memory `full`: bodies stand independently and overlap; or fibres fall one by one and bend over what lies below, and nothing overlaps."),
    a("flexibility", Number(Q::Number), Range::closed(0.0, 10.0), Default("0.5"), "Deposited: steepest course of a fibre, rise over way."),
    a("places", Number(Q::Count), Range::closed(1.0, 1024.0), Default("16"), "Deposited: places drawn for each fibre; it comes down where the sheet stands lowest below it, as drainage carries fibres to thin spots. 1: at random."),
    a("pressing", Number(Q::Fraction), Range::closed(0.05, 1.0), Optional, "Deposited: height of a fibre's section over that as drawn; the lumen gives way, the wall keeps its area. Without it, it is found so that the sheet gets its `thickness`."),
    a("cell", Number(Q::Length), POS, Default("1 mm"), "Deposited: edge of the square cell that repeats itself sideways."),
    a("realisations", Number(Q::Count), Range::closed(1.0, 32.0), Default("8"), "Deposited: so many sheets, which batches of 4096 histories meet in turn; intervals count realisations."),
    a("bond-gap", Number(Q::Length), NOT_NEG, Default("0.5 um"), "Deposited: distance within which two surfaces are reported as bonded."),
    a("spread", Number(Q::Length), NOT_NEG, Optional, "Boolean: histories meet their realisation at random within this distance along x and y; without it forty mean thicknesses of the bodies."),
];

pub(super) const CELL: &[A] = &[
    a("period", List(Q::Length, None), POS, Required, "Edge of the cell, or its edges along x and y: all bodies repeat so, and light finds the cell displaced sideways by chance."),
    a("bottom", Number(Q::Length), ANY, Default("0 um"), "Lower plane: there is no surface there, light leaves."),
    a("top", Number(Q::Length), ANY, Required, "Upper plane, where light comes in."),
];

pub(super) const TOPOGRAPHY: &[A] = &[
    w("side", Choice(&["top", "bottom"]), Default("top"), "Top: above the surface there is nothing; bottom: below it."),
    w("file", File, Required, "Map of heights: NumPy array, TIFF page, text matrix, or Gwyddion simple field; the first row is at y = 0."),
    a("pixel", List(Q::Length, None), POS, Optional, "Edge of a pixel, or its edges along x and y; without it as the file says."),
    a("unit", Number(Q::Length), POS, Optional, "What 1 in the file is; without it as the file says, or 1 um."),
    a("level", Number(Q::Length), ANY, Optional, "Height at which the mean of the map stands; without it heights count from z = 0."),
    w("lateral", Choice(&["mirror", "periodic"]), Default("mirror"), "How the map goes on sideways: reflected at its borders, or repeated."),
    w("position", Choice(&["random", "fixed"]), Optional, "Random: each history finds the surface displaced sideways by chance, so that light falls evenly on all of it; fixed: its first height stands at x = y = 0. Without it random, but for a point source, a beam with a radius, and single bodies. Both sides alike."),
    w("surface", Reference("surface"), Default("smooth"), "Law of the surface: what is finer than a pixel."),
];

pub(super) const SHEET: &[A] = &[
    a("thickness", Number(Q::Length), POS, Optional, "Thickness of the sheet; the layers' own must sum to it, one layer without thickness gets the rest."),
    w("pore", Reference("material"), Optional, "Medium between the bodies, for layers without their own."),
    a("backing", Number(Q::Fraction), SHARE, Optional, "Reflectance of a Lambertian backing in optical contact below."),
    w("name", Text, Optional, "Name, for messages."),
];

pub(super) const MIXTURE: &[A] = &[
    a("thickness", Number(Q::Length), POS, Required, "Thickness of the whole."),
    w("surface", Reference("surface"), Default("smooth"), "Law of the planes between phases; the two faces are smooth."),
    a("backing", Number(Q::Fraction), SHARE, Optional, "Reflectance of a Lambertian backing in optical contact below."),
];

pub(super) const PHASE: &[A] = &[
    w("material", Reference("material"), Required, "What the layers of this phase are made of."),
    a("chord", Number(Q::Length), POS, Required, "Mean thickness of a layer of this phase (exponential law)."),
    a("share", Number(Q::Number), POS, Default("1"), "More than two phases: share among the phases that may follow another, P_ij = share_j / sum over k ≠ i of share_k."),
];

pub(super) const VOLUME: &[A] = &[
    w("file", File, Required, "Stack of labels: TIFF, NRRD, MHD/RAW or NPY, whole numbers."),
    a("voxel", List(Q::Length, None), POS, Required, "Edge of a voxel, or its edges along x, y and z."),
    w("top", Choice(&["last", "first"]), Default("last"), "Slice that is the upper face of the sheet."),
    w("lateral", Choice(&["mirror", "periodic"]), Default("mirror"), "How the volume goes on sideways: reflected at its side faces, or repeated."),
    w("normals", Choice(&["smoothed", "faces"]), Default("smoothed"), "Where surfaces look: along the gradient of the labels smoothed by a Gaussian, or along the axes (never converges)."),
    a("smoothing", Number(Q::Number), Range::closed(0.5, 6.0), Default("2"), "Standard deviation of the Gaussian in voxels."),
    w("steps", Choice(&["passed", "mirrored"]), Default("passed"), "Steps of the staircase that a ray meets from behind: passed, for the smooth surface has none; or met, what lands behind the face mirrored about it (biased)."),
    w("position", Choice(&["random", "fixed"]), Optional, "Random: each ray finds the volume displaced sideways by chance, so that light falls evenly on all of it; fixed: its middle stands above x = y = 0. Without it random, but for a point source and a beam with a radius."),
    a("coarser", Number(Q::Count), Range::closed(1.0, 64.0), Default("1"), "Voxels merged along each edge after reading, by majority: less memory, and what the voxel size does to a figure."),
    a("max-voxels", Number(Q::Count), Range::closed(1.0, 1e12), Default("4e9"), "Larger files are refused before anything is read; a voxel takes 1 to 8 bits of memory."),
];

pub(super) const LABEL: &[A] = &[
    w("value", Integer, Required, "Value of the voxels."),
    w("to", Integer, Optional, "Last value, for a range."),
    w("material", Reference("material"), Required, "What they are made of. Labels of one material and surface are one body."),
    w("surface", Reference("surface"), Default("smooth"), "Law of the surface. Between two labels the later one rules, unless it is smooth."),
];

pub(super) const LAYER: &[A] = &[
    a("thickness", Number(Q::Length), POS, Optional, "Thickness of the layer."),
    w("pore", Reference("material"), Optional, "Medium between the bodies."),
    w("material", Reference("material"), Optional, "Medium of a homogeneous layer; the same as `pore`, without bodies."),
    w("surface", Reference("surface"), Default("smooth"), "Law of the layer's upper plane, where media differ."),
    w("name", Text, Optional, "Name, for messages."),
];

pub(super) const BODY: &[A] = &[
    w("from", File, Optional, "Distribution file whose values are taken where none stand here."),
    w("name", Text, Optional, "Name, for tallies."),
    w("material", Reference("material"), Required, "Solid of the body."),
    w("surface", Reference("surface"), Default("smooth"), "Law of all surfaces of the body."),
    a("density", Number(Q::Density), POS, Default("1500 kg/m3"), "Density of the solid."),
    w("orientation", Choice(&["uniform", "von-mises", "wrapped-cauchy", "isotropic"]), Default("uniform"), "Law of the axis: in the plane with this azimuth law, or isotropic in space."),
    a("mean-direction", Number(Q::Angle), Range::closed(-2.0 * PI, 2.0 * PI), Default("0 deg"), "Preferred azimuth from the machine direction x."),
    a("kappa", Number(Q::Number), NOT_NEG, Optional, "Concentration of `von-mises`."),
    a("rho", Number(Q::Number), Range::below(0.0, 1.0), Optional, "Concentration of `wrapped-cauchy`."),
    a("tilt", Number(Q::Angle), Range::closed(0.0, PI / 2.0), Default("0 deg"), "Standard deviation of the normal law by which axes leave the plane."),
    w("roll", Choice(&["flat", "uniform", "normal"]), Default("flat"), "Law of the roll of the section about the axis."),
    a("roll-sd", Number(Q::Angle), POS, Optional, "Standard deviation of roll `normal`."),
    a("grammage", Number(Q::Grammage), POS, Optional, "Amount: mass of solid really there after overlaps, over sheet area."),
    a("number-density", Number(Q::NumberDensity), POS, Optional, "Amount: number over volume."),
    a("volume-fraction", Number(Q::Fraction), Range::open(0.0, 1.0), Optional, "Amount: volume of bodies (wall and lumen) after overlaps over that of the layer."),
];

pub(super) const FIBRES: &[A] = &[
    a("width", Number(Q::Length), POS, Optional, "Full major axis of the section; or a law in a child."),
    a("flatness", Number(Q::Number), Range::above(0.0, 1.0), Optional, "Height of the section over its width (without it 1); or a law in a child."),
    a("wall", NumberOr(Q::Length, &["solid"]), POS, Optional, "Wall thickness, or `solid`; or a law in a child."),
    a("length", Number(Q::Length), POS, Optional, "Fibre length (without it 1 mm), for `number-density` and `ends`; or a law in a child."),
    w("ends", Choice(&["unbounded", "flat"]), Default("unbounded"), "Fibres without ends, or cut off flat at their length, the lumen open."),
    a("bonded", Number(Q::Fraction), Range::below(0.0, 1.0), Default("0"), "Relative bonded area: share of the outer surface in optical contact with another fibre (memory `none`)."),
    a("coarseness", Number(Q::Coarseness), POS, Optional, "Mass over length; checked against density × mean wall area."),
    w("lumen", Reference("material"), Optional, "Medium inside the lumen; without it that of the pores."),
    a("length-density", Number(Q::LengthDensity), POS, Optional, "Amount: fibre length over volume."),
];

pub(super) const PARTICLES: &[A] = &[
    w("shape", Choice(&["sphere", "ellipsoid", "disc"]), Required, "Shape."),
    a("diameter", Number(Q::Length), POS, Optional, "Sphere, disc: diameter; or a law in a child."),
    a("thickness", Number(Q::Length), POS, Optional, "Disc: thickness, across the sheet if not tilted; or a law in a child."),
    a("a", Number(Q::Length), POS, Optional, "Ellipsoid: full axis along the azimuth; or a law in a child."),
    a("b", Number(Q::Length), POS, Optional, "Ellipsoid: full axis across it (in the plane of the sheet if roll is `flat`); or a law in a child."),
    a("c", Number(Q::Length), POS, Optional, "Ellipsoid: third full axis; or a law in a child."),
];

pub(super) const LAW: &[A] = &[
    w("law", Choice(SIZES), Required, "Law."),
    a("shape", Number(Q::Number), POS, Optional, "gamma, weibull: shape."),
    a("sigma", Number(Q::Number), POS, Optional, "lognormal: standard deviation of the logarithm."),
    a("alpha", Number(Q::Number), POS, Optional, "beta: first exponent."),
    a("beta", Number(Q::Number), POS, Optional, "beta: second exponent."),
    w("file", File, Optional, "histogram: CSV with columns from, to, weight in the internal unit (um)."),
    a("weights", List(Q::Number, None), NOT_NEG, Optional, "histogram: weights between the `edges`."),
    w("weighted", Choice(&["number", "length", "mass"]), Default("number"), "How the law was measured: each particle counts once, by its length, or by its mass; converted to number."),
];
pub(super) const LAW_LENGTH: &[A] = &[
    a("value", Number(Q::Length), POS, Optional, "constant: the value."),
    a("from", Number(Q::Length), NOT_NEG, Optional, "uniform, truncated-normal, beta: lower end."),
    a("to", Number(Q::Length), POS, Optional, "uniform, truncated-normal, beta: upper end."),
    a("mean", Number(Q::Length), POS, Optional, "truncated-normal (before truncation), gamma: mean."),
    a("sd", Number(Q::Length), POS, Optional, "truncated-normal: standard deviation before truncation."),
    a("median", Number(Q::Length), POS, Optional, "lognormal: median."),
    a("scale", Number(Q::Length), POS, Optional, "weibull: scale."),
    a("edges", List(Q::Length, None), NOT_NEG, Optional, "histogram: edges, one more than `weights`."),
];
pub(super) const LAW_NUMBER: &[A] = &[
    a("value", Number(Q::Number), POS, Optional, "constant: the value."),
    a("from", Number(Q::Number), NOT_NEG, Optional, "uniform, truncated-normal, beta: lower end."),
    a("to", Number(Q::Number), POS, Optional, "uniform, truncated-normal, beta: upper end."),
    a("mean", Number(Q::Number), POS, Optional, "truncated-normal (before truncation), gamma: mean."),
    a("sd", Number(Q::Number), POS, Optional, "truncated-normal: standard deviation before truncation."),
    a("median", Number(Q::Number), POS, Optional, "lognormal: median."),
    a("scale", Number(Q::Number), POS, Optional, "weibull: scale."),
    a("edges", List(Q::Number, None), NOT_NEG, Optional, "histogram: edges, one more than `weights`."),
];
pub(super) const PART: &[A] = &[a("share", Number(Q::Fraction), Range::above(0.0, 1.0), Required, "Share of the mixture; shares sum to 1.")];

pub(super) const EXPLICIT: &[A] = &[
    w("name", Text, Optional, "Name, for tallies."),
    w("material", Reference("material"), Required, "Medium inside."),
    w("surface", Reference("surface"), Default("smooth"), "Law of the surface."),
    w("priority", Integer, Default("0"), "The higher wins where bodies overlap; the later at equal priority."),
];
pub(super) const CENTRE: &[A] = &[a("centre", List(Q::Length, Some(3)), ANY, Default("0 0 0 um"), "Centre: x, y, z.")];
pub(super) const AXES: &[A] = &[
    a("axis", List(Q::Number, Some(3)), ANY, Optional, "Direction of the axis, any length (ellipsoid: third half axis, without it 0 0 1; cylinder: without it 1 0 0)."),
    a("major", List(Q::Number, Some(3)), ANY, Optional, "Direction of the first half axis; its part across `axis` counts (without it the horizontal one)."),
];

pub(super) const SOURCE: &[A] = &[
    w("kind", Choice(&["collimated", "diffuse", "point"]), Default("collimated"), "Parallel light, Lambertian light, or a point that emits into a cone."),
    a("polar", Number(Q::Angle), Range::closed(0.0, PI), Default("0 deg"), "Collimated: angle from the normal; below 90 deg for a sheet."),
    a("azimuth", Number(Q::Angle), Range::closed(-2.0 * PI, 2.0 * PI), Default("0 deg"), "Collimated: azimuth of where light comes from."),
    a("radius", Number(Q::Length), NOT_NEG, Default("0 um"), "Collimated: radius of the beam; 0 is a pencil."),
    a("trap", Number(Q::Angle), Range::below(0.0, PI / 2.0), Default("0 deg"), "Diffuse: half angle of the dark cone around the normal (gloss trap; ISO 2469: 15.5 deg)."),
    w("polarisation", Choice(&["none", "linear", "left", "right"]), Default("none"), "Collimated: state of the light; `right` is circular with V > 0 (Bohren & Huffman)."),
    a("field", Number(Q::Angle), Range::closed(-2.0 * PI, 2.0 * PI), Default("0 deg"), "Linear: angle of the field from the plane of incidence (at polar 0 the plane through `azimuth`: 0 deg is the machine direction, 90 deg the cross direction)."),
    a("degree", Number(Q::Fraction), SHARE, Default("1"), "Polarised share of the power."),
    a("position", List(Q::Length, Some(3)), ANY, Optional, "Point: where it is."),
    a("target", List(Q::Length, Some(3)), ANY, Default("0 0 0 um"), "Point: where it aims."),
    a("half-angle", Number(Q::Angle), Range::closed(0.0, PI), Default("0 deg"), "Point: half angle of the cone; 0 is one direction, 180 deg all."),
];

pub(super) const SPECTRUM: &[A] = &[
    a("at", List(Q::Wavelength, None), NM, Optional, "Wavelengths, as \"550 nm\" or \"450 550 650 nm\"."),
    a("from", Number(Q::Wavelength), NM, Optional, "First wavelength of a grid."),
    a("to", Number(Q::Wavelength), NM, Optional, "Last wavelength of a grid."),
    a("step", Number(Q::Wavelength), POS, Optional, "Step of the grid."),
];

pub(super) const DETECT: &[A] = &[
    w("total", Choice(&["yes"]), Default("yes"), "Reflectance, transmittance, absorptance: always."),
    a("angular", Nside, Range::closed(1.0, 256.0), Optional, "Angular distribution in HEALPix bins."),
    a("depth", Number(Q::Count), Range::closed(1.0, 1e5), Optional, "Absorption and fluence over this many depth bins."),
    a("checkpoint", Number(Q::Length), ANY, Optional, "Height of a plane that scores rays going up."),
    w("analyser", Choice(&["none", "parallel", "perpendicular"]), Default("none"), "Ideal polariser before the detectors of what leaves: passes the field in the plane of the ray and the normal of the sheet, or across it."),
    w("time", YES_NO, Default("no"), "Mean time of flight of reflected and transmitted light."),
    w("path", YES_NO, Default("no"), "Mean path and collisions by medium."),
    w("gloss", YES_NO, Default("no"), "Specular gloss of parallel light (20, 60 or 75 deg): power in the receiver's window about the mirror direction over that of black glass (n = 1.540; at 60 deg 1.567, as ISO 2813 has it), times 100."),
    a("gloss-aperture", List(Q::Angle, None), Range::above(0.0, PI / 2.0), Optional, "Full opening of that window: one angle for a circle, two for a rectangle in and across the plane of incidence. Without it 5 deg at 20 deg (TAPPI T653), 4.4 and 11.7 deg at 60 deg (ISO 2813), 11.42 deg elsewhere (TAPPI T480)."),
    a("haze", Number(Q::Angle), Range::above(0.0, PI / 2.0), Optional, "Share of the transmitted parallel light that is turned by more than this angle (ASTM D1003: 2.5 deg)."),
    a("lateral", Number(Q::Length), POS, Optional, "Lateral spread of light that enters at one point: point spread, edge response and modulation transfer within this radius."),
    a("rings", Number(Q::Count), Range::closed(1.0, 1e4), Default("50"), "Rings of the point spread function."),
    a("path-histogram", Number(Q::Length), POS, Optional, "Histograms of path length up to this one, and of time of flight, of the light that leaves."),
    a("path-bins", Number(Q::Count), Range::closed(1.0, 1e5), Default("100"), "Bins of these histograms."),
    w("klems", YES_NO, Default("no"), "BRDF and BTDF between all 145 × 145 patches of the Klems basis (bsdf.xml), and how far the BRDF is from reciprocal (`brdf_reciprocity_defect`); needs diffuse light without a trap and one wavelength."),
];

pub(super) const HALFTONE: &[A] = &[
    a("coverage", Number(Q::Fraction), SHARE, Required, "Share of the area under ink."),
    a("period", Number(Q::Length), POS, Required, "Period of the lines of ink, which run across x."),
    a("ink", Number(Q::Fraction), SHARE, Default("0.05"), "Transmittance of the ink film for one passage."),
];

pub(super) const OPTICS: &[A] = &[
    w("geometry", Choice(&["d/0", "0/d", "45/0", "8/d", "total"]), Default("d/0"), "How the reflectance factor is measured: light/view. d/0: diffuse light viewed at 0°; 0/d: light from 0°, all that leaves outside the gloss trap; 45/0: light from 45°, viewed at 0°; 8/d: light from 8°, all that leaves; total: all reflected power of the source's light. Without a <source> 0/d, 45/0 and 8/d bring their own."),
    a("view", Number(Q::Angle), Range::above(0.0, PI / 2.0), Default("15.5 deg"), "d/0, 45/0: half angle of the viewing cone."),
    a("trap", Number(Q::Angle), Range::below(0.0, PI / 4.0), Optional, "0/d, 8/d: half angle of the gloss trap about the mirror direction; without it 15.5 deg for 0/d (ISO 2469), none for 8/d (specular included)."),
    a("backing", Number(Q::Fraction), SHARE, Optional, "RB instead of the pile: the sheet lies, with air between, over a Lambertian backing of this reflectance."),
    a("pile", Number(Q::Count), Range::closed(1.0, 1024.0), Default("16"), "Most sheets in the simulated pile."),
    a("grammage", Number(Q::Grammage), POS, Optional, "Grammage for s and k; without it that of the sheet."),
];

pub(super) const EFFECT: &[A] = &[
    w("name", Choice(EFFECTS), Required, "Which."),
    w("state", Choice(&["on", "off"]), Required, "Forced on or off."),
    w("reason", Text, Required, "Why; it stands in the plan and in the results."),
];

pub(super) const RUN: &[A] = &[
    a("histories", Number(Q::Count), Range::closed(1.0, 1e15), Default("1e5"), "Histories per wavelength group."),
    a("seed", Number(Q::Count), ANY, Default("20261122"), "Seed."),
    w("branching", Choice(&["sample", "split"]), Default("sample"), "One outgoing ray per event, or one per SAP patch above a power floor."),
    a("split-nside", Nside, Range::closed(1.0, 64.0), Default("2"), "split: granularity."),
    a("floor", Number(Q::Number), Range::open(0.0, 1.0), Default("1e-3"), "split: power floor relative to the emitted power; roulette below."),
    a("roulette", Number(Q::Number), Range::below(0.0, 1.0), Default("1e-3"), "Roulette below this share of the start power."),
    a("histories-per-realisation", Number(Q::Count), Range::closed(1.0, 4096.0), Default("1"), "Memory `full`, and realised sheets: so many histories (a power of two) share one realisation, and the variance between realisations is told apart. Realised sheets: 64 without it, or the largest power of two below that which divides `histories`."),
    a("event-cap", Number(Q::Count), Range::closed(1.0, 1e12), Default("1e6"), "Guard on the events of one history."),
    w("rng", Choice(&["pcg64dxsm", "philox"]), Default("pcg64dxsm"), "Family of the generator; another one is a check that no result leans on it, slower, and needs a build with the feature philox."),
    w("weights", Choice(&["auto", "yes", "no"]), Default("auto"), "Wavelengths whose scattering differs share their paths by weights, or each has its own; `auto`: by weights, but not through piles of sheets, whose long paths spread the weights."),
    w("absorption", Choice(&["implicit", "analog"]), Default("implicit"), "Absorption as weight along the path, or as the end of the ray."),
];

pub(super) const EXPECT: &[A] = &[
    w("quantity", Text, Required, "Name of the figure, as in result.json."),
    a("wavelength", Number(Q::Wavelength), NM, Optional, "Its wavelength, if it has one."),
    w("component", Text, Optional, "Its component, if it has one (as in result.json)."),
    a("value", Number(Q::Number), ANY, Required, "Expected value."),
    a("error", Number(Q::Number), NOT_NEG, Default("0"), "Absolute tolerance, beside 4 standard errors."),
    w("source", Text, Required, "Where the value comes from."),
];

pub(super) const DISTRIBUTION: &[A] = &[
    w("kind", Choice(&["fibres", "flakes", "filler"]), Required, "What it describes: <fibres>, body <particles>, or Mie <particles>."),
    w("name", Text, Required, "Name."),
    w("source", Text, Required, "Where the numbers come from, with their status: S seen in a source, D derived, M from memory."),
    w("licence", Text, Required, "Licence of the data."),
];
