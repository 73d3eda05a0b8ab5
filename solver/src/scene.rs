//! Validated scenes: meshes, materials, emitters, cameras. Units: metres, W/(sr m²), W/sr.

use crate::error::SceneError;
use crate::radiometry::Rgb;
use glam::Vec3;
use rustc_hash::FxHashMap;

/// Largest emitted radiance or intensity that is taken, per channel.
pub const EMISSION_LIMIT: f32 = 1e30;

/// The directional part of a material's reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gloss {
    /// Lambertian only.
    None,
    /// Normalised modified Phong: f = `specular` (n+2)/2π cosⁿα (Lafortune & Willems 1994).
    Phong {
        /// Ks, within 0..1.
        specular: Rgb,
        /// n ≥ 0.
        exponent: f32,
    },
    /// Isotropic Ward as Radiance uses it: MGF `rs specular roughness`.
    Ward {
        /// ρs, within 0..1.
        specular: Rgb,
        /// Root mean square slope, within 0..1; 0 is a mirror.
        roughness: f32,
    },
}

/// A surface material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Unique name.
    pub name: String,
    /// Lambertian reflectance, within 0..1.
    pub diffuse: Rgb,
    /// Glossy reflection.
    pub gloss: Gloss,
    /// Emitted radiance [W·sr⁻¹·m⁻²]; Lambertian.
    pub emission: Rgb,
    /// True: emits from the back too (MGF surfaces with two sides).
    pub emits_from_back: bool,
    /// False: only the front (counter-clockwise side) reflects; the back is black (MGF `sides 1`).
    pub two_sided: bool,
    /// Clear transmission (MGF `ts`): tint of a ray that passes; black for opaque surfaces.
    pub transmission: Rgb,
}

impl Material {
    /// A grey, diffuse, two-sided material that does not emit.
    pub fn lambert(name: &str, diffuse: Rgb) -> Self {
        Self {
            name: name.to_owned(),
            diffuse,
            gloss: Gloss::None,
            emission: Rgb::BLACK,
            emits_from_back: false,
            two_sided: true,
            transmission: Rgb::BLACK,
        }
    }

    /// True when light passes: such a surface does not block, it tints.
    pub fn is_glass(&self) -> bool {
        !self.transmission.is_black()
    }

    /// True when a directional distribution is needed to show this material.
    pub fn is_glossy(&self) -> bool {
        match self.gloss {
            Gloss::None => false,
            Gloss::Phong { specular, .. } | Gloss::Ward { specular, .. } => !specular.is_black(),
        }
    }
}

/// One triangle; front face counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Corners: indices into [`Scene::points`].
    pub points: [u32; 3],
    /// Shading normals at the corners: indices into [`Scene::normals`]. `None`: flat.
    pub normals: Option<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// An isotropic point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Where [m].
    pub position: Vec3,
    /// Radiant intensity [W/sr].
    pub intensity: Rgb,
}

/// A pinhole camera; right-handed: image right = (target - eye) × up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name, unique in the scene.
    pub name: String,
    /// Where the eye is [m].
    pub eye: Vec3,
    /// A point in the middle of the image.
    pub target: Vec3,
    /// Roughly up; not parallel to the view.
    pub up: Vec3,
    /// Vertical field of view [degrees].
    pub fov_y_degrees: f32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

/// What a reader gathers before validation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneParts {
    /// Positions [m].
    pub points: Vec<Vec3>,
    /// Shading normals, unit.
    pub normals: Vec<Vec3>,
    /// Faces.
    pub triangles: Vec<Triangle>,
    /// Materials, in the order that triangles refer to.
    pub materials: Vec<Material>,
    /// Point lights.
    pub point_lights: Vec<PointLight>,
    /// Cameras; may be empty.
    pub cameras: Vec<Camera>,
}

/// A scene whose every number has been checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    parts: SceneParts,
}

impl Scene {
    /// Checks `parts`. With `lenient`, repairs what can be repaired and says what was done, one line a kind of
    /// repair with its count; without, the first fault is an error.
    pub fn new(mut parts: SceneParts, lenient: bool) -> Result<(Self, Vec<String>), SceneError> {
        let mut repairs = Vec::new();
        for material in &mut parts.materials {
            check_material(material, lenient, &mut repairs)?;
        }
        for (index, light) in parts.point_lights.iter().enumerate() {
            check_emission(&format!("point light {}", index + 1), light.intensity)?;
            if !light.position.is_finite() {
                return Err(SceneError::Emission {
                    light: format!("point light {} at {}", index + 1, light.position),
                    value: light.intensity.to_array(),
                    limit: EMISSION_LIMIT,
                });
            }
        }
        check_triangles(&mut parts, lenient, &mut repairs)?;
        for camera in &parts.cameras {
            check_camera(camera)?;
        }
        if parts.cameras.is_empty() {
            parts.cameras.push(default_camera(&parts));
        }
        Ok((Self { parts }, repairs))
    }

