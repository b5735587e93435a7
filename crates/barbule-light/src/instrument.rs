//! What spectrometers see of a feather: which directions light comes from and which are collected.
//!
//! The light's radiance is the same over its aperture, and so is the response over the aperture that collects. A reading is the
//! collected power over that of a perfect white diffuser in the same place,
//!
//! ```text
//! ∫∫ f(ω_i, ω_o) cosθ_i cosθ_o dω_i dω_o  /  ∫∫ (1/π) cosθ_i cosθ_o dω_i dω_o,
//! ```
//!
//! over both apertures, as far as they are above the sample's horizon (Nicodemus et al. 1977, NBS Monograph 160: a biconical
//! reflectance factor). It is no part of a whole: a mirror sends into a cone of half angle α what white spreads over the
//! hemisphere, and reads R/sin²α. In the plane of the sample cosθ dω is the area of the projected direction, dx dy of ω = (x, y, z).

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt;

use crate::error::shortened;
use crate::math::quadrature::gauss_legendre;
use crate::{Error, Result};

/// Nodes for each fringe: π for the fringe itself where it is closest, and thrice as many for the overtones of bright layers.
const FRINGE: f64 = 12.0;
/// Nodes between two kinks, at most: as many fringes as are beyond them leave little of each other, and no stack asks for hours.
const MOST_NODES: usize = 20_000;
/// Nodes of one Gauss rule, at most; more are rules side by side.
const MOST_TOGETHER: usize = 96;

/// Half angles below this, rad (0.005°), are no instrument's.
const NARROWEST: f64 = 1e-4;

/// How an instrument lights a sample and what it collects; radians.
///
/// Angles are counted from the instrument's axis in the plane of incidence, positive towards the lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instrument {
    /// One bundle of fibres gives and takes the light: both apertures are the same cone about the axis.
    Probe {
        /// Half angle of the cone.
        half: f64,
    },
    /// Two arms, each with a cone.
    Arms {
        /// From the axis to the lamp.
        incident: f64,
        /// From the axis to the detector, on the side opposite to the lamp; negative on the lamp's side.
        collected: f64,
        /// Half angle of each cone.
        half: f64,
    },
    /// Light along the axis, and all that is reflected.
    Sphere,
    /// An objective lights and collects through all of its aperture; by the sine condition radiance is the same throughout, so it
    /// sees as a probe does.
    Microscope {
        /// Half angle of the aperture, asin NA in air.
        half: f64,
    },
}

/// A cone of directions whose axis is in the plane of incidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aperture {
    /// From the sample's normal to the cone's axis, rad, positive on the lamp's side.
    pub angle: f64,
    /// Half angle, rad; 0 is a single direction, π/2 about the normal is the hemisphere.
    pub half: f64,
}

/// Light on a planar stack from one angle, and its share in a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incidence {
    /// From the normal, rad, in \[0, π/2).
    pub angle: f64,
    /// What the unpolarized reflectance is multiplied by.
    pub weight: f64,
}

impl Instrument {
    /// Forms of instruments, for messages.
    pub const FORMS: &str = "probe:CONE, arms:IN,OUT,CONE, sphere, microscope:NA";

    /// Reads `probe:CONE`, `arms:IN,OUT,CONE`, `sphere` or `microscope:NA`; degrees, CONE the half angle.
    ///
    /// # Errors
    /// None of these, a cone that is no cone, or one that reaches below the horizon of a sample that is not turned.
    pub fn parse(text: &str) -> Result<Self> {
        Self::read(text.trim())
            .map_err(|why| Error::input(format!("the instrument '{}' {why}", shortened(text))))
    }

