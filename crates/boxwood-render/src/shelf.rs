//! Wide trees that are kept from one run to the next.
//!
//! *How it works.* A tree's name says all that it depends on: the settings, a hash of the primitives, and the versions of format and
//! builder. What is found under that name is read and looked at from end to end ([`WideBvh::open`]); where that
//! fails, or there is nothing, the tree is built and put there.

use boxwood::primitive::fingerprint;
use boxwood::{OpenError, Precision, Primitives, StructureKind, WideBvh, WideSah};
use std::fmt::{Debug, Display};
use std::io::{self, Read, Write};

/// A place where saved trees lie under names: a folder, say. It fails quietly: then trees are built.
pub trait Shelf: Debug + Send + Sync {
    /// The bytes that lie under a name, and how many there are.
    fn find(&self, name: &str) -> Option<(u64, Box<dyn Read + '_>)>;
    /// Told why what lay under a name is no good; it will be replaced.
    fn refuse(&self, name: &str, why: &dyn Display);
    /// Puts under a name what `save` writes, whole or not at all.
    fn keep(&self, name: &str, save: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>);
}

/// Over fewer primitives a tree is built sooner than its file is opened, and scenes of many small meshes would fill the shelf.
const FEWEST: usize = 4096;

/// Letters, digits, `-` and `.` only.
fn name(kind: StructureKind, revision: u32, primitives: &(impl Primitives + Sync)) -> String {
    let kind = kind.to_string().replace([':', '=', ','], "-");
    let fingerprint = fingerprint(primitives);
    let format = WideBvh::<(), 8>::SAVED_VERSION;
    format!("{kind}-{fingerprint:032x}-{format}.{revision}.bxw")
}

macro_rules! kept {
    ($($function:ident($n:literal, $kind:ident);)*) => {$(
        /// The tree of these settings over these primitives: from the shelf, or built and kept there, unless it is small.
        pub fn $function<P: Primitives + Clone + Sync>(
            builder: &WideSah<$n>,
            primitives: P,
            shelf: &dyn Shelf,
        ) -> WideBvh<P, $n> {
            if primitives.len() < FEWEST {
                return builder.build(primitives);
            }
            // The tree does not depend on what it is walked with.
            let plain = WideSah {
                isa: WideSah::<$n>::default().isa,
                precision: Precision::Exact,
                ..*builder
            };
            let name = name(StructureKind::$kind(plain), WideSah::<$n>::REVISION, &primitives);
            if let Some((length, mut file)) = shelf.find(&name) {
                let opened = WideBvh::open(primitives.clone(), length, |bytes| file.read_exact(bytes));
                match opened {
                    Ok(tree) => return tree.with_isa(builder.isa).with_precision(builder.precision),
                    Err(OpenError::Read(error)) => shelf.refuse(&name, &error),
                    Err(OpenError::Saved(error)) => shelf.refuse(&name, &error),
                }
            }
            let tree = builder.build(primitives);
            if tree.has_parts() {
                return tree;
            }
            shelf.keep(&name, &mut |file| tree.save(|bytes| file.write_all(bytes)));
            tree
        }
    )*};
}
kept! {
    kept_wide8(8, Wide8);
    kept_wide16(16, Wide16);
}
