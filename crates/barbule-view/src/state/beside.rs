//! Measured spectra that are drawn beside what is computed.

use std::path::Path;
use std::sync::Arc;

use barbule::Result;
use barbule::io::measured::{Measured, read_measured};
use barbule::io::{InputKind, kind_of};
use barbule::spectrum::Spectrum;
use barbule::spectrum::comparison::Comparison;

/// A file of measured reflectance.
#[derive(Debug, Clone)]
pub struct Beside {
    file: String,
    measured: Arc<Measured>,
}

impl Beside {
    /// Most files that are drawn at once: more are not told apart.
    pub const MOST: usize = 8;

    /// Reads a file as a spectrometer, R or a spreadsheet writes it.
    ///
    /// # Errors
    /// It cannot be read, is no such file, or can be read in two ways.
    pub fn read(file: &str) -> Result<Self> {
        let measured = read_measured(Path::new(file), None, None)?;
        Ok(Self { file: file.to_owned(), measured: Arc::new(measured) })
    }

    /// Whether a file is meant as one, by what is in it: nothing that can be opened otherwise.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn is_meant(path: &Path) -> Result<bool> {
        Ok(kind_of(path)? == InputKind::Other)
    }

    /// The file, as it was named.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The file's name without folders and ending.
    #[must_use]
    pub fn name(&self) -> String {
        let stem = Path::new(&self.file).file_stem();
        stem.map_or_else(|| self.file.clone(), |stem| stem.to_string_lossy().into_owned())
    }

    /// What it holds: samples, their mean and spread, and how it was read.
    #[must_use]
    pub fn measured(&self) -> &Measured {
        &self.measured
    }

    /// How far a computed reflectance is from its mean, in numbers.
    ///
    /// # Errors
    /// They share fewer than two wavelengths.
    pub fn compare(&self, computed: &Spectrum) -> Result<Comparison> {
        Comparison::of(computed, &self.measured.mean, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::spectrum::Wavelengths;

    #[test]
    fn measurements_are_told_from_everything_that_can_be_opened() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let spectrum = file("blue back.csv", "wl,R\n400,10\n500,30\n600,20\n700,20\n");
        assert!(Beside::is_meant(&spectrum).unwrap());
        for other in ["stack = 'air/keratin:300/air'", "preset = 'starling'", "barbule_view = 1"] {
            assert!(!Beside::is_meant(&file("a.toml", other)).unwrap(), "{other}");
        }
        let beside = Beside::read(&spectrum.to_string_lossy()).unwrap();
        assert_eq!((beside.name().as_str(), beside.measured().samples.len()), ("blue back", 1));
        assert_eq!(beside.measured().mean.held(450.0), 0.2);
        let at = Wavelengths::new([400.0, 500.0, 600.0, 700.0]).unwrap();
        let same = Spectrum::new(at, vec![0.1, 0.3, 0.2, 0.2]).unwrap();
        assert!(beside.compare(&same).unwrap().rmse < 1e-12);
        let short = Spectrum::new(Wavelengths::new([800.0, 820.0]).unwrap(), vec![0.1, 0.1]).unwrap();
        assert!(beside.compare(&short).is_err());
        assert!(Beside::read(&file("b.txt", "no numbers").to_string_lossy()).is_err());
    }
}
