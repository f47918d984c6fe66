//! A folder to work in, and the command run in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// Two triangles that face +z at z = 0 and z = −1, and a third of zero area.
pub const LAYERS: &str = "\
v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 -1\nv 1 0 -1\nv 0 1 -1\nv 2 2 2
f 1 2 3\nf 4 5 6\nf 7 7 7\n";

/// A folder of its own, removed in the end.
pub struct Bench(TempDir);

/// What a run said.
pub struct Said {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Bench {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        fs::write(self.path(name), bytes).expect("a file");
        self.path(name)
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect("a file")
    }

    /// The names of all files in the folder, hidden ones too.
    pub fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("a folder");
        let name = |e: std::io::Result<fs::DirEntry>| e.expect("an entry").file_name();
        let mut names: Vec<_> = entries
            .map(|e| name(e).to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// The command with words that blanks divide, in the folder, away from any terminal.
    pub fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_boxwood"));
        command
            .args(words.split_whitespace())
            .current_dir(self.0.path())
            .stdin(Stdio::null())
            .env_remove("CLICOLOR_FORCE");
        command
    }

    pub fn run(&self, words: &str) -> Said {
        said(self.command(words).output().expect("it runs"))
    }

    /// A run that must go well and say nothing on stderr; its stdout.
    pub fn good(&self, words: &str) -> String {
        let said = self.run(words);
        assert_eq!(
            (said.code, said.err.as_str()),
            (Some(0), ""),
            "boxwood {words}"
        );
        said.out
    }

    /// A run that must fail with exit code 1 and one line on stderr; that line.
    pub fn refused(&self, words: &str) -> String {
        let said = self.run(words);
        assert_eq!(
            (said.code, said.out.as_str()),
            (Some(1), ""),
            "boxwood {words}: {}",
            said.err
        );
        let line = said.err.strip_suffix('\n').expect("a whole line");
        assert!(!line.contains('\n') && !line.contains('\u{1b}'), "{line}");
        line.strip_prefix("error: ").expect("an error").to_string()
    }

    /// A run that must end as a usage error; its stderr.
    pub fn misused(&self, words: &str) -> String {
        let said = self.run(words);
        assert_eq!(
            (said.code, said.out.as_str()),
            (Some(2), ""),
            "boxwood {words}: {}",
            said.err
        );
        said.err
    }

    pub fn json(&self, words: &str) -> serde_json::Value {
        serde_json::from_str(&self.good(words)).expect("JSON")
    }
}

pub fn said(output: Output) -> Said {
    Said {
        code: output.status.code(),
        out: String::from_utf8(output.stdout).expect("text"),
        err: String::from_utf8(output.stderr).expect("text"),
    }
}

/// Whether a text is one well-formed SVG: every element is closed, in order, and nothing stands outside. Attributes hold
/// neither `<` nor `>`, because all that is said is escaped.
pub fn is_svg(text: &str) -> bool {
    let mut open = Vec::new();
    let mut seen = 0;
    for tag in text.split('<').skip(1) {
        let Some((tag, _)) = tag.split_once('>') else {
            return false;
        };
        // The first part holds the element's name, too.
        let parts = tag.split('"').step_by(2);
        let mut attributes: Vec<&str> = parts
            .filter_map(|part| part.split_whitespace().last()?.strip_suffix('='))
            .collect();
        let count = attributes.len();
        attributes.sort_unstable();
        attributes.dedup();
        if attributes.len() < count {
            return false;
        }
        let name = |tag: &str| tag.split_whitespace().next().unwrap_or("").to_string();
        if let Some(closed) = tag.strip_prefix('/') {
            if open.pop() != Some(closed.to_string()) {
                return false;
            }
        } else if !tag.ends_with('/') {
            if open.is_empty() && (seen > 0 || name(tag) != "svg") {
                return false;
            }
            open.push(name(tag));
        }
        seen += 1;
    }
    open.is_empty() && seen > 1 && !text.contains("NaN") && !text.contains("inf\"")
}

/// The folder of real scenes, where the machine has one.
pub fn scenes() -> Option<PathBuf> {
    let folder = std::env::var_os("BOXWOOD_SCENES");
    if folder.is_none() {
        eprintln!("skipped: BOXWOOD_SCENES names no folder of scenes");
    }
    folder.map(|f| Path::new(&f).to_path_buf())
}
