//! Collects the faces of one scene and writes them as OBJ, MTL, TOML and README.
//!
//! Positions are rounded to a grid of 10 µm and equal positions become one `v` entry, so meshes that
//! touch share their vertices exactly. What a scene looks like is left to its own module.

use std::collections::HashMap;
use std::fmt::Write as _;

use glam::{DAffine3, DVec3};

/// Grid cells per metre: five decimals.
const GRID: f64 = 1e5;

/// A quad whose fourth corner is farther from the plane of the others is written as two triangles [m].
/// Rounding to the grid alone moves a corner by up to about 2e-5.
const FLAT: f64 = 4e-5;

/// Index of a material of one [`SceneBuilder`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MaterialId(usize);

/// Modified Phong material with emission, as MTL spells it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Material {
    /// Diffuse albedo.
    pub(crate) kd: [f64; 3],
    /// Albedo of the glossy lobe.
    pub(crate) ks: [f64; 3],
    /// Exponent of the glossy lobe.
    pub(crate) ns: f64,
    /// Emitted radiance [W·m⁻²·sr⁻¹].
    pub(crate) ke: [f64; 3],
}

impl Material {
    /// Reflects diffusely.
    pub(crate) fn diffuse(kd: [f64; 3]) -> Self {
        Self {
            kd,
            ns: 1.0,
            ..Self::default()
        }
    }

    /// Reflects diffusely and in a glossy lobe of exponent `ns`.
    pub(crate) fn glossy(kd: [f64; 3], ks: [f64; 3], ns: f64) -> Self {
        Self {
            kd,
            ks,
            ns,
            ..Self::default()
        }
    }

    /// The same, emitting radiance `ke`.
    pub(crate) fn emitting(self, ke: [f64; 3]) -> Self {
        Self { ke, ..self }
    }

    fn is_glossy(&self) -> bool {
        self.ks.iter().any(|&k| k > 0.0)
    }
}

/// A pinhole camera of the sidecar.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    /// What a user asks for.
    pub(crate) name: &'static str,
    /// Position [m].
    pub(crate) eye: [f64; 3],
    /// A point in the middle of the image [m].
    pub(crate) target: [f64; 3],
    /// Vertical field of view.
    pub(crate) fov_y_degrees: f64,
    /// Image width and height in pixels.
    pub(crate) size: [u32; 2],
}

/// Prose of a scene's README.
#[derive(Clone, Copy, Debug)]
pub(crate) struct About {
    /// Folder and file name.
    pub(crate) name: &'static str,
    /// One line, also the first comment of the OBJ.
    pub(crate) title: &'static str,
    /// What it asks of a solver.
    pub(crate) stresses: &'static str,
    /// Facts to check results against, one list entry each.
    pub(crate) known: &'static [&'static str],
}

/// A face: corners into the positions, and normals if it is smooth.
struct Face {
    material: MaterialId,
    corners: Vec<usize>,
    normals: Option<Vec<usize>>,
}

struct Object {
    name: String,
    faces: Vec<Face>,
}

/// Counts that the README quotes.
struct Counts {
    patches: usize,
    glossy_patches: usize,
    triangles: usize,
    area: f64,
    emitted: [f64; 3],
}

/// The text of one scene's files.
#[derive(Clone, Debug)]
pub struct GeneratedScene {
    /// Folder and file name.
    pub name: &'static str,
    /// File name and content, in the order in which they are written.
    pub files: Vec<(String, String)>,
}

/// Collects one scene.
pub(crate) struct SceneBuilder {
    about: About,
    materials: Vec<(String, Material)>,
    positions: Vec<[i64; 3]>,
    position_of: HashMap<[i64; 3], usize>,
    normals: Vec<[i64; 3]>,
    normal_of: HashMap<[i64; 3], usize>,
    objects: Vec<Object>,
    cameras: Vec<Camera>,
    world_from_local: DAffine3,
}

impl SceneBuilder {
    /// An empty scene.
    pub(crate) fn new(about: About) -> Self {
        Self {
            about,
            materials: Vec::new(),
            positions: Vec::new(),
            position_of: HashMap::new(),
            normals: Vec::new(),
            normal_of: HashMap::new(),
            objects: Vec::new(),
            cameras: Vec::new(),
            world_from_local: DAffine3::IDENTITY,
        }
    }

    /// Adds a material; names are unique within a scene.
    pub(crate) fn material(&mut self, name: &str, material: Material) -> MaterialId {
        assert!(
            self.materials.iter().all(|(n, _)| n != name),
            "material {name} exists"
        );
        for (kd, ks) in material.kd.iter().zip(material.ks) {
            assert!(kd + ks <= 1.0, "material {name} reflects more than arrives");
        }
        self.materials.push((name.to_owned(), material));
        MaterialId(self.materials.len() - 1)
    }

