//! Refractive index, absorption, Fresnel.
pub mod fresnel;
/// Complex refractive index over wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct RefractiveIndex {
    /// Real part.
    pub n: crate::spectrum::Spectrum,
    /// Imaginary part.
    pub k: Option<crate::spectrum::Spectrum>,
}
