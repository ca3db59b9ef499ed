//! Large arrays on large pages.
//!
//! A new array of 13 MB on pages of 4 KiB costs 3,000 page faults, more than what is then computed in it; on pages of
//! 2 MiB it costs 7, and random reads miss the address cache less often. Linux grants large pages to whoever asks.
//! Clearing them is a tenth of a short run, so some of those given back are kept for the next array of their size.
//!
//! Every page of a smaller array of zeros is written at once: the system maps one that is read first to a page that
//! all zeros share, and once more when it is written, for which it interrupts every other thread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError};

const LARGE_PAGE: usize = 2 << 20;

const SMALL_PAGE: usize = 4 << 10;

/// From here on an array takes less time to clear a large page for than to fault in on small ones.
const LEAST: usize = LARGE_PAGE / 2;

/// The system's allocator, but for arrays of half a large page and more.
pub struct LargePages;

fn is_large(layout: Layout) -> bool {
    layout.size() >= LEAST && layout.align() <= LARGE_PAGE
}

/// What is mapped for an array: whole large pages.
fn mapped(size: usize) -> Option<usize> {
    size.checked_next_multiple_of(LARGE_PAGE)
}

/// Mappings that were given back and wait for an array of the same size.
static SPARE: Mutex<Spare> =
    Mutex::new(Spare { mappings: [const { None }; SPARE_MAPPINGS], bytes: 0 });

const SPARE_MAPPINGS: usize = 16;

/// No more than this is kept in all.
const SPARE_BYTES: usize = 64 << 20;

struct Spare {
    /// The oldest first, and nothing behind the last one.
    mappings: [Option<Mapping>; SPARE_MAPPINGS],
    bytes: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Mapping {
    start: *mut u8,
    size: usize,
}

// SAFETY: no thread but the one that takes it has its address.
unsafe impl Send for Mapping {}

impl Spare {
    /// Takes one of exactly that size, the latest: it may still be in the cache.
    fn take(&mut self, size: usize) -> Option<Mapping> {
        let fits = |mapping: &Option<Mapping>| mapping.is_some_and(|m| m.size == size);
        self.remove(self.mappings.iter().rposition(fits)?)
    }

    fn remove(&mut self, i: usize) -> Option<Mapping> {
        let mapping = self.mappings[i].take()?;
        self.mappings[i..].rotate_left(1);
        self.bytes -= mapping.size;
        Some(mapping)
    }

