//! Linear Rec. 709 triples. Which quantity a triple is (radiance, irradiance, ...) stands with its owner.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

/// Three channels, linear Rec. 709 primaries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct Rgb {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
}

impl Rgb {
    /// No light.
    pub const BLACK: Self = Self::new(0.0, 0.0, 0.0);
    /// One in every channel.
    pub const WHITE: Self = Self::new(1.0, 1.0, 1.0);

    /// A triple from its channels.
    pub const fn new(r: f32, g: f32, b: f32) -> Self {
        Self { r, g, b }
    }

    /// The same value in every channel.
    pub const fn splat(value: f32) -> Self {
        Self::new(value, value, value)
    }

    /// The channels in double precision, for sums.
    pub fn to_dvec3(self) -> DVec3 {
        DVec3::from_array(self.to_array().map(f64::from))
    }

    /// Largest channel.
    pub fn max_channel(self) -> f32 {
        self.r.max(self.g).max(self.b)
    }

    /// Smallest channel.
    pub fn min_channel(self) -> f32 {
        self.r.min(self.g).min(self.b)
    }

    /// Mean of the channels.
    pub fn mean(self) -> f32 {
        (self.r + self.g + self.b) * (1.0 / 3.0)
    }

    /// Rec. 709 luminance weights applied to the channels.
    pub fn luminance(self) -> f32 {
        0.2126 * self.r + 0.7152 * self.g + 0.0722 * self.b
    }

    /// True when every channel is exactly zero.
    pub fn is_black(self) -> bool {
        self.r == 0.0 && self.g == 0.0 && self.b == 0.0
    }

    /// True when every channel is finite.
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.g.is_finite() && self.b.is_finite()
    }

    /// Channel-wise maximum.
    pub fn max(self, other: Self) -> Self {
        Self::new(
            self.r.max(other.r),
            self.g.max(other.g),
            self.b.max(other.b),
        )
    }

    /// Channel-wise minimum.
    pub fn min(self, other: Self) -> Self {
        Self::new(
            self.r.min(other.r),
            self.g.min(other.g),
            self.b.min(other.b),
        )
    }

    /// The channels as an array.
    pub fn to_array(self) -> [f32; 3] {
        [self.r, self.g, self.b]
    }
}

impl From<[f32; 3]> for Rgb {
    fn from([r, g, b]: [f32; 3]) -> Self {
        Self::new(r, g, b)
    }
}

impl Add for Rgb {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.r + o.r, self.g + o.g, self.b + o.b)
    }
}

impl AddAssign for Rgb {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Rgb {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.r - o.r, self.g - o.g, self.b - o.b)
    }
}

impl Mul for Rgb {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self::new(self.r * o.r, self.g * o.g, self.b * o.b)
    }
}

impl Mul<f32> for Rgb {
    type Output = Self;
    fn mul(self, s: f32) -> Self {
        Self::new(self.r * s, self.g * s, self.b * s)
    }
}

impl MulAssign<f32> for Rgb {
    fn mul_assign(&mut self, s: f32) {
        *self = *self * s;
    }
}

impl Div<f32> for Rgb {
    type Output = Self;
    fn div(self, s: f32) -> Self {
        Self::new(self.r / s, self.g / s, self.b / s)
    }
}

/// Flux per channel in f64: sums of power over many elements are kept in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flux(pub [f64; 3]);

impl Flux {
    /// Adds `density` [W·m⁻²] over `area` [m²].
    pub fn add(&mut self, density: Rgb, area: f32) {
        for (sum, channel) in self.0.iter_mut().zip(density.to_array()) {
            *sum += f64::from(channel) * f64::from(area);
        }
    }

    /// Sum over the channels.
    pub fn total(self) -> f64 {
        self.0.iter().sum()
    }
}

impl AddAssign for Flux {
    fn add_assign(&mut self, o: Self) {
        for (sum, channel) in self.0.iter_mut().zip(o.0) {
            *sum += channel;
        }
    }
}
