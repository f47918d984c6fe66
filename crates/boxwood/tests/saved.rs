//! Saved trees: what was saved comes back to the bit, and what was not saved so is an error or harmless.

use boxwood::accel::bvh::seal;
use boxwood::{
    BruteForce, Hit, Intersect, OpenError, Primitives, Ray, SavedError, SpatialSplit, TriangleMesh,
    WideBvh, WideSah,
};
use boxwood_testkit::{Random, Spheres, agreement, rays, shapes, soups};
use std::convert::Infallible;

/// Bytes before the nodes.
const HEADER: usize = 128;

fn some_rays(mesh: &TriangleMesh, count: usize, random: &mut Random) -> Vec<Ray> {
    let (judge, targets) = (BruteForce::new(mesh), rays::Targets::of_mesh(mesh));
    let kinds = rays::KINDS.iter();
    kinds
        .flat_map(|(_, kind)| rays::sample(*kind, count, &targets, &judge, random))
        .collect()
}

/// Saved, opened, and saved again.
macro_rules! round_trip {
    ($tree:expr, $n:literal, $primitives:expr, $rays:expr, $case:expr) => {{
        let bytes = $tree.to_bytes();
        let opened = WideBvh::<_, $n>::from_bytes($primitives, &bytes).expect($case);
        assert!(opened.to_bytes() == bytes, "{}", $case);
        agreement::check_one(&opened, $primitives, $rays, $case).hits
    }};
}

#[test]
fn trees_come_back_to_the_bit() {
    let mut random = Random::new(1);
    let models = [
        ("terrain", shapes::terrain(20, &mut random)),
        ("soup", soups::random(300, &mut random)),
        ("one", soups::random(1, &mut random)),
        ("four", soups::random(4, &mut random)),
        ("identical", soups::identical(200)),
        ("slivers", soups::slivers(100, &mut random)),
        ("needles", soups::needles(100, &mut random)),
        ("any floats", soups::any_floats(100, &mut random)),
        ("nothing", shapes::Model::default()),
    ];
    let mut hits = 0;
    for (name, model) in models {
        let mesh = &model.mesh();
        let rays = &some_rays(mesh, 4, &mut random);
        let (eight, sixteen) = (WideSah::<8>::default(), WideSah::<16>::default());
        hits += round_trip!(eight.build(mesh), 8, mesh, rays, name);
        hits += round_trip!(sixteen.build(mesh), 16, mesh, rays, name);
        let cut = SpatialSplit::default().build(mesh);
        hits += round_trip!(WideBvh::<_, 8>::new(mesh, &cut), 8, mesh, rays, name);
        hits += round_trip!(WideBvh::<_, 16>::new(mesh, &cut), 16, mesh, rays, name);
    }
    for grid in [false, true] {
        let spheres = &Spheres::random(200, grid, &mut random);
        let targets = rays::Targets::of_boxes(spheres);
        let judge = BruteForce::new(spheres);
        let rays: &Vec<Ray> = &rays::KINDS
            .iter()
            .flat_map(|(_, kind)| rays::sample(*kind, 4, &targets, &judge, &mut random))
            .collect();
        let (eight, sixteen) = (WideSah::<8>::default(), WideSah::<16>::default());
        hits += round_trip!(eight.build(spheres), 8, spheres, rays, "spheres");
        hits += round_trip!(sixteen.build(spheres), 16, spheres, rays, "spheres");
        let cut = SpatialSplit::default().build(spheres);
        hits += round_trip!(WideBvh::<_, 8>::new(spheres, &cut), 8, spheres, rays, "cut");
    }
    assert!(hits > 500, "{hits}");
}

/// What trees are made of that are owned, borrowed or shared.
#[test]
fn trees_own_borrow_or_share_their_mesh() {
    use std::sync::Arc;
    let mesh = shapes::sphere(12, 8).mesh();
    let builder = WideSah::<8>::default();
    let borrowed = builder.build(&mesh).to_bytes();
    let shared = Arc::new(mesh.clone());
    let first = builder.build(shared.clone());
    let second = WideBvh::<_, 8>::from_bytes(shared.clone(), &borrowed).expect("the same mesh");
    assert_eq!(first.to_bytes(), borrowed);
    assert!(Arc::ptr_eq(first.primitives(), second.primitives()));
    assert_eq!(Arc::strong_count(&shared), 3);
    let place = mesh.positions().as_ptr();
    let owned = WideBvh::<_, 8>::from_bytes(mesh, &borrowed).expect("the same mesh");
    assert_eq!(owned.primitives().positions().as_ptr(), place);
    assert_eq!(owned.to_bytes(), borrowed);
    let ray = Ray::new([0.1, 0.2, 5.0], [0.0, 0.0, -1.0]);
    let hit = owned.closest_hit(&ray);
    assert!(hit.is_some() && hit == second.closest_hit(&ray) && hit == first.closest_hit(&ray));
}

