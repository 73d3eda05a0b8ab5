//! Solids that the scenes are made of: boxes, panels, surfaces of revolution, struts and tubes.
//!
//! Every shape faces outwards, counter-clockwise. Curved ones carry normals; flat ones do not.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec2, DVec3, dvec2, dvec3};

use crate::builder::{MaterialId, SceneBuilder};

/// A side of an axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Towards -x.
    Left,
    /// Towards +x.
    Right,
    /// Towards -y.
    Bottom,
    /// Towards +y.
    Top,
    /// Towards -z.
    Back,
    /// Towards +z.
    Front,
}

/// Position and turn about the vertical axis (degrees; 90 takes +z to +x).
pub(crate) fn at(x: f64, y: f64, z: f64, yaw_degrees: f64) -> DAffine3 {
    DAffine3::from_rotation_translation(
        DQuat::from_rotation_y(yaw_degrees.to_radians()),
        dvec3(x, y, z),
    )
}

/// A box between two corners, without the sides in `omit`.
pub(crate) fn cuboid(
    b: &mut SceneBuilder,
    material: MaterialId,
    min: DVec3,
    max: DVec3,
    omit: &[Side],
) {
    let corner = |k: usize| {
        let pick = |axis: usize| {
            if k >> axis & 1 == 1 {
                max[axis]
            } else {
                min[axis]
            }
        };
        dvec3(pick(0), pick(1), pick(2))
    };
    for (side, corners) in [
        (Side::Left, [0, 4, 6, 2]),
        (Side::Right, [1, 3, 7, 5]),
        (Side::Bottom, [0, 1, 5, 4]),
        (Side::Top, [2, 6, 7, 3]),
        (Side::Back, [0, 2, 3, 1]),
        (Side::Front, [4, 5, 7, 6]),
    ] {
        if !omit.contains(&side) {
            b.face(material, &corners.map(corner));
        }
    }
}

/// A rectangle: `origin`, then `u` to the right and `v` up as its front is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rectangle {
    /// Lower left corner.
    pub(crate) origin: DVec3,
    /// Along the lower side.
    pub(crate) u: DVec3,
    /// Along the left side.
    pub(crate) v: DVec3,
}

impl Rectangle {
    /// Lower left, lower right, upper right, upper left.
    pub(crate) fn corners(&self) -> [DVec3; 4] {
        let Self { origin, u, v } = *self;
        [origin, origin + u, origin + u + v, origin + v]
    }

    /// `margin` smaller on every side and `depth` behind.
    pub(crate) fn inset(&self, margin: f64, depth: f64) -> Self {
        let (u, v) = (self.u.normalize(), self.v.normalize());
        Self {
            origin: self.origin + margin * (u + v) - depth * u.cross(v),
            u: self.u - 2.0 * margin * u,
            v: self.v - 2.0 * margin * v,
        }
    }

    /// The part from `min` to `max`, both as fractions of the sides.
    pub(crate) fn part(&self, min: DVec2, max: DVec2) -> Self {
        Self {
            origin: self.origin + min.x * self.u + min.y * self.v,
            u: (max.x - min.x) * self.u,
            v: (max.y - min.y) * self.v,
        }
    }

    /// Equal cells, row by row from below.
    pub(crate) fn cells(&self, columns: u32, rows: u32) -> Vec<Self> {
        let size = dvec2(1.0 / f64::from(columns), 1.0 / f64::from(rows));
        (0..rows)
            .flat_map(|j| (0..columns).map(move |i| dvec2(f64::from(i), f64::from(j))))
            .map(|k| self.part(k * size, (k + 1.0) * size))
            .collect()
    }
}

/// One flat quad.
pub(crate) fn rectangle(b: &mut SceneBuilder, material: MaterialId, r: Rectangle) {
    b.face(material, &r.corners());
}

/// Four quads that lead from one rectangle to a second one inside, behind or before it.
pub(crate) fn border(
    b: &mut SceneBuilder,
    material: MaterialId,
    outer: Rectangle,
    inner: Rectangle,
) {
    let (o, i) = (outer.corners(), inner.corners());
    for k in 0..4 {
        let next = (k + 1) % 4;
        b.face(material, &[o[k], o[next], i[next], i[k]]);
    }
}

