//! `boxwood render`.

use crate::bench::{Bench, LAYERS, said};
use std::fs;

/// Small and quick.
const QUICK: &str = "--size 32x18 --spp 1 --threads 1";

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("layers.obj", LAYERS);
    bench
}

/// Width, height and colour type of a PNG.
fn header(png: &[u8]) -> (u32, u32, u8) {
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"), "no PNG");
    let number = |at: usize| u32::from_be_bytes([png[at], png[at + 1], png[at + 2], png[at + 3]]);
    (number(16), number(20), png[25])
}

#[test]
fn without_a_scene_it_makes_the_built_in_picture() {
    let bench = Bench::new();
    let text = bench.good(&format!("render {QUICK}"));
    assert!(
        text.contains("wrote   teapot-in-stadium.png (32x18, shaded, 1 sample, "),
        "{text}"
    );
    assert_eq!(bench.files(), ["teapot-in-stadium.png"]);
    assert_eq!(header(&bench.read("teapot-in-stadium.png")), (32, 18, 2));
}

#[test]
fn the_report_is_json_and_the_name_is_the_scenes() {
    let bench = bench();
    let report = bench.json(&format!("render layers.obj {QUICK} --json"));
    assert_eq!(bench.files(), ["layers.obj", "layers.png"]);
    assert_eq!(report["output"], "layers.png");
    assert_eq!(
        (&report["width"], &report["height"]),
        (&32.into(), &18.into())
    );
    assert_eq!((&report["threads"], &report["spp"]), (&1.into(), &1.into()));
    assert_eq!(report["bytes"], bench.read("layers.png").len());
    assert_eq!(report["camera"], serde_json::Value::Null);
}

#[test]
fn pictures_do_not_depend_on_threads_or_structure() {
    let bench = bench();
    let make = |name: &str, words: &str| {
        bench.good(&format!(
            "render layers.obj --size 40x30 --spp 2 -o {name} {words}"
        ));
        bench.read(name)
    };
    let first = make("a.png", "--threads 1");
    assert!(first == make("b.png", "--threads 2 --accel bvh:median"));
    assert!(make("a.exr", "--threads 1") == make("b.exr", "--threads 2"));
}

#[test]
fn every_view_and_flag_changes_the_picture() {
    let bench = bench();
    let mut seen = vec![];
    for words in [
        "",
        "--view normals",
        "--view depth",
        "--view primitives",
        "--view materials",
        "--view albedo",
        "--view cost",
        "--exposure -2",
        "--exposure 1",
        "--transparent",
        "--eye 0.3 0.3 4",
        "--eye -0.3,0.3,-4",
        "--eye 0.3,0.3,4 --look-at 0,0,0",
        "--eye 0.3,0.3,4 --fov 20",
        "--eye 0.3,0.3,4 --up 1 0 0",
        "--fov 80",
        "--up 0,0,-1",
        "--spp 4",
        "--size 18x32",
    ] {
        let quick = if words.starts_with("--s") { "" } else { QUICK };
        bench.good(&format!("render layers.obj {quick} {words} -o picture.png"));
        let picture = bench.read("picture.png");
        assert!(!seen.contains(&picture), "{words} changes nothing");
        seen.push(picture);
    }
}

#[test]
fn cameras_have_names() {
    let bench = bench();
    let make = |words: &str| {
        bench.json(&format!(
            "render teapot-in-stadium {QUICK} --json -o a.png {words}"
        ))
    };
    assert_eq!(make("")["camera"], "main");
    let main = bench.read("a.png");
    assert_eq!(make("--camera overview")["camera"], "overview");
    assert!(bench.read("a.png") != main);
    assert_eq!(make("--fov 30")["camera"], "main");
    assert!(bench.read("a.png") != main);
    assert_eq!(make("--camera overview --fov 30")["camera"], "overview");
    assert_eq!(
        bench.refused("render teapot-in-stadium --camera side -o a.png"),
        "teapot-in-stadium: no camera is called `side`; there are main, overview"
    );
    assert_eq!(
        bench.refused("render layers.obj --camera side -o a.png"),
        "layers.obj: has no cameras of its own, so none is called `side`"
    );
}

#[test]
fn a_pipe_gets_the_picture_and_stderr_the_report() {
    let bench = bench();
    bench.good(&format!("render layers.obj {QUICK}"));
    let output = bench
        .command(&format!("render layers.obj {QUICK} -o -"))
        .output()
        .expect("it runs");
    assert!(output.status.success());
    assert!(output.stdout == bench.read("layers.png"));
    assert!(String::from_utf8_lossy(&output.stderr).contains("wrote   standard output"));
}

