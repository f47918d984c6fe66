//! The sheet that all figures share: title, one sentence, and panels below.

use crate::svg::{
    Element, GRAY, INK, PALE, Picture, View, Window, arrow, clipped, dot, group, label, line,
    rectangle,
};
use boxwood::{Aabb, Ray, Vec3};
use std::fmt::Display;

pub const WIDTH: f64 = 900.0;
pub const MARGIN: f64 = 24.0;
/// What panels and writing may take.
pub const INNER: f64 = WIDTH - 2.0 * MARGIN;
/// Letters in a line of the sentence.
const LETTERS: usize = 112;
const LINE: f64 = 19.0;

/// A sheet that grows downwards.
pub struct Sheet {
    title: &'static str,
    sentence: Vec<String>,
    content: Element,
    /// Where the next thing begins.
    pub below: f64,
}

impl Sheet {
    pub fn new(title: &'static str, sentence: impl Display) -> Self {
        let mut lines = vec![String::new()];
        for word in sentence.to_string().split(' ') {
            if let Some(last) = lines.last_mut() {
                if last.is_empty() {
                    *last += word;
                } else if last.chars().count() + word.chars().count() < LETTERS {
                    *last += &format!(" {word}");
                } else {
                    lines.push(word.to_string());
                }
            }
        }
        Self {
            below: 62.0 + LINE * lines.len() as f64,
            title,
            sentence: lines,
            content: group(),
        }
    }

    pub fn add(&mut self, element: Element) {
        self.content.add(element);
    }

    /// Says something from a point on.
    pub fn say(&mut self, at: [f64; 2], text: impl Display) {
        self.add(words(at, text));
    }

    /// Says something in gray.
    pub fn note(&mut self, at: [f64; 2], text: impl Display) {
        self.add(words(at, text).with("fill", GRAY));
    }

    /// The whole file.
    pub fn finish(self) -> String {
        let mut picture = Picture::new([WIDTH, self.below + MARGIN]);
        let title = label([MARGIN, 38.0], self.title);
        picture.add(
            title
                .with("font-size", 22)
                .with("font-weight", "bold")
                .with("fill", INK),
        );
        for (k, text) in self.sentence.into_iter().enumerate() {
            let place = [MARGIN, 62.0 + LINE * k as f64];
            picture.add(label(place, text).with("font-size", 14).with("fill", GRAY));
        }
        picture.add(self.content);
        picture.finish()
    }
}

/// Words in the size of the figures.
pub fn words(at: [f64; 2], text: impl Display) -> Element {
    label(at, text).with("font-size", 13)
}

/// Words around a point.
pub fn centred(at: [f64; 2], text: impl Display) -> Element {
    words(at, text).with("text-anchor", "middle")
}

/// A framed part of the paper that shows a part of the plane.
pub struct Panel {
    pub window: Window,
    corner: [f64; 2],
    size: [f64; 2],
    inside: Element,
}

impl Panel {
    /// As much of the plane as `[lower, upper]`, fitted into a place.
    pub fn new([lower, upper]: [[f32; 2]; 2], corner: [f64; 2], size: [f64; 2]) -> Self {
        let bounds = Aabb::new([lower[0], lower[1], 0.0], [upper[0], upper[1], 0.0]);
        Self {
            window: Window::new(View::along(2), &bounds, corner, size),
            corner,
            size,
            inside: clipped(corner, size),
        }
    }
    pub fn add(&mut self, element: Element) {
        self.inside.add(element);
    }
    /// Where a point of the plane comes to lie.
    pub fn place(&self, [x, y]: [f32; 2]) -> [f64; 2] {
        self.window.place(Vec3::new(x, y, 0.0))
    }
    /// A box of the plane.
    pub fn rectangle(&self, b: &Aabb) -> Element {
        let [corner, size] = self.window.rectangle(b);
        rectangle(corner, size)
    }
    /// A ray up to `end`, where it has its head, and pale from there on.
    pub fn ray(&mut self, ray: &Ray, end: f32) {
        let far = ray.at(1.0e3 / ray.direction.length());
        let [from, to, far] = [ray.origin, ray.at(end), far].map(|p| self.window.place(p));
        self.add(
            line(to, far)
                .with("stroke", PALE)
                .with("stroke-dasharray", "4 4"),
        );
        let shaft = arrow(from, to).with("stroke", INK);
        self.add(shaft.with("stroke-width", 1.6));
        self.add(dot(from, 3.0).with("fill", INK));
    }
    /// With its frame.
    pub fn finish(self) -> Element {
        let mut framed = group();
        framed.add(self.inside);
        let frame = rectangle(self.corner, self.size).with("fill", "none");
        framed.add(frame.with("stroke", PALE));
        framed
    }
}
