//! A feather under an instrument, and what of both apertures each of its barbules has.
//!
//! The instrument's axes are turned into the barbule's own frame; in it a cone of directions cuts the specular cone of θ in one
//! range of azimuths.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use crate::Result;
use crate::instrument::Instrument;
use crate::math::quadrature::gauss_legendre;

/// How far from the mean tilts are taken, in standard deviations, and at most, rad: barbules that are turned further are behind others.
const FURTHEST_TILT: f64 = 3.0;
const STEEPEST: f64 = 1.4;

/// Slopes in each piece of their range.
const SLOPES: usize = 12;
/// Even tilts on either side of the mean, at least.
const FEWEST_TILTS: usize = 4;
/// Turns are closer than what they are to resolve by this.
const TURNS_PER_WIDTH: f64 = 6.0;
/// Halvings of a range of slopes: to the last digits.
const BISECTIONS: usize = 52;
/// Standard deviations of lobes within which they are taken.
const LOBE_REACH: f64 = 4.0;

/// A feather in the place of an instrument's sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// The instrument.
    pub instrument: Instrument,
    /// The feather's normal is this far, rad, from the instrument's axis, away from the lamp.
    pub turned: f64,
    /// Whether the plane of incidence is along the barbules rather than across them.
    pub along: bool,
    /// The feather is turned about its own normal by this, rad, from x towards y.
    pub about_normal: f64,
    /// Standard deviations between barbules, rad, of normal distributions: of their long axes' slope out of the plane of the vane, and
    /// of their turn about these axes.
    pub tilt: [f64; 2],
    /// The vane in which neighbours hide each other; none: they lie side by side and hide nothing.
    pub vane: Option<Vane>,
}

/// Barbules in a vane like the slats of a blind, all turned alike.
///
/// What of a slat's width is both lit and seen scatters as that share of the whole barbule; light that goes on to neighbours is lost. In the
/// plane across the slats this is exact for rays: a neighbour at (a, b) of the slat's frame hides what lies behind the ray of its edge, and
/// of a slat as wide as w min(w, |q|) is left, q = a − b tanφ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vane {
    /// From one barbule to the next, µm.
    pub pitch_um: f64,
    /// Width of a barbule, µm.
    pub width_um: f64,
    /// Turn of barbules about their axes, rad: positive lifts the side of −x.
    pub turn: f64,
}

impl Vane {
    /// The part of a slat's width that gets light out to the azimuth φ of its frame, µm from its middle.
    fn open(&self, phi: f64) -> [f64; 2] {
        let (rise, run) = self.turn.sin_cos();
        let from_edge = self.pitch_um * (run - rise * phi.tan());
        let (half, seen) = (0.5 * self.width_um, from_edge.abs().min(self.width_um));
        if (rise >= 0.0) == (from_edge >= 0.0) { [-half, seen - half] } else { [half - seen, half] }
    }

    /// Area of slats that is lit from φ_i and seen from φ_o, azimuths of their frame, over that of the vane.
    pub(crate) fn shared(&self, phi_i: f64, phi_o: f64) -> f64 {
        if [phi_i, phi_o].iter().any(|phi| (phi + self.turn).abs() >= FRAC_PI_2) {
            return 0.0;
        }
        let ([a, b], [c, d]) = (self.open(phi_i), self.open(phi_o));
        (b.min(d) - a.max(c)).max(0.0) / self.pitch_um
    }
}

/// One tilt of barbules with both apertures in their frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tilted {
    pub(crate) lit: Beam,
    pub(crate) seen: Beam,
    /// How much area of such barbules there is over an area of the vane, before neighbours hide any.
    pub(crate) weight: f64,
    /// The neighbours, which are turned alike.
    pub(crate) vane: Option<Vane>,
}

/// Standard deviations of the lobes in which barbules scatter light of one direction, rad.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lobes {
    /// The narrowest and the widest along barbules; 0 where light keeps its longitude.
    pub(crate) along: [f64; 2],
    /// The narrowest across them.
    pub(crate) across: f64,
}

/// A cone of directions in a barbule's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    axis: DVec3,
    /// π: all that is above the barbule.
    half: f64,
}

impl Mount {
    /// Refuses a feather that an instrument does not face.
    ///
    /// # Errors
    /// As [`Instrument::check`].
    pub fn check(&self) -> Result<()> {
        self.instrument.check(self.turned)
    }

