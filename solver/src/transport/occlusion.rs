//! What a point sees of a polygon, exactly: the polygons that stand before it are cut out of it.
//!
//! Which may stand before it is found once per sender, in the pyramid from the point, and handed down to its parts:
//! most pyramids hold nothing, and most others one or two patches. Where there are more, rays decide.

use crate::geometry::{Cone, Polygon};
use crate::hierarchy::patch::Patch;
use crate::transport::link::COPLANAR;
use crate::transport::visibility::Occluders;
use glam::Vec3;

/// Candidates that are cut exactly.
pub(super) const MOST_CANDIDATES: usize = 32;

/// Parts of a sender that are still seen; more are not worth their time.
const MOST_PIECES: usize = 48;

/// Patches that may stand between a point and a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Candidates {
    /// Not looked for yet.
    Unknown,
    /// A range of [`Occlusion::lists`].
    List(u32, u32),
    /// Too many, or glass.
    Many,
}

/// A polygon as seen from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    /// The part above the point's horizon.
    cone: Cone,
    /// A part of it lies below the horizon.
    pub(super) is_cut: bool,
    patch: u32,
    /// Plane of the polygon relative to the point: c·normal = offset < 0 on it; nearer is greater.
    normal: Vec3,
    offset: f32,
}

impl Target {
    /// `polygon` of `patch` from `point`, cut at the horizon; `None` when nothing of it can be seen.
    pub(super) fn new(
        polygon: &Polygon,
        normal: Vec3,
        patch: u32,
        point: Vec3,
        horizon: Option<Vec3>,
    ) -> Option<Self> {
        let offset = normal.dot(polygon.corners()[0] - point);
        if offset >= 0.0 {
            return None;
        }
        let whole = Cone::new(polygon, point);
        let below = |normal: Vec3| whole.corners().iter().any(|c| c.dot(normal) < 0.0);
        let is_cut = horizon.is_some_and(below);
        let cone = match horizon {
            Some(horizon) if is_cut => whole.above(horizon, 0.0),
            _ => whole,
        };
        (!cone.is_empty()).then_some(Self {
            cone,
            is_cut,
            patch,
            normal,
            offset,
        })
    }

    /// Vector irradiance of all of it [sr].
    pub(super) fn vector(&self) -> Vec3 {
        self.cone.vector_irradiance()
    }
}

/// Where occluders are found.
#[derive(Clone, Copy)]
pub(super) struct Geometry<'a> {
    pub(super) occluders: &'a Occluders,
    pub(super) patches: &'a [Patch],
    pub(super) points: &'a [Vec3],
}

impl Geometry<'_> {
    /// The shape of a patch.
    pub(super) fn polygon(&self, patch: u32) -> Polygon {
        let corners = self.patches[patch as usize].points;
        let at = |i: usize| self.points[corners[i] as usize];
        if corners[3] == crate::hierarchy::NONE {
            Polygon::new(&[at(0), at(1), at(2)])
        } else {
            Polygon::new(&[at(0), at(1), at(2), at(3)])
        }
    }

    /// True when a patch lies in a plane.
    pub(super) fn is_in_plane(&self, patch: u32, origin: Vec3, normal: Vec3) -> bool {
        let polygon = self.polygon(patch);
        let mut corners = polygon.corners().iter();
        corners.all(|&corner| (corner - origin).dot(normal).abs() <= COPLANAR)
    }

    /// Vector irradiance [sr] of what `eye` sees of `target` past `candidates`; `None` when it falls into too many
    /// pieces.
    pub(super) fn visible(&self, eye: Vec3, target: &Target, candidates: &[u32]) -> Option<Vec3> {
        let mut pieces = vec![target.cone];
        let mut cut = Vec::new();
        for &patch in candidates {
            let Some((occluder, front)) = self.occluder(eye, patch, target) else {
                continue;
            };
            cut.clear();
            for piece in &pieces {
                subtract(piece, &occluder, front, &mut cut)?;
            }
            std::mem::swap(&mut pieces, &mut cut);
            if pieces.is_empty() {
                break;
            }
        }
        Some(pieces.iter().map(Cone::vector_irradiance).sum())
    }

    /// The part of `patch` that lies before `target`, and whether it shows its front to the point.
    fn occluder(&self, eye: Vec3, patch: u32, target: &Target) -> Option<(Cone, bool)> {
        let polygon = self.polygon(patch);
        let normal = polygon.vector_area().normalize_or_zero();
        let height = normal.dot(polygon.corners()[0] - eye);
        // Seen from its edge, or the surface that the point lies on under another name.
        if height.abs() <= COPLANAR {
            return None;
        }
        let cone = Cone::new(&polygon, eye);
        let heights = || {
            cone.corners()
                .iter()
                .map(|c| c.dot(target.normal) - target.offset)
        };
        if heights().all(|h| h <= COPLANAR) {
            // In one place with the target: the first patch is seen.
            let coincident = heights().all(|h| h >= -COPLANAR) && patch < target.patch;
            return coincident.then_some((cone, height < 0.0));
        }
        let before = cone.above(target.normal, target.offset);
        (!before.is_empty()).then_some((before, height < 0.0))
    }
}