/// A small tree with nodes below nodes and leaves that are not full, its bytes, and rays with the judge's answers.
struct Small {
    mesh: TriangleMesh,
    bytes: Vec<u8>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
}

impl Small {
    fn new(cut: bool) -> Self {
        let mut random = Random::new(9);
        let mesh = if cut {
            // From corner to corner, side by side.
            let needles = (0..12_u8).map(|i| {
                let x = f32::from(i) * 0.1;
                [[x, 0.0, 0.0], [x + 0.05, 0.0, 0.0], [x + 9.0, 9.0, 9.0]]
            });
            shapes::Model::of_triangles(needles).mesh()
        } else {
            soups::random(90, &mut random).mesh()
        };
        let bytes = if cut {
            let builder = SpatialSplit {
                budget: 4.0,
                max_leaf: 1,
                ..SpatialSplit::default()
            };
            let tree = builder.build(&mesh);
            assert!(tree.order.len() > mesh.len(), "nothing was cut");
            WideBvh::<_, 8>::new(&mesh, &tree).to_bytes()
        } else {
            WideSah::<8>::default().build(&mesh).to_bytes()
        };
        let rays = some_rays(&mesh, 6, &mut random);
        let mut hits = vec![None; rays.len()];
        BruteForce::new(&mesh).closest_hits(&rays, &mut hits);
        Self {
            mesh,
            bytes,
            rays,
            hits,
        }
    }

    fn open(&self, bytes: &[u8]) -> Result<WideBvh<&TriangleMesh, 8>, SavedError> {
        WideBvh::from_bytes(&self.mesh, bytes)
    }

    /// Opens a forged file; where that succeeds, the answers must be the judge's.
    fn is_harmless(&self, bytes: &[u8], case: &dyn std::fmt::Debug) -> bool {
        let Ok(tree) = self.open(bytes) else {
            return false;
        };
        let mut hits = vec![None; self.rays.len()];
        tree.closest_hits(&self.rays, &mut hits);
        assert_eq!(hits, self.hits, "{case:?}");
        for (ray, hit) in self.rays.iter().zip(&hits) {
            assert_eq!(tree.closest_hit(ray), *hit, "{case:?}");
            assert_eq!(tree.occluded(ray), hit.is_some(), "{case:?}");
        }
        true
    }
}

#[test]
fn every_damaged_byte_is_an_error() {
    let small = Small::new(false);
    assert!(small.open(&small.bytes).is_ok());
    assert!((2000..20_000).contains(&small.bytes.len()));
    for at in 0..small.bytes.len() {
        for change in [1, 0x80, 0xff] {
            let mut bytes = small.bytes.clone();
            bytes[at] ^= change;
            assert!(small.open(&bytes).is_err(), "byte {at} by {change:#x}");
        }
    }
}

/// Whoever damages a file and then puts the right checksum into it, gets an error or the right answers.
#[test]
fn every_forged_byte_is_an_error_or_harmless() {
    for cut in [false, true] {
        let small = Small::new(cut);
        let (mut refused, mut harmless) = (0, 0);
        for at in 0..small.bytes.len() {
            for change in [1, 0x10, 0x80, 0xff] {
                let mut bytes = small.bytes.clone();
                bytes[at] ^= change;
                seal(&mut bytes);
                if small.is_harmless(&bytes, &(cut, at, change)) {
                    harmless += 1;
                } else {
                    refused += 1;
                }
            }
        }
        // Boxes that became larger do no harm.
        assert!(harmless > 100 && refused > 1000, "{harmless}, {refused}");
    }
}

