//! Cuts ears off one closed outline until nothing is left of it.

use super::{Triangulation, turn};
use glam::DVec2;

/// Up to so many corners the best of all ears is taken, beyond the first good one.
const EXHAUSTIVE: usize = 64;
/// Beyond so many corners any ear is good.
const ANY_EAR: usize = 1024;
/// An ear's area, relative to the square of its longest side, that is good.
const GOOD: f64 = 0.1;
/// So often an outline that crosses itself is helped on; what is left of a scribble then is left out.
const FORCED: u32 = 64;
/// Cells of the curve along each axis.
const CELLS: f64 = 65535.0;

/// What is left of the polygon: linked lists along the outline and along a Z-shaped curve over the plane, so that an
/// ear looks at its neighbourhood only (the idea of the `earcut` library).
pub(super) struct Ring<'a> {
    points: &'a [DVec2],
    /// Areas up to this are none.
    flat: f64,
    /// Corner of the polygon at each place of the outline: a cut to a hole passes its ends twice.
    corner: Vec<u32>,
    previous: Vec<u32>,
    next: Vec<u32>,
    /// Place on the curve, and the neighbours along it among those that are left.
    code: Vec<u64>,
    lower: Vec<Option<u32>>,
    higher: Vec<Option<u32>>,
    low: DVec2,
    /// Cells of the curve per unit of length.
    scale: f64,
}

impl<'a> Ring<'a> {
    /// The outline through these `corners`, which are numbers into `points`.
    pub(super) fn new(points: &'a [DVec2], corners: Vec<u32>, flat: f64) -> Self {
        let count = corners.len() as u32;
        let (low, high) = points.iter().fold(
            (DVec2::INFINITY, DVec2::NEG_INFINITY),
            |(low, high), &point| (low.min(point), high.max(point)),
        );
        let extent = (high - low).max_element();
        let mut ring = Self {
            points,
            flat,
            previous: (0..count).map(|i| (i + count - 1) % count).collect(),
            next: (0..count).map(|i| (i + 1) % count).collect(),
            code: Vec::new(),
            lower: vec![None; corners.len()],
            higher: vec![None; corners.len()],
            low,
            scale: if extent > 0.0 { CELLS / extent } else { 0.0 },
            corner: corners,
        };
        ring.code = (0..count).map(|at| ring.curve(ring.point(at))).collect();
        let mut order: Vec<u32> = (0..count).collect();
        order.sort_by_key(|&at| (ring.code[at as usize], at));
        for pair in order.windows(2) {
            ring.higher[pair[0] as usize] = Some(pair[1]);
            ring.lower[pair[1] as usize] = Some(pair[0]);
        }
        ring
    }

    /// Place of a point on the curve. It grows with either coordinate: the codes of a box's two corners enclose those
    /// of all points in it.
    fn curve(&self, point: DVec2) -> u64 {
        let cell = ((point - self.low) * self.scale).min(DVec2::splat(CELLS));
        let spread = |coordinate: f64| {
            // What lies below the outline's box counts as on its border.
            let mut x = coordinate as u64;
            x = (x | x << 8) & 0x00FF_00FF;
            x = (x | x << 4) & 0x0F0F_0F0F;
            x = (x | x << 2) & 0x3333_3333;
            (x | x << 1) & 0x5555_5555
        };
        spread(cell.x) | spread(cell.y) << 1
    }

    fn point(&self, at: u32) -> DVec2 {
        self.points[self.corner[at as usize] as usize]
    }

    fn neighbours(&self, at: u32) -> [u32; 3] {
        [self.previous[at as usize], at, self.next[at as usize]]
    }

    fn triangle(&self, at: u32) -> [u32; 3] {
        self.neighbours(at).map(|at| self.corner[at as usize])
    }

    /// Twice the area of the triangle at `at`.
    fn area(&self, at: u32) -> f64 {
        let [a, b, c] = self.neighbours(at).map(|at| self.point(at));
        turn(a, b, c)
    }

    /// The places that are left, from `from` on.
    fn around(&self, from: u32, left: usize) -> impl Iterator<Item = u32> {
        std::iter::successors(Some(from), |&at| Some(self.next[at as usize])).take(left)
    }

