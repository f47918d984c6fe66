//! Heat maps on one scale, and where any two of them differ, without a script.
//!
//! *How it works.* Each structure's map is there twice: in colours, to be looked at, and in grey, where equal steps are
//! equal factors. Half of one grey map over half of the other's negative is grey where they agree, brighter where the first
//! costs more, darker where the second does; an SVG filter turns that grey into colours. Radio buttons choose the two.

use super::escape::Escaped;
use super::svg::{count, round};
use crate::compare::text::number;
use crate::compare::views::{Map, Pictures};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use boxwood_render::HeatScale;
use std::fmt::Write;

/// The colours of a difference run from a quarter to four times the cost.
const OCTAVES: f64 = 2.0;
/// Entries of the filter's tables.
const ENTRIES: usize = 256;

/// A PNG as a `data:` address.
pub fn data(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// The heat maps with their legend.
pub fn heat_maps(pictures: &Pictures) -> String {
    let [width, height] = pictures.size;
    let mut html = format!(
        "<p>Inner nodes (or cells) and primitives that the ray through each pixel visits, all on one {} scale.</p>{}<div class=\"maps\">",
        if pictures.scale.is_logarithmic() {
            "logarithmic"
        } else {
            "linear"
        },
        legend(&pictures.scale)
    );
    for map in &pictures.maps {
        let name = Escaped(&map.structure);
        let _ = write!(
            html,
            "<figure><img src=\"{}\" width=\"{width}\" height=\"{height}\" alt=\"Cost of {name} per pixel\"><figcaption><b>{name}</b> {} steps per ray</figcaption></figure>",
            data(&map.png),
            round(map.mean())
        );
    }
    html += "</div>";
    if !pictures.left_out.is_empty() {
        let names: Vec<String> = pictures
            .left_out
            .iter()
            .map(|n| Escaped(n).to_string())
            .collect();
        let _ = write!(
            html,
            "<p class=\"small\">Too slow to draw: {}.</p>",
            names.join(", ")
        );
    }
    html
}

fn legend(scale: &HeatScale) -> String {
    let stops: String = (0..=16)
        .map(|i| {
            let share = i as f32 / 16.0;
            let [r, g, b] = HeatScale::colour(share);
            format!("<stop offset=\"{share}\" stop-color=\"#{r:02x}{g:02x}{b:02x}\"/>")
        })
        .collect();
    let mut svg = format!(
        "<svg class=\"legend\" viewBox=\"0 0 560 38\" role=\"img\" aria-label=\"Scale of the heat maps\"><defs><linearGradient id=\"inferno\">{stops}</linearGradient></defs><rect x=\"14\" width=\"532\" height=\"14\" rx=\"2\" fill=\"url(#inferno)\"/>"
    );
    let most = scale.most();
    let ticks: Vec<u32> = if scale.is_logarithmic() {
        let tens = (0..9).map(|e| 10_u32.pow(e)).filter(|&t| t < most / 2);
        [0].into_iter().chain(tens).chain([most]).collect()
    } else {
        vec![0, most / 4, most / 2, most / 4 * 3, most]
    };
    for tick in ticks {
        let x = 14.0 + 532.0 * scale.share(tick);
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"14\" y2=\"19\"/><text class=\"tick\" x=\"{x:.1}\" y=\"33\" text-anchor=\"middle\">{}</text>",
            count(f64::from(tick))
        );
    }
    svg + "</svg>"
}

/// Any two maps held against each other, and a table of all pairs; nothing for fewer than two.
pub fn differences(pictures: &Pictures) -> String {
    let maps = &pictures.maps;
    let by_mean = |a: &&(usize, &Map), b: &&(usize, &Map)| a.1.mean().total_cmp(&b.1.mean());
    let numbered: Vec<(usize, &Map)> = maps.iter().enumerate().collect();
    let (Some((best, _)), Some((worst, _))) = (
        numbered.iter().min_by(by_mean),
        numbered.iter().max_by(by_mean),
    ) else {
        return String::new();
    };
    if maps.len() < 2 {
        return String::new();
    }
    // All equal: any two will do.
    let worst = if best == worst {
        &((best + 1) % maps.len())
    } else {
        worst
    };
    let [width, height] = pictures.size;
    let mut style = String::new();
    let (mut inputs, mut picks) = (String::new(), [String::new(), String::new()]);
    for (i, map) in &numbered {
        let _ = write!(style, ":root{{--m{i}:url({})}}", data(&map.grey));
        for (side, chosen, pick) in [("a", worst, 0), ("b", best, 1)] {
            let checked = if i == chosen { " checked" } else { "" };
            let name = Escaped(&map.structure);
            let _ = write!(
                inputs,
                "<input type=\"radio\" name=\"pick-{side}\" id=\"{side}{i}\" aria-label=\"{side}: {name}\"{checked}>"
            );
            let _ = write!(picks[pick], "<label for=\"{side}{i}\">{name}</label>");
            let _ = write!(
                style,
                "#{side}{i}:checked~.stage .{side}{{background-image:var(--m{i})}}#{side}{i}:checked~.pick label[for={side}{i}]{{background:var(--ink);color:var(--paper)}}#{side}{i}:focus-visible~.pick label[for={side}{i}]{{outline:2px solid var(--green);outline-offset:2px}}"
            );
        }
    }
    let [a, b] = picks;
    format!(
        "<style>{style}</style>{}<div class=\"difference\">{inputs}\
        <div class=\"pick\"><b>A</b>{a}</div><div class=\"pick\"><b>B</b>{b}</div>\
        <div class=\"stage\" role=\"img\" aria-label=\"Cost of A over cost of B per pixel\" style=\"aspect-ratio:{width}/{height};max-width:{}px\">\
        <div class=\"a\"></div><div class=\"b\"></div></div></div>{}\
        <h3>All pairs</h3><p class=\"small\">Steps of the row over steps of the column, in the mean of all pixels.</p>{}",
        filter(pictures.scale.most()),
        width.max(720),
        ratio_legend(),
        pairs(maps)
    )
}

