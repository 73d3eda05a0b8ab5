//! `three_lights`: coloured lamps on a very glossy reflector; the wall sees the reflector only.

use glam::{DVec3, dvec3};

use crate::builder::{About, Camera, GeneratedScene, Material, SceneBuilder};
use crate::shapes::{Rectangle, Side, cuboid, rectangle, square_lamp};

/// After figure 3 of Stamminger et al. 2000, with dimensions of our own: three spots that overlap on the wall.
pub(crate) fn scene() -> GeneratedScene {
    let mut b = SceneBuilder::new(About {
        name: "three_lights",
        title: "Red, green and blue lamps on a small, very glossy reflector behind a screen; the wall is lit by the reflector only",
        stresses: "narrow lobes towards a diffuse receiver: the reflector's distribution must carry three \
                   distinct peaks as light, not only as appearance",
        known: &[
            "No point of the wall sees the front of a lamp: with at most one bounce it is black",
            "The reflector is 0.3 m square at the origin, Ks 0.92, Ns 300; mirror directions of the lamps hit the wall \
             at (x, y) = (-0.29, 0.87) red, (0, 1.19) green and (0.29, 0.87) blue",
        ],
    });
    let wall = b.material("wall", Material::diffuse([0.78; 3]));
    let reflector = b.material("reflector", Material::glossy([0.02; 3], [0.92; 3], 300.0));
    let pedestal = b.material("pedestal", Material::diffuse([0.05; 3]));
    let screen = b.material("screen", Material::diffuse([0.06; 3]));
    let casing = b.material("casing", Material::diffuse([0.12; 3]));

    b.object("wall");
    let (x, y) = (DVec3::X, DVec3::Y);
    rectangle(
        &mut b,
        wall,
        Rectangle {
            origin: dvec3(-1.3, 0.4, -1.0),
            u: 2.6 * x,
            v: 1.9 * y,
        },
    );
    b.object("reflector");
    let (min, max) = (dvec3(-0.15, -0.12, -0.15), dvec3(0.15, 0.0, 0.15));
    let rest = [
        Side::Left,
        Side::Right,
        Side::Bottom,
        Side::Back,
        Side::Front,
    ];
    cuboid(&mut b, reflector, min, max, &rest);
    cuboid(&mut b, pedestal, min, max, &[Side::Top]);
    b.object("screen");
    cuboid(
        &mut b,
        screen,
        dvec3(-0.9, 0.57, 0.28),
        dvec3(0.9, 1.75, 0.31),
        &[],
    );
    // Lamps at 1.2 m from the reflector, by azimuth and elevation.
    for (name, ke, azimuth, elevation) in [
        ("lamp_red", [420.0, 30.0, 20.0], 16.0_f64, 40.0_f64),
        ("lamp_green", [30.0, 380.0, 30.0], 0.0, 50.0),
        ("lamp_blue", [30.0, 50.0, 560.0], -16.0, 40.0),
    ] {
        let lamp = b.material(name, Material::diffuse([0.3; 3]).emitting(ke));
        let ((sa, ca), (se, ce)) = (
            azimuth.to_radians().sin_cos(),
            elevation.to_radians().sin_cos(),
        );
        b.object(name);
        square_lamp(
            &mut b,
            lamp,
            casing,
            1.2 * dvec3(sa * ce, se, ca * ce),
            DVec3::ZERO,
            0.08,
            0.05,
        );
    }
    b.camera(Camera {
        name: "overview",
        eye: [2.1, 1.35, 0.75],
        target: [0.1, 0.95, -0.45],
        fov_y_degrees: 52.0,
        size: [640, 480],
    });
    b.camera(Camera {
        name: "wall",
        eye: [0.0, 1.2, 0.2],
        target: [0.0, 1.25, -1.0],
        fov_y_degrees: 76.0,
        size: [640, 480],
    });
    b.finish()
}
