//! Clusters above the patches: a bounding volume hierarchy by obvhs, opened to four children a node.

use super::exposed::Exposed;
use super::reach::Side;
use super::{Element, Hierarchy, NONE, Node, NodeId};
use crate::geometry::Polygon;
use crate::scene::Material;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use std::collections::VecDeque;
use std::time::Duration;

/// Children that a cluster is opened to, sides of patches not counted.
const ARITY: usize = 4;

/// Black surfaces count this much as receivers, so that the power they absorb is known.
const LEAST_REFLECTANCE: f32 = 0.05;

#[derive(Clone, Copy)]
enum Item {
    Inner(usize),
    Patch(u32),
}

/// Fills `hierarchy.nodes` and `hierarchy.elements` from its patches.
pub(super) fn build(hierarchy: &mut Hierarchy, materials: &[Material], lit: &[[Side; 2]]) {
    let used: Vec<u32> = (0..hierarchy.patches.len() as u32)
        .filter(|&p| lit[p as usize].iter().any(|side| side.lit))
        .collect();
    let boxes: Vec<Aabb> = used
        .iter()
        .map(|&patch| {
            let patch = &hierarchy.patches[patch as usize];
            let corners: Vec<Vec3A> = patch
                .corners(&hierarchy.points)
                .iter()
                .map(|&c| c.into())
                .collect();
            Aabb::from_points(&corners)
        })
        .collect();
    let params = BvhBuildParams {
        pre_split: false,
        max_prims_per_leaf: 1,
        ..BvhBuildParams::medium_build()
    };
    let bvh = build_bvh2(&boxes, params, &mut Duration::default());

    hierarchy.nodes.push(cluster_node(NONE));
    if used.is_empty() {
        return;
    }
    let mut queue: VecDeque<(NodeId, Item)> = VecDeque::from([(0, item_of(&bvh, 0))]);
    while let Some((id, item)) = queue.pop_front() {
        let first = hierarchy.nodes.len() as NodeId;
        let mut clusters = Vec::new();
        for item in opened(&bvh, item) {
            match item {
                Item::Inner(_) => {
                    clusters.push((hierarchy.nodes.len() as NodeId, item));
                    hierarchy.nodes.push(cluster_node(id));
                }
                Item::Patch(index) => {
                    let patch = used[index as usize];
                    push_sides(hierarchy, materials, patch, lit[patch as usize], id);
                }
            }
        }
        queue.extend(clusters);
        let count = hierarchy.nodes.len() as NodeId - first;
        let node = &mut hierarchy.nodes[id as usize];
        node.first_child = first;
        node.child_count = count;
    }
    for id in (0..hierarchy.nodes.len()).rev() {
        if hierarchy.nodes[id].element == NONE {
            summarise(hierarchy, id as NodeId);
        }
    }
}

fn item_of(bvh: &Bvh2, index: usize) -> Item {
    let node = &bvh.nodes[index];
    if node.is_leaf() {
        Item::Patch(bvh.primitive_indices[node.first_index as usize])
    } else {
        Item::Inner(index)
    }
}

/// The item's children, largest boxes opened until there are [`ARITY`].
fn opened(bvh: &Bvh2, item: Item) -> Vec<Item> {
    let mut items = vec![item];
    loop {
        let largest = items
            .iter()
            .enumerate()
            .filter_map(|(slot, item)| match item {
                Item::Inner(index) => Some((slot, *index, bvh.nodes[*index].aabb().half_area())),
                Item::Patch(_) => None,
            })
            .max_by(|a, b| a.2.total_cmp(&b.2).then(b.0.cmp(&a.0)));
        match largest {
            Some((slot, index, _)) if items.len() < ARITY => {
                let first = bvh.nodes[index].first_index as usize;
                items.splice(slot..=slot, [item_of(bvh, first), item_of(bvh, first + 1)]);
            }
            _ => return items,
        }
    }
}

fn cluster_node(parent: NodeId) -> Node {
    Node {
        lower: Vec3::INFINITY,
        upper: Vec3::NEG_INFINITY,
        centre: Vec3::ZERO,
        radius: 0.0,
        area: 0.0,
        reflecting_area: 0.0,
        first_child: NONE,
        child_count: 0,
        parent,
        element: NONE,
    }
}

fn push_sides(
    hierarchy: &mut Hierarchy,
    materials: &[Material],
    patch_id: u32,
    sides: [Side; 2],
    parent: NodeId,
) {
    let patch = hierarchy.patches[patch_id as usize];
    let material = &materials[patch.material as usize];
    let specular = match material.gloss {
        crate::scene::Gloss::None => crate::Rgb::BLACK,
        crate::scene::Gloss::Phong { specular, .. }
        | crate::scene::Gloss::Ward { specular, .. } => specular,
    };
    let reflectance = (material.diffuse + specular).mean().max(LEAST_REFLECTANCE);
    let count = if patch.points[3] == NONE { 3 } else { 4 };
    for back in [false, true] {
        if !sides[usize::from(back)].lit {
            continue;
        }
        let mut points = patch.points;
        let mut normals = patch.normals;
        if back {
            // Reversed winding: corner 0 stays.
            points[1..count].reverse();
            if let Some(n) = &mut normals {
                n[1..count].reverse();
                *n = n.map(|n| -n);
            }
        }
        let at: Vec<Vec3> = points[..count]
            .iter()
            .map(|&p| hierarchy.points[p as usize])
            .collect();
        let polygon = Polygon::new(&at);
        let shading = match normals {
            Some(normals) => {
                hierarchy.shading_normals.push(normals);
                hierarchy.shading_normals.len() as u32 - 1
            }
            None => NONE,
        };
        let normal = polygon.vector_area().normalize_or_zero();
        let element = Element {
            node: NONE,
            points,
            polygon,
            normal,
            shading,
            patch: patch_id,
            material: patch.material,
            back,
            level: 0,
            exposed: Exposed::ALL,
            is_touched: sides[usize::from(back)].touched,
        };
        hierarchy.push_element(element, parent);
        let node = hierarchy.nodes.last_mut().expect("an element was pushed");
        node.reflecting_area = node.area * reflectance;
    }
}

/// Box, area and reflecting area of a cluster from its children, whose own are known.
fn summarise(hierarchy: &mut Hierarchy, id: NodeId) {
    let mut sum = cluster_node(hierarchy.node(id).parent);
    for child in hierarchy.children(id) {
        let child = hierarchy.node(child);
        sum.lower = sum.lower.min(child.lower);
        sum.upper = sum.upper.max(child.upper);
        sum.area += child.area;
        sum.reflecting_area += child.reflecting_area;
    }
    let node = &mut hierarchy.nodes[id as usize];
    let centre = (sum.lower + sum.upper) * 0.5;
    *node = Node {
        centre,
        radius: (sum.upper - centre).length(),
        first_child: node.first_child,
        child_count: node.child_count,
        ..sum
    };
}
