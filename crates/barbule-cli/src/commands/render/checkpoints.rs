//! What pictures go on from: kept while a run's pictures are not all done, and deleted then.

use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use barbule::io::{delete_file, read_own, write_whole};
use barbule::render::checkpoint;
use barbule::render::film::Film;
use barbule::{Error, Result};

use super::job::Job;
use crate::common::Common;

/// How often a checkpoint is written.
const EVERY: Duration = Duration::from_secs(15);

/// Where that of a picture in this file is.
fn path_of(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(".checkpoint");
    name.into()
}

/// Those of a run. A picture is worth more than what it could go on from: one that cannot be written is said once, and ends nothing.
pub(super) struct Checkpoints<'a> {
    common: &'a Common,
    are_wanted: bool,
    is_said: Cell<bool>,
    /// Why the first picture that ended has none.
    lacking: RefCell<Option<Error>>,
}

/// That of one picture.
pub(super) struct Kept<'a> {
    of: &'a Checkpoints<'a>,
    path: PathBuf,
    name: [u8; 32],
    last: Instant,
}

impl<'a> Checkpoints<'a> {
    pub(super) fn new(common: &'a Common, are_wanted: bool) -> Self {
        Self { common, are_wanted, is_said: Cell::new(false), lacking: RefCell::new(None) }
    }

    /// The checkpoint of a picture of this name.
    pub(super) fn of(&'a self, job: &Job<'_>, name: [u8; 32]) -> Kept<'a> {
        self.at(path_of(job.file), name)
    }

    /// What is kept in a file, under this name.
    pub(super) fn at(&'a self, path: PathBuf, name: [u8; 32]) -> Kept<'a> {
        Kept { of: self, path, name, last: Instant::now() }
    }

    /// Whether a picture ended of which none could be written.
    pub(super) fn lack_one(&self) -> bool {
        self.lacking.borrow().is_some()
    }

    /// Ends a run: what is not done stays, what is done needs none.
    ///
    /// # Errors
    /// A picture that is not done could not be kept, or what is done cannot be deleted.
    pub(super) fn end(self, all_done: bool, files: &[PathBuf]) -> Result<()> {
        match self.lacking.into_inner() {
            _ if !self.are_wanted => Ok(()),
            Some(error) if !all_done => Err(error.followed_by("; the picture itself is written")),
            _ if all_done => files.iter().try_for_each(|file| delete_file(&path_of(file))),
            _ => Ok(()),
        }
    }
}

impl Kept<'_> {
    /// The film to begin with.
    ///
    /// # Errors
    /// The file is no checkpoint of this picture.
    pub(super) fn film(&self, job: &Job<'_>) -> Result<Film> {
        let path: &Path = &self.path;
        let film = Film::with(job.size, job.planes.clone())?;
        if !(self.of.are_wanted && path.exists()) {
            return Ok(film);
        }
        let bytes = read_own(path, checkpoint::bytes(&film))?;
        checkpoint::read(&bytes, &self.name, film)
            .map_err(|error| error.followed_by("; delete it to begin again").at(path.display()))
    }

    /// Writes it where the last one is old.
    pub(super) fn now_and_then(&mut self, film: &Film) {
        if self.of.are_wanted && self.last.elapsed() > EVERY {
            // Said, and tried again later.
            let _ = self.write(film);
            self.last = Instant::now();
        }
    }

    /// Writes that of a picture that ended.
    pub(super) fn at_the_end(&self, film: &Film) {
        if self.of.are_wanted
            && let Err(error) = self.write(film)
        {
            self.of.lacking.borrow_mut().get_or_insert(error);
        }
    }

    fn write(&self, film: &Film) -> Result<()> {
        let written = write_whole(&self.path, &checkpoint::write(film, &self.name));
        if let Err(error) = &written
            && !self.of.is_said.replace(true)
        {
            self.of.common.say(&format!("{error}; rendering goes on without it"));
        }
        written
    }
}
