//! Evaluation of `Anim_Ctrl` keys.
//!
//! Angles are radians, rotations right-handed, frames numbers of frames. Outside its keys a track holds its first or
//! last value. Keys whose frame or values are not finite are left out, the rest is sorted by frame, and of several keys
//! at one frame the last in the file counts.

use glam::{DMat3, DQuat, DVec3};

use crate::document::{RotationTcb, Track};

/// Keys in order of frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys<V> {
    frames: Vec<f64>,
    values: Vec<V>,
}

/// Where a frame lies among keys.
enum Place {
    /// At or outside a key: its value holds.
    On(usize),
    /// Between a key and the next, and how far, in `(0, 1)`.
    Between(usize, f64),
}

impl<V> Keys<V> {
    /// The usable keys of a track, or `None` if there is not one.
    fn of<K>(rows: &[K], key: impl Fn(&K) -> (f32, Option<V>)) -> Option<Self> {
        let usable = |row| match key(row) {
            (frame, Some(value)) if frame.is_finite() => Some((f64::from(frame), value)),
            _ => None,
        };
        let mut keys: Vec<(f64, V)> = rows.iter().filter_map(usable).collect();
        // Stable and from the last to the first, so that the last of equal frames comes first and stays.
        keys.reverse();
        keys.sort_by(|a, b| a.0.partial_cmp(&b.0).unwrap_or(std::cmp::Ordering::Equal));
        keys.dedup_by(|later, kept| later.0 == kept.0);
        let (frames, values): (Vec<_>, Vec<_>) = keys.into_iter().unzip();
        (!frames.is_empty()).then_some(Self { frames, values })
    }

    fn place(&self, frame: f64) -> Place {
        let next = self.frames.partition_point(|&key| key <= frame);
        let Some(before) = next.checked_sub(1) else {
            return Place::On(0);
        };
        match self.frames.get(next) {
            Some(&end) if frame > self.frames[before] => {
                Place::Between(before, (frame - self.frames[before]) / (end - self.frames[before]))
            }
            _ => Place::On(before),
        }
    }

    fn interval(&self, key: usize) -> f64 {
        self.frames[key + 1] - self.frames[key]
    }

    pub(super) fn range(&self) -> (f64, f64) {
        (self.frames[0], self.frames[self.frames.len() - 1])
    }
}

/// A value with its tangents, in units a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bezier {
    value: DVec3,
    tangent_in: DVec3,
    tangent_out: DVec3,
}

impl Bezier {
    fn of(value: [f32; 3], tangent_in: [f32; 3], tangent_out: [f32; 3]) -> Option<Self> {
        Some(Self { value: vector(value)?, tangent_in: vector(tangent_in)?, tangent_out: vector(tangent_out)? })
    }
}

impl Keys<DVec3> {
    fn linear(&self, frame: f64) -> DVec3 {
        match self.place(frame) {
            Place::On(key) => self.values[key],
            Place::Between(key, u) => self.values[key].lerp(self.values[key + 1], u),
        }
    }
}

impl Keys<Bezier> {
    /// Cubic Hermite over the interval between two keys.
    fn hermite(&self, frame: f64) -> DVec3 {
        match self.place(frame) {
            Place::On(key) => self.values[key].value,
            Place::Between(key, u) => {
                let (from, to, length) = (&self.values[key], &self.values[key + 1], self.interval(key));
                let v = 1.0 - u;
                (1.0 + 2.0 * u) * v * v * from.value
                    + u * u * (3.0 - 2.0 * u) * to.value
                    + length * u * v * (v * from.tangent_out - u * to.tangent_in)
            }
        }
    }
}

impl Keys<DQuat> {
    /// On the shortest way between two keys at even speed.
    fn spherical(&self, frame: f64) -> DQuat {
        match self.place(frame) {
            Place::On(key) => self.values[key],
            Place::Between(key, u) => turn_towards(self.values[key], self.values[key + 1], u),
        }
    }
}

