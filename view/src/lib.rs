//! The window: camera, panels, reload.
