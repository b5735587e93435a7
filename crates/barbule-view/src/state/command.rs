//! The command lines that make the same pictures, figures and tables as the window shows.

use barbule::open::{self, Opening};
use barbule::progress::Progress;
use barbule::structure::Side;
use barbule::{Error, Result};

use super::picture::NeededFile;
use super::subject::{Grating, Subject, What};
use super::view::{Mode, Seer, View};

/// The scene file of a picture.
const SCENE_FILE: &str = "scene.toml";
/// Wavelengths that birds see, as commands take them.
const BIRDS_NM: &str = "300:700:4";

/// A command with its words, and the files that it needs in its working folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Command {
    /// Its words, the program's name first.
    pub words: Vec<String>,
    /// The files.
    pub files: Vec<NeededFile>,
}

/// A figure or table of the window that a command makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figure {
    /// Reflectance against wavelength at the view's angle.
    Spectrum,
    /// What one individual scatters at the view's wavelength and angle.
    FarField,
    /// The section of one individual, to scale.
    Section,
    /// The lobes of the material.
    Lobes,
    /// What the grating does with light.
    Diffraction,
}

impl Figure {
    /// The figures that there are of something.
    #[must_use]
    pub fn of(subject: &Subject) -> &'static [Self] {
        match subject.what() {
            What::Grating(Grating::Sample(_)) => &[Self::Diffraction],
            What::Grating(Grating::File(_)) | What::Scene(_) => &[],
            What::Material(_, None) => &[Self::Lobes],
            What::Material(_, Some(_))
            | What::Species(_)
            | What::Stack(_)
            | What::Lattice(..)
            | What::Sections(_) => &[Self::Spectrum, Self::FarField, Self::Section, Self::Lobes],
        }
    }

    /// What a file of it is called, without its ending.
    #[must_use]
    pub fn stem(self) -> &'static str {
        match self {
            Self::Spectrum => "spectrum",
            Self::FarField => "far-field",
            Self::Section => "section",
            Self::Lobes => "lobes",
            Self::Diffraction => "diffraction",
        }
    }
}

impl Command {
    fn new(words: &[&str]) -> Self {
        let words = std::iter::once("barbule").chain(words.iter().copied());
        Self { words: words.map(str::to_owned).collect(), files: Vec::new() }
    }

    fn with(mut self, words: &[&str]) -> Self {
        self.words.extend(words.iter().map(|word| (*word).to_owned()));
        self
    }

    /// As it is typed into a shell.
    #[must_use]
    pub fn line(&self) -> String {
        self.words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
    }

    /// The command that draws what the window shows, so many pixels wide and high. The scene is a file beside it but where a preset or
    /// species is shown as a scene of its own.
    ///
    /// # Errors
    /// As [`Subject::scene`].
    pub fn picture(
        subject: &Subject,
        view: &View,
        size: [u32; 2],
        opening: &Opening,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let (scene, mut files) = subject.scene(view, opening, progress)?;
        let [width, height] = size;
        let mut is_said_by_flags = view.mode == Mode::Scene && view.preset.is_none() && !subject.is_moved();
        if is_said_by_flags {
            // Flags turn the light and the camera, no more.
            let own = open::description(subject.text(), opening, progress)?;
            is_said_by_flags =
                own.light.radius_deg == scene.light.radius_deg && own.camera.target == scene.camera.target;
        }
        let typed = if is_said_by_flags {
            subject.text().to_owned()
        } else {
            files.insert(0, NeededFile { name: SCENE_FILE.into(), text: scene.to_toml()? });
            SCENE_FILE.to_owned()
        };
        let size = format!("{width}x{height}");
        let mut command = Self::new(&["render", &typed, "--size", &size]);
        if typed != SCENE_FILE {
            let (light, camera) = (&scene.light.bearing, &scene.camera.bearing);
            let light = format!("--light={},{}", light.azimuth_deg, light.elevation_deg);
            let from =
                format!("--view={},{},{}", camera.azimuth_deg, camera.elevation_deg, scene.camera.width_mm);
            command = command.with(&[&light, &from]);
        }
        if let Seer::Bird(_) = view.eye {
            command = command.with(&["--sensor", &view.eye.word()]);
        }
        Ok(Self { files, ..command.with(&["-o", "picture.png"]) })
    }

    /// The command that makes a figure or, where the file's ending says so, its table.
    ///
    /// # Errors
    /// There is no such figure of it; as [`Subject::typed`].
    pub fn figure(subject: &Subject, view: &View, figure: Figure, file: &str) -> Result<Self> {
        if !Figure::of(subject).contains(&figure) {
            return Err(Error::input(format!("there is no {} of a {}", figure.stem(), subject.kind())));
        }
        let typed = subject.typed()?;
        let name = match (&typed, subject.what()) {
            (Some(typed), _) => typed.name.clone(),
            (None, What::Grating(Grating::Sample(sample))) => (*sample).to_owned(),
            (None, _) => return Err(Error::input(format!("a {} is no structure", subject.kind()))),
        };
        // A material's structure is what it was made of.
        let structure = match subject.what() {
            What::Material(_, Some(sizes)) if !subject.is_moved() => {
                let side = if subject.side() == Side::Below { Side::BELOW } else { "" };
                sizes.original().title() + side
            }
            _ => name.clone(),
        };
        let (angle, individual) = (view.angle_deg.to_string(), view.individual.to_string());
        let command = match figure {
            Figure::Spectrum if subject.stack().is_some() => {
                Self::new(&["film", &structure, &format!("--angles={}", angle.trim_start_matches('-'))])
            }
            Figure::Spectrum => {
                let command = Self::new(&["spectrum", &structure, &format!("--angle={angle}")]);
                match &view.eye {
                    Seer::People => command,
                    Seer::Bird(bird) => command.with(&["--bird", bird, "--wavelengths", BIRDS_NM]),
                }
            }
            Figure::FarField => {
                let wavelength = view.wavelength_nm.to_string();
                let phi = format!("--phi={angle}");
                Self::new(&["far-field", &structure, "--wavelength", &wavelength, "--theta", "0", &phi])
                    .with(&["--instance", &individual])
            }
            Figure::Section => Self::new(&["geometry", &structure, "--instance", &individual]),
            Figure::Lobes => Self::new(&["lobes", &name]),
            Figure::Diffraction => Self::new(&["diffract", &name]),
        };
        let is_table = file.to_lowercase().ends_with(".csv");
        let command = command.with(&[if is_table { "--csv" } else { "-o" }, file]);
        Ok(Self { files: typed.and_then(|typed| typed.file).into_iter().collect(), ..command })
    }
}

