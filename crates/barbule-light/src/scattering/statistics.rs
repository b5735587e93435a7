//! What a campaign keeps of its fields: the narrow waist between wave simulation and BRDF.

use num_complex::Complex;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::spectrum::Wavelengths;
use crate::{Error, Result};

/// Outgoing azimuths on which U and V are tabulated: (n + ½)·180°/400 − 90°.
pub const AZIMUTHS: usize = 400;

/// Points of the noise process over x ∈ (−1, 1); lags are multiples of 2/NOISE_POINTS (S.44).
pub const NOISE_POINTS: usize = 1024;

/// Lags 0 … LAGS − 1 of the autocovariance that are kept.
pub const LAGS: usize = NOISE_POINTS / 2;

/// Azimuths at which the intensities of all instances are kept, in steps of [`AZIMUTHS`] from the one nearest to the mirror
/// direction: it, 4° and 12° to both sides.
pub const GLINTS: [i32; 5] = [0, -9, 9, -27, 27];

/// Numbers of the azimuths of [`GLINTS`] for light from φ_i (rad); `None` beyond the horizon.
#[must_use]
pub fn glints(phi_i: f64) -> [Option<usize>; GLINTS.len()] {
    let step = std::f64::consts::PI / AZIMUTHS as f64;
    let mirror = ((std::f64::consts::FRAC_PI_2 - phi_i) / step - 0.5).round() as i32;
    GLINTS.map(|offset| {
        usize::try_from(mirror.clamp(0, AZIMUTHS as i32 - 1) + offset).ok().filter(|at| *at < AZIMUTHS)
    })
}

/// Which signs of φ_i the arrays of a campaign hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sides {
    /// φ_i ≥ 0 alone: light from the other side is the mirror image.
    #[default]
    Alike,
    /// Both: first φ_i ≥ 0, then φ_i < 0, each in the order of cosφ_i.
    Both,
}

/// The axes shared by every array of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "GivenAxes", into = "GivenAxes")]
pub struct Axes {
    wavelengths: Wavelengths,
    cos_theta: Vec<f64>,
    cos_phi: Vec<f64>,
    sides: Sides,
}

/// Axes as they are written, not checked.
#[derive(Serialize, Deserialize)]
struct GivenAxes {
    wavelengths_nm: Vec<f64>,
    cos_theta_i: Vec<f64>,
    cos_phi_i: Vec<f64>,
    #[serde(default)]
    sides: Sides,
}

impl TryFrom<GivenAxes> for Axes {
    type Error = Error;

    fn try_from(given: GivenAxes) -> Result<Self> {
        let wavelengths = Wavelengths::new(given.wavelengths_nm)?;
        Ok(Self::new(&wavelengths, given.cos_theta_i, given.cos_phi_i)?.with_sides(given.sides))
    }
}

impl From<Axes> for GivenAxes {
    fn from(axes: Axes) -> Self {
        let Axes { wavelengths, cos_theta: cos_theta_i, cos_phi: cos_phi_i, sides } = axes;
        Self { wavelengths_nm: wavelengths.to_vec(), cos_theta_i, cos_phi_i, sides }
    }
}

/// A unit of a campaign's work by its numbers on the axes: all φ_i, polarizations and instances of one (λ, θ_i).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Unit {
    /// Number of the wavelength.
    pub wavelength: usize,
    /// Number of θ_i.
    pub theta: usize,
}

/// cosφ_i above this is light across the barbule's normal plane, which has no other side.
const NORMAL: f64 = 1.0 - 1e-12;

