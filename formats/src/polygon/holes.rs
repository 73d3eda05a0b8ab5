//! Holes become part of the outline: a bridge leads to each of them and back.

use super::{FLAT, turn};
use glam::DVec2;

/// The outline with all holes in it, as numbers into `points`: the first `outline` of them, then each of the `holes`,
/// wound either way.
pub(super) fn join(outline: usize, holes: &[usize], points: &[DVec2]) -> Vec<usize> {
    let mut ring: Vec<usize> = (0..outline).collect();
    let mut start = outline;
    let mut loops: Vec<Vec<usize>> = Vec::new();
    for &count in holes {
        let mut hole: Vec<usize> = (start..start + count).collect();
        start += count;
        if signed_area(&hole, points) > 0.0 {
            hole.reverse();
        }
        rotate_to_leftmost(&mut hole, points);
        loops.push(hole);
    }
    loops.sort_by(|a, b| points[a[0]].x.total_cmp(&points[b[0]].x));
    for at in 0..loops.len() {
        bridge(&mut ring, &loops[at..], points);
    }
    ring
}

/// Twice the area of a ring, positive counter-clockwise.
pub(super) fn signed_area(ring: &[usize], points: &[DVec2]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter()
        .zip(next)
        .map(|(&a, &b)| points[a].perp_dot(points[b]))
        .sum()
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
