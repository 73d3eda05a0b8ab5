//! Scenes: our own from their files, and small ones built in memory.

use glam::Vec3;
use sheen_formats::{LoadOptions, load_scene};
use sheen_solver::{Camera, Gloss, Material, PointLight, Rgb, Scene, SceneParts, Triangle};
use std::path::{Path, PathBuf};

/// The OBJ file of our own scene `name`.
pub fn own_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{name}/{name}.obj"))
}

/// Our own scene `name`. Panics when it does not load.
pub fn own(name: &str) -> Scene {
    load(&own_path(name))
}

/// The scene in the file `path`. Panics when it does not load.
pub fn load(path: &Path) -> Scene {
    match load_scene(path, &LoadOptions::default()) {
        Ok(loaded) => loaded.scene,
        Err(error) => panic!("{error}"),
    }
}

/// A scene in the making.
#[derive(Clone, Debug, Default)]
pub struct Builder {
    /// What has been added.
    pub parts: SceneParts,
}

impl Builder {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a grey, diffuse material that emits `emission` [W·sr⁻¹·m⁻²] from its front.
    pub fn lambert(&mut self, name: &str, reflectance: f32, emission: f32) -> u32 {
        self.material(Material {
            emission: Rgb::splat(emission),
            ..Material::lambert(name, Rgb::splat(reflectance))
        })
    }

    /// Adds a grey material with a modified Phong lobe.
    pub fn phong(&mut self, name: &str, diffuse: f32, specular: f32, exponent: f32) -> u32 {
        self.material(Material {
            gloss: Gloss::Phong {
                specular: Rgb::splat(specular),
                exponent,
            },
            ..Material::lambert(name, Rgb::splat(diffuse))
        })
    }

    /// Adds a material.
    pub fn material(&mut self, material: Material) -> u32 {
        self.parts.materials.push(material);
        self.parts.materials.len() as u32 - 1
    }

    /// Adds a quad, counter-clockwise seen from its front.
    pub fn quad(&mut self, corners: [Vec3; 4], material: u32) -> &mut Self {
        let first = self.parts.points.len() as u32;
        self.parts.points.extend(corners);
        self.face([first, first + 1, first + 2, first + 3], material);
        self
    }

    fn face(&mut self, [a, b, c, d]: [u32; 4], material: u32) {
        for points in [[a, b, c], [a, c, d]] {
            self.parts.triangles.push(Triangle {
                points,
                normals: None,
                material,
            });
        }
    }

    /// Adds a box whose front is its inside: materials of -x, +x, -y (floor), +y (ceiling), -z, +z.
    pub fn room(&mut self, low: Vec3, high: Vec3, materials: [u32; 6]) -> &mut Self {
        self.cuboid(low, high, materials, true)
    }

    /// Adds a box whose front is its outside.
    pub fn block(&mut self, low: Vec3, high: Vec3, material: u32) -> &mut Self {
        self.cuboid(low, high, [material; 6], false)
    }

    fn cuboid(&mut self, low: Vec3, high: Vec3, materials: [u32; 6], inward: bool) -> &mut Self {
        let first = self.parts.points.len() as u32;
        for corner in 0..8u32 {
            let pick = |bit: u32, low: f32, high: f32| {
                if corner >> bit & 1 == 1 { high } else { low }
            };
            self.parts.points.push(Vec3::new(
                pick(0, low.x, high.x),
                pick(1, low.y, high.y),
                pick(2, low.z, high.z),
            ));
        }
        // Corners by bits x, y, z; counter-clockwise seen from inside.
        let faces = [
            [0, 2, 6, 4],
            [1, 5, 7, 3],
            [0, 4, 5, 1],
            [2, 3, 7, 6],
            [0, 1, 3, 2],
            [4, 6, 7, 5],
        ];
        for (mut face, material) in faces.into_iter().zip(materials) {
            if !inward {
                face.reverse();
            }
            self.face(face.map(|corner| first + corner), material);
        }
        self
    }

