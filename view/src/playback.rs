//! The time line of an animated file.

use std::time::Duration;

use aam_scene::Animation;

/// Where the time line stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Playback {
    /// Frame, with fraction.
    pub(crate) frame: f32,
    pub(crate) playing: bool,
}

impl Playback {
    /// Lets time pass; true if another frame is to be drawn.
    pub(crate) fn advance(&mut self, animation: &Animation, time: Duration) -> bool {
        if !self.playing || animation.frame_count < 2 {
            return false;
        }
        let before = self.index(animation);
        let rate = if animation.frames_per_second.is_finite() { animation.frames_per_second.max(0.0) } else { 0.0 };
        self.frame = (self.frame + rate * time.as_secs_f32()).rem_euclid(animation.frame_count as f32);
        if !self.frame.is_finite() {
            self.frame = 0.0;
        }
        self.index(animation) != before
    }

    /// Stops and goes by whole frames, around the ends.
    pub(crate) fn step(&mut self, animation: &Animation, by: isize) {
        self.playing = false;
        let count = animation.frame_count.max(1) as isize;
        self.frame = (self.index(animation) as isize + by).rem_euclid(count) as f32;
    }

    /// The whole frame that is shown.
    pub(crate) fn index(&self, animation: &Animation) -> usize {
        (self.frame.max(0.0) as usize).min(animation.frame_count.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn animation(frame_count: usize) -> Animation {
        Animation { frames_per_second: 10.0, frame_count, nodes: Vec::new() }
    }

    #[test]
    fn time_moves_frames_and_wraps() {
        let clip = animation(5);
        let mut playback = Playback { frame: 0.0, playing: true };
        assert!(!playback.advance(&clip, Duration::from_millis(50)));
        assert!(playback.advance(&clip, Duration::from_millis(60)));
        assert_eq!(playback.index(&clip), 1);
        playback.advance(&clip, Duration::from_millis(450));
        assert_eq!(playback.index(&clip), 0);
        playback.playing = false;
        assert!(!playback.advance(&clip, Duration::from_secs(1)));
    }

    #[test]
    fn steps_wrap_and_stop() {
        let clip = animation(3);
        let mut playback = Playback { frame: 0.7, playing: true };
        playback.step(&clip, -1);
        assert_eq!((playback.index(&clip), playback.playing), (2, false));
        playback.step(&clip, 1);
        assert_eq!(playback.index(&clip), 0);
    }

    #[test]
    fn an_empty_clip_stands_still() {
        let clip = animation(0);
        let mut playback = Playback { frame: 3.0, playing: true };
        assert!(!playback.advance(&clip, Duration::from_secs(1)));
        playback.step(&clip, 1);
        assert_eq!(playback.index(&clip), 0);
    }
}
