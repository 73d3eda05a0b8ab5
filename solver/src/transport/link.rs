//! The two ends of a link and the bounds on what it carries (§3.1).
//!
//! Boxes and planes bound distances and cosines; with the sender's radiance bounded over the directions to the
//! receiver, Emin ≤ E ≤ Emax follows for every point of the receiver.

use crate::geometry::Polygon;
use crate::hierarchy::exposed::Exposed;
use crate::hierarchy::{Hierarchy, NONE, NodeId};
use crate::transport::exitant::Exitant;
use crate::transport::kernel::over;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Subdivisions of a sender below its own leaf that a link may name.
const MAX_VIRTUAL_DEPTH: u8 = 8;

/// A node, or a part of a leaf element that exists for quadrature only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SenderId {
    /// The node.
    pub node: NodeId,
    /// Two bits a level: which child of the child ... of the leaf.
    path: u16,
    /// Levels below the node.
    depth: u8,
}

impl SenderId {
    /// A whole node.
    pub fn whole(node: NodeId) -> Self {
        Self {
            node,
            path: 0,
            depth: 0,
        }
    }

    /// A part of a node: which child of the child ..., `depth` levels below it.
    pub(super) fn of(node: NodeId, path: u16, depth: u8) -> Self {
        Self { node, path, depth }
    }

    /// What of the node it is, as [`Self::of`] takes it.
    pub(super) fn below(&self) -> (u16, u8) {
        (self.path, self.depth)
    }

    /// A number that tells parts of one node from each other.
    pub fn hash(&self) -> u32 {
        u32::from(self.path) << 8 | u32::from(self.depth)
    }

    /// True for a whole node.
    pub fn is_whole(&self) -> bool {
        self.depth == 0
    }
}

/// A sender's geometry.
#[derive(Clone, Copy, Debug)]
pub struct Sender {
    /// Which.
    pub id: SenderId,
    /// Shape of an element or of a part of one; `None` for clusters.
    pub polygon: Option<Polygon>,
    /// Normal of an element.
    pub normal: Vec3,
    /// Area of an element or a part.
    pub area: f32,
    /// Share of the whole node.
    pub share: f32,
    /// Centre.
    pub centre: Vec3,
    /// Radius around it.
    pub radius: f32,
    /// Box.
    pub lower: Vec3,
    /// Box.
    pub upper: Vec3,
    /// Patch of an element, [`NONE`] for clusters.
    pub patch: u32,
}

impl Sender {
    /// The geometry of `id`.
    pub fn new(hierarchy: &Hierarchy, id: SenderId) -> Self {
        let node = hierarchy.node(id.node);
        let mut sender = Self {
            id,
            polygon: None,
            normal: Vec3::ZERO,
            area: node.area,
            share: 1.0,
            centre: node.centre,
            radius: node.radius,
            lower: node.lower,
            upper: node.upper,
            patch: NONE,
        };
        if let Some(element) = hierarchy.element_of(id.node) {
            let mut polygon = element.polygon;
            sender.area = polygon.vector_area().length();
            for level in 0..id.depth {
                polygon = polygon.child(usize::from(id.path >> (2 * level) & 3));
            }
            if id.depth > 0 {
                sender.centre = polygon.centre();
                sender.radius = polygon.radius();
                let area = polygon.vector_area().length();
                (sender.area, sender.share) = (area, area / sender.area);
                (sender.lower, sender.upper) = bounds_of(polygon.corners());
            }
            sender.polygon = Some(polygon);
            sender.normal = element.normal;
            sender.patch = element.patch;
        }
        sender
    }

    /// Its parts: children that existed when `node_count` nodes did, otherwise quarters of the leaf.
    pub fn parts(&self, hierarchy: &Hierarchy, node_count: usize, mut take: impl FnMut(SenderId)) {
        let node = hierarchy.node(self.id.node);
        if self.id.depth == 0
            && node.first_child != NONE
            && (node.first_child as usize) < node_count
        {
            hierarchy
                .children(self.id.node)
                .for_each(|child| take(SenderId::whole(child)));
        } else {
            for child in 0..4u16 {
                let path = self.id.path | child << (2 * self.id.depth);
                take(SenderId {
                    path,
                    depth: self.id.depth + 1,
                    ..self.id
                });
            }
        }
    }

