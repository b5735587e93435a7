//! Far fields of one section under light of several wavelengths and directions.

use rayon::prelude::*;

use super::direct::{self, Shadows};
use super::surface;
use super::surface::{Accuracy, FINE_ELEMENT_UM};
use crate::progress::{OnlyStops, Progress};
use crate::scattering::far_field::{FarField, Illumination, Window};
use crate::structure::Section;
use crate::{Error, Result};

/// Every wavelength with every direction: results are `[wavelength][theta_i][phi_i]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Illuminations {
    /// Vacuum wavelengths, nm.
    pub wavelengths_nm: Vec<f64>,
    /// Longitudinal angles of incidence, rad.
    pub theta_i: Vec<f64>,
    /// Azimuths of incidence, rad.
    pub phi_i: Vec<f64>,
    /// How far across the light falls.
    pub window: Window,
}

impl Illuminations {
    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.shape().iter().fold(1, |count, length| count.saturating_mul(*length))
    }

    /// The lengths of the axes.
    #[must_use]
    pub fn shape(&self) -> [usize; 3] {
        [self.wavelengths_nm.len(), self.theta_i.len(), self.phi_i.len()]
    }

    /// One of them, counted with φ_i fastest.
    ///
    /// # Panics
    /// `index` is not below [`Self::count`].
    #[must_use]
    pub fn at(&self, index: usize) -> Illumination {
        let (rest, phi) = (index / self.phi_i.len(), index % self.phi_i.len());
        let (wavelength, theta) = (rest / self.theta_i.len(), rest % self.theta_i.len());
        Illumination {
            wavelength_nm: self.wavelengths_nm[wavelength],
            theta_i: self.theta_i[theta],
            phi_i: self.phi_i[phi],
            window: self.window,
        }
    }

    /// All of them, φ_i fastest.
    pub fn iter(&self) -> impl Iterator<Item = Illumination> {
        (0..self.count()).map(|index| self.at(index))
    }
}

/// Which formulas compute a far field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// [`surface::far_field`].
    Fast,
    /// [`direct::far_field`], the plain reference.
    Direct,
    /// The same with the top in its own light, [`Shadows::Cast`].
    Shadowed,
}

/// The far fields of a section on so many azimuths of the upper half, in the order of [`Illuminations::iter`]: each the
/// same bits as alone, whatever the number of threads.
///
/// # Errors
/// As [`surface::far_field`], the first in this order; or a stop by `progress`.
pub fn far_fields(
    section: &Section,
    illuminations: &Illuminations,
    azimuths: usize,
    method: Method,
    progress: &dyn Progress,
) -> Result<Vec<FarField>> {
    let count = illuminations.count();
    let one = |index: usize, progress: &dyn Progress| {
        let illumination = illuminations.at(index);
        match method {
            Method::Fast => {
                surface::far_field_observed(section, &illumination, azimuths, &Accuracy::default(), progress)
            }
            Method::Direct | Method::Shadowed => {
                let shadows = if method == Method::Direct { Shadows::Ignored } else { Shadows::Cast };
                direct::far_field_observed(
                    section,
                    &illumination,
                    azimuths,
                    FINE_ELEMENT_UM,
                    shadows,
                    progress,
                )
            }
        }
    };
    if count == 1 {
        return Ok(vec![one(0, progress)?]);
    }
    progress.begin("far fields", count as u64);
    let found: Vec<_> = (0..count)
        .into_par_iter()
        .map(|index| {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let far = one(index, &OnlyStops(progress));
            progress.advance(1);
            far
        })
        .collect();
    found.into_iter().collect()
}

/// Bytes of so many far fields on so many azimuths.
#[must_use]
pub fn bytes(count: usize, azimuths: usize) -> u64 {
    const COMPONENTS: u64 = 4;
    let complex = size_of::<crate::Complex64>() as u64;
    (count as u64).saturating_mul(azimuths as u64).saturating_mul(COMPONENTS * complex)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Unobserved;
    use crate::structure::Structure;

    #[test]
    fn each_of_many_is_the_one_that_it_is_alone() {
        let section = Structure::builtin("starling").unwrap().instance(1, 0).unwrap();
        let sweep = Illuminations {
            wavelengths_nm: vec![450.0, 600.0],
            theta_i: vec![0.3],
            phi_i: vec![-0.4, 0.0, 0.7],
            window: Window::Gaussian,
        };
        let found = far_fields(&section, &sweep, 90, Method::Fast, &Unobserved).unwrap();
        assert_eq!((found.len(), sweep.shape()), (6, [2, 1, 3]));
        for (far, illumination) in found.iter().zip(sweep.iter()) {
            let alone = surface::far_field(&section, &illumination, 90, &Accuracy::default()).unwrap();
            assert_eq!(*far, alone);
        }
        assert_eq!((sweep.at(4).wavelength_nm, sweep.at(4).phi_i), (600.0, 0.0));
        // Components of two polarizations on every azimuth.
        let held: usize = found.iter().flat_map(|f| f.amplitudes.iter().flatten()).map(Vec::len).sum();
        assert_eq!(bytes(6, 90), 16 * held as u64);
    }

    #[test]
    fn the_first_error_is_the_one_that_is_said() {
        use crate::material::{Library, Table};
        let mut library = Library::builtin();
        let table = Table::new("glass", &[(500.0, 1.5.into()), (700.0, 1.5.into())]).unwrap();
        library.insert_table("glass", table).unwrap();
        let stack = crate::stack::Stack::parse("air/glass:300/air", &library).unwrap();
        let section = Section::flat("glass", &stack, library).unwrap();
        let sweep = Illuminations {
            wavelengths_nm: vec![550.0, 480.0, 320.0],
            theta_i: vec![0.0],
            phi_i: vec![0.0],
            window: Window::Gaussian,
        };
        let error = far_fields(&section, &sweep, 90, Method::Fast, &Unobserved).unwrap_err();
        assert!(error.to_string().contains("480"), "{error}");
    }
}
