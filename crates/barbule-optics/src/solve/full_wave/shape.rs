//! Pieces of curves.

use std::f64::consts::{PI, TAU};

/// Powers of the polynomials of smooth pieces.
const POWERS: usize = 8;

/// The power by which parameters crowd to corners.
const CROWDING: i32 = 3;

/// A straight, circular or smooth piece of a curve, over s ∈ \[−1, 1\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// From one point to another.
    Line {
        /// Where it starts, µm.
        from: [f64; 2],
        /// Where it ends, µm.
        to: [f64; 2],
    },
    /// Around a centre, against the angle: from +z towards +x, so that its normal leads outwards.
    Arc {
        /// Centre, µm.
        centre: [f64; 2],
        /// Radius, µm.
        radius_um: f64,
        /// Where it starts and ends, rad from +z towards +x.
        turn: [f64; 2],
    },
    /// A polynomial in s.
    Smooth {
        /// Of each power, µm.
        coefficients: [[f64; 2]; POWERS],
    },
}

/// A point of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    /// Position (x, z), µm.
    pub(super) at: [f64; 2],
    /// Unit tangent (x, z).
    pub(super) tangent: [f64; 2],
}

/// The way from a source to a target, and its parts along the normals of both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chord {
    /// (x, z), µm.
    pub(super) way: [f64; 2],
    /// Along the target's normal, µm.
    pub(super) target_normal: f64,
    /// Along the source's normal, µm.
    pub(super) source_normal: f64,
}

impl Chord {
    /// From one point to another.
    pub(super) fn between(target: &Point, source: &Point) -> Self {
        let way = [target.at[0] - source.at[0], target.at[1] - source.at[1]];
        let along = |normal: [f64; 2]| normal[0] * way[0] + normal[1] * way[1];
        Self { way, target_normal: along(target.normal()), source_normal: along(source.normal()) }
    }
}

impl Point {
    /// The unit normal, to the left of the tangent as seen with x to the right and z up.
    pub(super) fn normal(&self) -> [f64; 2] {
        [-self.tangent[1], self.tangent[0]]
    }
}

impl Shape {
    /// The polynomial through a curve, of its part of parameters from `from` to `to`; its ends are the curve's.
    pub(super) fn smooth(curve: impl Fn(f64) -> [f64; 2], from: f64, to: f64) -> Self {
        let nodes: [f64; POWERS] = std::array::from_fn(|i| -libm::cos(PI * i as f64 / (POWERS - 1) as f64));
        // Newton's divided differences, then powers.
        let mut differences = nodes.map(|s| curve(from + 0.5 * (1.0 + s) * (to - from)));
        for level in 1..POWERS {
            for i in (level..POWERS).rev() {
                let span = nodes[i] - nodes[i - level];
                differences[i] = [0, 1].map(|axis| (differences[i][axis] - differences[i - 1][axis]) / span);
            }
        }
        let mut coefficients = [[0.0; 2]; POWERS];
        for i in (0..POWERS).rev() {
            for axis in 0..2 {
                for power in (1..POWERS).rev() {
                    coefficients[power][axis] =
                        coefficients[power - 1][axis] - nodes[i] * coefficients[power][axis];
                }
                coefficients[0][axis] = differences[i][axis] - nodes[i] * coefficients[0][axis];
            }
        }
        Self::Smooth { coefficients }
    }

    /// Length per unit of s at a parameter, µm.
    pub(super) fn speed_um(&self, s: f64) -> f64 {
        match self {
            Self::Line { from, to } => 0.5 * libm::hypot(to[0] - from[0], to[1] - from[1]),
            Self::Arc { radius_um, turn, .. } => 0.5 * radius_um * (turn[1] - turn[0]),
            Self::Smooth { coefficients } => {
                let [dx, dz] = slope(coefficients, s);
                libm::hypot(dx, dz)
            }
        }
    }

