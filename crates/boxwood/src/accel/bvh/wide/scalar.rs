//! The same walk box by box: for rays outside the doors, which need double precision, and for those that want to know why.

use super::node::Child;
use super::tree::Tree;
use crate::geometry::frame::Frame;
use crate::geometry::{Aabb, PreparedRay};
use crate::primitive;
use crate::query::{Counters, Query, Step, Verdict};
use crate::simd::Portable;
use alloc::vec::Vec;

/// Shows the primitives that the ray may meet to the query, at any level and for any ray.
#[cold]
pub fn walk<T: Tree<N>, Q: Query, C: Counters, const N: usize>(
    tree: &T,
    from: Child,
    ray: &PreparedRay,
    query: &mut Q,
    counters: &mut C,
) {
    let (frame, bounds) = (tree.frame(), tree.bounds());
    let sight = Sight::new(ray, frame, tree.slackened().unwrap_or(1.0));
    let root = frame.seen(&bounds);
    let slabs = sight.slabs(&root);
    let (enter, t_max) = (slabs.0, query.t_max());
    let entered = sight.enters(&root, t_max).is_some();
    if C::EXPLAINS {
        counters.step(Step::of_box(
            0,
            bounds,
            slabs,
            ray.t_min,
            t_max,
            Verdict::Opened,
        ));
    }
    // Far to near; the last one comes next.
    let mut stack = Vec::new();
    if entered {
        stack.push((enter, 0, from));
    }
    let mut direct = true;
    while let Some((enter, number, child)) = stack.pop() {
        if !direct {
            let dropped = !(enter <= query.t_max());
            if C::EXPLAINS {
                counters.step(Step::Resumed {
                    node: number,
                    enter,
                    dropped,
                });
            }
            if dropped {
                continue;
            }
        }
        direct = false;
        if child.is_leaf() {
            counters.leaf();
            if C::EXPLAINS {
                counters.step(Step::Leaf {
                    node: number,
                    primitives: tree.leaves().ids(child.blocks()).count() as u32,
                });
            }
            for block in child.blocks() {
                for id in tree.leaves().ids(block..block + 1) {
                    let (primitives, id, part) = (tree.primitives(), id as usize, tree.part(block));
                    if primitive::offer_part(primitives, id, part, ray, query, counters).is_break()
                    {
                        return;
                    }
                }
            }
            continue;
        }
        counters.node();
        let from = stack.len();
        let t_max = query.t_max();
        for lane in 0..N {
            let below = tree.child(child.index(), lane);
            if below == Child::NOTHING {
                continue;
            }
            let bounds = tree.child_bounds(child.index(), lane, ray.is_tame());
            if let Some(enter) = sight.enters(&bounds, t_max) {
                stack.push((enter, child.number::<N>(lane), below));
            } else if C::EXPLAINS {
                let number = child.number::<N>(lane);
                let slabs = sight.slabs(&bounds);
                counters.step(Step::of_box(
                    number,
                    tree.in_world(&bounds),
                    slabs,
                    ray.t_min,
                    t_max,
                    Verdict::Missed,
                ));
            }
        }
        if Q::ORDERED {
            stack[from..].sort_by(|a, b| b.0.total_cmp(&a.0));
        }
        direct = stack.len() > from;
        if C::EXPLAINS {
            for (place, &(_, number, _)) in stack[from..].iter().enumerate().rev() {
                let lane = (number as usize - 1) % N;
                let bounds = tree.child_bounds(child.index(), lane, ray.is_tame());
                let otherwise = if from + place + 1 == stack.len() {
                    Verdict::Opened
                } else {
                    Verdict::Deferred
                };
                let slabs = sight.slabs(&bounds);
                counters.step(Step::of_box(
                    number,
                    tree.in_world(&bounds),
                    slabs,
                    ray.t_min,
                    t_max,
                    otherwise,
                ));
            }
        }
    }
}

/// How a ray meets boxes that a frame sees: as the loops in lanes do, so that explanations tell of the same steps; outside the
/// doors in the world, which double precision tells apart anywhere.
struct Sight<'a> {
    ray: PreparedRay,
    frame: Option<&'a Frame>,
}

impl<'a> Sight<'a> {
    /// With so many times the slack.
    fn new(ray: &PreparedRay, frame: &'a Frame, times: f32) -> Self {
        match PreparedRay::tame(Portable, ray, frame, times * PreparedRay::SLACK) {
            Some((ray, _)) => Self { ray, frame: None },
            None => Self {
                ray: *ray,
                frame: Some(frame),
            },
        }
    }

    fn met(&self, b: &Aabb) -> Aabb {
        self.frame.map_or(*b, |frame| frame.in_world(b))
    }

    /// As [`PreparedRay::slabs`].
    fn slabs(&self, b: &Aabb) -> (f32, f32) {
        self.ray.slabs(&self.met(b))
    }

    /// As [`PreparedRay::enters`].
    fn enters(&self, b: &Aabb, t_max: f32) -> Option<f32> {
        self.ray.enters(&self.met(b), t_max)
    }
}
