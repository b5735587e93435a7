//! Which way feathers lie, how large they are and how far they stand off: what guides say, spread harmonically over the body.

use glam::DVec3;

use super::body::{Body, Spot};
use crate::Result;
use crate::progress::Progress;
use crate::scene::go_on;

/// Least weight of an edge over the mean: obtuse triangles have negative ones, by which a solution would overshoot its guides.
const LEAST_WEIGHT: f64 = 1e-3;
/// Where the solution is good enough: residual over the right side's.
const TOLERANCE: f64 = 1e-8;
/// Most steps of the solver; a body of 100,000 corners takes some 700.
const MOST_STEPS: usize = 4000;

/// A direction that feathers near a place take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guide {
    /// The place, mm.
    pub position_mm: [f64; 3],
    /// From a feather's root to its tip; of any length.
    pub direction: [f64; 3],
    /// Which of a coat's feathers grow near it.
    pub kind: usize,
    /// Factor to their size; over 0.
    pub size: f64,
    /// Angle between the skin and their base, degrees; the coat's where none is given.
    pub erection_deg: Option<f64>,
}

impl Guide {
    /// A guide for the coat's own feathers as they are, towards the tail.
    pub const PLAIN: Self =
        Self { position_mm: [0.0; 3], direction: [0.0, -1.0, 0.0], kind: 0, size: 1.0, erection_deg: None };
}

/// At each of a body's corners values that are harmonic where no guide is.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    vectors: Vec<DVec3>,
    stature: Stature,
}

/// The logarithm of the feathers' size and their erection, degrees.
#[derive(Debug, Clone, PartialEq)]
enum Stature {
    Everywhere([f64; 2]),
    /// At each corner; the third coordinate is 0.
    Corners(Vec<DVec3>),
}

impl Field {
    /// The vectors whose coordinates solve Laplace's equation on the surface (cotangent weights; Pinkall & Polthier 1993) with
    /// those of the guides within `reach_mm`, times the guide's size, of them; the same everywhere where there is one guide. So do the
    /// logarithm of their size, and their erection, which is `erection_deg` where a guide says nothing.
    ///
    /// # Errors
    /// A stop by `progress`.
    pub fn new(
        body: &Body,
        guides: &[Guide],
        (reach_mm, erection_deg): (f64, f64),
        progress: &dyn Progress,
    ) -> Result<Self> {
        let directions: Vec<DVec3> =
            guides.iter().map(|g| DVec3::from(g.direction).normalize_or(DVec3::NEG_Y)).collect();
        let statures: Vec<DVec3> = guides
            .iter()
            .map(|g| DVec3::new(libm::log(g.size), g.erection_deg.unwrap_or(erection_deg), 0.0))
            .collect();
        let first = statures.first().copied().unwrap_or(DVec3::new(0.0, erection_deg, 0.0));
        let everywhere = Stature::Everywhere([first.x, first.y]);
        if directions.len() < 2 {
            let direction = directions.first().copied().unwrap_or(DVec3::NEG_Y);
            return Ok(Self { vectors: vec![direction; body.points.len()], stature: everywhere });
        }
        let distance = |point: DVec3, guide: &Guide| (point - DVec3::from(guide.position_mm)).length();
        let nearest = |point: DVec3| {
            let all = guides.iter().map(|guide| distance(point, guide)).enumerate();
            all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
        };
        // Of each corner the nearest guide, and whether it holds there.
        let mut of_corner: Vec<(usize, bool)> = (body.points.iter())
            .map(|&point| {
                let (index, far) = nearest(point);
                (index, far <= reach_mm * guides[index].size)
            })
            .collect();
        for (index, guide) in guides.iter().enumerate() {
            let all = body.points.iter().map(|&point| distance(point, guide)).enumerate();
            if let Some((corner, _)) = all.min_by(|a, b| a.1.total_cmp(&b.1)) {
                of_corner[corner] = (index, true);
            }
        }
        // Parts of a body without a guide keep what they begin with: that of the nearest one.
        let is_free: Vec<bool> = of_corner.iter().map(|(_, is_fixed)| !is_fixed).collect();
        let laplacian = Laplacian::new(body);
        let solved = |of: &[DVec3]| {
            laplacian.solve(of_corner.iter().map(|(index, _)| of[*index]).collect(), &is_free, progress)
        };
        let vectors = solved(&directions)?;
        let stature = match statures.iter().all(|own| *own == first) {
            true => everywhere,
            false => Stature::Corners(solved(&statures)?),
        };
        Ok(Self { vectors, stature })
    }

