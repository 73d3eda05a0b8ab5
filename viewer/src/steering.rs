//! From held keys to the eye. egui only, no graphics device.

use crate::camera::Walker;
use egui::{InputState, Key};

/// Turn of the view by a held arrow key [rad/s].
const TURN_RATE: f32 = 1.2;
/// How much faster the eye moves with shift.
const HURRY: f32 = 4.0;
/// Longest step that keys move the eye by at once [s].
const LONGEST_STEP_S: f32 = 0.25;

/// Moves the eye by the keys held, for the time since the last frame.
///
/// A and D, Q and E, S and W move by [`Walker::speed`], with shift faster; arrows turn.
pub fn by_keys(walker: &mut Walker, input: &InputState) {
    let seconds = input.stable_dt.min(LONGEST_STEP_S);
    let held = |forth: Key, back: Key| {
        f32::from(i8::from(input.key_down(forth)) - i8::from(input.key_down(back)))
    };
    let hurry = if input.modifiers.shift { HURRY } else { 1.0 };
    let step = walker.speed * seconds * hurry;
    let (right, up, forward) = (
        held(Key::D, Key::A),
        held(Key::E, Key::Q),
        held(Key::W, Key::S),
    );
    if (right, up, forward) != (0.0, 0.0, 0.0) {
        walker.shift(right * step, up * step, forward * step);
    }
    let (right, up) = (
        held(Key::ArrowRight, Key::ArrowLeft),
        held(Key::ArrowUp, Key::ArrowDown),
    );
    if (right, up) != (0.0, 0.0) {
        walker.turn(right * seconds * TURN_RATE, up * seconds * TURN_RATE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::{FRAME_S, HeldKey, Script};
    use glam::Vec3;
    use sheen_solver::Camera;

    /// Looks along -z, right is +x.
    fn start() -> Camera {
        Camera {
            name: "test".to_owned(),
            eye: Vec3::new(1.0, 2.0, 3.0),
            target: Vec3::new(1.0, 2.0, -1.0),
            up: Vec3::Y,
            fov_y_degrees: 50.0,
            width: 1,
            height: 1,
        }
    }

    const SPEED: f32 = 3.0;
    /// Steps of a sixtieth of a second are added up in f32.
    const ROUNDING: f32 = 1e-4;

    /// Where `keys`, one after the other, move the eye in `frames` frames.
    fn moved(keys: &[(Key, u32)], shift: bool, frames: u32) -> Camera {
        let script = Script {
            keys: keys
                .iter()
                .map(|&(key, frames)| HeldKey { key, frames })
                .collect(),
            frames: 1,
            path: "unused.png".into(),
        };
        let mut walker = Walker::new(&start(), (Vec3::ZERO, Vec3::ONE));
        walker.speed = SPEED;
        let context = egui::Context::default();
        for frame in 0..frames {
            let mut input = egui::RawInput {
                // As from a slow device, and a clock that the script replaces.
                time: Some(f64::from(frame) * 0.7),
                ..egui::RawInput::default()
            };
            let modifiers = egui::Modifiers {
                shift,
                ..egui::Modifiers::NONE
            };
            input.events.push(egui::Event::ModifiersChanged(modifiers));
            script.play(frame, &mut input);
            let mut output = context.run_ui(input, |ui| {
                ui.ctx().request_repaint();
                ui.input(|input| by_keys(&mut walker, input));
            });
            // Nothing is drawn.
            output.textures_delta.clear();
        }
        walker.camera(1, 1)
    }

    #[test]
    fn each_key_moves_the_eye_its_way_for_as_long_as_it_is_held() {
        let way = SPEED * 30.0 * FRAME_S;
        for (key, direction) in [
            (Key::D, Vec3::X),
            (Key::A, Vec3::NEG_X),
            (Key::E, Vec3::Y),
            (Key::Q, Vec3::NEG_Y),
            (Key::W, Vec3::NEG_Z),
            (Key::S, Vec3::Z),
        ] {
            // More frames than the key is held: it is let go.
            let camera = moved(&[(key, 30)], false, 40);
            let expected = start().eye + direction * way;
            assert!(
                camera.eye.distance(expected) < ROUNDING,
                "{key:?}: {}, expected {expected}",
                camera.eye
            );
            assert!((camera.target - camera.eye).distance(Vec3::NEG_Z * 4.0) < ROUNDING);
        }
    }

    #[test]
    fn each_arrow_turns_the_view_its_way() {
        let angle = TURN_RATE * 30.0 * FRAME_S;
        for (key, aside) in [
            (Key::ArrowRight, Vec3::X),
            (Key::ArrowLeft, Vec3::NEG_X),
            (Key::ArrowUp, Vec3::Y),
            (Key::ArrowDown, Vec3::NEG_Y),
        ] {
            let camera = moved(&[(key, 30)], false, 40);
            let view = (camera.target - camera.eye).normalize();
            let expected = aside * angle.sin() + Vec3::NEG_Z * angle.cos();
            assert!(
                view.distance(expected) < ROUNDING && camera.eye == start().eye,
                "{key:?}: {view}, expected {expected}"
            );
        }
    }

    #[test]
    fn keys_follow_each_other_and_shift_hurries() {
        let camera = moved(&[(Key::D, 6), (Key::W, 12), (Key::A, 6)], true, 30);
        let way = SPEED * HURRY * 12.0 * FRAME_S;
        assert!(camera.eye.distance(start().eye + Vec3::NEG_Z * way) < ROUNDING);
        // Nothing is held, nothing moves.
        assert_eq!(moved(&[], true, 30), start());
    }
}
