//! The walk: near child first, the other one put aside.

use super::node::MAX_DEPTH;
use super::{KdTree, inspect};
use crate::accel::cells::Mailbox;
use crate::geometry::{Aabb, PreparedRay, Ray};
use crate::inspect::{Cell, Statistics};
use crate::primitive::Primitives;
use crate::query::{Counters, Query, Step, Traverse, Verdict};

/// A child that was put aside, and where the ray is in it.
#[derive(Clone, Copy)]
struct Pending {
    node: u32,
    enter: f32,
    exit: f32,
}

impl<P: Primitives> Traverse for KdTree<P> {
    fn bounds(&self) -> Aabb {
        self.partition.space.bounds
    }

    fn statistics(&self) -> Statistics {
        inspect::statistics(&self.partition)
    }

    fn cells(&self, show: &mut dyn FnMut(&Cell<'_>)) {
        inspect::cells(&self.partition, show);
    }

    fn traverse<Q: Query, C: Counters>(&self, ray: &Ray, query: &mut Q, counters: &mut C) {
        let space = &self.partition.space;
        let nodes = &self.partition.nodes[..];
        let references = &self.partition.references[..];
        let Some(ray) = PreparedRay::new(ray, self.scale) else {
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
        let (mut enter, mut exit) = ray.slabs(&space.world);
        if C::EXPLAINS {
            counters.step(Step::of_box(
                0,
                space.world,
                (enter, exit),
                ray.t_min,
                query.t_max(),
                Verdict::Opened,
            ));
        }
        enter = if ray.t_min > enter { ray.t_min } else { enter };
        let t_max = query.t_max();
        exit = if t_max < exit { t_max } else { exit };
        if !(enter <= exit) {
            return;
        }
        let tame = ray.is_tame();
        let lines = ray.crossings();
        // Which child the ray meets first, by axis: 0 the lower, 1 the upper.
        let d = ray.direction;
        let first = [d.x < 0.0, d.y < 0.0, d.z < 0.0].map(usize::from);
        let mut met = Mailbox::new();
        let mut stack = [Pending {
            node: 0,
            enter: 0.0,
            exit: 0.0,
        }; MAX_DEPTH];
        let mut pending = 0;
        let mut current = 0;
        loop {
            let node = nodes[current];
            if !node.is_leaf() {
                counters.node();
                let (axis, plane) = (node.axis(), node.plane());
                let (early, late) = if tame {
                    let [inverse, enter, leave] = lines[axis];
                    let at = plane * inverse;
                    (at + enter, at + leave)
                } else {
                    ray.crossing(axis, plane)
                };
                let near = node.child() + first[axis];
                let far = node.child() + 1 - first[axis];
                if C::EXPLAINS {
                    counters.step(Step::Plane {
                        node: current as u32,
                        normal: core::array::from_fn(|k| f32::from(u8::from(k == axis))),
                        offset: plane,
                        t: (plane - ray.origin[axis]) / ray.direction[axis],
                        near: enter <= late,
                        far: enter > late || exit >= early,
                    });
                }
                if enter > late {
                    current = far;
                } else if exit < early {
                    current = near;
                } else {
                    stack[pending] = Pending {
                        node: far as u32,
                        enter: if early > enter { early } else { enter },
                        exit,
                    };
                    pending += 1;
                    exit = if late < exit { late } else { exit };
                    current = near;
                }
                continue;
            }
            if node.count() > 0 {
                counters.leaf();
                if C::EXPLAINS {
                    counters.step(Step::Leaf {
                        node: current as u32,
                        primitives: node.count() as u32,
                    });
                }
                let list = &references[node.places()];
                if met
                    .offer(&self.primitives, list, &ray, query, counters)
                    .is_break()
                {
                    return;
                }
            }
            // What is entered exactly at `t_max` may hold an equal hit of a lower primitive: only beyond is passed. What lies
            // deeper in the stack is entered later, but for the slack: so every one is asked.
            let t_max = query.t_max();
            loop {
                if pending == 0 {
                    return;
                }
                pending -= 1;
                let next = stack[pending];
                let dropped = next.enter > t_max;
                if C::EXPLAINS {
                    counters.step(Step::Resumed {
                        node: next.node,
                        enter: next.enter,
                        dropped,
                    });
                }
                if !dropped {
                    current = next.node as usize;
                    enter = next.enter;
                    exit = if t_max < next.exit { t_max } else { next.exit };
                    break;
                }
            }
        }
    }
}
