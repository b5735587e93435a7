//! The command line of `barbule-view`: words to checked values, and those to what is drawn.

use std::ffi::OsString;
use std::path::PathBuf;

use barbule::characterize::Catalog;
use barbule::error::{did_you_mean, shortened};
use barbule::open::Opening;
use barbule::progress::Progress;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory as _, FromArgMatches as _, Parser};

use crate::state::{Mode, Seer, Shown, State};
use crate::{Error, Result};

/// What is opened where nothing is named and nothing was kept.
pub const FIRST: &str = "starling";

/// Pixels of a picture without a window.
const PICTURE_PX: [u32; 2] = [1024, 1024];
/// Frames that are timed.
const FRAMES: u32 = 60;

const EXAMPLES: &str = "\
Examples:
  barbule-view                                             what was open last, or a starling
  barbule-view starling:green                              a species and its variant
  barbule-view 'air/6*(melanin:99/keratin:100)/keratin'    a stack, thicknesses in nm
  barbule-view magpie --mode sphere --eye bird:starling --light 300,40
  barbule-view xenopeltis --mode snake --screenshot snake.png --size 640x480
  barbule-view starling --screenshot feather.png --camera 180,60,1.6 --mean
  barbule-view starling --bench --frames 100               frames a second, without a window";

/// Looks at a feather's structure, its colours and its glints, in real time.
#[derive(Debug, Clone, Parser)]
#[command(name = "barbule-view", version, after_help = EXAMPLES)]
pub struct Arguments {
    /// A species (starling:green), a stack (air/keratin:595/air), a grating, a preset, or the file of one, of a material or of a saved
    /// viewer [default: what was open last, else starling]
    #[arg(value_name = "X")]
    pub open: Option<String>,
    /// Draw a picture into a PNG without a window
    #[arg(long, value_name = "FILE")]
    pub screenshot: Option<PathBuf>,
    /// Time frames without a window: start-up, frames a second, memory of the tables
    #[arg(long)]
    pub bench: bool,
    /// Frames that are timed, or of which the picture is made [default: 60, or as many as make it better]
    #[arg(long, value_name = "N", value_parser = frames)]
    pub frames: Option<u32>,
    /// Pixels of the picture or points of the window, as in 640x480
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Where the light stands: degrees clockwise from the feather's tip and over the vane, as in 340,50
    #[arg(long, value_name = "AZ,EL", value_parser = bearing, allow_hyphen_values = true)]
    pub light: Option<[f64; 2]>,
    /// From where it is seen, in the same degrees, and the picture's width in mm, as in 180,60,1.6
    #[arg(long, value_name = "AZ,EL[,WIDTH]", value_parser = camera, allow_hyphen_values = true)]
    pub camera: Option<Seen>,
    /// On what it is shown: sphere, vane, feather, snake or scene
    #[arg(long, value_name = "MODE", value_parser = mode)]
    pub mode: Option<Mode>,
    /// Show the mean over individuals, without glints
    #[arg(long)]
    pub mean: bool,
    /// Who sees: human, or bird:NAME in false colours
    #[arg(long, value_name = "EYE", value_parser = Seer::named)]
    pub eye: Option<Seer>,
    /// Keep the viewer's state in this file rather than in the system's folder
    #[arg(long, value_name = "FILE")]
    pub state: Option<PathBuf>,
    /// The cache of finished materials [default: $XDG_CACHE_HOME/barbule or ~/.cache/barbule]
    #[arg(long, value_name = "FOLDER")]
    pub cache: Option<PathBuf>,
}

/// From where something is seen: azimuth and elevation, and perhaps the picture's width, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Azimuth and elevation, degrees.
    pub bearing_deg: [f64; 2],
    /// Width of the picture at the target.
    pub width_mm: Option<f64>,
}

/// A picture, or times of frames, without a window.
#[derive(Debug, Clone)]
pub struct Request {
    /// What is drawn, and how it is looked at.
    pub state: State,
    /// Pixels along and down.
    pub size: [u32; 2],
    /// Frames: those that are timed, or of which the picture is the mean; none: as many as make it better.
    pub frames: Option<u32>,
    /// The file of the picture.
    pub file: Option<PathBuf>,
}

/// What reading a command line comes to.
#[derive(Debug)]
pub enum Given {
    /// Something to do.
    Arguments(Box<Arguments>),
    /// Words for standard output: help, or the version.
    Words(String),
}

/// Reads the words of a command line, the program's name first.
///
/// # Errors
/// A word that is none, or a value out of its range: one sentence.
pub fn read(words: impl IntoIterator<Item = OsString>) -> Result<Given> {
    let matches = match Arguments::command().try_get_matches_from(words) {
        Ok(matches) => matches,
        Err(error) if !error.use_stderr() => return Ok(Given::Words(error.render().to_string())),
        Err(error) => return Err(Error::input(unclear(&error))),
    };
    let arguments = Arguments::from_arg_matches(&matches).map_err(|error| Error::input(unclear(&error)))?;
    if arguments.frames.is_some() && !arguments.is_headless() {
        return Err(Error::input(
            "--frames counts frames without a window; give --screenshot or --bench too",
        ));
    }
    Ok(Given::Arguments(Box::new(arguments)))
}