    /// Adds a camera to the sidecar.
    pub(crate) fn camera(&mut self, camera: Camera) {
        self.cameras.push(camera);
    }

    /// Starts an object; the faces that follow belong to it.
    pub(crate) fn object(&mut self, name: impl Into<String>) {
        self.objects.push(Object {
            name: name.into(),
            faces: Vec::new(),
        });
    }

    /// Runs `build` with local coordinates placed by `parent_from_local` (a rigid motion).
    pub(crate) fn placed(&mut self, parent_from_local: DAffine3, build: impl FnOnce(&mut Self)) {
        let outer = self.world_from_local;
        self.world_from_local = outer * parent_from_local;
        build(self);
        self.world_from_local = outer;
    }

    /// Adds a triangle or quad, counter-clockwise seen from its front.
    pub(crate) fn face(&mut self, material: MaterialId, points: &[DVec3]) {
        let corners = points.iter().map(|&p| self.position(p)).collect();
        self.push(material, corners, None);
    }

    /// Adds a triangle or quad with one unit normal per corner.
    pub(crate) fn smooth_face(
        &mut self,
        material: MaterialId,
        points: &[DVec3],
        normals: &[DVec3],
    ) {
        assert_eq!(points.len(), normals.len());
        let corners = points.iter().map(|&p| self.position(p)).collect();
        let normals = normals.iter().map(|&n| self.normal(n)).collect();
        self.push(material, corners, Some(normals));
    }

    /// Splits bent quads, so that every quad in the file is flat.
    fn push(&mut self, material: MaterialId, corners: Vec<usize>, normals: Option<Vec<usize>>) {
        if corners.len() == 4 && self.bend(&corners) > FLAT {
            let pick = |list: &[usize], order: [usize; 3]| order.map(|k| list[k]).to_vec();
            for order in [[0, 1, 2], [0, 2, 3]] {
                let normals = normals.as_deref().map(|list| pick(list, order));
                self.push(material, pick(&corners, order), normals);
            }
            return;
        }
        assert!(
            corners.len() == 3 || corners.len() == 4,
            "faces are triangles or quads"
        );
        let object = self
            .objects
            .last_mut()
            .expect("a scene names an object before its first face");
        object.faces.push(Face {
            material,
            corners,
            normals,
        });
    }

