//! Reflection models. A material is Lambert plus at most one lobe; each lobe evaluates without its colour.

mod fast;
mod phong;
mod sampling;
mod ward;

use crate::radiometry::Rgb;
use crate::scene::{Gloss, Material};
use glam::Vec3;

/// Share of its peak below which a lobe counts as nothing when samples are culled.
const CUTOFF: f32 = 1e-4;

/// Shape of a glossy lobe, colour aside.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// Exponent.
    Phong(f32),
    /// Roughness, above zero.
    Ward(f32),
}

/// A glossy lobe of a material as the solver uses it.
#[derive(Clone, Debug)]
pub struct Lobe {
    /// Colour: Ks or ρs.
    pub specular: Rgb,
    shape: Shape,
    /// Angle from the mirror direction at which the lobe has half its peak [rad].
    pub half_width: f32,
    /// Directional albedo for specular = 1 at cos θ = i / (n - 1).
    albedo: [f32; ALBEDO_ENTRIES],
}

const ALBEDO_ENTRIES: usize = 33;

/// True where a solve has to widen the lobe of `material` to `sharpest` (Ward roughness).
pub fn is_widened(material: &Material, sharpest: f32) -> bool {
    material.is_glossy()
        && match material.gloss {
            Gloss::None => false,
            Gloss::Phong { exponent, .. } => exponent > phong::exponent_of_width(sharpest),
            Gloss::Ward { roughness, .. } => roughness < sharpest,
        }
}

impl Lobe {
    /// The lobe of `material`, if it is glossy. Lobes sharper than `sharpest` (Ward roughness) are widened to it.
    pub fn of(material: &Material, sharpest: f32) -> Option<Self> {
        if !material.is_glossy() {
            return None;
        }
        let (specular, shape) = match material.gloss {
            Gloss::None => return None,
            Gloss::Phong { specular, exponent } => (
                specular,
                Shape::Phong(exponent.min(phong::exponent_of_width(sharpest))),
            ),
            Gloss::Ward {
                specular,
                roughness,
            } => (specular, Shape::Ward(roughness.max(sharpest))),
        };
        let half = match shape {
            Shape::Phong(exponent) => phong::cosine_of(exponent, 0.5),
            Shape::Ward(roughness) => ward::cosine_of(roughness, 0.5),
        };
        let mut albedo = [0.0; ALBEDO_ENTRIES];
        for (i, entry) in albedo.iter_mut().enumerate() {
            let cosine = i as f32 / (ALBEDO_ENTRIES - 1) as f32;
            *entry = match shape {
                Shape::Phong(exponent) => phong::albedo(exponent, cosine),
                Shape::Ward(roughness) => ward::albedo(roughness, cosine),
            };
        }
        Some(Self {
            specular,
            shape,
            half_width: half.acos(),
            albedo,
        })
    }

    /// BRDF for specular = 1 [sr⁻¹]. Directions unit, leaving the surface; zero when either is below it.
    pub fn eval(&self, normal: Vec3, wi: Vec3, wo: Vec3) -> f32 {
        let (cos_i, cos_o) = (normal.dot(wi), normal.dot(wo));
        if cos_i <= 0.0 || cos_o <= 0.0 {
            return 0.0;
        }
        match self.shape {
            Shape::Phong(exponent) => phong::eval(exponent, mirror_cosine(normal, wi, wo)),
            Shape::Ward(roughness) => {
                ward::Half::of(normal, wi, wo).map_or(0.0, |half| ward::eval(roughness, &half))
            }
        }
    }

