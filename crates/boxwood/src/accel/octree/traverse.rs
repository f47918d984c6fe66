//! The walk: which children a ray may meet, nearest first.
//!
//! *Why nothing is lost.* A hit at `t` lies within slack of a point of the primitive in a cell that names it. On each axis
//! that cell lies on one side of each of its ancestors' planes; [`PreparedRay::crossing`] promises `t <= late` where that
//! is the side the ray comes from and `t >= early` where it is the other. A node's interval is the intersection of these
//! conditions, so it contains `t`, and a child is passed over only where its interval, cut to the ray's, is empty.

use super::MAX_DEPTH;
use super::node::{OctreeData, Place, rank};
use crate::accel::cells::Mailbox;
use crate::geometry::{Aabb, PreparedRay, Ray, Vec3};
use crate::inspect::{Cell, Statistics};
use crate::primitive::Primitives;
use crate::query::{Counters, Query, Step, Traverse, Verdict};

/// An octree over owned, borrowed or shared primitives.
#[derive(Clone, Debug)]
pub struct Octree<P> {
    primitives: P,
    data: OctreeData,
}

impl<P: Primitives> Octree<P> {
    /// Takes what a builder made for these primitives.
    ///
    /// # Panics
    /// When it was made for another number of primitives.
    pub fn new(primitives: P, data: OctreeData) -> Self {
        assert_eq!(
            primitives.len(),
            data.primitives,
            "an octree for other primitives"
        );
        Self { primitives, data }
    }

    /// The primitives.
    pub fn primitives(&self) -> &P {
        &self.primitives
    }
}

/// An opened node: the children that are still to be visited, and the ray's interval in it.
#[derive(Clone, Copy)]
struct Opened {
    first: u32,
    /// Which children exist.
    mask: u32,
    /// Which of them the ray may still meet, numbered as seen from the ray.
    ahead: u32,
    middle: Vec3,
    enter: f32,
    leave: f32,
}

/// Children in the lower half of an axis; children in the upper half of the one axis and the lower half of the other.
const LOW: [u32; 3] = [0b0101_0101, 0b0011_0011, 0b0000_1111];
const fn high_low(high: usize, low: usize) -> u32 {
    !LOW[high] & 0xff & LOW[low]
}

/// A mask of children as seen from a ray for which some axes are turned round.
static SEEN: [[u8; 256]; 8] = {
    let mut seen = [[0; 256]; 8];
    let mut flip = 0;
    while flip < 8 {
        let mut mask = 0;
        while mask < 256 {
            let mut octant = 0;
            while octant < 8 {
                if mask >> octant & 1 == 1 {
                    seen[flip][mask] |= 1 << (octant ^ flip);
                }
                octant += 1;
            }
            mask += 1;
        }
        flip += 1;
    }
    seen
};

/// Of `mask`, seen from the ray, the children that a ray with this interval may meet.
#[inline(always)]
fn ahead(ray: &PreparedRay, middle: Vec3, enter: f32, leave: f32, mask: u32) -> u32 {
    let (early_x, late_x) = ray.crossing(0, middle.x);
    let (early_y, late_y) = ray.crossing(1, middle.y);
    let (early_z, late_z) = ray.crossing(2, middle.z);
    // A child is met where the latest of its beginnings is no later than the earliest of its ends. Each line drops the
    // children of one such pair: a selection, not a jump.
    let mut ahead = mask;
    let mut keep = |met: bool, these: u32| ahead &= if met { 0xff } else { !these };
    keep(enter <= late_x, LOW[0]);
    keep(enter <= late_y, LOW[1]);
    keep(enter <= late_z, LOW[2]);
    keep(early_x <= leave, !LOW[0]);
    keep(early_y <= leave, !LOW[1]);
    keep(early_z <= leave, !LOW[2]);
    keep(early_x <= late_y, high_low(0, 1));
    keep(early_x <= late_z, high_low(0, 2));
    keep(early_y <= late_x, high_low(1, 0));
    keep(early_y <= late_z, high_low(1, 2));
    keep(early_z <= late_x, high_low(2, 0));
    keep(early_z <= late_y, high_low(2, 1));
    ahead & 0xff
}

