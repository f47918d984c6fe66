//! Saved trees that somebody tampered with, from any bytes: what fuzzing and the replay of its corpus share.
//!
//! *Layout.* Byte 0: bit 0 asks for 16 children, bit 1 for cut primitives, bit 2 for spheres; with bit 3 the checksum stays as
//! it was, and with bit 4 the bytes from the third on are the file. Byte 1 is the seed of the primitives. Then follow changes of four bytes: a word of the file (two bytes,
//! the lowest first), what happens to it, and by how much.

use crate::{Random, Spheres, agreement, rays, shapes, soups};
use boxwood::accel::bvh::seal;
use boxwood::{BruteForce, Primitives, Ray, SpatialSplit, WideBvh, WideSah};

/// Rays of each kind.
const RAYS: usize = 2;

/// Tampers with a saved tree and opens it; whether that succeeds.
///
/// # Panics
/// When it does and an answer is not the judge's.
pub fn check(bytes: &[u8], case: &str) -> bool {
    let &[what, seed, ref changes @ ..] = bytes else {
        return false;
    };
    let mut random = Random::new(u64::from(seed));
    if what & 4 != 0 {
        let spheres = Spheres::random(40, seed & 1 == 1, &mut random);
        let targets = rays::Targets::of_boxes(&spheres);
        return of(&spheres, &targets, what, changes, case, &mut random);
    }
    let model = match seed % 4 {
        0 => shapes::terrain(5, &mut random),
        1 => soups::needles(12, &mut random),
        2 => soups::grid(50, &mut random),
        _ => soups::random(50, &mut random),
    };
    let mesh = model.mesh();
    let targets = rays::Targets::of_mesh(&mesh);
    of(&mesh, &targets, what, changes, case, &mut random)
}

fn of<P: Primitives + Send + Sync>(
    primitives: &P,
    targets: &rays::Targets,
    what: u8,
    changes: &[u8],
    case: &str,
    random: &mut Random,
) -> bool {
    let judge = BruteForce::new(primitives);
    let kinds = rays::KINDS.iter();
    let rays: Vec<Ray> = kinds
        .flat_map(|(_, kind)| rays::sample(*kind, RAYS, targets, &judge, random))
        .collect();
    macro_rules! width {
        ($n:literal) => {{
            let tree = if what & 2 != 0 {
                let builder = SpatialSplit {
                    budget: 4.0,
                    max_leaf: 1,
                    ..SpatialSplit::default()
                };
                WideBvh::<_, $n>::new(primitives, &builder.build(primitives))
            } else {
                WideSah::<$n>::default().build(primitives)
            };
            let file = tampered(tree.to_bytes(), what, changes);
            let Ok(tree) = WideBvh::<_, $n>::from_bytes(primitives, &file) else {
                return false;
            };
            agreement::check_one(&tree, primitives, &rays, case);
        }};
    }
    if what & 1 == 0 {
        width!(8);
    } else {
        width!(16);
    }
    true
}

fn tampered(mut file: Vec<u8>, what: u8, changes: &[u8]) -> Vec<u8> {
    if what & 16 != 0 {
        file = changes.to_vec();
    } else {
        for &[low, high, how, by] in changes.as_chunks().0 {
            change(&mut file, u16::from_le_bytes([low, high]).into(), how, by);
        }
    }
    if what & 8 == 0 {
        seal(&mut file);
    }
    file
}

fn change(file: &mut Vec<u8>, word: usize, how: u8, by: u8) {
    let (words, _) = file.as_chunks_mut::<4>();
    if words.is_empty() {
        return;
    }
    let place = word % words.len();
    let other = words[(place + usize::from(by)) % words.len()];
    let number = u32::from_le_bytes(words[place]);
    words[place] = match how % 8 {
        0 => u32::from(by).to_le_bytes(),
        1 => other,
        2 => (number ^ 1 << (by % 32)).to_le_bytes(),
        3 => number.wrapping_add(by.into()).to_le_bytes(),
        4 => number.wrapping_sub(by.into()).to_le_bytes(),
        5 => u32::MAX.wrapping_sub(by.into()).to_le_bytes(),
        6 => (f32::from_bits(number) * (f32::from(by) - 128.0)).to_le_bytes(),
        _ => return file.truncate(4 * place + usize::from(by % 4)),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn untouched_trees_open_and_others_rarely() {
        for what in 0..8 {
            for seed in 0..8 {
                assert!(check(&[what, seed], "untouched"), "{what} {seed}");
                assert!(!check(&[what | 8, seed, 40, 0, 2, 3], "damaged"));
                assert!(!check(&[what | 16, seed, 1, 2, 3], "no file"));
            }
        }
        assert!(!check(&[], "nothing"));
        let mut random = Random::new(1);
        let mut opened = 0;
        for _ in 0..500 {
            let bytes: Vec<u8> = (0..6).map(|_| random.below(256) as u8).collect();
            opened += usize::from(check(
                &[&[bytes[0] & 7], &bytes[1..]].concat(),
                "one change",
            ));
        }
        assert!((1..400).contains(&opened), "{opened}");
    }
}