    /// Factor to the size of feathers, and their erection, degrees, at a place of a triangle.
    #[must_use]
    pub fn stature(&self, body: &Body, triangle: u32, weights: [f64; 3]) -> [f64; 2] {
        let [log, erection_deg] = match &self.stature {
            Stature::Everywhere(same) => *same,
            Stature::Corners(all) => {
                let corners = body.triangles[triangle as usize];
                let own: DVec3 = (0..3).map(|k| all[corners[k] as usize] * weights[k]).sum();
                [own.x, own.y]
            }
        };
        [libm::exp(log), erection_deg]
    }

    /// The direction at a point of the surface: the vector there as far as it lies in the surface; any where it stands on it.
    #[must_use]
    pub fn at(&self, body: &Body, spot: &Spot) -> DVec3 {
        let corners = body.triangles[spot.triangle as usize];
        let vector: DVec3 = (0..3).map(|k| self.vectors[corners[k] as usize] * spot.weights[k]).sum();
        let along = vector - spot.normal * spot.normal.dot(vector);
        if along.length() < 1e-6 { spot.normal.any_orthonormal_vector() } else { along.normalize() }
    }
}

/// Σ_j w_ij (u_i − u_j) at each corner.
struct Laplacian<'a> {
    body: &'a Body,
    /// Of the neighbours, in their order.
    weights: Vec<Vec<f64>>,
    sums: Vec<f64>,
}