    /// True when no other corner lies in the triangle at `at`. `strict`: none touches it either.
    fn is_free(&self, at: u32, strict: bool) -> bool {
        let [a, b, c] = self.neighbours(at).map(|at| self.point(at));
        let reach = DVec2::splat(self.flat);
        let least = self.curve(a.min(b).min(c) - reach);
        let most = self.curve(a.max(b).max(c) + reach);
        let holds = |a: DVec2, b: DVec2, p: DVec2| {
            let area = turn(a, b, p);
            if strict {
                area >= -self.flat
            } else {
                area > self.flat
            }
        };
        let blocks = |other: u32| {
            let p = self.point(other);
            // A corner at the same place as one of the triangle's is the other end of a cut to a hole.
            p != a && p != b && p != c && holds(a, b, p) && holds(b, c, p) && holds(c, a, p)
        };
        let up = std::iter::successors(self.higher[at as usize], |&i| self.higher[i as usize]);
        let down = std::iter::successors(self.lower[at as usize], |&i| self.lower[i as usize]);
        !up.take_while(|&i| self.code[i as usize] <= most)
            .any(blocks)
            && !down
                .take_while(|&i| self.code[i as usize] >= least)
                .any(blocks)
    }

    /// The roundest ear of small outlines, a good one of larger ones.
    fn ear(&self, from: u32, left: usize, strict: bool) -> Option<u32> {
        let good_enough = if left <= EXHAUSTIVE {
            f64::INFINITY
        } else if left <= ANY_EAR {
            GOOD
        } else {
            0.0
        };
        let mut best = None;
        let mut best_quality = 0.0;
        for at in self.around(from, left) {
            let [a, b, c] = self.neighbours(at).map(|at| self.point(at));
            let area = turn(a, b, c);
            let longest = a
                .distance_squared(b)
                .max(b.distance_squared(c))
                .max(c.distance_squared(a));
            let quality = area / longest;
            if area > self.flat && quality > best_quality && self.is_free(at, strict) {
                (best, best_quality) = (Some(at), quality);
                if quality > good_enough {
                    break;
                }
            }
        }
        best
    }

    fn remove(&mut self, at: u32) {
        let [previous, _, next] = self.neighbours(at);
        self.next[previous as usize] = next;
        self.previous[next as usize] = previous;
        let (lower, higher) = (self.lower[at as usize], self.higher[at as usize]);
        if let Some(lower) = lower {
            self.higher[lower as usize] = higher;
        }
        if let Some(higher) = higher {
            self.lower[higher as usize] = lower;
        }
    }

    /// True where cutting off takes no area away: on a `straight` edge, or else at the tip of a spike; a corner that
    /// stands twice counts as one.
    fn is_flat(&self, at: u32, straight: bool) -> bool {
        let [a, b, c] = self.neighbours(at).map(|at| self.point(at));
        turn(a, b, c).abs() <= self.flat && ((b - a).dot(c - b) > 0.0) == straight
    }

    /// What to cut off next, if the outline does not cross itself: an ear that nothing touches, what is no part of the
    /// area, an ear that something touches, and only then a corner that neighbours may share.
    fn next_cut(&self, from: u32, left: usize) -> Option<u32> {
        let flat = |straight: bool| {
            self.around(from, left)
                .find(|&at| self.is_flat(at, straight))
        };
        self.ear(from, left, true)
            .or_else(|| flat(false))
            .or_else(|| self.ear(from, left, false))
            .or_else(|| flat(true))
    }

    /// Cuts ears until nothing is left. Without an ear the outline crosses itself: then any convex corner has to do.
    pub(super) fn clip(mut self) -> Triangulation {
        let mut left = self.corner.len();
        let mut triangles = Vec::with_capacity(left.saturating_sub(2));
        let mut forced = 0;
        let mut from = 0;
        while left >= 3 {
            let cut = self.next_cut(from, left).or_else(|| {
                forced += 1;
                let mut convex = self
                    .around(from, left)
                    .filter(|&at| self.area(at) > self.flat);
                convex.next().filter(|_| forced <= FORCED)
            });
            let Some(cut) = cut else { break };
            if self.area(cut) > self.flat {
                triangles.push(self.triangle(cut));
            }
            from = self.next[cut as usize];
            if left > ANY_EAR {
                // Not the neighbour at once: every second corner keeps the triangles compact.
                from = self.next[from as usize];
            }
            self.remove(cut);
            left -= 1;
        }
        Triangulation {
            triangles,
            crossing: forced > 0,
        }
    }
}
