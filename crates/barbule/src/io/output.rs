//! Writing files so that they appear whole or not at all.
//!
//! A regular file is replaced: by a temporary file in the same folder, synced, then renamed, with the permissions and the
//! owner of what it replaces. Links are followed and stay. Pipes and character devices (`/dev/stdout`, `/dev/null`, a
//! shell's `>(…)`) are written through; nothing else ever takes their place.

use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::ledger::{begin_output, claim_output};
use super::temporary::{again, shared, sweep};
use super::whole::{failure, folder_of, is_descriptor};
use crate::{Error, Result};

/// What the names of temporary files begin and end with; killed runs leave them and later ones delete them.
const PREFIX: &str = ".barbule-";
const SUFFIX: &str = ".part";

/// Links that are followed, as the kernel does.
const MOST_LINKS: usize = 40;

/// Where an output's bytes go.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Target {
    /// A regular file behind all links, there or to be made.
    File(PathBuf),
    /// A pipe, a character device or a descriptor.
    Stream,
}

/// Writes a file so that it appears whole or not at all.
///
/// # Errors
/// As [`check_writable`], or the disk is full.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    write_together(&[(path, bytes)])
}

/// Writes several files so that all of them appear whole, or none: what a failure comes too late for gets back what it
/// was.
///
/// # Errors
/// As [`write_whole`].
pub fn write_together(files: &[(&Path, &[u8])]) -> Result<()> {
    let mut outputs =
        files.iter().map(|(path, bytes)| Output::prepared(path, bytes)).collect::<Result<Vec<_>>>()?;
    // What goes through cannot be taken back, and so goes first.
    outputs.sort_by_key(|output| output.target != Target::Stream);
    let keep = outputs.len() > 1;
    for index in 0..outputs.len() {
        if let Err(error) = outputs[index].appear(keep) {
            outputs[..index].iter_mut().for_each(Output::vanish);
            return Err(failure(outputs[index].path, "cannot be written", &error));
        }
    }
    Ok(())
}

/// Refuses early, before long work, a path that [`write_whole`] would refuse.
///
/// # Errors
/// No name; a folder, a disk or a socket; write-protected; in a folder that is missing or not writable; inside a campaign
/// store; a file that is read while a [`super::Ledger`] is open.
pub fn check_writable(path: &Path) -> Result<()> {
    let target = target(path)?;
    claim_output(path, &path.display().to_string())?;
    match target {
        Target::Stream => Ok(()),
        Target::File(file) => {
            again(|| temporary_beside(&file)).map(|_| ()).map_err(|e| failure(path, "cannot be written", &e))
        }
    }
}

/// Whether what is written to a path goes through it, to a pipe or a device, rather than into a file.
#[must_use]
pub fn is_stream(path: &Path) -> bool {
    target(path).is_ok_and(|target| target == Target::Stream)
}

/// Whether two paths name the same file or folder, through links too; either need not be there yet. Pipes and devices
/// are shared by many, and never the same.
#[must_use]
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(of_a), Ok(of_b)) => {
            let found = file_id(a, &of_a);
            !is_pipe_or_device(&of_a) && found.is_some() && found == file_id(b, &of_b)
        }
        (Err(_), Err(_)) => {
            let place = |path: &Path| {
                let end = behind_links(path).ok()?;
                Some((fs::canonicalize(folder_of(&end)).ok()?, end.file_name()?.to_owned()))
            };
            place(a).is_some_and(|at| Some(at) == place(b))
        }
        _ => false,
    }
}

/// What tells files and folders apart, whatever they are called: device and number.
#[cfg(unix)]
pub(super) type FileId = (u64, u64);

/// Where there is no such number: the path without links.
#[cfg(not(unix))]
pub(super) type FileId = PathBuf;

/// Which file or folder a path leads to.
#[cfg(unix)]
pub(super) fn file_id(_: &Path, metadata: &Metadata) -> Option<FileId> {
    use std::os::unix::fs::MetadataExt as _;
    Some((metadata.dev(), metadata.ino()))
}

/// Which file or folder a path leads to.
#[cfg(not(unix))]
pub(super) fn file_id(path: &Path, _: &Metadata) -> Option<FileId> {
    fs::canonicalize(path).ok()
}

/// Whether a path lies inside a campaign store, whose files are its own.
#[must_use]
pub fn is_inside_store(path: &Path) -> bool {
    let described = |folder: &Path| {
        let mut text = String::new();
        File::open(folder.join("zarr.json"))
            .and_then(|file| file.take(super::LARGEST_INPUT).read_to_string(&mut text))
            .is_ok_and(|_| text.contains("\"barbule_store\""))
    };
    let end = behind_links(path).unwrap_or_else(|_| path.to_owned());
    fs::canonicalize(folder_of(&end)).is_ok_and(|folder| folder.ancestors().any(described))
}

/// The end of a chain of links: what is there, or where something would be made.
///
/// # Errors
/// The links form a circle, or cannot be read.
pub(super) fn behind_links(path: &Path) -> Result<PathBuf> {
    let mut at = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::symlink_metadata(&at) {
            // The links of descriptors lead to what has no name, or not this one.
            Ok(metadata) if metadata.is_symlink() && !is_descriptor(&at) => {
                let to = fs::read_link(&at).map_err(|e| failure(path, "cannot be followed", &e))?;
                at = folder_of(&at).join(to);
            }
            Ok(_) => return Ok(at),
            Err(error) if is_nothing(&error) => return Ok(at),
            Err(error) => return Err(failure(path, "cannot be written", &error)),
        }
    }
    Err(Error::input("leads in a circle of links; give another name").in_file(path))
}

