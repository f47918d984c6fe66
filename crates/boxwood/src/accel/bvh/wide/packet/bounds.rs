//! The box test of a packet: the intervals of all its rays against every child of a node.

use super::Packet;
use crate::accel::bvh::wide::boxes::Boxes;
use crate::accel::bvh::wide::node::{Heading, Node};
use crate::simd::{F, Floats, Lanes};

/// The intervals of a packet in every lane.
pub struct Bounds<S: Lanes<N>, const N: usize> {
    least_inverse: [F<S, N>; 3],
    most_inverse: [F<S, N>; 3],
    /// What the near planes are seen from, and the far ones.
    near: [F<S, N>; 3],
    far: [F<S, N>; 3],
    t_min: F<S, N>,
    heading: Heading,
}

impl<S: Lanes<N>, const N: usize> Bounds<S, N> {
    #[inline(always)]
    pub fn new(s: S, packet: &Packet) -> Self {
        let zero = F::<S, N>::splat(s, 0.0);
        let mut new = Self {
            least_inverse: [zero; 3],
            most_inverse: [zero; 3],
            near: [zero; 3],
            far: [zero; 3],
            t_min: zero,
            heading: packet.heading,
        };
        for k in 0..3 {
            let (least, most) = (packet.least_origin[k], packet.most_origin[k]);
            let (near, far) = if packet.heading.is_down(k) {
                (least, most)
            } else {
                (most, least)
            };
            new.least_inverse[k] = F::<S, N>::splat(s, packet.least_inverse[k]);
            new.most_inverse[k] = F::<S, N>::splat(s, packet.most_inverse[k]);
            new.near[k] = F::<S, N>::splat(s, near);
            new.far[k] = F::<S, N>::splat(s, far);
        }
        new
    }

    /// Where the first ray may enter each child, and where the last one may leave it.
    #[inline(always)]
    pub fn slabs<B: Boxes<N>>(&self, s: S, node: &Node<N, B>, latest: f32) -> (F<S, N>, F<S, N>) {
        let mut entry = self.t_min;
        let mut exit = node.ends(s, F::<S, N>::splat(s, latest));
        for k in 0..3 {
            let [near, far] = node.planes(s, k, self.heading);
            let (near, far) = (near - self.near[k], far - self.far[k]);
            let (a, b) = (self.least_inverse[k], self.most_inverse[k]);
            entry = entry.max((near * a).min(near * b));
            exit = exit.min((far * a).max(far * b));
        }
        (entry, exit)
    }
}
