//! Every knob of a solve: default, range, price. One number, the quality, sets them all.

pub use crate::directional::Basis;
use crate::error::SolveError;
use std::str::FromStr;

/// How good a solution should be. 0 draft, 1 preview, 2 default, 3 high; fractions lie between.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Quality(f32);

impl Quality {
    /// A first look: seconds.
    pub const DRAFT: Self = Self(0.0);
    /// Good enough to place lamps.
    pub const PREVIEW: Self = Self(1.0);
    /// The default.
    pub const DEFAULT: Self = Self(2.0);
    /// For pictures to keep.
    pub const HIGH: Self = Self(3.0);

    /// A quality from its number. Errors: outside 0..=4.
    pub fn new(value: f32) -> Result<Self, SolveError> {
        if (0.0..=4.0).contains(&value) {
            Ok(Self(value))
        } else {
            Err(SolveError::Setting {
                setting: "quality",
                value: f64::from(value),
                expected: "within 0..4",
            })
        }
    }

    /// The number.
    pub fn value(self) -> f32 {
        self.0
    }
}

impl Default for Quality {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl FromStr for Quality {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "draft" => Ok(Self::DRAFT),
            "preview" => Ok(Self::PREVIEW),
            "default" => Ok(Self::DEFAULT),
            "high" => Ok(Self::HIGH),
            _ => text
                .parse::<f32>()
                .ok()
                .and_then(|value| Self::new(value).ok())
                .ok_or_else(|| {
                    format!(
                        "'{text}' is none of draft, preview, default, high, or a number within 0..4"
                    )
                }),
        }
    }
}

/// What becomes of light that arrives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// It is kept as samples, whose sum is reflected (§3.2, §3.3).
    #[default]
    IlluminationSamples,
    /// It is kept as samples, which are reflected one by one: "summing reflections" of table 1.
    SummedReflections,
    /// It is pushed to the leaves at once and reflected there, link by link (§2.2).
    RadianceClustering,
}

impl FromStr for Method {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "is" => Ok(Self::IlluminationSamples),
            "sr" => Ok(Self::SummedReflections),
            "rc" => Ok(Self::RadianceClustering),
            _ => Err(format!(
                "'{text}' is none of is (illumination samples), sr (summed reflections), rc (radiance clustering)"
            )),
        }
    }
}

/// Which light an iteration moves (§3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheme {
    /// What the iteration before has found.
    #[default]
    Shooting,
    /// All that is known.
    Gathering,
}

impl FromStr for Scheme {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "shooting" => Ok(Self::Shooting),
            "gathering" => Ok(Self::Gathering),
            _ => Err(format!("'{text}' is neither shooting nor gathering")),
        }
    }
}

/// What the deviation within a cell of a distribution is held against (§5.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Refiner {
    /// The radiance there.
    #[default]
    Relative,
    /// The typical radiance of the scene.
    Absolute,
}

impl FromStr for Refiner {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "relative" => Ok(Self::Relative),
            "absolute" => Ok(Self::Absolute),
            _ => Err(format!("'{text}' is neither relative nor absolute")),
        }
    }
}

/// Rays along each axis of the stratification of a link's visibility; their square is cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strata {
    /// As many on every link.
    Even(u32),
    /// As many on a link that carries as much light as links may be wrong by, squares in proportion to light on others.
    /// The variance of a link is as the square of its light over its rays: of all ways to share out rays this has the
    /// least sum of variances.
    Graded(u32),
}

impl Strata {
    /// Least and most along an axis when graded: a single ray of a weak link may decide what a glossy surface shows in
    /// some direction, and means of more rays than these are not corrected.
    const GRADES: (u32, u32) = (2, 6);

    /// Of a link that carries `light` times what links may be wrong by.
    pub fn along(self, light: f32) -> u32 {
        match self {
            Self::Even(side) => side,
            Self::Graded(side) => {
                ((side as f32 * light.sqrt()).ceil() as u32).clamp(Self::GRADES.0, Self::GRADES.1)
            }
        }
    }
}

/// How links find what stands between their ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Visibility {
    /// Shafts tell what may stand in between; where that is little it is cut out exactly, elsewhere rays decide.
    #[default]
    Shafts,
    /// Stratified rays alone.
    Rays,
}

impl FromStr for Visibility {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "shafts" => Ok(Self::Shafts),
            "rays" => Ok(Self::Rays),
            _ => Err(format!("'{text}' is neither shafts nor rays")),
        }
    }
}

impl FromStr for Basis {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "haar" => Ok(Self::Haar),
            "uniform" => Ok(Self::Uniform),
            _ => Err(format!("'{text}' is neither haar nor uniform")),
        }
    }
}

