//! Surface entities to shapes in the world, measured on the way. Nothing is tessellated here.

use super::context::{Contexts, Vertex};
use super::source::Entity;
use super::stats::MgfStats;
use super::xf::Transform;
use crate::error::{FormatError, quote};
use glam::DVec3;
use std::f64::consts::PI;

/// A corner of a polygon.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) position: DVec3,
    /// Unit.
    pub(super) normal: Option<DVec3>,
}

/// A surface in the world. `inward`: its front faces its axis or centre.
pub(super) enum Shape {
    /// The outline, then its holes.
    Polygon(Vec<Vec<Corner>>),
    /// Lateral surface between two circles; also cylinders.
    Cone {
        ends: [DVec3; 2],
        radii: [f64; 2],
        inward: bool,
    },
    /// Flat, facing `axis`; `radii[0]` is the hole.
    Ring {
        center: DVec3,
        axis: DVec3,
        radii: [f64; 2],
    },
    Sphere {
        center: DVec3,
        radius: f64,
        inward: bool,
    },
    Torus {
        center: DVec3,
        axis: DVec3,
        major: f64,
        minor: f64,
        inward: bool,
    },
}

/// The parts of one surface entity: a prism has many, a surface without area none.
pub(super) struct Measured {
    pub(super) area: f64,
    pub(super) shapes: Vec<Shape>,
}

/// Reads surface entities; borrows what they refer to.
pub(super) struct Reader<'a> {
    pub(super) entity: Entity<'a>,
    pub(super) transform: &'a Transform,
    pub(super) vertices: &'a Contexts<Vertex>,
}

