//! Several things as one eye sees them, each beside each.

use crate::Result;
use crate::spectrum::Spectrum;

use super::{Catches, Noise, Reference, Tetrahedral, View, achromatic_difference};

/// Differences of each thing from each, `[thing][thing]`; none where they are not defined.
pub type Differences = Vec<Vec<Option<f64>>>;

/// What an eye makes of several things.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Of each thing the quanta that cones catch, over those of white.
    pub catches: Vec<Catches>,
    /// Of each thing its place in the tetrahedron; of eyes with four cones.
    pub tetrahedral: Vec<Option<Tetrahedral>>,
    /// ΔS in just noticeable differences where the eye's Weber fraction is that of the longest cones.
    pub delta_s: Differences,
    /// The same where it is that of the rarest cones.
    pub delta_s_rarest: Differences,
    /// ΔL in just noticeable differences by the double cones.
    pub delta_l: Differences,
}

impl View {
    /// Looks at reflectances.
    ///
    /// # Errors
    /// As [`View::catches`] of the first that is refused; its index is returned with it.
    pub fn compare(&self, things: &[Spectrum]) -> std::result::Result<Compared, (usize, crate::Error)> {
        let each = things.iter().enumerate();
        let catches: Vec<Catches> = each
            .map(|(i, thing)| self.catches(thing).map_err(|error| (i, error)))
            .collect::<std::result::Result<_, _>>()?;
        let differences = |of: &dyn Fn(&Catches, &Catches) -> Option<f64>| -> Differences {
            catches.iter().map(|one| catches.iter().map(|other| of(one, other)).collect()).collect()
        };
        let by = |reference| {
            let noise = Noise::of(&self.eye, reference);
            differences(&|one, other| noise.delta_s(one, other))
        };
        Ok(Compared {
            tetrahedral: catches.iter().map(Tetrahedral::of).collect(),
            delta_s: by(Reference::Longest),
            delta_s_rarest: by(Reference::Rarest),
            delta_l: differences(&|one, other| achromatic_difference(self.eye.weber_double, one, other)),
            catches,
        })
    }

    /// Looks at one reflectance.
    ///
    /// # Errors
    /// As [`View::catches`].
    pub fn look(&self, thing: &Spectrum) -> Result<(Catches, Option<Tetrahedral>)> {
        let catches = self.catches(thing)?;
        let place = Tetrahedral::of(&catches);
        Ok((catches, place))
    }
}