    fn read(text: &str) -> Result<Self, String> {
        let (kind, rest) = text.split_once(':').map_or((text, None), |(kind, rest)| (kind, Some(rest)));
        let numbers =
            rest.map_or_else(Vec::new, |rest| rest.split(',').map(|n| n.trim().parse().ok()).collect());
        match (kind, &numbers[..]) {
            ("sphere", []) if rest.is_none() => Ok(Self::Sphere),
            ("probe", &[Some(cone)]) => Ok(Self::Probe { half: half_angle(cone, 0.0)? }),
            ("arms", &[Some(incident), Some(collected), Some(cone)]) => {
                if ![incident, collected].iter().all(|arm| f64::abs(*arm) < 90.0) {
                    return Err(
                        "has an arm at or below the horizon; give IN and OUT between -90 and 90 degrees"
                            .into(),
                    );
                }
                let half = half_angle(cone, f64::abs(incident).max(f64::abs(collected)))?;
                Ok(Self::Arms { incident: incident.to_radians(), collected: collected.to_radians(), half })
            }
            ("microscope", &[Some(aperture)]) => {
                let half = libm::asin(aperture);
                if !(half >= NARROWEST && aperture < 1.0) {
                    return Err(format!(
                        "has the numerical aperture {aperture}; in air it is above 0 and below 1"
                    ));
                }
                Ok(Self::Microscope { half })
            }
            _ => Err(format!("is none of {} (degrees), as in probe:10", Self::FORMS)),
        }
    }

    /// The lamp's and the detector's aperture over a sample whose normal is turned by `turned` rad away from the axis, away from
    /// the lamp.
    #[must_use]
    pub fn apertures(&self, turned: f64) -> [Aperture; 2] {
        match *self {
            Self::Probe { half } | Self::Microscope { half } => [Aperture { angle: turned, half }; 2],
            Self::Arms { incident, collected, half } => {
                [Aperture { angle: turned + incident, half }, Aperture { angle: turned - collected, half }]
            }
            Self::Sphere => [Aperture { angle: turned, half: 0.0 }, Aperture { angle: 0.0, half: FRAC_PI_2 }],
        }
    }

    /// The angle at which planes parallel to the top, or facets that send light from one axis to the other, are lit in a sample
    /// that is turned by `turned` rad: what a law of peaks against angle is about.
    ///
    /// A facet that is a mirror from one arm to the other is lit at half the angle between them however the sample is turned
    /// (Osorio & Ham 2002). Of probes, microscopes and spheres it is the angle of incidence.
    #[must_use]
    pub fn law_angle(&self, turned: f64) -> f64 {
        match *self {
            Self::Arms { incident, collected, .. } => 0.5 * (incident + collected).abs(),
            Self::Probe { .. } | Self::Microscope { .. } | Self::Sphere => turned.abs(),
        }
    }

    /// Whether a sample that is turned by `turned` rad still faces lamp and detector.
    ///
    /// # Errors
    /// The axis of an aperture is at or below the sample's horizon.
    pub fn check(&self, turned: f64) -> Result<()> {
        let names = ["lamp", "detector"];
        let below = self
            .apertures(turned)
            .into_iter()
            .zip(names)
            .find(|(one, _)| one.angle.is_nan() || one.angle.abs() >= FRAC_PI_2);
        match below {
            None => Ok(()),
            Some((aperture, name)) => Err(Error::input(format!(
                "{self}: with the sample turned by {:.4}° the {name} is {:.4}° from its normal, at or below its horizon; turn it less",
                turned.to_degrees(),
                aperture.angle.to_degrees()
            ))),
        }
    }