    /// Distance of a quad's last corner from the plane of the others.
    fn bend(&self, corners: &[usize]) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.point(corners[k]));
        (b - a).cross(c - a).normalize_or_zero().dot(d - a).abs()
    }

    fn position(&mut self, p: DVec3) -> usize {
        let key = on_grid(self.world_from_local.transform_point3(p));
        *self.position_of.entry(key).or_insert_with(|| {
            self.positions.push(key);
            self.positions.len() - 1
        })
    }

    fn normal(&mut self, n: DVec3) -> usize {
        let key = on_grid(self.world_from_local.transform_vector3(n).normalize());
        *self.normal_of.entry(key).or_insert_with(|| {
            self.normals.push(key);
            self.normals.len() - 1
        })
    }

    fn point(&self, index: usize) -> DVec3 {
        DVec3::from_array(self.positions[index].map(|k| k as f64 / GRID))
    }

    fn counts(&self) -> Counts {
        let mut counts = Counts {
            patches: 0,
            glossy_patches: 0,
            triangles: 0,
            area: 0.0,
            emitted: [0.0; 3],
        };
        for face in self.objects.iter().flat_map(|o| &o.faces) {
            let material = &self.materials[face.material.0].1;
            let origin = self.point(face.corners[0]);
            let area: f64 = face.corners[1..]
                .windows(2)
                .map(|w| {
                    (self.point(w[0]) - origin)
                        .cross(self.point(w[1]) - origin)
                        .length()
                        / 2.0
                })
                .sum();
            counts.patches += 1;
            counts.glossy_patches += usize::from(material.is_glossy());
            counts.triangles += face.corners.len() - 2;
            counts.area += area;
            for (sum, ke) in counts.emitted.iter_mut().zip(material.ke) {
                *sum += std::f64::consts::PI * ke * area;
            }
        }
        counts
    }

    /// Writes everything as text.
    pub(crate) fn finish(self) -> GeneratedScene {
        let name = self.about.name;
        let files = vec![
            (format!("{name}.obj"), self.obj()),
            (format!("{name}.mtl"), self.mtl()),
            (format!("{name}.toml"), self.toml()),
            ("README.md".to_owned(), self.readme()),
        ];
        GeneratedScene { name, files }
    }

    fn obj(&self) -> String {
        let mut text = format!("# {}\nmtllib {}.mtl\n", self.about.title, self.about.name);
        for (tag, list) in [("v", &self.positions), ("vn", &self.normals)] {
            for [x, y, z] in list {
                line(
                    &mut text,
                    format_args!("{tag} {} {} {}", decimal(*x), decimal(*y), decimal(*z)),
                );
            }
        }
        let mut current = None;
        for object in self.objects.iter().filter(|o| !o.faces.is_empty()) {
            line(&mut text, format_args!("o {}", object.name));
            for face in &object.faces {
                if current != Some(face.material) {
                    current = Some(face.material);
                    line(
                        &mut text,
                        format_args!("usemtl {}", self.materials[face.material.0].0),
                    );
                }
                text.push('f');
                for (k, corner) in face.corners.iter().enumerate() {
                    let corner = corner + 1;
                    let word = match &face.normals {
                        Some(normals) => format!(" {corner}//{}", normals[k] + 1),
                        None => format!(" {corner}"),
                    };
                    text.push_str(&word);
                }
                text.push('\n');
            }
        }
        text
    }

    fn mtl(&self) -> String {
        let mut text = String::new();
        for (name, m) in &self.materials {
            if !text.is_empty() {
                text.push('\n');
            }
            let [kd, ks, ke] = [m.kd, m.ks, m.ke].map(|[r, g, b]| format!("{r} {g} {b}"));
            line(
                &mut text,
                format_args!("newmtl {name}\nKd {kd}\nKs {ks}\nNs {}\nKe {ke}", m.ns),
            );
        }
        text
    }

    fn toml(&self) -> String {
        let mut text = String::new();
        for camera in &self.cameras {
            if !text.is_empty() {
                text.push('\n');
            }
            let Camera {
                name,
                eye,
                target,
                fov_y_degrees,
                size: [width, height],
            } = camera;
            line(
                &mut text,
                format_args!(
                    "[[camera]]\nname = \"{name}\"\neye = {eye:?}\ntarget = {target:?}\n\
                     up = [0.0, 1.0, 0.0]\nfov_y = {fov_y_degrees:?}\nwidth = {width}\nheight = {height}"
                ),
            );
        }
        text
    }

    fn readme(&self) -> String {
        let About {
            name,
            title,
            stresses,
            known,
        } = self.about;
        let c = self.counts();
        let [red, green, blue] = c.emitted;
        let cameras: Vec<_> = self
            .cameras
            .iter()
            .map(|c| format!("`{}`", c.name))
            .collect();
        let mut text = format!(
            "# {name}\n\n{title}.\n\n\
             - Origin: written by `generate-scenes` (crate `sheen-scenes`) of this repository;\n  \
             change the generator, not the files.\n\
             - Licence: MIT OR Apache-2.0, as the rest of the repository.\n\
             - Stresses: {stresses}.\n\
             - Cameras: {}.\n\n\
             Known numbers:\n\n\
             - {} triangles in {} patches (a quad or a single triangle), {} of them glossy;\n  \
             {} vertices, {} materials.\n\
             - Surface {:.4} m²; emitted power ({:.4}, {:.4}, {:.4}) W.\n",
            cameras.join(", "),
            c.triangles,
            c.patches,
            c.glossy_patches,
            self.positions.len(),
            self.materials.len(),
            c.area,
            red,
            green,
            blue,
        );
        for fact in known {
            line(&mut text, format_args!("- {fact}."));
        }
        text
    }
}

fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    writeln!(text, "{arguments}").expect("a String takes any text");
}

fn on_grid(p: DVec3) -> [i64; 3] {
    p.to_array().map(|x| (x * GRID).round() as i64)
}

/// The shortest exact decimal of `cells` grid cells.
fn decimal(cells: i64) -> String {
    let sign = if cells < 0 { "-" } else { "" };
    let (whole, rest) = (
        cells.unsigned_abs() / 100_000,
        cells.unsigned_abs() % 100_000,
    );
    if rest == 0 {
        return format!("{sign}{whole}");
    }
    let digits = format!("{rest:05}");
    format!("{sign}{whole}.{}", digits.trim_end_matches('0'))
}

#[cfg(test)]
mod tests {
    use super::decimal;

    #[test]
    fn decimals_are_short_and_exact() {
        for (cells, text) in [
            (0, "0"),
            (-5, "-0.00005"),
            (150_000, "1.5"),
            (-301_500, "-3.015"),
        ] {
            assert_eq!(decimal(cells), text);
        }
    }
}
