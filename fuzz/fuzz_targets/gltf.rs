//! glTF, as JSON and as GLB from any bytes: an answer or an error, never a panic.
#![no_main]

use boxwood_scene::{Format, NoFiles, Scene, Source};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let source = Source {
        name: "fuzz",
        files: &NoFiles,
    };
    if let Ok(scene) = Scene::from_bytes(Format::Gltf, data, source) {
        let _ = scene.flatten();
    }
});