    /// What a planar stack reads that is turned by `turned` rad away from the axis: Σ weight · R(angle), R its unpolarized
    /// reflectance, beside a perfect white diffuser in its place.
    ///
    /// There are no terms where nothing of the light that the stack mirrors is collected, as for arms that are not in mirror
    /// position. `waves` is the thickness of all layers over the shortest wavelength: light that crosses them and comes back makes
    /// fringes over the angles, as many as 2 · `waves` times what cosθ falls by, and the rule follows them and the sharper
    /// ones that bright layers make of them (`FRINGE`). It is good to 1e-9 of Σ weight, of stacks millimetres thick (`MOST_NODES`) to 1e-2.
    #[must_use]
    pub fn planar(&self, turned: f64, waves: f64) -> Vec<Incidence> {
        let [lit, seen] = self.apertures(turned);
        if matches!(self, Self::Sphere) {
            return vec![Incidence { angle: turned.abs(), weight: 1.0 }];
        }
        // Light from (x, y) leaves towards (−x, −y).
        let mirrored = Aperture { angle: -seen.angle, ..seen };
        let scale = PI / (lit.projected_area() * seen.projected_area());
        let both = shared(&[lit, mirrored], waves);
        both.into_iter()
            .map(|Incidence { angle, weight }| Incidence { angle, weight: scale * weight })
            .collect()
    }
}

impl fmt::Display for Instrument {
    /// As [`Instrument::parse`] reads it, to 1e-9.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |value: f64| (value * 1e9).round() / 1e9;
        let degrees = |angle: f64| number(angle.to_degrees());
        match *self {
            Self::Probe { half } => write!(f, "probe:{}", degrees(half)),
            Self::Arms { incident, collected, half } => {
                write!(f, "arms:{},{},{}", degrees(incident), degrees(collected), degrees(half))
            }
            Self::Sphere => write!(f, "sphere"),
            Self::Microscope { half } => write!(f, "microscope:{}", number(libm::sin(half))),
        }
    }
}

impl Aperture {
    /// The azimuths about the sample's normal, counted from the plane of incidence on the lamp's side, at which directions `polar`
    /// rad from the normal are inside: those from −reach to reach, or from π − reach to π + reach where the axis is on the other
    /// side.
    fn reach(&self, polar: f64) -> f64 {
        let (sin, cos) = libm::sincos(polar);
        let (across, up) = libm::sincos(self.angle.abs());
        let least = libm::cos(self.half) - cos * up;
        let most = sin * across;
        if least <= -most {
            PI
        } else if least >= most {
            0.0
        } else {
            libm::acos(least / most)
        }
    }

    /// ∫ cosθ dω over the part above the sample's horizon: π sin²half · cos angle of a cone that is wholly above it.
    #[must_use]
    pub fn projected_area(&self) -> f64 {
        if self.angle.abs() + self.half <= FRAC_PI_2 {
            return PI * libm::sin(self.half).powi(2) * libm::cos(self.angle);
        }
        shared(&[*self], 0.0).iter().map(|node| node.weight).sum()
    }
}

/// Polar angles and weights ∫ cosθ dω of what is inside all of one or two apertures and above the horizon.
///
/// The azimuths inside are known in closed form at each polar angle; they have kinks and square roots where circles touch or
/// cross, which the substitution θ = mid − h cos u between such angles makes smooth. `waves` as in [`Instrument::planar`].
fn shared(apertures: &[Aperture], waves: f64) -> Vec<Incidence> {
    let mut ends = vec![0.0, FRAC_PI_2];
    for one in apertures {
        let angle = one.angle.abs();
        ends.extend([(angle - one.half).abs(), angle + one.half]);
    }
    if let [a, b] = apertures {
        ends.extend(crossings(a, b));
    }
    ends.retain(|end| (0.0..=FRAC_PI_2).contains(end));
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let mut nodes = Vec::new();
    for pair in ends.windows(2) {
        let (mid, reach) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
        if reach < 1e-12 || azimuths(apertures, mid) == 0.0 {
            continue;
        }
        // cosθ falls by 2 sin(mid) sin(reach).
        let fringes = 4.0 * waves * libm::sin(mid) * libm::sin(reach);
        let count = (10 + (40.0 * reach + FRINGE * fringes).ceil() as usize).min(MOST_NODES);
        let parts = count.div_ceil(MOST_TOGETHER);
        let rule = gauss_legendre(count.div_ceil(parts));
        for part in 0..parts {
            for &(at, weight) in &rule {
                let (sin_u, cos_u) = libm::sincos(PI * (part as f64 + at) / parts as f64);
                let polar = mid - reach * cos_u;
                let (sin, cos) = libm::sincos(polar);
                let weight =
                    weight / parts as f64 * PI * reach * sin_u * sin * cos * azimuths(apertures, polar);
                if weight > 0.0 {
                    nodes.push(Incidence { angle: polar, weight });
                }
            }
        }
    }
    nodes
}