/// A word as a shell reads it: in quotes where it holds anything but plain letters.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,=+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::view::{Camera, Light};
    use barbule::Unobserved;
    use std::collections::BTreeMap;

    fn opened(text: &str) -> Subject {
        Subject::open(text, &Opening::default(), &Unobserved).unwrap()
    }

    fn picture(subject: &Subject, view: &View) -> Command {
        Command::picture(subject, view, [640, 480], &Opening::default(), &Unobserved).unwrap()
    }

    #[test]
    fn scenes_are_drawn_by_their_names_and_everything_else_by_a_file() {
        let state = crate::state::State::open("starling-feather", &Opening::default(), &Unobserved).unwrap();
        let mut view = state.view().clone();
        (view.light.azimuth_deg, view.light.elevation_deg, view.camera.width_mm) = (340.0, 50.0, 30.0);
        let command = picture(state.subject(), &view);
        let line = command.line();
        assert!(
            line.starts_with("barbule render starling-feather --size 640x480 --light=340,50 --view="),
            "{line}"
        );
        assert!(line.ends_with(",30 -o picture.png"), "{line}");
        assert_eq!(command.files, []);
        // No flag says how large the lamp is, nor what the camera looks at.
        let larger = View { light: Light { radius_deg: 20.0, ..view.light }, ..view.clone() };
        let aside = View { camera: Camera { target_mm: [1.0, 2.0, 0.0], ..view.camera }, ..view.clone() };
        for changed in [larger, aside] {
            assert_eq!(picture(state.subject(), &changed).files[0].name, "scene.toml");
        }
        view.eye = Seer::Bird("starling".into());
        view.mode = Mode::Sphere;
        let command = picture(&opened("air/keratin:300/melanin"), &view);
        assert_eq!(
            command.line(),
            "barbule render scene.toml --size 640x480 --sensor bird:starling -o picture.png"
        );
        assert!(command.files[0].text.contains("air/keratin:300/melanin"));
        let mut moved = opened("starling");
        moved.put(&BTreeMap::from([("cortex_um".to_owned(), 0.2)])).unwrap();
        let names: Vec<_> = picture(&moved, &view).files.into_iter().map(|file| file.name).collect();
        assert_eq!(names, ["scene.toml", "my-starling.toml"]);
    }

    #[test]
    fn figures_are_those_of_what_is_shown() {
        let view = View { angle_deg: -30.0, individual: 3, wavelength_nm: 480.0, ..View::default() };
        let line = |text: &str, figure, file: &str| {
            Command::figure(&opened(text), &view, figure, file).unwrap().line()
        };
        assert_eq!(
            line("starling:pink", Figure::Spectrum, "s.svg"),
            "barbule spectrum starling:pink --angle=-30 -o s.svg"
        );
        assert_eq!(
            line("air/6*(melanin:99/keratin:100)/keratin", Figure::Spectrum, "s.csv"),
            "barbule film 'air/6*(melanin:99/keratin:100)/keratin' --angles=30 --csv s.csv"
        );
        assert_eq!(
            line("rock-dove:forest (below)", Figure::Section, "s.svg"),
            "barbule geometry 'rock-dove:forest (below)' --instance 3 -o s.svg"
        );
        assert_eq!(
            line("magpie", Figure::FarField, "f.png"),
            "barbule far-field magpie --wavelength 480 --theta 0 --phi=-30 --instance 3 -o f.png"
        );
        assert_eq!(line("blazed", Figure::Diffraction, "d.png"), "barbule diffract blazed -o d.png");
        let bird = View { eye: Seer::Bird("peafowl".into()), ..view.clone() };
        let command = Command::figure(&opened("magpie"), &bird, Figure::Spectrum, "s.svg").unwrap();
        assert!(command.line().contains("--bird peafowl --wavelengths 300:700:4"));
        let mut moved = opened("starling");
        moved.put(&BTreeMap::from([("cortex_um".to_owned(), 0.2)])).unwrap();
        let command = Command::figure(&moved, &view, Figure::Lobes, "l.svg").unwrap();
        assert_eq!(
            (command.line().as_str(), command.files.len()),
            ("barbule lobes my-starling.toml -o l.svg", 1)
        );
        let refused = Command::figure(&opened("snake"), &view, Figure::Spectrum, "s.svg").unwrap_err();
        assert_eq!(refused.to_string(), "there is no spectrum of a scene");
    }

    #[test]
    fn words_are_quoted_as_shells_read_them() {
        assert_eq!(quoted("air/keratin:300/air"), "air/keratin:300/air");
        assert_eq!(
            (quoted("a b"), quoted("it's"), quoted("")),
            ("'a b'".into(), "'it'\\''s'".into(), "''".into())
        );
        assert_eq!(quoted("keratin:5±1"), "'keratin:5±1'");
    }
}
