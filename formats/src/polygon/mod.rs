//! Polygons to triangles, for every format: ear clipping, holes joined to their outline by bridges.
//!
//! Two ways in, for two kinds of coordinates, and one algorithm behind them:
//!
//! - [`outline`] takes the f32 corners of a file as they stand. It looks along an axis, where areas of such corners
//!   come out (nearly) exact: what has an area is a triangle, however small, and a straight edge is straight to the
//!   last bit. What is no polygon comes out as a fan, for the scene's checks to name.
//! - [`with_holes`] takes f64 corners that transforms have rounded. It looks along the polygon's normal, and areas
//!   below a tolerance are none, or each corner on a straight edge would make a sliver.
//!
//! All corners stay corners, also those on a straight edge, so that neighbours that share them stay joined; and no
//! triangle without area comes out. Small polygons are cut into the roundest ears, since the shape of triangles shows
//! in the light of their corners.
//!
//! Cost: n log n in practice; up to 1024 corners, where ears are chosen, O(n²) with a small factor. An outline that
//! crosses itself everywhere costs O(n²) too.

mod ears;
mod holes;

use ears::Ring;
use glam::{DVec2, DVec3, Vec3};

/// Areas of transformed corners below this, relative to the polygon's extent squared, are zero.
const FLAT: f64 = 1e-13;

/// Triangles of a polygon.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Triangulation {
    /// Corners as numbers from 0 into the polygon, its loops one after the other; wound as the polygon is.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The polygon crosses itself: no triangulation is right, in this one triangles overlap or are missing.
    pub(crate) crossing: bool,
}

/// Triangulates the polygon `corners`, convex or not, planar or nearly so, seen from the side where it is wound
/// counter-clockwise.
///
/// A polygon without area, or with a corner that is not finite, comes out as a fan.
pub(crate) fn outline(corners: &[Vec3]) -> Triangulation {
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
    let flat: Vec<DVec2> = (0..count)
        .map(|index| {
            let p = relative(index);
            let (pair, along) = match size {
                _ if size.z >= size.x && size.z >= size.y => (p.truncate(), normal.z),
                _ if size.x >= size.y => (DVec2::new(p.y, p.z), normal.x),
                _ => (DVec2::new(p.z, p.x), normal.y),
            };
            if along > 0.0 {
                pair
            } else {
                DVec2::new(pair.y, pair.x)
            }
        })
        .collect();
    split_quad(&flat, 0.0)
        .unwrap_or_else(|| Ring::new(&flat, (0..count as u32).collect(), 0.0).clip())
}

/// Triangulates a polygon with holes; `loops[0]` is the outline, counter-clockwise around `front`, the others are holes
/// in it, wound either way.
pub(crate) fn with_holes(loops: &[Vec<DVec3>], front: DVec3) -> Triangulation {
    let points = project(loops, front);
    let sizes: Vec<usize> = loops.iter().map(Vec::len).collect();
    let Some((&outline, holes)) = sizes.split_first() else {
        return Triangulation {
            triangles: Vec::new(),
            crossing: false,
        };
    };
    let quad = split_quad(&points, FLAT).filter(|_| holes.is_empty());
    quad.unwrap_or_else(|| {
        let ring = holes::join(outline, holes, &points);
        let corners = ring.into_iter().map(|corner| corner as u32).collect();
        Ring::new(&points, corners, FLAT).clip()
    })
}

/// A quadrilateral cut from corner 0 to corner 2 where that is right, else from 1 to 3; `None` for any other polygon.
fn split_quad(points: &[DVec2], flat: f64) -> Option<Triangulation> {
    let &[a, b, c, d] = points else { return None };
    let triangles = if turn(a, b, c) > flat && turn(a, c, d) > flat {
        vec![[0, 1, 2], [0, 2, 3]]
    } else if turn(b, c, d) > flat && turn(b, d, a) > flat {
        vec![[1, 2, 3], [1, 3, 0]]
    } else {
        return None;
    };
    Some(Triangulation {
        triangles,
        crossing: false,
    })
}

/// Coordinates in the polygon's plane, of extent about 1.
fn project(loops: &[Vec<DVec3>], front: DVec3) -> Vec<DVec2> {
    let (u, v) = front.any_orthonormal_pair();
    let origin = loops
        .first()
        .and_then(|corners| corners.first())
        .copied()
        .unwrap_or_default();
    let flat = |point: &DVec3| DVec2::new((point - origin).dot(u), (point - origin).dot(v));
    let mut points: Vec<DVec2> = loops.iter().flatten().map(flat).collect();
    let extent = points
        .iter()
        .fold(0.0, |most: f64, point| most.max(point.abs().max_element()));
    if extent > 0.0 {
        points.iter_mut().for_each(|point| *point /= extent);
    }
    points
}

