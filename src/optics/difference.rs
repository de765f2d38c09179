//! Colour differences between two sheets.

use super::colour::Lab;
use crate::math::{atan2, cos, exp, sin};

/// ΔE*ab: Euclidean distance in CIE 1976 L*a*b* (ISO 11664-4).
pub fn delta_e_ab(one: Lab, two: Lab) -> f64 {
    let (l, a, b) = (one.l - two.l, one.a - two.a, one.b - two.b);
    (l * l + a * a + b * b).sqrt()
}

/// ΔE00, CIEDE2000 with kL = kC = kH = 1 (ISO 11664-6), in the form of G. Sharma, W. Wu and
/// E. N. Dalal, Color Res. Appl. 30 (2005) 21, doi:10.1002/col.20070. Symmetric in its arguments.
pub fn delta_e_2000(one: Lab, two: Lab) -> f64 {
    const DEGREE: f64 = std::f64::consts::PI / 180.0;
    let chroma = |a: f64, b: f64| (a * a + b * b).sqrt();
    // 1 − √(C⁷/(C⁷ + 25⁷)), which grows a* near the neutral axis.
    let seventh = |c: f64| {
        let c7 = (c * c) * (c * c) * (c * c) * c;
        (c7 / (c7 + 6_103_515_625.0)).sqrt()
    };
    let stretch = 1.5 - 0.5 * seventh(0.5 * (chroma(one.a, one.b) + chroma(two.a, two.b)));
    let (a1, a2) = (stretch * one.a, stretch * two.a);
    let (c1, c2) = (chroma(a1, one.b), chroma(a2, two.b));
    let hue = |a: f64, b: f64| {
        let h = if a == 0.0 && b == 0.0 { 0.0 } else { atan2(b, a) / DEGREE };
        if h < 0.0 { h + 360.0 } else { h }
    };
    let (h1, h2) = (hue(a1, one.b), hue(a2, two.b));

    let grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if grey => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let (dl, dc) = (two.l - one.l, c2 - c1);
    let dh = 2.0 * (c1 * c2).sqrt() * sin(0.5 * turn * DEGREE);

    let l = 0.5 * (one.l + two.l);
    let c = 0.5 * (c1 + c2);
    let h = match h1 + h2 {
        sum if grey => sum,
        sum if (h1 - h2).abs() <= 180.0 => 0.5 * sum,
        sum if sum < 360.0 => 0.5 * (sum + 360.0),
        sum => 0.5 * (sum - 360.0),
    };
    let t = 1.0 - 0.17 * cos((h - 30.0) * DEGREE)
        + 0.24 * cos(2.0 * h * DEGREE)
        + 0.32 * cos((3.0 * h + 6.0) * DEGREE)
        - 0.20 * cos((4.0 * h - 63.0) * DEGREE);
    let bend = (h - 275.0) / 25.0;
    let rotation = -2.0 * seventh(c) * sin(60.0 * DEGREE * exp(-bend * bend));
    let dark = (l - 50.0) * (l - 50.0);
    let s_l = 1.0 + 0.015 * dark / (20.0 + dark).sqrt();
    let (s_c, s_h) = (1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let (u, v, w) = (dl / s_l, dc / s_c, dh / s_h);
    (u * u + v * v + w * w + rotation * v * w).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The 34 pairs of Sharma, Wu and Dalal (2005), table 1: L, a, b of both and ΔE00.
    #[rustfmt::skip]
    const PAIRS: [[f64; 7]; 34] = [
        [50.0, 2.6772, -79.7751, 50.0, 0.0, -82.7485, 2.0425],
        [50.0, 3.1571, -77.2803, 50.0, 0.0, -82.7485, 2.8615],
        [50.0, 2.8361, -74.0200, 50.0, 0.0, -82.7485, 3.4412],
        [50.0, -1.3802, -84.2814, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, -1.1848, -84.8006, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, -0.9009, -85.5211, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, 0.0, 0.0, 50.0, -1.0, 2.0, 2.3669],
        [50.0, -1.0, 2.0, 50.0, 0.0, 0.0, 2.3669],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0009, 7.1792],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0010, 7.1792],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0011, 7.2195],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0012, 7.2195],
        [50.0, -0.0010, 2.4900, 50.0, 0.0009, -2.4900, 4.8045],
        [50.0, -0.0010, 2.4900, 50.0, 0.0010, -2.4900, 4.8045],
        [50.0, -0.0010, 2.4900, 50.0, 0.0011, -2.4900, 4.7461],
        [50.0, 2.5, 0.0, 50.0, 0.0, -2.5, 4.3065],
        [50.0, 2.5, 0.0, 73.0, 25.0, -18.0, 27.1492],
        [50.0, 2.5, 0.0, 61.0, -5.0, 29.0, 22.8977],
        [50.0, 2.5, 0.0, 56.0, -27.0, -3.0, 31.9030],
        [50.0, 2.5, 0.0, 58.0, 24.0, 15.0, 19.4535],
        [50.0, 2.5, 0.0, 50.0, 3.1736, 0.5854, 1.0000],
        [50.0, 2.5, 0.0, 50.0, 3.2972, 0.0, 1.0000],
        [50.0, 2.5, 0.0, 50.0, 1.8634, 0.5757, 1.0000],
        [50.0, 2.5, 0.0, 50.0, 3.2592, 0.3350, 1.0000],
        [60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644],
        [63.0109, -31.0961, -5.8663, 62.8187, -29.7946, -4.0864, 1.2630],
        [61.2901, 3.7196, -5.3901, 61.4292, 2.2480, -4.9620, 1.8731],
        [35.0831, -44.1164, 3.7933, 35.0232, -40.0716, 1.5901, 1.8645],
        [22.7233, 20.0904, -46.6940, 23.0331, 14.9730, -42.5619, 2.0373],
        [36.4612, 47.8580, 18.3852, 36.2715, 50.5065, 21.2231, 1.4146],
        [90.8027, -2.0831, 1.4410, 91.1528, -1.6435, 0.0447, 1.4441],
        [90.9257, -0.5406, -0.9208, 88.6381, -0.8985, -0.7239, 1.5381],
        [6.7747, -0.2908, -2.4247, 5.8714, -0.0985, -2.2286, 0.6377],
        [2.0776, 0.0795, -1.1350, 0.9033, -0.0636, -0.5514, 0.9082],
    ];

    #[test]
    fn published_pairs_agree_to_the_last_printed_digit_and_are_symmetric() {
        for p in PAIRS {
            let (one, two) = (Lab { l: p[0], a: p[1], b: p[2] }, Lab { l: p[3], a: p[4], b: p[5] });
            let d = delta_e_2000(one, two);
            assert!((d - p[6]).abs() <= 5.1e-5, "{p:?}: {d}");
            assert!((delta_e_2000(two, one) - d).abs() < 1e-12);
            let moved = Lab { l: two.l + 0.01, ..two };
            assert!(p[6] < 1.5 || (delta_e_2000(one, moved) - d).abs() < 0.02);
        }
    }

    #[test]
    fn differences_of_a_colour_with_itself_vanish_and_lightness_counts() {
        let one = Lab { l: 95.0, a: 0.2, b: 1.3 };
        assert_eq!(delta_e_ab(one, one), 0.0);
        assert_eq!(delta_e_2000(one, one), 0.0);
        assert_eq!(delta_e_ab(one, Lab { l: 92.0, a: 0.2, b: 5.3 }), 5.0);
    }
}
