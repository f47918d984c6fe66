//! What fuzzing starts from and has found, replayed: every input ends in a scene or in a sentence.

use boxwood_scene::{Format, NoFiles, Scene, Source};
use std::path::Path;

fn replay(target: &str, format: Format) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../fuzz/corpus")
        .join(target);
    // A packaged crate comes without the workspace around it.
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("skipped: {} is not there", folder.display());
        return;
    };
    let mut files = 0;
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        let bytes = std::fs::read(&path).expect("a readable file");
        let source = Source {
            name: "corpus",
            files: &NoFiles,
        };
        // The whole file, and cut off everywhere: what is missing must not be read.
        for end in 0..=bytes.len() {
            match Scene::from_bytes(format, &bytes[..end], source) {
                Ok(scene) => {
                    let _ = scene.flatten();
                }
                Err(error) => {
                    let sentence = error.to_string();
                    let clear = sentence.contains("corpus") && !sentence.contains('\n');
                    assert!(clear, "{}, cut at {end}: {sentence}", path.display());
                }
            }
        }
        files += 1;
    }
    assert!(files >= 4, "only {files} files in {}", folder.display());
}

#[test]
fn obj() {
    replay("obj", Format::Obj);
}

#[test]
fn ply() {
    replay("ply", Format::Ply);
}

#[test]
fn stl() {
    replay("stl", Format::Stl);
}

#[test]
fn gltf() {
    replay("gltf", Format::Gltf);
}
