//! Tests of key evaluation against closed forms.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::*;
use crate::document::{PositionBezier, PositionSample, RotationEuler, RotationSample, ScaleBezier, ScaleSample};

fn near(a: DVec3, b: DVec3) -> bool {
    a.abs_diff_eq(b, 1e-6)
}

fn position(frame: f32, x: f32) -> PositionSample {
    PositionSample { frame, position: [x, 0.0, 0.0] }
}

fn position_at(rows: &[PositionSample], frame: f64) -> f64 {
    Curves::of(&[Track::PositionSampled(rows.to_vec())]).position.unwrap().at(frame).x
}

#[test]
fn samples_are_linear_between_and_hold_outside() {
    let rows = [position(2.0, 10.0), position(4.0, 20.0)];
    for (frame, expected) in [(-5.0, 10.0), (2.0, 10.0), (3.0, 15.0), (4.0, 20.0), (1e30, 20.0)] {
        assert_eq!(position_at(&rows, frame), expected, "frame {frame}");
    }
    assert_eq!(position_at(&rows[..1], 99.0), 10.0);
}

#[test]
fn keys_in_any_order_with_repeats_and_rubbish_still_work() {
    let rows = [
        position(4.0, 20.0),
        position(f32::NAN, 1.0),
        position(0.0, 5.0),
        position(f32::INFINITY, 1.0),
        position(4.0, 30.0),
        position(2.0, f32::NAN),
        position(-0.0, 6.0),
    ];
    assert_eq!(position_at(&rows, 0.0), 6.0, "the last of two keys at one frame, −0 is 0");
    assert_eq!(position_at(&rows, 4.0), 30.0);
    assert_eq!(position_at(&rows, 2.0), 18.0, "the key with NaN is gone");
    assert_eq!(Curves::of(&[Track::PositionSampled(vec![position(f32::NAN, 1.0)])]).position, None);
}

#[test]
fn the_last_usable_track_of_a_kind_counts() {
    let curves = Curves::of(&[
        Track::PositionSampled(vec![position(0.0, 1.0)]),
        Track::PositionSampled(vec![position(0.0, 2.0)]),
        Track::PositionBezier(Vec::new()),
    ]);
    assert_eq!(curves.position.unwrap().at(0.0).x, 2.0);
}

fn bezier(frame: f32, x: f32, tangent_in: f32, tangent_out: f32) -> PositionBezier {
    PositionBezier {
        frame,
        position: [x, 0.0, 0.0],
        tangent_in: [tangent_in, 0.0, 0.0],
        tangent_out: [tangent_out, 0.0, 0.0],
        flag: 6912,
    }
}

#[test]
fn bezier_keys_are_hermite_cubics() {
    let rows = vec![bezier(10.0, 1.0, 7.0, 2.0), bezier(14.0, 5.0, -1.0, 9.0)];
    let curve = Curves::of(&[Track::PositionBezier(rows)]).position.unwrap();
    // Midpoint: (p0 + p1)/2 + Δ·(m0 − m1)/8.
    assert!((curve.at(12.0).x - (3.0 + 4.0 * 3.0 / 8.0)).abs() < 1e-12);
    let step = 1e-6;
    let slope = |at: f64| (curve.at(at + step).x - curve.at(at).x) / step;
    assert!((slope(10.0) - 2.0).abs() < 1e-4, "leaves with its out tangent, in units a frame");
    assert!((slope(14.0 - step) + 1.0).abs() < 1e-4, "arrives with its in tangent");
    // A cubic is reproduced exactly: x = t³ at 0 and 3.
    let rows = vec![bezier(0.0, 0.0, 0.0, 0.0), bezier(3.0, 27.0, 27.0, 0.0)];
    let curve = Curves::of(&[Track::PositionBezier(rows)]).position.unwrap();
    for t in [0.5, 1.0, 2.25] {
        assert!((curve.at(t).x - t * t * t).abs() < 1e-12);
    }
}

fn rotation_at(track: Track, frame: f64) -> DQuat {
    DQuat::from_mat3(&Curves::of(&[track]).rotation.unwrap().at(frame))
}

#[test]
fn euler_angles_turn_about_x_then_y_then_z() {
    let quarter = FRAC_PI_2 as f32;
    let row = |frame, euler| RotationEuler { frame, euler };
    let track = Track::RotationEuler(vec![row(0.0, [quarter, 0.0, quarter])]);
    // X stays under the first turn, and the last takes it to Y; Z goes to −Y and on to X.
    let rotation = rotation_at(track, 0.0);
    assert!(near(rotation * DVec3::X, DVec3::Y) && near(rotation * DVec3::Z, DVec3::X));
    let track = Track::RotationEuler(vec![row(0.0, [0.0; 3]), row(10.0, [0.0, 0.0, 4.0 * TAU as f32])]);
    let eighth = rotation_at(track, 10.0 / 32.0);
    assert!(near(eighth * DVec3::X, DVec3::new(0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0)), "whole turns are kept");
}