impl Arguments {
    /// Whether no window is asked for.
    #[must_use]
    pub fn is_headless(&self) -> bool {
        self.bench || self.screenshot.is_some()
    }

    /// How names are opened: with the cache of `--cache`, else of a folder.
    #[must_use]
    pub fn opening(&self, usual_cache: Option<PathBuf>) -> Opening {
        let cache = self.cache.clone().or(usual_cache);
        Opening { catalog: Catalog { cache }, ..Opening::default() }
    }

    /// Opens what is named, or takes what is there, and looks at it as is asked for.
    ///
    /// # Errors
    /// There is none of this name, or it cannot be looked at so.
    pub fn state(&self, kept: Option<State>, opening: &Opening, progress: &dyn Progress) -> Result<State> {
        let mut state = match (&self.open, kept) {
            (Some(text), _) => State::open(text, opening, progress)?,
            (None, Some(kept)) => kept,
            (None, None) => State::open(FIRST, opening, progress)?,
        };
        if let Some(mode) = self.mode {
            state.choose(mode, progress)?;
        }
        state.look("arguments", |view| {
            if let Some([azimuth_deg, elevation_deg]) = self.light {
                (view.light.azimuth_deg, view.light.elevation_deg) = (azimuth_deg, elevation_deg);
            }
            if let Some(Seen { bearing_deg: [azimuth_deg, elevation_deg], width_mm }) = self.camera {
                (view.camera.azimuth_deg, view.camera.elevation_deg) = (azimuth_deg, elevation_deg);
                view.camera.width_mm = width_mm.unwrap_or(view.camera.width_mm);
            }
            if self.mean {
                view.shown = Shown::Mean;
            }
            if let Some(eye) = &self.eye {
                view.eye = eye.clone();
            }
        })?;
        state.settle();
        Ok(state)
    }

    /// What is drawn without a window.
    #[must_use]
    pub fn request(&self, state: State) -> Request {
        let frames = self.frames.or(self.bench.then_some(FRAMES));
        Request { state, size: self.size.unwrap_or(PICTURE_PX), frames, file: self.screenshot.clone() }
    }
}

fn frames(text: &str) -> Result<u32> {
    let number = text.parse().ok().filter(|number| (1..=100_000).contains(number));
    number.ok_or_else(|| refused("--frames", text, "a whole number from 1 to 100000"))
}

fn size(text: &str) -> Result<[u32; 2]> {
    let side = |text: &str| text.trim().parse().ok().filter(|side| (16..=16_384).contains(side));
    let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some([side(w)?, side(h)?]));
    sides.ok_or_else(|| refused("--size", text, "columns and rows from 16 to 16384, as in 640x480"))
}

fn numbers(text: &str) -> Option<Vec<f64>> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    text.split(',').map(number).collect()
}

/// An azimuth of any number of rounds, and an elevation.
fn as_bearing(numbers: &[f64]) -> Option<[f64; 2]> {
    let [azimuth, elevation] = *numbers else { return None };
    (azimuth.abs() <= 3600.0 && elevation.abs() <= 90.0).then_some([azimuth, elevation])
}

fn bearing(text: &str) -> Result<[f64; 2]> {
    let found = numbers(text).and_then(|numbers| as_bearing(&numbers));
    found.ok_or_else(|| {
        refused("--light", text, "an azimuth and an elevation from -90 to 90 in degrees, as in 340,50")
    })
}

fn camera(text: &str) -> Result<Seen> {
    let found = numbers(text).and_then(|numbers| {
        let bearing_deg = as_bearing(numbers.get(..2)?)?;
        let width_mm = numbers.get(2).copied();
        let is_seen = width_mm.is_none_or(|width| (0.05..=2000.0).contains(&width));
        (numbers.len() <= 3 && is_seen).then_some(Seen { bearing_deg, width_mm })
    });
    found.ok_or_else(|| {
        let what = "an azimuth, an elevation from -90 to 90 in degrees and, if you like, a width from 0.05 to 2000 mm, as in 180,60,1.6";
        refused("--camera", text, what)
    })
}

fn mode(text: &str) -> Result<Mode> {
    Mode::named("--mode", text)
}

fn refused(flag: &str, text: &str, what: &str) -> Error {
    Error::input(format!("{flag} is '{}', but must be {what}", shortened(text)))
}

