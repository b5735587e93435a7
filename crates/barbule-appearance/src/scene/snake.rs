//! A snake's body: a tube along a line, covered with rows of scales that overlap like shingles towards the tail.
//!
//! Dorsal scales stand in oblique rows, each half a scale behind its neighbours at either side; broad ventral plates close the
//! tube below. Every scale is its own patch: narrow and sunk at its root under the one before it, rounded and raised at
//! its free end, domed across, with or without a keel.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec2};

use crate::math::rng::Stream;
use crate::scene::geometry::Mesh;

/// Dorsal scales reach so far round from the back, rad; the ventral plates are between.
const FLANK: f64 = 2.2;
/// A scale's whole length over its visible one.
const OVERLAP: f64 = 1.75;
/// Length that a scale shows over its width.
const ASPECT: f64 = 1.15;
/// A scale's width over the distance of rows of scales.
const WIDTH: f64 = 1.72;
/// How far the root of a scale is sunk and its end raised, over its width.
const SUNK: f64 = 0.07;
const RAISED: f64 = 0.1;
/// Dome across, over a scale's width.
const DOME: f64 = 0.13;
/// Bow along, over a scale's width: a scale's own highlight ends within it.
const BOW: f64 = 0.12;
/// Relief is at most that of a scale of this width over the body's radius: plates below are flat.
const PLATE: f64 = 0.4;
/// Height of a keel of 1, over a scale's width.
const KEEL: f64 = 0.06;
/// Vertices across and along a scale.
const ACROSS: usize = 13;
const ALONG: usize = 12;
/// Samples of the line between two of its points.
const SAMPLES: usize = 64;
/// Radius at the ends of the line over that of its middle.
const TAPER: f64 = 0.35;

/// A snake.
#[derive(Debug, Clone, PartialEq)]
pub struct Snake {
    /// Points that guide the line, from the neck to the tail, mm; at least 2. It reaches the ends.
    pub path_mm: Vec<DVec3>,
    /// Radius of the middle, mm.
    pub radius_mm: f64,
    /// Rows of dorsal scales around the middle, odd.
    pub rows: usize,
    /// 0: smooth scales, 1: keeled ones.
    pub keel: f64,
}

/// A cubic B-spline by its arc length: its curvature is continuous, as colours in mirrors need it.
struct Line<'a> {
    path: &'a [DVec3],
    /// Arc lengths at even steps of the parameter, [`SAMPLES`] for each span.
    arc: Vec<f64>,
}

impl<'a> Line<'a> {
    fn along(path: &'a [DVec3]) -> Self {
        let mut line = Self { path, arc: vec![0.0] };
        let steps = SAMPLES * line.spans();
        let mut before = line.of(0.0).0;
        for step in 1..=steps {
            let here = line.of(step as f64 / SAMPLES as f64).0;
            line.arc.push(line.arc[step - 1] + here.distance(before));
            before = here;
        }
        line
    }

    /// The ends are held, so that the line reaches them.
    fn spans(&self) -> usize {
        self.path.len() + 1
    }

    /// Place and derivative at a parameter from 0 to the number of spans.
    fn of(&self, u: f64) -> (DVec3, DVec3) {
        let span = (u as usize).min(self.spans() - 1);
        let t = u - span as f64;
        let point = |k: usize| self.path[(span + k).saturating_sub(2).min(self.path.len() - 1)];
        let (r, [a, b, c, d]) = (1.0 - t, [point(0), point(1), point(2), point(3)]);
        let place = (r * r * r * a
            + (3.0 * t * t * t - 6.0 * t * t + 4.0) * b
            + (3.0 * r * r * r - 6.0 * r * r + 4.0) * c
            + t * t * t * d)
            / 6.0;
        let ahead =
            0.5 * (-r * r * a + (3.0 * t * t - 4.0 * t) * b - (3.0 * r * r - 4.0 * r) * c + t * t * d);
        (place, ahead)
    }

    fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// Place and direction at an arc length; straight on beyond the ends.
    fn at(&self, s: f64) -> (DVec3, DVec3) {
        let inside = s.clamp(0.0, self.length());
        let i = self.arc.partition_point(|arc| *arc <= inside).clamp(1, self.arc.len() - 1);
        let part = (inside - self.arc[i - 1]) / (self.arc[i] - self.arc[i - 1]).max(1e-12);
        let u = (i as f64 - 1.0 + part) / SAMPLES as f64;
        let (place, ahead) = self.of(u);
        // At the very ends the derivative vanishes.
        let ahead = ahead.try_normalize().unwrap_or_else(|| {
            let (from, to) = (self.of((u - 0.01).max(0.0)).0, self.of((u + 0.01).min(self.spans() as f64)).0);
            (to - from).normalize_or(DVec3::X)
        });
        (place + ahead * (s - inside), ahead)
    }
}

