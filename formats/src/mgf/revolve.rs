//! Cones, cylinders and rings: bands between two circles around one axis.
//!
//! Bands that share a circle, as the profile of a glass does, form a group: all its circles get the same sides, so
//! that the bands meet without a crack. Circles become polygons whose radius is larger by one factor for each group,
//! such that the group's facets together have exactly the area of its curved surfaces: a lamp keeps its flux.

use super::mesh::{Face, Mesh};
use super::tessellate::Tolerance;
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// End of a band.
struct Circle {
    center: DVec3,
    axis: DVec3,
    radius: f64,
    /// A circle of the same group, or itself: a forest.
    parent: usize,
}

/// A surface between two circles; the second is ahead of the first, or of a ring, the hole.
struct Band {
    circles: [usize; 2],
    /// From the first to the second circle; of a ring, its front.
    axis: DVec3,
    height: f64,
}

/// What a group has in common.
#[derive(Clone, Copy)]
struct Group {
    u: DVec3,
    v: DVec3,
    w: DVec3,
    sides: usize,
    factor: f64,
}

/// All bands of a scene; first gathered, then grouped, then added to a mesh.
#[derive(Default)]
pub(super) struct Bands {
    circles: Vec<Circle>,
    by_place: HashMap<[u64; 4], Vec<usize>>,
    bands: Vec<Band>,
    /// For the root circle of each group.
    groups: HashMap<usize, Group>,
}

impl Bands {
    /// A lateral surface; returns its index.
    pub(super) fn add_cone(&mut self, ends: [DVec3; 2], radii: [f64; 2]) -> usize {
        let height = ends[0].distance(ends[1]);
        let axis = (ends[1] - ends[0]) / height;
        let circles = [
            self.circle(ends[0], axis, radii[0]),
            self.circle(ends[1], axis, radii[1]),
        ];
        self.add(circles, axis, height)
    }

    /// A flat ring that faces `axis`; returns its index.
    pub(super) fn add_ring(
        &mut self,
        center: DVec3,
        axis: DVec3,
        [inner, outer]: [f64; 2],
    ) -> usize {
        let circles = [
            self.circle(center, axis, outer),
            self.circle(center, axis, inner),
        ];
        self.add(circles, axis, 0.0)
    }

    fn add(&mut self, circles: [usize; 2], axis: DVec3, height: f64) -> usize {
        let [a, b] = circles.map(|circle| self.root(circle));
        self.circles[b].parent = a;
        self.bands.push(Band {
            circles,
            axis,
            height,
        });
        self.bands.len() - 1
    }

    /// The circle of this place, size and axis; points, circles of radius 0, are not shared.
    fn circle(&mut self, center: DVec3, axis: DVec3, radius: f64) -> usize {
        let place = center + DVec3::ZERO;
        let key = [place.x, place.y, place.z, radius].map(f64::to_bits);
        let new = self.circles.len();
        if radius > 0.0 {
            let here = self.by_place.entry(key).or_default();
            // Either way round; a file's decimals may differ a little.
            let parallel =
                |&&index: &&usize| self.circles[index].axis.cross(axis).length_squared() < 1e-10;
            if let Some(&known) = here.iter().find(parallel) {
                return known;
            }
            here.push(new);
        }
        self.circles.push(Circle {
            center: place,
            axis,
            radius,
            parent: new,
        });
        new
    }

    fn root(&mut self, circle: usize) -> usize {
        let mut at = circle;
        while self.circles[at].parent != at {
            let above = self.circles[self.circles[at].parent].parent;
            self.circles[at].parent = above;
            at = above;
        }
        at
    }

