//! MGF materials to the scene's: photometric units to radiance, colours to RGB, and what has no counterpart noted.

use super::colour::Colour;
use super::source::Entity;
use crate::error::{FormatError, quote};
use glam::DVec3;
use sheen_solver::radiometry::Rgb;
use sheen_solver::scene::{Gloss, Material};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Radiance's luminous efficacy of white light [lm/W].
const WHITE_EFFICACY: f64 = 179.0;

/// What `m` holds. The default is the format's: two-sided, black, index of refraction 1.
#[derive(Clone)]
pub(super) struct MgfMaterial {
    two_sided: bool,
    diffuse: (f64, Colour),
    diffuse_transmission: f64,
    /// [lm/m²]
    emittance: (f64, Colour),
    specular: (f64, Colour),
    roughness: f64,
    transmission: (f64, Colour),
    transmission_roughness: f64,
    refraction: (f64, f64),
}

impl Default for MgfMaterial {
    fn default() -> Self {
        let none = (0.0, Colour::default());
        Self {
            two_sided: true,
            diffuse: none,
            diffuse_transmission: 0.0,
            emittance: none,
            specular: none,
            roughness: 0.0,
            transmission: none,
            transmission_roughness: 0.0,
            refraction: (1.0, 0.0),
        }
    }
}

impl MgfMaterial {
    /// `sides`, `rd`, `td`, `ed`, `rs`, `ts`, `ir`; `colour` is the current one. Ranges are the scene's affair.
    pub(super) fn set(&mut self, entity: Entity<'_>, colour: Colour) -> Result<(), FormatError> {
        let one = |form, what| {
            entity
                .expect_count(1, form)
                .and_then(|()| entity.number(0, what))
        };
        let two = |form, first, second| {
            entity.expect_count(2, form)?;
            Ok::<_, FormatError>((entity.number(0, first)?, entity.number(1, second)?))
        };
        match entity.keyword() {
            "sides" => {
                entity.expect_count(1, "sides 1|2")?;
                self.two_sided = match entity.arguments()[0].as_str() {
                    "1" => false,
                    "2" => true,
                    other => {
                        return Err(
                            entity.fault(format!("sides: expected 1 or 2, found {}", quote(other)))
                        );
                    }
                };
            }
            "rd" => self.diffuse = (one("rd reflectance", "the reflectance")?, colour),
            "td" => self.diffuse_transmission = one("td transmittance", "the transmittance")?,
            "ed" => self.emittance = (one("ed lumens-per-square-metre", "the emittance")?, colour),
            "rs" => {
                let (value, roughness) = two(
                    "rs reflectance roughness",
                    "the reflectance",
                    "the roughness",
                )?;
                (self.specular, self.roughness) = ((value, colour), roughness);
            }
            "ts" => {
                let (value, roughness) = two(
                    "ts transmittance roughness",
                    "the transmittance",
                    "the roughness",
                )?;
                (self.transmission, self.transmission_roughness) = ((value, colour), roughness);
            }
            _ => self.refraction = two("ir real imaginary", "the real part", "the imaginary part")?,
        }
        Ok(())
    }

    /// `ed` [lm/m²].
    pub(super) fn emittance(&self) -> f64 {
        self.emittance.0
    }

    fn to_material(&self, name: &str) -> Material {
        let share = self.saturation();
        let tinted = |(value, colour): (f64, Colour)| {
            rgb(value * (DVec3::ONE + share * (colour.rgb() - DVec3::ONE)))
        };
        let gloss = if self.specular.0 == 0.0 {
            Gloss::None
        } else {
            Gloss::Ward {
                specular: tinted(self.specular),
                roughness: self.roughness as f32,
            }
        };
        let (emittance, colour) = self.emittance;
        Material {
            name: name.to_owned(),
            diffuse: tinted(self.diffuse),
            gloss,
            emission: rgb(emittance / (WHITE_EFFICACY * PI) * colour.rgb()),
            emits_from_back: self.two_sided,
            two_sided: self.two_sided,
            transmission: tinted(self.transmission),
        }
    }

    /// 1; or less, where reflectances that add up to no more than one do so in luminance, but not in every channel.
    /// Their colours then keep this share of their distance from grey, which leaves luminance as it is.
    fn saturation(&self) -> f64 {
        let parts = [self.diffuse, self.specular, self.transmission];
        let luminance: f64 = parts.iter().map(|(value, _)| value).sum();
        let largest = parts
            .iter()
            .map(|(value, colour)| *value * colour.rgb())
            .sum::<DVec3>()
            .max_element();
        if largest <= 1.0 || luminance > 1.0 + 1e-9 {
            return 1.0;
        }
        (1.0 - luminance).max(0.0) / (largest - luminance)
    }

    fn notes(&self, name: &str, notes: &mut Vec<String>) {
        let name = quote(name);
        let transmits = self.transmission.0 != 0.0;
        let share = self.saturation();
        if share < 1.0 {
            notes.push(format!(
                "material {name}: colours taken {:.1} % towards grey, so that no channel reflects more than arrives",
                100.0 * (1.0 - share)
            ));
        }
        if self.diffuse_transmission != 0.0 {
            notes.push(format!(
                "material {name}: diffuse transmission (td {}) is not represented: that light is absorbed",
                self.diffuse_transmission
            ));
        }
        if transmits && self.transmission_roughness != 0.0 {
            notes.push(format!(
                "material {name}: rough transmission (ts with roughness {}) is taken as clear",
                self.transmission_roughness
            ));
        }
        if transmits && self.refraction != (1.0, 0.0) {
            notes.push(format!(
                "material {name}: the index of refraction (ir {} {}) is not used: light passes straight on",
                self.refraction.0, self.refraction.1
            ));
        }
        if transmits && !self.two_sided {
            notes.push(format!(
                "material {name}: one-sided glass (sides 1) is a thin sheet here, not a solid"
            ));
        }
    }
}

fn rgb(DVec3 { x, y, z }: DVec3) -> Rgb {
    Rgb::new(x as f32, y as f32, z as f32)
}

/// The materials that surfaces use, in the order of their first use.
#[derive(Default)]
pub(super) struct MaterialTable {
    pub(super) materials: Vec<Material>,
    indices: HashMap<String, u32>,
}

impl MaterialTable {
    /// Index of `material` as it is now. A name that came with other values before gets a number: `brass.2`.
    pub(super) fn intern(
        &mut self,
        name: &str,
        material: &MgfMaterial,
        notes: &mut Vec<String>,
    ) -> u32 {
        let mut candidate = material.to_material(name);
        let mut number = 2;
        while let Some(&index) = self.indices.get(&candidate.name) {
            if self.materials[index as usize] == candidate {
                return index;
            }
            candidate.name = format!("{name}.{number}");
            number += 1;
        }
        material.notes(&candidate.name, notes);
        let index = self.materials.len() as u32;
        self.indices.insert(candidate.name.clone(), index);
        self.materials.push(candidate);
        index
    }
}
