//! Parts of a row in the plane across it, as they are seen along a direction.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

/// A part of a row, in the plane: across the row, up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outline {
    /// The points centre + a cosψ + b sinψ of the axes a, b.
    Ellipse {
        /// Its middle.
        centre: DVec2,
        /// Half axes.
        axes: [DVec2; 2],
    },
    /// A thin sheet, seen from both sides.
    Segment {
        /// One end.
        from: DVec2,
        /// The other.
        to: DVec2,
    },
}

/// A direction towards the viewer or the light, in the plane across a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    /// Unit vector.
    pub(super) toward: DVec2,
    /// Unit vector across it; a period moves what is seen along it.
    pub(super) across: DVec2,
}

impl Sight {
    pub(super) fn new(toward: DVec2) -> Self {
        let across = -toward.perp();
        Self { toward, across: if across.x < 0.0 { -across } else { across } }
    }

    /// Where a point is seen.
    pub(super) fn place(&self, point: DVec2) -> f64 {
        point.dot(self.across)
    }
}

/// Part of an outline from one place along it to another, in turns of ψ or lengths of the segment.
pub(super) type Span = [f64; 2];

impl Outline {
    pub(super) fn moved(&self, by: f64) -> Self {
        let by = DVec2::new(by, 0.0);
        match *self {
            Self::Ellipse { centre, axes } => Self::Ellipse { centre: centre + by, axes },
            Self::Segment { from, to } => Self::Segment { from: from + by, to: to + by },
        }
    }

    /// From where to where it is seen.
    pub(super) fn extent(&self, sight: &Sight) -> Span {
        match *self {
            Self::Ellipse { centre, axes } => {
                let (middle, half) = (sight.place(centre), half_width(&axes, sight));
                [middle - half, middle + half]
            }
            Self::Segment { from, to } => {
                let (a, b) = (sight.place(from), sight.place(to));
                [a.min(b), a.max(b)]
            }
        }
    }

    /// How far towards the viewer its front stands at a place within its extent.
    pub(super) fn front(&self, sight: &Sight, place: f64) -> f64 {
        match *self {
            Self::Ellipse { centre, axes: [a, b] } => {
                let (a_across, b_across) = (a.dot(sight.across), b.dot(sight.across));
                let (a_toward, b_toward) = (a.dot(sight.toward), b.dot(sight.toward));
                let square = a_across * a_across + b_across * b_across;
                let off = place - sight.place(centre);
                // The chords' middles lie on the conjugate diameter.
                let middle = off * (a_across * a_toward + b_across * b_toward) / square;
                let half = (square - off * off).max(0.0).sqrt() * a.perp_dot(b).abs() / square;
                centre.dot(sight.toward) + middle + half
            }
            Self::Segment { from, to } => {
                let (start, end) = (sight.place(from), sight.place(to));
                let share = if start == end { 0.5 } else { (place - start) / (end - start) };
                from.lerp(to, share).dot(sight.toward)
            }
        }
    }

    /// The point at a place along it.
    pub(super) fn at(&self, along: f64) -> DVec2 {
        match *self {
            Self::Ellipse { centre, axes: [a, b] } => {
                centre + a * libm::cos(TAU * along) + b * libm::sin(TAU * along)
            }
            Self::Segment { from, to } => from.lerp(to, along),
        }
    }

    /// Places along it that are seen at one place.
    pub(super) fn along(&self, sight: &Sight, place: f64) -> [Option<f64>; 2] {
        match *self {
            Self::Ellipse { centre, axes } => {
                let cosine = (place - sight.place(centre)) / half_width(&axes, sight);
                if cosine.abs() > 1.0 {
                    return [None; 2];
                }
                let (middle, half) = (angle_across(&axes, sight), libm::acos(cosine));
                [Some(turns(middle - half)), Some(turns(middle + half))]
            }
            Self::Segment { from, to } => {
                let (start, end) = (sight.place(from), sight.place(to));
                [(start != end).then(|| (place - start) / (end - start)), None]
            }
        }
    }