impl<'a> Laplacian<'a> {
    fn new(body: &'a Body) -> Self {
        let mut weights: Vec<Vec<f64>> =
            (0..body.points.len() as u32).map(|i| vec![0.0; body.neighbours(i).len()]).collect();
        for triangle in &body.triangles {
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|i| triangle[(k + i) % 3]);
                let at = |corner: u32| body.points[corner as usize];
                let (to_b, to_c) = (at(b) - at(a), at(c) - at(a));
                let half = 0.5 * to_b.dot(to_c) / to_b.cross(to_c).length().max(f64::MIN_POSITIVE);
                for (one, other) in [(b, c), (c, b)] {
                    if let Ok(place) = body.neighbours(one).binary_search(&other) {
                        weights[one as usize][place] += half;
                    }
                }
            }
        }
        // Equilateral triangles have 1/√3.
        let least = LEAST_WEIGHT / 3.0_f64.sqrt();
        weights.iter_mut().flatten().for_each(|weight| *weight = weight.max(least).min(1.0 / least));
        let sums = weights.iter().map(|row| row.iter().sum()).collect();
        Self { body, weights, sums }
    }

    /// The operator on vectors that are 0 where they are fixed.
    fn apply(&self, of: &[DVec3], is_free: &[bool], to: &mut [DVec3]) {
        for (i, out) in to.iter_mut().enumerate() {
            *out = DVec3::ZERO;
            if is_free[i] {
                let near = self.body.neighbours(i as u32).iter().zip(&self.weights[i]);
                let sum: DVec3 = near.map(|(&j, &weight)| of[j as usize] * weight).sum();
                *out = of[i] * self.sums[i] - sum;
            }
        }
    }

    /// Conjugate gradients with the diagonal as preconditioner, all three coordinates at once; sums run in one order.
    ///
    /// # Errors
    /// A stop by `progress`.
    fn solve(&self, start: Vec<DVec3>, is_free: &[bool], progress: &dyn Progress) -> Result<Vec<DVec3>> {
        let count = start.len();
        let mut solution = start;
        let mut image = vec![DVec3::ZERO; count];
        self.apply(&solution, is_free, &mut image);
        let mut residual: Vec<DVec3> = image.iter().map(|v| -*v).collect();
        let scaled = |residual: &[DVec3]| -> Vec<DVec3> {
            residual.iter().zip(&self.sums).map(|(r, sum)| *r / sum.max(f64::MIN_POSITIVE)).collect()
        };
        let products = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| *a * *b).sum::<DVec3>();
        let ratio = |a: DVec3, b: DVec3| {
            let of = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
            DVec3::new(of(a.x, b.x), of(a.y, b.y), of(a.z, b.z))
        };
        let mut conditioned = scaled(&residual);
        let mut direction = conditioned.clone();
        let mut energy = products(&residual, &conditioned);
        let enough = energy * (TOLERANCE * TOLERANCE);
        for _ in 0..MOST_STEPS {
            go_on(progress)?;
            if energy.cmple(enough).all() {
                break;
            }
            self.apply(&direction, is_free, &mut image);
            let step = ratio(energy, products(&direction, &image));
            for i in 0..count {
                solution[i] += step * direction[i];
                residual[i] -= step * image[i];
            }
            conditioned = scaled(&residual);
            let next = products(&residual, &conditioned);
            let keep = ratio(next, energy);
            for i in 0..count {
                direction[i] = conditioned[i] + keep * direction[i];
            }
            energy = next;
        }
        Ok(solution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Unobserved;
    use crate::scene::geometry::Place;

    const UP: Guide =
        Guide { position_mm: [0.0, 0.0, 10.0], direction: [3.0, 0.0, 0.0], size: 0.5, ..Guide::PLAIN };

    /// One guide: its direction laid onto the sphere, which is that of the meridians about it.
    #[test]
    fn one_guide_gives_meridians() {
        let body = Body::ellipsoid([10.0; 3], &Place::HERE, 0.8);
        let field = Field::new(&body, &[UP], (1.0, 8.0), &Unobserved).unwrap();
        let [size, erection_deg] = field.stature(&body, 7, [0.2, 0.5, 0.3]);
        assert!((size - 0.5).abs() < 1e-15 && erection_deg == 8.0);
        for triangle in 0..body.triangles.len() as u32 {
            let spot = body.spot(triangle, [0.2, 0.5, 0.3]);
            let n = spot.point.normalize();
            if n.x.abs() < 0.95 {
                let meridian = (DVec3::X - n * n.x).normalize();
                let found = field.at(&body, &spot);
                assert!(found.dot(meridian) > 1.0 - 2e-4 && found.dot(spot.normal).abs() < 1e-12);
            }
        }
    }

    /// Between two caps of a sphere a harmonic function is a + b ln tan(θ/2).
    #[test]
    fn two_guides_are_joined_harmonically() {
        let body = Body::ellipsoid([10.0; 3], &Place::HERE, 0.4);
        let down = Guide {
            position_mm: [0.0, 0.0, -10.0],
            direction: [0.0, 1.0, 0.0],
            size: 0.5,
            erection_deg: Some(20.0),
            ..Guide::PLAIN
        };
        let field = Field::new(&body, &[UP, down], (8.0, 8.0), &Unobserved).unwrap();
        // A chord of 4 mm.
        let rim = 2.0 * libm::asin(0.2);
        let lean = |theta: f64| libm::log(libm::tan(0.5 * theta));
        let mut worst: f64 = 0.0;
        let Stature::Corners(statures) = &field.stature else { panic!() };
        for ((point, vector), stature) in body.points.iter().zip(&field.vectors).zip(statures) {
            let theta = libm::acos((point.z / 10.0).clamp(-1.0, 1.0)).clamp(rim, std::f64::consts::PI - rim);
            let share = 0.5 * (1.0 - lean(theta) / lean(rim));
            let expected = DVec3::X * (1.0 - share) + DVec3::Y * share;
            worst = worst.max((*vector - expected).length());
            // Erection is harmonic as directions are, from 8 to 20 degrees; sizes are alike.
            worst = worst.max((stature.y - 8.0 - 12.0 * expected.y).abs() / 12.0);
            assert!((stature.x - libm::log(0.5)).abs() < 1e-6);
        }
        // The caps end at corners, up to half an edge from the circle; that edge is 5 % of the radius.
        assert!(worst < 0.04, "{worst}");
        // All values lie between those of the guides.
        assert!(field.vectors.iter().all(|v| v.min_element() >= -1e-6 && v.max_element() <= 1.0 + 1e-6));
    }
}
