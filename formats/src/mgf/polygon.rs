//! Polygons to triangles: concave ones by ear clipping, holes by a bridge to their outline.
//!
//! All corners stay corners, also those on a straight edge, so that neighbours that share them stay joined.
//! Cost: O(n²) for each triangle at worst, less where the first ears are good.

use glam::{DVec2, DVec3};

/// Areas below this, relative to the polygon's extent squared, are zero.
const FLAT: f64 = 1e-13;
/// Up to so many corners the best of all ears is taken, beyond the first good one.
const EXHAUSTIVE: usize = 64;

/// Triangles of a polygon.
pub(super) struct Triangulation {
    /// Corners as indices into the concatenated loops.
    pub(super) triangles: Vec<[usize; 3]>,
    /// False: the polygon crosses itself and a part of it is missing.
    pub(super) complete: bool,
}

/// Splits a polygon; `loops[0]` is the outline, counter-clockwise around `front`, the others are holes in it.
pub(super) fn triangulate(loops: &[Vec<DVec3>], front: DVec3) -> Triangulation {
    let points = project(loops, front);
    let outline = loops.first().map_or(0, Vec::len);
    let mut ring: Vec<usize> = (0..outline).collect();
    if loops.len() == 1 && outline == 4 && is_convex_quad(&points) {
        return Triangulation {
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            complete: true,
        };
    }
    let mut start = outline;
    let mut holes: Vec<Vec<usize>> = Vec::new();
    for corners in &loops[1.min(loops.len())..] {
        let mut hole: Vec<usize> = (start..start + corners.len()).collect();
        start += corners.len();
        if signed_area(&hole, &points) > 0.0 {
            hole.reverse();
        }
        rotate_to_leftmost(&mut hole, &points);
        holes.push(hole);
    }
    holes.sort_by(|a, b| points[a[0]].x.total_cmp(&points[b[0]].x));
    for at in 0..holes.len() {
        bridge(&mut ring, &holes[at..], &points);
    }
    clip(ring, &points)
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

fn signed_area(ring: &[usize], points: &[DVec2]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter()
        .zip(next)
        .map(|(&a, &b)| points[a].perp_dot(points[b]))
        .sum()
}

fn is_convex_quad(points: &[DVec2]) -> bool {
    (0..4).all(|i| turn(points[i], points[(i + 1) % 4], points[(i + 2) % 4]) > FLAT)
}

fn rotate_to_leftmost(hole: &mut [usize], points: &[DVec2]) {
    let order = |a: usize, b: usize| {
        points[a]
            .x
            .total_cmp(&points[b].x)
            .then(points[a].y.total_cmp(&points[b].y))
    };
    if let Some(leftmost) = (0..hole.len()).min_by(|&a, &b| order(hole[a], hole[b])) {
        hole.rotate_left(leftmost);
    }
}

/// Joins `holes[0]`, which starts at its leftmost corner, to the ring at the nearest corner in sight. The other
/// holes only block the view.
fn bridge(ring: &mut Vec<usize>, holes: &[Vec<usize>], points: &[DVec2]) {
    let hole = &holes[0];
    let target = points[hole[0]];
    let mut nearest: Vec<usize> = (0..ring.len()).collect();
    nearest.sort_by(|&a, &b| {
        let distance = |at: usize| points[ring[at]].distance_squared(target);
        distance(a).total_cmp(&distance(b))
    });
    let visible = |&at: &usize| {
        let from = points[ring[at]];
        in_cone(ring, at, target, points)
            && in_cone(hole, 0, from, points)
            && std::iter::once(&*ring)
                .chain(holes)
                .all(|edges| !crosses_any(from, target, edges, points))
    };
    // Something is in sight of a hole that lies inside; of any other, the nearest corner has to do.
    let Some(at) = nearest
        .iter()
        .copied()
        .find(visible)
        .or(nearest.first().copied())
    else {
        return;
    };
    let seam: Vec<usize> = hole.iter().copied().chain([hole[0], ring[at]]).collect();
    ring.splice(at + 1..at + 1, seam);
}

/// True when `target` lies on the inner side of the two edges that meet at `ring[at]`.
fn in_cone(ring: &[usize], at: usize, target: DVec2, points: &[DVec2]) -> bool {
    let count = ring.len();
    let (before, here, after) = (
        points[ring[(at + count - 1) % count]],
        points[ring[at]],
        points[ring[(at + 1) % count]],
    );
    if turn(before, here, after) >= 0.0 {
        turn(here, target, before) > 0.0 && turn(target, here, after) > 0.0
    } else {
        !(turn(here, target, after) >= 0.0 && turn(target, here, before) >= 0.0)
    }
}

fn crosses_any(p: DVec2, q: DVec2, ring: &[usize], points: &[DVec2]) -> bool {
    let next = ring.iter().cycle().skip(1);
    ring.iter()
        .zip(next)
        .any(|(&a, &b)| crosses(p, q, points[a], points[b]))
}

/// True when an edge touches a segment elsewhere than at the segment's ends.
fn crosses(p: DVec2, q: DVec2, a: DVec2, b: DVec2) -> bool {
    let within = |point: DVec2| {
        point != p
            && point != q
            && turn(p, q, point).abs() <= FLAT
            && (p - point).dot(q - point) < 0.0
    };
    if within(a) || within(b) {
        return true;
    }
    if a == p || a == q || b == p || b == q {
        return false;
    }
    (turn(p, q, a) > 0.0) != (turn(p, q, b) > 0.0) && (turn(a, b, p) > 0.0) != (turn(a, b, q) > 0.0)
}

/// Cuts ears until nothing is left.
fn clip(mut ring: Vec<usize>, points: &[DVec2]) -> Triangulation {
    let mut triangles = Vec::with_capacity(ring.len().saturating_sub(2));
    let mut from = 0;
    while ring.len() >= 3 {
        let best =
            find_ear(&ring, points, from, true).or_else(|| find_ear(&ring, points, from, false));
        if let Some(at) = best {
            triangles.push(corners(&ring, at));
            ring.remove(at);
            from = at;
        } else if let Some(at) =
            (0..ring.len()).find(|&at| area_at(&ring, at, points).abs() <= FLAT)
        {
            // A corner on a straight line, or the tip of a spike without area.
            ring.remove(at);
        } else {
            return Triangulation {
                triangles,
                complete: false,
            };
        }
    }
    Triangulation {
        triangles,
        complete: true,
    }
}

fn corners(ring: &[usize], at: usize) -> [usize; 3] {
    let count = ring.len();
    [
        ring[(at + count - 1) % count],
        ring[at],
        ring[(at + 1) % count],
    ]
}

fn area_at(ring: &[usize], at: usize, points: &[DVec2]) -> f64 {
    let [a, b, c] = corners(ring, at).map(|index| points[index]);
    turn(a, b, c)
}

/// The ring position of the roundest ear. `strict`: no other corner may touch it; else, none may lie inside.
fn find_ear(ring: &[usize], points: &[DVec2], from: usize, strict: bool) -> Option<usize> {
    let good_enough = match ring.len() {
        0..=EXHAUSTIVE => f64::INFINITY,
        65..=1024 => 0.1,
        _ => 0.0,
    };
    let mut best = None;
    let mut best_quality = 0.0;
    for at in (0..ring.len()).map(|offset| (from + offset) % ring.len()) {
        let [a, b, c] = corners(ring, at).map(|index| points[index]);
        let area = turn(a, b, c);
        let longest = a
            .distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a));
        if area <= FLAT || area / longest <= best_quality {
            continue;
        }
        let margin = if strict { -FLAT } else { FLAT };
        let blocks = |&index: &usize| {
            let p = points[index];
            p != a
                && p != b
                && p != c
                && turn(a, b, p) >= margin
                && turn(b, c, p) >= margin
                && turn(c, a, p) >= margin
        };
        if !ring.iter().any(blocks) {
            (best, best_quality) = (Some(at), area / longest);
            if best_quality > good_enough {
                break;
            }
        }
    }
    best
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
        let split = triangulate(loops, DVec3::Z);
        assert!(split.complete);
        let points: Vec<DVec3> = loops.iter().flatten().copied().collect();
        let areas = split.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|index| points[index]);
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
        assert_eq!(triangulate(&square, DVec3::Z).triangles.len(), 4);
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
    fn a_comb_of_many_teeth() {
        let teeth = 100;
        let mut comb = vec![DVec3::new(f64::from(teeth), -1.0, 0.0)];
        for i in (0..teeth).rev() {
            comb.push(DVec3::new(f64::from(i) + 0.75, 1.0, 0.0));
            comb.push(DVec3::new(f64::from(i) + 0.25, 0.0, 0.0));
        }
        comb.push(DVec3::new(0.0, -1.0, 0.0));
        let loops = vec![comb];
        let exact = signed_area(
            &(0..loops[0].len()).collect::<Vec<_>>(),
            &loops[0].iter().map(|p| p.truncate()).collect::<Vec<_>>(),
        ) / 2.0;
        assert!((area(&loops) - exact).abs() < 1e-9 * exact);
    }

    #[test]
    fn crossed_polygons_end() {
        let bow = flat(&[&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]]);
        triangulate(&bow, DVec3::Z);
        let outside = flat(&[
            &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            &[[5.0, 5.0], [6.0, 5.0], [5.0, 6.0]],
        ]);
        triangulate(&outside, DVec3::Z);
    }
}
