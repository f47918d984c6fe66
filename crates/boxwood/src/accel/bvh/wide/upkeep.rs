//! Decides what a tree over moving primitives needs: to be fitted, to have parts built anew, or all of it.
//!
//! *How it works.* After each movement the tree is fitted, which also says what a ray that enters a node is expected to pay below it (the
//! surface-area heuristic). What that is more than it was when this part of the tree was built is lost with every ray; the losses of each
//! subtree are added up from frame to frame, as somebody who hires adds up what he has paid. When they come to as much as building the
//! subtree anew costs, it is built anew: then about twice as much is spent as by somebody who knew the future, as far as what is built anew is as
//! good as it was at first. Among subtrees within each other those are taken that save the most, and the whole tree is one of them. Everything
//! follows from boxes and counts, nothing from a clock: the same movements lead to the same decisions on every machine.
//!
//! *Cost.* One pass over the nodes besides fitting; 24 bytes for each block of a leaf and 64 for each node.
//!
//! *Source.* Karlin, Manasse, Rudolph & Sleator 1988, *Competitive Snoopy Caching* (to hire or to buy); Lauterbach, Yoon, Tuft & Manocha
//! 2006, *RT-DEFORM* (watching a cost), Yoon, Curtis & Manocha 2007 (subtrees).

use super::plan::NODE_COST;
use super::refit::{Fitting, inner};
use super::{WideBvh, WideSah};
use crate::accel::BuildError;
use crate::accel::limits::unlimited;
use crate::accel::sah::half_area;
use crate::primitive::Primitives;
use crate::simd::{Level, Vectorize, exactly};
use alloc::vec;
use alloc::vec::Vec;

/// A wide tree over primitives that move, kept good.
///
/// ```
/// use boxwood::{Decision, TriangleMesh, Upkeep, WideSah};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
/// let mut kept = Upkeep::new(mesh, WideSah::<8>::default(), 1.0e6);
/// let (moved, done) = kept.update(|mesh| mesh.move_vertices(corners.map(|p| p.map(|x| 2.0 * x))));
/// moved?;
/// assert_eq!(done.decision, Decision::Refit);
/// assert_eq!(kept.bvh().primitives().positions()[1].x, 2.0);
/// # Ok::<(), boxwood::MeshError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Upkeep<P, const N: usize> {
    /// How many rays are traced between two updates: what makes a good tree worth its price.
    pub rays: f64,
    bvh: WideBvh<P, N>,
    builder: WideSah<N>,
    past: Vec<Past>,
    built: f64,
    fitting: Fitting,
    costs: Vec<f64>,
}

/// What is remembered of a node.
#[derive(Clone, Copy, Debug)]
struct Past {
    /// What a ray that entered it was expected to pay below, when that was built.
    rate: f64,
    /// What rays have paid in vain since then.
    lost: f64,
    /// How many blocks of leaves lie below.
    blocks: u32,
}

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Boxes were fitted.
    Refit,
    /// Then some subtrees were built anew.
    Parts {
        /// How many.
        parts: usize,
        /// How many primitives are in them.
        primitives: usize,
    },
    /// The whole tree was built anew.
    Rebuild,
}

/// What an update did, and what a ray that meets the scene's box is expected to pay: in units of one block of four primitives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Updated {
    /// What was done.
    pub decision: Decision,
    /// The expected cost when the whole tree was built last.
    pub built: f64,
    /// The one after boxes were fitted.
    pub fitted: f64,
    /// The one now.
    pub cost: f64,
}

/// What building a block's primitives into a tree costs, in units of one block met by a ray.
const BUILD: f64 = 200.0;
/// What it costs to copy a block when parts of a tree are made anew.
const COPY: f64 = 4.0;
/// Parts of fewer blocks are not worth the while.
const LEAST: u32 = 64;

/// The builder of trees in which what moves is whole.
fn whole<const N: usize>(builder: WideSah<N>) -> WideSah<N> {
    WideSah {
        rebraid: 1,
        ..builder
    }
}

