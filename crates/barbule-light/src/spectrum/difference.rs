//! How different two colours look: CIELAB, ΔE*ab and ΔE00.

/// L*, a*, b* of X, Y, Z against a white (CIE 15:2004, section 8.2.1).
#[must_use]
pub fn lab(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    const KNEE: f64 = 24.0 / 116.0;
    let f = |ratio: f64| {
        if ratio > KNEE * KNEE * KNEE { libm::cbrt(ratio) } else { 841.0 / 108.0 * ratio + 16.0 / 116.0 }
    };
    let [x, y, z]: [f64; 3] = std::array::from_fn(|c| f(xyz[c] / white[c]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// ΔE*ab of 1976: the distance in CIELAB.
#[must_use]
pub fn delta_e_76(one: [f64; 3], other: [f64; 3]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// ΔE00, CIEDE2000 with k_L = k_C = k_H = 1, of two colours in CIELAB.
///
/// Source: Sharma, Wu & Dalal 2005, "The CIEDE2000 color-difference formula: implementation notes, supplementary test
/// data, and mathematical observations", *Color Res. Appl.* 30, 21, equations 2 to 22.
#[must_use]
pub fn delta_e_2000(one: [f64; 3], other: [f64; 3]) -> f64 {
    let seventh = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let mean_chroma = 0.5 * (one[1].hypot(one[2]) + other[1].hypot(other[2]));
    let stretch = 1.0 + 0.5 * (1.0 - seventh(mean_chroma));
    // Chroma and hue angle with the stretched a'.
    let polar = |lab: [f64; 3]| {
        let a = stretch * lab[1];
        (a.hypot(lab[2]), libm::atan2(lab[2], a).to_degrees().rem_euclid(360.0))
    };
    let ((c1, h1), (c2, h2)) = (polar(one), polar(other));
    let grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if grey => 0.0,
        turn if turn > 180.0 => turn - 360.0,
        turn if turn < -180.0 => turn + 360.0,
        turn => turn,
    };
    let mean_hue = match h1 + h2 {
        sum if grey => sum,
        sum if (h1 - h2).abs() <= 180.0 => 0.5 * sum,
        sum if sum < 360.0 => 0.5 * (sum + 360.0),
        sum => 0.5 * (sum - 360.0),
    };
    let (lightness, chroma) = (0.5 * (one[0] + other[0]), 0.5 * (c1 + c2));
    let cosine = |degrees: f64| libm::cos(degrees.to_radians());
    let t = 1.0 - 0.17 * cosine(mean_hue - 30.0)
        + 0.24 * cosine(2.0 * mean_hue)
        + 0.32 * cosine(3.0 * mean_hue + 6.0)
        - 0.20 * cosine(4.0 * mean_hue - 63.0);
    let offset = (lightness - 50.0).powi(2);
    let in_lightness = (other[0] - one[0]) / (1.0 + 0.015 * offset / (20.0 + offset).sqrt());
    let in_chroma = (c2 - c1) / (1.0 + 0.045 * chroma);
    let in_hue = 2.0 * (c1 * c2).sqrt() * libm::sin((0.5 * turn).to_radians()) / (1.0 + 0.015 * chroma * t);
    let rotation = 60.0 * libm::exp(-((mean_hue - 275.0) / 25.0).powi(2));
    let cross = -2.0 * seventh(chroma) * libm::sin(rotation.to_radians());
    (in_lightness.powi(2) + in_chroma.powi(2) + in_hue.powi(2) + cross * in_chroma * in_hue).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All pairs of table 1 of Sharma et al. 2005 (L, a, b, L, a, b, ΔE00), which go round every branch of the formula.
    const PAIRS: [[f64; 7]; 34] = [
        [50.0, 2.6772, -79.7751, 50.0, 0.0, -82.7485, 2.0425],
        [50.0, 3.1571, -77.2803, 50.0, 0.0, -82.7485, 2.8615],
        [50.0, 2.8361, -74.0200, 50.0, 0.0, -82.7485, 3.4412],
        [50.0, -1.3802, -84.2814, 50.0, 0.0, -82.7485, 1.0],
        [50.0, -1.1848, -84.8006, 50.0, 0.0, -82.7485, 1.0],
        [50.0, -0.9009, -85.5211, 50.0, 0.0, -82.7485, 1.0],
        [50.0, 0.0, 0.0, 50.0, -1.0, 2.0, 2.3669],
        [50.0, -1.0, 2.0, 50.0, 0.0, 0.0, 2.3669],
        [50.0, 2.49, -0.001, 50.0, -2.49, 0.0009, 7.1792],
        [50.0, 2.49, -0.001, 50.0, -2.49, 0.0010, 7.1792],
        [50.0, 2.49, -0.001, 50.0, -2.49, 0.0011, 7.2195],
        [50.0, 2.49, -0.001, 50.0, -2.49, 0.0012, 7.2195],
        [50.0, -0.001, 2.49, 50.0, 0.0009, -2.49, 4.8045],
        [50.0, -0.001, 2.49, 50.0, 0.0010, -2.49, 4.8045],
        [50.0, -0.001, 2.49, 50.0, 0.0011, -2.49, 4.7461],
        [50.0, 2.5, 0.0, 50.0, 0.0, -2.5, 4.3065],
        [50.0, 2.5, 0.0, 73.0, 25.0, -18.0, 27.1492],
        [50.0, 2.5, 0.0, 61.0, -5.0, 29.0, 22.8977],
        [50.0, 2.5, 0.0, 56.0, -27.0, -3.0, 31.9030],
        [50.0, 2.5, 0.0, 58.0, 24.0, 15.0, 19.4535],
        [50.0, 2.5, 0.0, 50.0, 3.1736, 0.5854, 1.0],
        [50.0, 2.5, 0.0, 50.0, 3.2972, 0.0, 1.0],
        [50.0, 2.5, 0.0, 50.0, 1.8634, 0.5757, 1.0],
        [50.0, 2.5, 0.0, 50.0, 3.2592, 0.3350, 1.0],
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
    fn ciede2000_is_that_of_the_published_pairs_in_either_order() {
        for [l1, a1, b1, l2, a2, b2, expected] in PAIRS {
            let (one, other) = ([l1, a1, b1], [l2, a2, b2]);
            // Published to four places.
            for found in [delta_e_2000(one, other), delta_e_2000(other, one)] {
                assert!((found - expected).abs() < 5.1e-5, "{one:?} {other:?}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn lab_of_white_grey_and_black_is_known() {
        let white = [0.9504, 1.0, 1.0889];
        assert_eq!(delta_e_76(lab(white, white), [100.0, 0.0, 0.0]), 0.0);
        // 18 % grey has L* = 116·0.18^(1/3) − 16; below the knee L* = 903.3 Y.
        let grey = lab(white.map(|v| 0.184_186_515_5 * v), white);
        assert!((grey[0] - 50.0).abs() < 1e-6 && grey[1].hypot(grey[2]) < 1e-12, "{grey:?}");
        let dark = lab(white.map(|v| 0.001 * v), white);
        assert!((dark[0] - 0.903_296_296_296).abs() < 1e-9);
        assert_eq!(delta_e_76([50.0, 3.0, 4.0], [50.0, 0.0, 0.0]), 5.0);
    }
}