impl Reader<'_> {
    /// The entity as shapes; its extent is added to the box of `stats`.
    pub(super) fn read(&self, stats: &mut MgfStats) -> Result<Measured, FormatError> {
        let mut measured = match self.entity.keyword() {
            "f" | "fh" => self.face(stats)?,
            "sph" => self.sphere(stats)?,
            "cyl" | "cone" => self.cone(stats)?,
            "ring" => self.ring(stats)?,
            "torus" => self.torus(stats)?,
            _ => self.prism(stats)?,
        };
        if !measured.area.is_finite() {
            return Err(self
                .entity
                .fault("the surface is larger than numbers can hold"));
        }
        if measured.area <= 0.0 {
            measured.shapes.clear();
        }
        Ok(measured)
    }

    fn vertex(&self, index: usize) -> Result<&Vertex, FormatError> {
        self.vertices
            .get(self.entity, &self.entity.arguments()[index])
    }

    fn place(&self, local: DVec3) -> Result<DVec3, FormatError> {
        let point = self.transform.point(local);
        // Written so that NaN is refused, too.
        if point.abs().max_element() <= f64::from(f32::MAX) {
            Ok(point)
        } else {
            Err(self.entity.fault(format!(
                "the point {point} is beyond what single precision holds"
            )))
        }
    }

    fn point(&self, index: usize) -> Result<DVec3, FormatError> {
        self.place(self.vertex(index)?.position)
    }

    fn axis(&self, index: usize) -> Result<DVec3, FormatError> {
        let name = &self.entity.arguments()[index];
        let normal = self.vertex(index)?.normal.ok_or_else(|| {
            self.entity.fault(format!(
                "{}: expected vertex {} to have a normal (n)",
                self.entity.keyword(),
                quote(name)
            ))
        })?;
        Ok(self.transform.direction(normal))
    }

    /// A length, scaled.
    fn length(&self, index: usize, what: &str) -> Result<f64, FormatError> {
        let length = self.entity.number(index, what)? * self.transform.scale;
        if length.abs() <= f64::from(f32::MAX) {
            Ok(length)
        } else {
            Err(self.entity.fault(format!(
                "{what} becomes {length}: beyond what single precision holds"
            )))
        }
    }

    /// Two signed radii to their sizes and whether they are negative. One of them may be zero.
    fn radii(&self, signed: [f64; 2]) -> Result<([f64; 2], bool), FormatError> {
        let inward = signed.iter().any(|&radius| radius < 0.0);
        if inward && signed.iter().any(|&radius| radius > 0.0) {
            let keyword = self.entity.keyword();
            return Err(self
                .entity
                .fault(format!("{keyword}: expected radii of one sign, found both")));
        }
        Ok((signed.map(f64::abs), inward))
    }

    fn face(&self, stats: &mut MgfStats) -> Result<Measured, FormatError> {
        let arguments = self.entity.arguments();
        let holes_allowed = self.entity.keyword() == "fh";
        let mut loops = vec![Vec::new()];
        for (index, word) in arguments.iter().enumerate() {
            if holes_allowed && word == "-" {
                loops.push(Vec::new());
            } else if let Some(corners) = loops.last_mut() {
                let vertex = self.vertex(index)?;
                let normal = vertex.normal.map(|normal| self.transform.direction(normal));
                corners.push(Corner {
                    position: self.place(vertex.position)?,
                    normal,
                });
            }
        }
        if loops.iter().any(|corners| corners.len() < 3) {
            let form = if holes_allowed {
                "fh v1 v2 v3 ... - h1 h2 h3 ..."
            } else {
                "f v1 v2 v3 ..."
            };
            return Err(self
                .entity
                .fault(format!("expected '{form}' with at least 3 vertices a loop")));
        }
        loops[0]
            .iter()
            .for_each(|corner| stats.grow(corner.position, DVec3::ZERO));
        let areas = loops.iter().map(|corners| vector_area(corners).length());
        let area = areas.reduce(|outline, hole| outline - hole).unwrap_or(0.0);
        if self.transform.mirrored {
            loops.iter_mut().for_each(|corners| corners.reverse());
        }
        face_normals_forward(&mut loops);
        Ok(Measured {
            area,
            shapes: vec![Shape::Polygon(loops)],
        })
    }

    fn sphere(&self, stats: &mut MgfStats) -> Result<Measured, FormatError> {
        self.entity.expect_count(2, "sph centre radius")?;
        let (center, signed) = (self.point(0)?, self.length(1, "the radius")?);
        let radius = signed.abs();
        stats.grow(center, DVec3::splat(radius));
        let shapes = vec![Shape::Sphere {
            center,
            radius,
            inward: signed < 0.0,
        }];
        Ok(Measured {
            area: 4.0 * PI * radius * radius,
            shapes,
        })
    }

    fn cone(&self, stats: &mut MgfStats) -> Result<Measured, FormatError> {
        let signed = if self.entity.keyword() == "cyl" {
            self.entity.expect_count(3, "cyl v1 radius v2")?;
            [self.length(1, "the radius")?; 2]
        } else {
            self.entity.expect_count(4, "cone v1 radius1 v2 radius2")?;
            [
                self.length(1, "the first radius")?,
                self.length(3, "the second radius")?,
            ]
        };
        let ends = [self.point(0)?, self.point(2)?];
        let (radii, inward) = self.radii(signed)?;
        let height = ends[0].distance(ends[1]);
        if height > 0.0 {
            let axis = (ends[1] - ends[0]) / height;
            stats.grow_disc(ends[0], axis, radii[0]);
            stats.grow_disc(ends[1], axis, radii[1]);
        }
        let area = PI * (radii[0] + radii[1]) * height.hypot(radii[0] - radii[1]);
        // Without height there is no axis, hence no surface to draw.
        let shapes = if height > 0.0 {
            vec![Shape::Cone {
                ends,
                radii,
                inward,
            }]
        } else {
            Vec::new()
        };
        Ok(Measured { area, shapes })
    }

    fn ring(&self, stats: &mut MgfStats) -> Result<Measured, FormatError> {
        self.entity
            .expect_count(3, "ring centre inner-radius outer-radius")?;
        let (center, axis) = (self.point(0)?, self.axis(0)?);
        let radii = [
            self.length(1, "the inner radius")?,
            self.length(2, "the outer radius")?,
        ];
        if radii[0] < 0.0 || radii[1] < radii[0] {
            return Err(self
                .entity
                .fault("ring: expected 0 ≤ inner radius < outer radius"));
        }
        stats.grow_disc(center, axis, radii[1]);
        let area = PI * (radii[1] * radii[1] - radii[0] * radii[0]);
        Ok(Measured {
            area,
            shapes: vec![Shape::Ring {
                center,
                axis,
                radii,
            }],
        })
    }

    fn torus(&self, stats: &mut MgfStats) -> Result<Measured, FormatError> {
        self.entity
            .expect_count(3, "torus centre inner-radius outer-radius")?;
        let (center, axis) = (self.point(0)?, self.axis(0)?);
        let signed = [
            self.length(1, "the inner radius")?,
            self.length(2, "the outer radius")?,
        ];
        let ([inner, outer], inward) = self.radii(signed)?;
        if outer < inner {
            return Err(self
                .entity
                .fault("torus: expected the inner radius first, then the outer one"));
        }
        let (major, minor) = ((inner + outer) / 2.0, (outer - inner) / 2.0);
        stats.grow_disc(center, axis, major);
        let extent = major * (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt);
        stats.grow(center, extent + DVec3::splat(minor));
        let shapes = vec![Shape::Torus {
            center,
            axis,
            major,
            minor,
            inward,
        }];
        Ok(Measured {
            area: 4.0 * PI * PI * major * minor,
            shapes,
        })
    }

    /// A face and its copy moved against its front, joined by quadrilaterals. With a negative length the copy lies
    /// in front and everything faces inward. Vertex normals smooth the sides only.
    fn prism(&self, stats: &mut MgfStats) -> Result<Measured, FormatError> {
        let count = self.entity.arguments().len().saturating_sub(1);
        if count < 3 {
            return Err(self.entity.wrong_count("prism v1 v2 v3 ... length"));
        }
        let length = self.entity.number(count, "the length")?;
        if length == 0.0 {
            return Err(self.entity.fault("prism: expected a length other than 0"));
        }
        let base = (0..count)
            .map(|index| self.vertex(index).copied())
            .collect::<Result<Vec<_>, _>>()?;
        let flat = |position| Corner {
            position,
            normal: None,
        };
        // In the local frame, so that a mirror turns the finished prism and not its direction.
        let local: Vec<Corner> = base.iter().map(|vertex| flat(vertex.position)).collect();
        let Some(normal) = vector_area(&local).try_normalize() else {
            return Err(self
                .entity
                .fault("prism: expected an end face with an area"));
        };
        let corner = |vertex: &Vertex, shift: DVec3| {
            let normal = vertex.normal.map(|normal| self.transform.direction(normal));
            Ok::<_, FormatError>(Corner {
                position: self.place(vertex.position + shift)?,
                normal,
            })
        };
        let near = base
            .iter()
            .map(|v| corner(v, DVec3::ZERO))
            .collect::<Result<Vec<_>, _>>()?;
        let far = base
            .iter()
            .map(|v| corner(v, -normal * length))
            .collect::<Result<Vec<_>, _>>()?;
        near.iter()
            .chain(&far)
            .for_each(|corner| stats.grow(corner.position, DVec3::ZERO));

        let mut faces: Vec<Vec<Corner>> = Vec::with_capacity(count + 2);
        let mut perimeter = 0.0;
        for (at, before) in (0..count).map(|at| (at, (at + count - 1) % count)) {
            perimeter += near[at].position.distance(near[before].position);
            faces.push(vec![far[at], near[at], near[before], far[before]]);
        }
        faces.push(near.iter().map(|corner| flat(corner.position)).collect());
        faces.push(
            far.iter()
                .rev()
                .map(|corner| flat(corner.position))
                .collect(),
        );
        let area =
            2.0 * vector_area(&near).length() + perimeter * (length * self.transform.scale).abs();
        let shapes = faces
            .into_iter()
            .filter(|face| vector_area(face).length() > 0.0)
            .map(|mut face| {
                if self.transform.mirrored {
                    face.reverse();
                }
                let mut loops = vec![face];
                face_normals_forward(&mut loops);
                Shape::Polygon(loops)
            });
        Ok(Measured {
            area,
            shapes: shapes.collect(),
        })
    }
}

