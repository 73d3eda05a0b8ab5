//! A window that no person sits at: keys held for some frames, then a picture of the window. For tests.

use egui::{Event, Key, Modifiers, RawInput};
use std::path::PathBuf;
use std::str::FromStr;

/// How long a frame lasts to keys, however long it takes to draw [s]: the way of the eye does not depend on the device.
pub const FRAME_S: f32 = 1.0 / 60.0;

/// A key that is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeldKey {
    /// Which key.
    pub key: Key,
    /// For so many frames.
    pub frames: u32,
}

/// As typed: `w:30`, `ArrowLeft:5`.
impl FromStr for HeldKey {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.rsplit_once(':')
            .and_then(|(key, frames)| {
                Some(Self {
                    key: Key::from_name(key)?,
                    frames: frames.parse::<u16>().ok()?.into(),
                })
            })
            .ok_or_else(|| format!("'{text}' is not a key and frames, as in w:30"))
    }
}

/// What happens in the window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Script {
    /// Held one after the other, from the first frame on.
    pub keys: Vec<HeldKey>,
    /// Frames to draw after the keys, at least 1.
    pub frames: u32,
    /// PNG to write then; after it the window closes.
    pub path: PathBuf,
}

impl Script {
    /// Frames drawn until the picture is taken.
    pub fn length(&self) -> u32 {
        self.keys
            .iter()
            .map(|held| held.frames)
            .fold(self.frames, u32::saturating_add)
    }

    /// The key held in a frame, counted from 0.
    fn held(&self, frame: u32) -> Option<Key> {
        let mut end = 0u32;
        self.keys.iter().find_map(|held| {
            end = end.saturating_add(held.frames);
            (frame < end).then_some(held.key)
        })
    }

    /// Adds to `input`, before egui sees it, what a keyboard and a steady clock would say in this frame.
    ///
    /// Every key of the script is reported in every frame, as down or up: a window that gains or loses the focus
    /// meanwhile lets go of all keys.
    pub fn play(&self, frame: u32, input: &mut RawInput) {
        // Without a time, egui adds the predicted step.
        input.time = None;
        input.predicted_dt = FRAME_S;
        let held = self.held(frame);
        let events = self.keys.iter().map(|&HeldKey { key, .. }| Event::Key {
            key,
            physical_key: None,
            pressed: held == Some(key),
            repeat: false,
            modifiers: Modifiers::NONE,
        });
        input.events.extend(events);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_read_or_explained() {
        let read = |text: &str| text.parse::<HeldKey>();
        let expected = |key, frames| Ok(HeldKey { key, frames });
        assert_eq!(read("w:30"), expected(Key::W, 30));
        assert_eq!(read("ArrowLeft:5"), expected(Key::ArrowLeft, 5));
        for text in ["", "w", "w:", "w:-1", "w:99999", "ctrl+w:3", ":3"] {
            assert!(read(text).is_err(), "{text}");
        }
    }

    #[test]
    fn keys_are_held_one_after_the_other() {
        let key = |key, frames| HeldKey { key, frames };
        let script = Script {
            keys: vec![key(Key::W, 2), key(Key::A, 0), key(Key::D, 1)],
            frames: 4,
            path: PathBuf::new(),
        };
        let held: Vec<_> = (0..5).map(|frame| script.held(frame)).collect();
        assert_eq!(held, [Some(Key::W), Some(Key::W), Some(Key::D), None, None]);
        assert_eq!(script.length(), 7);
    }
}
