//! Rods that act on each other as one cluster: scattering of plane waves by one layer of the stack.
//!
//! With S the lattice sums between the layer's rods, â = â_in + S T â; incoming plane waves give
//! â_in,n = j^{|n|} (w^n D + w^{−n} U), and outgoing ones are d = D + (2/(Δγ)) Σ_n (−j)^{|n|} w^{−n} b_n (upward w^n).
//! Rods of one depth have the mirror symmetry z → −z, under which E_y is even and H̃_y odd: two systems of half the size.

use num_complex::Complex64;

use super::lattice::LatticeSums;
use super::orders::Orders;
use super::rod::RodTable;
use crate::Result;
use crate::math::bessel::power_of_j;
use crate::math::dense::Dense;

/// A rod of a layer, placed from the layer's own origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Which table.
    pub(super) kind: usize,
    pub(super) x: f64,
    /// Above the layer's depth, µm.
    pub(super) z: f64,
}

/// Scattering of one layer between amplitudes (E of every order, then H̃ of every order) at its own origin.
#[derive(Debug, Clone)]
pub(super) struct Scattering {
    pub(super) r_above: Dense,
    pub(super) t_down: Dense,
    pub(super) r_below: Dense,
    pub(super) t_up: Dense,
    inside: Inside,
}

/// How incoming plane waves excite the rods' multipoles.
#[derive(Debug, Clone)]
enum Inside {
    /// By mirror symmetry in z, for waves D from above with U = ±ZD from below, Z = diag(1, −1) on (E, H̃).
    Flat([(Vec<Unknown>, Dense); 2]),
    /// For D, then U.
    Cluster(Vec<Unknown>, Dense),
}

/// One multipole of one rod; `field` 0 is E_y, 1 is H̃_y.
#[derive(Debug, Clone, Copy)]
struct Unknown {
    place: usize,
    n: i32,
    field: usize,
}

/// See [`Frame::half`].
struct Half {
    unknowns: Vec<Unknown>,
    coupling: Dense,
    inside: Dense,
    out: Dense,
}

/// What a layer's systems are made from.
pub(super) struct Frame<'a> {
    pub(super) orders: &'a Orders,
    pub(super) period: f64,
    pub(super) tables: &'a [RodTable],
    pub(super) places: &'a [Place],
    /// σ_q between two places, q = −q_max … q_max, by `target·places + source`.
    pub(super) sums: Vec<Vec<Complex64>>,
}

impl<'a> Frame<'a> {
    /// Sums for every pair; `all` are the orders of the lattice sums.
    ///
    /// # Errors
    /// Cylinder functions leave the range of numbers.
    pub(super) fn new(
        orders: &'a Orders,
        all: &Orders,
        lattice: &LatticeSums,
        period: f64,
        tables: &'a [RodTable],
        places: &'a [Place],
    ) -> Result<Self> {
        let mut sums = Vec::with_capacity(places.len() * places.len());
        for (i, target) in places.iter().enumerate() {
            for (k, source) in places.iter().enumerate() {
                let q_max = tables[target.kind].m() + tables[source.kind].m();
                sums.push(if i == k {
                    (-(q_max as i32)..=q_max as i32).map(|q| lattice.own(q)).collect()
                } else {
                    lattice.displaced(all, target.x - source.x, target.z - source.z, q_max)?
                });
            }
        }
        Ok(Self { orders, period, tables, places, sums })
    }

    fn table(&self, unknown: &Unknown) -> &RodTable {
        &self.tables[self.places[unknown.place].kind]
    }

    fn scale(&self, unknown: &Unknown) -> f64 {
        self.table(unknown).inverse_scale[unknown.n.unsigned_abs() as usize]
    }

