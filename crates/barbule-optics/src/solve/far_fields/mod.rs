//! Far fields of one section under light of several wavelengths and directions, by any solver of [`METHODS`](super::METHODS).

mod solver;

pub(super) use solver::OneByOne;
pub use solver::{
    ELEMENTS, ELEMENTS_PER_WAVELENGTH, Effort, Exact, Method, Prepared, Scattered, SectionSolver, Settings,
};

use crate::scattering::far_field::{Illumination, Window};

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
    use crate::material::{Library, Table};
    use crate::progress::Unobserved;
    use crate::scattering::far_field::Azimuths;
    use crate::solve::surface::{self, Accuracy};
    use crate::solve::{FAST, METHODS, method};
    use crate::structure::{Medium, Parts, Polyline, Section, Structure};
    use crate::{Error, Result};

    fn solved(method: &Method, section: &Section, light: &Illuminations, n: usize) -> Result<Vec<Scattered>> {
        (method.solver)(&Settings::default()).prepare(section)?.scatter(light, n, &Unobserved)
    }

    #[test]
    fn each_of_many_is_the_one_that_it_is_alone() {
        let section = Structure::builtin("starling").unwrap().instance(1, 0).unwrap();
        let sweep = Illuminations {
            wavelengths_nm: vec![450.0, 600.0],
            theta_i: vec![0.3],
            phi_i: vec![-0.4, 0.0, 0.7],
            window: Window::Gaussian,
        };
        let found = solved(&FAST, &section, &sweep, 90).unwrap();
        assert_eq!((found.len(), sweep.shape()), (6, [2, 1, 3]));
        for (found, illumination) in found.iter().zip(sweep.iter()) {
            let alone = surface::far_field(&section, &illumination, 90, &Accuracy::default()).unwrap();
            assert_eq!(found.far, alone);
        }
        assert_eq!((sweep.at(4).wavelength_nm, sweep.at(4).phi_i), (600.0, 0.0));
        // Components of two polarizations on every azimuth.
        let held: usize = found.iter().flat_map(|f| f.far.amplitudes.iter().flatten()).map(Vec::len).sum();
        assert_eq!(bytes(6, 90), 16 * held as u64);
    }

    #[test]
    fn every_method_says_what_it_is_takes_and_gives() {
        let line = |z_um: f64| Polyline { x_um: vec![-1.0, 0.0, 1.0], z_um: vec![z_um; 3] };
        let parts = Parts {
            width_um: Some(2.0),
            boundaries: vec![line(0.0), line(-0.3)],
            media: ["air", "keratin", "air"].map(Medium::named).to_vec(),
            ..Parts::default()
        };
        let section = Section::new(parts, Library::builtin()).unwrap();
        let light = |window| Illuminations {
            wavelengths_nm: vec![500.0, 600.0],
            theta_i: vec![0.0],
            phi_i: vec![0.2],
            window,
        };
        for &own in METHODS {
            assert_eq!(method(own.name), Some(own));
            let solver = (own.solver)(&Settings::default());
            let prepared = solver.prepare(&section).unwrap();
            for window in [Window::Gaussian, Window::PlaneWave] {
                let cost = prepared.cost(&light(window), 36, 2, &Unobserved).unwrap();
                assert!(cost.bytes > 0 && (cost.unknowns > 0) == own.is_exact, "{}: {cost:?}", own.name);
                let found = prepared.scatter(&light(window), 36, &Unobserved).unwrap();
                assert_eq!(found.len(), 2);
                for Scattered { far, reflected, exact, effort } in found {
                    let azimuths =
                        if own.is_exact { Azimuths::FullCircle(36) } else { Azimuths::UpperHalf(36) };
                    assert_eq!(far.azimuths, azimuths, "{}", own.name);
                    assert_eq!((exact.is_some(), effort.is_some()), (own.is_exact, own.is_exact));
                    assert_eq!(reflected.is_some(), window == Window::Gaussian, "{}", own.name);
                }
            }
        }
        assert_eq!(method("guess"), None);
    }

    #[test]
    fn the_first_error_is_the_one_that_is_said() {
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
        let error: Error = solved(&FAST, &section, &sweep, 90).unwrap_err();
        assert!(error.to_string().contains("480"), "{error}");
    }
}
