//! `parallel_plates`: two opposed unit squares, one of which emits.

use glam::{DVec3, dvec3};

use crate::builder::{About, Camera, GeneratedScene, Material, SceneBuilder};
use crate::shapes::{Rectangle, rectangle};

/// The plates stand upright, at x = -0.5 and x = 0.5.
pub(crate) fn scene() -> GeneratedScene {
    let mut b = SceneBuilder::new(About {
        name: "parallel_plates",
        title: "Two opposed unit squares at distance 1; the black one emits 1, the grey one reflects 0.6",
        stresses: "the form factor of one pair, with nothing else to hide an error behind",
        known: &[
            "Form factor between the plates 0.199824895698387 in both directions",
            "Mean irradiance of the receiver 0.199824895698387 π = 0.627768 W/m²",
            "Mean radiance of the receiver 0.6 · 0.199824895698387 = 0.119894937 W/(sr m²)",
            "The emitter shows 1 W/(sr m²) to its front, 0 to its back; nothing comes back to the receiver",
        ],
    });
    let emitter = b.material("emitter", Material::diffuse([0.0; 3]).emitting([1.0; 3]));
    let receiver = b.material("receiver", Material::diffuse([0.6; 3]));
    b.object("emitter");
    let plate = |x: f64, z: f64, u: DVec3| Rectangle {
        origin: dvec3(x, 0.0, z),
        u,
        v: DVec3::Y,
    };
    rectangle(&mut b, emitter, plate(-0.5, 0.5, -DVec3::Z));
    b.object("receiver");
    rectangle(&mut b, receiver, plate(0.5, -0.5, DVec3::Z));
    b.camera(Camera {
        name: "side",
        eye: [-0.35, 0.7, 1.6],
        target: [0.2, 0.5, 0.0],
        fov_y_degrees: 55.0,
        size: [256, 256],
    });
    b.finish()
}
