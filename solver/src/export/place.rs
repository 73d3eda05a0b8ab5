//! Where the light of a vertex is gathered: beside it, on a leaf that it belongs to, and not inside of what stands there.

use super::mesh::Vertex;
use crate::geometry::sampling::{cosine_direction, spread};
use crate::hierarchy::{Element, Hierarchy, NONE, NodeId};
use crate::transport::visibility::Occluders;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// A vertex is gathered this far from its point towards the middle of the leaves around it, unless they surround it: on
/// an edge between two walls the form factor of the other wall is not defined.
const INSET: f32 = 1.0 / 12.0;

/// Where a vertex is covered, it is gathered this far towards the middle or a corner of one of the leaves around it.
const UNCOVERED: [f32; 4] = [INSET, 0.25, 0.5, 1.0];

/// Rays that tell whether a place is covered.
const RAYS: u32 = 16;

/// A place is covered when fewer of them are open.
const OPEN: usize = RAYS as usize / 4;

/// A place is covered when more of them end on sides that light cannot reach.
const DARK: usize = RAYS as usize / 8;

/// A place touches what a ray meets within this share of the leaf's radius: it lies in the plane of that to rounding, where
/// no form factor is defined.
const TOUCHING: f32 = 0.02;

/// A place on a leaf.
pub(super) struct Place<'a> {
    pub(super) element: &'a Element,
    pub(super) position: Vec3,
}

impl<'a> Place<'a> {
    /// Where `vertex` sees what is seen around it. `around`: its leaves, at least one.
    ///
    /// What stands on a surface covers the vertices below it. They are not seen, but light is interpolated from them
    /// to places that are: those show what an uncovered part of the same leaves receives. Covered is what lies inside
    /// of something, or has surfaces before it that are closer than a leaf is large, which vanishes with refinement.
    pub(super) fn of(
        vertex: &Vertex,
        around: &[NodeId],
        hierarchy: &'a Hierarchy,
        occluders: &Occluders,
    ) -> Self {
        let element = |leaf: NodeId| &hierarchy.elements[hierarchy.node(leaf).element as usize];
        // Beside what stands on a leaf that it covers, a vertex shows what the others see.
        let is_exposed = |&leaf: &NodeId| !element(leaf).exposed.is_none();
        let exposed: Vec<NodeId> = around.iter().copied().filter(is_exposed).collect();
        let around = if exposed.is_empty() { around } else { &exposed };
        let on = |leaf: NodeId, towards: Vec3, share: f32| Self {
            element: element(leaf),
            position: hierarchy.points[vertex.point as usize].lerp(towards, share),
        };
        let centre = |leaf: NodeId| hierarchy.node(leaf).centre;
        let inset = |leaf: NodeId| on(leaf, centre(leaf), INSET);
        let view = |place: &Self| place.view(hierarchy, occluders);
        let openness = |place: &Self| view(place).open;
        let is_open = |place: &Self| openness(place) >= OPEN;
        let first = inset(around[0]);
        let is_touched = around.iter().any(|&leaf| element(leaf).is_touched);
        let is_plain = first.element.shading == NONE && !is_touched;
        let usual = if is_plain {
            let sum: Vec3 = around.iter().map(|&leaf| centre(leaf)).sum();
            let share = if surround(vertex.point, around, hierarchy) {
                0.0
            } else {
                INSET
            };
            on(around[0], sum / around.len() as f32, share)
        } else {
            // On smooth surfaces the middle of several leaves lies inside the solid, and some of them may; what stands on
            // a surface may do so between them: stay on the first of the most open ones.
            most_open(around.iter().map(|&leaf| inset(leaf)), openness).map_or(first, |best| best.1)
        };
        if is_open(&usual) {
            return usual;
        }
        let targets: Vec<(NodeId, Vec3)> = around
            .iter()
            .flat_map(|&leaf| {
                let corners = on(leaf, centre(leaf), 0.0).element.polygon;
                let inner = corners
                    .corners()
                    .iter()
                    .map(|c| c.lerp(centre(leaf), INSET));
                let targets: Vec<Vec3> = inner.chain([centre(leaf)]).collect();
                targets.into_iter().map(move |target| (leaf, target))
            })
            .collect();
        // The nearest of which the most rays are open, on the way to targets where enough of them are.
        let nearest = |seen: &dyn Fn(&Self) -> usize| {
            let is_seen = |&&(leaf, target): &&(NodeId, Vec3)| seen(&on(leaf, target, 1.0)) >= OPEN;
            let targets: Vec<_> = targets.iter().filter(is_seen).collect();
            UNCOVERED.iter().find_map(|&share| {
                let places = targets
                    .iter()
                    .map(|&&(leaf, target)| on(leaf, target, share));
                let best = most_open(places, seen)?;
                (best.0 >= OPEN).then_some(best.1)
            })
        };
        nearest(&openness)
            .or_else(|| {
                // Beside something that is near for all of the leaf, but not inside of it.
                let lit = |place: &Self| view(place).lit;
                (lit(&usual) < OPEN).then(|| nearest(&lit)).flatten()
            })
            .unwrap_or(usual)
    }