    /// The axis of the lamp in the frame of untilted barbules: longitude θ and azimuth φ, rad.
    #[must_use]
    pub fn incidence(&self) -> (f64, f64) {
        self.axes()[0].axis.angles()
    }

    /// The angle of the law that peaks follow, rad; see [`Instrument::law_angle`].
    #[must_use]
    pub fn law_angle(&self) -> f64 {
        self.instrument.law_angle(self.turned)
    }

    /// Whether all barbules lie flat and hide nothing.
    #[must_use]
    pub fn is_flat(&self) -> bool {
        self.tilt == [0.0; 2] && self.vane.is_none()
    }

    /// What the power collected of a white diffuser is multiplied by to be 1: π over both projected apertures. Of spheres one over
    /// the cosine of incidence.
    pub(crate) fn scale(&self) -> f64 {
        let [lit, seen] = self.instrument.apertures(self.turned);
        match self.instrument {
            Instrument::Sphere => lit.angle.cos().recip(),
            _ => PI / (lit.projected_area() * seen.projected_area()),
        }
    }

    fn axes(&self) -> [Beam; 2] {
        let (sin, cos) = self.about_normal.sin_cos();
        self.instrument.apertures(self.turned).map(|aperture| {
            let (out, up) = aperture.angle.sin_cos();
            let (x, y) = if self.along { (0.0, out) } else { (out, 0.0) };
            let half = if matches!(self.instrument, Instrument::Sphere) && aperture.half > 0.0 {
                PI
            } else {
                aperture.half
            };
            Beam { axis: DVec3::new(x * cos + y * sin, y * cos - x * sin, up), half }
        })
    }

    /// The tilts of barbules with these lobes.
    ///
    /// A slope of α turns the mirrored beam by 2α, so that apertures share light at few slopes however widely these are spread. The rule is
    /// Gauss's over those alone, apart on both sides of the slope at which most is shared, where readings have a kink. Turns are even, over
    /// ±3 standard deviations: across them barbules send light anywhere.
    pub(crate) fn tilted(&self, lobes: Lobes) -> Vec<Tilted> {
        let axes = self.axes();
        let [slopes, turns] = match self.instrument {
            Instrument::Sphere => self.tilt.map(|deviation| even_rule(deviation, f64::INFINITY)),
            _ => {
                let width = axes[0].half.min(axes[1].half).hypot(lobes.across);
                [
                    slope_rule(self.tilt[0], &axes, lobes.along),
                    even_rule(self.tilt[1], width / TURNS_PER_WIDTH),
                ]
            }
        };
        let mut all = Vec::with_capacity(slopes.len() * turns.len());
        for &(slope, share) in &slopes {
            for &(turn, part) in &turns {
                // In a vane the slats' own geometry says how much of them there is.
                let vane = self.vane.map(|vane| Vane { turn: vane.turn + turn, ..vane });
                let turn = vane.map_or(turn, |vane| vane.turn);
                let area = if vane.is_some() { 1.0 } else { turn.cos().recip() };
                let [lit, seen] = axes.map(|beam| Beam { axis: in_frame(beam.axis, slope, turn), ..beam });
                all.push(Tilted { lit, seen, weight: share * part * area / slope.cos(), vane });
            }
        }
        all
    }
}

impl Beam {
    /// Longitude θ and azimuth φ of the axis.
    pub(crate) fn direction(&self) -> (f64, f64) {
        self.axis.angles()
    }

    /// The least and the largest θ inside.
    pub(crate) fn theta_range(&self) -> [f64; 2] {
        let theta = self.axis.angles().0;
        [(theta - self.half).max(-FRAC_PI_2), (theta + self.half).min(FRAC_PI_2)]
    }

    /// The azimuths above the horizon that are inside at the longitude θ.
    pub(crate) fn azimuths(&self, theta: f64) -> Option<[f64; 2]> {
        if self.half >= PI {
            return Some([-FRAC_PI_2, FRAC_PI_2]);
        }
        // ω·axis = sinθ a_y + cosθ √(a_x² + a_z²) cos(φ − φ_a).
        let across = self.axis.x.hypot(self.axis.z);
        let least = (self.half.cos() - theta.sin() * self.axis.y) / (theta.cos() * across);
        if least >= 1.0 {
            return None;
        }
        let (middle, reach) = (self.axis.angles().1, least.max(-1.0).acos());
        let range = [(middle - reach).max(-FRAC_PI_2), (middle + reach).min(FRAC_PI_2)];
        (range[0] < range[1]).then_some(range)
    }
}

