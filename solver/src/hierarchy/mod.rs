//! The hierarchy of light transport: clusters above patches above elements, in one arena.
//!
//! Node 0 is the root. Children of a node are contiguous. Clusters come first, elements are appended as they are
//! made and never removed. A surface that reflects on both sides stands in the tree twice, once a side, so every
//! element is one-sided. Coordinates are normalised (see [`crate::normalise`]).

mod cluster;
pub mod coincident;
pub mod contact;
pub mod detail;
pub mod exposed;
pub mod patch;
pub mod reach;
mod split;
pub mod targets;

use crate::geometry::Polygon;
use crate::scene::Material;
use exposed::Exposed;
use glam::{Vec2, Vec3};
use patch::Patch;
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// Number of a node; the root is 0.
pub type NodeId = u32;

/// Stands for "no element", "no child" in 32-bit fields of the arena.
pub const NONE: u32 = u32::MAX;

/// A cluster or an element as the link refinement sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Box.
    pub lower: Vec3,
    /// Box.
    pub upper: Vec3,
    /// Element: mean of its corners. Cluster: middle of the box.
    pub centre: Vec3,
    /// Radius of a sphere around `centre` that holds the node.
    pub radius: f32,
    /// One-sided area of what light can reach; of a cluster, the sum over its patches.
    pub area: f32,
    /// Area times largest diffuse plus specular reflectance, summed.
    pub reflecting_area: f32,
    /// First child, or [`NONE`].
    pub first_child: NodeId,
    /// Number of children.
    pub child_count: u32,
    /// Parent, or [`NONE`] for the root.
    pub parent: NodeId,
    /// Index into [`Hierarchy::elements`], or [`NONE`] for a cluster.
    pub element: u32,
}

/// A one-sided patch or part of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// Its node.
    pub node: NodeId,
    /// Corner points: indices into [`Hierarchy::points`]; the fourth is [`NONE`] for triangles.
    pub points: [u32; 4],
    /// Its shape, counter-clockwise from the side that this element stands for.
    pub polygon: Polygon,
    /// Geometric normal, unit.
    pub normal: Vec3,
    /// Shading normals at the corners, unit: index into [`Hierarchy::shading_normals`], or [`NONE`] for flat.
    pub shading: u32,
    /// The patch that it is part of.
    pub patch: u32,
    /// Index of its material.
    pub material: u32,
    /// It stands for the back of its patch.
    pub back: bool,
    /// Subdivisions below the patch.
    pub level: u8,
    /// Which part of it light can reach.
    pub exposed: Exposed,
    /// Something may touch it: its parts may differ in that.
    pub is_touched: bool,
}

impl Element {
    /// Number of corners, three or four.
    pub fn corner_count(&self) -> usize {
        self.polygon.corners().len()
    }

    /// The point at `uv` of the unit square, on what light can reach.
    pub fn point(&self, uv: Vec2) -> Vec3 {
        self.polygon.point(self.exposed.point(uv))
    }
}

/// The arena.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy {
    /// Clusters and elements.
    pub nodes: Vec<Node>,
    /// One an element node.
    pub elements: Vec<Element>,
    /// Positions that elements refer to; edge midpoints are appended.
    pub points: Vec<Vec3>,
    /// Corner normals of smooth elements.
    pub shading_normals: Vec<[Vec3; 4]>,
    /// The patches.
    pub patches: Vec<Patch>,
    /// The element that is the whole front and back of each patch; [`NONE`] for sides that light cannot reach.
    wholes: Vec<[NodeId; 2]>,
    midpoints: FxHashMap<(u32, u32), u32>,
}

impl Hierarchy {
    /// Clusters and patches; no element is subdivided yet. `points`: normalised. `lit`: which sides of each patch,
    /// front and back, light can reach ([`reach::lit_sides`]); the others become no element.
    pub fn new(
        points: Vec<Vec3>,
        patches: Vec<Patch>,
        materials: &[Material],
        lit: &[[reach::Side; 2]],
    ) -> Self {
        let mut hierarchy = Self {
            points,
            patches,
            ..Self::default()
        };
        cluster::build(&mut hierarchy, materials, lit);
        hierarchy.wholes = vec![[NONE; 2]; hierarchy.patches.len()];
        for element in &hierarchy.elements {
            hierarchy.wholes[element.patch as usize][usize::from(element.back)] = element.node;
        }
        hierarchy
    }

    /// The element that is a whole side of `patch`; [`NONE`] for sides that light cannot reach.
    pub fn whole(&self, patch: u32, back: bool) -> NodeId {
        self.wholes[patch as usize][usize::from(back)]
    }

