//! The conforming leaf mesh: shared vertices, no T-junctions.
//!
//! Edge midpoints are shared points of the hierarchy, whatever surface they belong to; after 2:1 balancing a leaf
//! has at most one hanging point an edge; a fan from its middle, where that has a vertex, or templates triangulate it. Cost: linear in the leaves.

use crate::hierarchy::{Element, Hierarchy, NONE, NodeId};
use glam::Vec3;
use rustc_hash::FxHashMap;

/// A vertex of the mesh: a point as one smooth surface sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    /// Index into [`Hierarchy::points`].
    pub point: u32,
    /// Shading normal.
    pub normal: Vec3,
    /// Material.
    pub material: u32,
    /// The leaf element that it was made for.
    pub leaf: NodeId,
}

/// Vertices and triangles.
#[derive(Default)]
pub(super) struct Mesh {
    pub vertices: Vec<Vertex>,
    pub triangles: Vec<[u32; 3]>,
    pub element_edges: Vec<u8>,
    index: FxHashMap<Key, u32>,
    /// Vertices in the middle of leaves.
    centres: FxHashMap<NodeId, u32>,
}

/// Point, material and normal in steps of 1/1024: one vertex a smooth surface.
type Key = (u32, u32, [i16; 3]);

fn key(point: u32, material: u32, normal: Vec3) -> Key {
    (
        point,
        material,
        (normal * 1024.0).round().to_array().map(|c| c as i16),
    )
}

/// Shading normal at corner `i` of an element.
pub(super) fn corner_normal(hierarchy: &Hierarchy, element: &Element, i: usize) -> Vec3 {
    if element.shading == NONE {
        element.normal
    } else {
        hierarchy.shading_normals[element.shading as usize][i]
    }
}

/// Corners and hanging points around a leaf: each with its normal and whether it is a corner.
fn ring(hierarchy: &Hierarchy, element: &Element) -> impl Iterator<Item = (u32, Vec3, bool)> {
    let count = element.corner_count();
    (0..count).flat_map(move |i| {
        let j = (i + 1) % count;
        let (a, b) = (element.points[i], element.points[j]);
        let (na, nb) = (
            corner_normal(hierarchy, element, i),
            corner_normal(hierarchy, element, j),
        );
        let hanging = hierarchy.midpoint(a, b).map(|middle| {
            let normal = if element.shading == NONE {
                element.normal
            } else {
                (na + nb).normalize_or(element.normal)
            };
            (middle, normal, false)
        });
        std::iter::once((a, na, true)).chain(hanging)
    })
}

/// Leaf elements in the order of their making.
pub(super) fn leaves(hierarchy: &Hierarchy) -> impl Iterator<Item = &Element> {
    hierarchy
        .elements
        .iter()
        .filter(|e| hierarchy.is_leaf(e.node))
}

