//! Quanta that cones catch.

use crate::error::shortened;
use crate::spectrum::Spectrum;
use crate::spectrum::dense::{DenseSpectrum, LONGEST_NM, SHORTEST_NM};
use crate::{Error, Result};

use super::{Eye, Light};

/// The part of what each cone catches of white that must lie within a reflectance's wavelengths: nothing is invented outside.
pub const LEAST_SEEN: f64 = 0.985;

/// An eye in a light, to which it is adapted: white is 1 for each cone (von Kries).
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Who sees.
    pub eye: Eye,
    /// In which light.
    pub light: Light,
    /// For each cone, the double ones last, its answers to the light at each nm.
    seen: Vec<DenseSpectrum>,
}

/// Quanta caught, each over those of white in the same light.
#[derive(Debug, Clone, PartialEq)]
pub struct Catches {
    /// By each cone, in the eye's order.
    pub cones: Vec<f64>,
    /// By the double cones.
    pub double: Option<f64>,
}

impl View {
    /// An eye in a light.
    ///
    /// # Errors
    /// The light is not known where a cone has more than 1.5 % of its sensitivity, or a cone sees nothing of it.
    pub fn new(eye: Eye, light: Light) -> Result<Self> {
        let [low, high] = light.known_nm;
        for cone in eye.all_cones() {
            let answers = &cone.sensitivity;
            let known = within(answers, low, high) / within(answers, SHORTEST_NM, LONGEST_NM);
            if known < LEAST_SEEN {
                return Err(Error::input(format!(
                    "the light '{}' is known from {low} to {high} nm, where the cone {} of {} has {:.0} % of its sensitivity, and nothing is invented outside; give one from 300 to 700 nm",
                    shortened(&light.name),
                    cone.name,
                    shortened(&eye.name),
                    100.0 * known
                )));
            }
        }
        let seen: Vec<DenseSpectrum> =
            eye.all_cones().map(|cone| cone.sensitivity.times(&light.quanta)).collect();
        if let Some(blind) = seen.iter().position(|answers| within(answers, SHORTEST_NM, LONGEST_NM) <= 0.0) {
            let name = eye.all_cones().nth(blind).map_or("", |cone| cone.name.as_str());
            return Err(Error::input(format!(
                "the light '{}' has nothing that the cone {name} of {} sees; give one that shines from 300 to 700 nm",
                shortened(&light.name),
                shortened(&eye.name)
            )));
        }
        Ok(Self { eye, light, seen })
    }

    /// The cone that sees least of what lies within a range of nm, and the part of white that it sees there.
    #[must_use]
    pub fn least_seen(&self, [low, high]: [f64; 2]) -> (&str, f64) {
        let parts = self.eye.all_cones().zip(&self.seen).map(|(cone, answers)| {
            (cone.name.as_str(), within(answers, low, high) / within(answers, SHORTEST_NM, LONGEST_NM))
        });
        parts.fold(("", 1.0), |least, part| if part.1 < least.1 { part } else { least })
    }

    /// The narrowest whole nanometres between which every cone sees enough.
    #[must_use]
    pub fn needed_nm(&self) -> [f64; 2] {
        let enough = |low: f64, high: f64| self.least_seen([low, high]).1 >= LEAST_SEEN;
        let (mut low, mut high) = (SHORTEST_NM, LONGEST_NM);
        while enough(low + 1.0, high) && low + 1.0 < high {
            low += 1.0;
        }
        while enough(low, high - 1.0) && high - 1.0 > low {
            high -= 1.0;
        }
        [low, high]
    }

    /// Refuses a range of wavelengths, nm, outside which a cone sees more of white than 1.5 %.
    ///
    /// # Errors
    /// It is that; `what` begins the sentence, as in `the reflectance`.
    pub fn check(&self, what: &str, [low, high]: [f64; 2]) -> Result<()> {
        let (cone, part) = self.least_seen([low, high]);
        if part >= LEAST_SEEN {
            return Ok(());
        }
        let [from, to] = self.needed_nm();
        Err(Error::input(format!(
            "{what} is known from {low} to {high} nm, of which the cone {cone} of {} sees {:.1} % of white ({:.1} % are needed), and nothing is invented outside; give it from {from} to {to} nm or further",
            shortened(&self.eye.name),
            100.0 * part,
            100.0 * LEAST_SEEN
        )))
    }

    /// What each cone catches of a reflectance over what it catches of white: ∫ R I S dλ / ∫ I S dλ with I in quanta, over the
    /// reflectance's wavelengths, by the trapezoidal rule at whole nm and at the reflectance's own.
    ///
    /// # Errors
    /// As [`View::check`].
    pub fn catches(&self, reflectance: &Spectrum) -> Result<Catches> {
        let (low, high) = reflectance.wavelengths().range_nm();
        self.check("the reflectance", [low, high])?;
        let (low, high) = (low.max(SHORTEST_NM), high.min(LONGEST_NM));
        let whole = (low.ceil() as u32..=high.floor() as u32).map(f64::from);
        let own = reflectance.wavelengths().iter().copied().filter(|nm| (low..=high).contains(nm));
        let mut nodes: Vec<f64> = whole.chain(own).collect();
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        let reflected: Vec<f64> = nodes.iter().map(|nm| reflectance.held(*nm)).collect();
        let caught = |answers: &DenseSpectrum| {
            let at: Vec<f64> = nodes.iter().map(|nm| answers.at(*nm)).collect();
            let (mut sum, mut white) = (0.0, 0.0);
            for i in 1..nodes.len() {
                let half = 0.5 * (nodes[i] - nodes[i - 1]);
                sum += half * (at[i] * reflected[i] + at[i - 1] * reflected[i - 1]);
                white += half * (at[i] + at[i - 1]);
            }
            sum / white
        };
        let mut cones: Vec<f64> = self.seen.iter().map(caught).collect();
        let double = self.eye.double.as_ref().and_then(|_| cones.pop());
        Ok(Catches { cones, double })
    }
}