fn turn(frame: f32, degrees: f32) -> RotationSample {
    RotationSample { frame, axis: [0.0, 0.0, 2.0], angle: degrees.to_radians() }
}

fn angle_z(rotation: DQuat) -> f64 {
    let x = rotation * DVec3::X;
    x.y.atan2(x.x).to_degrees()
}

#[test]
fn sampled_rotations_take_the_short_way() {
    let track = |a, b| Track::RotationSampled(vec![turn(0.0, a), turn(1.0, b)]);
    assert!((angle_z(rotation_at(track(0.0, 90.0), 0.5)) - 45.0).abs() < 1e-4);
    // 350° is −10°: as quaternions the two lie on opposite halves.
    assert!((angle_z(rotation_at(track(20.0, 350.0), 0.5)) - 5.0).abs() < 1e-4);
    assert!((angle_z(rotation_at(track(170.0, 190.0), 0.5)).abs() - 180.0).abs() < 1e-4);
    let none = RotationSample { frame: 0.0, axis: [0.0; 3], angle: 1.0 };
    assert_eq!(rotation_at(Track::RotationSampled(vec![none]), 0.0), DQuat::IDENTITY);
}

fn tcb(frame: f32, degrees: f32, parameters: [f32; 3], ease: [f32; 2]) -> RotationTcb {
    let [tension, continuity, bias] = parameters;
    let [ease_in, ease_out] = ease;
    RotationTcb {
        frame,
        axis: [0.0, 0.0, 1.0],
        angle: degrees.to_radians(),
        tension,
        continuity,
        bias,
        ease_in,
        ease_out,
    }
}

#[test]
fn with_zero_parameters_tcb_is_catmull_rom() {
    let angles = [10.0, 40.0, 20.0, 80.0];
    let rows = angles.iter().enumerate().map(|(i, &a)| tcb(5.0 * i as f32, a, [0.0; 3], [0.0; 2])).collect();
    let track = Track::RotationTcb(rows);
    let [a, b, c, d] = angles.map(f64::from);
    for u in [0.0, 0.1, 0.25, 0.5, 0.9] {
        let expected = 0.5
            * (2.0 * b
                + (c - a) * u
                + (2.0 * a - 5.0 * b + 4.0 * c - d) * u * u
                + (3.0 * b - a - 3.0 * c + d) * u * u * u);
        let found = angle_z(rotation_at(track.clone(), 5.0 + 5.0 * u));
        assert!((found - expected).abs() < 1e-4, "u {u}: {found} is not {expected}");
    }
}

#[test]
fn tcb_tangents_are_those_of_kochanek_and_bartels() {
    let (t, c, b) = (0.3_f64, -0.4_f64, 0.5_f64);
    let parameters = [t as f32, c as f32, b as f32];
    let rows = vec![
        tcb(0.0, 0.0, [0.0; 3], [0.0; 2]),
        tcb(4.0, 30.0, parameters, [0.0; 2]),
        tcb(10.0, 50.0, [0.0; 3], [0.0; 2]),
    ];
    let track = Track::RotationTcb(rows);
    let step = 1e-5;
    let slope =
        |at: f64| (angle_z(rotation_at(track.clone(), at + step)) - angle_z(rotation_at(track.clone(), at))) / step;
    let (before, after, even) = (30.0, 20.0, 2.0 / (4.0 + 6.0));
    let outgoing = even * 0.5 * (1.0 - t) * ((1.0 + c) * (1.0 + b) * before + (1.0 - c) * (1.0 - b) * after);
    let incoming = even * 0.5 * (1.0 - t) * ((1.0 - c) * (1.0 + b) * before + (1.0 + c) * (1.0 - b) * after);
    assert!((slope(4.0) - outgoing).abs() < 1e-2, "{} is not {outgoing}", slope(4.0));
    assert!((slope(4.0 - step) - incoming).abs() < 1e-2, "{} is not {incoming}", slope(4.0 - step));
}

#[test]
fn tcb_does_not_care_about_the_sign_of_a_quaternion() {
    // The same rotations, the middle one as 40° + 360°, which is −q.
    let keys = |middle| {
        let rows = [10.0, middle, 60.0].into_iter().enumerate();
        Track::RotationTcb(rows.map(|(i, a)| tcb(i as f32, a, [0.0; 3], [0.0; 2])).collect())
    };
    for frame in [0.3, 0.9, 1.0, 1.5, 1.99] {
        let (a, b) = (rotation_at(keys(40.0), frame), rotation_at(keys(400.0), frame));
        assert!(a.dot(b).abs() > 1.0 - 1e-9, "frame {frame}");
    }
}

