//! The cost view: numbers of steps as colours, with a strip at the foot that says what they mean.

use super::colour_map::inferno;
use super::digits;
use crate::colour::WHITE;
use boxwood::Vec3;

/// Colours of costs, row by row, with the legend drawn over the foot of the image.
///
/// The scale runs from 0 to the cost that all but one pixel in two hundred stay below, rounded up to a round number: one
/// unlucky pixel does not darken the rest.
pub fn picture(costs: &[u32], [width, height]: [usize; 2]) -> Vec<Vec3> {
    let most = scale(costs);
    let mut pixels: Vec<Vec3> = costs
        .iter()
        .map(|&cost| inferno(cost as f32 / most as f32))
        .collect();
    draw(&mut pixels, [width, height], most);
    pixels
}

fn scale(costs: &[u32]) -> u32 {
    let mut sorted = costs.to_vec();
    sorted.sort_unstable();
    let high = sorted
        .get(sorted.len().saturating_sub(1 + sorted.len() / 200))
        .copied()
        .unwrap_or(0);
    round_up(high.max(1))
}

/// The next of 1, 2, 4, 6, 8, 10, 20, 40 …: halves stay whole.
fn round_up(n: u32) -> u32 {
    let mut unit = 1_u32;
    while n > unit.saturating_mul(10) {
        unit = unit.saturating_mul(10);
    }
    [2, 4, 6, 8, 10]
        .into_iter()
        .map(|k| unit.saturating_mul(k))
        .find(|&m| m >= n)
        .unwrap_or(n)
}

fn draw(pixels: &mut [Vec3], [width, height]: [usize; 2], most: u32) {
    let dot = (height / 200).max(1);
    let (margin, bar) = (2 * dot, 4 * dot);
    let strip = margin + bar + margin + digits::HEIGHT * dot + margin;
    let labels = [(0, 0.0), (most / 2, 0.5), (most, 1.0)].map(|(n, at)| (n.to_string(), at));
    let text: usize = labels
        .iter()
        .map(|(text, _)| (digits::width(text) + 3) * dot)
        .sum();
    // A legend that would cover half the picture or could not be read is left out.
    if strip * 2 > height || text + 2 * margin > width {
        return;
    }
    let top = height - strip;
    for y in top..height {
        for x in 0..width {
            let pixel = &mut pixels[y * width + x];
            *pixel = *pixel * 0.08;
        }
    }
    let (left, right) = (margin, width - margin);
    for y in top + margin..top + margin + bar {
        for x in left..right {
            pixels[y * width + x] = inferno((x - left) as f32 / (right - left - 1) as f32);
        }
    }
    for (text, at) in labels {
        let columns = digits::width(&text);
        let room = right - left - columns * dot;
        let start = left + (at * room as f32) as usize;
        for y in 0..digits::HEIGHT * dot {
            for x in 0..columns * dot {
                if digits::dot(&text, x / dot, y / dot) {
                    pixels[(top + 2 * margin + bar + y) * width + start + x] = WHITE;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_round_and_ignore_the_odd_pixel() {
        assert_eq!(
            [1, 2, 3, 11, 19, 47, 99, 101].map(round_up),
            [2, 2, 4, 20, 20, 60, 100, 200]
        );
        assert!(round_up(u32::MAX) == u32::MAX);
        let mut costs = vec![37; 1000];
        costs[5] = 9000;
        assert_eq!(scale(&costs), 40);
        assert_eq!(scale(&[]), 2);
    }

    #[test]
    fn tiny_pictures_have_no_legend() {
        let plain = picture(&[0; 4], [2, 2]);
        assert_eq!(plain, vec![inferno(0.0); 4]);
        let large = picture(&vec![0; 200 * 100], [200, 100]);
        assert!(large.contains(&WHITE));
    }
}
