//! Draws a scene with wgpu, to a window or off screen.
