//! Which structures are worth having, and from how many rays on a slower build pays.
//!
//! *How it works.* A structure is on the frontier when no other one builds at least as fast and traces at least as fast.
//! Of two neighbours on it, the one that traces faster overtakes after `(b₂ − b₁) / (t₁ − t₂)` rays: so many that its
//! saved time has paid for its building.

use super::report::{Measured, Structure, contenders};

/// A structure's place in the plane of building and tracing.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    pub name: String,
    /// Seconds.
    pub build: f64,
    /// Nanoseconds per ray, one thread, the mean over the kinds of rays.
    pub trace: f64,
}

/// All contenders.
pub fn places(structures: &[Structure]) -> Vec<Place> {
    let place = |(s, m): (&Structure, &Measured)| {
        Some(Place {
            name: s.structure.clone(),
            // On a logarithmic axis nothing is done in no time.
            build: m.build_seconds.max(1e-7),
            trace: m.nanoseconds()?,
        })
    };
    contenders(structures).filter_map(place).collect()
}

/// Those that no other one beats in both, the fastest to build first.
pub fn frontier(places: &[Place]) -> Vec<&Place> {
    let mut sorted: Vec<&Place> = places.iter().collect();
    sorted.sort_by(|a, b| {
        a.build
            .total_cmp(&b.build)
            .then(a.trace.total_cmp(&b.trace))
    });
    let mut best = f64::INFINITY;
    sorted.retain(|place| {
        let better = place.trace < best;
        best = best.min(place.trace);
        better
    });
    sorted
}

/// From how many rays on the second of two neighbours on the frontier is done first, building included.
pub fn break_even(first: &Place, second: &Place) -> f64 {
    (second.build - first.build) / ((first.trace - second.trace) * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frontier_leaves_out_what_is_beaten() {
        let place = |name: &str, build, trace| Place {
            name: name.into(),
            build,
            trace,
        };
        let all = [
            place("slow", 3.0, 300.0),
            place("fine", 2.0, 100.0),
            place("quick", 1.0, 200.0),
            place("equal", 2.0, 100.0),
        ];
        let found = frontier(&all);
        let names: Vec<&str> = found.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["quick", "fine"]);
        assert!((break_even(found[0], found[1]) - 1e7).abs() < 1.0);
        assert!(frontier(&[]).is_empty());
    }
}