/// Words rather than bytes: children, numbers and boxes that look like others of the same file.
#[test]
fn words_moved_about_are_errors_or_harmless() {
    for cut in [false, true] {
        let small = Small::new(cut);
        let mut random = Random::new(3);
        let words = small.bytes.len() / 4;
        let mut refused = 0;
        for case in 0..6000 {
            let mut bytes = small.bytes.clone();
            for _ in 0..1 + random.below(3) {
                let (from, to) = (random.below(words), random.below(words));
                if random.one_in(3) {
                    // Within a few words: the neighbour's child, the neighbour's number.
                    let to = (from + 1 + random.below(9)).min(words - 1);
                    bytes.copy_within(4 * from..4 * from + 4, 4 * to);
                } else {
                    bytes.copy_within(4 * from..4 * from + 4, 4 * to);
                }
            }
            seal(&mut bytes);
            refused += usize::from(!small.is_harmless(&bytes, &(cut, case)));
        }
        assert!(refused > 3000, "{refused}");
    }
}

#[test]
fn files_of_another_length_are_errors() {
    let small = Small::new(false);
    for length in 0..small.bytes.len() {
        let error = small.open(&small.bytes[..length]).expect_err("cut off");
        let expected = if length < HEADER {
            SavedError::NotSaved
        } else {
            SavedError::Length {
                expected: small.bytes.len() as u64,
                found: length as u64,
            }
        };
        assert_eq!(error, expected);
    }
    let mut bytes = small.bytes.clone();
    bytes.push(0);
    assert!(matches!(small.open(&bytes), Err(SavedError::Length { .. })));
}

fn at(bytes: &[u8], byte: usize, value: u32) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[byte..byte + 4].copy_from_slice(&value.to_le_bytes());
    seal(&mut bytes);
    bytes
}

#[test]
fn errors_say_what_is_wrong() {
    let small = Small::new(false);
    let said = |bytes: &[u8]| small.open(bytes).expect_err("wrong").to_string();
    assert_eq!(said(b"solid bunny"), "this is no saved tree");
    assert_eq!(said(&at(&small.bytes, 0, 7)), "this is no saved tree");
    assert_eq!(
        said(&at(&small.bytes, 8, 2)),
        "the tree is saved in version 2 of the format; this Boxwood reads version 1"
    );
    let sixteen = WideSah::<16>::default().build(&small.mesh).to_bytes();
    assert_eq!(
        said(&sixteen),
        "the saved tree has 16 children a node, expected 8"
    );
    let mut damaged = small.bytes.clone();
    damaged[200] ^= 4;
    assert_eq!(
        said(&damaged),
        "the saved tree is damaged: its checksum is wrong"
    );
    // Numbers the other way round.
    let mut foreign = small.bytes.clone();
    let (words, _) = foreign[8..].as_chunks_mut::<4>();
    words.iter_mut().for_each(|word| word.reverse());
    assert_eq!(
        said(&foreign),
        "the tree is saved in version 16777216 of the format; this Boxwood reads version 1"
    );
    // The root's first child is the root.
    let first_child = HEADER + 6 * 8 * 4;
    assert!(said(&at(&small.bytes, first_child, 0)).starts_with("the saved tree is not whole: "));
}

#[test]
fn trees_of_other_primitives_are_errors() {
    let small = Small::new(false);
    let open = |mesh: &TriangleMesh| {
        WideBvh::<_, 8>::from_bytes(mesh, &small.bytes)
            .map(|_| ())
            .expect_err("another mesh")
    };
    let (positions, triangles) = (small.mesh.positions(), small.mesh.triangles());
    let mut moved = positions.to_vec();
    moved[77].y = moved[77].y.next_up();
    let moved = TriangleMesh::new(moved, triangles.iter().copied()).expect("finite");
    assert_eq!(open(&moved), SavedError::OtherPrimitives);
    let mut turned = triangles.to_vec();
    turned[3].rotate_left(1);
    let turned = TriangleMesh::new(positions.iter().copied(), turned).expect("in range");
    assert_eq!(open(&turned), SavedError::OtherPrimitives);
    let fewer = triangles[1..].iter().copied();
    let fewer = TriangleMesh::new(positions.iter().copied(), fewer).expect("in range");
    assert_eq!(open(&fewer), SavedError::OtherPrimitives);
    let spheres = Spheres::random(small.mesh.len(), false, &mut Random::new(1));
    assert_eq!(
        WideBvh::<_, 8>::from_bytes(&spheres, &small.bytes).map(|_| ()),
        Err(SavedError::OtherPrimitives)
    );
}

