//! What a build may cost, who watches it, and how it ends early.
//!
//! *How it works.* [`Limits`] is the caller's side. A builder makes a [`Site`] of them: it tells the site what memory it is
//! about to take and how much work is done, and stops where the site says so. Threads may share a site.

use alloc::vec::Vec;
use core::fmt;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

/// What a build may cost and who watches it. The default is no limit and nobody.
///
/// ```
/// use boxwood::{BuildError, Limits, StructureKind, TriangleMesh};
/// let mesh = TriangleMesh::new([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0_u32, 1, 2]])?;
/// let tight = Limits { memory: Some(8), ..Limits::NONE };
/// let kind = StructureKind::default();
/// assert!(matches!(kind.build_within(&mesh, &tight), Err(BuildError::Memory { .. })));
/// # Ok::<(), boxwood::MeshError>(())
/// ```
#[derive(Clone, Copy, Default)]
pub struct Limits<'a> {
    /// The most bytes that the structure may take at any time of its building and afterwards, without the primitives.
    /// `None` is no limit. What counts are the large arrays; a few kilobytes beside them do not.
    pub memory: Option<usize>,
    /// Told every now and then which share of the work is done, 0 to 1 and never falling on one thread; `Break` ends the
    /// build. May be called from several threads at once.
    pub watch: Option<&'a (dyn Fn(f32) -> ControlFlow<()> + Sync)>,
}

impl Limits<'_> {
    /// No limit and nobody who watches.
    pub const NONE: Limits<'static> = Limits {
        memory: None,
        watch: None,
    };
}

impl fmt::Debug for Limits<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Limits")
            .field("memory", &self.memory)
            .field("watch", &self.watch.is_some())
            .finish()
    }
}

/// Why a build ended without a structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The one who watches said so.
    #[error("the build was cancelled")]
    Cancelled,
    /// More memory would be needed than is allowed.
    #[error("the structure needs at least {needed} bytes, but {allowed} are allowed")]
    Memory {
        /// Bytes that would be in use at the moment the build gave up; a whole build may need more.
        needed: usize,
        /// Bytes allowed.
        allowed: usize,
    },
    /// More primitives than the structure can number.
    #[error("the structure can hold about {most} primitives, but there are {primitives}")]
    TooMany {
        /// How many there are, each counted as often as it is named.
        primitives: usize,
        /// How many there may be.
        most: usize,
    },
}

/// The builder's side of [`Limits`].
pub(crate) struct Site<'a> {
    limits: &'a Limits<'a>,
    /// Units of work, whatever the builder counts; at least 1.
    total: usize,
    done: AtomicUsize,
    /// `done` at which the watcher is told next.
    tell_at: AtomicUsize,
    used: AtomicUsize,
    cancelled: AtomicBool,
    /// The bytes that were asked for in vain; 0 while there was room.
    refused: AtomicUsize,
}

impl<'a> Site<'a> {
    /// A site where `total` units of work are to be done.
    pub fn new(limits: &'a Limits<'a>, total: usize) -> Self {
        Self {
            limits,
            total: total.max(1),
            done: AtomicUsize::new(0),
            tell_at: AtomicUsize::new(0),
            used: AtomicUsize::new(0),
            cancelled: AtomicBool::new(false),
            refused: AtomicUsize::new(0),
        }
    }

    /// Counts bytes that are about to be taken; `false`, and the build is [over](Self::is_over), when they are too many.
    pub fn take(&self, bytes: usize) -> bool {
        let fits = self.try_take(bytes);
        if !fits {
            let needed = self.used.load(Relaxed).saturating_add(bytes);
            self.refused.fetch_max(needed, Relaxed);
        }
        fits
    }

    /// The same for a builder that can do with less: a refusal does not end the build.
    pub fn try_take(&self, bytes: usize) -> bool {
        let allowed = self.limits.memory.unwrap_or(usize::MAX);
        let fits = |used: usize| used.checked_add(bytes).filter(|&sum| sum <= allowed);
        self.used.fetch_update(Relaxed, Relaxed, fits).is_ok()
    }

    /// Counts bytes that were given back.
    pub fn give(&self, bytes: usize) {
        let less = |used: usize| Some(used.saturating_sub(bytes));
        let _ = self.used.fetch_update(Relaxed, Relaxed, less);
    }