/// A flat frame of width `frame`, a slope of width `slope` that falls by `depth`, and what remains:
/// the panel, which is returned and not drawn.
pub(crate) fn framed(
    b: &mut SceneBuilder,
    material: MaterialId,
    outer: Rectangle,
    frame: f64,
    slope: f64,
    depth: f64,
) -> Rectangle {
    let edge = outer.inset(frame, 0.0);
    let panel = outer.inset(frame + slope, depth);
    border(b, material, outer, edge);
    border(b, material, edge, panel);
    panel
}

/// The half outline of a surface of revolution, from below to above: radius and height.
///
/// Walking it, the outside is on the right. Pieces meet in creases; within a curve normals are smooth.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    pieces: Vec<Vec<DVec2>>,
    last: DVec2,
}

impl Profile {
    /// Starts at a radius and a height.
    pub(crate) fn from(radius: f64, height: f64) -> Self {
        Self {
            pieces: Vec::new(),
            last: dvec2(radius, height),
        }
    }

    /// Straight to the next point, with a crease at both ends.
    pub(crate) fn line(self, radius: f64, height: f64) -> Self {
        self.curve(&[[radius, height]])
    }

    /// Smoothly through the points, with a crease at both ends.
    pub(crate) fn curve(mut self, points: &[[f64; 2]]) -> Self {
        let mut piece = vec![self.last];
        piece.extend(points.iter().map(|&[r, y]| dvec2(r, y)));
        self.last = piece[piece.len() - 1];
        self.pieces.push(piece);
        self
    }

    /// Smoothly along an arc about `centre` that starts here and turns by `degrees` (positive:
    /// from outwards to upwards).
    pub(crate) fn arc(self, centre: [f64; 2], degrees: f64, steps: u32) -> Self {
        let arm = self.last - DVec2::from_array(centre);
        let points: Vec<_> = (1..=steps)
            .map(|k| {
                let turn =
                    DVec2::from_angle((degrees * f64::from(k) / f64::from(steps)).to_radians());
                let p = DVec2::from_array(centre) + turn.rotate(arm);
                // Ends on the axis are meant to lie on it.
                [if p.x.abs() < 1e-9 { 0.0 } else { p.x }, p.y]
            })
            .collect();
        self.curve(&points)
    }
}

/// Normals of a smooth piece: means of the segments' normals, continued to the ends as on a circle.
fn piece_normals(piece: &[DVec2]) -> Vec<DVec2> {
    let segment: Vec<_> = piece
        .windows(2)
        .map(|w| -(w[1] - w[0]).perp().normalize())
        .collect();
    let last = segment.len() - 1;
    let mut normals = vec![segment[0]];
    normals.extend(segment.windows(2).map(|w| (w[0] + w[1]).normalize()));
    normals.push(segment[last]);
    if last > 0 {
        let mirrored = |n: DVec2, about: DVec2| 2.0 * n.dot(about) * about - n;
        normals[0] = mirrored(normals[1], segment[0]);
        normals[last + 1] = mirrored(normals[last], segment[last]);
    }
    for (n, p) in normals.iter_mut().zip(piece) {
        if p.x == 0.0 {
            *n = dvec2(0.0, n.y.signum());
        }
    }
    normals
}

