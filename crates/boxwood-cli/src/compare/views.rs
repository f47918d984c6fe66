//! Pictures for the report: what the camera sees, and where each structure spends its work on it.

use super::report::Structure;
use super::{Candidate, Job};
use crate::failure::Outcome;
use crate::progress::Progress;
use boxwood::{Intersect, TraversalStats};
use boxwood_render::{HeatScale, Options, PngOptions, Renderer, Setup, workload};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Structures whose map would take longer are left out.
const PATIENCE: f64 = 20.0;
/// Pixels between two signs of life.
const STRETCH: usize = 1024;

/// Pictures of one size.
pub struct Pictures {
    pub size: [u32; 2],
    /// A PNG of the rendered view.
    pub view: Vec<u8>,
    pub scale: HeatScale,
    pub maps: Vec<Map>,
    /// Structures that have no map because it would have taken too long.
    pub left_out: Vec<String>,
}

/// Where one structure spends its work.
pub struct Map {
    pub structure: String,
    /// Inner nodes (or cells) and primitives visited, per pixel.
    pub costs: Vec<u32>,
    /// In colours on the common scale.
    pub png: Vec<u8>,
    /// In grey, logarithmic: the difference of two is the ratio of their costs.
    pub grey: Vec<u8>,
}

impl Map {
    /// Steps of the mean pixel.
    pub fn mean(&self) -> f64 {
        let sum: u64 = self.costs.iter().map(|&cost| u64::from(cost)).sum();
        sum as f64 / self.costs.len().max(1) as f64
    }
}

impl Job<'_> {
    /// Renders the view and counts steps for every pixel, in the caller's pool.
    pub(super) fn pictures(
        &self,
        candidates: &[Candidate<'_>],
        structures: &[Structure],
    ) -> Outcome<Pictures> {
        let size = self.args.size.0;
        let rays = workload::view(&self.camera, size);
        let mut costs = Vec::new();
        let mut left_out = Vec::new();
        for (Candidate(kind, outcome), found) in candidates.iter().zip(structures) {
            let Ok(built) = outcome else { continue };
            let rate = found
                .measured
                .as_ref()
                .and_then(|m| m.rays.first()?.mrays_per_second);
            if rate.is_none_or(|rate| rays.len() as f64 / (rate * 1e6) > PATIENCE) {
                left_out.push(kind.to_string());
                continue;
            }
            let progress = Progress::bar(format!("Drawing {kind}"));
            costs.push((kind.to_string(), count(&*built.structure, &rays, &progress)));
        }
        let scale = HeatScale::of(costs.iter().map(|(_, costs)| &costs[..]));
        let maps = costs.into_iter().map(|(structure, costs)| {
            Ok(Map {
                structure,
                png: scale.png(&costs, size)?,
                grey: scale.grey_png(&costs, size)?,
                costs,
            })
        });
        Ok(Pictures {
            size,
            maps: maps.collect::<Outcome<_>>()?,
            view: self.view()?,
            scale,
            left_out,
        })
    }

    fn view(&self) -> Outcome<Vec<u8>> {
        let renderer = {
            let _progress = Progress::spinner("Laying out the scene");
            Renderer::new(&self.file.scene, &Setup::default())?
        };
        let options = Options {
            size: self.args.size.0,
            ..Options::default()
        };
        options.check()?;
        let progress = Progress::bar("Rendering");
        let film = renderer.render(&self.camera, &options, &|done, of| progress.at(done, of));
        Ok(film.png(&PngOptions::default())?)
    }
}

/// Steps of each ray in search of its nearest hit.
fn count(structure: &dyn Intersect, rays: &[boxwood::Ray], progress: &Progress) -> Vec<u32> {
    let done = AtomicUsize::new(0);
    let steps = |ray: &boxwood::Ray| {
        let mut one = TraversalStats::default();
        structure.closest_hit_counted(ray, &mut one);
        u32::try_from(one.nodes + one.primitives).unwrap_or(u32::MAX)
    };
    let stretches = rays.par_chunks(STRETCH).flat_map_iter(|stretch| {
        let costs: Vec<u32> = stretch.iter().map(steps).collect();
        let before = done.fetch_add(stretch.len(), Ordering::Relaxed);
        progress.at(before + stretch.len(), rays.len());
        costs
    });
    stretches.collect()
}
