//! Rays from a NumPy file: (n, 6) `ox oy oz dx dy dz` or (n, 8) `ox oy oz t_min dx dy dz t_max`.

use crate::failure::Outcome;
use crate::table::{self, Table};
use boxwood::Ray;
use std::path::Path;

/// What the file must be.
const EXPECTED: &str =
    "(n, 6) `ox oy oz dx dy dz` or (n, 8) `ox oy oz t_min dx dy dz t_max` of float32 or float64";

/// Reads rays from a file, or from stdin for `-`. Float64 is rounded to float32.
///
/// # Errors
/// One sentence that names the file and what was expected of it.
pub fn read(path: &Path) -> Outcome<Vec<Ray>> {
    table::read(path, decode)
}

fn decode(bytes: &[u8]) -> Result<Vec<Ray>, String> {
    let table = Table::decode(bytes, &[6, 8], "ray", EXPECTED)?;
    Ok((0..table.rows())
        .map(|i| {
            if table.columns() == 6 {
                Ray::new(table.vector(i, 0), table.vector(i, 3))
            } else {
                Ray::new(table.vector(i, 0), table.vector(i, 4))
                    .from(table.at(i, 3))
                    .until(table.at(i, 7))
            }
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::npy::Header;

    fn file(descr: &str, fortran_order: bool, shape: &[u64], data: &[u8]) -> Vec<u8> {
        let mut bytes = Header {
            descr: descr.to_string(),
            fortran_order,
            shape: shape.to_vec(),
        }
        .to_bytes();
        bytes.extend(data);
        bytes
    }

    #[test]
    fn every_order_gives_the_same_rays() {
        // Two rays, numbered by column and ray.
        let value = |ray: usize, column: usize| (10 * ray + column) as f64 + 0.5;
        for columns in [6, 8] {
            let mut seen = Vec::new();
            for fortran in [false, true] {
                let values: Vec<f64> = if fortran {
                    (0..columns)
                        .flat_map(|c| [value(0, c), value(1, c)])
                        .collect()
                } else {
                    (0..2)
                        .flat_map(|r| (0..columns).map(move |c| value(r, c)))
                        .collect()
                };
                let encodings: [(&str, Vec<u8>); 4] = [
                    (
                        "<f4",
                        values
                            .iter()
                            .flat_map(|&x| (x as f32).to_le_bytes())
                            .collect(),
                    ),
                    (
                        ">f4",
                        values
                            .iter()
                            .flat_map(|&x| (x as f32).to_be_bytes())
                            .collect(),
                    ),
                    ("<f8", values.iter().flat_map(|x| x.to_le_bytes()).collect()),
                    (">f8", values.iter().flat_map(|x| x.to_be_bytes()).collect()),
                ];
                for (descr, data) in encodings {
                    let shape = [2, columns as u64];
                    seen.push(decode(&file(descr, fortran, &shape, &data)).expect("good rays"));
                }
            }
            assert!(seen.iter().all(|rays| rays == &seen[0]));
            let ray = seen[0][1];
            assert_eq!(ray.origin.to_array(), [10.5, 11.5, 12.5]);
            if columns == 6 {
                assert_eq!(ray.direction.to_array(), [13.5, 14.5, 15.5]);
                assert_eq!((ray.t_min, ray.t_max), (0.0, f32::INFINITY));
            } else {
                assert_eq!(ray.direction.to_array(), [14.5, 15.5, 16.5]);
                assert_eq!((ray.t_min, ray.t_max), (13.5, 17.5));
            }
        }
    }

    #[test]
    fn no_rays_are_legal() {
        assert_eq!(decode(&file("<f4", false, &[0, 6], &[])), Ok(vec![]));
        assert_eq!(decode(&file(">f8", true, &[0, 8], &[])), Ok(vec![]));
    }

    #[test]
    fn other_arrays_are_refused_in_a_sentence() {
        let refused = |bytes: &[u8]| decode(bytes).expect_err("refused");
        assert_eq!(
            refused(&file("<i4", false, &[1, 6], &[0; 24])),
            format!("holds numbers of type <i4; expected {EXPECTED}")
        );
        for (shape, text) in [
            (&[6][..], "(6,)"),
            (&[1, 7], "(1, 7)"),
            (&[1, 6, 1], "(1, 6, 1)"),
            (&[], "()"),
        ] {
            assert_eq!(
                refused(&file("<f4", false, shape, &[0; 24])),
                format!("has the shape {text}; expected {EXPECTED}")
            );
        }
        assert_eq!(
            refused(&file("<f4", false, &[2, 6], &[0; 24])),
            "promises 2 rays of 24 bytes, but 24 bytes follow its header"
        );
        assert!(refused(&file("<f8", false, &[u64::MAX, 8], &[0; 24])).starts_with("promises"));
        assert!(refused(&file("<f4", false, &[0, 6], &[0; 24])).starts_with("promises 0 rays"));
    }
}
