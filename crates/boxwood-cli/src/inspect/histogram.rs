//! How often each number occurs.

use crate::terminal::grouped;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// How often each number was counted; as JSON a list of pairs, smallest number first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Histogram(BTreeMap<u32, u64>);

/// Bars are at most so long.
const LONGEST: u64 = 50;
/// And so many; beyond, neighbours share one.
const MOST: usize = 40;

impl Histogram {
    pub fn count(&mut self, n: u32) {
        *self.0.entry(n).or_insert(0) += 1;
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The largest number that was counted.
    pub fn last(&self) -> Option<u32> {
        self.0.last_key_value().map(|(&n, _)| n)
    }

    /// How often numbers from `first` to `last` were counted.
    pub fn between(&self, first: u32, last: u32) -> u64 {
        self.0.range(first..=last).map(|(_, times)| times).sum()
    }

    /// A line for each number or each range of numbers, from the smallest to the largest.
    pub fn bars(&self) -> String {
        let (Some((&first, _)), Some(last)) = (self.0.first_key_value(), self.last()) else {
            return String::new();
        };
        let span = u64::from(last - first) + 1;
        // Ranges are as wide as a round number.
        let width = (1..)
            .flat_map(|power| [1, 2, 5].map(|k| k * 10_u64.pow(power - 1)))
            .find(|width| span.div_ceil(*width) < MOST as u64)
            .unwrap_or(span);
        let start = u64::from(first) / width * width;
        let ranges: Vec<(u64, u64, u64)> = (start..=u64::from(last))
            .step_by(width as usize)
            .map(|from| {
                let to = from + width - 1;
                let clamped = |n: u64| u32::try_from(n).unwrap_or(u32::MAX);
                (from, to, self.between(clamped(from), clamped(to)))
            })
            .collect();
        let most = ranges.iter().map(|range| range.2).max().unwrap_or(1).max(1);
        let mut text = String::new();
        for (from, to, times) in ranges {
            let name = if width == 1 {
                grouped(from)
            } else {
                format!("{}-{}", grouped(from), grouped(to))
            };
            // What is there has a bar, be it ever so short.
            let length = (times * LONGEST).div_ceil(most) as usize;
            text += &format!("{name:>14} | {} {}\n", "#".repeat(length), grouped(times));
        }
        text
    }
}

impl Serialize for Histogram {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_have_their_length() {
        let mut histogram = Histogram::default();
        assert_eq!(histogram.bars(), "");
        for n in [2, 2, 2, 2, 4] {
            histogram.count(n);
        }
        let bars = histogram.bars();
        let lines: Vec<&str> = bars.lines().map(str::trim).collect();
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[0], format!("2 | {} 4", "#".repeat(50)));
        assert_eq!(lines[1], "3 |  0");
        assert_eq!(lines[2], format!("4 | {} 1", "#".repeat(13)));
        assert_eq!(histogram.between(0, 3), 4);
    }

    #[test]
    fn wide_ranges_have_few_bars() {
        let mut histogram = Histogram::default();
        for n in [0, 5, 1_000_000, u32::MAX] {
            histogram.count(n);
        }
        let bars = histogram.bars();
        assert!(bars.lines().count() <= MOST, "{bars}");
        assert!(bars.contains("# 3\n") && bars.contains("# 1\n"), "{bars}");
    }
}
