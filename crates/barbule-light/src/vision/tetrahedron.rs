//! Where a colour lies among those of four cones.

use super::Catches;

/// A place in the tetrahedron of four cones (Goldsmith 1990; Endler & Mielke 2005; Stoddard & Prum 2008, *Am. Nat.* 171, 755): colours without
/// any hue are at its centre, which is the origin, those that one cone alone sees at a corner, 3/4 away from it; the ultraviolet one is up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tetrahedral {
    /// The shares of the cones from short to long wavelengths, which sum to 1.
    pub shares: [f64; 4],
    /// x (from the short to the long cone's corner), y (towards the middle one's) and z (towards the ultraviolet one's).
    pub xyz: [f64; 3],
    /// Hue about the axis of the ultraviolet, from x towards y, −180 to 180°.
    pub theta_deg: f64,
    /// Hue towards the ultraviolet, −90 to 90°.
    pub phi_deg: f64,
    /// Chroma: distance from the centre, 0 to 3/4.
    pub r: f64,
    /// The same over the largest one that its hue can have.
    pub achieved: f64,
}

impl Tetrahedral {
    /// The place of catches; none unless there are four cones whose catches are not below 0 and not all 0.
    #[must_use]
    pub fn of(catches: &Catches) -> Option<Self> {
        let [u, s, m, l] = catches.cones[..] else { return None };
        let sum = u + s + m + l;
        if [u, s, m, l].iter().any(|q| *q < 0.0) || sum <= 0.0 {
            return None;
        }
        let shares = [u, s, m, l].map(|q| q / sum);
        let [u, s, m, _] = shares;
        let x = 0.5 * (1.0 - 2.0 * s - m - u) * 1.5_f64.sqrt();
        let y = (-1.0 + 3.0 * m + u) / 8.0_f64.sqrt();
        let z = u - 0.25;
        let r = (x * x + y * y + z * z).sqrt();
        let phi = if r > 0.0 { (z / r).clamp(-1.0, 1.0).asin() } else { 0.0 };
        let least = shares.into_iter().fold(f64::INFINITY, f64::min);
        Some(Self {
            shares,
            xyz: [x, y, z],
            theta_deg: y.atan2(x).to_degrees(),
            phi_deg: phi.to_degrees(),
            r,
            achieved: 1.0 - 4.0 * least,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(cones: [f64; 4]) -> Tetrahedral {
        Tetrahedral::of(&Catches { cones: cones.to_vec(), double: None }).unwrap()
    }

    #[test]
    fn corners_are_as_far_from_the_centre_and_from_each_other() {
        let corners =
            [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        let corners = corners.map(of);
        for (i, one) in corners.iter().enumerate() {
            assert!((one.r - 0.75).abs() < 1e-12 && (one.achieved - 1.0).abs() < 1e-12);
            for other in &corners[..i] {
                let apart: f64 = one.xyz.iter().zip(other.xyz).map(|(a, b)| (a - b) * (a - b)).sum();
                assert!((apart.sqrt() - 1.5_f64.sqrt()).abs() < 1e-12);
            }
        }
        assert_eq!(corners[0].phi_deg, 90.0);
        assert!((corners[2].theta_deg - 90.0).abs() < 1e-9);
        assert!((corners[3].theta_deg + 30.0).abs() < 1e-9 && (corners[1].theta_deg + 150.0).abs() < 1e-9);
    }

    #[test]
    fn greys_are_at_the_centre_however_bright() {
        for q in [0.01, 0.5, 20.0] {
            let grey = of([q; 4]);
            assert!(grey.r < 1e-15 && grey.achieved.abs() < 1e-15 && grey.phi_deg.is_finite());
        }
        let none = |cones: &[f64]| Tetrahedral::of(&Catches { cones: cones.to_vec(), double: None });
        assert_eq!([none(&[1.0; 3]), none(&[0.0; 4]), none(&[1.0, 1.0, 1.0, -0.1])], [None; 3]);
    }

    #[test]
    fn the_largest_chroma_of_a_hue_is_on_a_face() {
        let inside = of([0.4, 0.25, 0.22, 0.13]);
        // Away from the centre until the first share is 0.
        let t = 1.0 / inside.achieved;
        let face = of(inside.shares.map(|share| (0.25 + t * (share - 0.25)).max(0.0)));
        assert!((face.r / inside.r - t).abs() < 1e-12 && (face.theta_deg - inside.theta_deg).abs() < 1e-9);
        assert!((face.achieved - 1.0).abs() < 1e-12);
    }
}
