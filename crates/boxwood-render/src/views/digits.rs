//! Numbers drawn with five rows of three dots.

/// Dots per glyph.
pub const WIDTH: usize = 3;
/// Rows per glyph.
pub const HEIGHT: usize = 5;

/// Each row's dots as octal digits from the top.
const GLYPHS: [u16; 10] = [
    0o75557, 0o26227, 0o71747, 0o71717, 0o55711, 0o74717, 0o74757, 0o71122, 0o75757, 0o75717,
];

/// Whether the dot at `x`, `y` of a text of digits is set. Glyphs stand one dot apart; `y` counts down.
pub fn dot(text: &str, x: usize, y: usize) -> bool {
    let (glyph, column) = (x / (WIDTH + 1), x % (WIDTH + 1));
    let digit = text
        .as_bytes()
        .get(glyph)
        .map(|byte| byte.wrapping_sub(b'0'));
    let Some(rows) = digit.and_then(|digit| GLYPHS.get(usize::from(digit))) else {
        return false;
    };
    column < WIDTH && y < HEIGHT && rows >> (3 * (HEIGHT - 1 - y) + WIDTH - 1 - column) & 1 == 1
}

/// Dots from the first to the last column of a text.
pub fn width(text: &str) -> usize {
    (text.len() * (WIDTH + 1)).saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_four_and_a_one() {
        let rows: Vec<String> = (0..HEIGHT)
            .map(|y| {
                (0..width("41"))
                    .map(|x| if dot("41", x, y) { '#' } else { '.' })
                    .collect()
            })
            .collect();
        assert_eq!(
            rows,
            ["#.#..#.", "#.#.##.", "###..#.", "..#..#.", "..#.###"]
        );
    }
}
