//! Splitting of elements: 4:1 (§3.1), long ones in two.

use super::exposed::Exposed;
use super::{Element, Hierarchy, NONE, NodeId};
use crate::geometry::Polygon;
use glam::Vec3;

/// Quads this many times as long as wide are halved.
const LONG_QUAD: f32 = 2.0;

/// And triangles this many times as long as high.
const LONG_TRIANGLE: f32 = 4.0;

/// A corner of a part.
#[derive(Clone, Copy)]
enum Corner {
    /// A corner of the whole.
    Old(usize),
    /// The middle of the edge from this corner to the next.
    Middle(usize),
    /// The middle of a quad.
    Centre,
}

use Corner::{Centre, Middle, Old};

/// What an element is split into.
type Pattern = &'static [&'static [Corner]];

const QUAD: Pattern = &[
    &[Old(0), Middle(0), Centre, Middle(3)],
    &[Middle(0), Old(1), Middle(1), Centre],
    &[Centre, Middle(1), Old(2), Middle(2)],
    &[Middle(3), Centre, Middle(2), Old(3)],
];

/// By the edge that is cut first.
const QUAD_HALVES: [Pattern; 2] = [
    &[
        &[Old(0), Middle(0), Middle(2), Old(3)],
        &[Middle(0), Old(1), Old(2), Middle(2)],
    ],
    &[
        &[Old(0), Old(1), Middle(1), Middle(3)],
        &[Middle(3), Middle(1), Old(2), Old(3)],
    ],
];

const TRIANGLE: Pattern = &[
    &[Old(0), Middle(0), Middle(2)],
    &[Middle(0), Old(1), Middle(1)],
    &[Middle(2), Middle(1), Old(2)],
    &[Middle(1), Middle(2), Middle(0)],
];

/// By the edge that is cut.
const TRIANGLE_HALVES: [Pattern; 3] = [
    &[&[Old(0), Middle(0), Old(2)], &[Middle(0), Old(1), Old(2)]],
    &[&[Old(0), Old(1), Middle(1)], &[Old(0), Middle(1), Old(2)]],
    &[&[Old(0), Old(1), Middle(2)], &[Middle(2), Old(1), Old(2)]],
];

/// How to split a polygon: towards parts that are about as long as wide.
fn pattern(polygon: &Polygon) -> Pattern {
    let corners = polygon.corners();
    let count = corners.len();
    let length = |i: usize| corners[i].distance(corners[(i + 1) % count]);
    if count == 4 {
        let (first, second) = (length(0) + length(2), length(1) + length(3));
        if first >= LONG_QUAD * second {
            QUAD_HALVES[0]
        } else if second >= LONG_QUAD * first {
            QUAD_HALVES[1]
        } else {
            QUAD
        }
    } else {
        let longest = (1..3).fold(0, |most, i| if length(i) > length(most) { i } else { most });
        // Area is half of length times height.
        let squared = length(longest) * length(longest);
        if squared >= 2.0 * LONG_TRIANGLE * polygon.vector_area().length() {
            TRIANGLE_HALVES[longest]
        } else {
            TRIANGLE
        }
    }
}

impl Hierarchy {
    /// Splits the leaf element of node `id` 4:1, long ones 2:1 across.
    pub fn subdivide(&mut self, id: NodeId) {
        let parent = *self.element_of(id).expect("only elements are subdivided");
        debug_assert!(self.is_leaf(id));
        let pattern = pattern(&parent.polygon);
        let first = self.nodes.len() as NodeId;
        for &part in pattern {
            let mut points = [NONE; 4];
            for (point, &corner) in points.iter_mut().zip(part) {
                *point = self.point_of(&parent, corner);
            }
            let polygon = part_of(&parent.polygon, part);
            let shading = self.shading_of(&parent, part);
            self.push_element(
                Element {
                    points,
                    polygon,
                    shading,
                    level: parent.level + 1,
                    exposed: if parent.is_touched {
                        Exposed::ALL
                    } else {
                        parent.exposed
                    },
                    ..parent
                },
                id,
            );
        }
        // Until more is known, parts are as exposed as the whole.
        let share = self.node(id).area / parent.polygon.vector_area().length();
        let per_area = self.node(id).reflecting_area / self.node(id).area;
        for child in &mut self.nodes[first as usize..] {
            child.area *= share;
            child.reflecting_area = child.area * per_area;
        }
        let node = &mut self.nodes[id as usize];
        node.first_child = first;
        node.child_count = pattern.len() as u32;
    }

