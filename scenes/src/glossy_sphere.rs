//! `glossy_sphere`: a smooth glossy sphere over a glossy floor, lit by a small lamp.

use glam::{DVec3, dvec3};

use crate::builder::{About, Camera, GeneratedScene, Material, SceneBuilder};
use crate::shapes::{Rectangle, rectangle, sphere, square_lamp};

/// After figure 9 of Stamminger et al. 2000, with dimensions of our own.
pub(crate) fn scene() -> GeneratedScene {
    let mut b = SceneBuilder::new(About {
        name: "glossy_sphere",
        title: "Glossy sphere with smooth normals over a glossy floor, a small lamp, diffuse ceiling and back wall",
        stresses: "interpolated normals, glossy to glossy reflection on a curved receiver, and the two caustics \
                   that floor and sphere throw on the ceiling",
        known: &[
            "The sphere has radius 0.48 m, centre (0, 0.8, 0), 40 by 20 facets; vertices lie on the true sphere",
            "The lamp is 0.18 m square and emits downwards and sideways only: the ceiling is lit by reflection alone \
             near its middle",
        ],
    });
    let ball = b.material(
        "ball",
        Material::glossy([0.2, 0.05, 0.04], [0.6, 0.56, 0.5], 70.0),
    );
    let floor = b.material("floor", Material::glossy([0.1, 0.16, 0.2], [0.5; 3], 45.0));
    let ceiling = b.material("ceiling", Material::diffuse([0.8; 3]));
    let wall = b.material("wall", Material::diffuse([0.55, 0.5, 0.42]));
    let lamp = b.material(
        "lamp",
        Material::diffuse([0.5; 3]).emitting([70.0, 64.0, 52.0]),
    );
    let casing = b.material("casing", Material::diffuse([0.25; 3]));

    let (half, height) = (1.8, 2.3);
    let (x, y, z) = (
        2.0 * half * DVec3::X,
        height * DVec3::Y,
        2.0 * half * DVec3::Z,
    );
    b.object("room");
    for (material, origin, u, v) in [
        (floor, dvec3(-half, 0.0, half), x, -z),
        (ceiling, dvec3(-half, height, -half), x, z),
        (wall, dvec3(-half, 0.0, -half), x, y),
    ] {
        rectangle(&mut b, material, Rectangle { origin, u, v });
    }
    b.object("ball");
    sphere(&mut b, ball, dvec3(0.0, 0.8, 0.0), 0.48, 40, 20);
    b.object("lamp");
    let (centre, target) = (dvec3(-0.95, 1.65, 0.8), dvec3(-0.1, 0.3, 0.0));
    square_lamp(&mut b, lamp, casing, centre, target, 0.09, 0.04);
    b.camera(Camera {
        name: "front",
        eye: [0.45, 0.95, 2.6],
        target: [-0.05, 1.02, 0.0],
        fov_y_degrees: 48.0,
        size: [640, 480],
    });
    b.camera(Camera {
        name: "low",
        eye: [-1.55, 0.3, 1.6],
        target: [0.1, 1.1, -0.25],
        fov_y_degrees: 60.0,
        size: [640, 480],
    });
    b.finish()
}
