//! tinybvh's trees, which the wrapper does not let threads share.

use tinybvh_rs::{Error, Intersector, Ray, bvh};

/// A tree of tinybvh that several threads may ask: its best layout that the wrapper offers to this program.
pub struct TinyTree<'a> {
    #[cfg(target_feature = "avx2")]
    tree: tinybvh_rs::bvh8_cpu::BVH,
    #[cfg(not(target_feature = "avx2"))]
    tree: bvh::BVH<'a>,
    _corners: &'a [[f32; 4]],
}

// SAFETY: the wrapper's types are neither `Send` nor `Sync` only because all types of C++ are not. This one owns its
// tree and borrows its corners, and shows nothing but `intersect`, a `const` method that writes to the ray alone, as
// programs in C++ call it from many threads.
unsafe impl Send for TinyTree<'_> {}
// SAFETY: as above.
unsafe impl Sync for TinyTree<'_> {}

impl<'a> TinyTree<'a> {
    /// How the library calls the layout.
    pub const LAYOUT: &'static str = if cfg!(target_feature = "avx2") {
        "BVH8_CPU"
    } else {
        "BVH"
    };

    /// Builds a tree with spatial splits over three corners for each triangle.
    ///
    /// # Errors
    /// What the wrapper says.
    pub fn build(corners: &'a [[f32; 4]]) -> Result<Self, Error> {
        let binary = bvh::BVH::new_hq(corners.into())?;
        #[cfg(target_feature = "avx2")]
        let tree = {
            let mut binary = binary;
            binary.split_leaves(4);
            tinybvh_rs::bvh8_cpu::BVH::new(&tinybvh_rs::mbvh::BVH::new(&binary))?
        };
        #[cfg(not(target_feature = "avx2"))]
        let tree = binary;
        Ok(Self {
            tree,
            _corners: corners,
        })
    }

    /// Leaves the nearest hit in the ray.
    #[inline]
    pub fn intersect(&self, ray: &mut Ray) {
        self.tree.intersect(ray);
    }
}
