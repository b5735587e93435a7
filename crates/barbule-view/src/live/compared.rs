//! What is open against what is pinned, in numbers.

use barbule::spectrum::Spectrum;
use barbule::spectrum::comparison::Comparison;
use barbule::{Error, Result};

use super::Viewer;

/// How one reflectance differs from another.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// CIEDE2000 between their colours in daylight, as people see them; none where too little of them is known.
    pub delta_e_2000: Option<f64>,
    /// By how much the peak that both have lies at longer wavelengths, nm; none where they have none in common.
    pub peak_shift_nm: Option<f64>,
    /// Its luminous reflectance over the other's; none where either has no colour or the other is black.
    pub brightness: Option<f64>,
    /// How far a bird tells their colours apart, in just noticeable differences; none for people.
    pub bird: Option<Told>,
}

/// How far a bird tells two reflectances apart.
#[derive(Debug, Clone, PartialEq)]
pub enum Told {
    /// ΔS by their colours and, where its eye has double cones, ΔL by their brightness, in just noticeable differences.
    Jnd {
        /// ΔS; none where a cone catches nothing.
        delta_s: Option<f64>,
        /// ΔL.
        delta_l: Option<f64>,
    },
    /// Why that cannot be said.
    Unknown(String),
}

impl Compared {
    /// How a reflectance differs from another, as somebody sees them.
    ///
    /// # Errors
    /// They have fewer than two wavelengths in common.
    pub fn of(own: &Spectrum, other: &Spectrum, viewer: &Viewer) -> Result<Self> {
        let found = Comparison::of(own, other, None).map_err(|_| {
            let [own, other] = [own, other].map(|one| one.wavelengths().range_nm());
            Error::input(format!(
                "{} to {} nm and {} to {} nm have no wavelengths in common, so nothing can be compared",
                own.0, own.1, other.0, other.1
            ))
        })?;
        let luminous = |look: &barbule::spectrum::look::Look| look.colour.map(|colour| colour.xyz[1]);
        let brightness = luminous(&found.simulated)
            .zip(luminous(&found.measured).filter(|other| *other > 0.0))
            .map(|(own, other)| own / other);
        Ok(Self {
            delta_e_2000: found.delta_e_2000,
            peak_shift_nm: found.peak_shift_nm(),
            brightness,
            bird: viewer.tells(own, other),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Seer;
    use barbule::spectrum::Wavelengths;
    use barbule::spectrum::look::Look;

    fn bump(at: &Wavelengths, middle: f64, height: f64) -> Spectrum {
        let value = |nm: &f64| 0.05 + height * (-(nm - middle).powi(2) / 3000.0).exp();
        Spectrum::new(at.clone(), at.iter().map(value).collect()).unwrap()
    }

    #[test]
    fn the_numbers_are_those_of_the_library() {
        let people = Viewer::new(&Seer::People).unwrap();
        let at = people.wavelengths();
        let (own, other) = (bump(at, 560.0, 0.6), bump(at, 540.0, 0.5));
        let compared = Compared::of(&own, &other, &people).unwrap();
        assert!((compared.peak_shift_nm.unwrap() - 20.0).abs() < 2.0, "{compared:?}");
        let luminous = |s: &Spectrum| Look::of(s).colour.unwrap().xyz[1];
        assert!((compared.brightness.unwrap() - luminous(&own) / luminous(&other)).abs() < 1e-3);
        assert!(compared.delta_e_2000.unwrap() > 5.0 && compared.bird.is_none());
        let same = Compared::of(&own, &own, &people).unwrap();
        assert!(same.delta_e_2000.unwrap() < 1e-9 && (same.brightness.unwrap() - 1.0).abs() < 1e-12);
        let far = Wavelengths::new([900.0, 950.0]).unwrap();
        let refused = Compared::of(&own, &Spectrum::new(far, vec![0.1; 2]).unwrap(), &people).unwrap_err();
        assert!(refused.to_string().contains("no wavelengths in common"), "{refused}");
    }

    #[test]
    fn birds_tell_colours_apart_where_they_see_them() {
        let bird = Viewer::new(&Seer::Bird("starling".into())).unwrap();
        let at = bird.wavelengths().clone();
        let (own, other) = (bump(&at, 560.0, 0.6), bump(&at, 540.0, 0.6));
        let told = Compared::of(&own, &other, &bird).unwrap().bird.unwrap();
        assert!(matches!(told, Told::Jnd { delta_s: Some(s), .. } if s > 1.0), "{told:?}");
        let told = Compared::of(&own, &own, &bird).unwrap().bird.unwrap();
        assert!(matches!(told, Told::Jnd { delta_s: Some(s), .. } if s < 1e-9), "{told:?}");
        let visible = bump(&Wavelengths::usual(), 550.0, 0.5);
        let told = Compared::of(&visible, &visible, &bird).unwrap().bird.unwrap();
        assert!(
            matches!(&told, Told::Unknown(why) if why.contains("nothing is invented outside")),
            "{told:?}"
        );
    }
}
