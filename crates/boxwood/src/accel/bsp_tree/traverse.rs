//! The walk: the side of the plane that the ray comes from, then the other.
//!
//! *Why nothing is lost.* A hit at `t` lies, on each axis, within `slack` of a point `p` of the primitive, and (see
//! [`Fragments`](super::fragment)) some leaf names the primitive such that `p` is at most `2 δ = 2 pad · reach` on the wrong
//! side of any plane above it. So the ray's point at `t` is at most `(slack + 2 pad) · reach` on the wrong side, and a side is
//! passed over only for the part of the ray that lies farther on the other one. Distances of slanted planes are double precision;
//! their rounding is 2⁻⁵⁰ of the coordinates, far less than a hundredth of that, which is added.

use super::MAX_DEPTH;
use super::node::BspData;
use crate::accel::cells::Mailbox;
use crate::geometry::{Aabb, PreparedRay, Ray, Vec3};
use crate::inspect::{Cell, Statistics};
use crate::primitive::Primitives;
use crate::query::{Counters, Query, Step, Traverse};

/// A BSP tree over owned, borrowed or shared primitives.
#[derive(Clone, Debug)]
pub struct BspTree<P> {
    primitives: P,
    data: BspData,
}

impl<P: Primitives> BspTree<P> {
    /// Takes what a builder made for these primitives.
    ///
    /// # Panics
    /// When it was made for another number of primitives.
    pub fn new(primitives: P, data: BspData) -> Self {
        assert_eq!(
            primitives.len(),
            data.primitives,
            "a tree for other primitives"
        );
        Self { primitives, data }
    }

    /// The primitives.
    pub fn primitives(&self) -> &P {
        &self.primitives
    }
    /// The tree.
    pub fn data(&self) -> &BspData {
        &self.data
    }
}

/// How much longer a ray is near a plane across each axis because of what builders leave on the wrong side: `2 pad` along
/// the axis, as `t`.
fn margins(ray: &PreparedRay, pad: f32) -> Vec3 {
    let d = ray.direction.abs();
    // As in the slab test: a direction that is nearly along a plane counts as a little steeper.
    let floor = d.max_element() * (1.0 / (1 << 24) as f32);
    let mut margins = Vec3::ZERO;
    for axis in 0..3 {
        let steep = if d[axis] > floor { d[axis] } else { floor };
        let margin = 2.0 * pad / steep;
        margins[axis] = if margin.is_nan() { 0.0 } else { margin };
    }
    margins
}

impl<P: Primitives> Traverse for BspTree<P> {
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
        let BspData {
            space,
            nodes,
            planes,
            ..
        } = &self.data;
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
        let (mut enter, mut leave) = (
            if enter < ray.t_min { ray.t_min } else { enter },
            if leave > query.t_max() {
                query.t_max()
            } else {
                leave
            },
        );
        if !(enter <= leave) {
            return;
        }
        let (ox, oy, oz) = (
            ray.origin.x as f64,
            ray.origin.y as f64,
            ray.origin.z as f64,
        );
        let (dx, dy, dz) = (
            ray.direction.x as f64,
            ray.direction.y as f64,
            ray.direction.z as f64,
        );
        // How far on the wrong side a hit may be, for a plane of reach 1.
        let wrong = (ray.slack() + 2.0 * f64::from(space.pad())) * 1.01;
        let margins = margins(&ray, space.pad());
        // 1 where the ray comes from above.
        let from = [
            u32::from(dx < 0.0),
            u32::from(dy < 0.0),
            u32::from(dz < 0.0),
        ];
        let mut mailbox = Mailbox::new();
        let mut stack = [(0_u32, 0.0_f32, 0.0_f32); MAX_DEPTH];
        let mut pending = 0;
        let mut number = 0_u32;
        loop {
            let node = nodes[number as usize];
            if node.is_leaf() {
                if node.count() > 0 {
                    counters.leaf();
                    if C::EXPLAINS {
                        counters.step(Step::Leaf {
                            node: number,
                            primitives: node.count(),
                        });
                    }
                }
                let list = &self.data.references[node.places()];
                if mailbox
                    .offer(&self.primitives, list, &ray, query, counters)
                    .is_break()
                {
                    return;
                }
                // What lies entirely beyond the nearest hit is dropped; what begins exactly there may hold an equal one.
                loop {
                    if pending == 0 {
                        return;
                    }
                    pending -= 1;
                    (number, enter, leave) = stack[pending];
                    let t_max = query.t_max();
                    let dropped = enter > t_max;
                    if C::EXPLAINS {
                        counters.step(Step::Resumed {
                            node: number,
                            enter,
                            dropped,
                        });
                    }
                    if !dropped {
                        leave = if leave > t_max { t_max } else { leave };
                        break;
                    }
                }
                continue;
            }
            counters.node();
            let (near, early, late);
            if let Some((axis, at)) = node.across() {
                let (first, last) = ray.crossing(axis, at);
                (early, late) = (first - margins[axis], last + margins[axis]);
                near = from[axis];
            } else {
                let plane = &planes[node.plane()];
                let [x, y, z] = plane.normal.map(f64::from);
                let speed = x * dx + y * dy + z * dz;
                let start = x * ox + y * oy + z * oz - plane.offset;
                let wrong = wrong * f64::from(plane.reach);
                near = u32::from(speed < 0.0);
                // As if the ray came from below.
                let (start, speed) = if speed < 0.0 {
                    (-start, -speed)
                } else {
                    (start, speed)
                };
                let at_enter = start + speed * f64::from(enter);
                let at_leave = start + speed * f64::from(leave);
                // One side only, most of the time: then no division.
                if at_leave < -wrong {
                    (early, late) = (f32::INFINITY, f32::INFINITY);
                } else if at_enter > wrong {
                    (early, late) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
                } else {
                    let per = 1.0 / speed;
                    let (first, last) = ((-wrong - start) * per, (wrong - start) * per);
                    (early, late) = (outward(first, -1.0), outward(last, 1.0));
                }
            }
            // Written so that NaN, which stands for a ray in the plane, asks both sides.
            let (to_near, to_far) = (!(enter > late), !(leave < early));
            if C::EXPLAINS {
                let plane = self.data.plane(node);
                let (normal, zero) = (plane.normal(), plane.distance([0.0; 3]));
                let [along, start] = [[dx, dy, dz], [ox, oy, oz]]
                    .map(|v| normal[0] * v[0] + normal[1] * v[1] + normal[2] * v[2]);
                counters.step(Step::Plane {
                    node: number,
                    normal: normal.map(|x| x as f32),
                    offset: -zero as f32,
                    t: if along == 0.0 {
                        f32::NAN
                    } else {
                        (-(start + zero) / along) as f32
                    },
                    near: to_near,
                    far: to_far,
                });
            }
            let far = node.first + (near ^ 1);
            if to_near {
                if to_far {
                    let enter = if early > enter { early } else { enter };
                    stack[pending] = (far, enter, leave);
                    pending += 1;
                }
                number = node.first + near;
                leave = if late < leave { late } else { leave };
            } else {
                // Of two sides that err to the outside at least one is met.
                number = far;
                enter = if early > enter { early } else { enter };
            }
        }
    }
}

/// Rounded to a float that is certainly not closer.
#[inline(always)]
fn outward(t: f64, sign: f32) -> f32 {
    let t = t as f32;
    t + sign * t.abs() * (1.0 / (1 << 22) as f32)
}
