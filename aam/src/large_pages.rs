//! Large pages for large lists.
//!
//! The system hands out fresh memory page by page, and clears each when it is first touched. With pages of 4 KiB this took
//! nearly as long as all else of reading: see `docs/techniques/reading.md`. Linux has larger pages, for those that ask.

/// The size of a large page on most systems. Where they are larger, asking for less has no effect.
#[cfg(target_os = "linux")]
const PAGE: usize = 2 << 20;

/// Asks for large pages for a list whose memory was not touched yet: with all its room reserved and empty, or all zeros. Nothing
/// but time hangs on whether the system grants them.
#[cfg(target_os = "linux")]
pub(crate) fn in_large_pages<T>(mut list: Vec<T>) -> Vec<T> {
    let start = list.as_mut_ptr().cast::<u8>();
    let skipped = start.align_offset(PAGE);
    let length = (list.capacity() * size_of::<T>()).saturating_sub(skipped) / PAGE * PAGE;
    if length > 0 {
        let first = start.wrapping_add(skipped).cast();
        #[expect(unsafe_code, reason = "large pages have no safe interface but for maps, which are no lists")]
        // SAFETY: the range lies within the list's memory, which is borrowed mutably; this advice changes no content.
        let advised = unsafe { rustix::mm::madvise(first, length, rustix::mm::Advice::LinuxHugepage) };
        // A system without large pages says so, which does no harm.
        let _ = advised;
    }
    list
}

/// As it is: this system has no such advice.
#[cfg(not(target_os = "linux"))]
pub(crate) fn in_large_pages<T>(list: Vec<T>) -> Vec<T> {
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_any_length_keep_what_they_hold() {
        for bytes in [0, 1, 4095, 2 << 20, (2 << 20) + 1, (4 << 20) - 1, 9 << 20] {
            let zeros = in_large_pages(vec![0u8; bytes]);
            assert!(zeros.len() == bytes && zeros.iter().all(|&byte| byte == 0));
            let list: Vec<u32> = (0..bytes as u32 / 4).collect();
            assert_eq!(in_large_pages(list.clone()), list);
        }
        assert_eq!(in_large_pages(vec![(); 10]).len(), 10);
    }
}
