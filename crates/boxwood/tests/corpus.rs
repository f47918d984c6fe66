//! What fuzzing starts from and has found, replayed: every structure agrees with the judge on every case.

use boxwood_testkit::{agreement, bytes};
use std::path::Path;

#[test]
fn structures_agree_on_the_corpus() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/structures");
    // A packaged crate comes without the workspace around it.
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("skipped: {} is not there", folder.display());
        return;
    };
    let (mut files, mut hits) = (0, 0);
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        let (mesh, rays) = bytes::case(&std::fs::read(&path).expect("a readable file"));
        hits += agreement::check(&mesh, &rays, &path.display().to_string()).hits;
        files += 1;
    }
    assert!(files >= 5 && hits > 0, "{files} files, {hits} hits");
}
