//! Smooth curves through points of the plane.

/// A parametric cubic spline: two derivatives are continuous, the parameter is the length of the chords.
#[derive(Debug, Clone)]
pub struct Spline {
    /// Parameters of the points, rising from 0.
    t: Vec<f64>,
    points: Vec<[f64; 2]>,
    /// Second derivatives at the points.
    curvature: Vec<[f64; 2]>,
}

impl Spline {
    /// Through `points` in order. A closed curve has its first point again at its end and no beginning; an open one keeps
    /// its first and its last piece parabolic. `None` for fewer than three points or neighbours that coincide.
    #[must_use]
    pub fn new(points: Vec<[f64; 2]>, closed: bool) -> Option<Self> {
        let mut t = vec![0.0];
        for pair in points.windows(2) {
            let step = libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            if !(step > 0.0 && step.is_finite()) {
                return None;
            }
            t.push(t[t.len() - 1] + step);
        }
        if points.len() < 3 || (closed && points.len() < 4) {
            return None;
        }
        let curvature = if closed { closed_moments(&t, &points) } else { open_moments(&t, &points) };
        Some(Self { t, points, curvature })
    }

    /// The parameters of the points.
    #[must_use]
    pub fn parameters(&self) -> &[f64] {
        &self.t
    }

    /// The point at a parameter.
    #[must_use]
    pub fn at(&self, t: f64) -> [f64; 2] {
        let right = self.t.partition_point(|&knot| knot <= t).clamp(1, self.t.len() - 1);
        let h = self.t[right] - self.t[right - 1];
        let (a, b) = ((self.t[right] - t) / h, (t - self.t[right - 1]) / h);
        std::array::from_fn(|axis| {
            let value = |i: usize| self.points[i][axis];
            let bend = |i: usize| self.curvature[i][axis];
            a * value(right - 1)
                + b * value(right)
                + ((a * a * a - a) * bend(right - 1) + (b * b * b - b) * bend(right)) * h * h / 6.0
        })
    }
}

/// The right side of the equations of continuity at point `i`: six times the second divided difference.
fn bend(t: &[f64], points: &[[f64; 2]], [before, at, after]: [usize; 3], axis: usize) -> f64 {
    let slope = |from: usize, to: usize, h: f64| (points[to][axis] - points[from][axis]) / h;
    let (left, right) = (step(t, before), step(t, at));
    6.0 * (slope(at, after, right) - slope(before, at, left))
}

fn step(t: &[f64], i: usize) -> f64 {
    t[i + 1] - t[i]
}

/// Second derivatives with those at the ends equal to their neighbours'.
fn open_moments(t: &[f64], points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let last = points.len() - 1;
    let inner = last - 1;
    let mut moments = vec![[0.0; 2]; points.len()];
    let lower: Vec<f64> = (1..=inner).map(|i| step(t, i - 1)).collect();
    let upper: Vec<f64> = (1..=inner).map(|i| step(t, i)).collect();
    let mut diagonal: Vec<f64> = (1..=inner).map(|i| 2.0 * (step(t, i - 1) + step(t, i))).collect();
    diagonal[0] += step(t, 0);
    diagonal[inner - 1] += step(t, last - 1);
    for axis in [0, 1] {
        let right: Vec<f64> = (1..=inner).map(|i| bend(t, points, [i - 1, i, i + 1], axis)).collect();
        for (i, value) in tridiagonal(&lower, &diagonal, &upper, right).into_iter().enumerate() {
            moments[i + 1][axis] = value;
        }
        moments[0][axis] = moments[1][axis];
        moments[last][axis] = moments[last - 1][axis];
    }
    moments
}

