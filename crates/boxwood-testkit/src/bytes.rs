//! A small mesh and some rays from any bytes: what fuzzing and the replay of its corpus share.
//!
//! Coordinates are whole numbers from -8 to 7, so that ties, triangles without area and rays in planes are the rule.
//!
//! *Layout.* One byte: the number of triangles, modulo 65; six bytes: a power of two that scales everything, and five that
//! are kept for later; nine nibbles (five bytes) per triangle; the rest are rays of seven nibbles (four bytes): origin,
//! direction, and how the interval ends. What is missing reads as zero.

use boxwood::{Ray, TriangleMesh, Vec3};

/// At most so many rays are made.
const MOST_RAYS: usize = 64;

/// The mesh and the rays that some bytes stand for.
pub fn case(bytes: &[u8]) -> (TriangleMesh, Vec<Ray>) {
    let mut nibbles = Nibbles { bytes, next: 0 };
    let count = usize::from(bytes.first().copied().unwrap_or(0)) % 65;
    // Mostly 1; sometimes beyond the sizes for which traversal is proven.
    let power = match bytes.get(1).copied().unwrap_or(0) {
        b @ 0..=251 => i32::from(b % 8),
        252 => -30,
        253 => 38,
        254 => -130,
        255 => 120,
    };
    let scale = 2.0_f32.powi(power);
    nibbles.next = 2 * 7;
    let mut positions = Vec::new();
    for _ in 0..count {
        positions.extend([(); 3].map(|()| nibbles.point(scale)));
        nibbles.next += 1;
    }
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    let mesh = TriangleMesh::new(positions, triangles).expect("whole numbers are finite");
    let mut rays = Vec::new();
    while nibbles.next < 2 * bytes.len() && rays.len() < MOST_RAYS {
        let (origin, direction) = (nibbles.point(scale), nibbles.point(1.0));
        let ray = Ray::new(origin, direction);
        rays.push(match nibbles.signed() {
            -8 => Ray::between(origin, direction * scale),
            -7 => ray.until(scale),
            -6 => ray.from(scale),
            -5 => ray.from(2.0 * scale).until(scale),
            -4 => ray.until(f32::NAN),
            -3 => Ray::new(origin, direction * -1.0e-30),
            -2 => Ray::new(origin, direction * 1.0e30),
            _ => ray,
        });
        nibbles.next += 1;
    }
    (mesh, rays)
}

/// Reads half bytes, the upper half first.
struct Nibbles<'a> {
    bytes: &'a [u8],
    next: usize,
}

impl Nibbles<'_> {
    /// From -8 to 7.
    fn signed(&mut self) -> i8 {
        let byte = self.bytes.get(self.next / 2).copied().unwrap_or(0);
        let nibble = if self.next.is_multiple_of(2) {
            byte >> 4
        } else {
            byte & 15
        };
        self.next += 1;
        // The sign bit of four moves up to that of eight and back.
        ((nibble << 4) as i8) >> 4
    }
    fn point(&mut self, scale: f32) -> Vec3 {
        Vec3::from([(); 3].map(|()| f32::from(self.signed()) * scale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_bytes_are_a_case() {
        let (mesh, rays) = case(&[]);
        assert!(mesh.triangles().is_empty() && rays.is_empty());
        let bytes: Vec<u8> = (0..=255).collect();
        for from in 0..=255 {
            let (mesh, rays) = case(&bytes[from..]);
            assert_eq!(mesh.triangles().len(), from % 65);
            assert!(rays.len() <= MOST_RAYS);
        }
    }

    #[test]
    fn nibbles_have_signs() {
        let bytes = [
            1, 0, 0, 0, 0, 0, 0, 0x01, 0x27, 0x8f, 0x00, 0x00, 0x12, 0x30, 0x01, 0x00,
        ];
        let (mesh, rays) = case(&bytes);
        assert_eq!(mesh.triangle(0)[1], Vec3::new(7.0, -8.0, -1.0));
        assert_eq!(rays, [Ray::new([1.0, 2.0, 3.0], [0.0, 0.0, 1.0])]);
    }
}
