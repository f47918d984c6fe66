//! Pictures that must stay the same, pixel for pixel.
//!
//! `BOXWOOD_BLESS=1 cargo test -p boxwood-render --test golden` writes them anew. A failure leaves the new picture and the
//! difference in `target/golden/`.

mod scenes;

use boxwood_render::{Options, PngOptions, Renderer, Setup, View, camera};
use std::fs;
use std::path::{Path, PathBuf};

fn render(view: View) -> Vec<u8> {
    let renderer = Renderer::new(&scenes::still_life(), &Setup::default()).expect("a good scene");
    assert!(renderer.warnings().is_empty(), "{:?}", renderer.warnings());
    let eye =
        camera::look_at([0.6, 2.0, 5.0], [0.0, 0.7, 0.0], [0.0, 1.0, 0.0], 0.7).expect("a camera");
    let options = Options {
        size: [96, 54],
        spp: 4,
        view,
        ..Options::default()
    };
    let film = renderer.render(&eye, &options, &|_, _| ());
    let options = PngOptions {
        view,
        ..PngOptions::default()
    };
    film.png(&options).expect("a PNG")
}

fn decode(bytes: &[u8]) -> Vec<u8> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a small image")];
    reader.next_frame(&mut pixels).expect("pixels");
    pixels
}

fn encode(pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 96, 54);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(pixels).expect("pixels");
    writer.finish().expect("an end");
    bytes
}

fn hold(view: View) {
    let found = render(view);
    let name = format!("{view}.png");
    let golden = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden")
        .join(&name);
    if std::env::var_os("BOXWOOD_BLESS").is_some() {
        fs::create_dir_all(golden.parent().expect("a folder")).expect("the folder can be made");
        fs::write(&golden, found).expect("the picture can be written");
        return;
    }
    let wanted = decode(&fs::read(&golden).expect("the golden picture is there"));
    let pixels = decode(&found);
    if wanted == pixels {
        return;
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).with_file_name("golden");
    fs::create_dir_all(&folder).expect("the folder can be made");
    fs::write(folder.join(&name), &found).expect("the picture can be written");
    let apart = wanted
        .iter()
        .zip(&pixels)
        .map(|(a, b)| a.abs_diff(*b).saturating_mul(8));
    let apart = encode(&apart.collect::<Vec<u8>>());
    fs::write(folder.join(format!("{view}-difference.png")), apart)
        .expect("the picture can be written");
    let count = wanted
        .chunks(3)
        .zip(pixels.chunks(3))
        .filter(|(a, b)| a != b)
        .count();
    panic!(
        "{view}: {count} pixels differ from the golden picture; see {}",
        folder.display()
    );
}

#[test]
fn shaded() {
    hold(View::Shaded);
}
#[test]
fn normals() {
    hold(View::Normals);
}
#[test]
fn depth() {
    hold(View::Depth);
}
#[test]
fn primitives() {
    hold(View::Primitives);
}
#[test]
fn materials() {
    hold(View::Materials);
}
#[test]
fn albedo() {
    hold(View::Albedo);
}
#[test]
fn cost() {
    hold(View::Cost);
}