    /// Node `id`.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id as usize]
    }

    /// The element of node `id`, if it is one.
    pub fn element_of(&self, id: NodeId) -> Option<&Element> {
        match self.nodes[id as usize].element {
            NONE => None,
            element => Some(&self.elements[element as usize]),
        }
    }

    /// Children of `id`.
    pub fn children(&self, id: NodeId) -> std::ops::Range<NodeId> {
        let node = self.node(id);
        if node.first_child == NONE {
            0..0
        } else {
            node.first_child..node.first_child + node.child_count
        }
    }

    /// True when `id` has no child.
    pub fn is_leaf(&self, id: NodeId) -> bool {
        self.node(id).first_child == NONE
    }

    /// True when `id` has children that existed when there were `count` nodes.
    pub fn has_children_among(&self, id: NodeId, count: usize) -> bool {
        let first = self.node(id).first_child;
        first != NONE && (first as usize) < count
    }

    /// Number of clusters.
    pub fn cluster_count(&self) -> usize {
        self.nodes.len() - self.elements.len()
    }

    /// Mean of the shading normals of an element, unit.
    pub fn shading_normal(&self, element: &Element) -> Vec3 {
        if element.shading == NONE {
            return element.normal;
        }
        let normals = &self.shading_normals[element.shading as usize];
        normals[..element.corner_count()]
            .iter()
            .sum::<Vec3>()
            .normalize_or(element.normal)
    }

    /// Angular radius over which mirror directions vary on an element [rad]: twice the largest angle between a
    /// corner's shading normal and their mean. Zero on flat elements.
    pub fn bend(&self, element: &Element) -> f32 {
        if element.shading == NONE {
            return 0.0;
        }
        let mean = self.shading_normal(element);
        let corners = &self.shading_normals[element.shading as usize][..element.corner_count()];
        let cosine = corners.iter().map(|n| n.dot(mean)).fold(1.0, f32::min);
        2.0 * cosine.acos()
    }

    /// The point in the middle of an edge, if some element has been split there.
    pub fn midpoint(&self, a: u32, b: u32) -> Option<u32> {
        self.midpoints.get(&(a.min(b), a.max(b))).copied()
    }

    /// The point in the middle of an edge, made if there is none.
    fn make_midpoint(&mut self, a: u32, b: u32) -> u32 {
        let points = &mut self.points;
        *self
            .midpoints
            .entry((a.min(b), a.max(b)))
            .or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]) * 0.5);
                points.len() as u32 - 1
            })
    }

    /// Adds up the areas of `nodes` and of all above them again.
    fn sum_areas(&mut self, nodes: Vec<NodeId>) {
        let mut pending: BTreeSet<NodeId> = nodes.into_iter().filter(|&id| id != NONE).collect();
        // Parents have smaller numbers than their children.
        while let Some(id) = pending.pop_last() {
            let children =
                &self.nodes[self.children(id).start as usize..self.children(id).end as usize];
            let area = children.iter().map(|child| child.area).sum();
            let reflecting_area = children.iter().map(|child| child.reflecting_area).sum();
            let node = &mut self.nodes[id as usize];
            (node.area, node.reflecting_area) = (area, reflecting_area);
            if node.parent != NONE {
                pending.insert(node.parent);
            }
        }
    }

    /// Appends an element and its node; the reflecting area is left to the caller.
    fn push_element(&mut self, mut element: Element, parent: NodeId) {
        let polygon = element.polygon;
        let (lower, upper) = polygon
            .corners()
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &c| {
                (low.min(c), high.max(c))
            });
        element.node = self.nodes.len() as NodeId;
        self.nodes.push(Node {
            lower,
            upper,
            centre: polygon.centre(),
            radius: polygon.radius(),
            area: polygon.vector_area().length(),
            reflecting_area: 0.0,
            first_child: NONE,
            child_count: 0,
            parent,
            element: self.elements.len() as u32,
        });
        self.elements.push(element);
    }

    /// Bytes that the arena holds.
    pub fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>()
            + self.elements.len() * size_of::<Element>()
            + self.points.len() * size_of::<Vec3>()
            + self.shading_normals.len() * size_of::<[Vec3; 4]>()
            + self.patches.len() * size_of::<Patch>()
            + self.wholes.len() * size_of::<[NodeId; 2]>()
            + self.midpoints.len() * 12
    }

    /// Panics unless the invariants hold: children point back, lie in their parent's box and fill its area.
    pub fn assert_well_formed(&self) {
        for (id, node) in self.nodes.iter().enumerate() {
            assert!(
                node.area > 0.0 && node.radius > 0.0,
                "node {id} has no area"
            );
            let mut area = 0.0;
            for child in self.children(id as NodeId) {
                let inner = self.node(child);
                assert_eq!(
                    inner.parent, id as NodeId,
                    "child {child} of {id} points elsewhere"
                );
                let slack = Vec3::splat(4.0 * f32::EPSILON);
                assert!(
                    inner.lower.cmpge(node.lower - slack).all()
                        && inner.upper.cmple(node.upper + slack).all()
                );
                area += inner.area;
            }
            // Corners are rounded in coordinates of size 1, however small the element.
            let rounding = 64.0 * f32::EPSILON * node.radius;
            assert!(
                node.first_child == NONE || (area - node.area).abs() <= 1e-4 * node.area + rounding,
                "area of node {id}: {area} in its children, {} itself",
                node.area
            );
        }
    }
}