    /// Share of its area that light can reach.
    pub fn exposed_share(&self, exitant: &Exitant) -> f32 {
        if self.polygon.is_some() && self.id.is_whole() {
            exitant.area[self.id.node as usize] / self.area
        } else {
            1.0
        }
    }

    /// True when it can be refined: clusters and inner elements always, parts of leaves down to a limit.
    pub fn can_refine(&self) -> bool {
        self.id.depth < MAX_VIRTUAL_DEPTH
    }
}

/// Heights above a plane that are rounding in normalised coordinates: surfaces in one plane do not light each other,
/// coincident ones least of all.
pub(crate) const COPLANAR: f32 = 16.0 * f32::EPSILON;

fn bounds_of(points: &[Vec3]) -> (Vec3, Vec3) {
    points
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| {
            (low.min(p), high.max(p))
        })
}

/// A receiver: a cluster, an element, or a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Centre.
    pub centre: Vec3,
    /// Radius around it; zero for a vertex.
    pub radius: f32,
    /// Box.
    pub lower: Vec3,
    /// Box.
    pub upper: Vec3,
    /// Shape of an element; `None` for clusters and vertices.
    pub polygon: Option<Polygon>,
    /// Normal of an element or a vertex; `None` for clusters.
    pub normal: Option<Vec3>,
    /// The patch whose surface does not block: of an element or a vertex.
    pub patch: u32,
    /// Which part of an element light can reach.
    pub exposed: Exposed,
}

impl Receiver {
    /// A node of the hierarchy.
    pub fn node(hierarchy: &Hierarchy, id: NodeId) -> Self {
        let node = hierarchy.node(id);
        let element = hierarchy.element_of(id);
        Self {
            centre: node.centre,
            radius: node.radius,
            lower: node.lower,
            upper: node.upper,
            polygon: element.map(|e| e.polygon),
            normal: element.map(|e| e.normal),
            patch: element.map_or(NONE, |e| e.patch),
            exposed: element.map_or(Exposed::ALL, |e| e.exposed),
        }
    }

    /// A point on `patch` with a shading normal.
    pub fn vertex(position: Vec3, normal: Vec3, patch: u32) -> Self {
        Self {
            centre: position,
            radius: 0.0,
            lower: position,
            upper: position,
            polygon: None,
            normal: Some(normal),
            patch,
            exposed: Exposed::ALL,
        }
    }

    /// Visits points of its polygon that light can reach and whose mean stands for it, with its `shape` quartered so many
    /// times.
    pub(super) fn points(&self, shape: &Polygon, quartered: u32, mut visit: impl FnMut(Vec3)) {
        if self.exposed == Exposed::ALL {
            over(shape, quartered, &mut visit);
            return;
        }
        let mut is_any = false;
        over(shape, quartered, &mut |point| {
            if let Some(uv) = self.exposed.nearest(shape.uv(point)) {
                is_any = true;
                visit(shape.point(uv));
            }
        });
        if !is_any {
            visit(shape.point(self.exposed.point(Vec2::splat(0.5))));
        }
    }
}

/// What is known of a link without a ray. Irradiance on the receiver's plane; normal irradiance on a cluster. Mean
/// over channels [W·m⁻²].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Not less, unless something occludes.
    pub low: f32,
    /// Not more.
    pub high: f32,
    /// Distance of the centres.
    pub distance: f32,
}

impl Bounds {
    /// Nothing arrives.
    const NOTHING: Self = Self {
        low: 0.0,
        high: 0.0,
        distance: 0.0,
    };
}

