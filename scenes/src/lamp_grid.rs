//! `lamp_grid_3`, `_15`, `_30`: 3 × 7 lamps in even steps of angle over a small glossy reflector.

use glam::{DVec3, dvec3};

use crate::builder::{About, Camera, GeneratedScene, Material, SceneBuilder};
use crate::shapes::{Rectangle, rectangle, square_lamp};

/// Distance of the lamps from the reflector [m].
const DISTANCE: f64 = 2.0;

/// Three degrees between neighbours: their highlights are one.
pub(crate) fn close() -> GeneratedScene {
    scene("lamp_grid_3", "3 degrees", 3.0)
}

/// Fifteen degrees: their highlights touch.
pub(crate) fn apart() -> GeneratedScene {
    scene("lamp_grid_15", "15 degrees", 15.0)
}

/// Thirty degrees: every highlight stands alone.
pub(crate) fn far_apart() -> GeneratedScene {
    scene("lamp_grid_30", "30 degrees", 30.0)
}

/// After figure 3 of Stamminger et al. 2000, with dimensions of our own.
fn scene(name: &'static str, step: &'static str, degrees: f64) -> GeneratedScene {
    let title = match step {
        "3 degrees" => {
            "3 x 7 lamps, 3 degrees apart, over a small glossy reflector before a large wall"
        }
        "15 degrees" => {
            "3 x 7 lamps, 15 degrees apart, over a small glossy reflector before a large wall"
        }
        _ => "3 x 7 lamps, 30 degrees apart, over a small glossy reflector before a large wall",
    };
    let mut b = SceneBuilder::new(About {
        name,
        title,
        stresses: "many lights in one distribution: reflecting their sum against summing their reflections \
                   (table 1 of Stamminger et al. 2000)",
        known: &[
            "The reflector is 0.2 m square at the origin, Ks 0.9, Ns 200; the lamps are 2 m from it, in steps of azimuth \
             and of elevation around 45 degrees",
        ],
    });
    let wall = b.material("wall", Material::diffuse([0.75; 3]));
    let reflector = b.material("reflector", Material::glossy([0.02; 3], [0.9; 3], 200.0));
    let casing = b.material("casing", Material::diffuse([0.1; 3]));
    let lamp = b.material("lamp", Material::diffuse([0.0; 3]).emitting([300.0; 3]));

    b.object("wall");
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    rectangle(
        &mut b,
        wall,
        Rectangle {
            origin: dvec3(-3.0, 0.0, -1.6),
            u: 6.0 * x,
            v: 4.0 * y,
        },
    );
    b.object("reflector");
    rectangle(
        &mut b,
        reflector,
        Rectangle {
            origin: dvec3(-0.1, 0.0, 0.1),
            u: 0.2 * x,
            v: -0.2 * z,
        },
    );
    b.object("lamps");
    for row in -1..=1 {
        for column in -3..=3 {
            let (azimuth, elevation) = (
                (degrees * f64::from(column)).to_radians(),
                (45.0 + degrees * f64::from(row)).to_radians(),
            );
            let level = z * azimuth.cos() + x * azimuth.sin();
            let at = DISTANCE * (level * elevation.cos() + y * elevation.sin());
            square_lamp(&mut b, lamp, casing, at, DVec3::ZERO, 0.03, 0.02);
        }
    }
    b.camera(Camera {
        name: "overview",
        eye: [2.4, 1.9, 3.4],
        target: [0.0, 0.9, -0.4],
        fov_y_degrees: 52.0,
        size: [640, 480],
    });
    b.finish()
}