trait Angles {
    fn angles(&self) -> (f64, f64);
}

impl Angles for DVec3 {
    fn angles(&self) -> (f64, f64) {
        (self.y.clamp(-1.0, 1.0).asin(), self.x.atan2(self.z))
    }
}

/// A direction in the frame of a barbule whose axis rises by `slope` and which is turned by `turn` about it.
fn in_frame(w: DVec3, slope: f64, turn: f64) -> DVec3 {
    let (sin, cos) = slope.sin_cos();
    let (along, up) = (w.y * cos + w.z * sin, w.z * cos - w.y * sin);
    let (sin, cos) = turn.sin_cos();
    DVec3::new(w.x * cos - up * sin, along, w.x * sin + up * cos)
}

/// How far tilts of this standard deviation go, rad.
fn furthest(deviation: f64) -> f64 {
    (FURTHEST_TILT * deviation).min(STEEPEST)
}

/// Nodes and weights, which sum to 1, of a normal distribution as far as it goes: even ones, no further apart than `step`.
fn even_rule(deviation: f64, step: f64) -> Vec<(f64, f64)> {
    if deviation == 0.0 {
        return vec![(0.0, 1.0)];
    }
    let reach = furthest(deviation);
    let steps = ((reach / step).ceil() as usize).max(FEWEST_TILTS);
    let nodes = (0..=2 * steps).map(|k| reach * (k as f64 / steps as f64 - 1.0));
    let rule: Vec<(f64, f64)> = nodes.map(|at| (at, bell(at, deviation))).collect();
    let sum: f64 = rule.iter().map(|node| node.1).sum();
    rule.into_iter().map(|(at, weight)| (at, weight / sum)).collect()
}

/// Nodes and weights of the slopes at which the apertures about two axes share light whose longitude barbules keep but for such lobes;
/// shares of the whole normal distribution. None where they never do.
fn slope_rule(deviation: f64, axes: &[Beam; 2], lobes: [f64; 2]) -> Vec<(f64, f64)> {
    if deviation == 0.0 {
        return vec![(0.0, 1.0)];
    }
    // Where both axes are above barbules, their longitudes rise with the slope.
    let leanings = axes.each_ref().map(|beam| beam.axis.y.atan2(beam.axis.z));
    let reach = furthest(deviation);
    let low = (-reach).max(-FRAC_PI_2 - leanings[0].min(leanings[1]));
    let high = reach.min(FRAC_PI_2 - leanings[0].max(leanings[1]));
    if low >= high {
        return Vec::new();
    }
    let longitudes =
        |slope: f64| axes.iter().map(|beam| in_frame(beam.axis, slope, 0.0).angles().0).sum::<f64>();
    let [near, far] = lobes.map(|lobe| axes[0].half + axes[1].half + LOBE_REACH * lobe);
    let edges = [-far, -near, 0.0, near, far].map(|wanted| {
        let (mut below, mut above) = (low, high);
        for _ in 0..BISECTIONS {
            let half_way = 0.5 * (below + above);
            if longitudes(half_way) < wanted {
                below = half_way;
            } else {
                above = half_way;
            }
        }
        0.5 * (below + above)
    });
    // ∫ of the bell as far as it goes.
    let whole: f64 =
        integral_rule(-reach, reach, 4 * SLOPES).map(|(at, weight)| weight * bell(at, deviation)).sum();
    let pieces = edges.windows(2).filter(|piece| piece[0] < piece[1]);
    let nodes = pieces.flat_map(|piece| integral_rule(piece[0], piece[1], SLOPES));
    nodes.map(|(at, weight)| (at, weight * bell(at, deviation) / whole)).collect()
}

fn bell(at: f64, deviation: f64) -> f64 {
    libm::exp(-0.5 * (at / deviation).powi(2))
}

