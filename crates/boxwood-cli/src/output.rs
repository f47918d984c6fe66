//! Files out: written beside their place, then renamed, so that nobody ever sees half a file.
//!
//! *How it works.* [`Destination::check`] finds out before any work whether the file will be writable, by making and
//! removing a temporary file in its folder. [`write_whole`] makes one again, fills it and renames it over the
//! destination. Ctrl-C (and SIGTERM) removes the temporary file before the program ends, so that an interrupted command
//! leaves the folder as it was. On systems without such signals the temporary file can stay behind when the command is
//! ended within the moment of writing.

use crate::failure::{Failure, Outcome};
use crate::terminal;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::{NamedTempFile, TempPath};

/// The temporary file that now exists, for the thread that waits for signals. Whoever makes, renames or removes it holds
/// the lock.
static TEMPORARY: Mutex<Option<PathBuf>> = Mutex::new(None);

fn temporary() -> MutexGuard<'static, Option<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where a verb's file goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// `-`
    Stdout,
    /// A path.
    File(PathBuf),
}

impl Destination {
    /// Reads `-o`'s value.
    pub fn new(path: &Path) -> Self {
        if path == Path::new("-") {
            Self::Stdout
        } else {
            Self::File(path.to_path_buf())
        }
    }

    /// Where a report goes when the file goes here.
    pub fn report(&self) -> terminal::Channel {
        match self {
            Self::Stdout => terminal::Channel::Stderr,
            Self::File(_) => terminal::Channel::Stdout,
        }
    }

    /// Fails when writing would fail, as far as one can know beforehand, or would replace one of the `inputs`. Touches no
    /// existing file.
    pub fn check<'a>(&self, inputs: impl IntoIterator<Item = &'a Path>) -> Outcome {
        let path = match self {
            Self::Stdout if io::stdout().is_terminal() => {
                return Err(Failure::new(
                    "standard output is a terminal; send it to a file or a pipe, or name a file with -o",
                ));
            }
            Self::Stdout => return Ok(()),
            Self::File(path) => path,
        };
        let target = Target::of(path)?;
        if target.existing.is_some() {
            let replaced = |input: &Path| fs::canonicalize(input).is_ok_and(|i| i == target.path);
            if inputs.into_iter().any(replaced) {
                return Err(Failure::file(
                    path,
                    "cannot be written: it is what is to be read",
                ));
            }
        }
        if let Some(folder) = target.folder() {
            stop_cleanly()?;
            drop(Temporary::new(folder).map_err(|e| Failure::file(path, cannot(folder, &e)))?);
        }
        Ok(())
    }

    /// Writes the whole file, or nothing.
    pub fn write(&self, bytes: &[u8]) -> Outcome {
        match self {
            Self::Stdout => terminal::pour(bytes),
            Self::File(path) => write_whole(path, |file| file.write_all(bytes)),
        }
    }
}

/// Writes the whole file that `fill` makes, or nothing.
pub fn write_whole(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Outcome {
    let failed = |e: io::Error| Failure::file(path, format_args!("cannot be written: {e}"));
    let target = Target::of(path)?;
    let Some(folder) = target.folder() else {
        let opened = OpenOptions::new().write(true).truncate(true).open(path);
        return opened.and_then(|mut file| fill(&mut file)).map_err(failed);
    };
    stop_cleanly()?;
    let mut file = Temporary::new(folder).map_err(failed)?;
    file.fill(fill).map_err(failed)?;
    file.rename(&target).map_err(failed)
}

/// Says why no file can be made in a folder.
fn cannot(folder: &Path, error: &io::Error) -> String {
    let name = folder.display();
    match error.kind() {
        io::ErrorKind::NotFound => format!("cannot be written: there is no folder {name}"),
        io::ErrorKind::NotADirectory => format!("cannot be written: {name} is not a folder"),
        _ => format!("cannot be written: no file can be made in {name}: {error}"),
    }
}

/// What is at the destination now.
struct Target {
    /// With symbolic links followed, so that a rename replaces the file and not the link to it.
    path: PathBuf,
    existing: Option<Metadata>,
}

impl Target {
    fn of(path: &Path) -> Outcome<Self> {
        let existing = match fs::metadata(path) {
            Ok(existing) => existing,
            Err(_) => {
                return Ok(Self {
                    path: path.to_path_buf(),
                    existing: None,
                });
            }
        };
        if existing.is_dir() {
            return Err(Failure::file(path, "cannot be written: it is a folder"));
        }
        if existing.permissions().readonly() {
            return Err(Failure::file(path, "cannot be written: it is read-only"));
        }
        Ok(Self {
            path: fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()),
            existing: Some(existing),
        })
    }

    /// Where a temporary file belongs; `None` for a device or a pipe, which is written and never replaced.
    fn folder(&self) -> Option<&Path> {
        if self.existing.as_ref().is_some_and(|m| !m.is_file()) {
            return None;
        }
        match self.path.parent() {
            None => Some(Path::new(".")),
            Some(parent) if parent.as_os_str().is_empty() => Some(Path::new(".")),
            parent => parent,
        }
    }
}

/// A temporary file, removed when dropped and when a signal ends the program.
struct Temporary(Option<NamedTempFile>);

impl Temporary {
    fn new(folder: &Path) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".boxwood-").suffix(".tmp");
        // Temporary files are private by default; this one becomes an ordinary file, under the user's umask.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut pending = temporary();
        let file = builder.tempfile_in(folder)?;
        *pending = Some(file.path().to_path_buf());
        Ok(Self(Some(file)))
    }

    fn fill(&mut self, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
        match &mut self.0 {
            Some(file) => fill(file.as_file_mut()),
            None => Ok(()),
        }
    }

    fn rename(mut self, target: &Target) -> io::Result<()> {
        let Some(file) = self.0.take() else {
            return Ok(());
        };
        if let Some(existing) = &target.existing {
            // A failure to keep the old permissions is no reason to lose the picture.
            let _ = file.as_file().set_permissions(existing.permissions());
        }
        let file: TempPath = file.into_temp_path();
        let mut pending = temporary();
        let renamed = file.persist(&target.path);
        *pending = None;
        renamed.map_err(|e| e.error)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(file) = self.0.take() {
            let mut pending = temporary();
            drop(file);
            *pending = None;
        }
    }
}

/// From now on, signals that end the program remove the temporary file first. Then the program ends by that very signal,
/// at once, whatever it was doing; a shell sees the usual code (130 for Ctrl-C).
#[cfg(unix)]
fn stop_cleanly() -> Outcome {
    // Not SIGHUP: `nohup` has it ignored, and a handler would undo that.
    use signal_hook::consts::{SIGINT, SIGTERM};
    use std::sync::Once;

    static ONCE: Once = Once::new();
    let mut outcome = Ok(());
    ONCE.call_once(
        || match signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) {
            Err(e) => outcome = Err(e),
            Ok(mut signals) => {
                std::thread::spawn(move || {
                    for signal in signals.forever() {
                        // Held to the end: nobody makes another one.
                        let pending = temporary();
                        if let Some(path) = &*pending {
                            let _ = fs::remove_file(path);
                        }
                        let _ = signal_hook::low_level::emulate_default_handler(signal);
                    }
                });
            }
        },
    );
    outcome.map_err(|e| Failure::new(format!("signals cannot be watched: {e}")))
}

#[cfg(not(unix))]
fn stop_cleanly() -> Outcome {
    Ok(())
}
