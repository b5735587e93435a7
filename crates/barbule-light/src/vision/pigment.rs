//! Templates of what cones are made of.

use crate::{Error, Result};

/// Where the average ocular media let half of the light pass, nm.
pub const AVERAGE_HALF_NM: f64 = 335.0;

/// Absorbance of a visual pigment with retinal (A1) over its maximum, by its wavelength of maximum absorbance and the wavelength,
/// both nm (Govardovskii et al. 2000, *Visual Neuroscience* 17, 509, equations 1, 2, 4 and 5). With `beta` the band in the ultraviolet
/// is added, and the sum may lie above 1.
#[must_use]
pub fn pigment(maximum_nm: f64, nm: f64, beta: bool) -> f64 {
    let square = |x: f64| x * x;
    let x = maximum_nm / nm;
    let a = 0.8795 + 0.0459 * libm::exp(-square(maximum_nm - 300.0) / 11_940.0);
    let alpha = 1.0
        / (libm::exp(69.7 * (a - x))
            + libm::exp(28.0 * (0.922 - x))
            + libm::exp(-14.9 * (1.104 - x))
            + 0.674);
    if !beta {
        return alpha;
    }
    let (middle, width) = (189.0 + 0.315 * maximum_nm, -40.5 + 0.195 * maximum_nm);
    alpha + 0.26 * libm::exp(-square((nm - middle) / width))
}

/// The oil droplet before a cone's pigment, by the letters of Hart (2001, *Prog. Retin. Eye Res.* 20, 675).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Droplet {
    /// T: absorbs nothing that the eye lets in.
    Transparent,
    /// C: colourless to people, of cones for short wavelengths.
    Colourless,
    /// Y: yellow, of cones for middle wavelengths.
    Yellow,
    /// R: red, of cones for long wavelengths.
    Red,
    /// P: pale, of the principal members of double cones.
    Pale,
}

impl Droplet {
    /// The droplet of a letter.
    ///
    /// # Errors
    /// None has it.
    pub fn of_letter(letter: &str) -> Result<Self> {
        match letter {
            "T" => Ok(Self::Transparent),
            "C" => Ok(Self::Colourless),
            "Y" => Ok(Self::Yellow),
            "R" => Ok(Self::Red),
            "P" => Ok(Self::Pale),
            other => Err(Error::input(format!(
                "is '{}', but must be T (transparent), C (colourless), Y (yellow), R (red) or P (pale)",
                crate::error::shortened(other)
            ))),
        }
    }

    /// The part of the light that it lets pass at a wavelength, by its cut-off; both nm. The slope follows from the cut-off (Hart &
    /// Vorobyev 2005, *J. Comp. Physiol. A* 191, 381).
    #[must_use]
    pub fn transmittance(self, cut_nm: f64, nm: f64) -> f64 {
        // λ_mid = a λ_cut + b, where half of the light passes.
        let (a, b) = match self {
            Self::Transparent => return 1.0,
            Self::Colourless => (0.99, 24.38),
            Self::Yellow => (0.90, 70.03),
            Self::Red => (0.99, 28.65),
            Self::Pale => (0.96, 33.57),
        };
        let slope = 0.5 / (a * cut_nm + b - cut_nm);
        libm::exp(-libm::exp(-2.89 * slope * (nm - cut_nm) + 1.08))
    }
}

/// The part of the light that cornea, lens and vitreous body let pass at a wavelength, nm: the average over birds (Hart & Vorobyev
/// 2005), moved along the wavelengths so that half passes at `half_nm` ([`AVERAGE_HALF_NM`]: the average itself).
#[must_use]
pub fn ocular_media(half_nm: f64, nm: f64) -> f64 {
    let x = nm - (half_nm - AVERAGE_HALF_NM);
    // The polynomial was fitted up to 700 nm, where it is 1.016, and falls to 0 at 300.
    if x >= 700.0 {
        return 1.0;
    }
    if x <= 300.0 {
        return 0.0;
    }
    let polynomial = ((((8.928e-13 * x - 2.595e-9) * x + 3.006e-6) * x - 0.001_736) * x + 0.5013) * x - 55.56;
    if polynomial <= 1.0 { 0.0 } else { libm::log(polynomial).min(1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of a second program (NumPy) of the same formulas, to 12 digits.
    #[test]
    fn templates_are_those_of_another_program() {
        for (found, expected) in [
            (pigment(563.0, 563.0, false), PIGMENT[0]),
            (pigment(563.0, 480.0, false), PIGMENT[1]),
            (pigment(362.0, 400.0, false), PIGMENT[2]),
            (pigment(563.0, 360.0, true), PIGMENT[3]),
            (Droplet::Colourless.transmittance(413.0, 430.0), DROPLETS[0]),
            (Droplet::Yellow.transmittance(507.0, 520.0), DROPLETS[1]),
            (Droplet::Red.transmittance(572.0, 600.0), DROPLETS[2]),
            (Droplet::Pale.transmittance(471.0, 490.0), DROPLETS[3]),
            (ocular_media(AVERAGE_HALF_NM, 350.0), MEDIA[0]),
            (ocular_media(AVERAGE_HALF_NM, 550.0), MEDIA[1]),
        ] {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    const PIGMENT: [f64; 4] = [1.000850232077, 0.288419794864, 0.246709774115, 0.258884829937];
    const DROPLETS: [f64; 4] = [0.416699709416, 0.328156560164, 0.603902808069, 0.633415061444];
    const MEDIA: [f64; 2] = [0.623359841782, 0.960407229554];

    #[test]
    fn pigments_peak_where_they_are_said_to() {
        for maximum in [355.0, 424.0, 500.0, 571.0] {
            let top = (3000..8000).map(|tenth| f64::from(tenth) / 10.0);
            let top = top.max_by(|a, b| pigment(maximum, *a, false).total_cmp(&pigment(maximum, *b, false)));
            assert!((top.unwrap() - maximum).abs() < 1.5, "{maximum} {top:?}");
            assert!((pigment(maximum, maximum, false) - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn droplets_pass_half_at_their_middle_and_little_at_their_cut_off() {
        // λ_cut is where the tangent at half the absorptance meets the whole of it: exp(−e^1.08) of the light passes there.
        for (droplet, cut, middle) in [
            (Droplet::Colourless, 413.0, 0.99 * 413.0 + 24.38),
            (Droplet::Yellow, 507.0, 0.9 * 507.0 + 70.03),
            (Droplet::Red, 572.0, 0.99 * 572.0 + 28.65),
            (Droplet::Pale, 460.0, 0.96 * 460.0 + 33.57),
        ] {
            assert!((droplet.transmittance(cut, middle) - 0.5).abs() < 1e-3);
            assert!((droplet.transmittance(cut, cut) - (-1.08_f64.exp()).exp()).abs() < 1e-12);
        }
        assert_eq!(Droplet::Transparent.transmittance(0.0, 310.0), 1.0);
        assert!(Droplet::of_letter("Q").unwrap_err().to_string().contains("T (transparent)"));
    }

    #[test]
    fn media_pass_half_where_they_are_said_to_and_never_more_than_all() {
        for half in [316.0, AVERAGE_HALF_NM, 365.0] {
            assert!((ocular_media(half, half) - 0.5).abs() < 1e-3);
            let passed: Vec<f64> = (300..831).map(|nm| ocular_media(half, f64::from(nm))).collect();
            assert!(passed.windows(2).all(|pair| pair[1] >= pair[0] - 1e-9));
            assert!(passed.iter().all(|part| (0.0..=1.0).contains(part)) && passed[530] == 1.0);
        }
    }
}