/// Integral from `low` to `high`, nm, of what is linear between whole nm.
fn within(spectrum: &DenseSpectrum, low: f64, high: f64) -> f64 {
    let (low, high) = (low.max(SHORTEST_NM), high.min(LONGEST_NM));
    if low >= high {
        return 0.0;
    }
    let mut sum = 0.0;
    let mut from = low;
    while from < high {
        let to = (from.floor() + 1.0).min(high);
        sum += 0.5 * (to - from) * (spectrum.at(from) + spectrum.at(to));
        from = to;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Wavelengths;

    const EYE: &str = "[[cones]]\nname = 'UV'\npigment_nm = 362\n[[cones]]\nname = 'L'\npigment_nm = 563\ndroplet = 'R'\ncut_nm = 572\n\
         [double]\npigment_nm = 563\ndroplet = 'P'\ncut_nm = 471\n";

    fn view(light: &str) -> View {
        View::new(Eye::parse(EYE, "a").unwrap(), Light::named(light).unwrap()).unwrap()
    }

    fn sampled(from: f64, to: f64, step: f64, value: impl Fn(f64) -> f64) -> Spectrum {
        let nm: Vec<f64> = (0..=((to - from) / step) as usize).map(|i| from + step * i as f64).collect();
        let values = nm.iter().map(|nm| value(*nm)).collect();
        Spectrum::new(Wavelengths::new(nm).unwrap(), values).unwrap()
    }

    #[test]
    fn white_is_one_and_grey_its_reflectance_whatever_the_light_and_the_samples() {
        for light in Light::NAMES.map(|(name, _)| name) {
            for step in [4.0, 7.3, 50.0] {
                let found = view(light).catches(&sampled(300.0, 701.0, step, |_| 0.3)).unwrap();
                for q in found.cones.into_iter().chain(found.double) {
                    assert!((q - 0.3).abs() < 1e-12, "{light} {step}: {q}");
                }
            }
        }
    }

    /// Gauss–Legendre quadrature of the formulas themselves, in pieces of 5 nm of three points each, for a smooth reflectance.
    #[test]
    fn catches_are_those_of_another_quadrature() {
        use crate::vision::{AVERAGE_HALF_NM, Droplet, ocular_media, pigment};
        let reflectance = |nm: f64| 0.4 + 0.3 * (nm / 23.0).sin();
        let cone = |k: usize, nm: f64| {
            let media = ocular_media(AVERAGE_HALF_NM, nm);
            media
                * match k {
                    0 => pigment(362.0, nm, false),
                    1 => pigment(563.0, nm, false) * Droplet::Red.transmittance(572.0, nm),
                    _ => pigment(563.0, nm, false) * Droplet::Pale.transmittance(471.0, nm),
                }
        };
        // Quanta of equal power.
        let integral = |f: &dyn Fn(f64) -> f64| -> f64 {
            (0..80)
                .map(|piece| {
                    let middle = 302.5 + 5.0 * f64::from(piece);
                    let node = 2.5 * 0.6_f64.sqrt();
                    2.5 / 9.0 * (5.0 * f(middle - node) + 8.0 * f(middle) + 5.0 * f(middle + node))
                })
                .sum()
        };
        let found = view("E").catches(&sampled(300.0, 700.0, 0.5, reflectance)).unwrap();
        for (k, q) in found.cones.into_iter().chain(found.double).enumerate() {
            let white = integral(&|nm| nm * cone(k, nm));
            let expected = integral(&|nm| nm * cone(k, nm) * reflectance(nm)) / white;
            assert!((q / expected - 1.0).abs() < 4e-5, "{k}: {q} {expected}");
        }
    }

    #[test]
    fn what_does_not_reach_into_the_ultraviolet_is_refused_with_what_to_do() {
        let message = view("D65").catches(&sampled(400.0, 694.0, 6.0, |_| 0.2)).unwrap_err().to_string();
        assert!(
            message.contains("the cone UV of a sees 9.") && message.contains("98.5 % are needed"),
            "{message}"
        );
        let [low, high] = view("D65").needed_nm();
        assert!((300.0..330.0).contains(&low) && (650.0..700.0).contains(&high), "{low} {high}");
        assert!(message.contains(&format!("from {low} to {high} nm")) && message.len() < 600);
        assert!(view("D65").check("it", [low, high]).is_ok());
        assert!(view("D65").check("it", [low + 1.0, high]).is_err());
        assert!(view("D65").check("it", [low, high - 1.0]).is_err());
    }

    #[test]
    fn lights_that_leave_a_cone_in_the_dark_are_refused() {
        let eye = || Eye::parse(EYE, "a").unwrap();
        let table = |from: f64| sampled(from, 700.0, 10.0, |nm| if nm < 450.0 { 0.0 } else { 1.0 });
        let light = |from| Light::of_table("lamp", &table(from), false).unwrap();
        let short = View::new(eye(), light(400.0)).unwrap_err().to_string();
        assert!(short.contains("known from 400 to 700 nm") && short.contains("UV"), "{short}");
        let dark = View::new(eye(), light(300.0));
        assert!(dark.is_ok(), "the tail of a pigment reaches everywhere");
    }
}
