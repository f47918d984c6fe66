//! Arrays of plain items on large pages, where the system has them for the asking.
//!
//! A tree of megabytes spans thousands of ordinary pages, more than a processor remembers the places of: every other step
//! into a cold node then waits for its page's place too. The advice to use large pages helps only where nothing has been
//! written yet, and an allocator hands out what others have written and given back: with it, the same tree was up to 15 %
//! slower in some runs than in others. So large arrays are asked of the system itself.

use super::Plain;
use alloc::alloc::{Layout, alloc, alloc_zeroed, dealloc, handle_alloc_error};
use core::fmt;
use core::marker::PhantomData;
use core::ops::{Deref, DerefMut};
use core::ptr::NonNull;

/// A list with room for a number of items that is known from the start.
pub struct Pages<T: Copy> {
    items: NonNull<T>,
    len: usize,
    room: usize,
    from: Source,
    owned: PhantomData<T>,
}

/// Whom the memory goes back to.
#[derive(Clone, Copy)]
enum Source {
    Allocator,
    #[cfg(all(target_os = "linux", feature = "std"))]
    System(system::Mapping),
}

impl<T: Copy> Pages<T> {
    /// An empty list.
    pub fn with_room(room: usize) -> Self {
        Self::asked(room, alloc).unwrap_or_else(|| handle_alloc_error(Self::layout(room)))
    }

    /// An empty list in memory from the system, which is new and therefore zero, or from a function of the allocator; `None` where
    /// there is no memory for it.
    fn asked(room: usize, allocator: unsafe fn(Layout) -> *mut u8) -> Option<Self> {
        let layout = Layout::array::<T>(room).ok()?;
        let (items, from) = if layout.size() == 0 {
            (NonNull::dangling(), Source::Allocator)
        } else if let Some(mapped) = mapped(layout) {
            mapped
        } else {
            // SAFETY: the layout is not empty.
            let items = unsafe { allocator(layout) };
            (NonNull::new(items)?.cast(), Source::Allocator)
        };
        Some(Self {
            items,
            len: 0,
            room,
            from,
            owned: PhantomData,
        })
    }

    fn layout(room: usize) -> Layout {
        Layout::array::<T>(room).expect("no more bytes than there are addresses")
    }

    /// Appends an item.
    ///
    /// # Panics
    /// When the room is used up.
    #[inline]
    pub fn push(&mut self, item: T) {
        assert!(self.len < self.room, "room for all items");
        // SAFETY: the memory holds `room` items.
        unsafe { self.items.add(self.len).write(item) };
        self.len += 1;
    }
}

impl<T: Plain> Pages<T> {
    /// So many items of zeros, to be written over; `None` where there is no memory for them.
    pub fn zeroed(len: usize) -> Option<Self> {
        let mut list = Self::asked(len, alloc_zeroed)?;
        // Zeros in all of the room, which are values.
        list.len = len;
        Some(list)
    }
}

#[cfg(all(target_os = "linux", feature = "std"))]
fn mapped<T>(layout: Layout) -> Option<(NonNull<T>, Source)> {
    let (items, mapping) = system::map(layout)?;
    Some((items.cast(), Source::System(mapping)))
}

#[cfg(not(all(target_os = "linux", feature = "std")))]
fn mapped<T>(_: Layout) -> Option<(NonNull<T>, Source)> {
    None
}

#[cfg(all(target_os = "linux", feature = "std"))]
mod system {
    use super::Layout;
    use core::ffi::c_void;
    use core::ptr::{NonNull, null_mut};
    use rustix::mm::{Advice, MapFlags, ProtFlags, madvise, mmap_anonymous, munmap};

    /// The size of a large page.
    const LARGE: usize = 2 << 20;

    /// What [`unmap`] needs.
    #[derive(Clone, Copy)]
    pub struct Mapping {
        start: NonNull<c_void>,
        bytes: usize,
    }