    pub(super) fn length_um(&self) -> f64 {
        match self {
            Self::Line { .. } | Self::Arc { .. } => 2.0 * self.speed_um(0.0),
            // Gauss's rule of four nodes.
            Self::Smooth { .. } => [
                (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
                (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
            ]
            .iter()
            .map(|&(s, weight)| weight * (self.speed_um(-s) + self.speed_um(s)))
            .sum(),
        }
    }

    pub(super) fn point(&self, s: f64) -> Point {
        let t = 0.5 * (1.0 + s);
        match *self {
            Self::Line { from, to } => {
                let (dx, dz) = (to[0] - from[0], to[1] - from[1]);
                let length = libm::hypot(dx, dz);
                Point { at: [from[0] + t * dx, from[1] + t * dz], tangent: [dx / length, dz / length] }
            }
            Self::Arc { centre, radius_um, turn } => {
                let (sin, cos) = libm::sincos(turn[0] + t * (turn[1] - turn[0]));
                Point { at: [centre[0] + radius_um * sin, centre[1] + radius_um * cos], tangent: [cos, -sin] }
            }
            Self::Smooth { ref coefficients } => {
                let [dx, dz] = slope(coefficients, s);
                let length = libm::hypot(dx, dz);
                Point { at: value(coefficients, s), tangent: [dx / length, dz / length] }
            }
        }
    }

    /// The way from parameter `source` to parameter `target`, exact however close they are.
    pub(super) fn chord(&self, target: f64, source: f64) -> Chord {
        let part = 0.5 * (target - source);
        match *self {
            Self::Line { from, to } => Chord {
                way: [part * (to[0] - from[0]), part * (to[1] - from[1])],
                target_normal: 0.0,
                source_normal: 0.0,
            },
            Self::Arc { radius_um, turn, .. } => {
                let half = 0.5 * part * (turn[1] - turn[0]);
                let middle = turn[0] + (0.5 + 0.25 * (target + source)) * (turn[1] - turn[0]);
                let (sin, cos) = libm::sincos(middle);
                let across = libm::sin(half);
                let sagitta = 2.0 * radius_um * across * across;
                let length = 2.0 * radius_um * across;
                Chord { way: [length * cos, -length * sin], target_normal: sagitta, source_normal: -sagitta }
            }
            Self::Smooth { ref coefficients } => {
                // P(a) − P(b) = (a − b) Q, Q by Horner's rule with the quotient carried along.
                let (mut p, mut q) = (coefficients[POWERS - 1], [0.0; 2]);
                for c in coefficients[..POWERS - 1].iter().rev() {
                    for axis in 0..2 {
                        q[axis] = q[axis] * target + p[axis];
                        p[axis] = p[axis] * source + c[axis];
                    }
                }
                let way = q.map(|quotient| (target - source) * quotient);
                let along = |s: f64| {
                    let normal = self.point(s).normal();
                    normal[0] * way[0] + normal[1] * way[1]
                };
                Chord { way, target_normal: along(target), source_normal: along(source) }
            }
        }
    }

    /// The parameter of the nearest point, and its distance in µm.
    pub(super) fn nearest(&self, at: [f64; 2]) -> (f64, f64) {
        let s = match *self {
            Self::Line { from, to } => {
                let (dx, dz) = (to[0] - from[0], to[1] - from[1]);
                let along = (at[0] - from[0]) * dx + (at[1] - from[1]) * dz;
                2.0 * along / (dx * dx + dz * dz) - 1.0
            }
            Self::Arc { centre, turn, .. } => {
                let middle = 0.5 * (turn[0] + turn[1]);
                let angle = libm::atan2(at[0] - centre[0], at[1] - centre[1]) - middle;
                2.0 * (angle - TAU * (angle / TAU).round()) / (turn[1] - turn[0])
            }
            Self::Smooth { ref coefficients } => nearest_of(coefficients, at),
        };
        let s = s.clamp(-1.0, 1.0);
        let point = self.point(s).at;
        (s, libm::hypot(at[0] - point[0], at[1] - point[1]))
    }

    /// The two halves.
    pub(super) fn split(&self) -> [Self; 2] {
        self.part(0.5)
    }

    /// The same piece with its parameter crowded to its start or its end.
    pub(super) fn crowded(&self, to_start: bool) -> Self {
        let crowd = |s: f64| 2.0 * (0.5 * (1.0 + s)).powi(CROWDING) - 1.0;
        let curve = |s: f64| self.point(if to_start { crowd(s) } else { -crowd(-s) }).at;
        Self::smooth(curve, -1.0, 1.0)
    }

    /// The pieces up to and from a part `t` of its parameters.
    pub(super) fn part(&self, t: f64) -> [Self; 2] {
        match *self {
            Self::Line { from, to } => {
                let middle = [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])];
                [Self::Line { from, to: middle }, Self::Line { from: middle, to }]
            }
            Self::Arc { centre, radius_um, turn: [a, b] } => {
                let middle = a + t * (b - a);
                [[a, middle], [middle, b]].map(|turn| Self::Arc { centre, radius_um, turn })
            }
            Self::Smooth { ref coefficients } => {
                let curve = |s: f64| value(coefficients, s);
                let middle = 2.0 * t - 1.0;
                [Self::smooth(curve, -1.0, middle), Self::smooth(curve, middle, 1.0)]
            }
        }
    }
}

fn value(coefficients: &[[f64; 2]; POWERS], s: f64) -> [f64; 2] {
    let step = |sum: [f64; 2], c: &[f64; 2]| [sum[0] * s + c[0], sum[1] * s + c[1]];
    coefficients.iter().rev().fold([0.0; 2], step)
}

fn slope(coefficients: &[[f64; 2]; POWERS], s: f64) -> [f64; 2] {
    let powers = coefficients.iter().enumerate().skip(1).rev();
    powers.fold([0.0; 2], |sum, (power, c)| {
        let factor = power as f64;
        [sum[0] * s + factor * c[0], sum[1] * s + factor * c[1]]
    })
}

/// The nearest of some points of a polynomial, then Newton's steps along its tangent.
fn nearest_of(coefficients: &[[f64; 2]; POWERS], at: [f64; 2]) -> f64 {
    const SAMPLES: u32 = 8;
    let way = |s: f64| {
        let p = value(coefficients, s);
        [at[0] - p[0], at[1] - p[1]]
    };
    let square = |s: f64| {
        let [dx, dz] = way(s);
        dx * dx + dz * dz
    };
    let samples = (0..=SAMPLES).map(|i| 2.0 * f64::from(i) / f64::from(SAMPLES) - 1.0);
    let mut s = samples.min_by(|&a, &b| square(a).total_cmp(&square(b))).unwrap_or(0.0);
    for _ in 0..4 {
        let ([dx, dz], [tx, tz]) = (way(s), slope(coefficients, s));
        let square = tx * tx + tz * tz;
        // Next to a corner the parameter may stand still.
        if square > 0.0 {
            s = (s + (dx * tx + dz * tz) / square).clamp(-1.0, 1.0);
        }
    }
    s
}
