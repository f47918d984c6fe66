//! Drawings as SVG: elements with attributes, a picture around them, and the scale of colours that all drawings share.
//!
//! *How it works.* An [`Element`] writes itself as it grows; whatever text it is given is escaped. A [`Picture`] is the
//! outermost element, with fonts and arrow heads. [`Window`](window::Window) maps a view of the scene to a place on the
//! paper. Nothing refers to anything outside the file.

mod window;

pub use window::{View, Window, section};

use boxwood_render::inferno_srgb;
use std::fmt::{Display, Write};

/// One element, with all that is in it.
#[derive(Clone, Debug)]
pub struct Element {
    name: &'static str,
    attributes: Vec<(String, String)>,
    content: String,
}

impl Element {
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            attributes: Vec::new(),
            content: String::new(),
        }
    }

    /// With an attribute; a later one of the same name replaces it.
    pub fn with(mut self, name: &str, value: impl Display) -> Self {
        let value = escaped(&value.to_string());
        match self.attributes.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = value,
            None => self.attributes.push((name.to_string(), value)),
        }
        self
    }

    /// With a length or a coordinate.
    pub fn at(self, name: &str, value: f64) -> Self {
        self.with(name, number(value))
    }

    /// Around a text.
    pub fn text(mut self, text: impl Display) -> Self {
        self.content += &escaped(&text.to_string());
        self
    }

    /// Takes an element in.
    pub fn add(&mut self, child: Element) {
        child.write_to(&mut self.content);
    }

    fn write_to(&self, out: &mut String) {
        let Self {
            name,
            attributes,
            content,
        } = self;
        let attributes: String = attributes
            .iter()
            .map(|(name, value)| format!(" {name}=\"{value}\""))
            .collect();
        // Writing to a string cannot fail.
        let _ = if content.is_empty() {
            writeln!(out, "<{name}{attributes}/>")
        } else if content.starts_with('<') {
            writeln!(out, "<{name}{attributes}>\n{content}</{name}>")
        } else {
            writeln!(out, "<{name}{attributes}>{content}</{name}>")
        };
    }
}

/// A group.
pub fn group() -> Element {
    Element::new("g")
}

/// A rectangle.
pub fn rectangle([x, y]: [f64; 2], [width, height]: [f64; 2]) -> Element {
    Element::new("rect")
        .at("x", x)
        .at("y", y)
        .at("width", width)
        .at("height", height)
}

/// A straight line.
pub fn line([x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) -> Element {
    Element::new("line")
        .at("x1", x1)
        .at("y1", y1)
        .at("x2", x2)
        .at("y2", y2)
}

/// A straight line with a head at its end.
pub fn arrow(from: [f64; 2], to: [f64; 2]) -> Element {
    line(from, to).with("marker-end", "url(#head)")
}

/// A disc.
pub fn dot([x, y]: [f64; 2], radius: f64) -> Element {
    Element::new("circle")
        .at("cx", x)
        .at("cy", y)
        .at("r", radius)
}

/// Strokes through points, each run of points one; closed ones end where they begin.
pub fn path<'a>(runs: impl IntoIterator<Item = &'a [[f64; 2]]>, closed: bool) -> Element {
    let mut d = String::new();
    for run in runs {
        for (i, [x, y]) in run.iter().enumerate() {
            let letter = if i == 0 { 'M' } else { 'L' };
            d += &format!("{letter}{} {}", number(*x), number(*y));
        }
        if closed && !run.is_empty() {
            d.push('Z');
        }
    }
    Element::new("path").with("d", d)
}

/// Many rectangles of one look, given by corner and size.
pub fn rectangles<'a>(all: impl IntoIterator<Item = &'a [[f64; 2]; 2]>) -> Element {
    let mut d = String::new();
    for [[x, y], [width, height]] in all {
        let [x, y, width, height, back] = [*x, *y, *width, *height, -*width].map(number);
        d += &format!("M{x} {y}h{width}v{height}h{back}Z");
    }
    Element::new("path").with("d", d)
}

/// A text that begins at a point.
pub fn label([x, y]: [f64; 2], text: impl Display) -> Element {
    Element::new("text").at("x", x).at("y", y).text(text)
}