    /// New memory that begins where a large page may; `None` for what would not fill half of one, or when there is no more.
    pub fn map(layout: Layout) -> Option<(NonNull<c_void>, Mapping)> {
        if layout.size() < LARGE / 2 || layout.align() > LARGE {
            return None;
        }
        // What is left over by less than half of a large page stays on small ones.
        let rest = layout.size() % LARGE;
        let used = layout.size() + if rest < LARGE / 2 { 0 } else { LARGE - rest };
        let bytes = used.checked_add(LARGE)?;
        let (rights, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::PRIVATE);
        // SAFETY: a new mapping where the system likes it.
        let start = unsafe { mmap_anonymous(null_mut(), bytes, rights, flags) }.ok()?;
        let skipped = start.align_offset(LARGE);
        // SAFETY: at most `LARGE` bytes behind the start, and `used` more are there. The advice changes neither contents nor
        // rights; that it may be declined is no harm.
        let (start, items) = unsafe {
            let items = start.byte_add(skipped);
            let _ = madvise(items, used, Advice::LinuxHugepage);
            (NonNull::new(start)?, NonNull::new(items)?)
        };
        Some((items, Mapping { start, bytes }))
    }

    /// Gives a mapping back.
    ///
    /// # Safety
    /// [`map`] made it, and nothing uses it any more.
    pub unsafe fn unmap(mapping: Mapping) {
        // SAFETY: the caller's promise.
        let unmapped = unsafe { munmap(mapping.start.as_ptr(), mapping.bytes) };
        debug_assert!(unmapped.is_ok(), "a mapping of our own");
    }
}

impl<T: Copy> Drop for Pages<T> {
    fn drop(&mut self) {
        let layout = Self::layout(self.room);
        match self.from {
            // SAFETY: allocated with this layout, and nobody borrows it.
            Source::Allocator if layout.size() > 0 => unsafe {
                dealloc(self.items.as_ptr().cast(), layout);
            },
            Source::Allocator => {}
            #[cfg(all(target_os = "linux", feature = "std"))]
            // SAFETY: made by `map`, and nobody borrows it.
            Source::System(mapping) => unsafe { system::unmap(mapping) },
        }
    }
}

// SAFETY: it owns its items, as a `Vec` does.
unsafe impl<T: Copy + Send> Send for Pages<T> {}
// SAFETY: as above.
unsafe impl<T: Copy + Sync> Sync for Pages<T> {}

impl<T: Copy> Deref for Pages<T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: so many items were written.
        unsafe { core::slice::from_raw_parts(self.items.as_ptr(), self.len) }
    }
}

impl<T: Copy> DerefMut for Pages<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: so many items were written.
        unsafe { core::slice::from_raw_parts_mut(self.items.as_ptr(), self.len) }
    }
}

impl<T: Copy> Clone for Pages<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::with_room(self.len);
        self.iter().for_each(|&item| copy.push(item));
        copy
    }
}

impl<T: Copy> Default for Pages<T> {
    fn default() -> Self {
        Self::with_room(0)
    }
}

impl<T: Copy + fmt::Debug> fmt::Debug for Pages<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::Pages;
    use alloc::vec::Vec;

    #[test]
    fn a_list_keeps_what_it_is_given_whatever_its_size() {
        // None, few, half a large page, several of them and some more.
        for count in [0, 1, 1000, 130_000, 1_000_003_u64] {
            let mut list = Pages::with_room(count as usize);
            (0..count).for_each(|item| list.push(item));
            assert!(list.iter().copied().eq(0..count));
            assert!(list.clone().iter().copied().eq(0..count));
            if let Some(last) = list.last_mut() {
                *last = 7;
                assert_eq!(list[count as usize - 1], 7);
            }
        }
        let lists: Vec<_> = (0..3).map(|_| Pages::<u8>::default()).collect();
        assert!(lists.iter().all(|list| list.is_empty()));
    }

    #[test]
    fn zeros_are_zeros_on_pages_of_any_size() {
        for count in [0, 1, 1000, 1_000_003] {
            let mut list = Pages::<[u32; 3]>::zeroed(count).expect("a few megabytes");
            assert!(list.len() == count && list.iter().all(|&item| item == [0; 3]));
            if let Some(last) = list.last_mut() {
                last[2] = 7;
            }
            assert_eq!(list.iter().flatten().sum::<u32>(), 7 * count.min(1) as u32);
        }
        for count in [usize::MAX, usize::MAX / 12, 1 << 48] {
            assert!(Pages::<[u32; 3]>::zeroed(count).is_none());
        }
    }

    #[test]
    #[should_panic(expected = "room for all items")]
    fn more_than_there_is_room_for_is_refused() {
        let mut list = Pages::with_room(1);
        list.push(1);
        list.push(2);
    }
}