    /// Positions [m].
    pub fn points(&self) -> &[Vec3] {
        &self.parts.points
    }
    /// Shading normals, unit.
    pub fn normals(&self) -> &[Vec3] {
        &self.parts.normals
    }
    /// Faces.
    pub fn triangles(&self) -> &[Triangle] {
        &self.parts.triangles
    }
    /// Materials.
    pub fn materials(&self) -> &[Material] {
        &self.parts.materials
    }
    /// Point lights.
    pub fn point_lights(&self) -> &[PointLight] {
        &self.parts.point_lights
    }
    /// Cameras; never empty: a scene without any gets one that sees it whole.
    pub fn cameras(&self) -> &[Camera] {
        &self.parts.cameras
    }
    /// The parts, for tools that change a scene and validate it again.
    pub fn into_parts(self) -> SceneParts {
        self.parts
    }
    /// Corners of a triangle [m].
    pub fn corners(&self, triangle: &Triangle) -> [Vec3; 3] {
        triangle
            .points
            .map(|index| self.parts.points[index as usize])
    }
    /// Smallest and largest corner of the box around all triangles [m].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        bounds(&self.parts)
    }
}

fn bounds(parts: &SceneParts) -> (Vec3, Vec3) {
    parts
        .triangles
        .iter()
        .flat_map(|t| t.points)
        .map(|index| parts.points[index as usize])
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        })
}

fn default_camera(parts: &SceneParts) -> Camera {
    let (low, high) = bounds(parts);
    let extent = (high - low).max_element();
    let target = (low + high) * 0.5;
    Camera {
        name: "default".to_owned(),
        eye: target + Vec3::new(0.4, 0.3, 1.6) * extent,
        target,
        up: Vec3::Y,
        fov_y_degrees: 45.0,
        width: 640,
        height: 480,
    }
}

fn check_emission(light: &str, value: Rgb) -> Result<(), SceneError> {
    if value
        .to_array()
        .iter()
        .all(|&c| (0.0..=EMISSION_LIMIT).contains(&c))
    {
        return Ok(());
    }
    Err(SceneError::Emission {
        light: light.to_owned(),
        value: value.to_array(),
        limit: EMISSION_LIMIT,
    })
}

fn check_material(
    m: &mut Material,
    lenient: bool,
    repairs: &mut Vec<String>,
) -> Result<(), SceneError> {
    check_emission(&format!("material '{}'", m.name), m.emission)?;
    let parameter = |what, value, expected| {
        Err(SceneError::Parameter {
            material: m.name.clone(),
            what,
            value,
            expected,
        })
    };
    let specular = match m.gloss {
        Gloss::None => Rgb::BLACK,
        Gloss::Phong { specular, exponent } => {
            if !(0.0..=1e7).contains(&exponent) {
                return parameter("the Phong exponent", exponent, "within 0..1e7");
            }
            specular
        }
        Gloss::Ward {
            specular,
            roughness,
        } => {
            if !(0.0..=1.0).contains(&roughness) {
                return parameter("the roughness", roughness, "within 0..1");
            }
            specular
        }
    };
    for (what, value) in [
        ("diffuse reflectance", m.diffuse),
        ("specular reflectance", specular),
        ("transmission", m.transmission),
    ] {
        if value.to_array().iter().any(|c| !c.is_finite() || *c < 0.0) {
            return Err(SceneError::Reflectance {
                material: m.name.clone(),
                what,
                value: value.min_channel(),
            });
        }
    }
    // A file's decimals may add up to a little more than one: that much rounding is no fault.
    const ROUNDING: f32 = 1e-5;
    let sum = m.diffuse + specular + m.transmission;
    let largest = sum.max_channel();
    if largest <= 1.0 + ROUNDING {
        return Ok(());
    }
    if !lenient {
        let what = "diffuse + specular + transmitted reflectance";
        return Err(SceneError::Reflectance {
            material: m.name.clone(),
            what,
            value: largest,
        });
    }
    let scale = 1.0 / largest;
    m.diffuse *= scale;
    m.transmission *= scale;
    match &mut m.gloss {
        Gloss::None => {}
        Gloss::Phong { specular, .. } | Gloss::Ward { specular, .. } => *specular *= scale,
    }
    repairs.push(format!(
        "material '{}': reflectances scaled by {scale:.4} to add up to 1",
        m.name
    ));
    Ok(())
}

/// A normal from a file is unit to this much: files print a few decimals.
const UNIT_TOLERANCE: f32 = 1e-2;

