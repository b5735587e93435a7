//! The whole crystal: layers one over another under the flat surface.
//!
//! From the lowest layer up, R ← R_a + T_u R P X with X = (1 − R_b R)⁻¹ T_d, where R is the reflection of all that lies
//! below: only decaying exponentials occur. Amplitudes between two layers refer to the middle of the gap, which keeps
//! evanescent orders of order one. Then the fields go down again to every rod.

use num_complex::Complex64;

use super::layer::Scattering;
use super::orders::{Orders, Surface};
use crate::math::dense::Dense;

/// One layer in its place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    /// Which scattering.
    pub(super) shape: usize,
    /// Of the layer's origin, µm.
    pub(super) x: f64,
    /// From the origin up to the upper plane of reference, and down to the lower one, µm.
    pub(super) above: f64,
    pub(super) below: f64,
}

/// Fields of both incident polarizations, one column each, (E_y, H̃_y): E of every order, then H̃ of every order.
#[derive(Debug, Clone)]
pub(super) struct Fields {
    /// Going down just under the surface, and coming up there.
    pub(super) surface: [Dense; 2],
    /// At each layer's origin.
    pub(super) layers: Vec<[Dense; 2]>,
    /// At each layer's lower plane.
    pub(super) gaps: Vec<[Dense; 2]>,
}

/// A layer between its planes of reference, x from its own origin.
struct Slab {
    level: Level,
    r_above: Dense,
    t_down: Dense,
    r_below: Dense,
    t_up: Dense,
    /// e^{jγ·height} of the upper and of the lower part.
    heights: [Vec<Complex64>; 2],
}

impl Slab {
    fn new(orders: &Orders, shapes: &[Scattering], level: &Level) -> Self {
        let [above, below] = [level.above, level.below].map(|height| phases(orders, 0.0, height));
        let s = &shapes[level.shape];
        Self {
            level: *level,
            r_above: s.r_above.scaled(&above, &above),
            t_down: s.t_down.scaled(&below, &above),
            r_below: s.r_below.scaled(&below, &below),
            t_up: s.t_up.scaled(&above, &below),
            heights: [above, below],
        }
    }

    fn serves(&self, level: &Level) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-13;
        let own = &self.level;
        own.shape == level.shape && near(own.above, level.above) && near(own.below, level.below)
    }
}

/// Phases of every order over a shift and a height, for E and for H̃.
fn phases(orders: &Orders, x: f64, height: f64) -> Vec<Complex64> {
    let one = |m: usize| (Complex64::i() * (orders.alpha[m] * x + orders.gamma[m] * height)).exp();
    let values: Vec<_> = (0..orders.len()).map(one).collect();
    values.iter().chain(&values).copied().collect()
}

/// Layers from the top, with what passes down through each and what is reflected from under it.
struct Pass {
    slab: usize,
    /// Reflection of all that lies under the layer, x from the layer's origin.
    rest: Option<Dense>,
    down: Dense,
}

/// Fields everywhere for the zeroth order coming from above, with E_y = 1 alone and with H̃_y = 1 alone. `first_gap` is
/// the distance from the surface to the first layer's upper plane.
pub(super) fn solve(
    orders: &Orders,
    surfaces: &[Surface],
    shapes: &[Scattering],
    levels: &[Level],
    first_gap: f64,
) -> Fields {
    let mut slabs: Vec<Slab> = Vec::new();
    let mut passes = Vec::with_capacity(levels.len());
    // reflection of what lies below, and the x it refers to
    let mut below: Option<(Dense, f64)> = None;
    for level in levels.iter().rev() {
        let at = slabs.iter().position(|slab| slab.serves(level)).unwrap_or(slabs.len());
        if at == slabs.len() {
            slabs.push(Slab::new(orders, shapes, level));
        }
        let slab = &slabs[at];
        let (mut reflection, mut down) = (slab.r_above.clone(), slab.t_down.clone());
        let rest = below.take().map(|(rest, x)| shifted(orders, rest, x - level.x));
        if let Some(rest) = &rest {
            let mut system = slab.r_below.times(rest);
            system.one_less();
            system.solve(&mut down);
            reflection.add_product(&slab.t_up, &rest.times(&down));
        }
        passes.push(Pass { slab: at, rest, down });
        below = Some((reflection, level.x));
    }
    passes.reverse();
    let gap = phases(orders, 0.0, first_gap);
    let reflection = below.map(|(rest, x)| shifted(orders, rest, x).scaled(&gap, &gap));
    let down = enter(orders, surfaces, reflection.as_ref());
    let up = reflection.map_or_else(|| Dense::zeros(down.rows(), 2), |r| r.times(&down));
    descend(orders, &slabs, levels, &passes, &gap, [down, up])
}

/// A reflection that refers to x = `by`, referred to x = 0.
fn shifted(orders: &Orders, reflection: Dense, by: f64) -> Dense {
    if by == 0.0 {
        return reflection;
    }
    let into = phases(orders, by, 0.0);
    let out: Vec<_> = into.iter().map(Complex64::conj).collect();
    reflection.scaled(&out, &into)
}

/// Waves that go down just under the surface: (1 − r′R) D = t·incident.
fn enter(orders: &Orders, surfaces: &[Surface], reflection: Option<&Dense>) -> Dense {
    let (n, zeroth) = (orders.len(), orders.index(0));
    let mut waves = Dense::zeros(2 * n, 2);
    for column in 0..2 {
        for field in 0..2 {
            waves[(field * n + zeroth, column)] = surfaces[zeroth].t[field][column];
        }
    }
    if let Some(r) = reflection {
        let mut system = Dense::from_fn(2 * n, 2 * n, |i, k| {
            let row = surfaces[i % n].r_below[i / n];
            row[0] * r[(i % n, k)] + row[1] * r[(i % n + n, k)]
        });
        system.one_less();
        system.solve(&mut waves);
    }
    waves
}

/// Carries the fields from the surface down through every layer.
fn descend(
    orders: &Orders,
    slabs: &[Slab],
    levels: &[Level],
    passes: &[Pass],
    gap: &[Complex64],
    surface: [Dense; 2],
) -> Fields {
    let one = [Complex64::new(1.0, 0.0); 2];
    let mut down = surface[0].scaled(gap, &one);
    let mut x = 0.0;
    let mut fields = Fields { surface, layers: Vec::new(), gaps: Vec::new() };
    for (level, pass) in levels.iter().zip(passes) {
        if level.x != x {
            down = down.scaled(&phases(orders, level.x - x, 0.0), &one);
            x = level.x;
        }
        let slab = &slabs[pass.slab];
        let under = pass.down.times(&down);
        let up = pass.rest.as_ref().map_or_else(|| Dense::zeros(under.rows(), 2), |rest| rest.times(&under));
        fields.layers.push([down.scaled(&slab.heights[0], &one), up.scaled(&slab.heights[1], &one)]);
        fields.gaps.push([under.clone(), up]);
        down = under;
    }
    fields
}