/// The range of azimuths inside all apertures at a polar angle, rad.
fn azimuths(apertures: &[Aperture], polar: f64) -> f64 {
    let reach = |one: &Aperture| one.reach(polar);
    match apertures {
        [one] => 2.0 * reach(one),
        // Both on the same side of the normal: the narrower one; on opposite sides: what both reaches have over π.
        [a, b] if a.angle == 0.0 || b.angle == 0.0 || (a.angle > 0.0) == (b.angle > 0.0) => {
            2.0 * reach(a).min(reach(b))
        }
        [a, b] => (2.0 * (reach(a) + reach(b)) - TAU).max(0.0),
        _ => 0.0,
    }
}

/// The polar angles at which the circles of two apertures cross: kinks of what both share.
fn crossings(a: &Aperture, b: &Aperture) -> Vec<f64> {
    // cosψ sinθ sin α + cosθ cos α = cos half for both: linear in (sinθ cosψ, cosθ).
    let (sin_a, cos_a) = libm::sincos(a.angle);
    let (sin_b, cos_b) = libm::sincos(b.angle);
    let determinant = sin_a * cos_b - sin_b * cos_a;
    if determinant.abs() < 1e-12 {
        return Vec::new();
    }
    let (at_a, at_b) = (libm::cos(a.half), libm::cos(b.half));
    let z = (sin_a * at_b - sin_b * at_a) / determinant;
    // Where they touch within one half-plane ψ = 0 the ends of the apertures are the kinks already.
    if (0.0..=1.0).contains(&z) { vec![libm::acos(z)] } else { Vec::new() }
}