    /// Adds a point light.
    pub fn point_light(&mut self, position: Vec3, intensity: f32) -> &mut Self {
        self.parts.point_lights.push(PointLight {
            position,
            intensity: Rgb::splat(intensity),
        });
        self
    }

    /// Adds a camera of 64 by 48 pixels.
    pub fn camera(&mut self, eye: Vec3, target: Vec3) -> &mut Self {
        self.parts.cameras.push(Camera {
            name: format!("camera {}", self.parts.cameras.len()),
            eye,
            target,
            up: Vec3::Y,
            fov_y_degrees: 60.0,
            width: 64,
            height: 48,
        });
        self
    }

    /// The scene. Panics when it is not valid.
    pub fn build(self) -> Scene {
        match Scene::new(self.parts, false) {
            Ok((scene, _)) => scene,
            Err(error) => panic!("{error}"),
        }
    }
}

/// `scene` with all lengths times `length`; lights keep their radiance.
pub fn longer(scene: &Scene, length: f32) -> Scene {
    let mut parts = scene.clone().into_parts();
    parts.points.iter_mut().for_each(|point| *point *= length);
    for light in &mut parts.point_lights {
        light.position *= length;
        // W/sr over m²: intensity grows with the square.
        light.intensity *= length;
        light.intensity *= length;
    }
    for camera in &mut parts.cameras {
        camera.eye *= length;
        camera.target *= length;
    }
    Builder { parts }.build()
}

/// `scene` with all lights times `factor`.
pub fn brighter(scene: &Scene, factor: f32) -> Scene {
    let mut parts = scene.clone().into_parts();
    for material in &mut parts.materials {
        material.emission *= factor;
    }
    for light in &mut parts.point_lights {
        light.intensity *= factor;
    }
    Builder { parts }.build()
}

/// A closed cube of `side` [m] of one reflectance, whose ceiling (+y) emits radiance 1/π: exitance 1 W/m².
pub fn cube_with_lit_ceiling(side: f32, reflectance: f32) -> Scene {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", reflectance, 0.0);
    let floor = builder.lambert("floor", reflectance, 0.0);
    let ceiling = builder.lambert("ceiling", reflectance, std::f32::consts::FRAC_1_PI);
    builder.room(
        Vec3::ZERO,
        Vec3::splat(side),
        [wall, wall, floor, ceiling, wall, wall],
    );
    builder.build()
}

/// A black emitter of radiance 1, `sender` (counter-clockwise seen from its front), and a diffuse receiver.
pub fn sender_and_receiver(sender: [Vec3; 4], receiver: [Vec3; 4], reflectance: f32) -> Scene {
    let mut builder = Builder::new();
    let emitter = builder.lambert("emitter", 0.0, 1.0);
    let grey = builder.lambert("receiver", reflectance, 0.0);
    builder.quad(sender, emitter).quad(receiver, grey);
    builder.build()
}

/// A room with a glossy floor, a glossy block, a small lamp in the ceiling and a point light.
pub fn room_with_glossy_floor() -> Scene {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", 0.5, 0.0);
    let floor = builder.phong("floor", 0.2, 0.5, 40.0);
    let shiny = builder.phong("block", 0.1, 0.7, 90.0);
    let lamp = builder.lambert("lamp", 0.0, 9.0);
    builder
        .room(
            Vec3::ZERO,
            Vec3::new(3.0, 2.5, 4.0),
            [wall, wall, floor, wall, wall, wall],
        )
        .block(Vec3::new(1.0, 0.1, 1.5), Vec3::new(1.6, 0.9, 2.1), shiny)
        .quad(
            [
                Vec3::new(1.0, 2.4, 1.0),
                Vec3::new(1.5, 2.4, 1.0),
                Vec3::new(1.5, 2.4, 1.5),
                Vec3::new(1.0, 2.4, 1.5),
            ],
            lamp,
        )
        .point_light(Vec3::new(2.3, 1.7, 3.1), 1.5)
        .camera(Vec3::new(0.3, 1.6, 3.6), Vec3::new(1.5, 0.8, 1.0));
    builder.build()
}
