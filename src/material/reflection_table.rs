//! Reflection ratios of a user's table r(λ, θ).

use crate::math::{PI, acos};
use crate::spectrum::{SpectrumError, csv};

/// Power reflectance over vacuum wavelength and angle of incidence, bilinear between the nodes of a
/// full grid; in place of Fresnel's formulas where a surface was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct ReflectionTable {
    name: String,
    nm: Vec<f64>,
    degrees: Vec<f64>,
    /// Row per wavelength, column per angle.
    ratios: Vec<f64>,
}

impl ReflectionTable {
    /// Reads the columns `wavelength_nm, angle_deg, reflectance` (comma, header or none, `#`
    /// comments): for each wavelength, ascending, the same ascending angles from 0 to 90.
    ///
    /// # Errors
    /// [`SpectrumError::Text`] with line and column of what is no number, no reflectance in [0, 1]
    /// or breaks the grid; [`SpectrumError::Invalid`] for a grid that is empty or incomplete.
    pub fn read(text: &str, name: &str) -> Result<Self, SpectrumError> {
        let rows = csv::rows::<3>(text, name)?;
        let first = rows[0].values[0];
        let degrees: Vec<f64> =
            rows.iter().take_while(|r| r.values[0] == first).map(|r| r.values[1]).collect();
        let mut nm: Vec<f64> = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            let wrong = |column: usize, what: String| {
                Err(SpectrumError::text(name, row.line, row.columns[column], what))
            };
            let ([wavelength, angle, ratio], at) = (row.values, i % degrees.len());
            if at == 0 {
                if wavelength <= nm.last().copied().unwrap_or(0.0) {
                    return wrong(0, format!("wavelengths must be positive and ascend: {wavelength} nm"));
                }
                nm.push(wavelength);
            } else if Some(&wavelength) != nm.last() {
                return wrong(
                    0,
                    format!("{} nm has {at} angles, others {}", nm[nm.len() - 1], degrees.len()),
                );
            }
            if angle != degrees[at] {
                return wrong(
                    1,
                    format!("every wavelength needs the same angles: {angle}° for {}°", degrees[at]),
                );
            }
            if at > 0 && angle <= degrees[at - 1] {
                return wrong(1, format!("angles must ascend: {angle}° follows {}°", degrees[at - 1]));
            }
            if !(0.0..=1.0).contains(&ratio) {
                return wrong(2, format!("a reflectance lies in 0 to 1, not {ratio}"));
            }
        }
        if (degrees[0], degrees[degrees.len() - 1]) != (0.0, 90.0) {
            return Err(SpectrumError::invalid(
                name,
                "angles must run from 0° to 90°: rays come at any angle",
            ));
        }
        if nm.len() * degrees.len() != rows.len() {
            return Err(SpectrumError::invalid(name, "the last wavelength lacks angles"));
        }
        Ok(ReflectionTable {
            name: name.to_owned(),
            nm,
            degrees,
            ratios: rows.iter().map(|r| r.values[2]).collect(),
        })
    }

    /// Vacuum wavelengths (nm) of the table, ascending.
    pub fn wavelengths(&self) -> &[f64] {
        &self.nm
    }

    /// Angles of incidence (degrees) of the table, ascending from 0 to 90.
    pub fn angles(&self) -> &[f64] {
        &self.degrees
    }

    /// Reflectance at the vacuum wavelength `nm` and the cosine `cos_i` of the angle of incidence,
    /// bilinear in wavelength and angle.
    ///
    /// # Errors
    /// [`SpectrumError::OutOfRange`] for a wavelength outside the table.
    pub fn at(&self, nm: f64, cos_i: f64) -> Result<f64, SpectrumError> {
        let (low, high) = (self.nm[0], self.nm[self.nm.len() - 1]);
        if !(nm >= low && nm <= high) {
            return Err(SpectrumError::OutOfRange { name: self.name.clone(), nm, low, high });
        }
        let angle = acos(cos_i) * (180.0 / PI);
        let (i, u) = cell(&self.nm, nm);
        let (j, v) = cell(&self.degrees, angle.min(90.0));
        let line = |i: usize| {
            let row = &self.ratios[i * self.degrees.len()..];
            if v == 0.0 { row[j] } else { (1.0 - v) * row[j] + v * row[j + 1] }
        };
        Ok(if u == 0.0 { line(i) } else { (1.0 - u) * line(i) + u * line(i + 1) })
    }
}

/// Cell of `x` between ascending nodes and the place in it, in [0, 1); a node itself has place 0.
fn cell(nodes: &[f64], x: f64) -> (usize, f64) {
    let i = nodes.partition_point(|n| *n <= x).saturating_sub(1);
    let next = nodes.get(i + 1).copied().unwrap_or(f64::INFINITY);
    (i, if next.is_finite() { (x - nodes[i]) / (next - nodes[i]) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "wavelength_nm,angle_deg,reflectance\n400,0,0.2\n400,45,0.3\n400,90,1\n600,0,0.4\n600,45,0.7\n600,90,1\n";

    #[test]
    fn bilinear_in_wavelength_and_angle() {
        let t = ReflectionTable::read(TEXT, "mirror").unwrap();
        let cos = |d: f64| crate::math::cos(d * PI / 180.0);
        let near = |got: f64, want: f64| assert!((got - want).abs() < 1e-14, "{got} {want}");
        near(t.at(400.0, 1.0).unwrap(), 0.2);
        near(t.at(600.0, cos(45.0)).unwrap(), 0.7);
        near(t.at(500.0, cos(22.5)).unwrap(), 0.25 * (0.2 + 0.3 + 0.4 + 0.7));
        near(t.at(450.0, cos(67.5)).unwrap(), 0.5 * (0.75 * 0.3 + 0.25 * 0.7) + 0.5);
        near(t.at(600.0, 0.0).unwrap(), 1.0);
        assert_eq!(
            t.at(399.0, 1.0).unwrap_err().to_string(),
            "mirror: no value at 399 nm, known from 400 nm to 600 nm"
        );
        assert!(t.at(f64::NAN, 1.0).is_err());
    }

    #[test]
    fn refusals_name_the_place() {
        for (text, message) in [
            ("400,0,0.1\n400,90,1.2", "t:2:8: a reflectance lies in 0 to 1, not 1.2"),
            (
                "400,0,0.1\n400,90,1\n500,0,0.1\n500,80,1",
                "t:4:5: every wavelength needs the same angles: 80° for 90°",
            ),
            ("400,0,0.1\n400,80,1", "t: angles must run from 0° to 90°: rays come at any angle"),
            (
                "400,0,0.1\n400,90,1\n300,0,1\n300,90,1",
                "t:3:1: wavelengths must be positive and ascend: 300 nm",
            ),
            ("400,0,0.1\n400,90,1\n500,0,1", "t: the last wavelength lacks angles"),
            ("400,0,0.1\n400,90,1\n500,0,1\n600,0,1", "t:4:1: 500 nm has 1 angles, others 2"),
            ("400,0,0.1\n400,0,0.1\n400,90,1", "t:2:5: angles must ascend: 0° follows 0°"),
        ] {
            assert_eq!(ReflectionTable::read(text, "t").unwrap_err().to_string(), message);
        }
    }
}
