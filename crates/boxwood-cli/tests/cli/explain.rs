//! `boxwood explain`.

use crate::bench::{Bench, LAYERS, is_svg};
use serde_json::Value;

const DOWN: &str = "--ray 0.2,0.2,5,0,0,-2";

#[test]
fn text_tells_the_story_and_the_answer() {
    let bench = Bench::new();
    bench.write("layers.obj", LAYERS);
    let text = bench.good(&format!(
        "explain layers.obj {DOWN} --accel bvh:binned,leaf=1"
    ));
    for part in [
        "ray        from (0.2, 0.2, 5) along (0, 0, -2), t from 0 to infinity\n",
        "   1  box 0 ",
        "  opened\n",
        "names 1 primitive\n",
        "HIT at t = 2.5: the ray now ends here\n",
        "answer     t = 2.5 at (0.2, 0.2, 0): triangle 0",
        "judge      testing every triangle gives the same bits\n",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let missed = bench.good("explain layers.obj --ray 0,0,5,0,0,1");
    assert!(
        missed.contains("behind: it ends before the ray begins"),
        "{missed}"
    );
    assert!(
        missed.contains("answer     the ray misses everything\n"),
        "{missed}"
    );
}

/// Each step by itself, and all of them together.
#[test]
fn json_is_consistent() {
    let bench = Bench::new();
    for accel in [
        "bvh:binned,leaf=1",
        "bvh:median",
        "brute",
        "bvh:binned,axes=xy",
    ] {
        let story = bench.json(&format!(
            "explain soup:500 --ray -3,0.1,0.2,1,0.02,-0.03 --accel {accel} --json"
        ));
        assert_eq!(story["judge_agrees"], true);
        let steps = story["steps"].as_array().expect("a list");
        let summary = &story["summary"];
        let number = |name: &str| summary[name].as_u64().expect("a number") as usize;
        let of_kind = |kind: &str| steps.iter().filter(|step| step["kind"] == kind).count();
        let verdict = |verdict: &str| {
            steps
                .iter()
                .filter(|step| step["verdict"] == verdict)
                .count()
        };
        assert_eq!(of_kind("box"), number("boxes"));
        assert_eq!(of_kind("test"), number("tests"));
        assert_eq!(of_kind("leaf"), number("leaves"));
        assert_eq!(verdict("opened"), number("opened"));
        assert_eq!(verdict("put aside"), number("put_aside"));
        assert_eq!(verdict("missed"), number("missed"));
        // Whatever was put aside is taken up again or dropped.
        assert_eq!(number("put_aside"), number("resumed") + number("dropped"));
        assert!(number("shortened") >= 1 && number("tests") >= 1, "{accel}");

        let float = |value: &Value| value.as_f64().unwrap_or(f64::INFINITY);
        let mut end = f64::INFINITY;
        for (i, step) in steps.iter().enumerate() {
            assert_eq!(step["step"], i + 1);
            let t_max = float(&step["t_max"]);
            assert!(t_max <= end, "the ray grows at {step}");
            let (enter, leave) = (float(&step["enter"]), float(&step["leave"]));
            match step["verdict"].as_str() {
                Some("opened" | "put aside") => assert!(enter <= leave && enter <= t_max),
                Some("missed") => assert!(enter > leave),
                Some("beyond") => assert!(enter > t_max),
                Some("behind") => assert!(leave < 0.0),
                _ => {}
            }
            if t_max < end {
                assert!(step["kind"] == "test" && step["hits"][0]["best"] == true);
            }
            end = t_max;
        }
        assert_eq!(float(&story["hit"]["t"]), end, "{accel}");
    }
}

#[test]
fn pixels_are_those_of_the_picture() {
    let bench = Bench::new();
    bench.write("layers.obj", LAYERS);
    let camera = "--eye 0.25,0.25,4 --look-at 0.25,0.25,0 --fov 30 --size 101x101";
    let story = bench.json(&format!("explain layers.obj --pixel 50,50 {camera} --json"));
    assert_eq!(story["pixel"], serde_json::json!([50, 50]));
    assert_eq!(
        story["ray"]["direction"],
        serde_json::json!([0.0, 0.0, -1.0])
    );
    assert_eq!(story["hit"]["t"], 4.0);
    assert_eq!(story["hit"]["triangle"], 0);
    let corner = bench.json(&format!("explain layers.obj --pixel 0,0 {camera} --json"));
    assert!(corner["ray"]["direction"][0].as_f64() < Some(-0.1));
    assert!(corner["ray"]["direction"][1].as_f64() > Some(0.1));
    assert_eq!(corner["hit"], Value::Null);
    assert!(
        bench
            .good("explain soup:20 --pixel 640,360")
            .contains("(pixel 640,360)")
    );
}

#[test]
fn a_film_has_a_frame_for_each_step() {
    let bench = Bench::new();
    let ray = "--ray -2,0.1,0.1,1,0,0 --accel bvh:binned,leaf=1,axes=xy";
    let steps = bench.json(&format!("explain soup:40 {ray} --json"))["steps"]
        .as_array()
        .expect("a list")
        .len();
    let frames = |words: &str| {
        bench.good(&format!("explain soup:40 {ray} --svg film.svg {words}"));
        let text = String::from_utf8(bench.read("film.svg")).expect("text");
        assert!(is_svg(&text), "{words}");
        (text.matches("<svg ").count() - 1, text)
    };
    assert_eq!(frames("").0, steps);
    assert!(steps > 7);
    let (few, text) = frames("--frames 7 --axis y");
    assert_eq!(few, 7);
    assert!(
        text.contains(&format!(
            "the first 7 of {steps} steps, --frames shows more"
        )),
        "{text}"
    );
    let said = bench.run(&format!("explain soup:40 {ray} --svg -"));
    assert!(
        is_svg(&said.out) && said.err.contains("answer "),
        "{}",
        said.err
    );
}

#[test]
fn odd_scenes_have_stories_too() {
    let bench = Bench::new();
    bench.write("none.obj", "v 0 0 0\n");
    let text = bench.good(&format!("explain none.obj {DOWN} --svg film.svg"));
    assert!(
        text.contains("0 triangles tested") && text.contains("misses everything"),
        "{text}"
    );
    assert!(is_svg(
        &String::from_utf8(bench.read("film.svg")).expect("text")
    ));
    bench.write("layers.obj", LAYERS);
    let story = bench.json("explain layers.obj --ray 1e30,0,0,-1e30,0,1e-30 --json");
    assert_eq!(story["judge_agrees"], true);
}

#[test]
fn errors_are_one_sentence() {
    let bench = Bench::new();
    assert_eq!(
        bench.refused("explain soup:9 --pixel 1280,0"),
        "pixel 1280,0 lies outside the picture of 1280x720; --size says how large it is"
    );
    for (words, part) in [
        ("explain soup:9", "--pixel"),
        (
            "explain soup:9 --pixel 1,1 --ray 0,0,0,1,0,0",
            "cannot be used with",
        ),
        ("explain soup:9 --ray 0,0,0,0,0,0", "needs a direction"),
        ("explain soup:9 --ray 1,2,3", "an origin and a direction"),
        ("explain soup:9 --pixel 1", "a column and a row"),
        ("explain soup:9 --pixel 1,1 --frames 5", "--svg"),
    ] {
        let said = bench.misused(words);
        assert!(said.contains(part), "{words}: {said}");
    }
}
