//! Figures of a file: what it holds, counted and measured exactly, before anything is tessellated.

use glam::DVec3;
use serde::Serialize;
use std::collections::BTreeMap;

/// Counts, exact areas, flux and bounds of an MGF file. Lengths in the file's units after its transforms (metres).
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MgfStats {
    /// Entities as written, by keyword: arrays do not repeat them, a file included twice counts once.
    pub entities: BTreeMap<String, u64>,
    /// Surfaces as instanced, by keyword.
    pub surfaces: BTreeMap<String, u64>,
    /// All of them.
    pub surface_total: u64,
    /// Those without area.
    pub degenerate: u64,
    /// One-sided area [m²].
    pub area_total: f64,
    /// Of the surfaces whose material has `ed` [m²].
    pub luminaire_area: f64,
    /// Sum of area times `ed`, one side counted [lm].
    pub luminaire_flux_lm: f64,
    /// Smallest corner of the box around all surfaces [m].
    pub bbox_min: [f64; 3],
    /// Largest corner [m].
    pub bbox_max: [f64; 3],
    /// Area by material name as written [m²].
    pub area_per_material: BTreeMap<String, f64>,
    /// Surfaces by material name as written.
    pub surfaces_per_material: BTreeMap<String, u64>,
}

impl MgfStats {
    pub(super) fn new() -> Self {
        Self {
            bbox_min: [f64::INFINITY; 3],
            bbox_max: [f64::NEG_INFINITY; 3],
            ..Self::default()
        }
    }

    pub(super) fn add_entity(&mut self, keyword: &str) {
        add(&mut self.entities, keyword, 1);
    }

    /// One instanced surface; `emittance` is its `ed`.
    pub(super) fn add_surface(&mut self, kind: &str, material: &str, area: f64, emittance: f64) {
        add(&mut self.surfaces, kind, 1);
        add(&mut self.surfaces_per_material, material, 1);
        add(&mut self.area_per_material, material, area);
        self.surface_total += 1;
        self.degenerate += u64::from(area <= 0.0);
        self.area_total += area;
        if emittance > 0.0 {
            self.luminaire_area += area;
            self.luminaire_flux_lm += area * emittance;
        }
    }

    /// Makes the box hold `point` and `extent` around it.
    pub(super) fn grow(&mut self, point: DVec3, extent: DVec3) {
        self.bbox_min = DVec3::from(self.bbox_min).min(point - extent).into();
        self.bbox_max = DVec3::from(self.bbox_max).max(point + extent).into();
    }

    /// Makes the box hold a disc.
    pub(super) fn grow_disc(&mut self, center: DVec3, axis: DVec3, radius: f64) {
        self.grow(
            center,
            radius * (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt),
        );
    }

    /// Of the box [m]; 0 without surfaces.
    pub(super) fn diagonal(&self) -> f64 {
        let diagonal = (DVec3::from(self.bbox_max) - DVec3::from(self.bbox_min)).length();
        if diagonal.is_finite() { diagonal } else { 0.0 }
    }
}

/// Adds without making a new key where there is one already.
fn add<T: std::ops::AddAssign>(map: &mut BTreeMap<String, T>, key: &str, value: T) {
    match map.get_mut(key) {
        Some(sum) => *sum += value,
        None => {
            map.insert(key.to_owned(), value);
        }
    }
}
