//! What was found, as it is written to JSON, and the figures that are made of it.

use crate::machine::Machine;
use crate::measure::{Noise, Question, Turns};
use crate::peers::Way;
use serde::Serialize;

/// Grows when a key changes its meaning; new keys do not count.
pub const FORMAT_VERSION: u32 = 1;

#[derive(Clone, Debug, Serialize)]
pub struct Report {
    pub format_version: u32,
    pub command: String,
    pub machine: Machine,
    pub rounds: u32,
    /// That traced.
    pub threads: usize,
    pub absent: Vec<Absent>,
    pub builds: Vec<Build>,
    pub series: Vec<Series>,
    pub summary: Vec<Summary>,
    pub notes: Vec<String>,
}

/// A scene or a peer that was asked for and is not there.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Absent {
    pub name: String,
    pub reason: String,
}

#[derive(Clone, Debug, Serialize)]
pub struct Build {
    pub scene: String,
    pub triangles: usize,
    pub contestant: String,
    /// By number of threads: one, and two where that makes a difference.
    pub seconds: Vec<f64>,
    pub bytes: Option<usize>,
}

/// One question about one kind of rays of one view.
#[derive(Clone, Debug, Serialize)]
pub struct Series {
    pub scene: String,
    pub view: String,
    pub rays: &'static str,
    pub coherent: bool,
    pub question: Question,
    pub count: usize,
    pub hits: usize,
    pub noise: Noise,
    pub turns: Vec<Turns>,
    pub ratios: Vec<Ratio>,
}

/// A contestant and a way to ask it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Column {
    pub name: String,
    pub way: Way,
}

impl Column {
    /// Of these turns.
    pub fn of(turns: &Turns) -> Self {
        Self {
            name: turns.contestant.clone(),
            way: turns.way,
        }
    }

    /// As a heading: the ordinary way goes without saying.
    pub fn title(&self) -> String {
        match self.way {
            Way::Single => self.name.clone(),
            way => format!("{} {way}", self.name),
        }
    }
}

/// A peer's time over Boxwood's in the same round: above one, Boxwood is faster.
#[derive(Clone, Debug, Serialize)]
pub struct Ratio {
    pub boxwood: Column,
    pub peer: Column,
    pub median: f64,
    pub lower_quartile: f64,
    pub upper_quartile: f64,
    /// The share of the peer's answers that are wrong: what is skipped costs no time.
    pub wrong: f64,
}

impl Series {
    /// Every peer against every one of Boxwood's own.
    pub fn ratios(turns: &[Turns]) -> Vec<Ratio> {
        let mut all = Vec::new();
        for own in turns.iter().filter(|t| t.own) {
            for peer in turns.iter().filter(|t| !t.own) {
                let mut ratios: Vec<f64> = peer
                    .nanoseconds
                    .iter()
                    .zip(&own.nanoseconds)
                    .map(|(peer, own)| peer / own)
                    .collect();
                ratios.sort_by(f64::total_cmp);
                all.push(Ratio {
                    boxwood: Column::of(own),
                    peer: Column::of(peer),
                    median: quantile(&ratios, 0.5),
                    lower_quartile: quantile(&ratios, 0.25),
                    upper_quartile: quantile(&ratios, 0.75),
                    wrong: f64::from(peer.disagreements.wrong()) / peer.rays_asked.max(1) as f64,
                });
            }
        }
        all
    }

    /// `sponza, gallery`
    pub fn place(&self) -> String {
        format!("{}, {}", self.scene, self.view)
    }
}

/// Of sorted numbers, between neighbours where it falls between them; NaN where there are none.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * sorted.len().saturating_sub(1) as f64;
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    match (sorted.get(below), sorted.get(above)) {
        (Some(a), Some(b)) => a + (b - a) * (place - place.floor()),
        _ => f64::NAN,
    }
}

/// The median of numbers in any order.
pub fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile(&sorted, 0.5)
}

/// NaN where there are none.
pub fn geometric_mean(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for number in numbers {
        sum += number.ln();
        count += 1;
    }
    (sum / f64::from(count)).exp()
}

/// What speed is spoken of by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// Primary and shadow rays.
    ClosestCoherent,
    /// Ambient occlusion, diffuse bounces and random segments.
    ClosestIncoherent,
    /// All of them.
    Occluded,
    OccludedCoherent,
    OccludedIncoherent,
}

