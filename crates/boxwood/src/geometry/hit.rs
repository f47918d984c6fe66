//! What a ray met, and the order of hits.

use core::cmp::Ordering;

/// A hit. Of hits with equal `t`, the one with the lower `(instance, primitive)` comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Barycentric weight of vertex 1; other shapes say what it is for them.
    pub u: f32,
    /// Barycentric weight of vertex 2; other shapes say what it is for them.
    pub v: f32,
    /// Which primitive.
    pub primitive: u32,
    /// Which placement of it; 0 where there is only one.
    pub instance: u32,
}

impl Hit {
    /// The order of hits: by distance, then by placement and primitive.
    #[inline(always)]
    pub fn is_before(&self, other: &Self) -> bool {
        self.t < other.t
            || (self.t == other.t
                && (self.instance, self.primitive) < (other.instance, other.primitive))
    }

    /// The same order for sorting.
    pub fn order(&self, other: &Self) -> Ordering {
        // Hits hold no NaN, and −0 equals 0.
        self.t
            .partial_cmp(&other.t)
            .unwrap_or(Ordering::Equal)
            .then((self.instance, self.primitive).cmp(&(other.instance, other.primitive)))
    }
}
