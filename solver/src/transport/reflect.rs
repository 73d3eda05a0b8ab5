//! Reflection (§3.3): all illumination samples of a place become its exitant light at once.
//!
//! The sum is projected, never one reflection after the other (table 1). Samples whose lobe cannot reach a cell are
//! left out of its evaluations, so their number does not grow as samples × cells.

use crate::brdf::Lobe;
use crate::config::Refiner;
use crate::directional::{Basis, Projection, ProjectionCost, Projector, Sum, octahedron};
use crate::radiometry::Rgb;
use crate::transport::closure::Dark;
use crate::transport::illumination::IlluminationSample;
use crate::transport::lobes::Lobes;
use crate::transport::merge::merged;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// Exitant light of a place.
#[derive(Clone, Debug, Default)]
pub struct Reflected {
    /// Irradiance [W·m⁻²].
    pub irradiance: Rgb,
    /// Diffusely reflected radiance.
    pub diffuse: Rgb,
    /// Packed distribution of glossily reflected radiance.
    pub distribution: Option<Box<[u32]>>,
    /// Exitance [W·m⁻²]: diffuse and glossy.
    pub exitance: Rgb,
    /// Cost of the projection.
    pub cost: ProjectionCost,
    /// BRDF evaluations.
    pub brdf_evaluations: u64,
}

impl Reflected {
    /// What a diffuse surface makes of `irradiance`.
    pub fn diffusely(irradiance: Rgb, reflectance: Rgb) -> Self {
        Self {
            irradiance,
            diffuse: irradiance * reflectance * FRAC_1_PI,
            exitance: irradiance * reflectance,
            ..Self::default()
        }
    }
}

/// How to project reflected light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectConfig {
    /// ε of the refiner.
    pub epsilon: f32,
    /// What deviations are held against.
    pub refiner: Refiner,
    /// What is projected on.
    pub basis: Basis,
    /// Deepest level of the basis.
    pub max_level: u32,
    /// Radiance that is far too small to matter, as a share of the diffuse radiance.
    pub floor: f32,
    /// Radiance anywhere in the scene that such a floor never falls below.
    pub least: f32,
    /// Typical radiance of the scene, which the absolute refiner holds deviations against.
    pub typical: f32,
    /// Make the projection carry exactly the reflected power; glossy light weaker than `least` becomes diffuse.
    pub conserve: bool,
}

/// A place of a surface that reflects.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Shading normal.
    pub normal: Vec3,
    /// Diffuse reflectance.
    pub diffuse: Rgb,
    /// Its lobe, if it is glossy.
    pub lobe: Option<&'a Lobe>,
    /// Emission that makes up for what the lobe does not reflect ([`crate::solve::Emission`]).
    pub compensating: Rgb,
    /// Angular radius [rad] over which mirror directions vary within the place, where it is curved.
    pub bend: f32,
    /// Where nothing sends. `None` where that is not known: the lobe is not closed.
    pub dark: Option<&'a Dark>,
}

/// Reflects `samples` at a surface. One BRDF evaluation per sample and direction that it can reach. Source: §3.3, §4.2.
pub fn reflect(
    samples: &[IlluminationSample],
    surface: &Surface<'_>,
    config: &ReflectConfig,
    projector: &mut Projector,
) -> Reflected {
    let (mut out, is_directional) = projected(samples, surface, config, projector);
    if is_directional {
        let mut words = Vec::new();
        out.cost.basis_functions = projector.pack(&mut words);
        if out.cost.basis_functions > 0 {
            out.distribution = Some(words.into_boxed_slice());
        }
    }
    out
}

