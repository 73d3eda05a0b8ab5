//! Which patches reach into a convex region: a search through a bounding volume hierarchy of patches.

use crate::geometry::Polygon;
use crate::transport::link::COPLANAR;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;
use std::time::Duration;

/// A convex region: a box cut by planes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region<'a> {
    /// Box and planes are relative to this.
    pub(crate) origin: Vec3,
    /// Box.
    pub(crate) lower: Vec3,
    /// Box.
    pub(crate) upper: Vec3,
    /// Normal and offset: inside where normal·p > offset.
    pub(crate) planes: &'a [(Vec3, f32)],
}

/// All patches, and clear triangles, which stop a search.
pub struct PatchTree {
    bvh: CwBvh,
    patch_count: u32,
}

/// Nodes that wait: a node of eight children leaves seven behind, a tree is about ten deep.
const MOST_PENDING: usize = 128;

impl PatchTree {
    /// Builds the hierarchy.
    pub fn new(shapes: &[Polygon], glass: &[[Vec3; 3]]) -> Self {
        let around = |corners: &[Vec3]| {
            let corners: Vec<Vec3A> = corners.iter().map(|&c| c.into()).collect();
            Aabb::from_points(&corners)
        };
        let mut boxes: Vec<Aabb> = shapes.iter().map(|s| around(s.corners())).collect();
        boxes.extend(glass.iter().map(|g| around(g)));
        let params = BvhBuildParams {
            pre_split: false,
            ..BvhBuildParams::medium_build()
        };
        Self {
            bvh: build_cwbvh(&boxes, params, &mut Duration::default()),
            patch_count: shapes.len() as u32,
        }
    }

    /// Visits every patch whose box reaches into or touches `region`, and some others. False when `visit` stopped it,
    /// or when there is glass.
    pub(crate) fn visit(&self, region: &Region<'_>, mut visit: impl FnMut(u32) -> bool) -> bool {
        self.search(region, |found| found < self.patch_count && visit(found))
    }

    /// The same whatever glass there is.
    pub(crate) fn visit_patches(
        &self,
        region: &Region<'_>,
        mut visit: impl FnMut(u32) -> bool,
    ) -> bool {
        self.search(region, |found| found >= self.patch_count || visit(found))
    }

    fn search(&self, region: &Region<'_>, mut visit: impl FnMut(u32) -> bool) -> bool {
        if self.bvh.nodes.is_empty() {
            return true;
        }
        let mut pending = [0u32; MOST_PENDING];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = &self.bvh.nodes[pending[count] as usize];
            let mut inside = children_inside(node, region);
            while inside != 0 {
                let child = inside.trailing_zeros() as usize;
                inside &= inside - 1;
                if node.is_child_empty(child) {
                    continue;
                }
                if node.is_leaf(child) {
                    let (first, length) = node.child_primitives(child);
                    let found = first as usize..(first + length) as usize;
                    for &patch in &self.bvh.primitive_indices[found] {
                        if !visit(patch) {
                            return false;
                        }
                    }
                } else if count < MOST_PENDING {
                    pending[count] = node.child_node_index(child);
                    count += 1;
                } else {
                    return false;
                }
            }
        }
        true
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.bvh.nodes.len() * size_of::<CwBvhNode>() + self.bvh.primitive_indices.len() * 4
    }
}

/// Which children of a node reach into a region, one bit a child.
fn children_inside(node: &CwBvhNode, region: &Region<'_>) -> u32 {
    let extent: Vec3 = node.compute_extent().into();
    let origin = node.p - region.origin;
    // The box in steps of the node's grid, rounded outward: casts cut off towards zero and saturate.
    let slack = Vec3::splat(COPLANAR);
    let low = (region.lower - slack - origin) / extent;
    let high = (region.upper + slack - origin) / extent + 1.0;
    if high.min_element() < 0.0 || low.max_element() > 256.0 {
        return 0;
    }
    let (low, high) = (
        low.to_array().map(|q| q as u8),
        high.to_array().map(|q| q as u8),
    );
    let mut inside = 0;
    for child in 0..8 {
        let is_inside = (node.child_max_x[child] >= low[0])
            & (node.child_min_x[child] <= high[0])
            & (node.child_max_y[child] >= low[1])
            & (node.child_min_y[child] <= high[1])
            & (node.child_max_z[child] >= low[2])
            & (node.child_min_z[child] <= high[2]);
        inside |= u32::from(is_inside) << child;
    }
    for &(normal, offset) in region.planes {
        if inside == 0 {
            return 0;
        }
        let slope = normal * extent;
        let least = offset - COPLANAR - normal.dot(origin);
        let x = if slope.x > 0.0 {
            &node.child_max_x
        } else {
            &node.child_min_x
        };
        let y = if slope.y > 0.0 {
            &node.child_max_y
        } else {
            &node.child_min_y
        };
        let z = if slope.z > 0.0 {
            &node.child_max_z
        } else {
            &node.child_min_z
        };
        let mut left = inside;
        while left != 0 {
            let child = left.trailing_zeros() as usize;
            left &= left - 1;
            let farthest = Vec3::new(
                f32::from(x[child]),
                f32::from(y[child]),
                f32::from(z[child]),
            );
            if slope.dot(farthest) <= least {
                inside &= !(1 << child);
            }
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hash::unit;

    #[test]
    fn it_finds_all_that_brute_force_finds() {
        let at = |i: u32, k: u32| Vec3::new(unit(i, k), unit(i, k + 1), unit(i, k + 2)) - 0.5;
        let shapes: Vec<Polygon> = (0..500)
            .map(|i| {
                let first = at(i, 0);
                Polygon::new(&[first, first + 0.1 * at(i, 10), first + 0.1 * at(i, 20)])
            })
            .collect();
        let tree = PatchTree::new(&shapes, &[]);
        let mut found_in_all = 0;
        for case in 0..100 {
            let planes: Vec<(Vec3, f32)> = (0..3)
                .map(|k| (at(1000 + case, 10 * k).normalize(), -0.1))
                .collect();
            let (a, b) = (at(2000 + case, 0), at(2000 + case, 10));
            let region = Region {
                origin: 0.1 * at(3000 + case, 0),
                lower: a.min(b),
                upper: a.max(b),
                planes: &planes,
            };
            let mut found = vec![false; shapes.len()];
            assert!(tree.visit(&region, |patch| {
                found[patch as usize] = true;
                true
            }));
            for (shape, found) in shapes.iter().zip(found) {
                // A corner inside is enough to reach into it.
                let is_inside = shape.corners().iter().any(|&corner| {
                    let p = corner - region.origin;
                    let in_box = p.cmpge(region.lower).all() && p.cmple(region.upper).all();
                    in_box && planes.iter().all(|&(n, offset)| n.dot(p) > offset)
                });
                assert!(found || !is_inside, "case {case}");
                found_in_all += u32::from(is_inside);
            }
        }
        assert!(found_in_all > 100, "{found_in_all} found");
    }

    #[test]
    fn glass_stops_the_search() {
        let glass = [[Vec3::ZERO, Vec3::X, Vec3::Y]];
        let region = Region {
            origin: Vec3::ZERO,
            lower: Vec3::splat(-1.0),
            upper: Vec3::ONE,
            planes: &[],
        };
        assert!(!PatchTree::new(&[], &glass).visit(&region, |_| true));
    }
}
