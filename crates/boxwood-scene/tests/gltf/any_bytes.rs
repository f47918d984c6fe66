//! Whatever the bytes are, reading them ends, in a scene that keeps its promises or in an error.

use crate::files::triangle;
use crate::{check_promises, read, scene};
use proptest::prelude::*;

fn seeds() -> [Vec<u8>; 2] {
    let mut file = triangle();
    let indices = file.indices(&[0, 1, 2]);
    let value = file.view(&[0; 12], "");
    let sparse = file.accessor(format!(
        r#"{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{{"count":1,"indices":{{"bufferView":1,"componentType":5123}},"values":{{"bufferView":{value}}}}}}}"#
    ));
    let rest = format!(
        r#""meshes":[{{"weights":[1],"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":{sparse}}},"indices":{indices},"mode":5,"material":0,"targets":[{{"POSITION":{sparse}}}]}}]}}],"materials":[{{"normalTexture":{{"index":0}}}}],"textures":[{{"source":0}}],"images":[{{"bufferView":{value}}}],"cameras":[{{"type":"perspective","perspective":{{"yfov":1}}}}],"nodes":[{{"children":[1]}},{{"mesh":0,"camera":0,"scale":[1,2,3]}}],"scenes":[{{"nodes":[0]}}]"#
    );
    [file.text(&rest).into_bytes(), file.glb(&rest)]
}

#[test]
fn the_seeds_are_valid() {
    for seed in seeds() {
        assert_eq!(scene(seed).triangle_count(), 1);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn changed_bytes_never_panic(
        which in 0..2_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        is_cut in prop::bool::weighted(0.1),
    ) {
        let mut bytes = seeds()[which].clone();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        if is_cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(scene) = read(&bytes) {
            check_promises(&scene);
        }
    }

    /// Numbers are where the traps are: indices, counts, offsets.
    #[test]
    fn changed_numbers_never_panic(
        which in 0..2_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), number()), 1..4),
    ) {
        let seed = seeds()[which].clone();
        let start = if which == 1 { 20 } else { 0 };
        let end = if which == 1 { start + u32::from_le_bytes(seed[12..16].try_into().unwrap()) as usize } else { seed.len() };
        let mut json = String::from_utf8(seed[start..end].to_vec()).unwrap();
        for (place, new) in changes {
            let digits: Vec<(usize, usize)> = numbers(&json);
            let (from, to) = digits[place.index(digits.len())];
            json.replace_range(from..to, &new);
        }
        let bytes = if which == 1 {
            let mut bytes = seed[..12].to_vec();
            bytes.extend((json.len() as u32).to_le_bytes());
            bytes.extend(b"JSON");
            bytes.extend(json.as_bytes());
            bytes.resize(bytes.len().next_multiple_of(4), b' ');
            bytes.extend(&seed[end..]);
            let length = bytes.len() as u32;
            bytes[8..12].copy_from_slice(&length.to_le_bytes());
            bytes
        } else {
            json.into_bytes()
        };
        if let Ok(scene) = read(&bytes) {
            check_promises(&scene);
        }
    }
}

fn number() -> impl Strategy<Value = String> {
    prop_oneof![
        (0..16_u32).prop_map(|n| n.to_string()),
        prop::sample::select(vec![
            "-1",
            "4294967295",
            "4294967296",
            "18446744073709551615",
            "1e308",
            "1e-300",
            "2.5",
            "null",
            "5120",
            "5121",
            "5122",
            "5123",
            "5125",
            "5126",
            "1000000000",
        ])
        .prop_map(str::to_owned),
    ]
}

/// Where the numbers of a JSON text are, those inside strings left out.
fn numbers(json: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut in_string = false;
    let mut start = None;
    for (at, c) in json.char_indices() {
        match (in_string, c) {
            (_, '"') => in_string = !in_string,
            (false, '0'..='9') => start = start.or(Some(at)),
            (false, '.' | 'e' | '-' | '+') if start.is_some() => {}
            _ => found.extend(start.take().map(|from| (from, at))),
        }
    }
    found
}