impl Axes {
    /// Vacuum wavelengths, and the cosines of θ_i and of φ_i ≥ 0 of the simulated directions.
    ///
    /// # Errors
    /// Cosines that do not rise or do not lie in (0, 1], or none.
    pub fn new(wavelengths: &Wavelengths, cos_theta: Vec<f64>, cos_phi: Vec<f64>) -> Result<Self> {
        for (name, values) in [("cosθ_i", &cos_theta), ("cosφ_i", &cos_phi)] {
            if values.is_empty() {
                return Err(Error::input(format!("the axis {name} is empty; give one or more cosines")));
            }
            if let Some(bad) = values.iter().find(|c| !(**c > 0.0 && **c <= 1.0)) {
                return Err(Error::input(format!("{name} {bad} is not in (0, 1]")));
            }
            if let Some(pair) = values.windows(2).find(|pair| pair[1] <= pair[0]) {
                return Err(Error::input(format!(
                    "{name} {} follows {}; cosines must rise",
                    pair[1], pair[0]
                )));
            }
        }
        Ok(Self { wavelengths: wavelengths.clone(), cos_theta, cos_phi, sides: Sides::Alike })
    }

    /// The same with these signs of φ_i.
    #[must_use]
    pub fn with_sides(self, sides: Sides) -> Self {
        Self { sides, ..self }
    }

    /// Which signs of φ_i there are.
    #[must_use]
    pub fn sides(&self) -> Sides {
        self.sides
    }

    /// Number of φ_i: of each cosφ_i one, or two of different sign where both sides are simulated and cosφ_i < 1.
    #[must_use]
    pub fn phis(&self) -> usize {
        let cosines = self.cos_phi.len();
        match self.sides {
            Sides::Alike => cosines,
            Sides::Both => cosines + self.cos_phi.iter().filter(|c| **c < NORMAL).count(),
        }
    }

    /// Which cosφ_i the φ_i number `phi` has.
    #[must_use]
    pub fn cosine_of(&self, phi: usize) -> usize {
        // Only the last cosine can be 1, so the negative ones are a beginning of the list.
        if phi < self.cos_phi.len() { phi } else { phi - self.cos_phi.len() }
    }

    /// Vacuum wavelengths, nm, rising.
    #[must_use]
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths
    }

    /// cosθ_i of the simulated directions, rising, in (0, 1].
    #[must_use]
    pub fn cos_theta(&self) -> &[f64] {
        &self.cos_theta
    }

    /// cosφ_i of the simulated directions, rising, in (0, 1].
    #[must_use]
    pub fn cos_phi(&self) -> &[f64] {
        &self.cos_phi
    }

    /// Number of (λ, θ_i, φ_i) triples, at least 1.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.wavelengths.len() * self.cos_theta.len() * self.phis()
    }

    /// All units of work, λ slowest.
    pub fn units(&self) -> impl Iterator<Item = Unit> + use<> {
        let (wavelengths, thetas) = (self.wavelengths.len(), self.cos_theta.len());
        (0..wavelengths).flat_map(move |wavelength| (0..thetas).map(move |theta| Unit { wavelength, theta }))
    }

    /// The units of shard `shard` of `shards`: neighbours, so that those of one wavelength mostly fall together.
    #[must_use]
    pub fn shard(&self, shard: usize, shards: usize) -> Vec<Unit> {
        let count = self.wavelengths.len() * self.cos_theta.len();
        let bound = |shard: usize| count * shard / shards.max(1);
        self.units().skip(bound(shard)).take(bound(shard + 1) - bound(shard)).collect()
    }

    /// θ_i number `theta`, rad, 0 to π/2.
    #[must_use]
    pub fn theta_i(&self, theta: usize) -> f64 {
        angle(self.cos_theta[theta])
    }

    /// φ_i number `phi`, rad, −π/2 to π/2.
    #[must_use]
    pub fn phi_i(&self, phi: usize) -> f64 {
        let size = angle(self.cos_phi[self.cosine_of(phi)]);
        if phi < self.cos_phi.len() { size } else { -size }
    }

    /// Position of a triple in arrays of shape `[λ, θ_i, φ_i]`.
    #[must_use]
    pub fn index(&self, wavelength: usize, theta: usize, phi: usize) -> usize {
        (wavelength * self.cos_theta.len() + theta) * self.phis() + phi
    }
}