    /// Keeps it, or says what has to be unmapped first: the oldest, which no one seems to want, or itself.
    fn keep(&mut self, new: Mapping) -> Result<(), Mapping> {
        if new.size > SPARE_BYTES {
            return Err(new);
        }
        match self.mappings.iter_mut().find(|mapping| mapping.is_none()) {
            Some(place) if self.bytes + new.size <= SPARE_BYTES => {
                *place = Some(new);
                self.bytes += new.size;
                Ok(())
            }
            _ => Err(self.remove(0).unwrap_or(new)),
        }
    }
}

/// No one panics while holding it.
fn spare() -> MutexGuard<'static, Spare> {
    SPARE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What was kept, with what is left in it, or fresh memory.
fn take_or_map(size: usize) -> *mut u8 {
    let kept = mapped(size).and_then(|size| spare().take(size));
    kept.map_or_else(|| map(size), |mapping| mapping.start)
}

/// All zeros.
fn take_or_map_zeroed(size: usize) -> *mut u8 {
    match mapped(size).and_then(|size| spare().take(size)) {
        // SAFETY: the mapping is at least as long.
        Some(Mapping { start, .. }) => unsafe {
            start.write_bytes(0, size);
            start
        },
        None => map(size),
    }
}

fn keep_or_unmap(new: Mapping) {
    loop {
        // Unmapping takes its time, and others need the lock.
        let Err(gone) = spare().keep(new) else { return };
        // SAFETY: it was given back, and no one can take it any more.
        unsafe { libc::munmap(gone.start.cast(), gone.size) };
        if gone == new {
            return;
        }
    }
}

/// Fresh memory, all zeros, at the start of a large page; null if there is none.
fn map(size: usize) -> *mut u8 {
    let Some(total) = mapped(size).and_then(|size| size.checked_add(LARGE_PAGE)) else {
        return ptr::null_mut();
    };
    // SAFETY: an anonymous mapping at an address of the system's choice touches nothing that exists. It has one
    // large page more than needed, of which the parts before and behind the aligned middle are given back.
    unsafe {
        let start = libc::mmap(
            ptr::null_mut(),
            total,
            libc::PROT_READ | libc::PROT_WRITE,
            libc::MAP_PRIVATE | libc::MAP_ANONYMOUS,
            -1,
            0,
        );
        if start == libc::MAP_FAILED {
            return ptr::null_mut();
        }
        let start = start.cast::<u8>();
        let before = start.align_offset(LARGE_PAGE);
        let array = start.add(before);
        if before > 0 {
            libc::munmap(start.cast(), before);
        }
        let middle = total - LARGE_PAGE;
        libc::munmap(array.add(middle).cast(), LARGE_PAGE - before);
        // A wish: refused, the pages are small ones.
        libc::madvise(array.cast(), middle, libc::MADV_HUGEPAGE);
        array
    }
}

// SAFETY: large arrays have mappings of their own, aligned to a large page; all others are the system's. Which is
// which follows from the layout, that callers repeat when they give an array back.
unsafe impl GlobalAlloc for LargePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if is_large(layout) { take_or_map(layout.size()) } else { unsafe { System.alloc(layout) } }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if is_large(layout) {
            return take_or_map_zeroed(layout.size());
        }
        unsafe {
            let array = System.alloc_zeroed(layout);
            if !array.is_null() {
                for first in (0..layout.size()).step_by(SMALL_PAGE) {
                    array.add(first).write_volatile(0);
                }
            }
            array
        }
    }

    unsafe fn dealloc(&self, array: *mut u8, layout: Layout) {
        match mapped(layout.size()) {
            Some(size) if is_large(layout) => keep_or_unmap(Mapping { start: array, size }),
            _ => unsafe { System.dealloc(array, layout) },
        }
    }

    unsafe fn realloc(&self, array: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        unsafe {
            let new = Layout::from_size_align_unchecked(size, layout.align());
            if !is_large(layout) && !is_large(new) {
                return System.realloc(array, layout, size);
            }
            if is_large(layout) && is_large(new) && mapped(layout.size()) == mapped(size) {
                return array;
            }
            let moved = self.alloc(new);
            if !moved.is_null() {
                ptr::copy_nonoverlapping(array, moved, layout.size().min(size));
                self.dealloc(array, layout);
            }
            moved
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Across the limit in both directions, an array keeps its content, and new memory is zero.
    #[test]
    fn arrays_keep_their_content_as_they_grow_and_shrink() {
        for align in [1, 8, 64] {
            let layout = |size| Layout::from_size_align(size, align).unwrap();
            let sizes = [64, LEAST - 1, LEAST, LARGE_PAGE, LARGE_PAGE + 1, 5 * LARGE_PAGE, 64];
            // SAFETY: every layout is the one that the array has at that time, and no byte outside it is touched.
            unsafe {
                let mut array = LargePages.alloc(layout(sizes[0]));
                array.write_bytes(7, 64);
                for pair in sizes.windows(2) {
                    array = LargePages.realloc(array, layout(pair[0]), pair[1]);
                    assert!(!array.is_null() && array.addr().is_multiple_of(align));
                    assert!((0..64).all(|i| *array.add(i) == 7));
                    array.add(pair[1] - 1).write(7);
                }
                LargePages.dealloc(array, layout(64));
                for size in sizes {
                    let array = LargePages.alloc_zeroed(layout(size));
                    assert!((0..size).all(|i| *array.add(i) == 0));
                    LargePages.dealloc(array, layout(size));
                }
            }
        }
    }

    /// A size that no other test asks for: no one takes it in between.
    #[test]
    fn what_was_given_back_is_used_again_and_zeroed_on_demand() {
        let layout = Layout::from_size_align(7 * LARGE_PAGE - 5, 8).unwrap();
        // SAFETY: as above.
        unsafe {
            let array = LargePages.alloc(layout);
            array.write_bytes(7, layout.size());
            LargePages.dealloc(array, layout);
            let again = LargePages.alloc_zeroed(layout);
            assert_eq!(again, array);
            assert!((0..layout.size()).all(|i| *again.add(i) == 0));
            let other = LargePages.alloc(layout);
            assert_ne!(other, again);
            LargePages.dealloc(other, layout);
            LargePages.dealloc(again, layout);
        }
    }

    #[test]
    fn no_more_is_kept_than_there_is_room_for_and_the_oldest_goes() {
        let mut spare = Spare { mappings: [const { None }; SPARE_MAPPINGS], bytes: 0 };
        let at = |i: usize, size| Mapping {
            start: ptr::without_provenance_mut::<u8>(i * LARGE_PAGE),
            size,
        };
        let one = |i| at(i, LARGE_PAGE);
        let too_large = at(1, SPARE_BYTES + LARGE_PAGE);
        assert_eq!(spare.keep(too_large), Err(too_large));
        let all = at(1, SPARE_BYTES);
        assert_eq!(spare.keep(all), Ok(()));
        assert_eq!((spare.keep(one(2)), spare.bytes), (Err(all), 0));
        for i in 1..=SPARE_MAPPINGS {
            assert_eq!(spare.keep(one(i)), Ok(()));
        }
        assert_eq!((spare.keep(one(17)), spare.keep(one(17))), (Err(one(1)), Ok(())));
        assert_eq!((spare.keep(at(18, 2 * LARGE_PAGE)), spare.take(3)), (Err(one(2)), None));
        assert_eq!(spare.take(LARGE_PAGE), Some(one(17)));
        assert_eq!(spare.keep(at(18, 2 * LARGE_PAGE)), Ok(()));
        assert_eq!(spare.take(LARGE_PAGE), Some(one(16)));
        assert_eq!(spare.take(2 * LARGE_PAGE), Some(at(18, 2 * LARGE_PAGE)));
        assert_eq!(spare.bytes, (SPARE_MAPPINGS - 3) * LARGE_PAGE);
    }

    #[test]
    fn what_does_not_exist_is_null() {
        let layout = Layout::from_size_align(isize::MAX as usize - LARGE_PAGE, 8).unwrap();
        // SAFETY: nothing is done with the array.
        assert!(unsafe { LargePages.alloc(layout) }.is_null());
    }
}
