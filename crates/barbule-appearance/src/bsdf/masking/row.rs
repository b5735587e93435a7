//! An endless row of parts that hide each other.

use std::ops::RangeInclusive;

use glam::DVec2;

use super::outline::{Outline, Sight, Span};

/// Parts that are repeated endlessly to both sides. Sheets may cross anything; of ellipses there is one.
#[derive(Debug, Clone)]
pub struct Row {
    parts: Vec<Outline>,
    period: f64,
}

/// What a direction sees of a row: shares of the row's own projected area.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Of each part, less what passes through it.
    pub weights: Vec<f64>,
    /// What passes.
    pub transmitted: f64,
}

/// A part, moved by some periods.
#[derive(Clone, Copy)]
struct Copy {
    part: usize,
    outline: Outline,
    extent: Span,
}

/// Along a part: until here this share of the light passes by what stands before it.
type Steps = Vec<(f64, f64)>;

impl Row {
    /// `period`: over 0, in the unit of the parts.
    ///
    /// # Panics
    /// In debug builds, with more than one ellipse.
    #[must_use]
    pub fn new(parts: Vec<Outline>, period: f64) -> Self {
        debug_assert!(parts.iter().filter(|part| matches!(part, Outline::Ellipse { .. })).count() <= 1);
        Self { parts, period }
    }

    /// What is seen from a direction.
    ///
    /// - `toward`: unit vector towards the viewer, across the row and up; not along the row
    /// - `transparency`: of each part in this direction, 0 … 1
    ///
    /// Cost: with n parts in sight, n² log n; n grows as the tangent of the angle from the normal.
    #[must_use]
    pub fn seen(&self, toward: DVec2, transparency: &[f64]) -> Seen {
        let sight = Sight::new(toward);
        let window = [0.0, self.period * sight.across.x];
        let copies = self.copies(&sight, window);
        let mut ends = window.to_vec();
        for one in &copies {
            ends.extend(one.extent);
            for other in copies.iter().filter(|other| other.part > one.part) {
                let crossings = one.outline.crossings(&other.outline).into_iter().flatten();
                ends.extend(crossings.map(|along| sight.place(one.outline.at(along))));
            }
        }
        let mut seen = Seen { weights: vec![0.0; self.parts.len()], transmitted: 0.0 };
        let mut stack: Vec<(f64, usize)> = Vec::new();
        for [start, end] in pieces(&mut ends, window[0]..=window[1]) {
            let place = 0.5 * (start + end);
            stack.clear();
            let covering = copies.iter().filter(|c| c.extent[0] < place && place < c.extent[1]);
            stack.extend(covering.map(|copy| (copy.outline.front(&sight, place), copy.part)));
            stack.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
            let mut passing = (end - start) / window[1];
            for &(_, part) in &stack {
                seen.weights[part] += passing * (1.0 - transparency[part]);
                passing *= transparency[part];
            }
            seen.transmitted += passing;
        }
        seen
    }

    /// Share of each part's projected area that is seen from one direction, if the part itself is opaque.
    #[must_use]
    pub fn visible(&self, toward: DVec2, transparency: &[f64]) -> Vec<f64> {
        let sight = Sight::new(toward);
        let one = |part: usize| {
            let spans = spans(self.unhidden(part, &sight, transparency));
            spans.map(|(span, passes)| passes * self.parts[part].share(&sight, span)).sum()
        };
        (0..self.parts.len()).map(one).collect()
    }

    /// Share of each part that is both seen from one direction and lit from another, on whichever side each is; exchanging
    /// them changes nothing. Light that has passed a transparent part on one way passes it on the other as if it had not.
    ///
    /// Of a sheet it is the share of its length. Of an ellipse, into which light enters at one point and leaves as from
    /// there wherever it goes, the smaller of two: of the width seen that which is lit, and the other way round. So it is never
    /// more than what each direction alone sees ([`Row::visible`]), and all of a part that nothing hides.
    #[must_use]
    pub fn shared(&self, towards: [DVec2; 2], transparencies: [&[f64]; 2]) -> Vec<f64> {
        let [a, b] = towards.map(Sight::new);
        let one = |part: usize| {
            let outline = &self.parts[part];
            let (first, second) =
                (self.unhidden(part, &a, transparencies[0]), self.unhidden(part, &b, transparencies[1]));
            let (mut rest, mut others) = (first.as_slice(), second.as_slice());
            let (mut start, mut sums) = (0.0, [0.0; 2]);
            while let (Some(&(end, passes)), Some(&(other_end, other_passes))) =
                (rest.first(), others.first())
            {
                let stop = end.min(other_end);
                for (sum, sight) in sums.iter_mut().zip([&a, &b]) {
                    *sum += passes * other_passes * outline.share(sight, [start, stop]);
                }
                start = stop;
                rest = if end <= stop { &rest[1..] } else { rest };
                others = if other_end <= stop { &others[1..] } else { others };
            }
            sums[0].min(sums[1])
        };
        (0..self.parts.len()).map(one).collect()
    }