/// One scale: where its root is, and its size.
struct Scale {
    s: f64,
    angle: f64,
    length: f64,
    width: f64,
    keel: f64,
}

impl Snake {
    /// The scales, with tangents from the head to the tail, and v along them.
    #[must_use]
    pub fn mesh(&self, seed: u64) -> Mesh {
        let line = Line::along(&self.path_mm);
        let mut mesh = Mesh::default();
        let spacing = 2.0 * FLANK * self.radius_mm / self.rows as f64;
        let visible = ASPECT * spacing;
        let mut stream = Stream::new(seed, &[0x7363_616c]);
        let half = (self.rows / 2) as i64;
        let count = (line.length() / visible).floor() as i64;
        for k in -1..=count {
            for row in -half..=half {
                let shift = if row.rem_euclid(2) == 1 { 0.5 } else { 0.0 };
                let s = (k as f64 + shift) * visible;
                let radius = self.radius(s, line.length());
                let size = radius / self.radius_mm * (1.0 + 0.03 * stream.normal());
                let scale = Scale {
                    s,
                    angle: row as f64 * 2.0 * FLANK / self.rows as f64,
                    length: OVERLAP * visible,
                    width: WIDTH * spacing * size,
                    keel: self.keel,
                };
                self.add(&line, &scale, &mut mesh);
            }
            let s = k as f64 * visible;
            let below = Scale {
                s,
                angle: PI,
                length: 1.3 * visible,
                width: 1.15 * (TAU - 2.0 * FLANK) * self.radius(s, line.length()),
                keel: 0.0,
            };
            self.add(&line, &below, &mut mesh);
        }
        mesh
    }

    /// Thickest in the middle half, thinner towards both ends.
    fn radius(&self, s: f64, length: f64) -> f64 {
        let from_middle = (2.0 * s / length - 1.0).abs().min(1.0);
        let part = ((from_middle - 0.5) / 0.5).max(0.0);
        self.radius_mm * (1.0 - (1.0 - TAPER) * part * part)
    }

    /// A place of the skin raised by `height`.
    fn skin(&self, line: &Line<'_>, s: f64, angle: f64, height: f64) -> DVec3 {
        let (centre, ahead) = line.at(s);
        let up = (DVec3::Z - ahead * ahead.z).normalize_or(DVec3::Y);
        let side = ahead.cross(up);
        let radius = self.radius(s, line.length()) + height;
        centre + radius * (libm::cos(angle) * up + libm::sin(angle) * side)
    }

    /// A place of a scale: −1 … 1 across, 0 … 1 from its root to its end.
    fn place(&self, line: &Line<'_>, scale: &Scale, across: f64, along: f64) -> DVec3 {
        // The outline: broad in the middle, a rounded point behind.
        let past = ((along - 0.45) / 0.55).max(0.0);
        let before = ((0.45 - along) / 0.45).max(0.0);
        let outline = (1.0 - libm::pow(past, 2.3)).max(0.0).sqrt() * (1.0 - 0.35 * before * before);
        let radius = self.radius(scale.s, line.length());
        let small = scale.width.min(PLATE * radius);
        let bow = 1.0 - across * across;
        let ridge =
            scale.keel * KEEL * libm::exp(-(across / 0.1).powi(2)) * (1.0 - before) * (1.0 - past.powi(4));
        let bend = BOW * (along - 0.55) * (along - 0.55);
        let height =
            small * (-SUNK + (SUNK + RAISED) * along - bend + DOME * (bow - 0.7) * outline * outline + ridge);
        let angle = scale.angle + 0.5 * scale.width * outline * across / radius;
        self.skin(line, scale.s + along * scale.length, angle, height)
    }

    fn add(&self, line: &Line<'_>, scale: &Scale, mesh: &mut Mesh) {
        let first = mesh.positions.len() as u32;
        const SMALL: f64 = 1e-3;
        for j in 0..ALONG {
            // Closer towards the end, which is round.
            let part = j as f64 / (ALONG - 1) as f64;
            let along = 0.998 * (1.0 - (1.0 - part) * (1.0 - part) * (1.0 - 0.3 * part));
            for i in 0..ACROSS {
                let across = 2.0 * i as f64 / (ACROSS - 1) as f64 - 1.0;
                let of = |da: f64, db: f64| self.place(line, scale, across + da, along + db);
                let here = of(0.0, 0.0);
                let aside = of(SMALL, 0.0) - of(-SMALL, 0.0);
                // Where the outline closes, lines along lean to the middle: the scale's own direction is the body's.
                let (_, ahead) = line.at(scale.s + along * scale.length);
                let onwards = {
                    let raised = of(0.0, -SMALL);
                    let back = here - raised;
                    back - aside.normalize_or_zero() * back.dot(aside.normalize_or_zero())
                };
                let normal = onwards.cross(aside).normalize_or(DVec3::Z);
                let outwards = here - line.at(scale.s + along * scale.length).0;
                let normal = if normal.dot(outwards) < 0.0 { -normal } else { normal };
                let tangent = (ahead - normal * ahead.dot(normal)).normalize_or(DVec3::X);
                mesh.positions.push(here.as_vec3());
                mesh.normals.push(normal.as_vec3());
                mesh.tangents.push(tangent.as_vec3());
                let uv = DVec2::new(0.5 * (across + 1.0), along).as_vec2();
                mesh.uvs.push(Vec2::new(uv.x, uv.y));
            }
        }
        for (j, i) in (0..ALONG as u32 - 1).flat_map(|j| (0..ACROSS as u32 - 1).map(move |i| (j, i))) {
            let at = first + j * ACROSS as u32 + i;
            let (right, above) = (at + 1, at + ACROSS as u32);
            // Counter-clockwise from outside: across is to the left of the way to the tail.
            mesh.triangles.push([at, right, above]);
            mesh.triangles.push([right, above + 1, above]);
        }
    }