/// The filter that turns the mixed grey into colours.
fn filter(most: u32) -> String {
    // From black to white are so many octaves, both ways.
    let span = f64::from(most) + 1.0;
    let table = |channel: usize| {
        let entries = (0..ENTRIES).map(|i| {
            let grey = i as f64 / (ENTRIES - 1) as f64;
            let octaves = 2.0 * (grey - 0.5) * span.log2();
            round(f64::from(ratio_colour(octaves)[channel]) / 255.0)
        });
        entries.collect::<Vec<_>>().join(" ")
    };
    let [r, g, b] = [0, 1, 2].map(table);
    format!(
        "<svg width=\"0\" height=\"0\" class=\"hidden\" aria-hidden=\"true\"><filter id=\"ratio\" color-interpolation-filters=\"sRGB\" x=\"0\" y=\"0\" width=\"1\" height=\"1\"><feComponentTransfer><feFuncR type=\"table\" tableValues=\"{r}\"/><feFuncG type=\"table\" tableValues=\"{g}\"/><feFuncB type=\"table\" tableValues=\"{b}\"/></feComponentTransfer></filter></svg>"
    )
}

/// Blue where A costs less, red where it costs more, nearly white where both cost the same (ColorBrewer's RdBu).
fn ratio_colour(octaves: f64) -> [u8; 3] {
    const BLUE: [[u8; 3]; 4] = [
        [247, 247, 247],
        [146, 197, 222],
        [67, 147, 195],
        [33, 102, 172],
    ];
    const RED: [[u8; 3]; 4] = [
        [247, 247, 247],
        [244, 165, 130],
        [214, 96, 77],
        [178, 24, 43],
    ];
    let side = if octaves < 0.0 { BLUE } else { RED };
    let place = (octaves.abs() / OCTAVES).min(1.0) * 3.0;
    let i = (place as usize).min(2);
    let t = place - i as f64;
    std::array::from_fn(|c| {
        let (from, to) = (f64::from(side[i][c]), f64::from(side[i + 1][c]));
        (from + (to - from) * t).round() as u8
    })
}

fn ratio_legend() -> String {
    let stop = |i: i32| {
        let octaves = f64::from(i) / 4.0;
        let [r, g, b] = ratio_colour(octaves);
        let offset = (octaves + OCTAVES) / (2.0 * OCTAVES);
        format!("<stop offset=\"{offset:.4}\" stop-color=\"#{r:02x}{g:02x}{b:02x}\"/>")
    };
    let stops: String = (-8..=8).map(stop).collect();
    let labels = ["B costs 4 ×", "2 ×", "equal", "2 ×", "A costs 4 ×"];
    let texts: String = (0..5)
        .map(|i| {
            let anchor = ["start", "middle", "middle", "middle", "end"][i];
            let x = [0.0, 140.0, 280.0, 420.0, 560.0][i];
            format!(
                "<text class=\"tick\" x=\"{x}\" y=\"31\" text-anchor=\"{anchor}\">{}</text>",
                labels[i]
            )
        })
        .collect();
    format!(
        "<svg class=\"legend\" viewBox=\"0 0 560 38\" role=\"img\" aria-label=\"Scale of the differences\"><defs><linearGradient id=\"rdbu\">{stops}</linearGradient></defs><rect width=\"560\" height=\"14\" rx=\"2\" fill=\"url(#rdbu)\"/>{texts}</svg>"
    )
}

fn pairs(maps: &[Map]) -> String {
    let means: Vec<f64> = maps.iter().map(|map| map.mean().max(1e-9)).collect();
    let mut html = "<div class=\"wide\"><table class=\"pairs\"><thead><tr><th></th>".to_string();
    for map in maps {
        let _ = write!(html, "<th>{}</th>", Escaped(&map.structure));
    }
    html += "</tr></thead><tbody>";
    for (i, (map, mean)) in maps.iter().zip(&means).enumerate() {
        let _ = write!(
            html,
            "<tr><th scope=\"row\">{}</th>",
            Escaped(&map.structure)
        );
        for (j, other) in means.iter().enumerate() {
            if i == j {
                html += "<td class=\"self\"></td>";
                continue;
            }
            let ratio = mean / other;
            let [r, g, b] = ratio_colour(ratio.log2());
            let ink = if ratio.log2().abs() > 0.6 * OCTAVES {
                "#fff"
            } else {
                "#1c1c1a"
            };
            let _ = write!(
                html,
                "<td style=\"background:#{r:02x}{g:02x}{b:02x};color:{ink}\">{}</td>",
                number(Some(ratio), 2)
            );
        }
        html += "</tr>";
    }
    html + "</tbody></table></div>"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_have_their_colours() {
        assert_eq!(ratio_colour(0.0), [247, 247, 247]);
        assert_eq!(ratio_colour(2.0), ratio_colour(9.0));
        let (less, more) = (ratio_colour(-1.0), ratio_colour(1.0));
        assert!(less[2] > less[0] && more[0] > more[2]);
    }

    #[test]
    fn pictures_are_part_of_the_page() {
        assert_eq!(data(b"PNG"), "data:image/png;base64,UE5H");
    }
}
