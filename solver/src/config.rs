//! Every knob of a solve: default, range, price. One number, the quality, sets them all.

use crate::error::SolveError;
use std::str::FromStr;

/// How good a solution should be. 0 draft, 1 preview, 2 default, 3 high; fractions lie between.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Quality(f32);

impl Quality {
    /// A first look: seconds.
    pub const DRAFT: Self = Self(0.0);
    /// Good enough to place lamps.
    pub const PREVIEW: Self = Self(1.0);
    /// The default.
    pub const DEFAULT: Self = Self(2.0);
    /// For pictures to keep.
    pub const HIGH: Self = Self(3.0);

    /// A quality from its number. Errors: outside 0..=4.
    pub fn new(value: f32) -> Result<Self, SolveError> {
        if (0.0..=4.0).contains(&value) {
            Ok(Self(value))
        } else {
            Err(SolveError::Setting { setting: "quality", value: f64::from(value), expected: "within 0..4" })
        }
    }

    /// The number.
    pub fn value(self) -> f32 {
        self.0
    }
}

impl Default for Quality {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl FromStr for Quality {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "draft" => Ok(Self::DRAFT),
            "preview" => Ok(Self::PREVIEW),
            "default" => Ok(Self::DEFAULT),
            "high" => Ok(Self::HIGH),
            _ => text
                .parse::<f32>()
                .ok()
                .and_then(|value| Self::new(value).ok())
                .ok_or_else(|| format!("'{text}' is none of draft, preview, default, high, or a number within 0..4")),
        }
    }
}
