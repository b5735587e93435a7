//! Effective indices of media mixed on a scale far below the wavelength.

use super::Material;
use crate::identity::{Hasher, Identify};
use crate::{Complex64, Error, Result};

/// Mixtures of mixtures go no deeper than this.
const DEEPEST: usize = 16;

/// How a mixture's index follows from those of its two media.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rule {
    /// The mean of the indices, (1−f)·n_a + f·n_b: the rule of the feather papers.
    #[default]
    Linear,
    /// Maxwell Garnett (1904): spheres of b in a.
    MaxwellGarnett,
    /// Bruggeman (1935): spheres of both in the mixture itself, symmetric in a and b.
    Bruggeman,
}

impl Rule {
    /// Every rule with its name in files and in the stack language.
    pub const ALL: [(&'static str, Self); 3] =
        [("linear", Self::Linear), ("maxwell-garnett", Self::MaxwellGarnett), ("bruggeman", Self::Bruggeman)];

    /// The rule of a name.
    ///
    /// # Errors
    /// No rule has that name.
    pub fn named(name: &str) -> Result<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, rule)| *rule).ok_or_else(|| {
            Error::input(format!(
                "there is no mixing rule '{}'; the rules are linear, maxwell-garnett and bruggeman",
                crate::error::shortened(name)
            ))
        })
    }

    /// The rule's name in files and in the stack language.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::MaxwellGarnett => "maxwell-garnett",
            Self::Bruggeman => "bruggeman",
        }
    }
}

/// Two media of which `fraction` of the volume is the second.
#[derive(Debug, Clone, PartialEq)]
pub struct Mixture {
    a: Material,
    b: Material,
    fraction: f64,
    rule: Rule,
    depth: usize,
}

impl Mixture {
    /// The same with both media's n higher by `by`.
    pub(super) fn with_higher_index(&self, by: f64) -> Result<Self> {
        Self::new(self.a.with_higher_index(by)?, self.b.with_higher_index(by)?, self.fraction, self.rule)
    }

    pub(super) fn new(a: Material, b: Material, fraction: f64, rule: Rule) -> Result<Self> {
        if !(0.0..=1.0).contains(&fraction) {
            return Err(Error::input(format!(
                "the mixing fraction {fraction} is outside 0 to 1; it is the part of the volume that is the second medium"
            )));
        }
        let depth_of = |m: &Material| if let Material::Mixture(inner) = m { inner.depth } else { 0 };
        let depth = 1 + depth_of(&a).max(depth_of(&b));
        if depth > DEEPEST {
            return Err(Error::input(format!("mixtures are nested more than {DEEPEST} deep")));
        }
        Ok(Self { a, b, fraction, rule, depth })
    }

    /// The medium that makes up 1 − fraction of the volume.
    #[must_use]
    pub fn a(&self) -> &Material {
        &self.a
    }

    /// The medium that makes up the fraction.
    #[must_use]
    pub fn b(&self) -> &Material {
        &self.b
    }

    /// The part of the volume that is the second medium, 0 to 1.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        self.fraction
    }

    /// How the index follows from those of the two media.
    #[must_use]
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// How deep mixtures are nested in it, itself included.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.depth
    }

    pub(super) fn is_constant(&self) -> bool {
        self.a.is_constant() && self.b.is_constant()
    }

    pub(super) fn index(&self, wavelength_nm: f64) -> Result<Complex64> {
        Ok(mixed(self.a.index(wavelength_nm)?, self.b.index(wavelength_nm)?, self.fraction, self.rule))
    }
}

impl Identify for Mixture {
    fn feed(&self, to: &mut Hasher) {
        let Self { a, b, fraction, rule, depth: _ } = self;
        to.part("a", a).part("b", b).number("fraction", *fraction).text("rule", rule.name());
    }
}

/// The index of a mixture from its parts'.
fn mixed(a: Complex64, b: Complex64, fraction: f64, rule: Rule) -> Complex64 {
    let f = fraction;
    // The formulas would spoil the last digits of a pure medium.
    if f == 0.0 || a == b {
        return a;
    }
    if f == 1.0 {
        return b;
    }
    let (eps_a, eps_b) = (a * a, b * b);
    match rule {
        Rule::Linear => a * (1.0 - f) + b * f,
        Rule::MaxwellGarnett => {
            let above = eps_b * (1.0 + 2.0 * f) + eps_a * (2.0 * (1.0 - f));
            let below = eps_b * (1.0 - f) + eps_a * (2.0 + f);
            absorbing_root(eps_a * above / below)
        }
        Rule::Bruggeman => {
            let [plus, minus] = bruggeman_roots(eps_a, eps_b, f);
            let tiny = 1e-14 * (plus.norm() + minus.norm());
            let physical = match (plus.im >= -tiny, minus.im >= -tiny) {
                (true, false) => plus,
                (false, true) => minus,
                _ => {
                    // Where neither absorbs it is the one that would if the media did a little.
                    let lossy = |eps: Complex64| eps + Complex64::I * (1e-6 * eps.norm());
                    let [with, without] = bruggeman_roots(lossy(eps_a), lossy(eps_b), f);
                    if with.im >= without.im { plus } else { minus }
                }
            };
            absorbing_root(physical)
        }
    }
}