#[test]
fn what_cannot_work_fails_before_the_work() {
    let bench = bench();
    bench.write("mine.png", "mine");
    // The header of an image of 2 x 1 pixels without any of them.
    let head = *b"BM\x36\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x02\0\0\0\x01\0\0\0\x01\0\x18";
    let mut sky = head.to_vec();
    sky.resize(54, 0);
    bench.write("sky.png", sky);
    fs::create_dir(bench.path("folder.png")).expect("a folder");
    for (words, sentence) in [
        (
            "layers.obj -o a.jpg",
            "a.jpg: a picture's name must end in .png or .exr",
        ),
        (
            "layers.obj -o picture",
            "picture: a picture's name must end in .png or .exr",
        ),
        (
            "layers.obj -o absent/a.png",
            "absent/a.png: cannot be written: there is no folder absent",
        ),
        (
            "layers.obj -o folder.png",
            "folder.png: cannot be written: it is a folder",
        ),
        (
            "layers.obj -o a.exr --exposure 1",
            "a.exr: an EXR keeps light as it is; --exposure is for PNG",
        ),
        (
            "layers.obj -o a.exr --transparent",
            "a.exr: an EXR always has an alpha channel; --transparent is for PNG",
        ),
        (
            "layers.obj --environment sky.png -o a.png",
            "the environment cannot be read: sky.png",
        ),
        (
            "layers.obj --environment sky.png -o sky.png",
            "sky.png: cannot be written: it is what is to be read",
        ),
        (
            "layers.obj --environment sky.hdr",
            "sky.hdr: cannot be read: ",
        ),
        ("layers.obj --environment layers.obj", "layers.obj: "),
        (
            "layers.obj --eye 0.5,0.5,1 --look-at 0.5,0.5,1",
            "the camera at ",
        ),
        ("layers.obj --up 0,0,0", "--up 0,0,0 gives no direction"),
        (
            "absent.obj -o mine.png",
            "absent.obj: there is no such file",
        ),
        // Whatever the scene is, the place of the picture is looked at first.
        (
            "absent.obj -o absent/a.png",
            "absent/a.png: cannot be written: ",
        ),
    ] {
        let error = bench.refused(&format!("render {words}"));
        assert!(error.starts_with(sentence), "{error}");
    }
    assert_eq!(bench.read("mine.png"), b"mine");
    assert_eq!(
        bench.files(),
        ["folder.png", "layers.obj", "mine.png", "sky.png"]
    );
}

#[test]
fn nonsense_is_a_usage_error() {
    let bench = bench();
    for (words, sentence) in [
        ("--size 0x5", "without pixels"),
        ("--size 99999x5", "too large"),
        ("--size big", "such as 1280x720"),
        ("--spp 0", "0 is not in 1..=65536"),
        ("--fov 180", "between 0 and 180 degrees"),
        ("--eye 1,2", "expected three numbers"),
        ("--look-at 1,2,3", "--eye"),
        ("--camera a --eye 1,2,3", "cannot be used with"),
        ("--view xray", "possible values: shaded, normals"),
        ("--accel tree", "no structure is called `tree`"),
        ("--exposure bright", "number of stops"),
        ("--paint", "unexpected argument"),
    ] {
        let error = bench.misused(&format!("render layers.obj {words}"));
        assert!(error.contains(sentence), "{error}");
    }
}

#[test]
fn warnings_are_few_and_no_failure() {
    let bench = bench();
    bench.write("layers.obj", format!("mtllib absent.mtl\n{LAYERS}"));
    let said = said(
        bench
            .command(&format!("render layers.obj {QUICK}"))
            .output()
            .expect("it runs"),
    );
    assert_eq!(said.code, Some(0));
    assert!(said.err.starts_with("warning: layers.obj"), "{}", said.err);
    assert_eq!(said.err.lines().count(), 1);
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    use std::os::unix::process::ExitStatusExt;
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    #[test]
    fn ctrl_c_ends_at_once_and_leaves_everything_as_it_was() {
        let bench = bench();
        bench.write("mine.png", "mine");
        let mut command =
            bench.command("render layers.obj --size 4000x4000 --spp 4096 -o mine.png");
        let mut child = command
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it runs");
        std::thread::sleep(Duration::from_millis(700));
        let start = Instant::now();
        let kill = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(kill.expect("kill").success());
        let status = child.wait().expect("it ends");
        // By the signal itself, which a shell shows as 130.
        assert_eq!(status.signal(), Some(2));
        assert!(start.elapsed() < Duration::from_secs(2));
        assert_eq!(bench.read("mine.png"), b"mine");
        assert_eq!(bench.files(), ["layers.obj", "mine.png"]);
    }

    #[test]
    fn links_and_permissions_are_kept_and_devices_are_not_replaced() {
        let bench = bench();
        fs::create_dir(bench.path("store")).expect("a folder");
        let real = bench.write("store/real.png", "old");
        fs::set_permissions(&real, PermissionsExt::from_mode(0o640)).expect("permissions");
        symlink("store/real.png", bench.path("link.png")).expect("a link");
        bench.good(&format!("render layers.obj {QUICK} -o link.png"));
        assert!(
            fs::symlink_metadata(bench.path("link.png"))
                .expect("a link")
                .is_symlink()
        );
        assert_eq!(header(&fs::read(&real).expect("a file")).0, 32);
        assert_eq!(
            fs::metadata(&real).expect("a file").permissions().mode() & 0o777,
            0o640
        );

        symlink("/dev/null", bench.path("null.png")).expect("a link");
        bench.good(&format!("render layers.obj {QUICK} -o null.png"));
        assert!(
            fs::metadata("/dev/null")
                .expect("a device")
                .file_type()
                .is_char_device()
        );

        fs::set_permissions(&real, PermissionsExt::from_mode(0o440)).expect("permissions");
        let error = bench.refused(&format!("render layers.obj {QUICK} -o link.png"));
        assert_eq!(error, "link.png: cannot be written: it is read-only");
    }
}