/// Whether an error says that nothing is there.
fn is_nothing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory)
}

/// Where an output goes.
fn target(path: &Path) -> Result<Target> {
    let refuse = |what: &str| Err(Error::input(what).in_file(path));
    if path.as_os_str().is_empty() {
        return refuse("an output needs a name; give one");
    }
    if path == Path::new("-") {
        return refuse("outputs are files and have names; give one, or /dev/stdout");
    }
    let end = behind_links(path)?;
    let folder = folder_of(&end);
    match fs::metadata(&end) {
        Ok(metadata) if metadata.is_dir() => refuse("is a folder; give a file name"),
        Ok(_) if is_inside_store(path) => refuse("lies inside a campaign store; give a name elsewhere"),
        Ok(_) if is_descriptor(&end) => Ok(Target::Stream),
        Ok(metadata) if metadata.is_file() => {
            if metadata.permissions().readonly() {
                return refuse("is write-protected; give another name, or make it writable");
            }
            // The folder's permission alone would do for a rename.
            File::options().write(true).open(&end).map_err(|e| failure(path, "cannot be written", &e))?;
            Ok(Target::File(end))
        }
        Ok(metadata) if is_pipe_or_device(&metadata) => Ok(Target::Stream),
        Ok(_) => refuse("is no file, and nothing takes its place; give another name"),
        Err(error) if !is_nothing(&error) => Err(failure(path, "cannot be written", &error)),
        Err(_) if !folder.is_dir() => refuse(&format!("the folder {} does not exist", folder.display())),
        Err(_) if end.as_os_str().to_string_lossy().ends_with(std::path::is_separator) => {
            refuse("is the name of a folder; give a file name")
        }
        Err(_) if is_inside_store(path) => refuse("lies inside a campaign store; give a name elsewhere"),
        Err(_) => Ok(Target::File(end)),
    }
}

#[cfg(unix)]
fn is_pipe_or_device(metadata: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    metadata.file_type().is_char_device() || metadata.file_type().is_fifo()
}

#[cfg(not(unix))]
fn is_pipe_or_device(_: &Metadata) -> bool {
    false
}

/// An empty temporary file in the folder of `file`, locked; those of killed runs are deleted first.
fn temporary_beside(file: &Path) -> io::Result<NamedTempFile> {
    let folder = folder_of(file);
    sweep(folder, |name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
    let temporary = names(&mut shared(false)).tempfile_in(folder)?;
    // Without locks age protects it.
    let _ = temporary.as_file().try_lock();
    Ok(temporary)
}

fn names<'b>(
    builder: &'b mut tempfile::Builder<'static, 'static>,
) -> &'b mut tempfile::Builder<'static, 'static> {
    builder.prefix(PREFIX).suffix(SUFFIX).rand_bytes(12)
}

/// One file on its way.
struct Output<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    target: Target,
    /// Its bytes under a temporary name.
    aside: Option<NamedTempFile>,
    /// A second name of what it replaces.
    before: Option<NamedTempFile<()>>,
}

impl<'a> Output<'a> {
    /// Writes the bytes aside, where they can be.
    fn prepared(path: &'a Path, bytes: &'a [u8]) -> Result<Self> {
        let target = target(path)?;
        begin_output(path)?;
        let mut output = Self { path, bytes, target, aside: None, before: None };
        if let Target::File(file) = &output.target {
            let aside = again(|| aside(file, bytes)).map_err(|e| failure(path, "cannot be written", &e))?;
            output.aside = Some(aside);
        }
        Ok(output)
    }

    /// Gives the bytes their name; with `keep` what was there can come back.
    fn appear(&mut self, keep: bool) -> io::Result<()> {
        let Target::File(file) = &self.target else { return through(self.path, self.bytes) };
        if keep && file.exists() {
            let second_name = |name: &Path| fs::hard_link(file, name);
            self.before = names(&mut shared(false)).make_in(folder_of(file), second_name).ok();
        }
        again(|| {
            let aside = self.aside.take().map_or_else(|| aside(file, self.bytes), Ok)?;
            aside.persist(file).map(|_| ()).map_err(|e| e.error)
        })
    }

    /// Undoes [`Self::appear`], as far as the file system lets it.
    fn vanish(&mut self) {
        let Target::File(file) = &self.target else { return };
        let _ = match self.before.take() {
            Some(before) => before.persist(file).map(|_| ()).map_err(|e| e.error),
            None => fs::remove_file(file),
        };
    }
}

/// Bytes in a synced temporary file that looks as `file` does.
fn aside(file: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    let mut temporary = temporary_beside(file)?;
    temporary.write_all(bytes)?;
    if let Ok(metadata) = fs::metadata(file) {
        like(temporary.as_file(), &metadata)?;
    }
    temporary.as_file().sync_all()?;
    Ok(temporary)
}

/// Gives a new file the permissions and, where this user may, the owner of the one that it replaces.
fn like(file: &File, before: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt as _, fchown};
        let _ = fchown(file, Some(before.uid()), Some(before.gid()));
    }
    file.set_permissions(before.permissions())
}

/// Writes to a pipe or a device. A reader that has seen enough is no failure.
fn through(path: &Path, bytes: &[u8]) -> io::Result<()> {
    match File::options().append(true).open(path).and_then(|mut file| file.write_all(bytes)) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        done => done,
    }
}

#[cfg(test)]
mod tests;
