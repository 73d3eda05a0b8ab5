//! Directions chosen in proportion to a lobe, and their densities: what a path tracer follows.

use super::{Lobe, Shape, mirror_cosine, phong, reflect, ward};
use crate::geometry::sampling::about;
use glam::{Vec2, Vec3};

impl Lobe {
    /// A direction for light that leaves towards `wo`, from a point of the unit square. It may lie below the surface:
    /// nothing comes from there.
    pub fn sample(&self, normal: Vec3, wo: Vec3, at: Vec2) -> Vec3 {
        match self.shape {
            Shape::Phong(exponent) => about(
                reflect(normal, wo),
                phong::sample_angle(exponent, at.x),
                at.y,
            ),
            Shape::Ward(roughness) => {
                let half = about(normal, ward::sample_angle(roughness, at.x), at.y);
                reflect(half, wo)
            }
        }
    }

    /// Density with which [`Self::sample`] gives `wi` [sr⁻¹].
    pub fn density(&self, normal: Vec3, wo: Vec3, wi: Vec3) -> f32 {
        match self.shape {
            Shape::Phong(exponent) => phong::density(exponent, mirror_cosine(normal, wi, wo)),
            // A half vector below the surface is never chosen.
            Shape::Ward(roughness) => {
                ward::Half::of(normal, wi, wo).map_or(0.0, |half| ward::density(roughness, &half))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::sampling::spread;
    use crate::radiometry::Rgb;
    use crate::scene::{Gloss, Material};

    fn lobes() -> Vec<Lobe> {
        let gloss = |gloss| Material {
            gloss,
            ..Material::lambert("m", Rgb::BLACK)
        };
        let phong = [0.0, 1.0, 30.0, 1000.0, 1e6].map(|exponent| {
            gloss(Gloss::Phong {
                specular: Rgb::WHITE,
                exponent,
            })
        });
        let ward = [1e-5, 1e-3, 0.03, 0.2, 0.5].map(|roughness| {
            gloss(Gloss::Ward {
                specular: Rgb::WHITE,
                roughness,
            })
        });
        let all = phong.iter().chain(&ward);
        all.map(|m| Lobe::of(m, 0.0).expect("glossy")).collect()
    }

    #[test]
    fn samples_weighted_by_their_density_give_the_albedo() {
        let normal = Vec3::new(0.36, -0.48, 0.8);
        for lobe in lobes() {
            for cosine in [1.0f32, 0.7, 0.3] {
                let wo = about(normal, ((1.0 - cosine * cosine).sqrt(), cosine), 0.3);
                const COUNT: u32 = 65_536;
                let weight = |i: u32| {
                    let wi = lobe.sample(normal, wo, spread(i));
                    let value = lobe.eval(normal, wi, wo) * normal.dot(wi);
                    if value > 0.0 {
                        f64::from(value / lobe.density(normal, wo, wi))
                    } else {
                        0.0
                    }
                };
                let found = (0..COUNT).map(weight).sum::<f64>() / f64::from(COUNT);
                let expected = f64::from(lobe.albedo(cosine));
                assert!(
                    (found - expected).abs() < 4e-3,
                    "{lobe:?} {cosine}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn densities_are_those_of_the_samples() {
        // Moments of the directions, sampled and by quadrature of the density.
        let (normal, wo) = (Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
        for lobe in lobes().into_iter().filter(|lobe| lobe.half_width > 0.1) {
            const COUNT: u32 = 65_536;
            let mean = (0..COUNT)
                .map(|i| lobe.sample(normal, wo, spread(i)).as_dvec3())
                .sum::<glam::DVec3>()
                / f64::from(COUNT);
            let (mut whole, mut moment) = (0.0, glam::DVec3::ZERO);
            let (rings, spokes) = (1024, 2048);
            let cell = 2.0 / f64::from(rings) * std::f64::consts::TAU / f64::from(spokes);
            for ring in 0..rings {
                let z = (ring as f32 + 0.5) / rings as f32 * 2.0 - 1.0;
                for spoke in 0..spokes {
                    let turn = (spoke as f32 + 0.5) / spokes as f32;
                    let wi = about(Vec3::Z, ((1.0 - z * z).sqrt(), z), turn);
                    let density = f64::from(lobe.density(normal, wo, wi)) * cell;
                    whole += density;
                    moment += wi.as_dvec3() * density;
                }
            }
            assert!((whole - 1.0).abs() < 2e-3, "{lobe:?}: {whole}");
            assert!((moment - mean).length() < 2e-3, "{lobe:?}: {moment} {mean}");
        }
    }
}