/// Distances between points of two boxes: smallest and largest.
fn box_distances(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> (f32, f32) {
    let gap = (a.0 - b.1).max(b.0 - a.1).max(Vec3::ZERO);
    let reach = (a.1 - b.0).max(b.1 - a.0);
    (gap.length(), reach.length())
}

/// Smallest and largest height of the points of a sender above a plane.
fn heights(
    corners: Option<&[Vec3]>,
    lower: Vec3,
    upper: Vec3,
    origin: Vec3,
    normal: Vec3,
) -> (f32, f32) {
    match corners {
        Some(corners) => corners
            .iter()
            .map(|&c| (c - origin).dot(normal))
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| {
                (low.min(h), high.max(h))
            }),
        None => {
            let (centre, half) = ((lower + upper) * 0.5, (upper - lower) * 0.5);
            let (h, spread) = ((centre - origin).dot(normal), half.dot(normal.abs()));
            (h - spread, h + spread)
        }
    }
}

/// Bounds on the irradiance that `sender` gives any point of `receiver` (§3.1). `high` is proven for the stored
/// exitant light; `low` too while nothing stands between.
///
/// First with the sender's extremes over all directions; only when `good` refuses those, over the directions to the
/// receiver.
pub fn bounds(
    receiver: &Receiver,
    sender: &Sender,
    exitant: &Exitant,
    good: impl Fn(&Bounds) -> bool,
) -> Bounds {
    let peak = exitant.peak[sender.id.node as usize];
    if peak <= 0.0 {
        return Bounds::NOTHING;
    }
    let offset = receiver.centre - sender.centre;
    let distance = offset.length();
    let reach = receiver.radius + sender.radius;
    let (near, far) = box_distances(
        (receiver.lower, receiver.upper),
        (sender.lower, sender.upper),
    );
    let (near, far) = (near.max(distance - reach), far.min(distance + reach));

    // Cosine at the receiver: heights of the sender above the receiver's plane.
    let sender_corners = sender.polygon.as_ref().map(Polygon::corners);
    let (cos_r_low, cos_r_high) = match receiver.normal {
        None => (1.0, 1.0),
        Some(normal) => {
            let (low, high) = heights(
                sender_corners,
                sender.lower,
                sender.upper,
                receiver.centre,
                normal,
            );
            if high <= COPLANAR {
                return Bounds::NOTHING;
            }
            (
                low.max(0.0) / far,
                if near > 0.0 {
                    (high / near).min(1.0)
                } else {
                    1.0
                },
            )
        }
    };
    let factors = match sender.polygon {
        // Cluster: intensity over distance squared.
        None => {
            let most = if near > 0.0 {
                cos_r_high / (near * near)
            } else {
                f32::INFINITY
            };
            (cos_r_low / (far * far), most)
        }
        Some(_) => {
            let receiver_corners = receiver.polygon.as_ref().map(Polygon::corners);
            let (g_low, g_high) = heights(
                receiver_corners,
                receiver.lower,
                receiver.upper,
                sender.centre,
                sender.normal,
            );
            if g_high <= COPLANAR {
                return Bounds::NOTHING;
            }
            let cos_s_low = g_low.max(0.0) / far;
            let most = if near > 0.0 {
                let cos_s_high = (g_high / near).min(1.0);
                (sender.area * cos_s_high * cos_r_high / (near * near)).min(PI)
            } else {
                PI
            };
            (sender.area * cos_s_low * cos_r_low / (far * far), most)
        }
    };
    let diffuse = exitant.diffuse[sender.id.node as usize].mean();
    let rough = Bounds {
        low: diffuse * factors.0,
        high: peak * factors.1,
        distance,
    };
    if exitant.distribution[sender.id.node as usize].is_none() || good(&rough) {
        return rough;
    }
    // The half-angle of all directions from the sender to the receiver, about the line of centres.
    let half_angle = if distance > reach {
        (reach / distance).asin()
    } else {
        PI
    };
    let axis = if distance > 0.0 {
        offset / distance
    } else {
        Vec3::Z
    };
    let (low, high) = exitant.bounds(sender.id.node, axis, half_angle);
    Bounds {
        low: low * factors.0,
        high: high * factors.1,
        distance,
    }
}