    /// The point of a part's corner, made if there is none.
    fn point_of(&mut self, parent: &Element, corner: Corner) -> u32 {
        let count = parent.corner_count();
        let points = parent.points;
        let mut middle = |i: usize| self.make_midpoint(points[i], points[(i + 1) % count]);
        match corner {
            Old(i) => points[i],
            Middle(i) => middle(i),
            Centre => {
                let (a, b) = (middle(0), middle(2));
                self.make_midpoint(a, b)
            }
        }
    }

    /// Shading normals of a part.
    fn shading_of(&mut self, parent: &Element, part: &[Corner]) -> u32 {
        if parent.shading == NONE {
            return NONE;
        }
        let all = self.shading_normals[parent.shading as usize];
        let count = parent.corner_count();
        let mean = |sum: Vec3| sum.normalize_or(parent.normal);
        let normal = |corner: Corner| match corner {
            Old(i) => all[i],
            Middle(i) => mean(all[i] + all[(i + 1) % count]),
            Centre => mean(all[0] + all[1] + all[2] + all[3]),
        };
        // Triangles repeat their first.
        let mut normals = [normal(part[0]); 4];
        for (slot, &corner) in normals.iter_mut().zip(part) {
            *slot = normal(corner);
        }
        self.shading_normals.push(normals);
        self.shading_normals.len() as u32 - 1
    }
}

/// The shape of a part.
fn part_of(polygon: &Polygon, part: &[Corner]) -> Polygon {
    let corners = polygon.corners();
    let place = |corner: Corner| match corner {
        Old(i) => corners[i],
        Middle(i) => (corners[i] + corners[(i + 1) % corners.len()]) * 0.5,
        Centre => polygon.centre(),
    };
    let mut places = [Vec3::ZERO; 4];
    for (slot, &corner) in places.iter_mut().zip(part) {
        *slot = place(corner);
    }
    Polygon::new(&places[..part.len()])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(corners: &[Vec3]) -> Vec<Polygon> {
        let whole = Polygon::new(corners);
        let parts = pattern(&whole).iter().map(|part| part_of(&whole, part));
        parts.collect()
    }

    #[test]
    fn parts_fill_the_whole_and_face_where_it_does() {
        let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        let shapes: [&[Vec3]; 7] = [
            &[at(0., 0.), at(1., 0.), at(1., 1.), at(0., 1.)],
            &[at(0., 0.), at(9., 0.), at(9., 1.), at(0., 1.)],
            &[at(0., 0.), at(1., 0.), at(2., 9.), at(0., 9.)],
            &[at(0., 0.), at(1., 0.), at(0., 1.)],
            &[at(0., 0.), at(9., 0.), at(0., 1.)],
            &[at(0., 0.), at(1., 0.), at(0., 9.)],
            &[at(9., 0.), at(1., 1.), at(0., 0.)],
        ];
        let counts = shapes.map(|shape| {
            let whole = Polygon::new(shape).vector_area();
            let parts = split(shape);
            let sum: Vec3 = parts.iter().map(Polygon::vector_area).sum();
            assert!((sum - whole).length() < 1e-5 * whole.length());
            assert!(parts.iter().all(|p| p.vector_area().dot(whole) > 0.0));
            parts.len()
        });
        assert_eq!(counts, [4, 2, 2, 4, 2, 2, 2]);
    }

    #[test]
    fn strips_end_as_squares() {
        let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        let mut parts = vec![Polygon::new(&[
            at(0., 0.),
            at(64., 0.),
            at(64., 1.),
            at(0., 1.),
        ])];
        for _ in 0..6 {
            parts = parts.iter().flat_map(|p| split(p.corners())).collect();
        }
        assert_eq!(parts.len(), 64);
        assert!(
            parts
                .iter()
                .all(|p| (p.radius() - 0.5f32.sqrt()).abs() < 1e-5)
        );
    }
}