    /// Scaled S between functions with |n| in place of n: (±1)^n σ_{p−n}.
    fn coupling(&self, target: &Unknown, source: &Unknown) -> Complex64 {
        let sums = &self.sums[target.place * self.places.len() + source.place];
        let centre = (sums.len() / 2) as i32;
        let value = sums[(centre + source.n - target.n) as usize];
        let odd = |u: &Unknown| u.n < 0 && u.n % 2 != 0;
        if odd(target) == odd(source) { value } else { -value }
    }

    /// The scattering of the layer.
    pub(super) fn scattering(&self) -> Scattering {
        let depth = self.places[0].z;
        if self.places.iter().all(|place| (place.z - depth).abs() < 1e-12) {
            self.flat()
        } else {
            self.cluster()
        }
    }

    /// Layer without mirror symmetry.
    fn cluster(&self) -> Scattering {
        let mut unknowns = Vec::new();
        for (place, at) in self.places.iter().enumerate() {
            let m = self.tables[at.kind].m() as i32;
            unknowns.extend((0..2).flat_map(|field| (-m..=m).map(move |n| Unknown { place, n, field })));
        }
        let size = unknowns.len();
        let s = Dense::from_fn(size, size, |i, k| {
            let (target, source) = (&unknowns[i], &unknowns[k]);
            if target.field == source.field {
                self.coupling(target, source) * (self.scale(target) * self.scale(source))
            } else {
                Complex64::new(0.0, 0.0)
            }
        });
        let n = self.orders.len();
        let mut inside = Dense::zeros(size, 4 * n);
        let mut out = Dense::zeros(4 * n, size);
        for (i, unknown) in unknowns.iter().enumerate() {
            let Place { x, z, .. } = self.places[unknown.place];
            let turn = power_of_j(unknown.n.unsigned_abs() as usize);
            for m in 0..n {
                let (w, gamma) = (self.orders.w[m].powi(unknown.n), self.orders.gamma[m]);
                let along = Complex64::cis(self.orders.alpha[m] * x) * self.scale(unknown);
                let rise = (Complex64::i() * gamma * z).exp();
                let radiated = 2.0 / (self.period * gamma);
                let (down, up) = (unknown.field * n + m, (2 + unknown.field) * n + m);
                inside[(i, down)] = turn * along * w / rise;
                inside[(i, up)] = turn * along / w * rise;
                let outward = turn.conj() * radiated * along.conj();
                out[(down, i)] = outward / w * rise;
                out[(up, i)] = outward * w / rise;
            }
        }
        let partner = partners(&unknowns);
        let mut system = times_t(self, &unknowns, &partner, &s);
        system.one_less();
        system.solve(&mut inside);
        let mut all = times_t(self, &unknowns, &partner, &out).times(&inside);
        all.add_one();
        let block = |i: usize, k: usize| all.block(2 * n * i, 2 * n * k, 2 * n, 2 * n);
        Scattering {
            t_down: block(0, 0),
            r_below: block(0, 1),
            r_above: block(1, 0),
            t_up: block(1, 1),
            inside: Inside::Cluster(unknowns, inside),
        }
    }

    /// Layer of rods at one depth: z → −z symmetry.
    fn flat(&self) -> Scattering {
        let n = self.orders.len();
        let halves = [self.half(1.0), self.half(-1.0)];
        let [(even, down_even), (odd, down_odd)] = [self.sector(&halves, 0), self.sector(&halves, 1)];
        let size = 2 * n;
        let sign = |i: usize| if i < n { 1.0 } else { -1.0 };
        let sum = |i: usize, k: usize| (down_even[(i, k)] + down_odd[(i, k)]) * 0.5;
        let difference = |i: usize, k: usize| (down_even[(i, k)] - down_odd[(i, k)]) * 0.5;
        Scattering {
            t_down: Dense::from_fn(size, size, sum),
            r_above: Dense::from_fn(size, size, |i, k| difference(i, k) * sign(i)),
            t_up: Dense::from_fn(size, size, |i, k| sum(i, k) * (sign(i) * sign(k))),
            r_below: Dense::from_fn(size, size, |i, k| difference(i, k) * sign(k)),
            inside: Inside::Flat([even, odd]),
        }
    }

