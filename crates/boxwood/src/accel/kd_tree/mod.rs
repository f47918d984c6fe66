//! The kd-tree: space cut in two by a plane across an axis, and each half again.
//!
//! *How it works.* The cells of the leaves tile the scene's box without gaps. A leaf names the primitives that reach into
//! its cell, so a primitive may be named by several; inner nodes name none. A ray that is in a cell from `enter` to `exit`
//! crosses the cell's plane somewhere: before that it is in the near half, after that in the far half, which is put aside.
//! So cells are met strictly in order, and the walk ends with the first one that holds the hit.
//! [`KdSah`] and [`KdLecture`] decide where to cut; both make a [`Partition`].
//!
//! *Why no hit is lost.* A hit at `t` stands for a point `q` of its primitive no farther than the slack from the ray's
//! point at `t`. Wherever a cell was cut, `q` went to a half that names the primitive (a point in the plane counts for
//! either), so one leaf has both. [`PreparedRay::crossing`](crate::PreparedRay) gives a plane's `early <= late`: for `q` in the near half
//! `t <= late`, for `q` in the far half `t >= early`. The near half is walked with `[enter, late]` and the far one with
//! `[early, exit]`, whenever these are not empty; so from the root down `t` lies in the interval of the cell that holds
//! `q`, and that leaf is opened unless a hit before `t` ends the walk. What is met by its box instead (shapes without the proof,
//! scenes of extreme size) is named wherever its box reaches; its hits lie within its own padded box, and as the bounds are
//! monotone in the plane the same two lines hold. Rays outside the doors of such a proof ask everything.
//!
//! *Cost.* Building takes O(n log n); 8 bytes per node and 4 per reference. References and leaves are at most a multiple of the
//! primitives, the depth at most [`MAX_DEPTH`], whatever the scene. More than 2²⁹ primitives are not divided at all.
//!
//! *Source.* Bentley 1975; Kaplan 1985; Havran 2000, *Heuristic Ray Shooting Algorithms*; Wald & Havran 2006, *On building fast
//! kd-Trees for Ray Tracing, and on doing that in O(N log N)*.

mod build;
mod hierarchy;
mod inspect;
mod node;
mod traverse;

pub use build::{AxisRule, KdLecture, KdSah, PlaneRule};
pub use node::{MAX_DEPTH, Partition};

use crate::primitive::Primitives;
use crate::simd::exactly;

/// A kd-tree over owned, borrowed or shared primitives.
#[derive(Clone, Debug)]
pub struct KdTree<P> {
    primitives: P,
    partition: Partition,
    /// The largest |coordinate| of the scene.
    scale: f32,
}

impl<P: Primitives> KdTree<P> {
    /// Takes a partition that a builder made for these primitives.
    ///
    /// # Panics
    /// When the partition was made for another number of primitives.
    pub fn new(primitives: P, partition: Partition) -> Self {
        assert_eq!(
            primitives.len(),
            partition.primitives,
            "a partition for other primitives"
        );
        Self {
            scale: exactly(|| partition.space.bounds.scale()),
            primitives,
            partition,
        }
    }

    /// The cells.
    pub fn partition(&self) -> &Partition {
        &self.partition
    }
    /// The primitives.
    pub fn primitives(&self) -> &P {
        &self.primitives
    }
}
