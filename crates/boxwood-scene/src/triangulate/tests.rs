use super::*;
use proptest::prelude::*;

fn cut(corners: &[[f32; 3]]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    Triangulator::default().triangulate(corners, &mut triangles);
    triangles
}

fn flat(points: &[[f32; 2]]) -> Vec<[f32; 3]> {
    points.iter().map(|&[x, y]| [x, y, 0.0]).collect()
}

fn area_of(corners: &[[f32; 3]], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|i| corners[i as usize].map(f64::from));
    let n = cross(
        std::array::from_fn(|k| b[k] - a[k]),
        std::array::from_fn(|k| c[k] - a[k]),
    );
    dot(n, n).sqrt() / 2.0
}

/// Asserts `n − 2` triangles that cover the polygon once, and returns how many have no area.
fn assert_covers(corners: &[[f32; 3]]) -> usize {
    let triangles = cut(corners);
    assert_eq!(triangles.len(), corners.len() - 2);
    let areas: Vec<f64> = triangles.iter().map(|&t| area_of(corners, t)).collect();
    let normal = newell(corners);
    let right = dot(normal, normal).sqrt() / 2.0;
    let sum: f64 = areas.iter().sum();
    assert!(
        (sum - right).abs() <= 1e-5 * right,
        "{sum} instead of {right}: {corners:?}"
    );
    areas.iter().filter(|&&area| area == 0.0).count()
}

#[test]
fn too_few_corners_make_nothing() {
    assert!(cut(&[]).is_empty());
    assert!(cut(&[[0.0; 3]; 2]).is_empty());
    assert_eq!(cut(&[[0.0; 3]; 3]), [[0, 1, 2]]);
}

#[test]
fn a_concave_quad_is_cut_at_its_reflex_corner_wherever_it_stands() {
    let dart = flat(&[[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]]);
    for turn in 0..4 {
        let mut corners = dart.clone();
        corners.rotate_left(turn);
        assert_eq!(assert_covers(&corners), 0);
        corners.reverse();
        assert_eq!(assert_covers(&corners), 0);
    }
}

#[test]
fn a_quad_with_three_corners_in_a_line_has_no_empty_triangle() {
    let quad = flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]]);
    for turn in 0..4 {
        let mut corners = quad.clone();
        corners.rotate_left(turn);
        assert_eq!(assert_covers(&corners), 0);
    }
}

#[test]
fn a_hole_joined_by_a_slit_stays_open() {
    // A square with a square hole, cut in at one corner each: ten corners, two of them twice.
    let corners = flat(&[
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [0.0, 3.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
    ]);
    for turn in 0..10 {
        let mut turned = corners.clone();
        turned.rotate_left(turn);
        assert_eq!(assert_covers(&turned), 0);
        turned.reverse();
        assert_eq!(assert_covers(&turned), 0);
    }
}

#[test]
fn corners_in_a_line_are_kept() {
    // A square whose sides have corners in the middle.
    let corners = flat(&[
        [0.0, 0.0],
        [1.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [2.0, 2.0],
        [1.0, 2.0],
        [0.0, 2.0],
        [0.0, 1.0],
    ]);
    assert_eq!(assert_covers(&corners), 0);
}

#[test]
fn polygons_without_area_and_polygons_that_cross_themselves_have_their_count() {
    assert_eq!(cut(&[[1.0, 2.0, 3.0]; 9]).len(), 7);
    let line: Vec<[f32; 3]> = (0..9).map(|i| [i as f32, 2.0 * i as f32, 0.0]).collect();
    assert_eq!(cut(&line).len(), 7);
    let star: Vec<[f32; 3]> = (0..5)
        .map(|i| (i as f32 * 4.0 * std::f32::consts::PI / 5.0).sin_cos())
        .map(|(x, y)| [x, y, 0.0])
        .collect();
    assert_eq!(cut(&star).len(), 3);
    let huge = [
        [f32::MAX, 0.0, 0.0],
        [0.0, f32::MAX, 0.0],
        [-f32::MAX; 3],
        [f32::MIN_POSITIVE; 3],
        [0.0; 3],
    ];
    assert_eq!(cut(&huge).len(), 3);
}

/// Corners around the origin at the given distances: never crosses itself.
fn star(radii: &[f32]) -> Vec<[f32; 2]> {
    let step = 2.0 * std::f64::consts::PI / radii.len() as f64;
    (radii.iter().enumerate())
        .map(|(i, &r)| (f64::from(r), i as f64 * step))
        .map(|(r, angle)| [(r * angle.cos()) as f32, (r * angle.sin()) as f32])
        .collect()
}

/// Takes the plane into space: no axis is special.
fn tilt(points: &[[f32; 2]], flip: bool) -> Vec<[f32; 3]> {
    let z = if flip { -0.75 } else { 0.75 };
    points
        .iter()
        .map(|&[x, y]| [x - 0.5 * y, z * y, x + 0.25 * y])
        .collect()
}

#[test]
fn a_hundred_thousand_corners_take_no_time() {
    let mut state = 1_u32;
    let radii: Vec<f32> = (0..100_000)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            0.5 + (state >> 8) as f32 / 3e7
        })
        .collect();
    assert_covers(&flat(&star(&radii)));
    assert_covers(&flat(&star(&vec![1.0; 100_000])));
    // A comb, a spiral of garbage, and everything in one cell but for one corner.
    let comb: Vec<[f32; 2]> = (0..99_999)
        .map(|i| [i as f32, (i % 2 * 50_000) as f32])
        .chain([[50_000.0, -1e5]])
        .rev()
        .collect();
    assert_covers(&flat(&comb));
    let garbage: Vec<[f32; 3]> = radii.chunks(2).map(|r| [r[0], r[1], 0.0]).collect();
    assert_eq!(cut(&garbage).len(), garbage.len() - 2);
    let mut far = flat(&star(&radii));
    far[7] = [1e30, 1e30, 0.0];
    assert_eq!(cut(&far).len(), far.len() - 2);
}

