//! Colour entities to chromaticities, chromaticities to RGB.
//!
//! Every MGF colour ends as a CIE 1931 (x, y): `cmix` weighs by luminance, which is linear in XYZ, so that mixing
//! spectra and mixing their chromaticities give the same. RGB has Radiance's primaries and stays unconverted: what is
//! neutral in MGF, (1/3, 1/3), is neutral here.

use super::source::Entity;
use crate::error::FormatError;
use glam::{DMat3, DVec2, DVec3};

/// A chromaticity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Colour {
    x: f64,
    y: f64,
}

impl Default for Colour {
    fn default() -> Self {
        Self {
            x: 1.0 / 3.0,
            y: 1.0 / 3.0,
        }
    }
}

/// Shortest and longest wavelength of the observer's table, and its step [nm].
const SHORTEST: f64 = 380.0;
const LONGEST: f64 = 780.0;
const STEP: f64 = 10.0;

/// CIE 1931 2° standard observer, 380 to 780 nm by 10 nm, in ten-thousandths: x̄, ȳ, z̄.
#[rustfmt::skip]
const OBSERVER: [[u32; 41]; 3] = [
    [14, 42, 143, 435, 1344, 2839, 3483, 3362, 2908, 1954, 956, 320, 49, 93, 633, 1655, 2904, 4334, 5945, 7621, 9163,
     10263, 10622, 10026, 8544, 6424, 4479, 2835, 1649, 874, 468, 227, 114, 58, 29, 14, 7, 3, 2, 1, 0],
    [0, 1, 4, 12, 40, 116, 230, 380, 600, 910, 1390, 2080, 3230, 5030, 7100, 8620, 9540, 9950, 9950, 9520, 8700,
     7570, 6310, 5030, 3810, 2650, 1750, 1070, 610, 320, 170, 82, 41, 21, 10, 5, 2, 1, 1, 0, 0],
    [65, 201, 679, 2074, 6456, 13856, 17471, 17721, 16692, 12876, 8130, 4652, 2720, 1582, 782, 422, 203, 87, 39, 21,
     17, 11, 8, 3, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
];

impl Colour {
    /// `cxy`, `cspec` or `cct`; `cmix` has [`Colour::mix`].
    pub(super) fn parse(entity: Entity<'_>) -> Result<Self, FormatError> {
        match entity.keyword() {
            "cxy" => Self::parse_xy(entity),
            "cct" => Self::parse_temperature(entity),
            _ => Self::parse_spectrum(entity),
        }
    }

    fn parse_xy(entity: Entity<'_>) -> Result<Self, FormatError> {
        entity.expect_count(2, "cxy x y")?;
        let (x, y) = (entity.number(0, "x")?, entity.number(1, "y")?);
        if x >= 0.0 && y > 0.0 && x + y <= 1.0 + 1e-9 {
            Ok(Self { x, y })
        } else {
            Err(entity.fault(format!(
                "cxy: expected a chromaticity (x ≥ 0, y > 0, x + y ≤ 1), found {x} {y}"
            )))
        }
    }

    fn parse_temperature(entity: Entity<'_>) -> Result<Self, FormatError> {
        entity.expect_count(1, "cct temperature")?;
        let kelvin = entity.number(0, "the temperature")?;
        // Planck's law up to a factor; hc/k in m K.
        let planck = |nanometres: f64| {
            let metres = nanometres * 1e-9;
            (1e-7 / metres).powi(5) / (1.4388e-2 / (metres * kelvin)).exp_m1()
        };
        // Radiance's limit: below it there is next to no visible light.
        (kelvin >= 1000.0)
            .then(|| Self::observed(planck))
            .flatten()
            .ok_or_else(|| {
                entity.fault(format!(
                    "cct: expected a temperature of at least 1000 K, found {kelvin}"
                ))
            })
    }

    fn parse_spectrum(entity: Entity<'_>) -> Result<Self, FormatError> {
        let count = entity.arguments().len();
        if count < 4 {
            return Err(entity.wrong_count("cspec shortest longest value value ..."));
        }
        let (shortest, longest) = (
            entity.number(0, "the shortest wavelength")?,
            entity.number(1, "the longest wavelength")?,
        );
        if shortest >= longest {
            return Err(entity.fault(format!(
                "cspec: expected the shorter wavelength first, found {shortest} {longest}"
            )));
        }
        let values = (2..count)
            .map(|at| entity.number(at, "a value"))
            .collect::<Result<Vec<f64>, _>>()?;
        let spacing = (longest - shortest) / (values.len() - 1) as f64;
        let interpolated = |nanometres: f64| {
            let place = (nanometres - shortest) / spacing;
            if !(-1e-9..=(values.len() - 1) as f64 + 1e-9).contains(&place) {
                return 0.0;
            }
            let left = (place.max(0.0) as usize).min(values.len() - 2);
            let share = (place - left as f64).clamp(0.0, 1.0);
            values[left] * (1.0 - share) + values[left + 1] * share
        };
        let found = if spacing >= STEP {
            Self::observed(interpolated)
        } else {
            // Finer than the observer's table: means over its steps.
            Self::observed(|centre| {
                (0..10)
                    .map(|i| interpolated(centre - 4.5 + f64::from(i)))
                    .sum::<f64>()
            })
        };
        found.ok_or_else(|| {
            entity.fault(format!(
                "cspec: expected some visible light within {SHORTEST}..{LONGEST} nm, found none in {shortest}..{longest}"
            ))
        })
    }

    /// The chromaticity of a spectrum; `None` when the observer sees nothing, or nothing real.
    fn observed(spectrum: impl Fn(f64) -> f64) -> Option<Self> {
        let mut sums = [0.0; 3];
        for index in 0..OBSERVER[0].len() {
            let value = spectrum(SHORTEST + STEP * index as f64);
            for (sum, table) in sums.iter_mut().zip(&OBSERVER) {
                *sum += value * f64::from(table[index]);
            }
        }
        // Each table by its own sum, so that equal energy is exactly (1/3, 1/3).
        let [x, y, z] =
            std::array::from_fn(|i| sums[i] / f64::from(OBSERVER[i].iter().sum::<u32>()));
        Self::from_xyz(DVec3::new(x, y, z))
    }

    /// `cmix weight colour ...`, the named colours already looked up.
    pub(super) fn mix(entity: Entity<'_>, colours: &[(f64, Self)]) -> Result<Self, FormatError> {
        let xyz = colours.iter().fold(DVec3::ZERO, |sum, &(weight, colour)| {
            sum + weight * colour.xyz()
        });
        Self::from_xyz(xyz).ok_or_else(|| {
            entity.fault("cmix: expected weights whose sum is a colour with luminance")
        })
    }

    fn from_xyz(xyz: DVec3) -> Option<Self> {
        let sum = xyz.element_sum();
        let (x, y) = (xyz.x / sum, xyz.y / sum);
        (xyz.y > 0.0 && sum > 0.0 && x.is_finite() && y > 1e-9 && x >= 0.0).then_some(Self { x, y })
    }

    /// At luminance 1.
    fn xyz(self) -> DVec3 {
        DVec3::new(self.x / self.y, 1.0, (1.0 - self.x - self.y) / self.y)
    }

    /// Radiance's R, G, B of this colour at luminance 1. What lies outside the primaries' triangle is moved towards
    /// grey at the same luminance, as Radiance does, until no channel is negative.
    pub(super) fn rgb(self) -> DVec3 {
        let rgb = xyz_from_rgb().inverse() * self.xyz();
        let least = rgb.min_element();
        if least >= 0.0 {
            rgb
        } else {
            (DVec3::ONE + (rgb - DVec3::ONE) / (1.0 - least)).max(DVec3::ZERO)
        }
    }
}

/// XYZ of Radiance's primaries, scaled so that (1, 1, 1) is equal-energy white of luminance 1.
fn xyz_from_rgb() -> DMat3 {
    let primaries = [
        DVec2::new(0.640, 0.330),
        DVec2::new(0.290, 0.600),
        DVec2::new(0.150, 0.060),
    ];
    let [r, g, b] = primaries.map(|p| DVec3::new(p.x, p.y, 1.0 - p.x - p.y));
    let unscaled = DMat3::from_cols(r, g, b);
    unscaled * DMat3::from_diagonal(unscaled.inverse() * DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminance_weights_are_radiances() {
        let weights = xyz_from_rgb().row(1);
        assert!(
            (weights - DVec3::new(0.2651, 0.6701, 0.0648))
                .abs()
                .max_element()
                < 5e-5,
            "{weights}"
        );
    }

    #[test]
    fn grey_is_neutral_and_colours_have_unit_luminance() {
        assert!((Colour::default().rgb() - DVec3::ONE).abs().max_element() < 1e-12);
        let weights = xyz_from_rgb().row(1);
        for colour in [
            Colour { x: 0.64, y: 0.33 },
            Colour { x: 0.08, y: 0.85 },
            Colour { x: 0.17, y: 0.005 },
        ] {
            let rgb = colour.rgb();
            assert!(
                rgb.min_element() >= 0.0 && (rgb.dot(weights) - 1.0).abs() < 1e-9,
                "{colour:?} {rgb}"
            );
        }
    }

    #[test]
    fn spectra() {
        let flat = Colour::observed(|_| 3.0).expect("visible");
        assert!((flat.x - 1.0 / 3.0).abs() < 1e-12 && (flat.y - 1.0 / 3.0).abs() < 1e-12);
        // CIE illuminant A is a Planckian radiator of 2856 K: (0.4476, 0.4074).
        let a = Colour::observed(|l| (l * 1e-3).powi(-5) / (1.4388e7 / (l * 2856.0)).exp_m1())
            .expect("visible");
        assert!(
            (a.x - 0.4476).abs() < 1e-3 && (a.y - 0.4074).abs() < 1e-3,
            "{a:?}"
        );
    }
}
