//! Who sees a film, and what it keeps beside what is seen, normals and depth, where it is asked to: what compositors and
//! spectroscopists use.

use super::integrator::{FirstHit, Sample};
use crate::spectrum::dense::WAVES;
use crate::spectrum::sensor::{Band, Sensor};
use crate::{Error, Result};

/// One channel of a picture, with its name in an EXR.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel<T> {
    /// Name, as in `normal.X`.
    pub name: String,
    /// Values, row by row.
    pub values: Vec<T>,
}

/// The planes of a film.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Planes {
    /// Who sees it: its first planes are the channels of this sensor.
    pub sensor: Sensor,
    /// Whether pixels keep the albedo of first hits and which shapes cover them.
    pub compositing: bool,
    /// Where radiance itself is kept.
    pub spectral: Bands,
}

/// Triangular bands of the spectrum about rising wavelengths, each as wide to both sides as its nearest neighbour is far (10 nm
/// where there is only one), cut at the ends of the sensor's band.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bands {
    nm: Vec<f64>,
    half_width: Vec<f64>,
    area: Vec<f64>,
}

/// Half width of a band without neighbours, nm.
const ALONE_NM: f64 = 10.0;

/// Bands nearer than this have too few samples to be told apart.
const NEAREST_NM: f64 = 1.0;

impl Bands {
    /// Bands about these wavelengths, nm, within that of a sensor.
    ///
    /// # Errors
    /// A wavelength outside the sensor's band, or not 1 nm or more above the one before.
    pub fn new(nm: &[f64], within: Band) -> Result<Self> {
        let (shortest, longest) = (within.low_nm(), within.high_nm());
        if let Some(bad) = nm.iter().find(|w| !within.contains(**w)) {
            return Err(Error::input(format!(
                "{bad} nm is outside the wavelengths that are rendered, {shortest} to {longest}"
            )));
        }
        if let Some(pair) = nm.windows(2).find(|pair| pair[1] - pair[0] < NEAREST_NM) {
            return Err(Error::input(format!(
                "{} nm follows {} nm; wavelengths must rise by {NEAREST_NM} nm or more",
                pair[1], pair[0]
            )));
        }
        let half_width: Vec<f64> = (0..nm.len())
            .map(|i| {
                let before = i.checked_sub(1).map(|j| nm[i] - nm[j]);
                let after = nm.get(i + 1).map(|next| next - nm[i]);
                before.into_iter().chain(after).fold(f64::INFINITY, f64::min)
            })
            .map(|width| if width.is_finite() { width } else { ALONE_NM })
            .collect();
        let side = |width: f64, room: f64| {
            let reach = width.min(room);
            reach - 0.5 * reach * reach / width
        };
        let area = nm.iter().zip(&half_width);
        let area = area.map(|(w, width)| side(*width, w - shortest) + side(*width, longest - w));
        Ok(Self { area: area.collect(), nm: nm.to_vec(), half_width })
    }

    /// Their wavelengths, nm.
    #[must_use]
    pub fn nm(&self) -> &[f64] {
        &self.nm
    }

    /// Each wavelength's share in the mean radiance of the bands that it lies in: calls `add(band, value)`.
    #[inline]
    pub(super) fn each(&self, sample: &Sample, mut add: impl FnMut(usize, f64)) {
        for (radiance, w) in sample.radiance.iter().zip(sample.hero.wavelengths.nm()) {
            let above = self.nm.partition_point(|nm| *nm <= w);
            for band in above.saturating_sub(1)..(above + 1).min(self.nm.len()) {
                let height = 1.0 - (w - self.nm[band]).abs() / self.half_width[band];
                if height > 0.0 {
                    add(band, radiance * height / (self.area[band] * WAVES as f64));
                }
            }
        }
    }
}

/// One of the shapes that a pixel's samples hit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Cover {
    /// Identity of the shape; 0: none.
    pub id: u32,
    /// Index of its object in the scene.
    pub object: u32,
    /// How many samples hit it first.
    pub hits: u32,
}

/// Shapes that a pixel keeps count of. What comes later is counted as none.
pub const COVERS: usize = 6;

/// What compositors want to know of a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Compositing {
    /// The first shapes that were hit, in their order.
    pub covers: [Cover; COVERS],
}

impl Compositing {
    /// Adds a sample that hit something.
    pub(super) fn add(&mut self, first: &FirstHit) {
        let slot = self.covers.iter_mut().find(|cover| cover.id == first.id || cover.id == 0);
        if let Some(cover) = slot {
            *cover = Cover { id: first.id, object: first.object, hits: cover.hits + 1 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::integrator::NO_HIT;

    /// A spectrum that is linear in the wavelength is found at each band but those that the range cuts, whose middle
    /// moves: there the mean over the part that is left.
    #[test]
    fn bands_hold_the_mean_radiance_about_their_wavelengths() {
        let bands = Bands::new(&[385.0, 420.0, 450.0, 600.0, 601.0, 720.0], Band::HUMAN).unwrap();
        let sensor = Sensor::human();
        let mut sums = [0.0; 6];
        let count = 200_000;
        for i in 0..count {
            let hero = sensor.density().draw((f64::from(i) + 0.5) / f64::from(count));
            let radiance = std::array::from_fn(|k| hero.wavelengths.nm()[k] / hero.pdf[k]);
            let sample = Sample { radiance, hero, first: NO_HIT, offset: [0.5; 2], alpha: 1.0, rays: [0; 2] };
            bands.each(&sample, |band, value| sums[band] += value / f64::from(count));
        }
        // The tent about 385 with 35 nm to the right and 5 of as many to the left; the half tent below 720.
        let (left, right) = (5.0 - 12.5 / 35.0, 17.5);
        let moment = 35.0 * 35.0 / 6.0 - (12.5 - 125.0 / (3.0 * 35.0));
        let expected = [385.0 + moment / (left + right), 420.0, 450.0, 600.0, 601.0, 720.0 - 119.0 / 3.0];
        for (found, expected) in sums.iter().zip(expected) {
            assert!((found - expected).abs() < 0.02, "{sums:?}");
        }
    }

    #[test]
    fn bands_outside_or_out_of_order_are_refused() {
        for (bad, part) in
            [(&[300.0][..], "300 nm is outside"), (&[500.0, 500.5][..], "500.5 nm follows 500 nm")]
        {
            assert!(Bands::new(bad, Band::HUMAN).unwrap_err().to_string().contains(part));
        }
        let ultraviolet = Band::new(300, 400).unwrap();
        assert!(
            Bands::new(&[300.0, 400.0], ultraviolet).is_ok() && Bands::new(&[401.0], ultraviolet).is_err()
        );
        assert!(Bands::new(&[f64::NAN], ultraviolet).is_err());
        assert!(Bands::new(&[], ultraviolet).unwrap().nm().is_empty());
    }

    #[test]
    fn shapes_are_counted_until_there_is_no_room() {
        let mut pixel = Compositing::default();
        for id in (1..=8).chain([2, 2]) {
            pixel.add(&FirstHit { id, object: 3, ..NO_HIT });
        }
        assert_eq!(pixel.covers.map(|c| (c.id, c.hits)), [(1, 1), (2, 3), (3, 1), (4, 1), (5, 1), (6, 1)]);
        assert_eq!(pixel.covers[0].object, 3);
    }
}