/// A Kochanek–Bartels key, ready to evaluate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tcb {
    rotation: DQuat,
    /// The inner control points of the curve before and after the key.
    inner_in: DQuat,
    inner_out: DQuat,
    ease_in: f64,
    ease_out: f64,
}

impl Keys<Tcb> {
    /// Kochanek and Bartels, "Interpolating Splines with Local Tension, Continuity, and Bias Control" (1984), on the
    /// logarithms of unit quaternions (Shoemake's spherical quadrangle with their tangents). About one fixed axis this is
    /// exactly their spline of the angle; with all parameters zero and even spacing it is Catmull–Rom. At both ends the
    /// missing neighbour is taken as moving on evenly.
    fn tcb(rows: &[RotationTcb]) -> Option<Self> {
        let keys = Keys::of(rows, |row| (row.frame, axis_angle(row.axis, row.angle).map(|rotation| (rotation, *row))))?;
        let rotations = same_half(keys.values.iter().map(|&(rotation, _)| rotation).collect());
        let count = rotations.len();
        let values = (0..count)
            .map(|key| {
                let row = keys.values[key].1;
                let rotation = rotations[key];
                let step =
                    |from: usize| Some((log(rotations[from].inverse() * rotations[from + 1]), keys.interval(from)));
                let before = key.checked_sub(1).and_then(step);
                let after = if key + 1 < count { step(key) } else { None };
                let rest = (DVec3::ZERO, 1.0);
                let (before, before_length) = before.or(after).unwrap_or(rest);
                let (after, after_length) =
                    if key + 1 < count { after.unwrap_or(rest) } else { (before, before_length) };
                let [tension, continuity, bias] =
                    [row.tension, row.continuity, row.bias].map(|value| parameter(value, -1.0));
                let (slack, even) = (1.0 - tension, 2.0 / (before_length + after_length));
                let tangent = |c: f64| {
                    0.5 * slack * ((1.0 + c) * (1.0 + bias) * before + (1.0 - c) * (1.0 - bias) * after) * even
                };
                let outgoing = tangent(continuity) * after_length;
                let incoming = tangent(-continuity) * before_length;
                Tcb {
                    rotation,
                    inner_out: rotation * exp(0.5 * (outgoing - after)),
                    inner_in: rotation * exp(0.5 * (before - incoming)),
                    ease_in: parameter(row.ease_in, 0.0),
                    ease_out: parameter(row.ease_out, 0.0),
                }
            })
            .collect();
        Some(Self { frames: keys.frames, values })
    }

    fn at(&self, frame: f64) -> DQuat {
        match self.place(frame) {
            Place::On(key) => self.values[key].rotation,
            Place::Between(key, u) => {
                let (from, to) = (&self.values[key], &self.values[key + 1]);
                let u = ease(u, from.ease_out, to.ease_in);
                let outer = turn_towards(from.rotation, to.rotation, u);
                let inner = turn_towards(from.inner_out, to.inner_in, u);
                turn_towards(outer, inner, 2.0 * u * (1.0 - u))
            }
        }
    }
}

/// The part of an interval that is done at the part `u` of its time, when the first part `out` of the time speeds up
/// and the last part `into` slows down, both evenly, as 3ds Max eases.
fn ease(u: f64, out: f64, into: f64) -> f64 {
    let sum = out + into;
    let (out, into) = if sum > 1.0 { (out / sum, into / sum) } else { (out, into) };
    let speed = 1.0 / (2.0 - out - into);
    if u < out {
        speed / out * u * u
    } else if u <= 1.0 - into {
        speed * (2.0 * u - out)
    } else {
        1.0 - speed / into * (1.0 - u) * (1.0 - u)
    }
}

/// A parameter from `low` to 1; what is not a number is 0.
fn parameter(value: f32, low: f64) -> f64 {
    if value.is_nan() { 0.0 } else { f64::from(value).clamp(low, 1.0) }
}

fn vector(values: [f32; 3]) -> Option<DVec3> {
    let vector = DVec3::from(values.map(f64::from));
    vector.is_finite().then_some(vector)
}