#[test]
fn tcb_between_different_axes_is_smooth_and_passes_through_its_keys() {
    let row = |frame: f32, axis, angle| RotationTcb { axis, angle, ..tcb(frame, 0.0, [0.0; 3], [0.0; 2]) };
    let rows = vec![
        row(0.0, [1.0, 0.0, 0.0], 0.4),
        row(2.0, [0.0, 1.0, 0.0], 1.0),
        row(3.0, [0.0, 1.0, 1.0], -0.7),
        row(7.0, [1.0, 1.0, 0.0], 0.9),
    ];
    let keys: Keys<Tcb> = Keys::tcb(&rows).unwrap();
    for row in &rows {
        let key = axis_angle(row.axis, row.angle).unwrap();
        assert!(keys.at(f64::from(row.frame)).dot(key).abs() > 1.0 - 1e-12);
    }
    let step = 1e-5;
    for key in [2.0, 3.0] {
        let speed = |at: f64| log(keys.at(at).inverse() * keys.at(at + step)) / step;
        let (before, after) = (speed(key - step), speed(key));
        assert!(before.abs_diff_eq(after, 1e-3), "speed jumps at {key}: {before} to {after}");
    }
}

#[test]
fn easing_starts_and_ends_slowly() {
    assert_eq!(ease(0.3, 0.0, 0.0), 0.3);
    for (out, into) in [(0.5, 0.5), (0.2, 0.0), (0.0, 0.7), (1.0, 1.0), (1.0, 0.0)] {
        assert!(ease(0.0, out, into).abs() < 1e-12 && (ease(1.0, out, into) - 1.0).abs() < 1e-12);
        let samples: Vec<f64> = (0..=1000).map(|i| ease(f64::from(i) / 1000.0, out, into)).collect();
        for pair in samples.windows(3) {
            assert!(pair[1] >= pair[0], "goes backwards");
            assert!((pair[2] - 2.0 * pair[1] + pair[0]).abs() < 2e-5, "jumps at {pair:?}");
        }
    }
    assert!((ease(0.5, 0.5, 0.5) - 0.5).abs() < 1e-12);
    let rows = vec![tcb(0.0, 0.0, [0.0; 3], [0.0, 0.5]), tcb(10.0, 90.0, [0.0; 3], [0.5, 0.0])];
    let angle = angle_z(rotation_at(Track::RotationTcb(rows), 1.0));
    assert!((angle - 90.0 * 2.0 * 0.01).abs() < 1e-4, "one tenth of the time covers 2/100: {angle}");
}

#[test]
fn bad_parameters_do_no_harm() {
    let rows = vec![
        tcb(0.0, 0.0, [f32::NAN, f32::INFINITY, -50.0], [f32::NAN, f32::INFINITY]),
        tcb(10.0, 90.0, [25.0, 1e30, f32::NEG_INFINITY], [-3.0, 2.0]),
        tcb(20.0, f32::NAN, [0.0; 3], [0.0; 2]),
        tcb(30.0, 10.0, [0.0; 3], [0.0; 2]),
    ];
    for frame in 0..=300 {
        let rotation = rotation_at(Track::RotationTcb(rows.clone()), f64::from(frame) / 10.0);
        assert!(rotation.is_normalized(), "frame {frame}: {rotation}");
    }
    let rows = vec![tcb(0.0, 0.0, [0.0; 3], [0.0; 2]), tcb(1.0, 180.0, [0.0; 3], [0.0; 2])];
    assert!(rotation_at(Track::RotationTcb(rows), 0.5).is_normalized());
}

#[test]
fn scales_stretch_along_their_axes() {
    let half = (PI / 8.0) as f32;
    let axes = [0.0, 0.0, half.sin(), half.cos()];
    let row = ScaleSample { frame: 0.0, axes, scale: [3.0, 1.0, 1.0] };
    let scale = Curves::of(&[Track::ScaleSampled(vec![row])]).scale.unwrap().at(0.0);
    let diagonal = DVec3::new(1.0, 1.0, 0.0);
    assert!(near(scale * diagonal, 3.0 * diagonal), "axes at 45°");
    assert!(near(scale * DVec3::new(-1.0, 1.0, 0.0), DVec3::new(-1.0, 1.0, 0.0)));
    let row = |frame, x, out| ScaleBezier {
        frame,
        scale: [x, 1.0, 1.0],
        axes: [0.0; 4],
        tangent_in: [0.0; 3],
        tangent_out: [out, 0.0, 0.0],
        flag: 0,
    };
    let scale = Curves::of(&[Track::ScaleBezier(vec![row(0.0, 1.0, 1.0), row(2.0, 3.0, 0.0)])]).scale.unwrap();
    assert!(near(scale.at(1.0) * DVec3::ONE, DVec3::new(2.0 + 2.0 / 8.0, 1.0, 1.0)), "a zero quaternion is identity");
}
