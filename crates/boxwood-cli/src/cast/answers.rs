//! What the rays are asked, and the answers as arrays.

use crate::npz::Archive;
use boxwood::{Hit, Intersect, Ray};
use boxwood_render::Layout;
use boxwood_scene::Located;
use rayon::prelude::*;
use std::io;

/// The number of nothing, where a number of something stands.
const NONE: u32 = u32::MAX;

/// What the rays are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// The nearest hit.
    Closest,
    /// Is anything there?
    Any,
    /// All hits.
    All,
}

/// The answers, one for each ray.
pub enum Answers {
    Closest(Vec<Option<Hit>>),
    Any(Vec<bool>),
    All(Vec<Vec<Hit>>),
}

impl Question {
    /// Room for the answers, made before the clock starts.
    pub fn answers(self, rays: usize) -> Answers {
        match self {
            Self::Closest => Answers::Closest(vec![None; rays]),
            Self::Any => Answers::Any(vec![false; rays]),
            Self::All => Answers::All(vec![Vec::new(); rays]),
        }
    }
}

impl Answers {
    /// Asks a structure about all rays, in the caller's rayon pool.
    pub fn ask(&mut self, structure: &dyn Intersect, rays: &[Ray]) {
        match self {
            Self::Closest(hits) => structure.closest_hits(rays, hits),
            Self::Any(occluded) => structure.occluded_each(rays, occluded),
            Self::All(hits) => rays
                .par_iter()
                .zip(hits)
                .with_min_len(64)
                .for_each(|(ray, hits)| *hits = structure.all_hits(ray)),
        }
    }

    /// How many hits; of [`Question::Any`], how many rays hit anything.
    pub fn hits(&self) -> u64 {
        match self {
            Self::Closest(hits) => hits.iter().flatten().count() as u64,
            Self::Any(occluded) => occluded.iter().filter(|&&o| o).count() as u64,
            Self::All(hits) => hits.iter().map(|h| h.len() as u64).sum(),
        }
    }

    /// The answers as a NumPy archive.
    pub fn archive(&self, layout: &Layout, rays: &[Ray], normals: bool) -> io::Result<Vec<u8>> {
        let mut archive = Archive::new();
        match self {
            Self::Closest(hits) => {
                let hits: Vec<_> = rays.iter().zip(hits.iter().copied()).collect();
                add_hits(&mut archive, layout, &hits, normals)?;
            }
            Self::Any(occluded) => archive.add("occluded", occluded.iter().copied())?,
            Self::All(lists) => {
                let mut end = 0_u64;
                let ends = lists.iter().map(|hits| {
                    end += hits.len() as u64;
                    end
                });
                archive.add("offsets", std::iter::once(0).chain(ends))?;
                let hits: Vec<_> = rays
                    .iter()
                    .zip(lists)
                    .flat_map(|(ray, hits)| hits.iter().map(move |&hit| (ray, Some(hit))))
                    .collect();
                add_hits(&mut archive, layout, &hits, normals)?;
            }
        }
        archive.finish()
    }
}

/// Adds one row for each hit or miss.
fn add_hits(
    archive: &mut Archive,
    layout: &Layout,
    hits: &[(&Ray, Option<Hit>)],
    normals: bool,
) -> io::Result<()> {
    let each = || hits.iter().map(|(_, hit)| hit);
    archive.add("t", each().map(|hit| hit.map_or(f32::INFINITY, |h| h.t)))?;
    archive.add("u", each().map(|hit| hit.map_or(0.0, |h| h.u)))?;
    archive.add("v", each().map(|hit| hit.map_or(0.0, |h| h.v)))?;
    let located: Vec<_> = hits
        .par_iter()
        .map(|(_, hit)| hit.map(|h| layout.locate(&h)))
        .collect();
    add_located(archive, &located)?;
    if normals {
        let normals: Vec<[f32; 3]> = hits
            .par_iter()
            .map(|(ray, hit)| {
                hit.map_or([0.0; 3], |hit| layout.surface(ray, &hit).normal.to_array())
            })
            .collect();
        archive.add_vectors("normal", normals)?;
    }
    Ok(())
}

/// Adds the numbers of some of the scene's triangles, as the files have them.
pub fn add_located(archive: &mut Archive, located: &[Option<Located>]) -> io::Result<()> {
    let located = || located.iter();
    archive.add(
        "primitive",
        located().map(|l| l.map_or(NONE, |l| l.primitive)),
    )?;
    archive.add("geometry", located().map(|l| l.map_or(NONE, |l| l.mesh)))?;
    archive.add(
        "instance",
        located().map(|l| l.map_or(NONE, |l| l.instance)),
    )
}