fn check_triangles(
    parts: &mut SceneParts,
    lenient: bool,
    repairs: &mut Vec<String>,
) -> Result<(), SceneError> {
    let (point_count, normal_count) = (parts.points.len(), parts.normals.len());
    let material_count = parts.materials.len();
    let (mut not_finite, mut degenerate, mut duplicate, mut rebuilt) = (0, 0, 0, 0);
    let mut seen: FxHashMap<([u32; 3], u32), usize> = FxHashMap::default();
    let mut kept = Vec::with_capacity(parts.triangles.len());
    for (index, triangle) in parts.triangles.iter().enumerate() {
        let range = |kind, values: &[u32], count: usize| match values
            .iter()
            .find(|&&v| v as usize >= count)
        {
            Some(&index_found) => Err(SceneError::Index {
                triangle: index,
                kind,
                index: index_found,
                count,
            }),
            None => Ok(()),
        };
        range("point", &triangle.points, point_count)?;
        range("material", &[triangle.material], material_count)?;
        if let Some(normals) = triangle.normals {
            range("normal", &normals, normal_count)?;
        }
        let [a, b, c] = triangle.points.map(|p| parts.points[p as usize]);
        if !(a.is_finite() && b.is_finite() && c.is_finite()) {
            if !lenient {
                return Err(SceneError::NotFinite { triangle: index });
            }
            not_finite += 1;
            continue;
        }
        // In f64 so that far origins and small triangles do not underflow.
        let normal = (b.as_dvec3() - a.as_dvec3()).cross(c.as_dvec3() - a.as_dvec3());
        if normal.length_squared() == 0.0 {
            if !lenient {
                return Err(SceneError::Degenerate { triangle: index });
            }
            degenerate += 1;
            continue;
        }
        let mut key = triangle.points;
        let smallest = (0..3).min_by_key(|&i| key[i]).unwrap_or(0);
        key.rotate_left(smallest);
        if let Some(&first) = seen.get(&(key, triangle.material)) {
            if !lenient {
                return Err(SceneError::Duplicate {
                    triangle: index,
                    first,
                });
            }
            duplicate += 1;
            continue;
        }
        seen.insert((key, triangle.material), index);
        let mut triangle = *triangle;
        if let Some(normals) = triangle.normals {
            let face = normal.normalize().as_vec3();
            for n in normals.map(|n| parts.normals[n as usize]) {
                let reason = if !n.is_finite() || n.length_squared() == 0.0 {
                    "has no direction"
                } else if (n.length() - 1.0).abs() > UNIT_TOLERANCE {
                    "is not of unit length"
                } else if n.dot(face) <= 0.0 {
                    "points away from its face"
                } else {
                    continue;
                };
                if !lenient {
                    return Err(SceneError::Normal {
                        triangle: index,
                        normal: n.to_array(),
                        reason,
                    });
                }
                triangle.normals = None;
            }
            rebuilt += usize::from(triangle.normals.is_none());
        }
        kept.push(triangle);
    }
    for (count, what) in [
        (
            not_finite,
            "triangles with corners that are not finite dropped",
        ),
        (degenerate, "triangles without area dropped"),
        (duplicate, "duplicate triangles dropped"),
        (rebuilt, "triangles with bad shading normals made flat"),
    ] {
        if count > 0 {
            repairs.push(format!("{count} {what}"));
        }
    }
    parts.triangles = kept;
    if parts.triangles.is_empty() {
        Err(SceneError::NoSurface)
    } else {
        Ok(())
    }
}

/// Checks a camera from a file or the command line.
pub fn check_camera(camera: &Camera) -> Result<(), SceneError> {
    let fault = |reason| {
        Err(SceneError::Camera {
            camera: camera.name.clone(),
            reason,
        })
    };
    if !(camera.eye.is_finite() && camera.target.is_finite() && camera.up.is_finite()) {
        return fault("eye, target and up must be finite");
    }
    if camera.eye == camera.target {
        return fault("eye and target are the same point");
    }
    if looks_along_up(camera) {
        return fault("up is parallel to the view or zero");
    }
    if !(camera.fov_y_degrees > 0.0 && camera.fov_y_degrees < 180.0) {
        return fault("fov_y must be between 0 and 180 degrees");
    }
    if camera.width == 0 || camera.height == 0 || camera.width > 16384 || camera.height > 16384 {
        return fault("width and height must be within 1..16384 pixels");
    }
    Ok(())
}

/// True for a camera whose `up` is parallel to its view or zero: roundings alone would say what is up.
pub fn looks_along_up(camera: &Camera) -> bool {
    let view = camera.target.as_dvec3() - camera.eye.as_dvec3();
    let up = camera.up.as_dvec3().normalize_or_zero();
    let sine = view.normalize_or_zero().cross(up).length();
    sine <= f64::from(f32::EPSILON)
}