/// Everything that follows from the quality. Each knob may be overridden in [`crate::SolveConfig`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What becomes of light that arrives.
    pub method: Method,
    /// Which light an iteration moves.
    pub scheme: Scheme,
    /// When directions are refined.
    pub refiner: Refiner,
    /// What distributions are stored on.
    pub basis: Basis,
    /// How links find what stands between their ends.
    pub visibility: Visibility,
    /// Tolerance of a link as a share of the emitted power (§3.1). Smaller: more links, about as its inverse.
    pub link_tolerance: f32,
    /// Largest error of the irradiance of a link as a share of what the emitted power would be, spread evenly: small
    /// elements carry no power, but they are seen.
    pub link_irradiance: f32,
    /// Elements with a smaller radius are not split by links; scene size 1.
    pub min_radius: f32,
    /// Visibility rays of a link.
    pub strata: Strata,
    /// ε of the directional refiner (§4.2). Smaller: more cells.
    pub epsilon: f32,
    /// The same in transport, where light is averaged over receivers.
    pub transport_epsilon: f32,
    /// The same of clusters, which send to what is far away.
    pub cluster_epsilon: f32,
    /// Radiance that carries no direction in transport, as a share of the mean of the scene.
    pub least_directional: f32,
    /// Deepest level of the basis in transport.
    pub transport_level: u32,
    /// Deepest level of the basis at vertices.
    pub display_level: u32,
    /// Ward roughness that mirrors are widened to.
    pub sharpest_roughness: f32,
    /// Iterations stop when less than this share of the emitted power is unshot.
    pub unshot_share: f32,
    /// Gather at vertices; otherwise surrounding elements are averaged (§5.2).
    pub gather: bool,
    /// Insides of nearly closed things show the light of their elements where it is below this share of the typical
    /// irradiance.
    pub dark_share: f32,
    /// Error of a link to a vertex as a share of the irradiance there.
    pub vertex_tolerance: f32,
    /// Stratification of a strong link to a vertex.
    pub vertex_strata: u32,
    /// Leaves are split while the radiance at their centre is mispredicted by more than this share.
    pub mesh_tolerance: f32,
    /// Leaves of the displayed mesh are not larger; scene size 1.
    pub max_edge: f32,
    /// And not split below this.
    pub min_edge: f32,
}

impl Settings {
    /// The settings of a quality: geometric between the named ones.
    pub fn of(quality: Quality) -> Self {
        let q = quality.value();
        // Values at quality 0 and 3, interpolated in the logarithm.
        let knob = |draft: f32, high: f32| draft * (high / draft).powf(q / 3.0);
        // From default to high errors halve, as a picture shows them, when these fall by more than the rest.
        let beyond_default = |factor: f32| factor.powf((q - 2.0).max(0.0));
        let step = |values: [u32; 4]| values[(q.round() as usize).min(3)];
        Self {
            method: Method::default(),
            scheme: Scheme::default(),
            refiner: Refiner::default(),
            basis: Basis::default(),
            visibility: Visibility::default(),
            link_tolerance: knob(4e-4, 1.5e-5) * beyond_default(0.72),
            link_irradiance: knob(1.0, 0.2),
            min_radius: knob(1.0 / 24.0, 1.0 / 192.0),
            strata: Strata::Graded(step([3, 3, 3, 4])),
            epsilon: knob(0.7, 0.05),
            transport_epsilon: knob(1.5, 0.1),
            cluster_epsilon: knob(1.5, 0.2),
            least_directional: knob(0.15, 0.01),
            transport_level: step([4, 4, 5, 6]),
            display_level: step([4, 5, 5, 6]),
            sharpest_roughness: knob(0.06, 0.02),
            unshot_share: knob(2e-2, 5e-4),
            gather: q > 0.0,
            dark_share: knob(0.4, 0.1),
            vertex_tolerance: knob(0.16, 0.013) * beyond_default(0.66),
            vertex_strata: step([2, 2, 3, 4]),
            mesh_tolerance: knob(0.25, 0.04),
            max_edge: knob(1.0 / 6.0, 1.0 / 32.0),
            min_edge: knob(1.0 / 32.0, 1.0 / 256.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hash::unit;

    #[test]
    fn graded_rays_are_worth_more_than_even_ones() {
        // Light of links as solves find it: most far below what they may be wrong by.
        let lights: Vec<f32> = (0..10_000)
            .map(|i| (-6.0 + 6.5 * unit(i, 1)).exp2())
            .collect();
        // Rays times variance: half as much is as good with half as many rays.
        let cost = |strata: Strata| {
            let (mut rays, mut variance) = (0.0, 0.0);
            for &light in &lights {
                let count = f64::from(strata.along(light).pow(2));
                rays += count;
                variance += f64::from(light * light) / count;
            }
            rays * variance
        };
        let (graded, even) = (cost(Strata::Graded(3)), cost(Strata::Even(2)));
        assert!(graded < 0.6 * even, "{graded} {even}");
        assert!((cost(Strata::Even(3)) / even - 1.0).abs() < 1e-9);
    }

    #[test]
    fn rays_of_a_link_are_few_and_not_none() {
        for light in [0.0, 1e-30, 1.0, 1e30, f32::INFINITY] {
            assert!((2..=6).contains(&Strata::Graded(3).along(light)));
            assert_eq!(Strata::Even(16).along(light), 16);
        }
        assert_eq!(Strata::Graded(3).along(1.0), 3);
    }
}
