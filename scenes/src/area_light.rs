//! `area_light`: a square lamp over a very glossy ground.

use glam::{DVec3, dvec3};

use crate::builder::{About, Camera, GeneratedScene, Material, SceneBuilder};
use crate::shapes::{Rectangle, rectangle};

/// After figure 4 of Stamminger et al. 2000, with dimensions of our own.
pub(crate) fn scene() -> GeneratedScene {
    let mut b = SceneBuilder::new(About {
        name: "area_light",
        title: "A square lamp stands behind a very glossy ground that mirrors it",
        stresses: "the shape of a light in its reflection: few illumination samples show as dots",
        known: &[
            "The lamp is 1 m square, 0.4 m above the ground; the ground is 3 m square, Ks 0.9, Ns 300",
        ],
    });
    let ground = b.material("ground", Material::glossy([0.04; 3], [0.9; 3], 300.0));
    let lamp = b.material("lamp", Material::diffuse([0.0; 3]).emitting([8.0; 3]));
    b.object("ground");
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    rectangle(
        &mut b,
        ground,
        Rectangle {
            origin: dvec3(-1.5, 0.0, 1.5),
            u: 3.0 * x,
            v: -3.0 * z,
        },
    );
    b.object("lamp");
    rectangle(
        &mut b,
        lamp,
        Rectangle {
            origin: dvec3(-0.5, 0.4, -1.5),
            u: x,
            v: y,
        },
    );
    b.camera(Camera {
        name: "front",
        eye: [0.0, 1.3, 3.4],
        target: [0.0, 0.35, -0.6],
        fov_y_degrees: 36.0,
        size: [480, 360],
    });
    b.finish()
}
