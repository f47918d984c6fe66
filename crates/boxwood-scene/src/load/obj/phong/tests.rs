use super::*;

fn material(text: &str) -> Material {
    let mut cursor = Cursor::new(text.as_bytes());
    let mut phong = Phong::new("m".to_owned());
    let mut warnings = Warnings::new("m.mtl");
    while !cursor.is_done() {
        let line = Line(cursor.line());
        let word = cursor.word();
        phong.statement(word, &mut cursor, line, &mut warnings, |map, _| {
            Some(map.texture(map.name.len() as u32))
        });
        cursor.next_line();
    }
    assert_eq!(warnings.finish().count(), 0);
    phong.into_material()
}

#[test]
fn matt_materials_have_no_gloss() {
    for text in [
        "Kd .1 .2 .3\nKs 0 0 0\nNs 100\nillum 2",
        "Kd .1 .2 .3\nKs 1 1 1\nillum 1",
        "Kd .1 .2 .3",
    ] {
        let m = material(text);
        assert_eq!(m.base_color, [0.1, 0.2, 0.3, 1.0]);
        assert_eq!((m.specular, m.roughness, m.metallic), ([0.0; 3], 1.0, 0.0));
        assert_eq!(m.alpha, Alpha::Opaque);
    }
}

#[test]
fn highlights_have_the_hue_of_ks_and_the_width_of_ns() {
    let m = material("Kd 1 1 1\nKs 1 .5 0\nNs 30\nillum 2");
    assert_eq!(m.specular, [1.0, 0.5, 0.0]);
    assert_eq!(m.roughness, 0.5);
    let faint = material("Ks .01\nillum 2").specular;
    assert!((faint[0] - 0.25).abs() < 1e-6 && faint[0] == faint[2]);
}

#[test]
fn mirrors_are_metal_and_glass_lets_through() {
    let mirror = material("Kd .5 .5 .5\nKs .9 .8 .7\nillum 3");
    assert_eq!((mirror.metallic, mirror.roughness), (1.0, 0.0));
    assert_eq!(mirror.base_color, [0.9, 0.8, 0.7, 1.0]);
    let glass = material("Kd 0 0 0\nNi 1.33\nd .2\nTf .9 1 .9\nillum 7");
    assert_eq!(
        (glass.transmission, glass.ior, glass.roughness),
        (1.0, 1.33, 0.0)
    );
    assert_eq!(glass.base_color, [0.9, 1.0, 0.9, 1.0]);
    assert_eq!((glass.alpha, glass.specular), (Alpha::Opaque, [1.0; 3]));
}

#[test]
fn newer_statements_have_the_last_word() {
    let m = material("Kd .9 .6 .1\nKs .5\nNs 900\nillum 3\nPr .25\nPm 1");
    assert_eq!((m.metallic, m.roughness), (1.0, 0.25));
    assert_eq!(m.base_color, [0.9, 0.6, 0.1, 1.0]);
}

#[test]
fn transparency_is_coverage() {
    assert_eq!(material("d -halo .25").base_color[3], 0.25);
    assert_eq!(material("Tr .25").base_color[3], 0.75);
    assert_eq!(material("d .25\nTr .25").alpha, Alpha::Blend);
    assert_eq!(material("d 1\nTr 1").alpha, Alpha::Opaque);
    let mask = material("map_d leaf.png");
    assert_eq!(mask.alpha, Alpha::Mask { cutoff: 0.5 });
    assert_eq!(mask.alpha_map.unwrap().image, 8);
}

#[test]
fn black_beside_a_map_means_only_the_map() {
    let m = material("Kd 0 0 0\nmap_Kd a.png\nmap_Ke b.jpeg\nnorm -bm 2 cc.png");
    assert_eq!((m.base_color, m.emissive), ([1.0; 4], [1.0; 3]));
    assert_eq!(m.base_color_map.unwrap().image, 5);
    assert_eq!(m.emissive_map.unwrap().image, 6);
    assert_eq!((m.normal_map.unwrap().image, m.normal_scale), (6, 2.0));
    assert_eq!(
        material("Kd .5\nmap_Kd a.png").base_color,
        [0.5, 0.5, 0.5, 1.0]
    );
    assert_eq!(material("Ke 2 3 4").emissive, [2.0, 3.0, 4.0]);
}
