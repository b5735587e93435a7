//! Strips of colour: of wavelengths, and of what is seen at each angle of incidence.

use barbule::Result;
use barbule::spectrum::colour::{display, matching, rgb_from_xyz};
use barbule::spectrum::look::Look;
use barbule::spectrum::peaks::Origin;

use super::sight::Sight;
use super::{Curves, Viewer};

/// The wavelengths that people see, nm, as strips show them.
const SEEN_NM: [f64; 2] = [390.0, 750.0];
/// What stands for wavelengths that nobody of the readers sees, linear.
const UNSEEN: f64 = 0.03;
/// Colours darker than this are lifted by it, so that a strip fades to its ends instead of ending at once.
const FADE: f64 = 0.35;

/// The colour of a wavelength on a screen, which has none of them: without what it would have to take away, and as bright as fits but for the
/// ends of what people see.
#[must_use]
pub fn spectral_srgb(nm: f64) -> [u8; 3] {
    if !(SEEN_NM[0]..=SEEN_NM[1]).contains(&nm) {
        return display([UNSEEN; 3]);
    }
    let linear = rgb_from_xyz(matching(nm)).map(|channel| channel.max(0.0));
    let most = linear.into_iter().fold(0.0, f64::max);
    display(linear.map(|channel| UNSEEN + (1.0 - UNSEEN) * channel / most.max(FADE)))
}

/// What is seen at one angle of incidence.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleSeen {
    /// The angle across the barbule, rad.
    pub angle: f64,
    /// Where its colour reaches, half-way to its neighbours, rad.
    pub reach: [f64; 2],
    /// What is seen.
    pub sight: Sight,
    /// The wavelength of the peak that is followed from angle to angle, nm; none where it is lost or there is none.
    pub peak_nm: Option<f64>,
}

/// What is seen at each angle of curves, from low to high angles.
///
/// # Errors
/// As [`Viewer::sees`].
pub fn along_angles(curves: &Curves, viewer: &Viewer) -> Result<Vec<AngleSeen>> {
    let mut order: Vec<usize> = (0..curves.angle.len()).collect();
    order.sort_by(|a, b| curves.angle[*a].total_cmp(&curves.angle[*b]));
    let spectra = order.iter().map(|row| curves.spectrum(*row)).collect::<Result<Vec<_>>>()?;
    let angles: Vec<f64> = order.iter().map(|row| curves.angle[*row]).collect();
    let degrees: Vec<f64> = angles.iter().map(|angle| angle.to_degrees()).collect();
    let looks = Look::series(&degrees, &spectra, Origin::Computed, None);
    let each = spectra.iter().zip(looks).zip(reaches(&angles)).zip(&angles);
    each.map(|(((spectrum, look), reach), angle)| {
        let sight = viewer.sees(spectrum)?;
        Ok(AngleSeen { angle: *angle, reach, sight, peak_nm: look.peak.map(|peak| peak.nm) })
    })
    .collect()
}

/// Where each of rising places reaches: half-way to its neighbours, at the ends as far outwards as inwards; a lone one half a degree
/// to either side.
#[must_use]
pub fn reaches(places: &[f64]) -> Vec<[f64; 2]> {
    let last = places.len().saturating_sub(1);
    let alone = 0.5_f64.to_radians();
    let half = |k: usize| 0.5 * (places[k + 1] - places[k]);
    let reach = |k: usize| {
        let below = if k > 0 {
            half(k - 1)
        } else if last > 0 {
            half(0)
        } else {
            alone
        };
        let above = if k < last { half(k) } else { below };
        [places[k] - below, places[k] + above]
    };
    (0..places.len()).map(reach).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::{FilmJob, film};
    use crate::state::Seer;
    use barbule::Unobserved;
    use barbule::material::Library;
    use barbule::stack::Stack;

    #[test]
    fn wavelengths_have_their_colours_and_fade_at_the_ends() {
        let [violet, green, red] = [440.0, 530.0, 640.0].map(spectral_srgb);
        assert!(violet[2] > violet[0].max(violet[1]) && violet[2] > 150, "{violet:?}");
        assert!(green[1] > green[0].max(green[2]) && green[1] > 200, "{green:?}");
        assert!(red[0] > red[1].max(red[2]) && red[0] > 200, "{red:?}");
        assert!(spectral_srgb(745.0)[0] < 90 && spectral_srgb(320.0) == spectral_srgb(800.0));
        let [r, g, b] = spectral_srgb(320.0);
        assert!(r == g && g == b, "nobody's colour is grey");
    }

    #[test]
    fn places_reach_half_way_to_their_neighbours() {
        assert_eq!(reaches(&[0.0, 1.0, 3.0]), [[-0.5, 0.5], [0.5, 2.0], [2.0, 4.0]]);
        let alone = reaches(&[1.0])[0];
        assert!((alone[1] - alone[0] - 1_f64.to_radians()).abs() < 1e-12);
        assert!(reaches(&[]).is_empty());
    }

    /// A film's peak moves to short wavelengths as light comes from the side, and its colours are those of its rows.
    #[test]
    fn colours_follow_the_angles() {
        let viewer = Viewer::new(&Seer::People).unwrap();
        let angle = [40.0_f64, 0.0, 60.0].map(f64::to_radians).to_vec();
        let stack = Stack::parse("air/6*(melanin:99/keratin:100)/keratin", &Library::builtin()).unwrap();
        let job = FilmJob { stack, at: viewer.wavelengths().clone(), angle, individuals: 1, seed: 1 };
        let curves = film(&job, &Unobserved).unwrap();
        let seen = along_angles(&curves, &viewer).unwrap();
        let angles: Vec<f64> = seen.iter().map(|one| one.angle.to_degrees().round()).collect();
        assert_eq!(angles, [0.0, 40.0, 60.0]);
        let peaks: Vec<f64> = seen.iter().map(|one| one.peak_nm.unwrap()).collect();
        assert!(peaks[0] > peaks[1] + 10.0, "{peaks:?}");
        assert_eq!(seen[0].sight, viewer.sees(&curves.spectrum(1).unwrap()).unwrap());
    }
}