/// Half the sum of cross products: along the front, as long as the area.
pub(super) fn vector_area(corners: &[Corner]) -> DVec3 {
    let Some(first) = corners.first() else {
        return DVec3::ZERO;
    };
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    edges
        .map(|(a, b)| (a.position - first.position).cross(b.position - first.position))
        .sum::<DVec3>()
        / 2.0
}

/// Where every corner has a normal and all of them oppose the winding, the normals are right, as in Radiance: the
/// face is turned over. Where they disagree, or add nothing to the face's own normal, they are dropped.
fn face_normals_forward(loops: &mut [Vec<Corner>]) {
    let Some(front) = loops
        .first()
        .and_then(|outline| vector_area(outline).try_normalize())
    else {
        return;
    };
    let corners = || loops.iter().flatten();
    // A missing normal counts as 0: on neither side.
    let along = || corners().map(|corner| corner.normal.map_or(0.0, |normal| normal.dot(front)));
    let all_behind = along().all(|cosine| cosine < 0.0);
    let smooth = along().all(|cosine| cosine.abs() > 0.0 && (cosine < 0.0) == all_behind);
    let bent = along().any(|cosine| cosine.abs() < 1.0 - 1e-9);
    if all_behind {
        loops.iter_mut().for_each(|corners| corners.reverse());
    }
    if !(smooth && bent) {
        loops
            .iter_mut()
            .flatten()
            .for_each(|corner| corner.normal = None);
    }
}