/// Second derivatives of a closed curve: a tridiagonal system with two corners, by Sherman and Morrison's formula.
fn closed_moments(t: &[f64], points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let count = points.len() - 1;
    let before = |i: usize| (i + count - 1) % count;
    let lower: Vec<f64> = (0..count).map(|i| step(t, before(i))).collect();
    let upper: Vec<f64> = (0..count).map(|i| step(t, i)).collect();
    let mut diagonal: Vec<f64> = (0..count).map(|i| 2.0 * (lower[i] + upper[i])).collect();
    let (corner, gamma) = (lower[0], -diagonal[0]);
    diagonal[0] -= gamma;
    diagonal[count - 1] -= corner * corner / gamma;
    let mut ends = vec![0.0; count];
    (ends[0], ends[count - 1]) = (gamma, corner);
    let z = tridiagonal(&lower, &diagonal, &upper, ends);
    let mut moments = vec![[0.0; 2]; count + 1];
    for axis in [0, 1] {
        let right = (0..count).map(|i| bend_closed(t, points, [before(i), i], axis)).collect();
        let y = tridiagonal(&lower, &diagonal, &upper, right);
        let over = |v: &[f64]| v[0] + corner / gamma * v[count - 1];
        let factor = over(&y) / (1.0 + over(&z));
        for i in 0..count {
            moments[i][axis] = y[i] - factor * z[i];
        }
        moments[count][axis] = moments[0][axis];
    }
    moments
}

fn bend_closed(t: &[f64], points: &[[f64; 2]], [before, at]: [usize; 2], axis: usize) -> f64 {
    let slope = |i: usize| (points[i + 1][axis] - points[i][axis]) / step(t, i);
    6.0 * (slope(at) - slope(before))
}

/// Solves a tridiagonal system whose diagonal dominates (Thomas).
fn tridiagonal(lower: &[f64], diagonal: &[f64], upper: &[f64], mut right: Vec<f64>) -> Vec<f64> {
    let count = right.len();
    let mut pivots = diagonal.to_vec();
    for i in 1..count {
        let factor = lower[i] / pivots[i - 1];
        pivots[i] -= factor * upper[i - 1];
        right[i] -= factor * right[i - 1];
    }
    right[count - 1] /= pivots[count - 1];
    for i in (0..count - 1).rev() {
        right[i] = (right[i] - upper[i] * right[i + 1]) / pivots[i];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(count: usize, part: f64) -> Vec<[f64; 2]> {
        let angle = |i: usize| part * std::f64::consts::TAU * i as f64 / count as f64;
        (0..=count).map(|i| [angle(i).sin(), angle(i).cos()]).collect()
    }

    /// Largest distance from the unit circle.
    fn error(spline: &Spline) -> f64 {
        let end = spline.parameters()[spline.parameters().len() - 1];
        let radius = |i: u32| {
            let [x, z] = spline.at(end * f64::from(i) / 1000.0);
            (x.hypot(z) - 1.0).abs()
        };
        (0..=1000).map(radius).fold(0.0, f64::max)
    }

    #[test]
    fn circles_are_followed_to_the_fourth_order_when_closed() {
        let of = |count| error(&Spline::new(circle(count, 1.0), true).unwrap());
        let (coarse, fine) = (of(20), of(40));
        assert!(coarse < 4e-5 && (coarse / fine) > 13.0, "{coarse:e} {fine:e}");
        // The chord's sagitta at 20 points is 1.2 % of the radius; parabolic ends leave a fiftieth of it.
        let open = error(&Spline::new(circle(20, 0.999), false).unwrap());
        assert!(open < 3e-4, "{open:e}");
    }

    #[test]
    fn straight_lines_stay_straight_and_coinciding_points_are_refused() {
        let line = Spline::new(vec![[0.0, 1.0], [1.0, 1.0], [1.5, 1.0], [4.0, 1.0]], false).unwrap();
        for t in [0.0, 0.3, 1.2, 3.9] {
            assert!((line.at(t)[0] - t).abs() < 1e-14 && (line.at(t)[1] - 1.0).abs() < 1e-14);
        }
        assert!(Spline::new(vec![[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]], false).is_none());
        assert!(Spline::new(vec![[0.0, 0.0], [1.0, 0.0]], false).is_none());
    }
}
