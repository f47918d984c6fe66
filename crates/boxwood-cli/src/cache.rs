//! `--cache`: a folder in which wide trees lie from one run to the next.
//!
//! *How it works.* Names and contents are the library's ([`Shelf`]); here are the files. They are written beside their place and
//! renamed, so that commands running at the same time never see half of one. Whatever goes wrong with the folder is a note on stderr,
//! and the trees are built.

use crate::args::CacheArgs;
use crate::failure::{Failure, Outcome};
use crate::output::write_whole;
use crate::terminal;
use boxwood::StructureKind;
use boxwood_render::Shelf;
use serde::Serialize;
use std::env;
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

/// A folder with saved trees, and how often it was of use.
#[derive(Debug)]
pub struct Cache {
    folder: PathBuf,
    found: AtomicU32,
    refused: AtomicU32,
    kept: AtomicU32,
    /// Whether a failure to write was said: one is enough.
    complained: AtomicBool,
}

/// What reports say of it.
#[derive(Serialize)]
pub struct CacheUse {
    folder: String,
    /// Trees that were read instead of built.
    loaded: u32,
    /// Trees that were built, and kept.
    kept: u32,
}

/// Tells programs that make backups that they may pass the folder over; see <https://bford.info/cachedir/>.
const TAG: &str = "Signature: 8a477f597d28d172789f06886806bc55\n\
    # This folder holds trees that boxwood keeps from one run to the next. It may be emptied at any time.\n";

impl Cache {
    /// The cache that the command line asks for, if any.
    pub fn open(args: &CacheArgs, kind: StructureKind) -> Outcome<Option<Arc<Self>>> {
        let Some(folder) = &args.cache else {
            return Ok(None);
        };
        if !matches!(kind, StructureKind::Wide8(_) | StructureKind::Wide16(_)) {
            let name = kind.name();
            terminal::note(format_args!(
                "only wide8 and wide16 are kept in the cache; {name} is built"
            ));
        }
        let folder = if folder.as_os_str().is_empty() {
            usual_folder().ok_or_else(|| {
                Failure::new("the user has no folder for caches; name one with --cache=DIR")
            })?
        } else {
            folder.clone()
        };
        Ok(Some(Arc::new(Self {
            folder,
            found: AtomicU32::new(0),
            refused: AtomicU32::new(0),
            kept: AtomicU32::new(0),
            complained: AtomicBool::new(false),
        })))
    }

    /// What reports say: `null` without a cache.
    pub fn use_of(cache: Option<&Self>) -> Option<CacheUse> {
        cache.map(|cache| CacheUse {
            folder: cache.folder.display().to_string(),
            loaded: cache.found.load(Relaxed) - cache.refused.load(Relaxed),
            kept: cache.kept.load(Relaxed),
        })
    }

    fn write(&self, name: &str, save: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> Outcome {
        if !self.folder.is_dir() {
            fs::create_dir_all(&self.folder).map_err(|e| {
                Failure::file(&self.folder, format_args!("cannot be made a folder: {e}"))
            })?;
            write_whole(&self.folder.join("CACHEDIR.TAG"), |file| {
                file.write_all(TAG.as_bytes())
            })?;
        }
        write_whole(&self.folder.join(name), |file| save(file))
    }
}

impl CacheUse {
    /// What tables say before and after a structure's name: how it came about.
    pub fn said(cache: Option<&Self>) -> (&'static str, &'static str) {
        match cache.map_or((0, 0), |cache| (cache.loaded, cache.kept)) {
            (0, 0) => ("built", ""),
            (0, _) => ("built", " and kept it"),
            (_, 0) => ("took", " from the cache"),
            _ => ("built", " partly from the cache"),
        }
    }
}

impl Shelf for Cache {
    fn find(&self, name: &str) -> Option<(u64, Box<dyn Read + '_>)> {
        let file = File::open(self.folder.join(name)).ok()?;
        let about = file.metadata().ok().filter(|about| about.is_file())?;
        self.found.fetch_add(1, Relaxed);
        Some((about.len(), Box::new(file)))
    }

    fn refuse(&self, name: &str, why: &dyn Display) {
        self.refused.fetch_add(1, Relaxed);
        let path = self.folder.join(name);
        terminal::note(format_args!("{}: {why}; built anew", path.display()));
    }

    fn keep(&self, name: &str, save: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) {
        match self.write(name, save) {
            Ok(()) => {
                self.kept.fetch_add(1, Relaxed);
            }
            Err(Failure::Said(sentence)) if !self.complained.swap(true, Relaxed) => {
                terminal::note(format_args!("the tree is not kept: {sentence}"));
            }
            Err(_) => {}
        }
    }
}

/// Where caches belong on this system; `None` where the environment does not say.
fn usual_folder() -> Option<PathBuf> {
    let named = |variable: &str| {
        env::var_os(variable)
            .map(PathBuf::from)
            // As the specification of XDG asks for.
            .filter(|path| path.is_absolute())
    };
    let inside = |folder: &str| named("HOME").map(|home| home.join(folder));
    let caches = named("XDG_CACHE_HOME").or_else(|| {
        if cfg!(windows) {
            named("LOCALAPPDATA")
        } else if cfg!(target_os = "macos") {
            inside("Library/Caches")
        } else {
            inside(".cache")
        }
    });
    caches.map(|caches| caches.join(Path::new("boxwood")))
}