    /// The largest albedo, and its mean over a hemisphere that is lit evenly.
    pub(crate) fn albedo_range(&self) -> (f32, f32) {
        let largest = self.albedo.iter().copied().fold(0.0, f32::max);
        // ∫ 2 c a(c) dc with a linear between entries: Simpson's rule is exact.
        let step = 1.0 / (ALBEDO_ENTRIES - 1) as f32;
        let pairs = self.albedo.windows(2).enumerate();
        let mean = pairs.map(|(i, pair)| {
            let (from, to) = (i as f32 * step, (i + 1) as f32 * step);
            let middle = 0.25 * (from + to) * (pair[0] + pair[1]);
            (from * pair[0] + 4.0 * middle + to * pair[1]) * step / 3.0
        });
        (largest, mean.sum())
    }

    /// Share of the light from an angle with cosine `cos_i` that a lobe with specular = 1 reflects.
    pub fn albedo(&self, cos_i: f32) -> f32 {
        let x = cos_i.clamp(0.0, 1.0) * (ALBEDO_ENTRIES - 1) as f32;
        let i = (x as usize).min(ALBEDO_ENTRIES - 2);
        let t = x - i as f32;
        self.albedo[i] * (1.0 - t) + self.albedo[i + 1] * t
    }
}

/// Mirror direction of `wi` about `normal`; both leave the surface.
pub fn reflect(normal: Vec3, wi: Vec3) -> Vec3 {
    normal * (2.0 * normal.dot(wi)) - wi
}

/// Cosine of the angle between `wo` and the mirror direction of `wi`, from their distance: a dot product would know it,
/// near 1, no better than it knows the lengths of both, and the sharpest lobes are as narrow as that.
fn mirror_cosine(normal: Vec3, wi: Vec3, wo: Vec3) -> f32 {
    1.0 - 0.5 * reflect(normal, wo).distance_squared(wi)
}

/// A number of incoming directions against one outgoing direction; structure of arrays.
pub(crate) struct Cosines<'a> {
    /// Mirror direction · wo.
    pub(crate) mirror: &'a [f32],
    /// n · wi.
    pub(crate) incoming: &'a [f32],
    /// [`Spread::sharpness`] of each.
    pub(crate) sharpness: &'a [f32],
    /// n · wo.
    pub(crate) outgoing: f32,
}

/// A lobe as widened by the size of what it reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spread {
    /// Phong: the exponent. Ward: log₂e/α².
    pub(crate) sharpness: f32,
    /// Factor that belongs to it: the lobe's value is this times [`Shape::eval_many`].
    pub(crate) factor: f32,
    /// Cosine of the half-width.
    pub(crate) half: f32,
    /// Cosine of the angle from the mirror direction beyond which it is nothing.
    pub(crate) cutoff: f32,
}

impl Lobe {
    /// The lobe convolved with a uniform disc of angular radius `spread` [rad]: both taken for Gaussians in the
    /// mirror angle, with variances 1/n (Phong) or 2α² (Ward) and spread²/4 per axis.
    pub(crate) fn spread(&self, spread: f32) -> Spread {
        let (sharpness, factor, half, cutoff) = match self.shape {
            Shape::Phong(exponent) => {
                let n = exponent / (1.0 + exponent * spread * spread * 0.25);
                let factor = (n + 2.0) / std::f32::consts::TAU;
                (
                    n,
                    factor,
                    phong::cosine_of(n, 0.5),
                    phong::cosine_of(n, CUTOFF),
                )
            }
            Shape::Ward(roughness) => {
                let a = (roughness * roughness + spread * spread * 0.125).min(1.0);
                let alpha = a.sqrt();
                let factor = 1.0 / (std::f32::consts::PI * a);
                let sharpness = std::f32::consts::LOG2_E / a;
                (
                    sharpness,
                    factor,
                    ward::cosine_of(alpha, 0.5),
                    ward::cosine_of(alpha, CUTOFF),
                )
            }
        };
        Spread {
            sharpness,
            factor,
            half,
            cutoff,
        }
    }