    /// Mean share of the light from a direction that arrives at each of equal pieces of a part.
    pub(super) fn profile(&self, part: usize, toward: DVec2, transparency: &[f64], pieces: &mut [f64]) {
        let count = pieces.len() as f64;
        pieces.fill(0.0);
        for ([start, end], passes) in spans(self.unhidden(part, &Sight::new(toward), transparency)) {
            for (i, piece) in pieces.iter_mut().enumerate() {
                let (low, high) = ((start * count).max(i as f64), (end * count).min(i as f64 + 1.0));
                *piece += passes * (high - low).max(0.0);
            }
        }
    }

    /// Share of what is seen of a part, if nothing hides it, that lies on each of equal pieces of it.
    pub(super) fn shares(&self, part: usize, toward: DVec2, pieces: &mut [f64]) {
        let (sight, count) = (Sight::new(toward), pieces.len() as f64);
        for (i, piece) in pieces.iter_mut().enumerate() {
            *piece = self.parts[part].share(&sight, [i as f64 / count, (i + 1) as f64 / count]);
        }
    }

    /// How much light from a direction passes all that stands before a part, step by step along it. A part does not stand
    /// before itself.
    fn unhidden(&self, part: usize, sight: &Sight, transparency: &[f64]) -> Steps {
        let own = &self.parts[part];
        let mut others = self.copies(sight, own.extent(sight));
        others.retain(|copy| copy.part != part || copy.outline != *own);
        let mut ends = vec![0.0, 1.0];
        for other in &others {
            for place in other.extent {
                ends.extend(own.along(sight, place).into_iter().flatten());
            }
            for along in own.crossings(&other.outline).into_iter().flatten() {
                ends.push(along);
                // Of an ellipse, what hides a place hides front and back.
                ends.extend(own.along(sight, sight.place(own.at(along))).into_iter().flatten());
            }
        }
        let step = |[start, end]: Span| {
            let point = own.at(0.5 * (start + end));
            let place = sight.place(point);
            let front = match own {
                Outline::Ellipse { .. } => own.front(sight, place),
                Outline::Segment { .. } => point.dot(sight.toward),
            };
            let before = |copy: &&Copy| {
                copy.extent[0] < place && place < copy.extent[1] && copy.outline.front(sight, place) > front
            };
            (end, others.iter().filter(before).map(|copy| transparency[copy.part]).product())
        };
        pieces(&mut ends, 0.0..=1.0).map(step).collect()
    }

    /// All that is seen within a window.
    fn copies(&self, sight: &Sight, [low, high]: Span) -> Vec<Copy> {
        let step = self.period * sight.across.x;
        let mut copies = Vec::new();
        for (part, outline) in self.parts.iter().enumerate() {
            let [start, end] = outline.extent(sight);
            let (first, last) = (libm::ceil((low - end) / step), libm::floor((high - start) / step));
            let mut number = first;
            while number <= last {
                let outline = outline.moved(number * self.period);
                copies.push(Copy { part, outline, extent: outline.extent(sight) });
                number += 1.0;
            }
        }
        copies
    }
}

/// Pieces between neighbouring ends within a range.
fn pieces(ends: &mut Vec<f64>, within: RangeInclusive<f64>) -> impl Iterator<Item = Span> {
    ends.retain(|end| within.contains(end));
    ends.sort_unstable_by(f64::total_cmp);
    ends.windows(2).map(|pair| [pair[0], pair[1]]).filter(|[start, end]| start < end)
}

/// Steps with their beginnings.
fn spans(steps: Steps) -> impl Iterator<Item = (Span, f64)> {
    let mut start = 0.0;
    steps.into_iter().map(move |(end, passes)| {
        let span = [start, end];
        start = end;
        (span, passes)
    })
}