/// Reflects each of `samples` on its own and adds up what they become: "summing reflections" of table 1, and what
/// radiance clustering does (§2.2). The plain twin of [`reflect`]; basis functions are those of all summands. No sample is
/// too weak for its direction to matter: nobody knows how many there will be.
pub fn reflect_each(
    samples: &[IlluminationSample],
    surface: &Surface<'_>,
    config: &ReflectConfig,
    projector: &mut Projector,
    sum: &mut Sum,
) -> Reflected {
    let config = ReflectConfig {
        least: 0.0,
        ..*config
    };
    let mut out = Reflected::default();
    let mut is_any_directional = false;
    sum.clear(Some(surface.normal));
    let mut add = |samples: &[IlluminationSample], surface: &Surface<'_>| {
        let (one, is_directional) = projected(samples, surface, &config, projector);
        out.irradiance += one.irradiance;
        out.diffuse += one.diffuse;
        out.exitance += one.exitance;
        out.cost.evaluations += one.cost.evaluations;
        out.brdf_evaluations += one.brdf_evaluations;
        if is_directional {
            out.cost.basis_functions += projector.basis_functions();
            sum.add(projector);
            is_any_directional = true;
        }
    };
    let without_emission = Surface {
        compensating: Rgb::BLACK,
        ..*surface
    };
    for sample in samples {
        add(std::slice::from_ref(sample), &without_emission);
    }
    if !surface.compensating.is_black() {
        add(&[], surface);
    }
    if is_any_directional {
        let mut words = Vec::new();
        if sum.pack(&mut words) > 0 {
            out.distribution = Some(words.into_boxed_slice());
        }
    }
    out
}

/// [`Reflected`] but for the distribution, which is left in `projector`; and whether there is one.
fn projected(
    samples: &[IlluminationSample],
    surface: &Surface<'_>,
    config: &ReflectConfig,
    projector: &mut Projector,
) -> (Reflected, bool) {
    let &Surface {
        normal,
        diffuse,
        lobe,
        compensating,
        bend,
        dark,
    } = surface;
    let mut irradiance = Rgb::BLACK;
    let mut glossy_exitance = Rgb::BLACK;
    for sample in samples {
        let cosine = sample.direction.dot(normal);
        if cosine <= 0.0 {
            continue;
        }
        let light = sample.irradiance * cosine;
        irradiance += light;
        if let Some(lobe) = lobe {
            glossy_exitance += light * lobe.specular * lobe.albedo(cosine);
        }
    }
    let mut out = Reflected::diffusely(irradiance, diffuse);
    out.exitance += glossy_exitance;
    let Some(lobe) = lobe else {
        return (out, false);
    };
    if out.irradiance.is_black() && compensating.is_black() {
        return (out, false);
    }
    let (largest, mean) = lobe.albedo_range();
    let emitted = compensating * (PI * (largest - mean));
    glossy_exitance += emitted;
    out.exitance += emitted;
    let mean_glossy = glossy_exitance.mean() * FRAC_1_PI;
    if config.conserve && mean_glossy < config.least {
        // Too weak for its direction to matter to others: it travels with the diffuse light.
        out.diffuse += glossy_exitance * FRAC_1_PI;
        return (out, false);
    }
    let how = Projection {
        min_level: 1,
        max_level: match config.basis {
            Basis::Haar => config.max_level.min(finest_level(lobe)),
            Basis::Uniform => config.max_level,
        },
        epsilon: config.epsilon,
        floor: match config.refiner {
            Refiner::Relative => {
                (config.floor * (out.diffuse.mean() + mean_glossy)).max(config.least)
            }
            Refiner::Absolute => config.typical,
        },
        relative: config.refiner == Refiner::Relative,
        horizon: Some(normal),
        integral: config.conserve.then_some(glossy_exitance.mean()),
        basis: config.basis,
    };
    let few = merged(samples, normal, lobe.half_width.hypot(bend));
    let mut source = Lobes::new(lobe, normal, &few, dark, bend, compensating);
    out.cost.evaluations = projector.project_only(&mut source, &how);
    out.brdf_evaluations = source.evaluations;
    (out, true)
}