/// Counts are held against the length before memory is asked for, and the length against what there is.
#[test]
fn huge_counts_take_no_memory() {
    let small = Small::new(false);
    for power in [20, 31, 40, 56, 63] {
        let mut bytes = small.bytes.clone();
        bytes[32..40].copy_from_slice(&(1_u64 << power).to_le_bytes());
        assert!(matches!(small.open(&bytes), Err(SavedError::Length { .. })));
        // The file claims to be as long.
        let nodes = (1_u128 << power) * 256;
        let blocks = u64::from_le_bytes(bytes[40..48].try_into().expect("eight"));
        let length = nodes + u128::from(blocks) * 160 + HEADER as u128;
        let Ok(length) = u64::try_from(length) else {
            continue;
        };
        if power < 40 {
            continue;
        }
        let mut rest = &bytes[..];
        let opened = WideBvh::<_, 8>::open(&small.mesh, length, |out| {
            let next = rest.split_off(..out.len()).ok_or("the end")?;
            out.copy_from_slice(next);
            Ok::<_, &str>(())
        });
        assert_eq!(
            opened.map(|_| ()),
            Err(OpenError::Saved(SavedError::NoMemory { bytes: length }))
        );
    }
}

#[test]
fn who_reads_and_writes_may_fail() {
    let small = Small::new(false);
    let tree = small.open(&small.bytes).expect("as it was saved");
    let mut pieces = 0;
    let failed = tree.save(|_| {
        pieces += 1;
        if pieces == 2 { Err("full") } else { Ok(()) }
    });
    assert_eq!((failed, pieces), (Err("full"), 2));
    let opened = WideBvh::<_, 8>::open(&small.mesh, small.bytes.len() as u64, |_| Err("gone"));
    assert_eq!(opened.map(|_| ()), Err(OpenError::Read("gone")));
    let written = tree.save(|_| Ok::<_, Infallible>(()));
    assert_eq!(written, Ok(()));
}

/// The first bytes are what `docs/bxw.md` says, on every machine and for ever.
#[test]
fn the_format_stays() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 3.0]];
    let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]]).expect("good");
    let bytes = WideSah::<8>::default().build(&mesh).to_bytes();
    assert_eq!(bytes.len(), HEADER + 160);
    assert_eq!(bytes[..8], *b"\x89BXW\r\n\x1a\n");
    let words: Vec<u32> = bytes[8..80]
        .as_chunks()
        .0
        .iter()
        .map(|&word| u32::from_le_bytes(word))
        .collect();
    let float = f32::to_bits;
    assert_eq!(
        words,
        [
            1,
            8,
            1,
            0,
            1,
            0,
            0,
            0,
            1,
            0,
            0x8000_0000,
            0,
            0,
            0,
            0,
            float(1.0),
            float(2.0),
            float(3.0)
        ]
    );
    let hash = |at: usize| u128::from_le_bytes(bytes[at..at + 16].try_into().expect("sixteen"));
    assert_eq!(
        hash(80),
        318_010_655_129_384_622_393_470_207_273_132_184_828
    );
    assert_eq!(
        hash(112),
        197_531_415_347_972_422_505_497_742_367_855_430_631
    );
    assert_eq!(bytes[96..112], [0; 16]);
    assert_eq!(
        bytes[HEADER + 144..],
        [0_u32, !0, !0, !0].map(u32::to_le_bytes).concat()
    );
}

/// Whoever changes a builder raises its number, so that trees in caches are built anew, and then the figures below.
#[test]
fn builders_make_the_trees_of_their_revision() {
    let mesh = shapes::terrain(40, &mut Random::new(1)).mesh();
    let hash = |bytes: Vec<u8>| u128::from_le_bytes(bytes[112..128].try_into().expect("sixteen"));
    assert_eq!(
        (
            WideSah::<8>::REVISION,
            hash(WideSah::<8>::default().build(&mesh).to_bytes())
        ),
        (2, 72_636_621_047_930_230_467_226_004_801_921_171_695)
    );
    assert_eq!(
        (
            WideSah::<16>::REVISION,
            hash(WideSah::<16>::default().build(&mesh).to_bytes())
        ),
        (2, 23_088_655_166_287_979_221_449_060_490_787_323_544)
    );
}