    /// Of all that was taken so many bytes are still in use.
    pub fn settle(&self, bytes: usize) {
        self.used.fetch_min(bytes, Relaxed);
    }

    /// Makes room in a list for more, and counts it; `false` when there is none, and the build is over.
    pub fn reserve<T>(&self, list: &mut Vec<T>, more: usize) -> bool {
        let (needed, old) = (list.len() + more, list.capacity());
        if needed <= old {
            return true;
        }
        let new = needed.max(old + old / 2).max(16);
        if !self.take(new.saturating_mul(size_of::<T>())) {
            return false;
        }
        list.reserve_exact(new - list.len());
        self.give(old * size_of::<T>());
        true
    }

    /// Gives back what was [reserved](Self::reserve) for a list.
    pub fn release<T>(&self, list: Vec<T>) {
        self.give(list.capacity() * size_of::<T>());
    }

    /// Bytes that may still be taken.
    pub fn room(&self) -> usize {
        let allowed = self.limits.memory.unwrap_or(usize::MAX);
        allowed.saturating_sub(self.used.load(Relaxed))
    }

    /// Counts work that is done, and asks the watcher now and then; `false` when the build is over.
    ///
    /// Cheap enough for every few hundred primitives, not for each.
    pub fn advance(&self, units: usize) -> bool {
        // What is over is unwound, and nobody is asked again.
        if self.is_over() {
            return false;
        }
        if let Some(watch) = self.limits.watch {
            let done = self.done.fetch_add(units, Relaxed) + units;
            let due = self.tell_at.load(Relaxed);
            if done >= due {
                self.tell_at
                    .store(due.max(done) + self.total / 128 + 1, Relaxed);
                let share = (done as f32 / self.total as f32).min(1.0);
                if watch(share).is_break() {
                    self.cancelled.store(true, Relaxed);
                }
            }
        }
        !self.is_over()
    }

    /// Whether the build was cancelled or ran out of memory: whatever it makes now is thrown away.
    #[inline]
    pub fn is_over(&self) -> bool {
        self.cancelled.load(Relaxed) || self.refused.load(Relaxed) > 0
    }

    /// What was built, unless the build was over before.
    pub fn finish<T>(&self, built: T) -> Result<T, BuildError> {
        let needed = self.refused.load(Relaxed);
        if needed > 0 {
            let allowed = self.limits.memory.unwrap_or(usize::MAX);
            return Err(BuildError::Memory { needed, allowed });
        }
        if self.cancelled.load(Relaxed) {
            return Err(BuildError::Cancelled);
        }
        if let Some(watch) = self.limits.watch
            && watch(1.0).is_break()
        {
            return Err(BuildError::Cancelled);
        }
        Ok(built)
    }
}

/// What was built without limits, which cannot fail.
pub(crate) fn unlimited<T>(built: Result<T, BuildError>) -> T {
    built.expect("a build without limits does not end early")
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ops::ControlFlow::{Break, Continue};

    #[test]
    fn memory_is_counted() {
        let limits = Limits {
            memory: Some(100),
            ..Limits::NONE
        };
        let site = Site::new(&limits, 1);
        assert!(site.take(60) && !site.try_take(50) && site.room() == 40);
        site.give(30);
        assert!(site.try_take(50) && !site.is_over());
        site.settle(90);
        assert_eq!(site.room(), 20, "nothing is taken by settling");
        site.settle(70);
        assert_eq!(site.room(), 30);
        assert!(!site.take(usize::MAX) && site.is_over());
        let error = BuildError::Memory {
            needed: usize::MAX,
            allowed: 100,
        };
        assert_eq!(site.finish(()), Err(error));
    }

    #[test]
    fn the_watcher_sees_it_all_and_may_break() {
        let seen = AtomicUsize::new(0);
        let watch = |share: f32| {
            seen.fetch_add(1, Relaxed);
            if share >= 0.5 {
                Break(())
            } else {
                Continue(())
            }
        };
        let limits = Limits {
            watch: Some(&watch),
            ..Limits::NONE
        };
        let site = Site::new(&limits, 1000);
        let steps = (0..1000).take_while(|_| site.advance(1)).count();
        assert!((499..520).contains(&steps), "{steps}");
        assert!((50..70).contains(&seen.load(Relaxed)), "{seen:?}");
        assert_eq!(site.finish(()), Err(BuildError::Cancelled));
    }
}
