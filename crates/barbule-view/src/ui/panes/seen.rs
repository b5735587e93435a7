//! What is seen of the reflectances that have been computed: their numbers, and their colours to people and to a bird.

use barbule::spectrum::Spectrum;
use barbule::spectrum::look::Look;
use eframe::egui::Ui;

use super::style;
use super::words::percent;
use super::{Memory, Once};
use crate::live::{Curves, Known, Results, Sight, Viewer};
use crate::state::{Seer, State};

/// Who sees, or why they cannot.
pub(super) type Eyes = Once<Seer, Result<Viewer, String>>;
/// What was seen last of one of the two.
pub(super) type Kept = Once<(Curves, usize, Seer), Option<Seen>>;

/// What is seen of a reflectance at the angle that is looked at.
pub(super) struct Seen {
    /// Angle of incidence, rad.
    pub(super) angle: f64,
    /// The reflectance.
    pub(super) spectrum: Spectrum,
    /// Its standard deviation between individuals, at its wavelengths.
    pub(super) deviation: Option<Vec<f64>>,
    /// Its numbers.
    pub(super) look: Look,
    /// What is seen, or why a bird cannot say.
    pub(super) sight: Result<Sight, String>,
}

impl Seen {
    fn of(curves: &Curves, row: usize, viewer: &Viewer) -> Option<Self> {
        let spectrum = curves.spectrum(row).ok()?;
        let look = Look::of(&spectrum);
        let sight = viewer.sees(&spectrum).map_err(|error| error.to_string());
        let deviation = curves.deviation(row).map(<[f64]>::to_vec);
        Some(Self { angle: curves.angle[row], spectrum, deviation, look, sight })
    }

    /// Peak and half width in words.
    pub(super) fn words(&self) -> String {
        match self.look.peak {
            Some(peak) => {
                let half = match peak.half.nm() {
                    Some(nm) => format!("half width {nm:.0} nm"),
                    None => peak.half.words(),
                };
                format!("peak {:.0} nm, {}; {half}", peak.nm, percent(peak.reflectance))
            }
            None => format!("no peak; highest at {:.0} nm", self.look.hue_nm),
        }
    }
}

/// The viewer of this state; the error's sentence where there is none.
pub(super) fn viewer<'a>(eyes: &'a mut Eyes, state: &State) -> Result<&'a Viewer, String> {
    let made = eyes.of(&state.view().eye, |seer| Viewer::new(seer).map_err(|error| error.to_string()));
    made.as_ref().map_err(Clone::clone)
}

/// What is seen of what is open and of what is pinned, as far as it is there.
pub(super) fn both<'a>(memory: &'a mut Memory, state: &State, results: &Results) -> [Option<&'a Seen>; 2] {
    let Memory { viewer: eyes, seen, .. } = memory;
    let Ok(viewer) = viewer(eyes, state) else { return [None, None] };
    let pinned = state.pinned().is_some().then_some(&results.pinned);
    let [first, second] = seen;
    [of(first, state, Some(&results.own), viewer), of(second, state, pinned, viewer)]
}

fn of<'a>(kept: &'a mut Kept, state: &State, of: Option<&Known>, viewer: &Viewer) -> Option<&'a Seen> {
    let curves = of?.curves.as_ref()?;
    let row = curves.nearest(state.view().angle_deg.to_radians());
    let key = (curves.clone(), row, state.view().eye.clone());
    kept.of(&key, |(curves, row, _)| Seen::of(curves, *row, viewer)).as_ref()
}

/// What is seen, as patches of colour: to people, and to the bird that is chosen.
pub(super) fn swatches(ui: &mut Ui, sight: &Result<Sight, String>, state: &State, whose: &str) {
    match sight {
        Ok(sight) => {
            style::swatch(ui, sight.srgb, &format!("{whose} as people see it"));
            if let (Some(srgb), Seer::Bird(bird)) = (sight.bird_srgb, &state.view().eye) {
                style::swatch(ui, srgb, &format!("{whose} as the {bird} sees it, in false colours"));
            }
        }
        Err(why) => style::not_there(ui, why),
    }
}

/// The cones' catches in words, as in `UV 0.12, S 0.4`; none for people.
pub(super) fn catches(sight: &Sight, viewer: &Viewer) -> Option<String> {
    let caught = sight.catches.as_ref()?;
    let each = viewer.cones().into_iter().zip(&caught.cones);
    Some(each.map(|(cone, caught)| format!("{cone} {caught:.2}")).collect::<Vec<_>>().join(", "))
}