    /// What is seen from the place: nothing where it touches something, or sees what light does not reach.
    fn view(&self, hierarchy: &Hierarchy, occluders: &Occluders) -> View {
        let reach = hierarchy.node(self.element.node).radius;
        let mut view = View::default();
        let mut dark = 0;
        for ray in 0..RAYS {
            let direction = cosine_direction(self.element.normal, spread(ray));
            let hit = occluders.nearest_hit(self.position, direction, self.element.patch);
            if hit.is_some_and(|hit| hit.distance < TOUCHING * reach) {
                return View::default();
            }
            let is_dark = hit.is_some_and(|hit| hierarchy.whole(hit.patch, hit.back) == NONE);
            dark += usize::from(is_dark);
            view.lit += usize::from(!is_dark);
            view.open += usize::from(hit.is_none_or(|hit| !hit.back && hit.distance > reach));
        }
        if dark > DARK { View::default() } else { view }
    }
}

/// Of the rays from a place.
#[derive(Clone, Copy, Default)]
struct View {
    /// How many meet what light can reach, or nothing.
    lit: usize,
    /// How many meet a front, and not closer than the leaf is large, or nothing.
    open: usize,
}

/// True when leaves of one plane lie all around a point: their angles there fill a turn.
fn surround(point: u32, around: &[NodeId], hierarchy: &Hierarchy) -> bool {
    /// Angles are rounded; what is left open is less than any corner.
    const SLACK: f32 = 1e-3;
    let at = hierarchy.points[point as usize];
    let angle = |&leaf: &NodeId| {
        let element = &hierarchy.elements[hierarchy.node(leaf).element as usize];
        let count = element.corner_count();
        match element.points.iter().position(|&corner| corner == point) {
            Some(i) => {
                let to = |j: usize| element.polygon.corners()[j % count] - at;
                to(i + 1).angle_between(to(i + count - 1))
            }
            // In the middle of an edge.
            None => PI,
        }
    };
    around.iter().map(angle).sum::<f32>() > TAU - SLACK
}

/// The first of those `places` of which the most rays are open, and how many are.
fn most_open<P>(
    places: impl Iterator<Item = P>,
    openness: impl Fn(&P) -> usize,
) -> Option<(usize, P)> {
    let mut best: Option<(usize, P)> = None;
    for place in places {
        let open = openness(&place);
        if best.as_ref().is_none_or(|best| open > best.0) {
            best = Some((open, place));
        }
        if open == RAYS as usize {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Scene, SceneParts, Triangle};
    use crate::solve::Prepared;
    use crate::{Rgb, SolveConfig};

    /// A floor, and a wall that stands on it along x = 0.
    fn floor_and_wall() -> Scene {
        let mut parts = SceneParts {
            materials: vec![Material {
                emission: Rgb::WHITE,
                two_sided: true,
                ..Material::lambert("shining", Rgb::BLACK)
            }],
            ..SceneParts::default()
        };
        let floor = [
            (-1.0, 0.0, -1.0),
            (-1.0, 0.0, 1.0),
            (1.0, 0.0, 1.0),
            (1.0, 0.0, -1.0),
        ];
        let wall = [
            (0.0, 0.0, -1.0),
            (0.0, 0.0, 1.0),
            (0.0, 1.0, 1.0),
            (0.0, 1.0, -1.0),
        ];
        for corners in [floor, wall] {
            let first = parts.points.len() as u32;
            parts.points.extend(corners.map(Vec3::from));
            for points in [[0, 1, 2], [0, 2, 3]] {
                parts.triangles.push(Triangle {
                    points: points.map(|corner| first + corner),
                    normals: None,
                    material: 0,
                });
            }
        }
        Scene::new(parts, true).expect("a scene").0
    }

    #[test]
    fn at_the_foot_of_a_wall_no_place_is_open() {
        let settings = SolveConfig::default().settings().expect("settings");
        let prepared = Prepared::new(&floor_and_wall(), &settings);
        let hierarchy = prepared.hierarchy();
        let floor = hierarchy
            .elements
            .iter()
            .find(|element| element.normal.y > 0.9)
            .expect("a floor");
        let radius = hierarchy.node(floor.node).radius;
        let openness = |x: f32| {
            let position = floor.polygon.centre() - Vec3::X * (x * radius);
            let place = Place {
                element: floor,
                position,
            };
            place.view(&hierarchy, &prepared.occluders).open
        };
        // The wall is as near as rounding has it, and further off than the leaf is large for some of the rays.
        assert_eq!(openness(1e-5), 0);
        assert_eq!(openness(0.5 * TOUCHING), 0);
        assert!(openness(0.4) >= OPEN, "{}", openness(0.4));
    }
}
