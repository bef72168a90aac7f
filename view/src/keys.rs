//! Keys to actions, and keys held down to flight.

use egui::{Context, InputState, Key, Modifiers};
use glam::Vec3;

use crate::demo::DemoAction;
use crate::eye::Side;
use crate::model::Action;

/// Scene radii a second.
const FLIGHT: f32 = 0.8;
const FAST: f32 = 4.0;

const PRESSED: [(Key, Action); 34] = [
    (Key::F, Action::Fit),
    (Key::Home, Action::Fit),
    (Key::Num1, Action::LookFrom(Side::Front)),
    (Key::Num2, Action::LookFrom(Side::Back)),
    (Key::Num3, Action::LookFrom(Side::Left)),
    (Key::Num4, Action::LookFrom(Side::Right)),
    (Key::Num5, Action::LookFrom(Side::Top)),
    (Key::Num6, Action::LookFrom(Side::Bottom)),
    (Key::Num7, Action::LookFrom(Side::Corner)),
    (Key::O, Action::Orthographic),
    (Key::L, Action::NextLayer),
    (Key::X, Action::Wireframe),
    (Key::N, Action::Normals),
    (Key::B, Action::Bounds),
    (Key::K, Action::Hulls),
    (Key::M, Action::Shadows),
    (Key::V, Action::LightView),
    (Key::Y, Action::Explode),
    (Key::U, Action::Contacts),
    (Key::Z, Action::Sleeping),
    (Key::G, Action::Simulate),
    (Key::J, Action::SimulateStep),
    (Key::Backspace, Action::SimulateReset),
    (Key::Space, Action::PlayPause),
    (Key::Comma, Action::Step(-1)),
    (Key::Period, Action::Step(1)),
    (Key::P, Action::Screenshot),
    (Key::F12, Action::Screenshot),
    (Key::R, Action::Reload),
    (Key::T, Action::Panels),
    (Key::H, Action::Help),
    (Key::F1, Action::Help),
    (Key::Q, Action::Quit),
    (Key::Escape, Action::Quit),
];

/// Keys of the shadow-mapping demo, before all others.
const DEMO: [(Key, Action); 9] = [
    (Key::Space, Action::Demo(DemoAction::NextScene)),
    (Key::L, Action::LightView),
    (Key::P, Action::Demo(DemoAction::Pause)),
    (Key::U, Action::Demo(DemoAction::Resume)),
    (Key::R, Action::Demo(DemoAction::Reset)),
    (Key::ArrowUp, Action::Demo(DemoAction::Faster(5))),
    (Key::ArrowDown, Action::Demo(DemoAction::Faster(-5))),
    (Key::ArrowRight, Action::Demo(DemoAction::Faster(10))),
    (Key::ArrowLeft, Action::Demo(DemoAction::Faster(-10))),
];

/// What the keys of this frame ask for; `demo` while the demo is shown. Nothing while text is typed.
pub(crate) fn actions(context: &Context, demo: bool) -> Vec<Action> {
    if context.egui_wants_keyboard_input() {
        return Vec::new();
    }
    context.input_mut(|input| {
        let mut actions = Vec::new();
        if input.consume_key(Modifiers::COMMAND, Key::S) {
            actions.push(Action::Save);
        }
        for (key, action) in DEMO.into_iter().filter(|_| demo).chain(PRESSED) {
            // Slow frames may hold several presses.
            let presses = input.count_and_consume_key(Modifiers::NONE, key);
            actions.extend(std::iter::repeat_n(action, presses));
        }
        actions
    })
}

/// How far the keys held down fly in `seconds`: right, up, forward.
pub(crate) fn flight(context: &Context, seconds: f32) -> Vec3 {
    if context.egui_wants_keyboard_input() {
        return Vec3::ZERO;
    }
    context.input(|input| {
        if input.modifiers.command || input.modifiers.alt {
            return Vec3::ZERO;
        }
        let axis = |input: &InputState, plus: Key, minus: Key| {
            f32::from(u8::from(input.key_down(plus))) - f32::from(u8::from(input.key_down(minus)))
        };
        let direction =
            Vec3::new(axis(input, Key::D, Key::A), axis(input, Key::E, Key::C), axis(input, Key::W, Key::S));
        direction * seconds * FLIGHT * if input.modifiers.shift { FAST } else { 1.0 }
    })
}
