//! Values at the corners of a refined octahedron: continuous over hanging corners, with the means and the power of the
//! function that they stand for.

use super::haar::{Projection, Projector};
use super::octahedron;
use super::tree::Tree;
use crate::radiometry::Rgb;
use glam::Vec3;

impl Projector {
    /// Turns samples at corners into the values to store; returns the factor that they still need.
    pub(super) fn fit(&mut self, how: &Projection) -> f32 {
        let hanging = self.hanging_vertices();
        self.constrain(&hanging);
        self.keep_means(&hanging);
        self.constrain(&hanging);
        how.integral
            .map_or(1.0, |target| self.correction(target, how.horizon))
    }

    /// Vertices that hang in a larger neighbour's edge, with its ends; larger cells first.
    fn hanging_vertices(&self) -> Vec<[u32; 3]> {
        let mut hanging = Vec::new();
        let deepest = self.tree.cells.iter().map(|c| c.level).max().unwrap_or(0);
        for level in 0..deepest {
            for (_, cell) in self.tree.leaves().filter(|(_, cell)| cell.level == level) {
                for (a, b) in Tree::edges(cell) {
                    hanging.extend(self.tree.midpoint_of(a, b).map(|m| [m, a, b]));
                }
            }
        }
        hanging
    }

    /// Gives hanging vertices the mean of the ends of their edge.
    fn constrain(&mut self, hanging: &[[u32; 3]]) {
        for &[middle, a, b] in hanging {
            self.tree.values[middle as usize] =
                (self.tree.values[a as usize] + self.tree.values[b as usize]) * 0.5;
        }
    }

    /// Scales the corners' values towards leaves that have the means of the function: a linear function through samples
    /// cuts peaks off, which the refiner allows by ε, and power with them. Three corners and nine times the centre,
    /// over twelve, are the mean of any quadratic function. A corner is scaled by the mean of what the leaves around it
    /// need: nothing becomes negative, and the sum of the means is right after one step (that of Richardson 1972 and
    /// Lucy 1974).
    fn keep_means(&mut self, hanging: &[[u32; 3]]) {
        let mut factors = vec![(Rgb::BLACK, 0.0f32); self.tree.values.len()];
        for (index, cell) in self.tree.leaves() {
            // Cells of a level are alike in size.
            let area = 0.25f32.powi(i32::from(cell.level));
            let [a, b, c] = cell.vertices.map(|v| self.tree.values[v as usize]);
            let linear = (a + b + c) / 3.0;
            let needed = self.centres[index].map_or(Rgb::WHITE, |centre| {
                let ratio = |centre: f32, linear: f32| {
                    if linear > 0.0 {
                        0.25 + 0.75 * centre / linear
                    } else {
                        1.0
                    }
                };
                Rgb::new(
                    ratio(centre.r, linear.r),
                    ratio(centre.g, linear.g),
                    ratio(centre.b, linear.b),
                )
            });
            for vertex in cell.vertices {
                let (sum, weight) = &mut factors[vertex as usize];
                *sum += needed * area;
                *weight += area;
            }
        }
        for &[middle, a, b] in hanging.iter().rev() {
            let (sum, weight) = std::mem::take(&mut factors[middle as usize]);
            for end in [a, b] {
                factors[end as usize].0 += sum * 0.5;
                factors[end as usize].1 += weight * 0.5;
            }
        }
        for (value, (sum, weight)) in self.tree.values.iter_mut().zip(factors) {
            if weight > 0.0 {
                *value = *value * (sum / weight);
            }
        }
    }

    /// The factor that gives the projection the integral `target`; a projection that is off by more than a factor
    /// of two has missed something that no factor mends.
    fn correction(&self, target: f32, horizon: Option<Vec3>) -> f32 {
        let mut sum = 0.0f64;
        for (_, cell) in self.tree.leaves() {
            let values = cell.vertices.map(|v| self.tree.values[v as usize].mean());
            let of_cell = octahedron::integral(
                self.tree.corners(cell),
                values,
                horizon,
                usize::from(cell.level),
            );
            sum += f64::from(of_cell);
        }
        if sum > 0.0 {
            ((f64::from(target) / sum) as f32).clamp(0.5, 2.0)
        } else {
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::haar::tests::{HOW, Plain};
    use super::*;
    use crate::directional::packed;

    #[test]
    fn a_projection_carries_the_power_it_is_given() {
        carries_its_power(Vec3::new(0.4, -0.3, 0.8), Vec3::new(0.9, 0.2, 0.5));
        // The horizon runs along the middles of cells; a grazing lobe.
        carries_its_power(Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 2.0));
        carries_its_power(Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 0.3, 0.2));
    }

    #[test]
    fn coarse_leaves_keep_the_power_of_peaks() {
        for exponent in [4, 8, 16] {
            let (mut found, mut wanted) = (0.0, 0.0);
            for i in 0..40 {
                let lobe = around(Vec3::Z, i as f32 / 40.0, 0.3 * i as f32 / 40.0);
                let f = |d: Vec3| d.dot(lobe).max(0.0).powi(exponent);
                let how = Projection {
                    epsilon: 2.0,
                    ..HOW
                };
                let mut words = Vec::new();
                Projector::default().project(&mut Plain(f), &how, &mut words);
                found += power(Vec3::Z, &|d| packed::evaluate(&words, d).g);
                wanted += power(Vec3::Z, &f);
            }
            let error: f64 = found / wanted - 1.0;
            // 2 % without.
            assert!(error.abs() < 0.01, "{exponent}: {error}");
        }
    }

    /// A direction about `normal`; `squared` is the square of its sine.
    fn around(normal: Vec3, turns: f32, squared: f32) -> Vec3 {
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let (sine, cosine) = (turns * std::f32::consts::TAU).sin_cos();
        (tangent * cosine + bitangent * sine) * squared.sqrt() + normal * (1.0 - squared).sqrt()
    }

    /// Cosine-weighted integral over the hemisphere.
    fn power(normal: Vec3, radiance: &dyn Fn(Vec3) -> f32) -> f64 {
        let count = 100_000u32;
        let sample = |i: u32| {
            let squared = (i as f32 + 0.5) / count as f32;
            let turns = (f64::from(i) * 0.618_033_988_75).fract() as f32;
            f64::from(radiance(around(normal, turns, squared)))
        };
        let sum: f64 = (0..count).map(sample).sum();
        sum / f64::from(count) * std::f64::consts::PI
    }

    fn carries_its_power(normal: Vec3, lobe: Vec3) {
        let (normal, lobe) = (normal.normalize(), lobe.normalize());
        // Coarse cells, where a sum over corners is several per cent off; cells cross the horizon.
        for (min_level, epsilon, exponent) in [(1, 2.0, 4), (1, 0.5, 30), (2, 0.2, 30)] {
            let f = |d: Vec3| d.dot(lobe).max(0.0).powi(exponent);
            let wanted = power(normal, &f);
            let how = Projection {
                min_level,
                epsilon,
                horizon: Some(normal),
                integral: Some(wanted as f32),
                ..HOW
            };
            let mut words = Vec::new();
            Projector::default().project(&mut Plain(f), &how, &mut words);
            let error = power(normal, &|d| packed::evaluate(&words, d).g) / wanted - 1.0;
            assert!(
                error.abs() < 5e-3,
                "{normal} {min_level} {epsilon}: {error}"
            );
        }
    }
}
