//! Who is compared, each behind one trait.
//!
//! *How it works.* A [`Contestant`] is a name with settings; [`Contestant::build`] makes its structure over a mesh, and
//! [`Built`] asks that about slices of rays. One dynamic call answers a whole slice, and what a library wants rays to look
//! like is made within the call: its users have to do that too.

mod boxwood;
#[cfg(feature = "bvh")]
mod bvh;
mod embree;
mod ffi;
#[cfg(feature = "obvhs")]
mod obvhs;
#[cfg(feature = "parry3d")]
mod parry3d;
#[cfg(feature = "tinybvh")]
mod tinybvh;

pub use ffi::FlushToZero;

use ::boxwood::{Hit, Intersect, Ray, StructureKind, TriangleMesh};
use serde::Serialize;
use std::fmt;
use std::str::FromStr;
use std::sync::OnceLock;

/// How rays are handed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// One call for each ray.
    Single,
    /// Many rays in any order with one call, which a library may answer as it likes.
    Batch,
    /// Sixteen rays with one call, which the caller says go the same way.
    Packet,
}

impl Way {
    /// Whether it makes sense for rays whose neighbours go elsewhere.
    pub fn wants_coherence(self) -> bool {
        self == Self::Packet
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Single => "single",
            Self::Batch => "batch",
            Self::Packet => "packet",
        })
    }
}

/// A structure that is ready to be asked.
pub trait Built: Send + Sync {
    /// The ways to ask it, at least one.
    fn ways(&self) -> &'static [Way] {
        &[Way::Single]
    }
    /// What it keeps besides the mesh; `None` where nobody can say.
    fn bytes(&self) -> Option<usize>;
    /// What a reader should know about it.
    fn note(&self) -> Option<String> {
        None
    }
    /// The nearest hit of each ray; `u` and `v` may be left 0. The slices are equally long.
    fn closest(&self, way: Way, rays: &[Ray], hits: &mut [Option<Hit>]);
    /// Whether anything is in each ray's interval. The slices are equally long.
    fn occluded(&self, way: Way, rays: &[Ray], occluded: &mut [bool]);
    /// Boxwood's own structures, which can be counted.
    fn own(&self) -> Option<&dyn Intersect> {
        None
    }
    /// Whether every answer must have Boxwood's bits.
    fn is_exact(&self) -> bool {
        false
    }
}

/// A structure, and the seconds its library took.
pub struct Finished<'a> {
    pub built: Box<dyn Built + 'a>,
    pub seconds: f64,
}

/// A mesh in the forms that libraries borrow.
pub struct Subject {
    pub mesh: TriangleMesh,
    corners: OnceLock<Vec<[f32; 4]>>,
}

impl Subject {
    pub fn new(mesh: TriangleMesh) -> Self {
        Self {
            mesh,
            corners: OnceLock::new(),
        }
    }

    /// Three points of four numbers for each triangle.
    #[cfg_attr(
        not(feature = "tinybvh"),
        expect(dead_code, reason = "only tinybvh borrows it")
    )]
    fn corners(&self) -> &[[f32; 4]] {
        self.corners.get_or_init(|| {
            let triangles = 0..self.mesh.triangles().len();
            triangles
                .flat_map(|i| self.mesh.triangle(i).map(|p| [p.x, p.y, p.z, 0.0]))
                .collect()
        })
    }
}

/// Someone to compare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contestant {
    /// One of Boxwood's structures.
    Boxwood(StructureKind),
    /// Embree, as it is built.
    Embree(embree::Variant),
    /// obvhs, whose wide tree is its best; `true` for its slowest build.
    Obvhs(bool),
    /// The crate `bvh`.
    Bvh,
    /// parry3d's `TriMesh`.
    Parry3d,
    /// tinybvh by its Rust wrapper.
    TinyBvh,
}

/// How peers are written.
pub const PEERS: &str =
    "embree[:low|high,robust,compact,avx2], obvhs, obvhs:slow, bvh, parry3d, tinybvh";

impl Contestant {
    /// Those of who names none.
    pub fn defaults() -> Vec<Self> {
        let names = [
            "embree",
            "embree:robust",
            "embree:high",
            "embree:low",
            "obvhs",
            "bvh",
            "parry3d",
            "tinybvh",
        ];
        names
            .into_iter()
            .filter_map(|name| name.parse().ok())
            .collect()
    }

    /// Whether the number of threads matters to its build.
    pub fn builds_in_parallel(&self) -> bool {
        !matches!(self, Self::Parry3d | Self::TinyBvh)
    }