impl<P: Primitives + Sync, const N: usize> Upkeep<P, N>
where
    Level: Vectorize<N>,
{
    /// Builds a tree, to be kept good for so many rays between two updates.
    ///
    /// # Panics
    /// When there are more than a quarter of a billion primitives.
    pub fn new(primitives: P, builder: WideSah<N>, rays: f64) -> Self {
        Self::of(whole(builder).build(primitives), builder, rays)
    }

    /// Takes a tree from elsewhere; what is built anew is built by the builder.
    pub fn of(bvh: WideBvh<P, N>, builder: WideSah<N>, rays: f64) -> Self {
        let mut kept = Self {
            rays,
            bvh,
            builder: whole(builder),
            past: Vec::new(),
            built: 0.0,
            fitting: Fitting::default(),
            costs: Vec::new(),
        };
        exactly(|| {
            kept.weigh();
            kept.learn(&[]);
            kept.built = kept.cost();
        });
        kept
    }

    /// The tree, as of the last update.
    pub fn bvh(&self) -> &WideBvh<P, N> {
        &self.bvh
    }
    /// The tree, to be kept no longer.
    pub fn into_bvh(self) -> WideBvh<P, N> {
        self.bvh
    }

    /// Changes the primitives, follows them and does what pays; returns what `change` returns and what was done. As
    /// [`WideBvh::update`].
    ///
    /// # Panics
    /// When there are fewer or more primitives afterwards.
    pub fn update<A>(&mut self, change: impl FnOnce(&mut P) -> A) -> (A, Updated) {
        let answer = self.bvh.change(change);
        let updated = exactly(|| unlimited(self.follow()));
        (answer, updated)
    }

    /// Takes other primitives, of any number, and builds the tree anew.
    ///
    /// # Panics
    /// When there are more than a quarter of a billion primitives.
    pub fn replace(&mut self, primitives: P) {
        self.bvh.replace(primitives);
        exactly(|| unlimited(self.rebuild()));
    }

    fn follow(&mut self) -> Result<Updated, BuildError> {
        self.bvh.fit(&mut self.fitting);
        let chosen = if self.remember() {
            self.choose()
        } else {
            Vec::new()
        };
        let fitted = self.cost();
        let decision = match &*chosen {
            [] => Decision::Refit,
            [0] => self.rebuild()?,
            parts => self.rebuild_parts(parts)?,
        };
        Ok(Updated {
            decision,
            built: self.built,
            fitted,
            cost: self.cost(),
        })
    }

    /// What a ray is expected to pay.
    fn cost(&self) -> f64 {
        let area = half_area(&self.bvh.bounds);
        match self.costs.first() {
            Some(below) if area > 0.0 => f64::from(NODE_COST) + below / area,
            _ => self.bvh.leaves.len() as f64,
        }
    }

    /// Finds out what rays pay below each node now, adds up what they pay in vain, and says whether that is worth building any of them anew.
    fn remember(&mut self) -> bool {
        let all = half_area(&self.bvh.bounds);
        let mut worth = false;
        self.fitting
            .costs(&self.bvh.nodes, &mut self.costs, |i, cost, bounds| {
                let past = &mut self.past[i];
                let lost = self.rays * (cost - past.rate * half_area(bounds)) / all;
                // Of boxes without area there is nothing to say.
                if lost > 0.0 && lost < f64::INFINITY {
                    past.lost += lost;
                }
                worth |= past.lost > BUILD * f64::from(past.blocks);
            });
        worth
    }

    /// The nodes whose subtrees should be built anew, none below another one.
    fn choose(&self) -> Vec<u32> {
        // What is won by the best choice below each node, and whether that is the node itself.
        let mut best = vec![(0.0, false); self.past.len()];
        for (i, node) in self.bvh.nodes.iter().enumerate().rev() {
            let past = &self.past[i];
            let mut below: f64 = inner(node).map(|child| best[child].0).sum();
            if i == 0 {
                below -= COPY * f64::from(past.blocks);
            }
            let own = past.lost - BUILD * f64::from(past.blocks);
            let large = past.blocks >= LEAST || i == 0;
            let itself = large && own > below.max(0.0);
            best[i] = (if itself { own } else { below.max(0.0) }, itself);
        }
        let mut chosen = Vec::new();
        let mut open = Vec::from_iter(best.first().filter(|root| root.0 > 0.0).map(|_| 0));
        while let Some(i) = open.pop() {
            if best[i].1 {
                chosen.push(i as u32);
            } else {
                open.extend(inner(&self.bvh.nodes[i]).filter(|&child| best[child].0 > 0.0));
            }
        }
        chosen
    }

    /// Builds everything anew.
    fn rebuild(&mut self) -> Result<Decision, BuildError> {
        self.bvh.rebuild(&self.builder)?;
        self.weigh();
        self.past.clear();
        self.learn(&[]);
        self.built = self.cost();
        Ok(Decision::Rebuild)
    }

    /// Builds some subtrees anew.
    fn rebuild_parts(&mut self, chosen: &[u32]) -> Result<Decision, BuildError> {
        // What these have lost is settled, also for the nodes above.
        let mut settled = vec![0.0; self.past.len()];
        for &i in chosen {
            settled[i as usize] = self.past[i as usize].lost;
        }
        for (i, node) in self.bvh.nodes.iter().enumerate().rev() {
            settled[i] += inner(node).map(|child| settled[child]).sum::<f64>();
            self.past[i].lost = (self.past[i].lost - settled[i]).max(0.0);
        }
        let Some((before, primitives)) = self.bvh.rebuild_parts(&self.builder, chosen)? else {
            return self.rebuild();
        };
        self.weigh();
        self.learn(&before);
        Ok(Decision::Parts {
            parts: chosen.len(),
            primitives,
        })
    }

    /// What follows from the boxes of a tree that fits.
    fn weigh(&mut self) {
        self.fitting.weigh(&self.bvh.nodes);
        self.fitting
            .costs(&self.bvh.nodes, &mut self.costs, |_, _, _| ());
    }

    /// Remembers nodes that are new; of others, what they were before.
    fn learn(&mut self, before: &[u32]) {
        let mut past = Vec::with_capacity(self.bvh.nodes.len());
        for (i, bounds) in self.fitting.bounds.iter().enumerate() {
            let old = before.get(i).and_then(|&old| self.past.get(old as usize));
            past.push(old.copied().unwrap_or(Past {
                rate: self.costs[i] / half_area(bounds),
                lost: 0.0,
                blocks: 0,
            }));
        }
        for (i, node) in self.bvh.nodes.iter().enumerate().rev() {
            let leaves = node.slots().filter(|slot| slot.2.is_leaf());
            let own: usize = leaves.map(|slot| slot.2.blocks().len()).sum();
            past[i].blocks = own as u32 + inner(node).map(|child| past[child].blocks).sum::<u32>();
        }
        self.past = past;
    }
}
