//! Keys of a character's objects.

/// The keys of one kind, from `Anim_Ctrl: Y`. Frames are numbers of frames; values are absolute and local to the parent.
#[derive(Clone, Debug, PartialEq)]
pub enum Track {
    /// `PsSam`: position.
    PositionSampled(Vec<PositionSample>),
    /// `RtSam`: axis and angle in radians.
    RotationSampled(Vec<RotationSample>),
    /// `ScSam`: scale axes as a quaternion, and scale.
    ScaleSampled(Vec<ScaleSample>),
    /// `PsBez`: position with tangents.
    PositionBezier(Vec<PositionBezier>),
    /// `RtBez`: Euler angles X, Y, Z in radians, with tangents.
    RotationBezier(Vec<RotationBezier>),
    /// `ScBez`: scale with tangents.
    ScaleBezier(Vec<ScaleBezier>),
    /// `RtTcb`: axis and angle with tension, continuity, bias and ease.
    RotationTcb(Vec<RotationTcb>),
    /// `RtIPA`: Euler angles X, Y, Z in radians.
    RotationEuler(Vec<RotationEuler>),
}

impl Track {
    /// How many rows it has.
    pub const fn key_count(&self) -> usize {
        match self {
            Self::PositionSampled(rows) => rows.len(),
            Self::RotationSampled(rows) => rows.len(),
            Self::ScaleSampled(rows) => rows.len(),
            Self::PositionBezier(rows) => rows.len(),
            Self::RotationBezier(rows) => rows.len(),
            Self::ScaleBezier(rows) => rows.len(),
            Self::RotationTcb(rows) => rows.len(),
            Self::RotationEuler(rows) => rows.len(),
        }
    }
}

/// A `PsSam` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionSample {
    /// Frame.
    pub frame: f32,
    /// Position.
    pub position: [f32; 3],
}

/// A `RtSam` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationSample {
    /// Frame.
    pub frame: f32,
    /// Axis.
    pub axis: [f32; 3],
    /// Angle in radians.
    pub angle: f32,
}

/// A `ScSam` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleSample {
    /// Frame.
    pub frame: f32,
    /// Orientation of the scale axes, x y z w.
    pub axes: [f32; 4],
    /// Scale.
    pub scale: [f32; 3],
}

/// A `PsBez` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionBezier {
    /// Frame.
    pub frame: f32,
    /// Position.
    pub position: [f32; 3],
    /// Tangent before the key.
    pub tangent_in: [f32; 3],
    /// Tangent after the key.
    pub tangent_out: [f32; 3],
    /// The flag of 3ds Max, ignored.
    pub flag: i32,
}

/// A `RtBez` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationBezier {
    /// Frame.
    pub frame: f32,
    /// Euler angles in radians, applied X, Y, Z.
    pub euler: [f32; 3],
    /// Tangent before the key.
    pub tangent_in: [f32; 3],
    /// Tangent after the key.
    pub tangent_out: [f32; 3],
    /// The flag of 3ds Max, ignored.
    pub flag: i32,
}

/// A `ScBez` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleBezier {
    /// Frame.
    pub frame: f32,
    /// Scale.
    pub scale: [f32; 3],
    /// Orientation of the scale axes, x y z w.
    pub axes: [f32; 4],
    /// Tangent before the key.
    pub tangent_in: [f32; 3],
    /// Tangent after the key.
    pub tangent_out: [f32; 3],
    /// The flag of 3ds Max, ignored.
    pub flag: i32,
}

/// A `RtTcb` row (Kochanek–Bartels).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationTcb {
    /// Frame.
    pub frame: f32,
    /// Axis.
    pub axis: [f32; 3],
    /// Angle in radians.
    pub angle: f32,
    /// Tension.
    pub tension: f32,
    /// Continuity.
    pub continuity: f32,
    /// Bias.
    pub bias: f32,
    /// Ease in.
    pub ease_in: f32,
    /// Ease out.
    pub ease_out: f32,
}

/// A `RtIPA` row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationEuler {
    /// Frame.
    pub frame: f32,
    /// Euler angles in radians, applied X, Y, Z.
    pub euler: [f32; 3],
}
