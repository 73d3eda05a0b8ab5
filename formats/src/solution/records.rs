//! What stands in the JSON chunks: materials, cameras, statistics.

use serde::{Deserialize, Serialize};
use sheen_solver::{Camera, Gloss, Material, Rgb, Stats};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialRecord {
    name: String,
    diffuse: Rgb,
    gloss: GlossRecord,
    emission: Rgb,
    emits_from_back: bool,
    two_sided: bool,
    transmission: Rgb,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
enum GlossRecord {
    None,
    Phong { specular: Rgb, exponent: f32 },
    Ward { specular: Rgb, roughness: f32 },
}

impl From<&Material> for MaterialRecord {
    fn from(material: &Material) -> Self {
        Self {
            name: material.name.clone(),
            diffuse: material.diffuse,
            gloss: match material.gloss {
                Gloss::None => GlossRecord::None,
                Gloss::Phong { specular, exponent } => GlossRecord::Phong { specular, exponent },
                Gloss::Ward {
                    specular,
                    roughness,
                } => GlossRecord::Ward {
                    specular,
                    roughness,
                },
            },
            emission: material.emission,
            emits_from_back: material.emits_from_back,
            two_sided: material.two_sided,
            transmission: material.transmission,
        }
    }
}

impl From<MaterialRecord> for Material {
    fn from(record: MaterialRecord) -> Self {
        Self {
            name: record.name,
            diffuse: record.diffuse,
            gloss: match record.gloss {
                GlossRecord::None => Gloss::None,
                GlossRecord::Phong { specular, exponent } => Gloss::Phong { specular, exponent },
                GlossRecord::Ward {
                    specular,
                    roughness,
                } => Gloss::Ward {
                    specular,
                    roughness,
                },
            },
            emission: record.emission,
            emits_from_back: record.emits_from_back,
            two_sided: record.two_sided,
            transmission: record.transmission,
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraRecord {
    name: String,
    eye: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    fov_y_degrees: f32,
    width: u32,
    height: u32,
}

impl From<&Camera> for CameraRecord {
    fn from(camera: &Camera) -> Self {
        Self {
            name: camera.name.clone(),
            eye: camera.eye.to_array(),
            target: camera.target.to_array(),
            up: camera.up.to_array(),
            fov_y_degrees: camera.fov_y_degrees,
            width: camera.width,
            height: camera.height,
        }
    }
}

impl From<CameraRecord> for Camera {
    fn from(record: CameraRecord) -> Self {
        Self {
            name: record.name,
            eye: record.eye.into(),
            target: record.target.into(),
            up: record.up.into(),
            fov_y_degrees: record.fov_y_degrees,
            width: record.width,
            height: record.height,
        }
    }
}

/// The statistics without what differs from run to run: seconds and resident memory are zero.
pub(super) fn reproducible(stats: &Stats) -> Stats {
    let mut stats = stats.clone();
    stats.solve.wall_s = 0.0;
    stats.solve.cpu_s = 0.0;
    stats.solve.peak_rss_bytes = 0;
    stats.solve.phases_s = Default::default();
    stats
}

/// Statistics as JSON. A number that is not finite, which JSON cannot hold, is left out and read as zero.
pub(super) fn stats_json(stats: &Stats) -> serde_json::Result<Vec<u8>> {
    fn drop_nulls(value: &mut serde_json::Value) {
        if let serde_json::Value::Object(fields) = value {
            fields.retain(|_, field| !field.is_null());
            fields.values_mut().for_each(drop_nulls);
        }
    }
    let mut value = serde_json::to_value(reproducible(stats))?;
    drop_nulls(&mut value);
    serde_json::to_vec(&value)
}
