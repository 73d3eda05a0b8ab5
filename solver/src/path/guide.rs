//! Where indirect light comes from, learned from photons: camera paths look there.
//!
//! Paths stay unbiased whatever is learned, since its density is known and mixed with that of the surface. Jensen 1995,
//! "Importance driven path tracing using the photon map", with directions as in Müller et al. 2017.
//! Cost: one short walk down a tree per lookup; learning takes photons until enough have met surfaces, about half a
//! second.

use super::choice::Choice;
use super::directions::{Directions, to_square};
use super::reflectors::Reflectors;
use super::scatter::Scatterer;
use super::surface::Surface;
use super::{PathTracer, Sampler};
use crate::geometry::sampling::cosine_direction;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// Photons that learning follows at a time.
const PHOTONS: u32 = 1 << 18;
/// Learning is over when photons met this many surfaces,
const ENOUGH: usize = 1 << 20;
/// or after this many rounds: where most light is lost.
const MOST_ROUNDS: u32 = 16;
/// Of the random numbers that photons take.
const SEED: u32 = 0x5eed_0f1e;
/// Bounces of a photon, at most.
const MOST_BOUNCES: u32 = 32;
/// Places with more photons than this are split.
const MOST_IN_PLACE: usize = 1024;
/// Points of a place that tell which lights matter there.
const LIT_POINTS: usize = 8;
/// Paths from each of them that tell how much light there is.
const PATHS: u32 = 8;
/// Places with fewer teach nothing.
const LEAST_IN_PLACE: usize = 64;

/// A photon that met a surface after it had been scattered.
#[derive(Clone, Copy)]
struct Met {
    point: Vec3,
    triangle: u32,
    /// The material that scattered it last.
    sender: u32,
    /// Towards where it came from, as a point of the square.
    from: Vec2,
    /// The surface's, on this side.
    normal: Vec3,
}

/// Irradiance [mean over channels; normalised].
#[derive(Clone, Copy, Default)]
pub(super) struct Light {
    /// All of it.
    pub(super) whole: f32,
    /// What comes from surfaces that reflect.
    pub(super) indirect: f32,
}

/// What is known about light at a place.
pub(super) struct Place {
    /// Where indirect light comes from.
    pub(super) directions: Directions,
    /// Which lights matter.
    pub(super) lights: Choice,
    /// How much light there is, about.
    pub(super) light: Light,
}

enum Node {
    /// Halves below and above a coordinate of an axis.
    Split {
        axis: usize,
        at: f32,
        halves: Box<[Node; 2]>,
    },
    Whole(Option<Place>),
}

/// What is known about light, by place and facing.
pub(super) struct Guide {
    facings: [Node; 6],
    reflectors: Reflectors,
}

impl Guide {
    /// One that knows nothing.
    pub(super) fn empty() -> Self {
        Self {
            facings: std::array::from_fn(|_| Node::Whole(None)),
            reflectors: Reflectors::default(),
        }
    }

    /// Learns from photons in `tracer`'s scene.
    pub(super) fn learn(tracer: &PathTracer) -> Self {
        let mut met: Vec<Met> = Vec::new();
        for round in 0..MOST_ROUNDS {
            let photons = (round * PHOTONS..(round + 1) * PHOTONS).into_par_iter();
            let photons = photons.with_min_len(256);
            met.par_extend(photons.flat_map_iter(|index| follow(tracer, index)));
            if met.len() >= ENOUGH {
                break;
            }
        }
        let mut facings: [Vec<Met>; 6] = std::array::from_fn(|_| Vec::new());
        let mut sent = vec![0; tracer.scattering.len()];
        for one in met {
            sent[one.sender as usize] += 1;
            facings[facing(one.normal)].push(one);
        }
        Self {
            facings: facings.map(|mut met| places(tracer, &mut met)),
            reflectors: Reflectors::of(tracer, &sent),
        }
    }

    /// What is known about light at `point` of a surface with this normal.
    pub(super) fn at(&self, point: Vec3, normal: Vec3) -> Option<&Place> {
        let mut node = &self.facings[facing(normal)];
        loop {
            match node {
                Node::Whole(place) => return place.as_ref(),
                Node::Split { axis, at, halves } => {
                    node = &halves[usize::from(point[*axis] >= *at)];
                }
            }
        }
    }
}

/// Where a path looks for light from one point.
pub(super) struct Directed<'a> {
    directions: &'a Directions,
    reflectors: Option<&'a Reflectors>,
    point: Vec3,
}

impl Guide {
    /// Where to look for light at `point` that is at this place.
    pub(super) fn directed<'a>(&'a self, place: &'a Place, point: Vec3) -> Directed<'a> {
        let reflectors = &self.reflectors;
        Directed {
            directions: &place.directions,
            reflectors: Some(reflectors).filter(|all| !all.is_empty_from(point)),
            point,
        }
    }
}