/// Turns a profile about the y axis.
pub(crate) fn lathe(b: &mut SceneBuilder, material: MaterialId, segments: u32, profile: &Profile) {
    let around = |k: u32| DVec2::from_angle(TAU * f64::from(k % segments) / f64::from(segments));
    let place = |p: DVec2, a: DVec2| dvec3(p.x * a.x, p.y, p.x * a.y);
    for piece in &profile.pieces {
        let normals = piece_normals(piece);
        for k in 0..segments {
            let (a0, a1) = (around(k), around(k + 1));
            for (p, n) in piece.windows(2).zip(normals.windows(2)) {
                let mut corners = vec![(p[0], n[0], a0), (p[1], n[1], a0)];
                if p[1].x > 0.0 {
                    corners.push((p[1], n[1], a1));
                }
                if p[0].x > 0.0 {
                    corners.push((p[0], n[0], a1));
                }
                let points: Vec<_> = corners.iter().map(|&(p, _, a)| place(p, a)).collect();
                if piece.len() == 2 && p[0].y == p[1].y {
                    b.face(material, &points);
                } else {
                    let normals: Vec<_> = corners.iter().map(|&(_, n, a)| place(n, a)).collect();
                    b.smooth_face(material, &points, &normals);
                }
            }
        }
    }
}

/// A sphere with poles on its y axis: `2 segments (rings - 1)` triangles.
pub(crate) fn sphere(
    b: &mut SceneBuilder,
    material: MaterialId,
    centre: DVec3,
    radius: f64,
    segments: u32,
    rings: u32,
) {
    let profile = Profile::from(0.0, -radius).arc([0.0, 0.0], 180.0, rings);
    b.placed(DAffine3::from_translation(centre), |b| {
        lathe(b, material, segments, &profile)
    });
}

/// A round bar between two horizontal circles, open at both ends: legs, spindles, cords.
/// With an upper radius of zero it ends in a point.
pub(crate) fn strut(
    b: &mut SceneBuilder,
    material: MaterialId,
    ends: [DVec3; 2],
    radii: [f64; 2],
    sides: u32,
) {
    let ring = |k: u32| {
        let (sin, cos) = (TAU * f64::from(k % sides) / f64::from(sides)).sin_cos();
        let (out, tangent) = (dvec3(cos, 0.0, sin), dvec3(-sin, 0.0, cos));
        let (low, high) = (ends[0] + radii[0] * out, ends[1] + radii[1] * out);
        (low, high, (high - low).cross(tangent).normalize())
    };
    for k in 0..sides {
        let ((l0, h0, n0), (l1, h1, n1)) = (ring(k), ring(k + 1));
        if radii[1] == 0.0 {
            b.smooth_face(material, &[l0, h0, l1], &[n0, (n0 + n1).normalize(), n1]);
        } else {
            b.smooth_face(material, &[l0, h0, h1, l1], &[n0, n0, n1, n1]);
        }
    }
}

/// How a tube ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ends {
    /// The path closes on itself.
    Joined,
    /// Nothing: the ends touch something else.
    Open,
    /// A flat disc on both.
    Capped,
}

/// A round tube along a path in the plane of normal `across`.
pub(crate) fn tube(
    b: &mut SceneBuilder,
    material: MaterialId,
    path: &[DVec3],
    across: DVec3,
    radius: f64,
    sides: u32,
    ends: Ends,
) {
    let count = path.len();
    let joined = ends == Ends::Joined;
    // Cross sections halve the turn between their two segments.
    let tangent = |k: usize| {
        let before = if k > 0 || joined {
            path[k] - path[(k + count - 1) % count]
        } else {
            DVec3::ZERO
        };
        let after = if k + 1 < count || joined {
            path[(k + 1) % count] - path[k]
        } else {
            DVec3::ZERO
        };
        (before.normalize_or_zero() + after.normalize_or_zero()).normalize()
    };
    let normal = |k: usize, side: u32| {
        let (sin, cos) = (TAU * f64::from(side % sides) / f64::from(sides)).sin_cos();
        cos * across.cross(tangent(k)) - sin * across
    };
    let segment_count = if joined { count } else { count - 1 };
    for k in 0..segment_count {
        let next = (k + 1) % count;
        for side in 0..sides {
            let ring = [(k, side), (next, side), (next, side + 1), (k, side + 1)];
            let normals = ring.map(|(k, side)| normal(k, side));
            let points: Vec<_> = ring
                .iter()
                .zip(normals)
                .map(|(&(k, _), n)| path[k] + radius * n)
                .collect();
            b.smooth_face(material, &points, &normals);
        }
    }
    if ends == Ends::Capped {
        for side in 0..sides {
            let rim = |k: usize, side: u32| path[k] + radius * normal(k, side);
            b.face(material, &[path[0], rim(0, side), rim(0, side + 1)]);
            b.face(
                material,
                &[
                    path[count - 1],
                    rim(count - 1, side + 1),
                    rim(count - 1, side),
                ],
            );
        }
    }
}