    /// Chooses sides and factor of every group; to be called once, between adding and emitting.
    pub(super) fn group(&mut self, tolerance: &Tolerance) {
        let mut members: HashMap<usize, Vec<usize>> = HashMap::new();
        for band in 0..self.bands.len() {
            let root = self.root(self.bands[band].circles[0]);
            members.entry(root).or_default().push(band);
        }
        for (root, members) in members {
            let radii = |band: usize| {
                self.bands[band]
                    .circles
                    .map(|circle| self.circles[circle].radius)
            };
            let largest = members
                .iter()
                .flat_map(|&band| radii(band))
                .fold(0.0, f64::max);
            let sides = tolerance.sides(largest);
            let exact: f64 = members
                .iter()
                .map(|&band| {
                    let [a, b] = radii(band);
                    PI * (a + b) * self.bands[band].height.hypot(a - b)
                })
                .sum();
            let faceted = |factor: f64| -> f64 {
                let area = |&band: &usize| {
                    band_area(
                        sides,
                        radii(band).map(|r| r * factor),
                        self.bands[band].height,
                    )
                };
                members.iter().map(area).sum()
            };
            let factor = solve_increasing(exact, 1.0, 1.5, faceted);
            let w = self.circles[root].axis;
            let (u, v) = w.any_orthonormal_pair();
            // Counter-clockwise around w.
            let v = if u.cross(v).dot(w) < 0.0 { -v } else { v };
            self.groups.insert(
                root,
                Group {
                    u,
                    v,
                    w,
                    sides,
                    factor,
                },
            );
        }
    }

    /// Triangles that the band will make.
    pub(super) fn triangle_count(&mut self, band: usize) -> u64 {
        let root = self.root(self.bands[band].circles[0]);
        self.groups
            .get(&root)
            .map_or(0, |group| 2 * group.sides as u64)
    }

    /// Adds the band to `mesh`; `smooth` bands get the normals of their cone, the others are flat.
    pub(super) fn emit(&mut self, band: usize, smooth: bool, face: Face, mesh: &mut Mesh) {
        let root = self.root(self.bands[band].circles[0]);
        let Some(&Group {
            u,
            v,
            w,
            sides,
            factor,
        }) = self.groups.get(&root)
        else {
            return;
        };
        let band = &self.bands[band];
        let [first, second] = band.circles.map(|circle| &self.circles[circle]);
        let ahead = band.axis.dot(w) > 0.0;
        let face = Face {
            flip: face.flip == ahead,
            ..face
        };
        let outward = |turns: f64| {
            let (sine, cosine) = (TAU * turns).sin_cos();
            u * cosine + v * sine
        };
        let fall = first.radius - second.radius;
        // Points towards the outside of a cone that is seen along its own axis; flips with the face.
        let normal = |outward: DVec3| {
            let normal = (outward * band.height + band.axis * fall).normalize();
            if ahead { normal } else { -normal }
        };
        for side in 0..sides {
            let turns = |corner: usize| ((side + corner) % sides) as f64 / sides as f64;
            let [here, next] = [outward(turns(0)), outward(turns(1))];
            let at = |circle: &Circle, outward: DVec3| {
                circle.center + outward * (circle.radius * factor)
            };
            let normals = smooth.then(|| [normal(here), normal(next)]);
            let middle = || normal((here + next).normalize());
            if second.radius == 0.0 {
                let corners = [at(first, here), at(first, next), second.center];
                mesh.triangle(face, corners, normals.map(|[a, b]| [a, b, middle()]));
            } else if first.radius == 0.0 {
                let corners = [first.center, at(second, next), at(second, here)];
                mesh.triangle(face, corners, normals.map(|[a, b]| [middle(), b, a]));
            } else {
                let corners = [
                    at(first, here),
                    at(first, next),
                    at(second, next),
                    at(second, here),
                ];
                mesh.quad(face, corners, normals.map(|[a, b]| [a, b, b, a]));
            }
        }
    }
}

/// Area of the facets between two regular polygons of the same sides around one axis, given their corners' radii.
pub(super) fn band_area(sides: usize, [first, second]: [f64; 2], height: f64) -> f64 {
    let half = PI / sides as f64;
    let slant = height.hypot((first - second) * half.cos());
    sides as f64 * (first + second) * half.sin() * slant
}

/// Where an increasing function takes a value, between `low` and `high`.
pub(super) fn solve_increasing(
    value: f64,
    mut low: f64,
    mut high: f64,
    function: impl Fn(f64) -> f64,
) -> f64 {
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if function(middle) < value {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low + high) / 2.0
}
