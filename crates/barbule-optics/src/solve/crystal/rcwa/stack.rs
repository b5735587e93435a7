//! The stack of slices as a grammar: what repeats in it, shifted or mirrored, is computed once.
//!
//! The most frequent pair of neighbours becomes a new part until one is left (Larsson & Moffat 2000, "Re-Pair"), so
//! the halves of a rod, its rows, and rows that interleave share their scattering matrices.

use std::collections::{HashMap, HashSet};

use super::modes::Harmonics;
use super::profile::{Body, Slice, slices};
use super::scattering::{Join, Scattering, phases};
use crate::math::dense::Dense;
use crate::{Complex64, Error, Result};

/// A part of the stack, where it stands and whether it is upside down.
#[derive(Debug, Clone, Copy)]
struct Placed {
    part: usize,
    /// Of the period.
    shift: f64,
    flipped: bool,
}

enum Kind {
    /// A layer of the host.
    Gap,
    /// The host's half-space.
    Exit,
    Slice,
    Pair {
        upper: Placed,
        lower: Placed,
        join: Box<Join>,
    },
}

struct Part {
    scattering: Scattering,
    kind: Kind,
    /// Whether it is its own mirror image in z.
    symmetric: bool,
}

/// All that lies below the surface, solved.
pub(super) struct Stack {
    parts: Vec<Part>,
    whole: Placed,
}

/// What becomes of the power that comes down on a stack.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Budget {
    /// In slices that cut bodies, and in those of the host where it absorbs.
    pub absorbed: f64,
    /// Through the plane at the lowest body's lower edge.
    pub transmitted: f64,
}

/// Bytes of scattering matrices, at most.
const MOST_BYTES: usize = 4 << 30;

/// Refuses slices whose scattering matrices would not fit.
fn check_memory(harmonics: &Harmonics, slices: &[Slice]) -> Result<()> {
    let distinct = slices.iter().map(Slice::key).collect::<HashSet<_>>().len();
    // Four matrices for each slice and for each pair, and as many for what joins a pair.
    let matrix = size_of::<Complex64>() * (2 * harmonics.len()).pow(2);
    if (distinct * 3 * 4).saturating_mul(matrix) > MOST_BYTES {
        return Err(Error::input(format!(
            "{distinct} different slices of {} orders need over {} GB of memory; give fewer or equal rods, or a shorter period",
            harmonics.len(),
            MOST_BYTES >> 30
        )));
    }
    Ok(())
}

type PairKey = (usize, bool, usize, bool, i64);

impl Stack {
    pub(super) fn solve(
        harmonics: &Harmonics,
        bodies: &[Body],
        period_um: f64,
        host_eps: Complex64,
        per_rod: usize,
    ) -> Result<Self> {
        let (top_um, mut slices) = slices(bodies, period_um, host_eps, per_rod);
        if top_um > 0.0 {
            slices.insert(0, Slice { thickness_um: top_um, pieces: vec![(1.0, host_eps)], shift: 0.0 });
        }
        check_memory(harmonics, &slices)?;
        let exit = Part { scattering: harmonics.exit(), kind: Kind::Exit, symmetric: false };
        let whole = Placed { part: 0, shift: 0.0, flipped: false };
        let mut stack = Self { parts: vec![exit], whole };
        let mut sequence = stack.leaves(harmonics, &slices, host_eps)?;
        sequence.push(whole);
        while sequence.len() > 1 {
            stack.merge_most_frequent(&mut sequence);
        }
        stack.whole = sequence[0];
        Ok(stack)
    }

    /// The slices as parts, one for all that differ in position alone.
    fn leaves(
        &mut self,
        harmonics: &Harmonics,
        slices: &[Slice],
        host_eps: Complex64,
    ) -> Result<Vec<Placed>> {
        let mut known = HashMap::new();
        let mut sequence: Vec<Placed> = Vec::with_capacity(slices.len());
        for slice in slices {
            let key = slice.key();
            let part = match known.get(&key) {
                Some(&part) => part,
                None => {
                    let (scattering, kind) = if slice.is_uniform(host_eps) {
                        (harmonics.gap(slice.thickness_um)?, Kind::Gap)
                    } else {
                        (harmonics.slice(slice)?, Kind::Slice)
                    };
                    self.parts.push(Part { scattering, kind, symmetric: true });
                    known.insert(key, self.parts.len() - 1);
                    self.parts.len() - 1
                }
            };
            // What does not change along x stands where its upper neighbour stands, so that rows look alike.
            let shift = match sequence.last() {
                Some(last) if slice.pieces.len() == 1 => last.shift,
                _ => slice.shift,
            };
            sequence.push(Placed { part, shift, flipped: false });
        }
        Ok(sequence)
    }

    /// A name for a pair that its mirror image shares, and whether the pair is the mirror image of the one so named.
    fn key(&self, upper: Placed, lower: Placed) -> (PairKey, bool, bool) {
        let relative = |from: f64, to: f64| {
            let shift = ((to - from).rem_euclid(1.0) * 1e9).round() as i64;
            if shift == 1_000_000_000 { 0 } else { shift }
        };
        let turned = |placed: Placed| !placed.flipped && !self.parts[placed.part].symmetric;
        let upright =
            (upper.part, upper.flipped, lower.part, lower.flipped, relative(upper.shift, lower.shift));
        let mirrored =
            (lower.part, turned(lower), upper.part, turned(upper), relative(lower.shift, upper.shift));
        if mirrored < upright { (mirrored, true, false) } else { (upright, false, mirrored == upright) }
    }