    /// Most vertices and triangles that [`Self::mesh`] makes, of a line of this length.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        let line = Line::along(&self.path_mm);
        let visible = ASPECT * 2.0 * FLANK * self.radius_mm / self.rows as f64;
        let scales = ((line.length() / visible) as usize).saturating_add(3).saturating_mul(self.rows + 1);
        [scales.saturating_mul(ACROSS * ALONG), scales.saturating_mul(2 * (ACROSS - 1) * (ALONG - 1))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snake(keel: f64) -> Snake {
        let path = [[0.0, 0.0, 12.0], [60.0, 20.0, 12.0], [120.0, -20.0, 14.0], [180.0, 0.0, 12.0]];
        Snake { path_mm: path.map(DVec3::from_array).to_vec(), radius_mm: 12.0, rows: 15, keel }
    }

    #[test]
    fn scales_face_outwards_and_their_tangents_lie_in_them_towards_the_tail() {
        let snake = snake(1.0);
        let mesh = snake.mesh(1);
        assert_eq!(mesh, snake.mesh(1));
        let [vertices, triangles] = snake.size();
        assert!(mesh.positions.len() <= vertices && mesh.triangles.len() <= triangles);
        let line = Line::along(&snake.path_mm);
        let points: Vec<(DVec3, DVec3)> =
            (-40..=1040).map(|i| line.at(1e-3 * f64::from(i) * line.length())).collect();
        let nearest = |p: DVec3| {
            let apart = |of: &&(DVec3, DVec3)| of.0.distance_squared(p);
            *points.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap()
        };
        for v in (0..mesh.positions.len()).step_by(7) {
            let [p, n, t] = [&mesh.positions, &mesh.normals, &mesh.tangents].map(|of| of[v].as_dvec3());
            assert!(n.dot(t).abs() < 1e-5 && (n.length() - 1.0).abs() < 1e-5);
            let (middle, ahead) = nearest(p);
            assert!(n.dot(p - middle) > 0.0, "{v}");
            assert!(t.dot(ahead) > 0.8, "{v}: {t}");
        }
        // Faces look where their normals do, but for slivers at the tips.
        let mut against = 0;
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v as usize)) {
            let p = [a, b, c].map(|v| mesh.positions[v].as_dvec3());
            let face = (p[1] - p[0]).cross(p[2] - p[0]);
            against += usize::from(face.dot(mesh.normals[a].as_dvec3()) < 0.0);
        }
        assert!(against * 200 < mesh.triangles.len(), "{against} of {}", mesh.triangles.len());
    }

    /// Straight at the skin from outside a ray meets a scale nearly where the skin is, everywhere.
    #[test]
    fn scales_cover_the_body_without_holes() {
        let snake = snake(0.0);
        let mesh = snake.mesh(2);
        let line = Line::along(&snake.path_mm);
        for (s, turn) in
            (0..40).flat_map(|i| (0..36).map(move |k| (40.0 + 2.37 * f64::from(i), 0.1745 * f64::from(k))))
        {
            let (origin, target) = (snake.skin(&line, s, turn, 5.0), snake.skin(&line, s, turn, -5.0));
            let direction = (target - origin).normalize();
            let mut nearest = f64::INFINITY;
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].as_dvec3());
                if a.distance_squared(origin) > 200.0 {
                    continue;
                }
                let (e1, e2) = (b - a, c - a);
                let across = direction.cross(e2);
                let determinant = e1.dot(across);
                if determinant.abs() < 1e-12 {
                    continue;
                }
                let from = origin - a;
                let u = from.dot(across) / determinant;
                let other = from.cross(e1);
                let v = direction.dot(other) / determinant;
                if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
                    nearest = nearest.min(e2.dot(other) / determinant);
                }
            }
            // Roots are sunk by up to 0.95 mm; through a hole it would be the other side, 20 mm away.
            assert!((nearest - 5.0).abs() < 1.0, "at {s} mm, {turn}: {nearest}");
        }
    }
}