/// The half angle of a cone in degrees whose axis is up to `from_deg` from the normal, rad.
fn half_angle(cone_deg: f64, from_deg: f64) -> Result<f64, String> {
    let half = cone_deg.to_radians();
    if !(half >= NARROWEST && cone_deg <= 90.0) {
        return Err(format!(
            "has a cone of {cone_deg}°; give its half angle in degrees, over 0.006 and up to 90"
        ));
    }
    if from_deg + cone_deg > 90.0 {
        return Err(format!(
            "has a cone that reaches {}° from the normal, below the horizon; give a smaller angle or CONE",
            from_deg + cone_deg
        ));
    }
    Ok(half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Stream;

    fn parsed(text: &str) -> Instrument {
        Instrument::parse(text).unwrap()
    }

    fn reading(instrument: &str, turned_deg: f64, reflectance: impl Fn(f64) -> f64) -> f64 {
        let nodes = parsed(instrument).planar(f64::to_radians(turned_deg), 0.0);
        nodes.iter().map(|node| node.weight * reflectance(node.angle)).sum()
    }

    #[test]
    fn what_is_written_is_read() {
        for text in
            ["probe:10", "arms:30,-12.5,2", "sphere", "microscope:0.4", "probe:90", "arms:-45,45,0.01"]
        {
            assert_eq!(parsed(text).to_string(), text);
        }
        assert_eq!(parsed(" microscope: 0.5 "), Instrument::Microscope { half: libm::asin(0.5) });
    }

    #[test]
    fn what_is_no_instrument_is_refused() {
        for (text, part) in [
            ("prob:10", "none of probe:CONE, arms:IN,OUT,CONE, sphere, microscope:NA"),
            ("probe", "none of"),
            ("probe:1,2", "none of"),
            ("sphere:1", "none of"),
            ("arms:30,30", "none of"),
            ("probe:ten", "none of"),
            ("probe:0", "has a cone of 0°"),
            ("probe:NaN", "has a cone of NaN°"),
            ("probe:91", "has a cone of 91°"),
            ("arms:95,30,2", "an arm at or below the horizon"),
            ("arms:NaN,30,2", "an arm at or below the horizon"),
            ("arms:85,30,10", "reaches 95° from the normal, below the horizon"),
            ("microscope:1", "numerical aperture 1;"),
            ("microscope:0", "numerical aperture 0;"),
            ("microscope:-0.3", "numerical aperture -0.3;"),
        ] {
            let error = Instrument::parse(text).unwrap_err();
            assert!(error.is_input() && error.to_string().contains(part), "{text}: {error}");
        }
        let error = parsed("arms:60,10,2").check(f64::to_radians(35.0)).unwrap_err().to_string();
        assert!(error.contains("the lamp is 95.0000° from its normal"), "{error}");
        assert!(parsed("arms:60,10,2").check(f64::to_radians(-35.0)).is_ok());
    }

    #[test]
    fn mirrors_read_what_closed_forms_say() {
        // A probe upright over a mirror: all of its cone comes back, 1/sin²α; R(θ) = cos²θ has the mean 1 − sin²α/2.
        for cone in [1.0_f64, 10.0, 60.0, 90.0] {
            let squared = cone.to_radians().sin().powi(2);
            let probe = format!("probe:{cone}");
            assert!((reading(&probe, 0.0, |_| 1.0) * squared - 1.0).abs() < 1e-10, "{cone}");
            let faded = reading(&probe, 0.0, |angle| angle.cos().powi(2));
            assert!((faded * squared / (1.0 - 0.5 * squared) - 1.0).abs() < 1e-10, "{cone}");
        }
        let na = 0.4_f64;
        assert!((reading("microscope:0.4", 0.0, |_| 1.0) * na * na - 1.0).abs() < 1e-10);
        // Arms in mirror position share their whole cones: π / ∫cosθ dω.
        let squared = f64::to_radians(3.0).sin().powi(2) * f64::to_radians(30.0).cos();
        assert!((reading("arms:30,30,3", 0.0, |_| 1.0) * squared - 1.0).abs() < 1e-9);
        assert_eq!(reading("sphere", 40.0, |angle| angle.to_degrees().round()), 40.0);
    }

    /// ½ (1 + cos 4π D cosθ) over a probe's cone is known: with s = cosθ, ∫ s cos(as) ds.
    #[test]
    fn fringes_of_thick_stacks_are_followed() {
        for (text, waves) in
            [("probe:20", 100.0), ("microscope:0.9", 20.0), ("microscope:0.9", 2000.0), ("probe:90", 50.0)]
        {
            let instrument = parsed(text);
            let a = 4.0 * PI * waves;
            let nodes = instrument.planar(0.0, waves);
            let found: f64 =
                nodes.iter().map(|n| n.weight * 0.5 * (1.0 + libm::cos(a * libm::cos(n.angle)))).sum();
            let low = libm::cos(instrument.apertures(0.0)[0].half);
            let integral = |s: f64| 0.5 * s * s + (s * libm::sin(a * s) + libm::cos(a * s) / a) / a;
            let squared = 1.0 - low * low;
            let expected = (integral(1.0) - integral(low)) / squared / squared;
            assert!((found / expected - 1.0).abs() < 1e-9, "{text} {waves}: {found} {expected}");
        }
        // Of far more fringes than there are nodes half is left.
        for waves in [3e4, 1e5, 7e6] {
            let nodes = parsed("microscope:0.9").planar(0.0, waves);
            let sum: f64 = nodes.iter().map(|node| node.weight).sum();
            let fringe = |angle: f64| 0.5 * (1.0 + libm::cos(4.0 * PI * waves * libm::cos(angle)));
            let found: f64 = nodes.iter().map(|node| node.weight * fringe(node.angle)).sum();
            assert!(
                nodes.len() <= MOST_NODES + MOST_TOGETHER && (found / sum - 0.5).abs() < 0.01,
                "{waves}: {found} of {sum}"
            );
        }
    }

    #[test]
    fn narrow_arms_see_one_angle_and_arms_out_of_mirror_position_none() {
        let nodes = parsed("arms:20,40,0.05").planar(f64::to_radians(10.0), 0.0);
        let sum: f64 = nodes.iter().map(|node| node.weight).sum();
        let mean = nodes.iter().map(|node| node.weight * node.angle.to_degrees()).sum::<f64>() / sum;
        assert!((mean - 30.0).abs() < 1e-4, "{mean}");
        assert!(parsed("arms:20,40,0.05").planar(0.0, 0.0).is_empty());
        assert!(parsed("arms:30,-30,10").planar(0.0, 0.0).is_empty());
        assert!(parsed("probe:5").planar(0.1, 0.0).is_empty());
    }

    #[test]
    fn arms_are_reciprocal() {
        for (there, back) in [("arms:20,35,12", "arms:35,20,12"), ("arms:50,40,20", "arms:40,50,20")] {
            let fade = |angle: f64| (3.0 * angle).sin().powi(2);
            let (there, back) = (reading(there, 0.0, fade), reading(back, 0.0, fade));
            assert!((there / back - 1.0).abs() < 1e-9 && there > 0.0, "{there} {back}");
        }
    }

    /// Directions drawn uniformly over projected areas: lamp's ones, and which of their mirror images are collected.
    #[test]
    fn random_rays_give_the_same_readings() {
        let fade = |angle: f64| 0.3 + 0.7 * (2.5 * angle).cos().powi(2);
        for (k, (text, turned)) in [
            ("probe:20", 12.0),
            ("probe:60", 50.0),
            ("arms:30,42,14", 0.0),
            ("arms:10,60,29", 20.0),
            ("arms:10,-5,12", 3.0),
            ("microscope:0.7", -20.0),
        ]
        .into_iter()
        .enumerate()
        {
            let [lit, seen] = parsed(text).apertures(f64::to_radians(turned));
            let inside =
                |one: &Aperture, x: f64, z: f64| x * one.angle.sin() + z * one.angle.cos() >= one.half.cos();
            let mut stream = Stream::new(7, &[k as u64]);
            let count = 400_000;
            let (mut in_lit, mut in_seen, mut sum, mut squares) = (0.0, 0.0, 0.0, 0.0);
            for _ in 0..count {
                let (x, y) = (stream.uniform(-1.0, 1.0), stream.uniform(-1.0, 1.0));
                let squared = x * x + y * y;
                if squared > 1.0 {
                    continue;
                }
                let z = (1.0 - squared).sqrt();
                in_seen += f64::from(u8::from(inside(&seen, x, z)));
                if !inside(&lit, x, z) {
                    continue;
                }
                in_lit += 1.0;
                if inside(&seen, -x, z) {
                    let value = fade(z.acos());
                    sum += value;
                    squares += value * value;
                }
            }
            let area = 4.0 / f64::from(count);
            for (one, hits) in [(lit, in_lit), (seen, in_seen)] {
                let error = (hits * area / one.projected_area() - 1.0).abs();
                assert!(error < 4.0 / f64::sqrt(hits), "{text}: area off by {error}");
            }
            let drawn = PI * sum * area / (lit.projected_area() * seen.projected_area());
            let found = reading(text, turned, fade);
            let spread = squares.sqrt() / sum;
            assert!((drawn / found - 1.0).abs() < 4.0 * spread, "{text}: {found}, drawn {drawn} ± {spread}");
        }
    }
}
