//! Axes for drawings, and colours for families of structures.

pub use crate::compare::text::round;
use std::fmt::Write;

/// A logarithmic axis between two positions of a drawing.
pub struct LogAxis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl LogAxis {
    /// Around all positive `values`, with some air; from and to are positions.
    pub fn around(values: impl IntoIterator<Item = f64>, from: f64, to: f64) -> Self {
        let good = values.into_iter().filter(|v| *v > 0.0 && v.is_finite());
        let (low, high) = good.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), v| {
            (a.min(v), b.max(v))
        });
        let (low, high) = if low <= high {
            (low, high)
        } else {
            (1.0, 10.0)
        };
        // At least one and a half octaves and a margin, so that ticks fit.
        let middle = (low * high).sqrt();
        let half = ((high / low).sqrt() * 1.25).max(1.7);
        Self {
            low: middle / half,
            high: middle * half,
            from,
            to,
        }
    }

    /// Where a value stands.
    pub fn at(&self, value: f64) -> f64 {
        let share = (value / self.low).ln() / (self.high / self.low).ln();
        self.from + share.clamp(-0.5, 1.5) * (self.to - self.from)
    }

    /// Round values, not too many.
    pub fn ticks(&self) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        let steps: &[f64] = match decades {
            d if d < 0.9 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
            d if d < 2.2 => &[1.0, 2.0, 5.0],
            d if d < 4.0 => &[1.0, 3.0],
            _ => &[1.0],
        };
        let exponents = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let every = if decades > 9.0 { 3 } else { 1 };
        exponents
            .filter(|e| e.rem_euclid(every) == 0)
            .flat_map(|e| steps.iter().map(move |s| s * 10_f64.powi(e)))
            .filter(|t| (self.low..=self.high).contains(t))
            .collect()
    }
}

/// The frame of a plot.
pub struct Frame {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

impl Frame {
    /// Grid lines and labels of both axes, and what they mean.
    pub fn draw(
        &self,
        x: &LogAxis,
        y: &LogAxis,
        labels: [&str; 2],
        texts: [fn(f64) -> String; 2],
    ) -> String {
        let mut svg = self.x_axis(x, labels[0], texts[0]);
        let (left, right, middle) = (self.left, self.right, (self.top + self.bottom) / 2.0);
        for tick in y.ticks() {
            let at = y.at(tick);
            let _ = write!(
                svg,
                r#"<line class="grid" x1="{left}" x2="{right}" y1="{at:.1}" y2="{at:.1}"/><text class="tick" x="{:.1}" y="{:.1}" text-anchor="end">{}</text>"#,
                left - 7.0,
                at + 4.0,
                texts[1](tick)
            );
        }
        let _ = write!(
            svg,
            r#"<text class="axis" transform="translate(11 {middle:.1}) rotate(-90)" text-anchor="middle">{}</text>"#,
            labels[1]
        );
        svg
    }

    /// Grid lines and labels of the x-axis alone.
    pub fn x_axis(&self, x: &LogAxis, label: &str, text: fn(f64) -> String) -> String {
        let mut svg = String::new();
        for tick in x.ticks() {
            let at = x.at(tick);
            let _ = write!(
                svg,
                r#"<line class="grid" x1="{at:.1}" x2="{at:.1}" y1="{}" y2="{}"/><text class="tick" x="{at:.1}" y="{:.1}" text-anchor="middle">{}</text>"#,
                self.top,
                self.bottom,
                self.bottom + 17.0,
                text(tick)
            );
        }
        let _ = write!(
            svg,
            r#"<text class="axis" x="{:.1}" y="{:.1}" text-anchor="middle">{label}</text>"#,
            (self.left + self.right) / 2.0,
            self.bottom + 37.0
        );
        svg
    }
}

/// The class that gives a structure its family's colour.
pub fn family(structure: &str) -> &'static str {
    let name = structure.split([':', ',']).next().unwrap_or_default();
    match name {
        "brute" | "boxes" => "f-plain",
        "grid" | "grid2" => "f-grid",
        "octree" => "f-octree",
        "kd" => "f-kd",
        "bsp" => "f-bsp",
        "bvh" => "f-bvh",
        _ => "f-other",
    }
}

/// A duration as an axis says it: `50 ms`.
pub fn duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s >= 1.0 => (s, "s"),
        s if s >= 1e-3 => (s * 1e3, "ms"),
        s => (s * 1e6, "µs"),
    };
    format!("{} {unit}", round(value))
}

/// Nanoseconds as an axis says them.
pub fn nanoseconds(ns: f64) -> String {
    if ns >= 1000.0 {
        duration(ns * 1e-9)
    } else {
        format!("{} ns", round(ns))
    }
}

/// A count with a letter: `30 k`.
pub fn count(n: f64) -> String {
    let (value, unit) = match n {
        n if n >= 1e12 => return format!("{n:.0e}"),
        n if n >= 1e9 => (n / 1e9, " G"),
        n if n >= 1e6 => (n / 1e6, " M"),
        n if n >= 1e4 => (n / 1e3, " k"),
        n => (n, ""),
    };
    format!("{}{unit}", round(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_their_values_and_tick_roundly() {
        let axis = LogAxis::around([0.01, 0.0, 10.0, f64::NAN], 0.0, 100.0);
        assert!(axis.at(0.01) > 0.0 && axis.at(10.0) < 100.0);
        assert_eq!(axis.ticks().len(), 7, "{:?}", axis.ticks());
        for nothing in [vec![], vec![0.0]] {
            assert!(!LogAxis::around(nothing, 0.0, 1.0).ticks().is_empty());
        }
        assert!(LogAxis::around([1e-9, 1e9], 0.0, 1.0).ticks().len() < 12);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(duration(0.0123), "12.3 ms");
        assert_eq!(duration(2.0), "2 s");
        assert_eq!(nanoseconds(1500.0), "1.5 µs");
        assert_eq!(count(12_340.0), "12.3 k");
        assert_eq!(
            [round(0.002), round(1.239), round(1200.0)],
            ["0.002", "1.24", "1200"]
        );
    }
}