impl<P: Primitives> Traverse for Octree<P> {
    fn bounds(&self) -> Aabb {
        self.data.space.bounds
    }
    fn statistics(&self) -> Statistics {
        self.data.statistics()
    }
    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        self.data.cells(show);
    }

    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        let OctreeData { space, nodes, .. } = &self.data;
        let Some(ray) = PreparedRay::new(ray, space.bounds.scale()) else {
            return;
        };
        if space.asks_all(&ray) {
            return space.ask_all(&self.primitives, &ray, query, counters);
        }
        if space
            .ask_everywhere(&self.primitives, &ray, query, counters)
            .is_break()
            || nodes.is_empty()
        {
            return;
        }
        let (enter, leave) = ray.slabs(&space.world);
        let enter = if enter < ray.t_min { ray.t_min } else { enter };
        let mut flip = 0;
        for axis in 0..3 {
            flip |= u32::from(ray.direction[axis] < 0.0) << axis;
        }
        let seen = &SEEN[(flip & 7) as usize];
        let half = self.data.root.half;
        let mut mailbox = Mailbox::new();
        // The path from the root, which is not in it: it is the child of nothing.
        let mut path = [Opened {
            first: 0,
            mask: 0,
            ahead: 0,
            middle: Vec3::ZERO,
            enter: 0.0,
            leave: 0.0,
        }; MAX_DEPTH + 1];
        let mut depth = 0;
        let mut number = 0;
        let mut middle = self.data.root.middle;
        let (mut enter, mut leave) = (enter, leave);
        let t_max = query.t_max();
        if !(enter <= leave && enter <= t_max) {
            return;
        }
        loop {
            let node = nodes[number as usize];
            if node.is_leaf() {
                counters.leaf();
                if C::EXPLAINS {
                    counters.step(Step::Leaf {
                        node: number,
                        primitives: node.count(),
                    });
                }
                let list = &self.data.references[node.places()];
                if mailbox
                    .offer(&self.primitives, list, &ray, query, counters)
                    .is_break()
                {
                    return;
                }
            } else {
                counters.node();
                let t_max = query.t_max();
                if leave > t_max {
                    leave = t_max;
                }
                let mask = u32::from(seen[(node.mask() & 0xff) as usize]);
                path[depth] = Opened {
                    first: node.first,
                    mask: node.mask(),
                    ahead: ahead(&ray, middle, enter, leave, mask),
                    middle,
                    enter,
                    leave,
                };
                depth += 1;
            }
            // The next child of the deepest node that has one.
            loop {
                let Some(top) = depth.checked_sub(1) else {
                    return;
                };
                let open = &mut path[top];
                if open.ahead == 0 {
                    depth = top;
                    continue;
                }
                let near = open.ahead.trailing_zeros();
                open.ahead &= open.ahead - 1;
                (enter, leave) = (open.enter, open.leave);
                let scale = HALVES[top + 1];
                middle = open.middle;
                let octant = near ^ flip;
                for axis in 0..3 {
                    let (early, late) = ray.crossing(axis, open.middle[axis]);
                    let quarter = half[axis] * scale;
                    if near >> axis & 1 == 1 {
                        enter = if early > enter { early } else { enter };
                    } else {
                        leave = if late < leave { late } else { leave };
                    }
                    middle[axis] += if octant >> axis & 1 == 1 {
                        quarter
                    } else {
                        -quarter
                    };
                }
                let child = open.first + rank(open.mask, octant);
                let beyond = enter > query.t_max();
                if C::EXPLAINS {
                    let half = half * scale;
                    counters.step(Step::Box {
                        node: child,
                        bounds: Place { middle, half }.bounds(&space.world),
                        enter,
                        leave,
                        verdict: if beyond {
                            Verdict::Beyond
                        } else {
                            Verdict::Opened
                        },
                    });
                }
                if !beyond {
                    number = child;
                    break;
                }
            }
        }
    }
}

/// 1, ½, ¼, …
static HALVES: [f32; MAX_DEPTH + 2] = {
    let mut halves = [1.0; MAX_DEPTH + 2];
    let mut i = 1;
    while i < halves.len() {
        halves[i] = 0.5 * halves[i - 1];
        i += 1;
    }
    halves
};