impl Directed<'_> {
    /// A direction from a point of the unit square.
    pub(super) fn sample(&self, at: Vec2) -> Option<Vec3> {
        let Some(reflectors) = self.reflectors else {
            return Some(self.directions.sample(at).0);
        };
        let doubled = at.x * 2.0;
        let at = Vec2::new(doubled.fract(), at.y);
        if doubled < 1.0 {
            Some(self.directions.sample(at).0)
        } else {
            reflectors.sample(self.point, at)
        }
    }

    /// Density of [`Self::sample`] [sr⁻¹].
    pub(super) fn density(&self, direction: Vec3) -> f32 {
        let learned = self.directions.density(direction);
        match self.reflectors {
            Some(reflectors) => 0.5 * (learned + reflectors.density(self.point, direction)),
            None => learned,
        }
    }
}

/// Which of the sides of a cube a normal faces most.
fn facing(normal: Vec3) -> usize {
    let axis = normal.abs().max_position();
    2 * axis + usize::from(normal[axis] < 0.0)
}

/// Where photon `index` meets surfaces. All carry the same power: they are absorbed or live on as they are.
fn follow(tracer: &PathTracer, index: u32) -> Vec<Met> {
    let mut met = Vec::new();
    let mut sampler = Sampler::new(0, index, SEED);
    let Some((mut from, mut origin, mut direction)) =
        tracer.lights.emit(sampler.draw(), sampler.draw())
    else {
        return met;
    };
    let mut scattered = None;
    for _ in 0..MOST_BOUNCES {
        let Some(hit) = tracer.surfaces.nearest_hit(from, direction, origin) else {
            break;
        };
        let surface = Surface::new(tracer, from, direction, &hit);
        if surface.is_black {
            break;
        }
        if let Some(sender) = scattered {
            met.push(Met {
                point: surface.point,
                triangle: surface.triangle,
                sender,
                from: to_square(-direction),
                normal: surface.normal,
            });
        }
        let choices = sampler.draw();
        let scatterer = Scatterer::new(tracer, &surface, -direction);
        let Some(step) = scatterer.step(choices) else {
            break;
        };
        if choices[3] >= step.weight.mean() {
            break;
        }
        if !step.passed {
            scattered = Some(surface.material);
        }
        (from, origin, direction) = (surface.point, surface.triangle, step.direction);
    }
    met
}

/// The places of `met`.
fn places(tracer: &PathTracer, met: &mut [Met]) -> Node {
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = met.iter().fold(none, |(low, high), one| {
        (low.min(one.point), high.max(one.point))
    });
    let axis = (high - low).max_position();
    if met.len() <= MOST_IN_PLACE || high[axis] <= low[axis] {
        return Node::Whole(place(tracer, met));
    }
    let middle = met.len() / 2;
    let by_axis = |a: &Met, b: &Met| a.point[axis].total_cmp(&b.point[axis]);
    let at = met.select_nth_unstable_by(middle, by_axis).1.point[axis];
    let (below, above) = met.split_at_mut(middle);
    let (below, above) = rayon::join(|| places(tracer, below), || places(tracer, above));
    Node::Split {
        axis,
        at,
        halves: Box::new([below, above]),
    }
}

fn place(tracer: &PathTracer, met: &[Met]) -> Option<Place> {
    if met.len() < LEAST_IN_PLACE {
        return None;
    }
    let some: Vec<Met> = met
        .iter()
        .copied()
        .step_by(met.len() / LIT_POINTS)
        .collect();
    let points: Vec<(Vec3, Vec3)> = some.iter().map(|one| (one.point, one.normal)).collect();
    let lights = tracer.lights.choice_for(&points);
    let directions = Directions::learn(met.iter().map(|one| one.from).collect())?;
    Some(Place {
        light: light_at(tracer, &lights, &directions, &some),
        directions,
        lights,
    })
}

/// Mean irradiance of some points, by paths.
fn light_at(
    tracer: &PathTracer,
    lights: &Choice,
    directions: &Directions,
    points: &[Met],
) -> Light {
    let mut light = Light::default();
    for (number, one) in points.iter().enumerate() {
        for index in 0..PATHS {
            let mut sampler = Sampler::new(number as u32, index, SEED);
            let [x, y, ..] = sampler.draw();
            // By turns towards where light is known to come from, and elsewhere.
            let direction = if index % 2 == 0 {
                cosine_direction(one.normal, Vec2::new(x, y))
            } else {
                directions.sample(Vec2::new(x, y)).0
            };
            let cosine = one.normal.dot(direction);
            if cosine > 0.0 {
                let density = 0.5 * (cosine * FRAC_1_PI + directions.density(direction));
                let reflected =
                    tracer.follow(one.point, one.triangle, direction, &mut sampler, false);
                light.indirect += reflected.mean() * cosine / density;
            }
            let to_light = sampler.draw();
            light.whole += tracer.irradiance(lights, one.point, one.normal, one.triangle, to_light);
        }
    }
    let count = (points.len() as u32 * PATHS) as f32;
    Light {
        whole: (light.whole + light.indirect) / count,
        indirect: light.indirect / count,
    }
}
