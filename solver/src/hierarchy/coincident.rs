//! Surfaces in one place: of several, one is seen. Lamps come before what they lie on, otherwise the first in the scene;
//! a side that reflects before one that does not.

use super::patch::Patch;
use crate::geometry::Polygon;
use crate::scene::Material;
use crate::transport::link::COPLANAR;
use crate::transport::region::{PatchTree, Region};
use glam::Vec3;
use rayon::prelude::*;

/// Brings patches that emit to the front; the numbers of `patch_of` follow.
pub fn lamps_first(patches: &mut Vec<Patch>, patch_of: &mut [u32], materials: &[Material]) {
    let is_dark = |patch: &Patch| materials[patch.material as usize].emission.is_black();
    let mut order: Vec<u32> = (0..patches.len() as u32).collect();
    order.sort_by_key(|&patch| is_dark(&patches[patch as usize]));
    let mut place = vec![0; patches.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old as usize] = new as u32;
    }
    *patches = order.iter().map(|&old| patches[old as usize]).collect();
    for patch in patch_of {
        *patch = place[*patch as usize];
    }
}

/// Which sides, front and back, of each patch reflect or emit.
pub fn usable_sides(patches: &[Patch], materials: &[Material]) -> Vec<[bool; 2]> {
    let usable = |patch: &Patch| {
        let material = &materials[patch.material as usize];
        let emits = material.emits_from_back && !material.emission.is_black();
        [true, material.two_sided || emits]
    };
    patches.iter().map(usable).collect()
}

/// Which sides, front and back, lie wholly in the place of another patch that is seen instead. Cost: a search through
/// the `tree` of the patches for each.
pub fn covered_sides(tree: &PatchTree, shapes: &[Polygon], usable: &[[bool; 2]]) -> Vec<[bool; 2]> {
    let sides = |patch: usize| {
        let shape = &shapes[patch];
        let region = Region {
            origin: shape.centre(),
            lower: Vec3::ZERO,
            upper: Vec3::ZERO,
            planes: &[],
        };
        let mut covered = [false; 2];
        tree.visit_patches(&region, |other| {
            let other = other as usize;
            if other != patch && lies_in(shape, &shapes[other]) {
                let same = shape.vector_area().dot(shapes[other].vector_area()) > 0.0;
                for (side, covered) in covered.iter_mut().enumerate() {
                    let facing = if same { side } else { 1 - side };
                    // What is usable comes first, then what has the smaller number.
                    *covered |= (!usable[other][facing], other) < (!usable[patch][side], patch);
                }
            }
            true
        });
        covered
    };
    (0..shapes.len()).into_par_iter().map(sides).collect()
}

/// True when all of `inner` lies in `outer`.
fn lies_in(inner: &Polygon, outer: &Polygon) -> bool {
    let normal = outer.vector_area().normalize_or_zero();
    let corners = outer.corners();
    let is_inside = |point: &Vec3| {
        (point - corners[0]).dot(normal).abs() <= COPLANAR
            && (0..corners.len()).all(|i| {
                let edge = corners[(i + 1) % corners.len()] - corners[i];
                let inward = normal.cross(edge).normalize_or_zero();
                (point - corners[i]).dot(inward) >= -COPLANAR
            })
    };
    normal != Vec3::ZERO && inner.corners().iter().all(is_inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rgb;

    fn square(low: f32, high: f32, up: bool) -> Polygon {
        let corner = |x: f32, z: f32| Vec3::new(x, 0.25, z);
        let mut corners = [
            corner(low, low),
            corner(low, high),
            corner(high, high),
            corner(high, low),
        ];
        if !up {
            corners.reverse();
        }
        Polygon::new(&corners)
    }

    fn covered(shapes: &[Polygon], usable: &[[bool; 2]]) -> Vec<[bool; 2]> {
        covered_sides(&PatchTree::new(shapes, &[]), shapes, usable)
    }

    #[test]
    fn of_sides_in_one_place_one_is_left() {
        let (whole, part, beside) = (
            square(0.0, 0.4, true),
            square(0.1, 0.2, false),
            square(0.3, 0.5, true),
        );
        let both = [true, true];
        let front = [true, false];
        // The part lies in the whole; what lies beside it only touches it with a corner of its own.
        let shapes = [whole, part, beside];
        assert_eq!(
            covered(&shapes, &[both; 3]),
            [[false; 2], [true; 2], [false; 2]]
        );
        // The other way round it is the part that is seen, and the whole stays for what is around it.
        assert_eq!(
            covered(&[part, whole], &[both; 2]),
            [[false; 2], [false; 2]]
        );
        // Back to back: each covers the other's back.
        let back_to_back = [square(0.0, 0.4, true), square(0.0, 0.4, false)];
        assert_eq!(
            covered(&back_to_back, &[front; 2]),
            [[false, true], [false, true]]
        );
        // The same twice.
        assert_eq!(
            covered(&[whole, whole], &[front; 2]),
            [[false; 2], [true; 2]]
        );
    }

    #[test]
    fn lamps_come_first_in_their_order() {
        let lamp = Material {
            emission: Rgb::WHITE,
            ..Material::lambert("lamp", Rgb::BLACK)
        };
        let materials = [Material::lambert("wall", Rgb::BLACK), lamp];
        let patch = |first: u32, material: u32| Patch {
            points: [first, 1, 2, super::super::NONE],
            normals: None,
            material,
        };
        let mut patches = vec![patch(0, 0), patch(10, 1), patch(20, 0), patch(30, 1)];
        let mut patch_of = [3, 0, 1, 2, 2];
        lamps_first(&mut patches, &mut patch_of, &materials);
        let firsts: Vec<u32> = patches.iter().map(|p| p.points[0]).collect();
        assert_eq!(firsts, [10, 30, 0, 20]);
        assert_eq!(patch_of, [1, 2, 0, 3, 3]);
    }
}