/// The solutions ε of (1−f)(ε_a−ε)/(ε_a+2ε) + f(ε_b−ε)/(ε_b+2ε) = 0; the physical one absorbs.
fn bruggeman_roots(eps_a: Complex64, eps_b: Complex64, f: f64) -> [Complex64; 2] {
    // It is 2ε² − pε − ε_a ε_b = 0 with this p.
    let p = eps_a * (2.0 - 3.0 * f) + eps_b * (3.0 * f - 1.0);
    let root = (p * p + eps_a * eps_b * 8.0).sqrt();
    [(p + root) / 4.0, (p - root) / 4.0]
}

/// The square root with Re ≥ 0 and Im ≥ 0 of a permittivity whose Im may be below zero by rounding.
fn absorbing_root(eps: Complex64) -> Complex64 {
    Complex64::new(eps.re, if eps.im > 0.0 { eps.im } else { 0.0 }).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: [Rule; 3] = [Rule::Linear, Rule::MaxwellGarnett, Rule::Bruggeman];

    fn keratin_melanin(fraction: f64, rule: Rule) -> Complex64 {
        let mixture = Material::mixture(Material::keratin(), Material::melanin(), fraction, rule);
        mixture.unwrap().index(500.0).unwrap()
    }

    #[test]
    fn pure_media_are_kept_by_every_rule() {
        for rule in RULES {
            assert_eq!(keratin_melanin(0.0, rule), Material::keratin().index(500.0).unwrap());
            assert_eq!(keratin_melanin(1.0, rule), Material::melanin().index(500.0).unwrap());
        }
    }

    #[test]
    fn a_mixture_lies_between_its_media() {
        for rule in RULES {
            let low = Material::keratin().index(500.0).unwrap();
            let high = Material::melanin().index(500.0).unwrap();
            let index = keratin_melanin(0.4, rule);
            assert!(index.re > low.re && index.re < high.re, "{rule:?}: {index}");
            assert!(index.im > 0.0 && index.im < high.im, "{rule:?}: {index}");
        }
    }

    #[test]
    fn bruggeman_solves_its_equation_and_treats_both_media_alike() {
        let (a, b) = (Complex64::new(1.0, 0.0), Complex64::new(0.2, 3.0));
        for fraction in [0.1, 0.33, 0.5, 0.9] {
            let index = mixed(a, b, fraction, Rule::Bruggeman);
            let (eps, ea, eb) = (index * index, a * a, b * b);
            let rest =
                (ea - eps) / (ea + eps * 2.0) * (1.0 - fraction) + (eb - eps) / (eb + eps * 2.0) * fraction;
            assert!(rest.norm() < 1e-12, "{fraction}: {rest}");
            assert!(index.im >= 0.0);
            assert!((index - mixed(b, a, 1.0 - fraction, Rule::Bruggeman)).norm() < 1e-12);
        }
    }

    /// A metal without loss: both solutions are positive where there is little of it, and the mixture is that of a metal with a little.
    #[test]
    fn bruggeman_of_a_lossless_metal_is_the_limit_of_small_losses() {
        let (air, metal) = (Complex64::ONE, Complex64::new(0.0, 10_f64.sqrt()));
        let with_loss = Complex64::new(1e-7, 10_f64.sqrt());
        for fraction in [1e-6, 0.01, 0.05, 0.2, 0.5, 0.95, 1.0 - 1e-6] {
            let index = mixed(air, metal, fraction, Rule::Bruggeman);
            let limit = mixed(air, with_loss, fraction, Rule::Bruggeman);
            assert!((index - limit).norm() < 1e-5, "{fraction}: {index} {limit}");
            assert!((index - mixed(metal, air, 1.0 - fraction, Rule::Bruggeman)).norm() < 1e-9, "{fraction}");
        }
        assert!((mixed(air, metal, 1e-6, Rule::Bruggeman) - 1.0).norm() < 1e-5);
    }

    #[test]
    fn maxwell_garnett_is_bruggeman_to_first_order() {
        let (a, b) = (Complex64::new(1.0, 0.0), Complex64::new(1.6, 0.1));
        let mg = mixed(a, b, 1e-4, Rule::MaxwellGarnett);
        assert!((mg - mixed(a, b, 1e-4, Rule::Bruggeman)).norm() < 1e-7);
        let slope = (b * b - 1.0) / (b * b + 2.0) * 3.0;
        assert!((mg * mg - 1.0 - slope * 1e-4).norm() < 1e-7);
    }

    #[test]
    fn fractions_outside_0_to_1_are_refused() {
        for bad in [-0.1, 1.1, f64::NAN] {
            let error =
                Material::mixture(Material::air(), Material::keratin(), bad, Rule::Linear).unwrap_err();
            assert!(error.to_string().contains("outside 0 to 1"));
        }
    }
}