/// The level whose cells are a third of the lobe's half-width: linear interpolation needs no finer one.
fn finest_level(lobe: &Lobe) -> u32 {
    (0..octahedron::MAX_LEVEL)
        .find(|&level| octahedron::radius(level) < 0.4 * lobe.half_width)
        .unwrap_or(octahedron::MAX_LEVEL) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directional::{Source, packed};
    use crate::geometry::hash::unit;
    use crate::scene::{Gloss, Material};

    fn config(epsilon: f32, floor: f32) -> ReflectConfig {
        ReflectConfig {
            epsilon,
            refiner: Refiner::Relative,
            basis: Basis::Haar,
            max_level: 7,
            floor,
            least: 0.0,
            typical: 1.0,
            conserve: false,
        }
    }

    fn surface(lobe: &Lobe, diffuse: Rgb) -> Surface<'_> {
        Surface {
            normal: Vec3::Z,
            diffuse,
            lobe: Some(lobe),
            compensating: Rgb::BLACK,
            bend: 0.0,
            dark: None,
        }
    }

    /// Uniform over the hemisphere, above the grazing band.
    fn hemisphere(i: u32) -> Vec3 {
        let z = 0.05 + 0.95 * unit(i, 1);
        let (s, phi) = ((1.0 - z * z).sqrt(), unit(i, 2) * std::f32::consts::TAU);
        Vec3::new(s * phi.cos(), s * phi.sin(), z)
    }

    #[test]
    fn a_sharp_lobe_is_found_wherever_it_points() {
        let gloss = Gloss::Phong {
            specular: Rgb::WHITE,
            exponent: 1000.0,
        };
        let material = Material {
            gloss,
            ..Material::lambert("m", Rgb::BLACK)
        };
        let lobe = Lobe::of(&material, 0.0).expect("glossy");
        let config = config(0.1, 0.2);
        let mut projector = Projector::default();
        for i in 0..1000 {
            let direction = hemisphere(i);
            let sample = IlluminationSample {
                direction,
                irradiance: Rgb::WHITE / direction.z,
                spread: 0.0,
                parallax: None,
            };
            let out = reflect(
                &[sample],
                &surface(&lobe, Rgb::BLACK),
                &config,
                &mut projector,
            );
            let words = out.distribution.expect("a distribution");
            let mirror = crate::brdf::reflect(Vec3::Z, direction);
            let (found, peak) = (
                packed::evaluate(&words, mirror).g,
                1002.0 / std::f32::consts::TAU,
            );
            // The finest cells have a radius of 0.4 half-widths: their corners hold 0.9 of the peak; hanging ones less.
            assert!(
                found > 0.8 * peak && found < 1.1 * peak,
                "{i}: {found} of {peak} towards {mirror}"
            );
        }
    }

    #[test]
    fn a_round_lamp_is_found_in_the_weak_lobe_of_a_bright_surface() {
        // A polished table: a hundredth of the light of each facet is mirrored, and no facet alone would be seen.
        let material = Material {
            gloss: Gloss::Ward {
                specular: Rgb::splat(0.01),
                roughness: 0.03,
            },
            ..Material::lambert("m", Rgb::BLACK)
        };
        let lobe = Lobe::of(&material, 0.0).expect("glossy");
        let config = config(0.12, 0.4);
        let mut projector = Projector::default();
        for (i, to_lamp) in (0..500).map(|i| (i, hemisphere(i))) {
            // Lobes are narrow in one direction at grazing angles.
            if to_lamp.z < 0.6 {
                continue;
            }
            // Facets of 1°, over a disc of 2.5°.
            let facet = |k: u32| {
                let offset = |salt: u32| 0.08 * (unit(20 * i + k, salt) - 0.5);
                let direction = (to_lamp + Vec3::new(offset(3), offset(4), offset(5))).normalize();
                IlluminationSample {
                    direction,
                    irradiance: Rgb::WHITE / direction.z,
                    spread: 1.0f32.to_radians(),
                    parallax: None,
                }
            };
            let room = IlluminationSample {
                direction: Vec3::Z,
                irradiance: Rgb::splat(400.0),
                spread: 0.9,
                parallax: None,
            };
            let samples: Vec<_> = (0..20).map(facet).chain([room]).collect();
            let out = reflect(
                &samples,
                &surface(&lobe, Rgb::splat(0.6)),
                &config,
                &mut projector,
            );
            let words = out.distribution.expect("a distribution");
            let few = merged(&samples, Vec3::Z, lobe.half_width);
            let mut exact = Lobes::new(&lobe, Vec3::Z, &few, None, 0.0, Rgb::BLACK);
            let all: Vec<u32> = (0..exact.candidate_count()).collect();
            let view = crate::brdf::reflect(Vec3::Z, to_lamp);
            let wanted = exact.eval(&all, view).g;
            let found = packed::evaluate(&words, view).g;
            // The refiner looks at the deviation of one point, and the smallest cells hold what is left.
            let most = 1.5 * config.epsilon * (wanted + config.floor * out.diffuse.g);
            assert!(
                (found - wanted).abs() < most,
                "{i}: {found} of {wanted}, beside {} diffuse, towards {view}",
                out.diffuse.g
            );
        }
    }
}