fn angle(cosine: f64) -> f64 {
    cosine.clamp(0.0, 1.0).acos()
}

/// The statistics of one campaign. All arrays are row-major.
///
/// Index of polarization 0 means the page's polarization 1 (E along e₁), 1 means polarization 2. Values that are undefined
/// where nothing is reflected are NaN, which JSON does not have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Statistics {
    /// Wavelengths and directions.
    pub axes: Axes,
    /// Number of instances M.
    pub instances: usize,
    /// Places across the barbules at which instances were lit in turn; V, contrasts and glints are about the mean of each place.
    #[serde(default = "one")]
    pub places: usize,
    /// U of S.12, rad⁻¹. Shape `[λ, θ_i, φ_i, polarization, AZIMUTHS]`.
    pub u: Vec<f32>,
    /// V of S.21 without its bias, not clipped, so values may be slightly negative. Shape of `u`.
    pub v: Vec<f32>,
    /// Autocovariance of the weighted field (S.29, S.30), mean over instances and over real and imaginary parts, in
    /// units of its own. Shape `[λ, θ_i, φ_i, polarization, LAGS]`, lag k ↔ Δx = 2k/NOISE_POINTS.
    pub autocovariance: Vec<f32>,
    /// Reflected fraction Φ_r/Φ_i, mean over instances. Shape `[λ, θ_i, φ_i, polarization]`.
    pub reflected: Vec<f64>,
    /// Standard deviation of the reflected fraction over instances. Shape of `reflected`.
    pub reflected_std: Vec<f64>,
    /// Correlation over instances and azimuths of the two polarizations' intensity patterns, each divided by its
    /// mean. Shape `[λ, θ_i, φ_i]`.
    pub pattern_correlation: Vec<f64>,
    /// Contrast (standard deviation over mean, weighted by the mean intensity over azimuths) of the unpolarized
    /// intensity over instances. Shape `[λ, θ_i, φ_i]`.
    pub unpolarized_contrast: Vec<f64>,
    /// Contrast of each polarization's intensity over instances at each azimuth, 0 where nothing is reflected. Shape of
    /// `u`.
    pub contrast: Vec<f32>,
    /// Unpolarized intensity of every instance at the azimuths of [`GLINTS`], rad⁻¹; 0 beyond the horizon. Of several places: the
    /// mean of all, and beside it the instance's departure from its own place's, with the contrast of all. Shape
    /// `[λ, θ_i, φ_i, GLINTS, instance]`; a fit can do without.
    pub glints: Vec<f32>,
}

impl Statistics {
    /// No unit yet; [`Self::append`] adds them in the order of the axes.
    #[must_use]
    pub fn empty(axes: Axes, instances: usize) -> Self {
        Self {
            axes,
            instances,
            places: 1,
            u: Vec::new(),
            v: Vec::new(),
            autocovariance: Vec::new(),
            reflected: Vec::new(),
            reflected_std: Vec::new(),
            pattern_correlation: Vec::new(),
            unpolarized_contrast: Vec::new(),
            contrast: Vec::new(),
            glints: Vec::new(),
        }
    }

    /// The same of instances that were lit at so many places in turn.
    #[must_use]
    pub fn with_places(self, places: usize) -> Self {
        Self { places: places.max(1), ..self }
    }

    /// Instances of one place, as many as contrasts are told from.
    #[must_use]
    pub fn instances_of_a_place(&self) -> usize {
        self.instances / self.places.max(1)
    }

    /// Adds the next unit, λ slowest, then θ_i.
    pub fn append(&mut self, unit: UnitStatistics) {
        self.u.extend(unit.u);
        self.v.extend(unit.v);
        self.autocovariance.extend(unit.autocovariance);
        self.reflected.extend(unit.reflected);
        self.reflected_std.extend(unit.reflected_std);
        self.pattern_correlation.extend(unit.pattern_correlation);
        self.unpolarized_contrast.extend(unit.unpolarized_contrast);
        self.contrast.extend(unit.contrast);
        self.glints.extend(unit.glints);
    }
}