/// A path along a circular arc in the plane of `x` and `y` (unit), from and to in degrees.
pub(crate) fn arc_path(
    centre: DVec3,
    x: DVec3,
    y: DVec3,
    radius: f64,
    degrees: [f64; 2],
    steps: u32,
) -> Vec<DVec3> {
    (0..=steps)
        .map(|k| {
            let angle = degrees[0] + (degrees[1] - degrees[0]) * f64::from(k) / f64::from(steps);
            let (sin, cos) = angle.to_radians().sin_cos();
            centre + radius * (cos * x + sin * y)
        })
        .collect()
}

/// A closed ring of tube about the y axis at `height`.
pub(crate) fn ring(
    b: &mut SceneBuilder,
    material: MaterialId,
    height: f64,
    radius: f64,
    tube_radius: f64,
    segments: u32,
    sides: u32,
) {
    let mut path = arc_path(
        height * DVec3::Y,
        DVec3::X,
        DVec3::Z,
        radius,
        [0.0, 360.0],
        segments,
    );
    path.pop();
    tube(
        b,
        material,
        &path,
        DVec3::Y,
        tube_radius,
        sides,
        Ends::Joined,
    );
}

/// A board bent about the y axis: radii, heights, and half the angle that it spans about +z.
pub(crate) fn bent_board(
    b: &mut SceneBuilder,
    material: MaterialId,
    radii: [f64; 2],
    heights: [f64; 2],
    half_degrees: f64,
    steps: u32,
) {
    let direction = |k: u32| {
        let angle = half_degrees * (2.0 * f64::from(k) / f64::from(steps) - 1.0);
        let (sin, cos) = angle.to_radians().sin_cos();
        dvec3(sin, 0.0, cos)
    };
    let point = |k: u32, r: usize, h: usize| radii[r] * direction(k) + heights[h] * DVec3::Y;
    for k in 0..steps {
        let (a, c) = (direction(k), direction(k + 1));
        let quad = |r: [usize; 4], h: [usize; 4]| {
            [
                point(k, r[0], h[0]),
                point(k + 1, r[1], h[1]),
                point(k + 1, r[2], h[2]),
                point(k, r[3], h[3]),
            ]
        };
        b.smooth_face(material, &quad([1; 4], [0, 0, 1, 1]), &[a, c, c, a]);
        let mut inner = quad([0; 4], [0, 0, 1, 1]);
        inner.reverse();
        b.smooth_face(material, &inner, &[-a, -c, -c, -a]);
        b.face(material, &quad([1, 1, 0, 0], [1; 4]));
        b.face(material, &quad([0, 0, 1, 1], [0; 4]));
    }
    let end = |k: u32| {
        [
            point(k, 0, 0),
            point(k, 1, 0),
            point(k, 1, 1),
            point(k, 0, 1),
        ]
    };
    b.face(material, &end(0));
    let mut last = end(steps);
    last.reverse();
    b.face(material, &last);
}

/// A square lamp: it emits from the face that looks at `target`; the casing behind does not.
pub(crate) fn square_lamp(
    b: &mut SceneBuilder,
    emitter: MaterialId,
    casing: MaterialId,
    centre: DVec3,
    target: DVec3,
    half: f64,
    depth: f64,
) {
    let forward = (target - centre).normalize();
    let u = forward.cross(DVec3::Y).normalize() * -1.0;
    let v = forward.cross(u);
    let front = Rectangle {
        origin: centre - half * (u + v),
        u: 2.0 * half * u,
        v: 2.0 * half * v,
    };
    let back = front.inset(0.0, depth);
    rectangle(b, emitter, front);
    border(b, casing, back, front);
    let mut corners = back.corners();
    corners.reverse();
    b.face(casing, &corners);
}
