//! Transforms: `xf` arguments to matrices, arrays included.
//!
//! Arguments act from left to right. `-i n` repeats those after it, up to the next `-i` or `-a`, n times; `-a n` makes
//! n instances, of which the k-th (from 0) has them k times. Several arrays nest, the last one runs fastest.

use super::source::Entity;
use crate::error::{FormatError, quote};
use glam::{DAffine3, DMat3, DVec3};

/// A similarity: rotations, uniform scale, mirrors, a translation.
#[derive(Clone, Copy)]
pub(super) struct Transform {
    matrix: DAffine3,
    /// Positive factor on lengths.
    pub(super) scale: f64,
    /// True when it turns left hands into right ones: faces must be written backwards.
    pub(super) mirrored: bool,
}

impl Transform {
    pub(super) const IDENTITY: Self = Self {
        matrix: DAffine3::IDENTITY,
        scale: 1.0,
        mirrored: false,
    };

    fn new(matrix: DAffine3) -> Self {
        let determinant = matrix.matrix3.determinant();
        Self {
            matrix,
            scale: determinant.abs().cbrt(),
            mirrored: determinant < 0.0,
        }
    }

    /// First `inner`, then this one.
    fn after(&self, inner: DAffine3) -> Self {
        Self::new(self.matrix * inner)
    }

    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        self.matrix.transform_point3(point)
    }

    /// Unit again; mirrored with the geometry.
    pub(super) fn direction(&self, unit: DVec3) -> DVec3 {
        (self.matrix.matrix3 * unit / self.scale).normalize()
    }

    fn is_usable(&self) -> bool {
        self.matrix.is_finite() && self.scale.is_normal()
    }
}

/// What the arguments from one `-i` or `-a` to the next say.
struct Step {
    matrix: DAffine3,
    count: u64,
    is_array: bool,
}

/// The arguments of one `xf` (or of an `i` after its file name).
pub(super) struct Xf {
    steps: Vec<Step>,
    /// How many instances the arrays make.
    pub(super) instance_count: u64,
}

impl Xf {
    /// Reads the arguments from index `first` on.
    pub(super) fn parse(entity: Entity<'_>, first: usize) -> Result<Self, FormatError> {
        let arguments = entity.arguments();
        let mut steps = vec![Step {
            matrix: DAffine3::IDENTITY,
            count: 1,
            is_array: false,
        }];
        let mut at = first;
        while at < arguments.len() {
            let flag = arguments[at].as_str();
            let number = |offset| entity.number(at + offset, flag);
            let (matrix, used) = match flag {
                "-t" => (
                    DAffine3::from_translation(DVec3::new(number(1)?, number(2)?, number(3)?)),
                    4,
                ),
                "-rx" => (DAffine3::from_rotation_x(number(1)?.to_radians()), 2),
                "-ry" => (DAffine3::from_rotation_y(number(1)?.to_radians()), 2),
                "-rz" => (DAffine3::from_rotation_z(number(1)?.to_radians()), 2),
                "-s" => {
                    let factor = number(1)?;
                    if factor == 0.0 {
                        return Err(entity.fault("-s: expected a scale factor other than 0"));
                    }
                    (DAffine3::from_scale(DVec3::splat(factor)), 2)
                }
                "-mx" => (mirror(DVec3::new(-1.0, 1.0, 1.0)), 1),
                "-my" => (mirror(DVec3::new(1.0, -1.0, 1.0)), 1),
                "-mz" => (mirror(DVec3::new(1.0, 1.0, -1.0)), 1),
                "-i" | "-a" => {
                    let is_array = flag == "-a";
                    let word = arguments.get(at + 1).map_or("", String::as_str);
                    let least = u64::from(is_array);
                    let count = word
                        .parse::<u64>()
                        .ok()
                        .filter(|&count| count >= least)
                        .ok_or_else(|| {
                            entity.fault(format!(
                                "{flag}: expected a whole number of at least {least}, found {}",
                                quote(word)
                            ))
                        })?;
                    steps.push(Step {
                        matrix: DAffine3::IDENTITY,
                        count,
                        is_array,
                    });
                    at += 2;
                    continue;
                }
                _ => {
                    return Err(entity.fault(format!(
                        "expected -t, -rx, -ry, -rz, -s, -mx, -my, -mz, -i or -a, found {}",
                        quote(flag)
                    )));
                }
            };
            if let Some(step) = steps.last_mut() {
                step.matrix = matrix * step.matrix;
            }
            at += used;
        }
        let arrays = steps.iter().filter(|step| step.is_array);
        let instance_count =
            arrays.fold(1, |product: u64, step| product.saturating_mul(step.count));
        Ok(Self {
            steps,
            instance_count,
        })
    }

    /// Instance `index` of `instance_count`, seen through `outer`.
    pub(super) fn instance(
        &self,
        entity: Entity<'_>,
        outer: &Transform,
        index: u64,
    ) -> Result<Transform, FormatError> {
        let mut rest = index;
        let mut inner = DAffine3::IDENTITY;
        // From the last step, which is the fastest index and the outermost matrix, to the first.
        for step in self.steps.iter().rev() {
            let count = if step.is_array {
                rest % step.count
            } else {
                step.count
            };
            if step.is_array {
                rest /= step.count;
            }
            inner *= power(step.matrix, count);
        }
        let transform = outer.after(inner);
        if transform.is_usable() {
            Ok(transform)
        } else {
            Err(entity.fault("the transform grows or shrinks beyond what numbers can hold"))
        }
    }
}

fn mirror(signs: DVec3) -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_diagonal(signs))
}

/// By repeated squaring: a count in a file may be anything.
fn power(base: DAffine3, exponent: u64) -> DAffine3 {
    let (mut result, mut square, mut rest) = (DAffine3::IDENTITY, base, exponent);
    while rest > 0 {
        if rest & 1 == 1 {
            result = square * result;
        }
        rest >>= 1;
        if rest > 0 {
            square *= square;
        }
    }
    result
}