    /// Places along it where it crosses another, if that is longer than it may be: ends of pieces that are none do no harm.
    pub(super) fn crossings(&self, other: &Self) -> [Option<f64>; 2] {
        match (*self, *other) {
            (Self::Segment { from, to }, Self::Segment { from: start, to: end }) => {
                let (own, others) = (to - from, end - start);
                let determinant = own.perp_dot(others);
                [(determinant != 0.0).then(|| (start - from).perp_dot(others) / determinant), None]
            }
            (Self::Segment { from, to }, Self::Ellipse { centre, axes }) => {
                // In coordinates in which the ellipse is the unit circle.
                let (p, d) = (in_axes(&axes, from - centre), in_axes(&axes, to - from));
                let (a, b, c) = (d.length_squared(), p.dot(d), p.length_squared() - 1.0);
                let square = b * b - a * c;
                if square <= 0.0 || a == 0.0 {
                    return [None; 2];
                }
                [Some((-b - square.sqrt()) / a), Some((-b + square.sqrt()) / a)]
            }
            (Self::Ellipse { centre, axes }, Self::Segment { from, to }) => {
                other.crossings(self).map(|share| {
                    let point = in_axes(&axes, from.lerp(to, share?) - centre);
                    Some(turns(libm::atan2(point.y, point.x)))
                })
            }
            // Of a row all ellipses are the same one moved: both points lie on the line half way between.
            (Self::Ellipse { centre, axes }, Self::Ellipse { centre: others, .. }) => {
                let off = in_axes(&axes, others - centre);
                let half = 0.5 * off.length();
                if half == 0.0 || half >= 1.0 {
                    return [None; 2];
                }
                let (middle, turn) = (libm::atan2(off.y, off.x), libm::acos(half));
                [Some(turns(middle - turn)), Some(turns(middle + turn))]
            }
        }
    }

    /// Share of what is seen of it, if nothing hides it, that lies on a part of it.
    pub(super) fn share(&self, sight: &Sight, [start, end]: Span) -> f64 {
        match *self {
            // The front half: the place seen runs as the sine of ψ from its middle.
            Self::Ellipse { axes, .. } => {
                let middle = front_middle(&axes, sight);
                let below = |along: f64| {
                    let off = along - middle / TAU;
                    let whole = libm::floor(off + 0.5);
                    let angle = (TAU * (off - whole)).clamp(-0.5 * PI, 0.5 * PI);
                    whole + 0.5 * (1.0 + libm::sin(angle))
                };
                below(end) - below(start)
            }
            Self::Segment { .. } => end - start,
        }
    }
}

/// Half the width that is seen of an ellipse.
fn half_width(axes: &[DVec2; 2], sight: &Sight) -> f64 {
    libm::hypot(axes[0].dot(sight.across), axes[1].dot(sight.across))
}

/// ψ of the point farthest across.
fn angle_across(axes: &[DVec2; 2], sight: &Sight) -> f64 {
    libm::atan2(axes[1].dot(sight.across), axes[0].dot(sight.across))
}

/// ψ of the middle of the half that faces the viewer.
fn front_middle(axes: &[DVec2; 2], sight: &Sight) -> f64 {
    let middle = angle_across(axes, sight) + 0.5 * PI;
    let point = axes[0] * libm::cos(middle) + axes[1] * libm::sin(middle);
    if point.dot(sight.toward) > 0.0 { middle } else { middle - PI }
}

/// Of an ellipse of perpendicular axes, counter-clockwise, a place of the part of its front that lies on a span: the share `rest` of
/// the width seen of it further on. Its signed distance from the middle over half the width seen, positive to the left of the
/// viewer's direction (counter-clockwise), and the outward normal there.
pub(super) fn front_place(axes: &[DVec2; 2], toward: DVec2, [start, end]: Span, rest: f64) -> (f64, DVec2) {
    let middle = front_middle(axes, &Sight::new(toward));
    let off = start - middle / TAU;
    let first = TAU * (off - libm::floor(off + 0.5));
    let [low, high] =
        [first, first + TAU * (end - start)].map(|angle| libm::sin(angle.clamp(-0.5 * PI, 0.5 * PI)));
    let offset = low + (high - low) * rest;
    let angle = middle + libm::asin(offset.clamp(-1.0, 1.0));
    let [a, b] = axes.map(|axis| axis / axis.length_squared());
    (offset, (a * libm::cos(angle) + b * libm::sin(angle)).normalize())
}

/// A vector in the axes of an ellipse.
fn in_axes([a, b]: &[DVec2; 2], v: DVec2) -> DVec2 {
    DVec2::new(v.perp_dot(*b), a.perp_dot(v)) / a.perp_dot(*b)
}

/// An angle in turns, 0 … 1.
fn turns(angle: f64) -> f64 {
    (angle / TAU).rem_euclid(1.0)
}