/// Gauss's rule over an interval.
fn integral_rule(from: f64, to: f64, count: usize) -> impl Iterator<Item = (f64, f64)> {
    gauss_legendre(count).into_iter().map(move |(at, weight)| (from + (to - from) * at, (to - from) * weight))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::directions::omega;

    const KEPT: Lobes = Lobes { along: [0.0; 2], across: 0.01 };

    #[test]
    fn azimuths_of_a_cone_are_those_inside_it() {
        let mount = |along, about_normal| Mount {
            instrument: Instrument::parse("arms:40,10,25").unwrap(),
            turned: 0.2,
            along,
            about_normal,
            tilt: [0.05, 0.02],
            vane: None,
        };
        for mount in [mount(false, 0.0), mount(true, 0.0), mount(false, 0.7), mount(true, -2.0)] {
            for tilted in mount.tilted(KEPT) {
                for beam in [tilted.lit, tilted.seen] {
                    for k in -44..=44 {
                        let theta = f64::from(2 * k).to_radians();
                        let range = beam.azimuths(theta);
                        for j in -89..=89 {
                            let phi = (f64::from(j) + 0.37).to_radians();
                            let inside = omega(theta, phi).dot(beam.axis) >= beam.half.cos();
                            assert_eq!(inside, range.is_some_and(|[from, to]| (from..=to).contains(&phi)));
                            let [least, most] = beam.theta_range();
                            assert!(!inside || (least - 1e-9..=most + 1e-9).contains(&theta));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn frames_turn_as_they_say() {
        // Where the axis rises towards +y by 0.1, the normal falls back from light on that side.
        let (theta, phi) = in_frame(omega(0.3, 0.0), 0.1, 0.0).angles();
        assert!((theta - 0.4).abs() < 1e-12 && phi.abs() < 1e-12, "{theta} {phi}");
        let (theta, phi) = in_frame(omega(0.3, 0.5), 0.0, 0.1).angles();
        assert!((theta - 0.3).abs() < 1e-12 && (phi - 0.4).abs() < 1e-12);
        let mount = Mount {
            instrument: Instrument::Sphere,
            turned: 0.5,
            along: false,
            about_normal: FRAC_PI_2,
            tilt: [0.1, 0.1],
            vane: None,
        };
        let (theta, phi) = mount.incidence();
        assert!((theta + 0.5).abs() < 1e-12 && phi.abs() < 1e-12, "{theta} {phi}");
        // Facets over a unit of area take what falls on it.
        let white: f64 = mount
            .tilted(KEPT)
            .iter()
            .map(|t| {
                let (theta, phi) = t.lit.direction();
                t.weight * theta.cos() * phi.cos()
            })
            .sum();
        assert!((white * mount.scale() - 1.0).abs() < 1e-12, "{white}");
    }

    /// Rays from places of a slat, followed past its neighbours one by one.
    #[test]
    fn what_neighbours_hide_is_what_rays_meet() {
        for vane in [
            Vane { pitch_um: 14.0, width_um: 25.0, turn: -0.14 },
            Vane { pitch_um: 20.0, width_um: 25.0, turn: 0.5 },
            Vane { pitch_um: 30.0, width_um: 12.0, turn: 0.9 },
        ] {
            let (rise, run) = vane.turn.sin_cos();
            let gets_out = |s: f64, phi: f64| {
                (-40..=40).filter(|k| *k != 0).all(|k| {
                    let (ahead, up) =
                        (f64::from(k) * vane.pitch_um * run, f64::from(k) * vane.pitch_um * rise);
                    up < 0.0 || (s + up * phi.tan() - ahead).abs() > 0.5 * vane.width_um
                })
            };
            for phi_i in [-70.0_f64, -31.0, 0.0, 12.0, 55.0].map(f64::to_radians) {
                for phi_o in [-48.0_f64, -9.0, 20.0, 66.0].map(f64::to_radians) {
                    let above = |phi: f64| (phi + vane.turn).abs() < FRAC_PI_2;
                    let count = 2000;
                    let places =
                        (0..count).map(|k| vane.width_um * ((f64::from(k) + 0.5) / f64::from(count) - 0.5));
                    let both = places.filter(|s| gets_out(*s, phi_i) && gets_out(*s, phi_o)).count();
                    let expected = both as f64 / f64::from(count) * vane.width_um / vane.pitch_um;
                    let expected = if above(phi_i) && above(phi_o) { expected } else { 0.0 };
                    let found = vane.shared(phi_i, phi_o);
                    assert!((found - expected).abs() < 3e-3, "{vane:?} {phi_i} {phi_o}: {found} {expected}");
                }
            }
        }
    }
}