proptest! {
    #[test]
    fn stars_are_covered(radii in prop::collection::vec(0.1_f32..10.0, 4..600), flip: bool) {
        assert_covers(&tilt(&star(&radii), flip));
    }

    /// Skylines on small integers: corners in lines, corners on top of each other.
    #[test]
    fn skylines_are_covered(heights in prop::collection::vec(1_u8..4, 1..60), turn: prop::sample::Index) {
        let mut points: Vec<[f32; 2]> = Vec::new();
        for (i, &h) in heights.iter().enumerate() {
            points.push([i as f32, f32::from(h)]);
            points.push([i as f32 + 1.0, f32::from(h)]);
        }
        points.push([heights.len() as f32, 0.0]);
        points.push([0.0, 0.0]);
        let start = turn.index(points.len());
        points.rotate_left(start);
        assert_covers(&flat(&points));
    }

    /// A row of holes in a wall, each joined by a slit to the outline below it.
    #[test]
    fn walls_with_holes_are_covered(holes in prop::collection::vec((1_u8..4, 4_u8..8), 1..30), turn: prop::sample::Index) {
        let mut points = Vec::new();
        for (i, &(low, high)) in holes.iter().enumerate() {
            let (x, low, high) = (3.0 * i as f32, f32::from(low), f32::from(high));
            points.extend([
                [x + 1.0, 0.0], [x + 1.0, low], [x + 1.0, high], [x + 2.0, high], [x + 2.0, low],
                [x + 1.0, low], [x + 1.0, 0.0],
            ]);
        }
        let width = 3.0 * holes.len() as f32;
        points.extend([[width, 0.0], [width, 9.0], [0.0, 9.0], [0.0, 0.0]]);
        let start = turn.index(points.len());
        points.rotate_left(start);
        // Corners in a line may be left to the end, so some triangles may have no area.
        assert_covers(&tilt(&points, false));
    }

    #[test]
    fn anything_has_its_count(corners in prop::collection::vec([-2_i8..3, -2_i8..3, -1_i8..1], 3..80)) {
        let corners: Vec<[f32; 3]> = corners.iter().map(|p| p.map(f32::from)).collect();
        let triangles = cut(&corners);
        prop_assert_eq!(triangles.len(), corners.len() - 2);
        // Every corner is used: none is dropped for lying on another.
        let mut used = vec![false; corners.len()];
        triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
        prop_assert!(!used.contains(&false));
    }
}
