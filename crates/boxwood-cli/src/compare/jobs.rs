//! Build and rays together: who is done first with how many rays, and whom the model of costs would have taken.

use super::frontier::{Place, places};
use super::report::{Chosen, Forecast, JobRow, Structure};

/// Powers of ten up to the last one.
const EXPONENTS: std::ops::RangeInclusive<u32> = 3..=9;

impl Forecast {
    /// Seconds until so many rays are traced.
    pub fn total(&self, rays: f64) -> f64 {
        self.build_seconds + rays * self.nanoseconds_per_ray * 1e-9
    }
}

impl Place {
    /// The same, as measured.
    pub fn total(&self, rays: f64) -> f64 {
        self.build + rays * self.trace * 1e-9
    }
}

/// A row for each number of rays; none where nobody competes.
pub fn rows(structures: &[Structure]) -> Vec<JobRow> {
    let places = places(structures);
    let expected = expected(structures, &places);
    let row = |exponent| {
        let rays = 10_u64.pow(exponent);
        let n = rays as f64;
        let first = places
            .iter()
            .min_by(|a, b| a.total(n).total_cmp(&b.total(n)))?;
        let chosen = expected
            .iter()
            .min_by(|a, b| a.1.total(n).total_cmp(&b.1.total(n)));
        Some(JobRow {
            rays,
            first: first.name.clone(),
            seconds: first.total(n),
            chosen: chosen.map(|(place, forecast)| Chosen {
                structure: place.name.clone(),
                expected_seconds: forecast.total(n),
                seconds: place.total(n),
            }),
        })
    };
    EXPONENTS.filter_map(row).collect()
}

/// Those of the contenders that have a forecast.
pub fn expected<'a>(
    structures: &'a [Structure],
    places: &'a [Place],
) -> Vec<(&'a Place, &'a Forecast)> {
    let forecast = |place: &Place| {
        let of = structures.iter().find(|s| s.structure == place.name)?;
        of.forecast.as_ref()
    };
    places
        .iter()
        .filter_map(|place| Some((place, forecast(place)?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_are_of_build_and_rays() {
        let place = Place {
            name: "fine".into(),
            build: 2.0,
            trace: 100.0,
        };
        assert!((place.total(1e7) - 3.0).abs() < 1e-9);
        assert!(rows(&[]).is_empty());
    }
}