/// What is wrong with the words, in one sentence: that of a value's reader where it is one of ours.
fn unclear(error: &clap::Error) -> String {
    let reader = std::error::Error::source(error).and_then(|source| source.downcast_ref::<Error>());
    if let Some(refused) = reader {
        return refused.to_string();
    }
    if let (ErrorKind::UnknownArgument, Some(ContextValue::String(given))) =
        (error.kind(), error.get(ContextKind::InvalidArg))
    {
        let near = match error.get(ContextKind::SuggestedArg) {
            Some(ContextValue::String(flag)) => did_you_mean(given, [flag.as_str()]),
            _ => String::new(),
        };
        let rest = if near.is_empty() { "; --help says what can be given" } else { &near };
        return format!("unexpected argument '{}'{rest}", shortened(given));
    }
    let text = error.render().to_string();
    let lines = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"));
    let joined = lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    format!(
        "{}; --help says what can be given",
        joined.trim_start_matches("error: ").trim_end_matches(['.', ' '])
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;

    fn given(line: &str) -> Result<Arguments> {
        let words = std::iter::once("barbule-view").chain(line.split_whitespace()).map(OsString::from);
        match read(words)? {
            Given::Arguments(arguments) => Ok(*arguments),
            Given::Words(words) => panic!("{words}"),
        }
    }

    fn state(line: &str) -> Result<State> {
        given(line)?.state(None, &Opening::default(), &Unobserved)
    }

    #[test]
    fn what_is_asked_for_is_what_is_looked_at() {
        let line = "magpie --mode sphere --eye bird:starling --light -20,40 --camera 90,-5,3 --mean";
        let state = state(line).unwrap();
        let view = state.view();
        assert_eq!((state.subject().text(), view.mode, view.shown), ("magpie", Mode::Sphere, Shown::Mean));
        assert_eq!((view.light.azimuth_deg, view.light.elevation_deg), (-20.0, 40.0));
        assert_eq!(
            (view.camera.azimuth_deg, view.camera.elevation_deg, view.camera.width_mm),
            (90.0, -5.0, 3.0)
        );
        assert_eq!(view.eye, Seer::Bird("starling".into()));
        let request = given("--screenshot a.png --size 64x48").unwrap().request(state);
        assert_eq!((request.size, request.frames), ([64, 48], None));
        assert_eq!(given("--bench").unwrap().request(request.state).frames, Some(FRAMES));
    }

    #[test]
    fn nothing_named_is_what_was_kept_or_a_starling() {
        assert_eq!(state("").unwrap().subject().text(), FIRST);
        let kept = state("air/keratin:300/air").unwrap();
        let again = given("--mean").unwrap().state(Some(kept), &Opening::default(), &Unobserved).unwrap();
        assert_eq!((again.subject().text(), again.view().shown), ("air/keratin:300/air", Shown::Mean));
    }

    #[test]
    fn examples_of_the_help_can_be_run() {
        let mut count = 0;
        for line in EXAMPLES.lines().filter_map(|line| line.trim().strip_prefix("barbule-view")) {
            // What stands behind many blanks is said about it.
            let line = line.split("  ").next().unwrap_or_default().replace('\'', "");
            state(&line).unwrap_or_else(|error| panic!("{line}: {error}"));
            count += 1;
        }
        assert_eq!(count, 7);
    }

    #[test]
    fn words_that_are_none_are_refused_in_a_sentence() {
        for (line, words) in [
            ("starlign", "did you mean 'starling'?"),
            ("--mod sphere", "unexpected argument '--mod', did you mean '--mode'?"),
            ("--mode cube", "--mode is 'cube'"),
            ("starling --mode snake", "view.mode is snake, but a species is shown as"),
            ("--size 3x4", "--size is '3x4', but must be columns and rows from 16 to 16384"),
            ("--light 3", "--light is '3', but must be an azimuth"),
            ("--camera 1,2,0", "--camera is '1,2,0', but must be"),
            ("--camera 1,2,3,4", "--camera is '1,2,3,4'"),
            ("--light 0,nan", "--light is '0,nan'"),
            ("--eye bird:dodo", "there is no eye 'dodo'"),
            ("--bench --frames 0", "--frames is '0', but must be a whole number"),
            ("--frames 3", "--frames counts frames without a window"),
            ("a b", "unexpected argument 'b'"),
            ("--screenshot", "--help says what can be given"),
        ] {
            let refused = state(line).unwrap_err();
            let sentence = refused.to_string();
            assert!(refused.is_input() && sentence.contains(words), "{line}: {sentence}");
            assert!(!sentence.contains('\n') && sentence.len() < 600, "{line}: {sentence}");
        }
    }

    #[test]
    fn help_and_version_are_words() {
        for flag in ["--help", "--version"] {
            let words = read(["barbule-view", flag].map(OsString::from)).unwrap();
            assert!(matches!(words, Given::Words(words) if words.contains("barbule-view")), "{flag}");
        }
    }
}