/// Finds occluders of one point.
pub(super) struct Occlusion<'a> {
    pub(super) geometry: Geometry<'a>,
    /// The point.
    pub(super) eye: Vec3,
    /// The patch that it lies on.
    pub(super) own: u32,
    /// Candidates of all senders so far.
    pub(super) lists: Vec<u32>,
}

impl Occlusion<'_> {
    /// What may stand before `target`, from what may stand before a polygon that holds it.
    pub(super) fn candidates(&mut self, target: &Target, of_parent: Candidates) -> Candidates {
        let sides = || target.cone.sides(true);
        let first = self.lists.len();
        match of_parent {
            Candidates::List(from, to) => {
                for i in from..to {
                    let patch = self.lists[i as usize];
                    if self.reaches(patch, target) {
                        self.lists.push(patch);
                    }
                }
            }
            Candidates::Unknown | Candidates::Many => {
                // Slightly behind the target: what lies in its plane may be seen instead of it.
                let mut planes = [(Vec3::ZERO, 0.0); 8];
                let mut count = 0;
                for side in sides().take(7) {
                    planes[count] = (side, -COPLANAR);
                    count += 1;
                }
                planes[count] = (target.normal, target.offset - COPLANAR);
                let found =
                    self.geometry
                        .occluders
                        .reaching(self.eye, &planes[..=count], |patch| {
                            if patch == self.own
                                || patch == target.patch
                                || self.lists[first..].contains(&patch)
                            {
                                return true;
                            }
                            let corners = self.geometry.polygon(patch);
                            if reaches(&corners, self.eye, target) {
                                self.lists.push(patch);
                            }
                            self.lists.len() - first <= MOST_CANDIDATES
                        });
                if !found {
                    self.lists.truncate(first);
                    return Candidates::Many;
                }
            }
        }
        Candidates::List(first as u32, self.lists.len() as u32)
    }

    fn reaches(&self, patch: u32, target: &Target) -> bool {
        reaches(&self.geometry.polygon(patch), self.eye, target)
    }

    /// [`Geometry::visible`] past the range `from..to` of the lists.
    pub(super) fn visible(&self, target: &Target, from: u32, to: u32) -> Option<Vec3> {
        let candidates = &self.lists[from as usize..to as usize];
        self.geometry.visible(self.eye, target, candidates)
    }
}

/// False when a patch lies wholly outside one plane of the pyramid to `target`.
fn reaches(polygon: &Polygon, eye: Vec3, target: &Target) -> bool {
    let corners = polygon.corners();
    if corners
        .iter()
        .all(|&c| (c - eye).dot(target.normal) < target.offset - COPLANAR)
    {
        return false;
    }
    !target
        .cone
        .sides(true)
        .any(|side| corners.iter().all(|&c| (c - eye).dot(side) <= COPLANAR))
}

/// Appends the parts of `piece` outside `occluder` to `kept`; `None` when they are too many.
fn subtract(piece: &Cone, occluder: &Cone, front: bool, kept: &mut Vec<Cone>) -> Option<()> {
    let beside = |cone: &Cone, side: Vec3| cone.corners().iter().all(|c| c.dot(side) <= COPLANAR);
    let apart = occluder.sides(front).any(|side| beside(piece, side))
        || piece.sides(true).any(|side| beside(occluder, side));
    if apart {
        kept.push(*piece);
        return Some(());
    }
    let mut rest = *piece;
    for side in occluder.sides(front) {
        if rest.is_full() || kept.len() >= MOST_PIECES {
            return None;
        }
        let outside = rest.above(-side, 0.0);
        if !outside.is_empty() {
            kept.push(outside);
        }
        rest = rest.above(side, 0.0);
        if rest.is_empty() {
            break;
        }
    }
    Some(())
}
