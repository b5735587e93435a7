//! Which processes fill a store now.
//!
//! Each keeps a file of its own in the folder of temporaries for as long as it computes, under a lock that ends with the process; its name
//! says who it is. So others see which parts of a campaign run, and which were killed. Nothing of it stays in a finished store.

use std::fs::{self, DirEntry, File, FileType, TryLockError};
use std::io::{self, ErrorKind};
use std::sync::{MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use tempfile::NamedTempFile;

use super::aside::Files;
use crate::clock;
use crate::io::temporary::{ATTEMPTS, abandoned, shared};
use crate::progress::Shard;

/// What the names of these files begin with.
pub(super) const PREFIX: &str = "run-";

/// How often a file is touched: where locks are not to be had, its age says whether its process lives.
const TOUCHED_EVERY: Duration = Duration::from_secs(60);

/// So many files are looked at.
const MOST: usize = 200_000;

/// A process that fills a store, or one that was killed while it did and whose trace nobody has deleted yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Its part of the units.
    pub shard: Shard,
    /// Its number, on the machine where it runs.
    pub process: u32,
    /// Since it began.
    pub since: Duration,
    /// Whether it still is.
    pub is_alive: bool,
}

/// This process's own, while it computes.
#[derive(Debug)]
pub(super) struct Own {
    file: NamedTempFile,
    touched: SystemTime,
}

/// Says that this process fills a store, as long as this lives.
#[derive(Debug)]
pub struct Announced<'a>(&'a Files);

impl Drop for Announced<'_> {
    fn drop(&mut self) {
        self.0.leave();
    }
}

impl Files {
    /// Lets others see ([`Survey`](super::Survey)) that this process computes a part of the units, until what is given back is dropped.
    /// Where this cannot be written, nobody sees it, and the work is the same.
    #[must_use = "what is announced ends with it"]
    pub(in crate::io) fn announce(&self, shard: Shard) -> Announced<'_> {
        self.enter(shard);
        Announced(self)
    }

    /// As [`Self::announce`], until [`Self::leave`] or the end of this value.
    pub(in crate::io) fn enter(&self, shard: Shard) {
        let now = clock::now();
        *self.own() = self.announcement(&name_of(shard, now)).ok().map(|file| Own { file, touched: now });
    }

    /// Ends what [`Self::enter`] began.
    pub(in crate::io) fn leave(&self) {
        // Not while it is locked.
        let own = self.own().take();
        if own.is_some() {
            drop(own);
            self.tidy();
        }
    }

    fn own(&self) -> MutexGuard<'_, Option<Own>> {
        self.own.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows, now and then, that this process lives.
    pub(super) fn show_life(&self) {
        let now = clock::now();
        if let Some(own) = self.own().as_mut()
            && now.duration_since(own.touched).is_ok_and(|since| since > TOUCHED_EVERY)
        {
            // Where locks are to be had nobody looks at it.
            let _ = own.file.as_file().set_modified(now);
            own.touched = now;
        }
    }

    /// A locked file of its own for this process.
    fn announcement(&self, name: &str) -> io::Result<NamedTempFile> {
        for _ in 0..ATTEMPTS {
            fs::create_dir_all(self.aside())?;
            let file = match shared(false).prefix(name).tempfile_in(self.aside()) {
                // Another process found the folder empty.
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                other => other?,
            };
            let is_taken = matches!(file.as_file().try_lock(), Err(TryLockError::WouldBlock));
            if !is_taken && file.path().exists() {
                return Ok(file);
            }
            // Somebody looked at it, or swept it, before it was locked.
        }
        Err(ErrorKind::NotFound.into())
    }

    /// All processes that announced themselves, those that are no more among them; by their parts.
    pub(super) fn runs(&self, now: SystemTime) -> Vec<Run> {
        let Ok(entries) = fs::read_dir(self.aside()) else { return Vec::new() };
        let one = |entry: DirEntry| {
            let (shard, begun, process) = read_name(entry.file_name().to_str()?)?;
            entry.file_type().ok().filter(FileType::is_file)?;
            let left: Option<io::Result<File>> = abandoned(&entry.path());
            let since = now.duration_since(begun).unwrap_or_default();
            Some(Run { shard, process, since, is_alive: left.is_none() })
        };
        let mut runs: Vec<Run> = entries.take(MOST).flatten().filter_map(one).collect();
        runs.sort_by_key(|run| (run.shard.of(), run.shard.number(), !run.is_alive, run.since));
        runs
    }
}

/// The name of a process's file, but for what makes it unique.
fn name_of(shard: Shard, now: SystemTime) -> String {
    let begun_s = now.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    format!("{PREFIX}{}-{}-{begun_s}-{}-", shard.number(), shard.of(), std::process::id())
}

/// What such a name says; `None` where it is no such.
fn read_name(name: &str) -> Option<(Shard, SystemTime, u32)> {
    let mut parts = name.strip_prefix(PREFIX)?.splitn(5, '-');
    let shard = Shard::new(parts.next()?.parse().ok()?, parts.next()?.parse().ok()?).ok()?;
    let begun = UNIX_EPOCH.checked_add(Duration::from_secs(parts.next()?.parse().ok()?))?;
    let process = parts.next()?.parse().ok()?;
    parts.next().map(|_| (shard, begun, process))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_was_written_into_them() {
        let (shard, begun) = (Shard::new(3, 16).unwrap(), UNIX_EPOCH + Duration::from_secs(1_800_000_000));
        let name = name_of(shard, begun) + "x-7";
        assert_eq!(read_name(&name), Some((shard, begun, std::process::id())));
        let huge = format!("run-0-1-{}-1-x", u64::MAX);
        for other in [
            "new-x",
            "run-",
            "run-2-2-5-1-x",
            "run-0-1-x-1-y",
            "run-0-1-5-9999999999-x",
            "run-0-1-5-1",
            &huge,
        ] {
            assert_eq!(read_name(other), None, "{other}");
        }
    }

    #[test]
    fn the_living_are_told_from_the_killed() {
        let folder = tempfile::tempdir().unwrap();
        let files = Files::new(folder.path());
        assert!(files.runs(clock::now()).is_empty());
        let (now, shard) = (clock::now(), Shard::new(1, 4).unwrap());
        let own = files.announcement(&name_of(shard, now)).unwrap();
        fs::write(folder.path().join(".aside/run-2-4-1800000000-77-dead"), b"").unwrap();
        fs::write(folder.path().join(".aside/new-half"), b"half").unwrap();
        let later = now + Duration::from_secs(90);
        // No file of a process.
        fs::create_dir(folder.path().join(".aside/run-3-4-1800000000-78-folder")).unwrap();
        let runs = files.runs(later);
        assert_eq!(runs.iter().map(|run| run.is_alive).collect::<Vec<_>>(), [true, false]);
        assert_eq!((runs[0].process, runs[1].process), (std::process::id(), 77));
        // Whole seconds stand in names.
        assert!((90..92).contains(&runs[0].since.as_secs()));
        // What the living have stays, and goes with them.
        assert_eq!(files.sweep(), 3);
        assert!(own.path().exists());
        drop(own);
        files.tidy();
        assert!(!folder.path().join(".aside").exists());
    }
}
