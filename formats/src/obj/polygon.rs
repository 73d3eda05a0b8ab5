//! Polygons to triangles: ear clipping, with a space-filling curve over large polygons so that an ear looks at its
//! neighbourhood only (the idea of the `earcut` library). No triangle without area comes out.

use glam::{DVec3, Vec3};

/// Corners as numbers from 0 into the polygon, wound as the polygon is.
pub(super) struct Triangulation {
    pub triangles: Vec<[u32; 3]>,
    /// The outline crosses itself: no triangulation is right, this one covers its corners.
    pub crossing: bool,
}

/// Triangulates the polygon `corners`, convex or not, planar or nearly so.
///
/// Convex quadrilaterals are cut from corner 0 to corner 2. Corners on a straight edge stay corners of a triangle.
/// A polygon without area, or with a corner that is not finite, comes out as a fan, for the scene's checks to refuse.
/// Cost: n log n in practice.
pub(super) fn triangulate(corners: &[Vec3]) -> Triangulation {
    let count = corners.len();
    let fan = || Triangulation {
        triangles: (2..count as u32)
            .map(|corner| [0, corner - 1, corner])
            .collect(),
        crossing: false,
    };
    if count <= 3 || !corners.iter().all(|p| p.is_finite()) {
        return fan();
    }
    let origin = corners[0].as_dvec3();
    let relative = |index: usize| corners[index % count].as_dvec3() - origin;
    let normal = (1..count)
        .map(|i| relative(i).cross(relative(i + 1)))
        .sum::<DVec3>();
    if normal.length_squared() == 0.0 {
        // As much of it is wound one way as the other: a bow tie, or nothing at all.
        let crossing = (1..count).any(|i| relative(i).cross(relative(i + 1)) != DVec3::ZERO);
        return Triangulation { crossing, ..fan() };
    }
    // Seen along the axis that the normal is nearest to, counter-clockwise.
    let size = normal.abs();
    let flat: Vec<[f64; 2]> = (0..count)
        .map(|index| {
            let p = relative(index);
            let (pair, along) = match size {
                _ if size.z >= size.x && size.z >= size.y => ([p.x, p.y], normal.z),
                _ if size.x >= size.y => ([p.y, p.z], normal.x),
                _ => ([p.z, p.x], normal.y),
            };
            if along > 0.0 {
                pair
            } else {
                [pair[1], pair[0]]
            }
        })
        .collect();
    if count == 4 {
        let positive = |a: usize, b: usize, c: usize| area(flat[a], flat[b], flat[c]) > 0.0;
        if positive(0, 1, 2) && positive(0, 2, 3) {
            return fan();
        }
        if positive(1, 2, 3) && positive(1, 3, 0) {
            return Triangulation {
                triangles: vec![[1, 2, 3], [1, 3, 0]],
                crossing: false,
            };
        }
    }
    Ring::new(flat).clip()
}

/// Twice the area of a triangle; positive when counter-clockwise.
fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}

/// What is left of the polygon: linked lists along the outline and along the curve.
struct Ring {
    points: Vec<[f64; 2]>,
    previous: Vec<u32>,
    next: Vec<u32>,
    /// Place on the curve, and the neighbours along it among the corners that are left.
    code: Vec<u64>,
    lower: Vec<Option<u32>>,
    higher: Vec<Option<u32>>,
    low: [f64; 2],
    /// Cells of the curve per unit of length.
    scale: f64,
}

/// Cells of the curve along each axis.
const CELLS: f64 = 65535.0;