/// The colour of a share from 0 to 1, on paper: the pale end of the scale is left out.
pub fn color(share: f64) -> String {
    let [r, g, b] = inferno_srgb(0.12 + 0.7 * share.clamp(0.0, 1.0) as f32);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A whole drawing.
pub struct Picture {
    root: Element,
    size: [f64; 2],
}

impl Picture {
    /// A white sheet of so many pixels.
    pub fn new([width, height]: [f64; 2]) -> Self {
        let mut root = Element::new("svg")
            .with("xmlns", "http://www.w3.org/2000/svg")
            .at("width", width)
            .at("height", height)
            .with(
                "viewBox",
                format!("0 0 {} {}", number(width), number(height)),
            )
            .with("font-family", "Helvetica, Arial, sans-serif")
            .with("font-size", 12);
        let mut head = Element::new("marker")
            .with("id", "head")
            .with("viewBox", "0 0 8 8")
            .with("refX", 7)
            .with("refY", 4)
            .with("markerWidth", 5)
            .with("markerHeight", 5)
            .with("orient", "auto");
        head.add(
            Element::new("path")
                .with("d", "M0 0L8 4L0 8Z")
                .with("fill", INK),
        );
        let mut definitions = Element::new("defs");
        definitions.add(head);
        root.add(definitions);
        root.add(rectangle([0.0; 2], [width, height]).with("fill", "#ffffff"));
        Self {
            root,
            size: [width, height],
        }
    }

    pub fn add(&mut self, element: Element) {
        self.root.add(element);
    }

    /// Pixels.
    pub fn size(&self) -> [f64; 2] {
        self.size
    }

    /// The whole file.
    pub fn finish(self) -> String {
        let mut text = String::new();
        self.root.write_to(&mut text);
        text
    }
}

/// A part of the paper, given by corner and size: what is drawn in it ends at its edges.
pub fn clipped([x, y]: [f64; 2], [width, height]: [f64; 2]) -> Element {
    let numbers = [x, y, width, height].map(number).join(" ");
    Element::new("svg")
        .at("x", x)
        .at("y", y)
        .at("width", width)
        .at("height", height)
        .with("viewBox", numbers)
}

/// Dark lines and letters.
pub const INK: &str = "#20242c";
/// Things in the background.
pub const PALE: &str = "#b9bec6";
/// Words of less weight.
pub const GRAY: &str = "#5a6270";
/// What lies in a scene.
pub const BODY: &str = "#e4e7eb";
/// What is opened.
pub const BLUE: &str = "#1f77b4";
/// What waits.
pub const ORANGE: &str = "#d98e04";
/// What is passed over, or costs too much.
pub const RED: &str = "#c0392b";
/// What is found.
pub const GREEN: &str = "#1a8a4a";

/// Without digits that nobody can see; numbers that are none are 0.
fn number(x: f64) -> String {
    let x = if x.is_finite() { x } else { 0.0 };
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".into()
    } else {
        text.into()
    }
}

fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            // XML has no way at all to write other control characters.
            c if c < ' ' && !"\t\n\r".contains(c) => safe.push('\u{fffd}'),
            '\u{fffe}' | '\u{ffff}' => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_is_said_stays_text() {
        let mut picture = Picture::new([10.0, 20.0]);
        let nasty = "\"><script>&\u{1}";
        let twice = label([1.0, 2.0], nasty).with("data-name", "old");
        picture.add(twice.with("data-name", nasty));
        let text = picture.finish();
        assert!(
            text.contains("&quot;&gt;&lt;script&gt;&amp;\u{fffd}"),
            "{text}"
        );
        assert!(!text.contains("<script") && !text.contains("old") && !text.contains('\u{1}'));
        assert!(text.starts_with("<svg xmlns=") && text.ends_with("</svg>\n"));
        assert!(text.contains("viewBox=\"0 0 10 20\""), "{text}");
    }

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (-0.001, "0"),
            (1.5, "1.5"),
            (100.0, "100"),
            (2.0 / 3.0, "0.67"),
            (f64::NAN, "0"),
        ] {
            assert_eq!(number(x), text);
        }
    }
}
