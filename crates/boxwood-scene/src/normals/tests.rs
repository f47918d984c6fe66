use super::*;
use crate::Mesh;

const PI: f32 = std::f32::consts::PI;

fn assert_near(a: [f32; 3], b: [f32; 3]) {
    let far = (0..3).any(|k| (a[k] - b[k]).abs() > 1e-5);
    assert!(!far, "{a:?} instead of {b:?}");
}

/// A cube from 0 to 1, each face its own four vertices, two triangles each.
fn cube() -> Mesh {
    let mut mesh = Mesh {
        smooth: true,
        ..Mesh::default()
    };
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let first = mesh.positions.len() as u32;
            for (a, b) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                let mut p = [side; 3];
                p[(axis + 1) % 3] = a;
                p[(axis + 2) % 3] = b;
                mesh.positions.push(p);
            }
            let quad = if side > 0.0 {
                [0, 1, 2, 3]
            } else {
                [3, 2, 1, 0]
            };
            let [a, b, c, d] = quad.map(|i| first + i);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[test]
fn a_cube_is_sharp_below_its_angle_and_round_above_whatever_its_diagonals() {
    let cube = cube();
    let sharp = cube.corner_normals(1.0);
    let round = cube.corner_normals(2.0);
    for (i, triangle) in cube.triangles.iter().enumerate() {
        let face = unit(area_normal(&cube.positions, *triangle)).unwrap();
        for (place, &vertex) in triangle.iter().enumerate() {
            assert_near(sharp[i][place], face);
            // Angles, not counts, weigh: the diagonal of the cube although faces have one or two triangles there.
            let outward = cube.positions[vertex as usize].map(|x| (2.0 * x - 1.0) / 3.0_f32.sqrt());
            assert_near(round[i][place], outward);
        }
    }
}

#[test]
fn the_files_own_normals_win_and_facets_stay_flat() {
    let mut mesh = Mesh {
        smooth: false,
        ..cube()
    };
    let faces = mesh.corner_normals(PI);
    assert_near(faces[0][0], [-1.0, 0.0, 0.0]);
    mesh.normals = vec![[0.0, 1.0, 0.0]; mesh.positions.len()];
    assert_eq!(mesh.corner_normals(PI)[0], [[0.0, 1.0, 0.0]; 3]);
}

#[test]
fn faces_without_area_take_the_normal_of_their_neighbours() {
    let positions = [
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [-0.0; 3],
        [9.0; 3],
    ];
    let normals = smooth_normals(&positions, &[[0, 1, 2], [3, 0, 3], [4, 4, 4]], 0.5);
    assert_near(normals[0][0], [0.0, 0.0, -1.0]);
    assert_near(normals[1][0], [0.0, 0.0, -1.0]);
    assert_eq!(normals[2], [[0.0, 0.0, 1.0]; 3]);
    assert!(smooth_normals(&[], &[], 1.0).is_empty());
}

/// A cone of many faces around one vertex, and a lid of as many below.
fn cone(count: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut positions = vec![[0.0, 0.0, 1.0]];
    positions.extend((0..count).map(|i| {
        let (y, x) = (f64::from(i) * 2.0 * std::f64::consts::PI / f64::from(count)).sin_cos();
        [x as f32, y as f32, 0.0]
    }));
    let triangles = (0..count)
        .map(|i| [0, 1 + i, 1 + (i + 1) % count])
        .collect();
    (positions, triangles)
}

#[test]
fn a_vertex_with_a_hundred_thousand_faces_takes_no_time() {
    let (positions, triangles) = cone(100_000);
    let round = smooth_normals(&positions, &triangles, PI);
    assert_near(round[5][0], [0.0, 0.0, 1.0]);
    // With a crease the tip follows the side on which it is looked at.
    let creased = smooth_normals(&positions, &triangles, 0.6);
    let side = unit(area_normal(&positions, triangles[0])).unwrap();
    let n = creased[0][0];
    assert!(
        n[0] * side[0] + n[1] * side[1] + n[2] * side[2] > 0.9,
        "{n:?}"
    );
}

#[test]
fn few_and_many_faces_agree_where_both_are_smooth() {
    for count in [20, 200] {
        let (positions, triangles) = cone(count);
        for normals in smooth_normals(&positions, &triangles, PI) {
            assert_near(normals[0], [0.0, 0.0, 1.0]);
        }
    }
}

#[test]
fn lengths_are_one_at_any_scale() {
    for scale in [1e-20_f32, 1.0, 1e18] {
        let triangle = [[0.0; 3], [scale, 0.0, 0.0], [0.0, scale, 0.0]];
        assert_eq!(
            smooth_normals(&triangle, &[[0, 1, 2]], 1.0)[0],
            [[0.0, 0.0, 1.0]; 3]
        );
    }
    assert_eq!(unit([0.0, f64::NAN, 1.0]), None);
    assert_eq!(unit([f64::INFINITY, 0.0, 1.0]), None);
}