/// Twice the area of a triangle, positive counter-clockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(loops: &[&[[f64; 2]]]) -> Vec<Vec<DVec3>> {
        loops
            .iter()
            .map(|l| l.iter().map(|p| DVec3::new(p[0], p[1], 0.0)).collect())
            .collect()
    }

    /// Area of the triangles, all of which must face the front.
    fn area(loops: &[Vec<DVec3>]) -> f64 {
        let split = with_holes(loops, DVec3::Z);
        assert!(!split.crossing);
        let points: Vec<DVec3> = loops.iter().flatten().copied().collect();
        let areas = split.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|index| points[index as usize]);
            let area = (b - a).cross(c - a).z / 2.0;
            assert!(area > 0.0, "{t:?}");
            area
        });
        areas.sum()
    }

    #[test]
    fn concave_collinear_and_holed() {
        let l = flat(&[&[
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ]]);
        assert!((area(&l) - 3.0).abs() < 1e-12);
        // Corners on straight edges stay corners.
        let square = flat(&[&[
            [0.0, 0.0],
            [0.5, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 1.0],
            [0.0, 0.5],
        ]]);
        assert!((area(&square) - 1.0).abs() < 1e-12);
        assert_eq!(with_holes(&square, DVec3::Z).triangles.len(), 4);
        let dart = flat(&[&[[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.0, 1.0]]]);
        assert!((area(&dart) - 1.0).abs() < 1e-12);
        let hole_a = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]];
        let hole_b = [[3.0, 1.0], [4.0, 1.0], [4.0, 2.0], [3.0, 2.0]];
        let hole_c = [[1.0, 3.0], [4.0, 3.0], [4.0, 4.0]];
        let holed = flat(&[
            &[[0.0, 0.0], [5.0, 0.0], [5.0, 5.0], [0.0, 5.0]],
            &hole_b,
            &hole_a,
            &hole_c,
        ]);
        assert!((area(&holed) - 21.5).abs() < 1e-12);
    }

    #[test]
    fn a_hole_written_as_a_seam() {
        let seam = flat(&[&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ]]);
        assert!((area(&seam) - 8.0).abs() < 1e-12);
    }

    #[test]
    fn a_comb_of_many_transformed_teeth() {
        let teeth = 100;
        let mut comb = vec![DVec3::new(f64::from(teeth), -1.0, 0.0)];
        for i in (0..teeth).rev() {
            comb.push(DVec3::new(f64::from(i) + 0.75, 1.0, 0.0));
            comb.push(DVec3::new(f64::from(i) + 0.25, 0.0, 0.0));
        }
        comb.push(DVec3::new(0.0, -1.0, 0.0));
        let loops = vec![comb];
        let exact = holes::signed_area(
            &(0..loops[0].len()).collect::<Vec<_>>(),
            &loops[0].iter().map(|p| p.truncate()).collect::<Vec<_>>(),
        ) / 2.0;
        assert!((area(&loops) - exact).abs() < 1e-9 * exact);
    }

    #[test]
    fn crossed_polygons_end() {
        let bow = flat(&[&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]]);
        with_holes(&bow, DVec3::Z);
        let outside = flat(&[
            &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            &[[5.0, 5.0], [6.0, 5.0], [5.0, 6.0]],
        ]);
        with_holes(&outside, DVec3::Z);
    }

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
            let result = outline(&corners);
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
        let result = outline(&corners);
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
        let result = outline(&corners);
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
        assert!(outline(&bow).crossing);
    }

    #[test]
    fn a_corner_written_twice_and_a_spike_are_no_fault() {
        let points = [
            (0.0, 0.0),
            (3.0, 0.0),
            (3.0, 0.0),
            (3.0, 2.0),
            (1.0, 2.0),
            (5.0, 2.0),
            (0.0, 2.0),
        ];
        for start in 0..points.len() {
            let mut corners = points.map(|(x, y)| Vec3::new(x, y, 0.0));
            corners.rotate_left(start);
            let result = outline(&corners);
            let (sum, least) = areas(&corners, &result);
            assert!(
                !result.crossing && sum == 6.0 && least > 0.0,
                "start {start}: {result:?}"
            );
        }
    }

    /// Two numbers without order within 0..1.
    fn scattered(index: u32) -> (f64, f64) {
        let hash = u64::from(index)
            .wrapping_add(1)
            .wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let hash = (hash ^ hash >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (
            f64::from((hash >> 32) as u32) / 4_294_967_296.0,
            f64::from(hash as u32) / 4_294_967_296.0,
        )
    }

    #[test]
    fn no_corner_lies_in_a_triangle() {
        let count = 300;
        let corners: Vec<Vec3> = (0..count)
            .map(|i| {
                let (y, x) = (std::f64::consts::TAU * f64::from(i) / f64::from(count)).sin_cos();
                (DVec3::new(x, y, 0.0) * (0.3 + scattered(i).0)).as_vec3()
            })
            .collect();
        let result = outline(&corners);
        let (_, least) = areas(&corners, &result);
        assert!(!result.crossing && least > 0.0 && result.triangles.len() == corners.len() - 2);
        for triangle in &result.triangles {
            let [a, b, c] = triangle.map(|i| corners[i as usize].as_dvec3().truncate());
            let inside = corners
                .iter()
                .map(|p| p.as_dvec3().truncate())
                .find(|&p| turn(a, b, p) > 0.0 && turn(b, c, p) > 0.0 && turn(c, a, p) > 0.0);
            assert_eq!(inside, None, "{triangle:?}");
        }
    }

    #[test]
    fn a_scribble_ends_soon() {
        let corners: Vec<Vec3> = (0..20_000)
            .map(|i| {
                let (x, y) = scattered(i);
                Vec3::new(x as f32, y as f32, 0.0)
            })
            .collect();
        // Helped on to the end, it would take minutes and make some 9,000 triangles.
        let result = outline(&corners);
        assert!(result.crossing && result.triangles.len() < 1000);
    }
}