impl Ring {
    fn new(points: Vec<[f64; 2]>) -> Self {
        let count = points.len() as u32;
        let fold = |start: f64, pick: fn(f64, f64) -> f64, axis: usize| {
            points.iter().map(|p| p[axis]).fold(start, pick)
        };
        let low = [
            fold(f64::INFINITY, f64::min, 0),
            fold(f64::INFINITY, f64::min, 1),
        ];
        let high = [
            fold(f64::NEG_INFINITY, f64::max, 0),
            fold(f64::NEG_INFINITY, f64::max, 1),
        ];
        let extent = (high[0] - low[0]).max(high[1] - low[1]);
        let scale = if extent > 0.0 { CELLS / extent } else { 0.0 };
        let mut ring = Self {
            previous: (0..count).map(|i| (i + count - 1) % count).collect(),
            next: (0..count).map(|i| (i + 1) % count).collect(),
            code: Vec::new(),
            lower: vec![None; points.len()],
            higher: vec![None; points.len()],
            low,
            scale,
            points,
        };
        ring.code = ring.points.iter().map(|&p| ring.curve(p)).collect();
        let mut order: Vec<u32> = (0..count).collect();
        order.sort_by_key(|&i| (ring.code[i as usize], i));
        for pair in order.windows(2) {
            ring.higher[pair[0] as usize] = Some(pair[1]);
            ring.lower[pair[1] as usize] = Some(pair[0]);
        }
        ring
    }

    /// Place of a point on the Z-shaped curve. It grows with either coordinate: the codes of a box's two corners
    /// enclose those of all points in it.
    fn curve(&self, p: [f64; 2]) -> u64 {
        let spread = |axis: usize| {
            let mut x = ((p[axis] - self.low[axis]) * self.scale) as u64 & 0xFFFF;
            x = (x | x << 8) & 0x00FF_00FF;
            x = (x | x << 4) & 0x0F0F_0F0F;
            x = (x | x << 2) & 0x3333_3333;
            (x | x << 1) & 0x5555_5555
        };
        spread(0) | spread(1) << 1
    }

    fn neighbours(&self, corner: u32) -> [u32; 3] {
        [
            self.previous[corner as usize],
            corner,
            self.next[corner as usize],
        ]
    }

    /// Twice the area of the triangle that `corner` makes with its neighbours.
    fn corner_area(&self, corner: u32) -> f64 {
        let [a, b, c] = self.neighbours(corner).map(|i| self.points[i as usize]);
        area(a, b, c)
    }

    /// True when the triangle at `corner` can be cut off: it has an area and no other corner lies in it.
    fn is_ear(&self, corner: u32) -> bool {
        if self.corner_area(corner) <= 0.0 {
            return false;
        }
        let ear = self.neighbours(corner);
        let [a, b, c] = ear.map(|i| self.points[i as usize]);
        let least = self.curve([a[0].min(b[0]).min(c[0]), a[1].min(b[1]).min(c[1])]);
        let most = self.curve([a[0].max(b[0]).max(c[0]), a[1].max(b[1]).max(c[1])]);
        let blocks = |other: u32| {
            let p = self.points[other as usize];
            // A corner at the same place as one of the triangle's is the other end of a cut to a hole.
            p != a
                && p != b
                && p != c
                && area(a, b, p) >= 0.0
                && area(b, c, p) >= 0.0
                && area(c, a, p) >= 0.0
                && self.corner_area(other) <= 0.0
        };
        let up = std::iter::successors(self.higher[corner as usize], |&i| self.higher[i as usize]);
        let down = std::iter::successors(self.lower[corner as usize], |&i| self.lower[i as usize]);
        !up.take_while(|&i| self.code[i as usize] <= most)
            .any(blocks)
            && !down
                .take_while(|&i| self.code[i as usize] >= least)
                .any(blocks)
    }

    fn remove(&mut self, corner: u32) {
        let at = corner as usize;
        let (previous, next) = (self.previous[at], self.next[at]);
        self.next[previous as usize] = next;
        self.previous[next as usize] = previous;
        if let Some(lower) = self.lower[at] {
            self.higher[lower as usize] = self.higher[at];
        }
        if let Some(higher) = self.higher[at] {
            self.lower[higher as usize] = self.lower[at];
        }
    }