    /// Values of the lobe, without [`Spread::factor`], for all of `cosines`.
    pub(crate) fn eval_many(&self, cosines: &Cosines<'_>, values: &mut [f32]) {
        match self.shape {
            Shape::Phong(_) => {
                let incoming = cosines.mirror.iter().zip(cosines.sharpness);
                for (value, (&mirror, &exponent)) in values.iter_mut().zip(incoming) {
                    *value = phong::power(exponent, mirror);
                }
            }
            Shape::Ward(_) => {
                let incoming = cosines
                    .incoming
                    .iter()
                    .zip(cosines.mirror)
                    .zip(cosines.sharpness);
                for (value, ((&cos_i, &mirror), &sharpness)) in values.iter_mut().zip(incoming) {
                    // wi is the mirror image of its mirror direction.
                    let between = 2.0 * cos_i * cosines.outgoing - mirror;
                    *value = ward::bell(sharpness, cos_i, cosines.outgoing, between);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobe(gloss: Gloss) -> Lobe {
        let material = Material {
            gloss,
            ..Material::lambert("m", Rgb::BLACK)
        };
        Lobe::of(&material, 0.0).expect("glossy")
    }

    fn quadrature(lobe: &Lobe, cosine: f32) -> f64 {
        let wi = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let (rings, spokes) = (600, 1200);
        let mut sum = 0.0f64;
        for ring in 0..rings {
            let theta = (ring as f32 + 0.5) / rings as f32 * std::f32::consts::FRAC_PI_2;
            for spoke in 0..spokes {
                let phi = (spoke as f32 + 0.5) / spokes as f32 * std::f32::consts::TAU;
                let wo = Vec3::new(
                    theta.sin() * phi.cos(),
                    theta.sin() * phi.sin(),
                    theta.cos(),
                );
                sum += f64::from(lobe.eval(Vec3::Z, wi, wo) * wo.z * theta.sin());
            }
        }
        sum * std::f64::consts::FRAC_PI_2 / f64::from(rings) * std::f64::consts::TAU
            / f64::from(spokes)
    }

    #[test]
    fn phong_albedo_has_the_published_values() {
        // `exact_cases.md` 2e: a at 0°, 30°, 60°.
        for (n, expected) in [
            (1.0, [1.0, 0.8808, 0.6090]),
            (10.0, [1.0, 0.8660, 0.5047]),
            (50.0, [1.0, 0.8660, 0.5]),
        ] {
            let lobe = lobe(Gloss::Phong {
                specular: Rgb::WHITE,
                exponent: n,
            });
            for (degrees, a) in [0.0f32, 30.0, 60.0].into_iter().zip(expected) {
                let found = lobe.albedo(degrees.to_radians().cos());
                assert!(
                    (found - a).abs() < 2e-3,
                    "n {n}, {degrees}°: {found} against {a}"
                );
            }
        }
    }

    #[test]
    fn ward_albedo_is_the_integral_of_eval_and_within_one() {
        for roughness in [0.05, 0.2] {
            let lobe = lobe(Gloss::Ward {
                specular: Rgb::WHITE,
                roughness,
            });
            for cosine in [1.0, 0.75, 0.5, 0.25] {
                let (table, integral) = (f64::from(lobe.albedo(cosine)), quadrature(&lobe, cosine));
                assert!(
                    (table - integral).abs() < 5e-3 && table <= 1.0,
                    "{roughness} {cosine}: {table} {integral}"
                );
            }
        }
    }

    #[test]
    fn lobes_are_reciprocal() {
        let lobe = lobe(Gloss::Ward {
            specular: Rgb::WHITE,
            roughness: 0.15,
        });
        let (a, b) = (
            Vec3::new(0.3, 0.2, 0.9).normalize(),
            Vec3::new(-0.4, 0.1, 0.8).normalize(),
        );
        let (there, back) = (lobe.eval(Vec3::Z, a, b), lobe.eval(Vec3::Z, b, a));
        assert!(
            (there - back).abs() <= 1e-5 * there && there > 0.0,
            "{there} {back}"
        );
    }
}
