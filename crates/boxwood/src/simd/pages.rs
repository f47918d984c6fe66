//! Large arrays on large pages, where the system has them for the asking.
//!
//! A tree of megabytes spans thousands of ordinary pages, more than a processor remembers the places of: every other step
//! into a cold node then waits for its page's place too.

use alloc::vec::Vec;

/// Arrays smaller than this stay as they are: the size of a large page.
#[cfg(all(target_os = "linux", feature = "std"))]
const LARGE: usize = 2 << 20;

/// A list with room for so many items, on large pages where it is large and the system allows. Best asked for before
/// anything is written.
pub fn with_capacity<T>(count: usize) -> Vec<T> {
    #[allow(unused_mut, reason = "advice is asked for on some systems only")]
    let mut list: Vec<T> = Vec::with_capacity(count);
    #[cfg(all(target_os = "linux", feature = "std"))]
    {
        let room = list.spare_capacity_mut();
        let (start, bytes) = (room.as_mut_ptr() as usize, size_of_val(room));
        // Whole pages inside the array only: what lies around it is not ours.
        let first = start.next_multiple_of(LARGE);
        let end = (start + bytes) / LARGE * LARGE;
        if first < end {
            // SAFETY: the range lies within the array's own memory, and the advice changes neither contents nor rights.
            let _ = unsafe {
                rustix::mm::madvise(
                    first as *mut core::ffi::c_void,
                    end - first,
                    rustix::mm::Advice::LinuxHugepage,
                )
            };
        }
    }
    list
}
