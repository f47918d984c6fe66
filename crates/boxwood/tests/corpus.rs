//! What fuzzing starts from and has found, replayed: every structure agrees with the judge on every case, and so does every saved tree
//! that can be opened.

use boxwood_testkit::{agreement, bytes, forged};
use std::path::{Path, PathBuf};

/// The files of a target, with their contents; none in a packaged crate, which comes without the workspace around it.
fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    let folder = folder.join(target);
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("skipped: {} is not there", folder.display());
        return Vec::new();
    };
    let read = |path: PathBuf| {
        let bytes = std::fs::read(&path).expect("a readable file");
        (path, bytes)
    };
    let paths = entries.map(|entry| entry.expect("a readable folder").path());
    let files: Vec<_> = paths.map(read).collect();
    assert!(files.len() >= 5, "{} files", files.len());
    files
}

#[test]
fn structures_agree_on_the_corpus() {
    let mut hits = 0;
    let files = corpus("structures");
    for (path, bytes) in &files {
        let (mesh, rays) = bytes::case(bytes);
        hits += agreement::check(&mesh, &rays, &path.display().to_string()).hits;
    }
    assert!(files.is_empty() || hits > 0);
}

#[test]
fn saved_trees_of_the_corpus_are_errors_or_harmless() {
    for (path, bytes) in corpus("bxw") {
        let opened = forged::check(&bytes, &path.display().to_string());
        let name = path.file_name().and_then(|name| name.to_str());
        // Those whose names say so are expected to open.
        if name.is_some_and(|name| name.starts_with("opens-")) {
            assert!(opened, "{}", path.display());
        }
    }
}
