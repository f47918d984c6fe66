//! What a plane costs in any direction, and what it costs across an axis: counted by numbers that count.

use super::sheet::{INNER, MARGIN, Panel, Sheet, words};
use crate::failure::Outcome;
use crate::svg::{BLUE, INK, ORANGE, PALE, dot, line, path};
use boxwood::{Aabb, plane};
use std::cell::Cell;
use std::ops::{Add, Div, Mul, Sub};

/// Operations that were done.
#[derive(Clone, Copy, Default)]
struct Done {
    products: u32,
    sums: u32,
    quotients: u32,
}

thread_local! {
    static DONE: Cell<Done> = const { Cell::new(Done { products: 0, sums: 0, quotients: 0 }) };
}

/// A number that counts what is done with it.
#[derive(Clone, Copy)]
struct Counting(f32);

/// One more of a kind.
fn tick(kind: fn(&mut Done) -> &mut u32) {
    DONE.with(|done| {
        let mut now = done.get();
        *kind(&mut now) += 1;
        done.set(now);
    });
}

macro_rules! counting {
    ($($operator:ident $method:ident $count:ident $sign:tt,)*) => {
        $(impl $operator for Counting {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                tick(|done| &mut done.$count);
                Self(self.0 $sign other.0)
            }
        })*
    };
}

counting! {
    Add add sums +,
    Sub sub sums -,
    Mul mul products *,
    Div div quotients /,
}

/// What some work takes.
fn count<T>(work: impl FnOnce() -> T) -> (T, Done) {
    DONE.with(|done| done.set(Done::default()));
    let result = work();
    (result, DONE.with(Cell::get))
}

fn dot3(a: [Counting; 3], b: [Counting; 3]) -> Counting {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn draw() -> Outcome<String> {
    let ray = plane::ray([0.6, 0.8], [1.0, 0.55]);
    let [origin, direction] = [ray.origin, ray.direction].map(|v| v.to_array().map(Counting));
    // A plane in any direction, and one across x, both through the same point.
    let point = [3.4, 2.2, 0.0];
    let normal = [0.8, -0.6, 0.0].map(Counting);
    let (offset, _) = count(|| dot3(normal, point.map(Counting)));
    let (slanted, any) = count(|| (offset - dot3(normal, origin)) / dot3(normal, direction));
    // Of two parallel planes, what does not depend on the offset is worked out once.
    let (_, slab) = count(|| {
        let (start, inverse) = (
            dot3(normal, origin),
            Counting(1.0) / dot3(normal, direction),
        );
        [
            (offset - start) * inverse,
            (Counting(1.0) - start) * inverse,
        ]
    });
    let ((inverse, start), once) = count(|| {
        let inverse = Counting(1.0) / direction[0];
        (inverse, origin[0] * inverse)
    });
    let (upright, axis) = count(|| Counting(point[0]) * inverse - start);

    let mut sheet = Sheet::new(
        "Why axis-aligned?",
        "A plane in any direction needs two scalar products and a division for each ray; a plane across an axis one product and \
         one difference, once the ray has its reciprocals.",
    );
    let (gap, top) = (24.0, sheet.below);
    let side = 0.5 * (INNER - gap);
    let tall = side * 0.52;
    let b = Aabb::new([3.4, 1.4, -1.0], [5.2, 3.0, 1.0]);
    for (k, t) in [slanted.0, upright.0].into_iter().enumerate() {
        let x = MARGIN + k as f64 * (side + gap);
        let color = [ORANGE, BLUE][k];
        let mut panel = Panel::new([[0.0, 0.0], [8.0, 4.16]], [x, top + 24.0], [side, tall]);
        let title = ["A plane in any direction", "A plane across an axis"][k];
        sheet.add(
            words([x, top + 14.0], title)
                .with("font-weight", "bold")
                .with("fill", color),
        );
        let body = if k == 0 { turned(&b) } else { corners(&b) };
        let places = body.map(|p| panel.place(p));
        panel.add(
            path([&places[..]], true)
                .with("fill", color)
                .with("fill-opacity", 0.14)
                .with("stroke", color),
        );
        let along = if k == 0 { [0.6, 0.8] } else { [0.0, 1.0] };
        let [from, to] = [-9.0_f32, 9.0]
            .map(|s| panel.place([point[0] + s * along[0], point[1] + s * along[1]]));
        panel.add(
            line(from, to)
                .with("stroke", color)
                .with("stroke-width", 2.2),
        );
        panel.ray(&ray, 5.6);
        panel.add(dot(panel.window.place(ray.at(t)), 4.5).with("fill", color));
        let [x, y] = panel.window.place(ray.at(t));
        let shift = if k == 0 { 12.0 } else { -74.0 };
        panel.add(words(
            [x + shift, y + if k == 0 { 20.0 } else { -8.0 }],
            format!("t = {t:.2}"),
        ));
        sheet.add(panel.finish());
    }
    let rows = [
        (
            "",
            "any direction".to_string(),
            "across an axis".to_string(),
        ),
        ("the plane", "n · p = d".into(), "x = a".into()),
        (
            "once per ray and axis",
            "—".into(),
            format!("1/dx and ox · 1/dx: {}", told(&once, 1)),
        ),
        (
            "t of a ray",
            "(d − n · o) / (n · dir)".into(),
            "a · (1/dx) − ox · (1/dx)".into(),
        ),
        ("operations per plane", told(&any, 1), told(&axis, 1)),
        (
            "for the three slabs of a box",
            told(&slab, 3),
            told(&axis, 6),
        ),
        (
            "in all",
            format!("{}", 3 * total(&slab)),
            format!("{}", 6 * total(&axis)),
        ),
        (
            "memory of a box",
            format!("{} bytes", 3 * size_of::<[f32; 5]>()),
            format!("{} bytes", size_of::<Aabb>()),
        ),
    ];
    let mut y = top + tall + 56.0;
    for (k, (what, slanted, upright)) in rows.into_iter().enumerate() {
        if k == 1 {
            sheet.add(line([MARGIN, y - 15.0], [MARGIN + INNER, y - 15.0]).with("stroke", PALE));
        }
        let weight = if k == 0 || k == 6 { "bold" } else { "normal" };
        for (x, text, color) in [
            (0.0, what.to_string(), INK),
            (250.0, slanted, ORANGE),
            (560.0, upright, BLUE),
        ] {
            sheet.add(
                words([MARGIN + x, y], text)
                    .with("fill", color)
                    .with("font-weight", weight)
                    .with("font-size", 14),
            );
        }
        y += 24.0;
    }
    sheet.below = y - 12.0;
    Ok(sheet.finish())
}

fn total(done: &Done) -> u32 {
    done.products + done.sums + done.quotients
}

fn told(done: &Done, times: u32) -> String {
    let parts = [
        (done.products, "×"),
        (done.sums, "±"),
        (done.quotients, "÷"),
    ];
    let parts: Vec<String> = parts
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, sign)| format!("{} {sign}", count * times))
        .collect();
    parts.join(", ")
}

fn corners(b: &Aabb) -> [[f32; 2]; 4] {
    let (l, u) = (b.lower, b.upper);
    [[l.x, l.y], [u.x, l.y], [u.x, u.y], [l.x, u.y]]
}

/// A box whose side lies in the slanted plane.
fn turned(b: &Aabb) -> [[f32; 2]; 4] {
    let (l, size) = (b.lower, b.size());
    corners(b).map(|[x, y]| {
        let (s, t) = (x - l.x, y - l.y - 0.4 * size.y);
        [3.4 + 0.8 * s + 0.6 * t, 2.2 - 0.6 * s + 0.8 * t]
    })
}
