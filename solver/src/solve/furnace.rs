//! The directional furnace: in a closed scene whose surfaces emit L₀ (1 − a(ω)), with a(ω) their directional albedo, the
//! radiance is L₀ at every point in every direction, however surfaces are shaped and whatever their reflection.

use super::prepare::{Emission, Prepared};
use super::{Observer, SolveConfig, solve_prepared};
use crate::brdf::Lobe;
use crate::error::{SceneError, SolveError};
use crate::normalise::Normalised;
use crate::radiometry::Rgb;
use crate::scene::{Material, Scene, Triangle};
use crate::solution::Solution;
use glam::Vec3;

/// The scene with both sides of all its surfaces in a black box a little larger than itself, without clear glass, which
/// takes light and gives none back. Errors: none but for scenes of glass alone.
pub fn enclosed(scene: &Scene) -> Result<Scene, SceneError> {
    /// How far the box is from the scene, as a share of its size.
    const MARGIN: f32 = 1.0 / 16.0;
    let (low, high) = scene.bounds();
    let mut parts = scene.clone().into_parts();
    let is_glass = |t: &Triangle| scene.materials()[t.material as usize].is_glass();
    parts.triangles.retain(|t| !is_glass(t));
    for material in &mut parts.materials {
        material.two_sided = true;
    }
    let material = parts.materials.len() as u32;
    let mut name = "enclosure".to_owned();
    while parts.materials.iter().any(|other| other.name == name) {
        name.push('_');
    }
    parts.materials.push(Material {
        two_sided: false,
        ..Material::lambert(&name, Rgb::BLACK)
    });
    let margin = (high - low).max_element() * MARGIN;
    let (low, high) = (low - margin, high + margin);
    let first = parts.points.len() as u32;
    let is_high = |corner: u32, axis: u32| corner >> axis & 1 == 1;
    parts.points.extend((0..8).map(|corner| {
        let at = |axis: u32, low, high| if is_high(corner, axis) { high } else { low };
        Vec3::new(
            at(0, low.x, high.x),
            at(1, low.y, high.y),
            at(2, low.z, high.z),
        )
    }));
    for axis in 0..3u32 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for (at, order) in [(0, [0, u, u + v, v]), (1 << axis, [0, v, u + v, u])] {
            let [a, b, c, d] = order.map(|corner| first + at + corner);
            parts
                .triangles
                .extend([[a, b, c], [a, c, d]].map(|points| Triangle {
                    points,
                    normals: None,
                    material,
                }));
        }
    }
    Ok(Scene::new(parts, true)?.0)
}

/// Solves an [`enclosed`] scene as a furnace; also returns its radiance L₀ [W·sr⁻¹·m⁻²]. What its lamps do not reach,
/// such as the inside of solid things, is left out as ever, and dark. Errors: as [`super::solve`].
pub fn solve_furnace(
    enclosed: &Scene,
    config: &SolveConfig,
    observer: &mut dyn Observer,
) -> Result<(Solution, f32), SolveError> {
    let solution = solve_prepared(enclosed, config, observer, |settings, watch| {
        let mut prepared = Prepared::watched(enclosed, settings, watch);
        prepared.frame.point_lights.clear();
        for sides in &mut prepared.lit {
            for side in sides {
                side.emits = side.lit;
            }
        }
        let of_material =
            |(diffuse, lobe): (&Rgb, &Option<_>)| compensating(*diffuse, lobe.as_ref());
        prepared.emission = prepared
            .diffuse
            .iter()
            .zip(&prepared.lobes)
            .map(of_material)
            .collect();
        prepared
    })?;
    let unit = Normalised::new(enclosed).radiance_unit();
    Ok((solution, unit))
}

/// 1 − a(ω) of a material.
fn compensating(diffuse: Rgb, lobe: Option<&Lobe>) -> Emission {
    let Some(lobe) = lobe else {
        return Emission {
            even: Rgb::WHITE - diffuse,
            compensating: Rgb::BLACK,
        };
    };
    let (largest, _) = lobe.albedo_range();
    Emission {
        even: (Rgb::WHITE - diffuse - lobe.specular * largest).max(Rgb::BLACK),
        compensating: lobe.specular,
    }
}
