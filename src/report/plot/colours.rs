//! Colours that readers with any colour vision tell apart.

/// Red, green and blue, 0 to 255.
pub type Rgb = (u8, u8, u8);

/// Text and axes.
pub const INK: Rgb = (38, 38, 38);
/// Minor text.
pub const FAINT_INK: Rgb = (95, 95, 95);
/// Grid lines.
pub const GRID: Rgb = (222, 222, 222);
/// Ground.
pub const WHITE: Rgb = (255, 255, 255);
/// Incident light.
pub const INCIDENT: Rgb = (200, 60, 0);

/// Colours of curves (M. Okabe and K. Ito's set without its yellow, which is faint on white).
const SERIES: [Rgb; 7] = [
    (0, 114, 178),
    (213, 94, 0),
    (0, 158, 115),
    (204, 121, 167),
    (86, 180, 233),
    (230, 159, 0),
    (70, 70, 70),
];

/// Colour of curve `i`; they repeat after seven.
pub fn series(i: usize) -> Rgb {
    SERIES[i % SERIES.len()]
}

/// Nine stations of viridis (S. van der Walt and N. Smith, CC0): lightness rises evenly.
const VIRIDIS: [Rgb; 9] = [
    (68, 1, 84),
    (71, 45, 123),
    (59, 82, 139),
    (44, 114, 142),
    (33, 145, 140),
    (40, 174, 128),
    (94, 201, 98),
    (173, 220, 48),
    (253, 231, 37),
];

/// Colour of `t` in [0, 1] (limited to it) on the ramp from dark violet to yellow.
pub fn ramp(t: f64) -> Rgb {
    let x = t.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let i = (x as usize).min(VIRIDIS.len() - 2);
    let mix = |a: u8, b: u8| (f64::from(a) + (x - i as f64) * (f64::from(b) - f64::from(a))).round() as u8;
    let (a, b) = (VIRIDIS[i], VIRIDIS[i + 1]);
    (mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_gets_lighter_all_the_way() {
        let light = |c: Rgb| 0.2126 * f64::from(c.0) + 0.7152 * f64::from(c.1) + 0.0722 * f64::from(c.2);
        let steps: Vec<f64> = (0..=40).map(|i| light(ramp(f64::from(i) / 40.0))).collect();
        assert!(steps.windows(2).all(|w| w[1] > w[0]));
        assert_eq!(ramp(-1.0), VIRIDIS[0]);
        assert_eq!(ramp(2.0), VIRIDIS[8]);
    }
}
