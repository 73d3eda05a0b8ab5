//! `glossy_room`: an empty room with a glossy floor and glossy walls.

use glam::{DVec3, dvec3};

use crate::builder::{About, Camera, GeneratedScene, Material, SceneBuilder};
use crate::shapes::{Rectangle, rectangle};

/// After figure 7 of Stamminger et al. 2000, with dimensions of our own.
pub(crate) fn scene() -> GeneratedScene {
    let mut b = SceneBuilder::new(About {
        name: "glossy_room",
        title: "An empty room with a glossy floor, satin walls and four lamps in its ceiling",
        stresses: "highlights of small lamps on a large floor, directly and by way of the walls: adaptive against even \
                   subdivision of directions (table 2 of Stamminger et al. 2000)",
        known: &["The room is closed: all power is absorbed"],
    });
    let floor = b.material("floor", Material::glossy([0.25, 0.2, 0.16], [0.5; 3], 80.0));
    let wall = b.material(
        "wall",
        Material::glossy([0.45, 0.47, 0.42], [0.25; 3], 25.0),
    );
    let ceiling = b.material("ceiling", Material::diffuse([0.75; 3]));
    let lamp = b.material(
        "lamp",
        Material::diffuse([0.0; 3]).emitting([60.0, 54.0, 45.0]),
    );
    let (x, y, z) = (6.0 * DVec3::X, 2.8 * DVec3::Y, 4.0 * DVec3::Z);
    b.object("room");
    for (material, origin, u, v) in [
        (floor, dvec3(-3.0, 0.0, 2.0), x, -z),
        (ceiling, dvec3(-3.0, 2.8, -2.0), x, z),
        (wall, dvec3(-3.0, 0.0, -2.0), x, y),
        (wall, dvec3(3.0, 0.0, 2.0), -x, y),
        (wall, dvec3(-3.0, 0.0, 2.0), -z, y),
        (wall, dvec3(3.0, 0.0, -2.0), z, y),
    ] {
        rectangle(&mut b, material, Rectangle { origin, u, v });
    }
    b.object("lamps");
    for x in [-1.6, 1.3] {
        for z in [-1.2, 0.9] {
            rectangle(
                &mut b,
                lamp,
                Rectangle {
                    origin: dvec3(x, 2.75, z),
                    u: dvec3(0.3, 0.0, 0.0),
                    v: dvec3(0.0, 0.0, 0.3),
                },
            );
        }
    }
    b.camera(Camera {
        name: "inside",
        eye: [-2.6, 1.6, 1.7],
        target: [0.8, 0.5, -0.8],
        fov_y_degrees: 62.0,
        size: [640, 480],
    });
    b.camera(Camera {
        name: "floor",
        eye: [-2.7, 1.5, -0.15],
        target: [0.2, 0.0, -0.15],
        fov_y_degrees: 34.0,
        size: [640, 360],
    });
    b.finish()
}