    /// What one field of one parity needs: its multipoles n ≥ 0, how they act on each other, how plane waves excite
    /// them and how they radiate down.
    fn half(&self, parity: f64) -> Half {
        let start = if parity > 0.0 { 0 } else { 1 };
        let mut unknowns = Vec::new();
        for (place, at) in self.places.iter().enumerate() {
            unknowns.extend((start..=self.tables[at.kind].m() as i32).map(|n| Unknown {
                place,
                n,
                field: 0,
            }));
        }
        let size = unknowns.len();
        let scales: Vec<f64> = unknowns.iter().map(|unknown| self.scale(unknown)).collect();
        let coupling = Dense::from_fn(size, size, |i, k| {
            let (target, source) = (&unknowns[i], &unknowns[k]);
            let mut value = self.coupling(target, source);
            if source.n > 0 {
                value += parity * self.coupling(target, &Unknown { n: -source.n, ..*source });
            }
            value * (scales[i] * scales[k])
        });
        let n = self.orders.len();
        let one = Complex64::new(1.0, 0.0);
        let mut inside = Dense::zeros(size, n);
        let mut out = Dense::zeros(n, size);
        for m in 0..n {
            let w = self.orders.w[m];
            let inverse = w.inv();
            let radiated = 2.0 / (self.period * self.orders.gamma[m]) * parity;
            let (mut up, mut down, mut along) = (one, one, one);
            for (i, unknown) in unknowns.iter().enumerate() {
                if unknown.n == start {
                    (up, down) = if start == 0 { (one, one) } else { (w, inverse) };
                    along = Complex64::cis(self.orders.alpha[m] * self.places[unknown.place].x);
                }
                let turn = power_of_j(unknown.n as usize);
                let both = (up + parity * down) * scales[i];
                inside[(i, m)] = turn * both * along;
                let once = if unknown.n == 0 { 0.5 } else { 1.0 };
                out[(m, i)] = turn.conj() * both * radiated * along.conj() * once;
                up *= w;
                down *= inverse;
            }
        }
        Half { unknowns, coupling, inside, out }
    }

    /// One half of a flat layer: waves D from above with U = ±ZD from below, the sign of `halves[which]`, which holds E;
    /// H̃ has the other parity. Returns the multipoles with their response to D, and the outgoing waves below.
    fn sector(&self, halves: &[Half; 2], which: usize) -> ((Vec<Unknown>, Dense), Dense) {
        let fields = [&halves[which], &halves[1 - which]];
        let starts = [0, fields[0].unknowns.len()];
        let n = self.orders.len();
        let mut unknowns = Vec::new();
        for (field, half) in fields.iter().enumerate() {
            unknowns.extend(half.unknowns.iter().map(|unknown| Unknown { field, ..*unknown }));
        }
        let size = unknowns.len();
        let (mut system, mut out, mut inside) =
            (Dense::zeros(size, size), Dense::zeros(2 * n, size), Dense::zeros(size, 2 * n));
        for (k, unknown) in unknowns.iter().enumerate() {
            let t = &self.table(unknown).t[unknown.n as usize];
            for (field, half) in fields.iter().enumerate() {
                let same = |u: &Unknown| u.place == unknown.place && u.n == unknown.n;
                let index = if field == unknown.field {
                    Some(k - starts[field])
                } else {
                    half.unknowns.iter().position(same)
                };
                let Some(index) = index else { continue };
                let t = t[field][unknown.field];
                let rows = &mut system.column_mut(k)[starts[field]..];
                for (element, s) in rows.iter_mut().zip(half.coupling.column(index)) {
                    *element = -s * t;
                }
                let rows = &mut out.column_mut(k)[field * n..];
                for (element, o) in rows.iter_mut().zip(half.out.column(index)) {
                    *element = o * t;
                }
            }
        }
        system.add_one();
        for (field, half) in fields.iter().enumerate() {
            for m in 0..n {
                let column = half.inside.column(m);
                inside.column_mut(field * n + m)[starts[field]..starts[field] + column.len()]
                    .copy_from_slice(column);
            }
        }
        system.solve(&mut inside);
        let mut all = out.times(&inside);
        all.add_one();
        ((unknowns, inside), all)
    }