impl Mesh {
    /// Makes vertices for the corners of all leaves; known ones are kept.
    pub(super) fn add_corners(&mut self, hierarchy: &Hierarchy) {
        for element in leaves(hierarchy) {
            for i in 0..element.corner_count() {
                let normal = corner_normal(hierarchy, element, i);
                self.vertex(element.points[i], normal, element);
            }
        }
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.vertices[..])
            + size_of_val(&self.triangles[..])
            + self.element_edges.len()
            + self.index.capacity() * size_of::<(Key, u32)>()
            + self.centres.capacity() * size_of::<(NodeId, u32)>()
    }

    /// Vertices, triangles, and which of their edges are those of elements.
    pub(super) fn into_parts(self) -> (Vec<Vertex>, Vec<[u32; 3]>, Vec<u8>) {
        (self.vertices, self.triangles, self.element_edges)
    }

    /// Makes a vertex in the middle of a leaf.
    pub(super) fn add_centre(&mut self, hierarchy: &mut Hierarchy, element: &Element) {
        let vertex = Vertex {
            point: hierarchy.points.len() as u32,
            normal: hierarchy.shading_normal(element),
            material: element.material,
            leaf: element.node,
        };
        hierarchy.points.push(hierarchy.node(element.node).centre);
        self.centres
            .insert(element.node, self.vertices.len() as u32);
        self.vertices.push(vertex);
    }

    /// The leaves around each vertex in order, those included that have it on an edge.
    pub(super) fn leaves_around(&self, hierarchy: &Hierarchy) -> Vec<Vec<NodeId>> {
        let mut around: Vec<Vec<NodeId>> = vec![Vec::new(); self.vertices.len()];
        for element in leaves(hierarchy) {
            for (point, normal, _) in ring(hierarchy, element) {
                if let Some(&vertex) = self.index.get(&key(point, element.material, normal)) {
                    around[vertex as usize].push(element.node);
                }
            }
        }
        for (vertex, around) in self.vertices.iter().zip(&mut around) {
            if around.is_empty() {
                around.push(vertex.leaf);
            }
        }
        around
    }

    /// The vertex at a point on `element`'s surface.
    fn vertex(&mut self, point: u32, normal: Vec3, element: &Element) -> u32 {
        let vertices = &mut self.vertices;
        *self
            .index
            .entry(key(point, element.material, normal))
            .or_insert_with(|| {
                vertices.push(Vertex {
                    point,
                    normal,
                    material: element.material,
                    leaf: element.node,
                });
                vertices.len() as u32 - 1
            })
    }

    /// The vertices at the corners of a leaf, which [`Self::add_corners`] made.
    pub(super) fn corners(
        &self,
        hierarchy: &Hierarchy,
        element: &Element,
    ) -> impl Iterator<Item = u32> {
        let known = |i: usize| {
            let normal = corner_normal(hierarchy, element, i);
            self.index[&key(element.points[i], element.material, normal)]
        };
        (0..element.corner_count())
            .map(known)
            .collect::<Vec<_>>()
            .into_iter()
    }

    /// Triangles of all leaves, hanging points included.
    pub(super) fn triangulate(&mut self, hierarchy: &Hierarchy) {
        let all: Vec<Element> = leaves(hierarchy).copied().collect();
        for element in all {
            let ring: Vec<(u32, bool)> = ring(hierarchy, &element)
                .map(|(point, normal, is_corner)| (self.vertex(point, normal, &element), is_corner))
                .collect();
            match self.centres.get(&element.node).copied() {
                Some(centre) => {
                    for (i, &(vertex, _)) in ring.iter().enumerate() {
                        self.push([vertex, ring[(i + 1) % ring.len()].0, centre], 0b001);
                    }
                }
                None => self.fill(hierarchy, &ring, element.corner_count()),
            }
        }
    }

    /// Triangulates one leaf from its ring.
    fn fill(&mut self, hierarchy: &Hierarchy, ring: &[(u32, bool)], corners: usize) {
        let n = ring.len();
        if n == corners {
            if n == 3 {
                return self.push([ring[0].0, ring[1].0, ring[2].0], 0b111);
            }
            // The shorter diagonal; the first on a tie.
            let at = |i: usize| hierarchy.points[self.vertices[ring[i].0 as usize].point as usize];
            let (d02, d13) = (at(0).distance_squared(at(2)), at(1).distance_squared(at(3)));
            let start = usize::from(d13 < d02);
            let v = |i: usize| ring[(start + i) % 4].0;
            self.push([v(0), v(1), v(2)], 0b011);
            return self.push([v(0), v(2), v(3)], 0b110);
        }
        // Cut the corner between two hanging points first; what is left is convex with fewer of them.
        if let Some(corner) =
            (0..n).find(|&i| ring[i].1 && !ring[(i + 1) % n].1 && !ring[(i + n - 1) % n].1)
        {
            let (before, after) = ((corner + n - 1) % n, (corner + 1) % n);
            self.push([ring[before].0, ring[corner].0, ring[after].0], 0b011);
            let mut rest: Vec<(u32, bool)> = ring.to_vec();
            // The cut makes its two ends true corners of the rest.
            rest[before].1 = true;
            rest[after].1 = true;
            rest.remove(corner);
            return self.fan(&rest);
        }
        self.fan(ring);
    }

    /// A fan from a hanging point, whose neighbours are corners, or from a corner if there is none.
    fn fan(&mut self, ring: &[(u32, bool)]) {
        let n = ring.len();
        if n == 3 {
            return self.push([ring[0].0, ring[1].0, ring[2].0], 0b111);
        }
        let start = (0..n).find(|&i| !ring[i].1).unwrap_or(0);
        let v = |i: usize| ring[(start + i) % n].0;
        for i in 1..n - 1 {
            let first = u8::from(i == 1);
            let last = if i == n - 2 { 0b100 } else { 0 };
            self.push([v(0), v(i), v(i + 1)], first | 0b010 | last);
        }
    }

    fn push(&mut self, triangle: [u32; 3], edges: u8) {
        self.triangles.push(triangle);
        self.element_edges.push(edges);
    }
}