/// A rotation about an axis of any length; no axis is no rotation.
fn axis_angle(axis: [f32; 3], angle: f32) -> Option<DQuat> {
    let axis = vector(axis)?;
    angle
        .is_finite()
        .then(|| axis.try_normalize().map_or(DQuat::IDENTITY, |axis| DQuat::from_axis_angle(axis, f64::from(angle))))
}

/// The rotation of Euler angles: about X first, then Y, then Z, all axes fixed.
fn euler(angles: DVec3) -> DQuat {
    DQuat::from_rotation_z(angles.z) * DQuat::from_rotation_y(angles.y) * DQuat::from_rotation_x(angles.x)
}

/// A quaternion x y z w of any length; zero means identity.
fn quaternion(values: [f32; 4]) -> Option<DQuat> {
    let [x, y, z, w] = values.map(f64::from);
    let quaternion = DQuat::from_xyzw(x, y, z, w);
    quaternion.is_finite().then(|| {
        let length = quaternion.length();
        if length > 0.0 { quaternion * (1.0 / length) } else { DQuat::IDENTITY }
    })
}

/// Flips signs so that each quaternion is on the same half of the sphere as the one before: q and −q are one rotation,
/// but the way between them is not none.
fn same_half(mut rotations: Vec<DQuat>) -> Vec<DQuat> {
    for index in 1..rotations.len() {
        if rotations[index].dot(rotations[index - 1]) < 0.0 {
            rotations[index] = -rotations[index];
        }
    }
    rotations
}

/// The axis times half the angle of a unit quaternion.
fn log(rotation: DQuat) -> DVec3 {
    let axis = DVec3::new(rotation.x, rotation.y, rotation.z);
    let sine = axis.length();
    if sine > 0.0 { axis * (sine.atan2(rotation.w) / sine) } else { DVec3::ZERO }
}

/// The inverse of [`log`].
fn exp(half: DVec3) -> DQuat {
    half.try_normalize().map_or(DQuat::IDENTITY, |axis| DQuat::from_axis_angle(axis, 2.0 * half.length()))
}

/// The part `u` of the way from one rotation to another, the way that their signs say.
fn turn_towards(from: DQuat, to: DQuat, u: f64) -> DQuat {
    (from * exp(u * log(from.inverse() * to))).normalize()
}

/// How a position moves.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PositionCurve {
    Linear(Keys<DVec3>),
    Bezier(Keys<Bezier>),
}

/// How a rotation moves.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum RotationCurve {
    Spherical(Keys<DQuat>),
    Euler(Keys<DVec3>),
    EulerBezier(Keys<Bezier>),
    Tcb(Keys<Tcb>),
}

/// How a scale moves: along axes of its own, which turn on the shortest way.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ScaleCurve {
    Linear(Keys<DQuat>, Keys<DVec3>),
    Bezier(Keys<DQuat>, Keys<Bezier>),
}

impl PositionCurve {
    pub(super) fn at(&self, frame: f64) -> DVec3 {
        match self {
            Self::Linear(keys) => keys.linear(frame),
            Self::Bezier(keys) => keys.hermite(frame),
        }
    }

    pub(super) fn range(&self) -> (f64, f64) {
        match self {
            Self::Linear(keys) => keys.range(),
            Self::Bezier(keys) => keys.range(),
        }
    }
}

impl RotationCurve {
    pub(super) fn at(&self, frame: f64) -> DMat3 {
        DMat3::from_quat(match self {
            Self::Spherical(keys) => keys.spherical(frame),
            Self::Euler(keys) => euler(keys.linear(frame)),
            Self::EulerBezier(keys) => euler(keys.hermite(frame)),
            Self::Tcb(keys) => keys.at(frame),
        })
    }

    pub(super) fn range(&self) -> (f64, f64) {
        match self {
            Self::Spherical(keys) => keys.range(),
            Self::Euler(keys) => keys.range(),
            Self::EulerBezier(keys) => keys.range(),
            Self::Tcb(keys) => keys.range(),
        }
    }
}