    /// The multipoles â of every place for waves `down` and `up` at the layer's origin, one column each case:
    /// `[case][place]`, n = −M … M.
    pub(super) fn multipoles(
        &self,
        layer: &Scattering,
        down: &Dense,
        up: &Dense,
    ) -> Vec<Vec<Vec<[Complex64; 2]>>> {
        let zero = Complex64::new(0.0, 0.0);
        let empty: Vec<_> =
            self.places.iter().map(|p| vec![[zero; 2]; 2 * self.tables[p.kind].m() + 1]).collect();
        let mut found = vec![empty; down.columns()];
        let mut add = |case: usize, unknown: &Unknown, n: i32, value: Complex64| {
            let centre = self.table(unknown).m() as i32;
            found[case][unknown.place][(centre + n) as usize][unknown.field] += value;
        };
        let n = self.orders.len();
        match &layer.inside {
            Inside::Flat(sectors) => {
                for ((unknowns, response), parity) in sectors.iter().zip([1.0, -1.0]) {
                    let sign = |i: usize| if i < n { parity } else { -parity };
                    let element = |i: usize, k: usize| (down[(i, k)] + up[(i, k)] * sign(i)) * 0.5;
                    let values = response.times(&Dense::from_fn(2 * n, down.columns(), element));
                    for case in 0..down.columns() {
                        for (unknown, &value) in unknowns.iter().zip(values.column(case)) {
                            add(case, unknown, unknown.n, value);
                            if unknown.n > 0 {
                                let mirrored = value * if unknown.field == 0 { parity } else { -parity };
                                add(case, unknown, -unknown.n, mirrored);
                            }
                        }
                    }
                }
            }
            Inside::Cluster(unknowns, response) => {
                let element = |i: usize, k: usize| if i < 2 * n { down[(i, k)] } else { up[(i - 2 * n, k)] };
                let values = response.times(&Dense::from_fn(4 * n, down.columns(), element));
                for case in 0..down.columns() {
                    for (unknown, &value) in unknowns.iter().zip(values.column(case)) {
                        add(case, unknown, unknown.n, value);
                    }
                }
            }
        }
        found
    }
}

/// A·T with the rods' T-matrices; `partner` holds the index of the same multipole of the other field.
fn times_t(frame: &Frame<'_>, unknowns: &[Unknown], partner: &[Option<usize>], a: &Dense) -> Dense {
    let mut product = Dense::zeros(a.rows(), a.columns());
    for (k, source) in unknowns.iter().enumerate() {
        let t = &frame.table(source).t[source.n.unsigned_abs() as usize];
        let own = t[source.field][source.field];
        let out = product.column_mut(k);
        for (sum, x) in out.iter_mut().zip(a.column(k)) {
            *sum = x * own;
        }
        if let Some(other) = partner[k] {
            let cross = t[1 - source.field][source.field];
            let cross = if source.n < 0 { -cross } else { cross };
            for (sum, x) in out.iter_mut().zip(a.column(other)) {
                *sum += x * cross;
            }
        }
    }
    product
}

/// For every unknown the index of the same multipole of the other field.
fn partners(unknowns: &[Unknown]) -> Vec<Option<usize>> {
    let matches = |a: &Unknown, b: &Unknown| a.place == b.place && a.n == b.n && a.field != b.field;
    unknowns.iter().map(|a| unknowns.iter().position(|b| matches(a, b))).collect()
}