    /// Builds it over the subject, in the caller's rayon pool, which has so many threads.
    ///
    /// # Errors
    /// Why it is absent.
    pub fn build<'a>(&self, subject: &'a Subject, threads: usize) -> Result<Finished<'a>, String> {
        match self {
            Self::Boxwood(kind) => boxwood::build(*kind, &subject.mesh),
            Self::Embree(variant) => embree::build(*variant, &subject.mesh, threads),
            #[cfg(feature = "obvhs")]
            Self::Obvhs(slow) => Ok(obvhs::build(*slow, &subject.mesh)),
            #[cfg(feature = "bvh")]
            Self::Bvh => Ok(bvh::build(&subject.mesh, threads)),
            #[cfg(feature = "parry3d")]
            Self::Parry3d => parry3d::build(&subject.mesh),
            #[cfg(feature = "tinybvh")]
            Self::TinyBvh => tinybvh::build(subject),
            #[allow(
                unreachable_patterns,
                reason = "reachable where a peer's feature is off"
            )]
            _ => Err("it was not compiled in: its feature is off".to_string()),
        }
    }
}

impl fmt::Display for Contestant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boxwood(kind) => kind.fmt(f),
            Self::Embree(variant) => variant.fmt(f),
            Self::Obvhs(false) => f.write_str("obvhs"),
            Self::Obvhs(true) => f.write_str("obvhs:slow"),
            Self::Bvh => f.write_str("bvh"),
            Self::Parry3d => f.write_str("parry3d"),
            Self::TinyBvh => f.write_str("tinybvh"),
        }
    }
}

/// Reads the name of a peer.
impl FromStr for Contestant {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':').unwrap_or((text, "")) {
            ("embree", settings) => settings.parse().map(Self::Embree),
            ("obvhs", "") => Ok(Self::Obvhs(false)),
            ("obvhs", "slow") => Ok(Self::Obvhs(true)),
            ("bvh", "") => Ok(Self::Bvh),
            ("parry3d", "") => Ok(Self::Parry3d),
            ("tinybvh", "") => Ok(Self::TinyBvh),
            _ => Err(format!("no peer is called `{text}`; there are {PEERS}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_both_ways() {
        for text in [
            "embree",
            "embree:robust",
            "embree:low",
            "embree:high,robust,avx2",
            "embree:robust,compact",
            "obvhs",
            "obvhs:slow",
            "bvh",
            "parry3d",
            "tinybvh",
        ] {
            let peer: Contestant = text.parse().expect("a peer");
            assert_eq!(peer.to_string(), text);
        }
        assert_eq!(
            "embree:medium,isa=avx2"
                .parse::<Contestant>()
                .map(|p| p.to_string()),
            Ok("embree:avx2".into())
        );
        let unknown = "embree:quick"
            .parse::<Contestant>()
            .expect_err("no such setting");
        assert!(
            unknown.contains("`quick`") && unknown.contains("robust"),
            "{unknown}"
        );
        assert!("optix".parse::<Contestant>().is_err());
        assert_eq!(Contestant::defaults().len(), 8);
    }

    /// Everybody that is compiled in finds a wall, its end and its neighbour, however asked.
    #[test]
    fn all_find_a_wall() {
        // Two triangles that make a square at z = 0.
        let square = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        let mesh = TriangleMesh::new(square, [[0_u32, 1, 2], [0, 2, 3]]).expect("a good mesh");
        let subject = Subject::new(mesh);
        let towards = Ray::new([0.25, 0.5, 2.0], [0.0, 0.0, -2.0]);
        let beside = Ray::new([1.5, 0.5, 2.0], [0.0, 0.0, -2.0]);
        let from_behind = Ray::new([0.75, 0.5, -3.0], [0.0, 0.0, 1.0]);
        let rays = [towards, beside, towards.until(0.5), from_behind];
        let kinds = [Contestant::Boxwood(StructureKind::default())];
        let compiled = Contestant::defaults();
        // Embree would be fetched.
        let compiled = compiled
            .into_iter()
            .filter(|c| !matches!(c, Contestant::Embree(_)));
        for contestant in kinds.into_iter().chain(compiled) {
            let Ok(finished) = contestant.build(&subject, 1) else {
                continue;
            };
            for &way in finished.built.ways() {
                let (mut hits, mut occluded) = ([None; 4], [false; 4]);
                finished.built.closest(way, &rays, &mut hits);
                finished.built.occluded(way, &rays, &mut occluded);
                let found = hits.map(|h| h.map(|h| (h.t, h.primitive)));
                assert_eq!(
                    found,
                    [Some((1.0, 1)), None, None, Some((3.0, 0))],
                    "{contestant} {way}"
                );
                assert_eq!(occluded, [true, false, false, true], "{contestant} {way}");
            }
        }
    }
}