impl Class {
    pub const ALL: [Self; 5] = [
        Self::ClosestCoherent,
        Self::ClosestIncoherent,
        Self::Occluded,
        Self::OccludedCoherent,
        Self::OccludedIncoherent,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::ClosestCoherent => "closest, coherent",
            Self::ClosestIncoherent => "closest, incoherent",
            Self::Occluded => "occluded",
            Self::OccludedCoherent => "occluded, coherent",
            Self::OccludedIncoherent => "occluded, incoherent",
        }
    }

    fn holds(self, series: &Series) -> bool {
        let (question, coherent) = match self {
            Self::ClosestCoherent => (Question::Closest, Some(true)),
            Self::ClosestIncoherent => (Question::Closest, Some(false)),
            Self::Occluded => (Question::Occluded, None),
            Self::OccludedCoherent => (Question::Occluded, Some(true)),
            Self::OccludedIncoherent => (Question::Occluded, Some(false)),
        };
        series.question == question && coherent.is_none_or(|c| c == series.coherent)
    }
}

/// The geometric mean over views of each view's geometric mean of medians.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    pub boxwood: Column,
    pub peer: Column,
    pub class: Class,
    pub mean: f64,
    pub worst: f64,
    pub worst_view: String,
    pub views: usize,
    /// The largest share of wrong answers in any of it.
    pub wrong: f64,
}

/// Over all that was measured.
pub fn summarize(all: &[Series]) -> Vec<Summary> {
    let mut pairs: Vec<(Column, Column)> = Vec::new();
    let mut places: Vec<String> = Vec::new();
    for series in all {
        if !places.contains(&series.place()) {
            places.push(series.place());
        }
        for ratio in &series.ratios {
            let pair = (ratio.boxwood.clone(), ratio.peer.clone());
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
    }
    let mut found = Vec::new();
    for (boxwood, peer) in pairs {
        for class in Class::ALL {
            let mut views: Vec<(f64, &String)> = Vec::new();
            let mut wrong = 0.0_f64;
            for place in &places {
                let series: Vec<&Series> = all
                    .iter()
                    .filter(|s| s.place() == *place && class.holds(s))
                    .collect();
                let ratios: Vec<&Ratio> = series
                    .iter()
                    .flat_map(|s| &s.ratios)
                    .filter(|r| r.boxwood == boxwood && r.peer == peer)
                    .collect();
                // Who took part in some of the series only, such as packets in those of coherent rays, has no mean of all.
                if !ratios.is_empty() && ratios.len() == series.len() {
                    views.push((geometric_mean(ratios.iter().map(|r| r.median)), place));
                }
                wrong = ratios.iter().map(|r| r.wrong).fold(wrong, f64::max);
            }
            let worst = views.iter().min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some(&(worst, place)) = worst {
                found.push(Summary {
                    boxwood: boxwood.clone(),
                    peer: peer.clone(),
                    class,
                    mean: geometric_mean(views.iter().map(|v| v.0)),
                    worst,
                    worst_view: place.clone(),
                    views: views.len(),
                    wrong,
                });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::Disagreements;

    fn turns(contestant: &str, own: bool, nanoseconds: &[f64]) -> Turns {
        Turns {
            contestant: contestant.to_string(),
            way: Way::Single,
            own,
            rays_asked: 1,
            nanoseconds: nanoseconds.to_vec(),
            nodes_per_ray: None,
            leaves_per_ray: None,
            primitives_per_ray: None,
            disagreements: Disagreements::default(),
        }
    }

    fn series(scene: &str, peer: &[f64]) -> Series {
        let turns = vec![turns("bvh", true, &[1.0; 3]), turns("embree", false, peer)];
        Series {
            scene: scene.to_string(),
            view: "main".to_string(),
            rays: "tile",
            coherent: true,
            question: Question::Closest,
            count: 1,
            hits: 1,
            noise: Noise {
                clock_drift: 0.0,
                waited: None,
            },
            ratios: Series::ratios(&turns),
            turns,
        }
    }

    #[test]
    fn quantiles_lie_between_neighbours() {
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.5), 2.0);
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), 3.0);
        assert_eq!(quantile(&[7.0], 0.25), 7.0);
        assert!(quantile(&[], 0.5).is_nan());
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
    }

    #[test]
    fn a_peer_that_takes_longer_is_above_one_and_views_count_alike() {
        let all = [
            series("a", &[4.0, 2.0, 9.0]),
            series("a", &[4.0, 4.0, 4.0]),
            series("b", &[1.0, 1.0, 1.0]),
        ];
        assert_eq!(all[0].ratios[0].median, 4.0);
        assert_eq!(all[0].ratios[0].lower_quartile, 3.0);
        let summary = summarize(&all);
        assert_eq!(summary.len(), 1);
        assert!((summary[0].mean - 2.0).abs() < 1e-12);
        assert_eq!((summary[0].worst, summary[0].views), (1.0, 2));
        assert_eq!(summary[0].wrong, 0.0);
        assert_eq!(summary[0].worst_view, "b, main");
    }
}
