//! The cost view: numbers of steps as colours, with a strip at the foot that says what they mean.

use super::colour_map::inferno;
use super::digits;
use super::heat_map::HeatScale;
use crate::colour::WHITE;
use boxwood::Vec3;

/// Colours of costs, row by row, with the legend drawn over the foot of the image.
///
/// The scale runs from 0 to the cost that all but one pixel in two hundred stay below, rounded up to a round number: one
/// unlucky pixel does not darken the rest.
pub fn picture(costs: &[u32], [width, height]: [usize; 2]) -> Vec<Vec3> {
    let most = HeatScale::of([costs]).most();
    let mut pixels: Vec<Vec3> = costs
        .iter()
        .map(|&cost| inferno(cost as f32 / most as f32))
        .collect();
    draw(&mut pixels, [width, height], most);
    pixels
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
    fn tiny_pictures_have_no_legend() {
        let plain = picture(&[0; 4], [2, 2]);
        assert_eq!(plain, vec![inferno(0.0); 4]);
        let large = picture(&vec![0; 200 * 100], [200, 100]);
        assert!(large.contains(&WHITE));
    }
}