    fn clip(mut self) -> Triangulation {
        let mut left = self.points.len();
        let mut triangles = Vec::with_capacity(left - 2);
        let mut crossing = false;
        // Corners seen since the last one that was cut off.
        let mut seen = 0;
        let mut corner = 0;
        while left >= 3 {
            if self.is_ear(corner) {
                triangles.push(self.neighbours(corner));
                self.remove(corner);
                left -= 1;
                seen = 0;
                // Not the neighbour at once: every second corner keeps the triangles compact.
                corner = self.next[self.next[corner as usize] as usize];
                continue;
            }
            corner = self.next[corner as usize];
            seen += 1;
            if seen > left {
                let around = std::iter::successors(Some(corner), |&i| Some(self.next[i as usize]))
                    .take(left);
                let (straight, convex) = around.fold((None, None), |(straight, convex), i| {
                    let area = self.corner_area(i);
                    (
                        straight.or((area == 0.0).then_some(i)),
                        convex.or((area > 0.0).then_some(i)),
                    )
                });
                // Without an ear, a corner on a straight line can go; if there is none, the outline crosses itself.
                let Some(victim) = straight.or(convex) else {
                    break;
                };
                if straight.is_none() {
                    crossing = true;
                    triangles.push(self.neighbours(victim));
                }
                corner = self.next[victim as usize];
                self.remove(victim);
                left -= 1;
                seen = 0;
            }
        }
        Triangulation {
            triangles,
            crossing: crossing || left >= 3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas(corners: &[Vec3], result: &Triangulation) -> (f64, f64) {
        let mut sums = (0.0, f64::INFINITY);
        for triangle in &result.triangles {
            let [a, b, c] = triangle.map(|i| corners[i as usize].as_dvec3());
            let one = (b - a).cross(c - a).z * 0.5;
            sums = (sums.0 + one, sums.1.min(one));
        }
        sums
    }

    #[test]
    fn a_concave_polygon_is_covered_once() {
        let arrow =
            [(0.0, 0.0), (4.0, 4.0), (0.0, 1.0), (-4.0, 4.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
        for start in 0..4 {
            let mut corners = arrow;
            corners.rotate_left(start);
            let result = triangulate(&corners);
            let (sum, least) = areas(&corners, &result);
            assert!(
                !result.crossing && result.triangles.len() == 2 && sum == 4.0 && least > 0.0,
                "start {start}"
            );
        }
    }

    #[test]
    fn corners_on_straight_edges_stay_corners() {
        let corners: Vec<Vec3> = [
            (0, 0),
            (1, 0),
            (2, 0),
            (3, 0),
            (3, 3),
            (2, 3),
            (1, 3),
            (0, 3),
        ]
        .map(|(x, y)| Vec3::new(x as f32, y as f32, 0.0))
        .to_vec();
        let result = triangulate(&corners);
        let (sum, least) = areas(&corners, &result);
        assert!(!result.crossing && result.triangles.len() == 6 && sum == 9.0 && least > 0.0);
    }

    #[test]
    fn a_comb_with_many_teeth_is_covered_once() {
        let teeth = 500;
        let mut corners = vec![
            Vec3::new(0.0, -1.0, 0.0),
            Vec3::new(2.0 * teeth as f32, -1.0, 0.0),
        ];
        for tooth in (0..teeth).rev() {
            corners.push(Vec3::new(2.0 * tooth as f32 + 2.0, 0.0, 0.0));
            corners.push(Vec3::new(2.0 * tooth as f32 + 1.0, 5.0, 0.0));
        }
        corners.push(Vec3::ZERO);
        let result = triangulate(&corners);
        let (sum, least) = areas(&corners, &result);
        // A bar of 1 by 2 teeth wide, and triangles of area 5.
        assert!(
            !result.crossing && least > 0.0 && sum == (2 * teeth + 5 * teeth) as f64,
            "{sum} {least}"
        );
        assert_eq!(result.triangles.len(), corners.len() - 2);
    }

    #[test]
    fn an_outline_that_crosses_itself_is_noticed() {
        let bow =
            [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 3.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
        assert!(triangulate(&bow).crossing);
    }
}