    fn merge_most_frequent(&mut self, sequence: &mut Vec<Placed>) {
        // Count of each pair without overlaps, and where it was met last and first.
        let mut counts: HashMap<PairKey, (usize, usize, usize)> = HashMap::new();
        for index in 0..sequence.len() - 1 {
            let (key, _, _) = self.key(sequence[index], sequence[index + 1]);
            let entry = counts.entry(key).or_insert((0, usize::MAX, index));
            if entry.1 == usize::MAX || entry.1 + 1 < index {
                *entry = (entry.0 + 1, index, entry.2);
            }
        }
        let best = counts.into_iter().min_by_key(|(_, (count, _, first))| (usize::MAX - count, *first));
        let Some((wanted, _)) = best else { return };
        let part = self.parts.len();
        let mut merged = Vec::with_capacity(sequence.len());
        let mut index = 0;
        while index < sequence.len() {
            let here = sequence[index];
            let Some(&next) = sequence.get(index + 1) else {
                merged.push(here);
                break;
            };
            let (key, mirrored, symmetric) = self.key(here, next);
            if key != wanted {
                merged.push(here);
                index += 1;
                continue;
            }
            // The pair as named: its upper part first, unmirrored.
            let (first, second) = if mirrored { (next, here) } else { (here, next) };
            if self.parts.len() == part {
                let turn = |placed: Placed| Placed {
                    flipped: placed.flipped != (mirrored && !self.parts[placed.part].symmetric),
                    ..placed
                };
                let upper = Placed { shift: 0.0, ..turn(first) };
                let lower = Placed { shift: second.shift - first.shift, ..turn(second) };
                let (scattering, join) = self.placed(upper).above(&self.placed(lower));
                let kind = Kind::Pair { upper, lower, join: Box::new(join) };
                self.parts.push(Part { scattering, kind, symmetric });
            }
            merged.push(Placed { part, shift: first.shift, flipped: mirrored });
            index += 2;
        }
        *sequence = merged;
    }

    fn placed(&self, placed: Placed) -> Scattering {
        let scattering = &self.parts[placed.part].scattering;
        let moved = if placed.shift == 0.0 { scattering.clone() } else { scattering.shifted(placed.shift) };
        if placed.flipped { moved.flipped() } else { moved }
    }

    /// How waves that come down on the stack go back up.
    pub(super) fn reflection(&self) -> Dense {
        self.placed(self.whole).top
    }

    /// Where the power goes of waves that come down on the stack.
    ///
    /// Amplitudes are found at every plane between slices, and each slice absorbs what flows in less what flows out.
    pub(super) fn budget(&self, harmonics: &Harmonics, down: &[Complex64]) -> Budget {
        let mut budget = Budget::default();
        self.descend(harmonics, self.whole, down, &vec![Complex64::ZERO; down.len()], &mut budget);
        budget
    }

    /// Adds what becomes of the power in a part that is met by `down` from above and `up` from below.
    fn descend(
        &self,
        harmonics: &Harmonics,
        placed: Placed,
        down: &[Complex64],
        up: &[Complex64],
        budget: &mut Budget,
    ) {
        // In the part's own frame.
        let turn = phases(down.len() / 2, -placed.shift);
        let own = |wave: &[Complex64]| wave.iter().zip(&turn).map(|(w, t)| w * t).collect::<Vec<_>>();
        let (down, up) = if placed.flipped { (own(up), own(down)) } else { (own(down), own(up)) };
        let part = &self.parts[placed.part];
        match &part.kind {
            // Rounding would be all that it adds.
            Kind::Gap if !harmonics.host_absorbs() => {}
            Kind::Exit => {
                budget.transmitted += harmonics.flux(&down, &apply(&part.scattering.top, &down));
            }
            Kind::Slice | Kind::Gap => {
                let s = &part.scattering;
                let back = sum(apply(&s.top, &down), &apply(&s.up, &up));
                let out = sum(apply(&s.down, &down), &apply(&s.bottom, &up));
                budget.absorbed += harmonics.flux(&down, &back) - harmonics.flux(&out, &up);
            }
            Kind::Pair { upper, lower, join } => {
                let middle = sum(apply(&join.from_top, &down), &apply(&join.from_bottom, &up));
                let lower_part = self.placed(*lower);
                let back = sum(apply(&lower_part.top, &middle), &apply(&lower_part.up, &up));
                self.descend(harmonics, *upper, &down, &back, budget);
                self.descend(harmonics, *lower, &middle, &up, budget);
            }
        }
    }

    /// Number of slices, pairs included, for which a scattering matrix was computed.
    #[cfg(test)]
    pub(crate) fn parts(&self) -> usize {
        self.parts.len()
    }
}

fn apply(matrix: &Dense, wave: &[Complex64]) -> Vec<Complex64> {
    let mut out = vec![Complex64::ZERO; matrix.rows()];
    for (j, value) in wave.iter().enumerate() {
        for (o, m) in out.iter_mut().zip(matrix.column(j)) {
            *o += m * value;
        }
    }
    out
}

fn sum(mut a: Vec<Complex64>, b: &[Complex64]) -> Vec<Complex64> {
    for (a, b) in a.iter_mut().zip(b) {
        *a += b;
    }
    a
}
