//! Shafts between two boxes (Haines & Wallace 1991): a link whose shaft holds nothing is visible without a ray, and what
//! it holds is cut out exactly where that is little.

use crate::transport::link::{COPLANAR, Receiver, Sender};
use crate::transport::occlusion::Geometry;
use crate::transport::region::Region;
use glam::Vec3;

/// The convex hull of two boxes, as the box around both and up to eight planes.
#[derive(Clone, Debug)]
pub struct Shaft {
    lower: Vec3,
    upper: Vec3,
    /// Outward unit normal and offset: outside when normal·p >= offset.
    planes: [(Vec3, f32); 8],
    plane_count: usize,
}

impl Shaft {
    /// The shaft between two boxes.
    pub fn new(first: (Vec3, Vec3), second: (Vec3, Vec3)) -> Self {
        let (a, b) = ([first.0, first.1], [second.0, second.1]);
        let mut shaft = Self {
            lower: a[0].min(b[0]),
            upper: a[1].max(b[1]),
            planes: [(Vec3::ZERO, 0.0); 8],
            plane_count: 0,
        };
        // Which box bounds the shaft on each of the six sides.
        let owner = |axis: usize, side: usize| {
            if side == 0 {
                usize::from(b[0][axis] < a[0][axis])
            } else {
                usize::from(b[1][axis] > a[1][axis])
            }
        };
        for axis1 in 0..3 {
            for axis2 in axis1 + 1..3 {
                for sides in 0..4 {
                    let (s1, s2) = (sides & 1, sides >> 1);
                    let (o1, o2) = (owner(axis1, s1), owner(axis2, s2));
                    if o1 == o2 || shaft.plane_count == 8 {
                        continue;
                    }
                    // The plane through the edge (s1, s2) of each box, parallel to the third axis.
                    let (dx, dy) = (b[s1][axis1] - a[s1][axis1], b[s2][axis2] - a[s2][axis2]);
                    let mut normal = Vec3::ZERO;
                    normal[axis1] = dy;
                    normal[axis2] = -dx;
                    // Outward: towards the sides that it cuts off.
                    let outward = |side: usize| if side == 0 { -1.0 } else { 1.0 };
                    if normal[axis1] * outward(s1) + normal[axis2] * outward(s2) < 0.0 {
                        normal = -normal;
                    }
                    let Some(normal) = normal.try_normalize() else {
                        continue;
                    };
                    let offset = (normal[axis1] * a[s1][axis1] + normal[axis2] * a[s2][axis2])
                        .max(normal[axis1] * b[s1][axis1] + normal[axis2] * b[s2][axis2]);
                    shaft.planes[shaft.plane_count] = (normal, offset);
                    shaft.plane_count += 1;
                }
            }
        }
        shaft
    }
}

/// Patches but for the two `ends` that reach into the shaft between two polygons, at most `most`; `None` when there
/// are more, or glass. Coincident surfaces of the sender are among them, those of the receiver are not.
pub(super) fn occluders(
    receiver: &Receiver,
    sender: &Sender,
    geometry: &Geometry<'_>,
    most: usize,
) -> Option<Vec<u32>> {
    let shaft = Shaft::new(
        (receiver.lower, receiver.upper),
        (sender.lower, sender.upper),
    );
    let mut planes = [(Vec3::ZERO, 0.0); 10];
    let mut count = 0;
    let mut add = |normal: Vec3, offset: f32| {
        planes[count] = (normal, offset);
        count += 1;
    };
    for &(normal, offset) in &shaft.planes[..shaft.plane_count] {
        add(-normal, -offset);
    }
    if let Some(normal) = receiver.normal {
        add(normal, normal.dot(receiver.centre));
    }
    if sender.polygon.is_some() {
        add(
            sender.normal,
            sender.normal.dot(sender.centre) - 2.0 * COPLANAR,
        );
    }
    let mut found = Vec::new();
    let region = Region {
        origin: Vec3::ZERO,
        lower: shaft.lower,
        upper: shaft.upper,
        planes: &planes[..count],
    };
    let complete = geometry.tree.visit(&region, |patch| {
        if patch == receiver.patch || patch == sender.patch {
            return true;
        }
        let corners = geometry.shapes[patch as usize].corners();
        let outside = region
            .planes
            .iter()
            .any(|&(normal, offset)| corners.iter().all(|c| c.dot(normal) <= offset + COPLANAR));
        if !outside {
            found.push(patch);
        }
        found.len() <= most
    });
    complete.then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hash::unit;

    #[test]
    fn no_segment_between_the_boxes_leaves_the_shaft() {
        for case in 0..200 {
            let u = |i: u32| unit(case, i);
            let corner = |i: u32| Vec3::new(u(i), u(i + 1), u(i + 2));
            let (a, b) = (corner(0), corner(3));
            let first = (a, a + corner(6) * 0.2);
            let second = (b, b + corner(9) * 0.3);
            let shaft = Shaft::new(first, second);
            for i in 0..50 {
                let v = |k: u32| Vec3::new(unit(i, k), unit(i, k + 1), unit(i, k + 2));
                let p = first.0 + (first.1 - first.0) * v(100);
                let q = second.0 + (second.1 - second.0) * v(200);
                let at = p.lerp(q, unit(i, 300));
                let slack = Vec3::splat(1e-6);
                let in_box =
                    at.cmpge(shaft.lower - slack).all() && at.cmple(shaft.upper + slack).all();
                let in_planes = shaft.planes[..shaft.plane_count]
                    .iter()
                    .all(|&(normal, offset)| normal.dot(at) <= offset + 1e-6);
                assert!(in_box && in_planes, "case {case}: {at}");
            }
        }
    }
}