impl ScaleCurve {
    pub(super) fn at(&self, frame: f64) -> DMat3 {
        let (axes, scale) = match self {
            Self::Linear(axes, scale) => (axes.spherical(frame), scale.linear(frame)),
            Self::Bezier(axes, scale) => (axes.spherical(frame), scale.hermite(frame)),
        };
        let axes = DMat3::from_quat(axes);
        axes * DMat3::from_diagonal(scale) * axes.transpose()
    }

    pub(super) fn range(&self) -> (f64, f64) {
        match self {
            Self::Linear(axes, _) | Self::Bezier(axes, _) => axes.range(),
        }
    }
}

/// The curves of an object. Of several tracks for one of them the last in the file that has a usable key counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Curves {
    pub(super) position: Option<PositionCurve>,
    pub(super) rotation: Option<RotationCurve>,
    pub(super) scale: Option<ScaleCurve>,
}

impl Curves {
    pub(super) fn of(tracks: &[Track]) -> Self {
        let mut curves = Self::default();
        for track in tracks {
            curves.add(track);
        }
        curves
    }

    fn add(&mut self, track: &Track) {
        let halves = |keys: Keys<DQuat>| Keys { frames: keys.frames, values: same_half(keys.values) };
        match track {
            Track::PositionSampled(rows) => {
                let keys = Keys::of(rows, |row| (row.frame, vector(row.position)));
                self.position = keys.map(PositionCurve::Linear).or(self.position.take());
            }
            Track::PositionBezier(rows) => {
                let value = |row: &crate::document::PositionBezier| {
                    (row.frame, Bezier::of(row.position, row.tangent_in, row.tangent_out))
                };
                self.position = Keys::of(rows, value).map(PositionCurve::Bezier).or(self.position.take());
            }
            Track::RotationSampled(rows) => {
                let keys = Keys::of(rows, |row| (row.frame, axis_angle(row.axis, row.angle)));
                self.rotation = keys.map(halves).map(RotationCurve::Spherical).or(self.rotation.take());
            }
            Track::RotationBezier(rows) => {
                let value = |row: &crate::document::RotationBezier| {
                    (row.frame, Bezier::of(row.euler, row.tangent_in, row.tangent_out))
                };
                self.rotation = Keys::of(rows, value).map(RotationCurve::EulerBezier).or(self.rotation.take());
            }
            Track::RotationTcb(rows) => {
                self.rotation = Keys::tcb(rows).map(RotationCurve::Tcb).or(self.rotation.take());
            }
            Track::RotationEuler(rows) => {
                let keys = Keys::of(rows, |row| (row.frame, vector(row.euler)));
                self.rotation = keys.map(RotationCurve::Euler).or(self.rotation.take());
            }
            Track::ScaleSampled(rows) => {
                let keys = Keys::of(rows, |row| (row.frame, quaternion(row.axes).zip(vector(row.scale))));
                let curve = keys.map(|keys| split(keys, |keys, scale| ScaleCurve::Linear(halves(keys), scale)));
                self.scale = curve.or(self.scale.take());
            }
            Track::ScaleBezier(rows) => {
                let value = |row: &crate::document::ScaleBezier| {
                    let scale = Bezier::of(row.scale, row.tangent_in, row.tangent_out);
                    (row.frame, quaternion(row.axes).zip(scale))
                };
                let curve = Keys::of(rows, value)
                    .map(|keys| split(keys, |keys, scale| ScaleCurve::Bezier(halves(keys), scale)));
                self.scale = curve.or(self.scale.take());
            }
        }
    }
}

/// Keys of pairs as a pair of keys.
fn split<A, B, C>(keys: Keys<(A, B)>, join: impl FnOnce(Keys<A>, Keys<B>) -> C) -> C {
    let frames = keys.frames.clone();
    let (first, second) = keys.values.into_iter().unzip();
    join(Keys { frames: keys.frames, values: first }, Keys { frames, values: second })
}

#[cfg(test)]
#[path = "tracks_tests.rs"]
mod tests;
