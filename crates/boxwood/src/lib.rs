//! Ray-tracing acceleration structures whose answers are the same bits everywhere.
//!
//! ```
//! use boxwood::{BinnedSah, Bvh, Intersect, Ray, TriangleMesh};
//!
//! // mesh → build → tree → layout → query → hit
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let mesh = TriangleMesh::new(corners, [[0_u32, 1, 2]])?;
//! let tree = BinnedSah { bins: 16, ..Default::default() }.build(&mesh);
//! let bvh = Bvh::new(&mesh, tree);
//!
//! let ray = Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0]);
//! let hit = bvh.closest_hit(&ray).expect("the triangle is in the way");
//! assert_eq!((hit.t, hit.primitive), (1.0, 0));
//! assert!(!bvh.occluded(&ray.until(0.5)));
//! # Ok::<(), boxwood::MeshError>(())
//! ```
//!
//! *How it is laid out.* Data walks one line from left to right, and each module serves one stop of it: [`geometry`] (rays,
//! boxes, triangles, shapes), [`primitive`] (numbered sets of things a ray may meet), [`query`] (what a ray asks), [`proximity`] (what is asked of space), [`accel`] (the
//! structures), [`inspect`] (looking at a tree). [`plane`] makes scenes in two dimensions of the same parts.
//!
//! *What can be relied on.* Every structure returns the bits of [`BruteForce`], on every machine and for any number of
//! threads; no ray slips between triangles that share an edge; nothing panics on data.
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(unsafe_code)]

extern crate alloc;

pub mod accel;
mod digest;
pub mod geometry;
pub mod inspect;
mod math;
mod pieces;
pub mod plane;
pub mod primitive;
pub mod proximity;
pub mod query;
mod simd;
#[cfg(feature = "parallel")]
mod threads;

pub use accel::boxes::{BoundingBoxes, ObjectBoxes};
pub use accel::brute_force::BruteForce;
pub use accel::bsp_tree::{BspData, BspSah, BspTree};
pub use accel::bvh::{
    BinaryTree, BinnedSah, Bvh, CompactBvh, CompactSah, Decision, EqualCounts, Forecast, Gathering,
    Job, Lbvh, Median, Middle, MotionBvh, OpenError, Ploc, Precision, Quality, Refine, SavedError,
    SpatialSplit, Survey, SweepSah, UnknownQuality, Updated, Upkeep, WideBvh, WideSah,
};
pub use accel::grid::{Density, GridBuilder, UniformGrid};
pub use accel::kd_tree::{KdLecture, KdSah, KdTree};
pub use accel::octree::{Octree, OctreeBuilder, OctreeData};
pub use accel::top_level::{Committed, Handle, TopLevel};
pub use accel::two_level_grid::{TwoLevelGrid, TwoLevelGridBuilder};
pub use accel::{Axes, BuildError, Limits, StructureKind, UnknownStructure};
pub use geometry::implicit::{Enclosure, Formula, Implicit, ImplicitSurface, Segment};
pub use geometry::real::Real;
pub use geometry::shape::{Shape, ShapeError, ShapeFlaw};
pub use geometry::{Aabb, Affine, Hit, Interval, PreparedRay, Ray, Surface, Vec3};
pub use geometry::{Cuboid, Cylinder, Disc, Line, OrientedCuboid, Plane, Prism, Sphere, Torus};
pub use primitive::{
    Chain, Cuboids, Cylinders, Discs, Foresight, ImplicitSurfaces, Instance, InstanceError,
    Instances, MeshError, MollerTrumbore, MotionError, MovingMesh, Object, OrientedCuboids, Planes,
    Pose, Primitives, Shapes, Spheres, Surfaces, Tori, TriangleMesh, Triangles,
};
pub use proximity::Proximity;
pub use query::{
    AllHits, At, Closest, Counters, Filter, FirstHits, Intersect, Occluded, Part, Query, Relay,
    Seen, Step, Timed, TraversalStats, Traverse, Verdict,
};
#[doc(hidden)]
pub use simd::carelessly;
pub use simd::{Isa, UnknownIsa, exactly};
