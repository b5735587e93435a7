//! Layers of given thickness under a curve, which never cross.

use super::section::Polyline;

/// The upper boundary of what lies deeper than `depth_um` (one number for each point, measured along the normal) under a
/// curve, at the curve's own x.
///
/// It is the lower envelope of the discs of radius `depth_um` about all points of the curve, whose end segments go on as
/// lines: the normal offset where the curve is smooth, a mitre under a ridge and an arc under a groove. It is everywhere
/// at least `depth_um` below the curve, so layers made one under the other cannot cross.
pub(super) fn under(curve: &Polyline, depth_um: &[f64]) -> Polyline {
    let (xs, zs) = (&curve.x_um, &curve.z_um);
    let last = xs.len() - 1;
    let segments: Vec<Segment> = (0..last)
        .map(|i| {
            let (dx, dz) = (xs[i + 1] - xs[i], zs[i + 1] - zs[i]);
            let length = libm::hypot(dx, dz);
            let depth = 0.5 * (depth_um[i] + depth_um[i + 1]);
            Segment { slope: dz / dx, shift: depth * dz / length, drop: depth * dx / length }
        })
        .collect();
    // No point of the offset comes from farther away than the steepest segment's.
    let reach = segments.iter().fold(0.0, |reach: f64, segment| reach.max(segment.shift.abs()));
    let mut first = 0;
    let z_um = xs
        .iter()
        .enumerate()
        .map(|(j, &x)| {
            while first + 1 < last && xs[first + 1] < x - reach {
                first += 1;
            }
            let mut lowest = zs[j] - depth_um[j];
            for i in first..last {
                if xs[i] > x + reach {
                    break;
                }
                // The point of the segment's line whose offset lies at x.
                let foot = x - segments[i].shift;
                let within = (i == 0 || foot >= xs[i]) && (i + 1 == last || foot <= xs[i + 1]);
                if within {
                    lowest = lowest.min(zs[i] + segments[i].slope * (foot - xs[i]) - segments[i].drop);
                }
                let room = depth_um[i] * depth_um[i] - (x - xs[i]) * (x - xs[i]);
                if room > 0.0 {
                    lowest = lowest.min(zs[i] - libm::sqrt(room));
                }
            }
            lowest
        })
        .collect();
    Polyline { x_um: xs.clone(), z_um }
}

/// A segment with the way of its offset: `shift` in x and `drop` in −z.
struct Segment {
    slope: f64,
    shift: f64,
    drop: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::curve::grid;

    fn curve(height: impl Fn(f64) -> f64) -> Polyline {
        let x_um = grid(10.0, 1001);
        Polyline { z_um: x_um.iter().map(|&x| height(x)).collect(), x_um }
    }

    #[test]
    fn a_flat_curve_is_moved_down_and_a_line_along_its_normal() {
        let flat = under(&curve(|_| 0.5), &[0.3; 1001]);
        assert!(flat.z_um.iter().all(|&z| z == 0.5 - 0.3));
        let line = under(&curve(|x| 0.5 * x), &[0.3; 1001]);
        for (&x, &z) in line.x_um.iter().zip(&line.z_um) {
            assert!(((0.5 * x - z) / libm::sqrt(1.25) - 0.3).abs() < 1e-13, "{x} {z}");
        }
    }

    /// Chords of a circle of 6 µm lie up to 4e-6 µm below it where it slopes by 48°.
    #[test]
    fn under_a_circle_lies_a_smaller_one_and_depths_add_up() {
        let circle = curve(|x| libm::sqrt(36.0 - x * x));
        let once = under(&circle, &[0.5; 1001]);
        let twice = under(&under(&circle, &[0.2; 1001]), &[0.3; 1001]);
        for (j, &x) in circle.x_um.iter().enumerate().filter(|(_, x)| x.abs() < 4.0) {
            assert!((once.z_um[j] - libm::sqrt(30.25 - x * x)).abs() < 1e-5, "{x}");
            assert!((once.z_um[j] - twice.z_um[j]).abs() < 2e-5, "{x}");
        }
    }

    #[test]
    fn a_ridge_gives_a_mitre_and_a_groove_an_arc() {
        let ridge = under(&curve(|x| -x.abs()), &[0.4; 1001]);
        let groove = under(&curve(f64::abs), &[0.4; 1001]);
        for (j, &x) in ridge.x_um.iter().enumerate() {
            let mitre = -x.abs() - 0.4 * libm::sqrt(2.0);
            assert!((ridge.z_um[j] - mitre).abs() < 1e-12, "{x}");
            let arc = if x.abs() < 0.4 * libm::sqrt(0.5) {
                -libm::sqrt(0.16 - x * x)
            } else {
                x.abs() - 0.4 * libm::sqrt(2.0)
            };
            assert!((groove.z_um[j] - arc).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn whatever_the_curve_and_the_depths_nothing_comes_nearer() {
        let rough = curve(|x| 0.4 * libm::sin(9.0 * x) + 0.2 * libm::sin(31.0 * x));
        let depth: Vec<f64> = rough.x_um.iter().map(|x| 0.1 + 0.05 * libm::sin(17.0 * x)).collect();
        let below = under(&rough, &depth);
        for (j, &x) in below.x_um.iter().enumerate() {
            assert!(below.z_um[j] <= rough.z_um[j] - depth[j]);
            for (i, &other) in rough.x_um.iter().enumerate().filter(|(_, o)| (x - **o).abs() < 0.2) {
                let distance = libm::hypot(x - other, rough.z_um[i] - below.z_um[j]);
                assert!(distance > depth[i] - 1e-12, "{x} {other}");
            }
        }
    }
}