fn one() -> usize {
    1
}

/// Values of all arrays at each (λ, θ_i, φ_i), in the order of the fields from `u` on.
const fn values(instances: usize) -> [usize; 9] {
    [2 * AZIMUTHS, 2 * AZIMUTHS, 2 * LAGS, 2, 2, 1, 1, 2 * AZIMUTHS, GLINTS.len() * instances]
}

/// More than any campaign has; what reads as more is damaged.
const MOST_INSTANCES: usize = 1 << 20;

impl Serialize for Statistics {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        Self::serialize(self, to)
    }
}

impl<'a> Deserialize<'a> for Statistics {
    fn deserialize<D: Deserializer<'a>>(from: D) -> std::result::Result<Self, D::Error> {
        let found = Self::deserialize(from)?;
        let lengths = [
            found.u.len(),
            found.v.len(),
            found.autocovariance.len(),
            found.reflected.len(),
            found.reflected_std.len(),
            found.pattern_correlation.len(),
            found.unpolarized_contrast.len(),
            found.contrast.len(),
            found.glints.len(),
        ];
        let expected = values(found.instances.min(MOST_INSTANCES));
        if lengths != expected.map(|values| values * found.axes.len()) {
            return Err(D::Error::custom("arrays of statistics have other lengths than their axes say"));
        }
        Ok(found)
    }
}

/// The statistics of one [`Unit`]: rows of the arrays of [`Statistics`] from the axis φ_i on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct UnitStatistics {
    /// Shape `[φ_i, polarization, AZIMUTHS]`.
    pub u: Vec<f32>,
    /// Shape `[φ_i, polarization, AZIMUTHS]`.
    pub v: Vec<f32>,
    /// Shape `[φ_i, polarization, LAGS]`.
    pub autocovariance: Vec<f32>,
    /// Shape `[φ_i, polarization]`.
    pub reflected: Vec<f64>,
    /// Shape `[φ_i, polarization]`.
    pub reflected_std: Vec<f64>,
    /// Shape `[φ_i]`.
    pub pattern_correlation: Vec<f64>,
    /// Shape `[φ_i]`.
    pub unpolarized_contrast: Vec<f64>,
    /// Shape `[φ_i, polarization, AZIMUTHS]`.
    pub contrast: Vec<f32>,
    /// Shape `[φ_i, GLINTS, instance]`.
    pub glints: Vec<f32>,
    /// Fields over √Φ_i where they are kept, else empty. Shape `[φ_i, polarization, e₁ e₂, instance, AZIMUTHS]`.
    #[serde(with = "pairs")]
    pub fields: Vec<Complex<f32>>,
}

impl UnitStatistics {
    /// Whether its arrays are as long as those of a unit of these axes and so many instances.
    #[must_use]
    pub fn is_of(&self, axes: &Axes, instances: usize) -> bool {
        let lengths = [
            self.u.len(),
            self.v.len(),
            self.autocovariance.len(),
            self.reflected.len(),
            self.reflected_std.len(),
            self.pattern_correlation.len(),
            self.unpolarized_contrast.len(),
            self.contrast.len(),
            self.glints.len(),
        ];
        lengths == values(instances).map(|values| values * axes.phis())
    }
}

/// Complex numbers as pairs of their parts.
mod pairs {
    use num_complex::Complex;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(values: &[Complex<f32>], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(values.iter().map(|value| [value.re, value.im]))
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<Vec<Complex<f32>>, D::Error> {
        let pairs = Vec::<[f32; 2]>::deserialize(from)?;
        Ok(pairs.into_iter().map(|[re, im]| Complex { re, im }).collect())
    }
}
