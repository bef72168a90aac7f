//! The scene at a frame of its animation.

/// The frame number as a position: rounded down, and 0 where it is negative or not a number.
pub(crate) fn index(frame: f32) -> usize {
    frame as usize
}
