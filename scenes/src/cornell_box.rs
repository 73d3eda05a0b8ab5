//! `cornell_box` and `cornell_box_glossy`: a box in the manner of Cornell's, with dimensions of our own.

use glam::{DVec3, dvec3};

use crate::builder::{About, Camera, GeneratedScene, Material, MaterialId, SceneBuilder};
use crate::shapes::{Rectangle, Side, at, border, cuboid, rectangle};

/// Half the width of the room, its height and half its depth [m].
const HALF_WIDTH: f64 = 1.0;
const HEIGHT: f64 = 1.9;
const HALF_DEPTH: f64 = 1.0;

const WHITE: [f64; 3] = [0.74, 0.73, 0.7];

/// Which material each part has.
struct Parts {
    floor: MaterialId,
    back: MaterialId,
    ceiling: MaterialId,
    left: MaterialId,
    right: MaterialId,
    tall: MaterialId,
    low: MaterialId,
    lamp: MaterialId,
}

/// Everything diffuse.
pub(crate) fn diffuse() -> GeneratedScene {
    let mut b = SceneBuilder::new(About {
        name: "cornell_box",
        title: "Box with a brick-red and a teal wall, two blocks and a lamp in the ceiling, all diffuse",
        stresses: "diffuse interreflection, colour bleeding and soft shadows, without any glossy cost",
        known: &[
            "The lamp is a 0.6 m by 0.44 m hole in the ceiling, radiance (14, 11.5, 8) W/(sr m²)",
            "The front is open: power that leaves through its 3.8 m² is lost",
            "No material is glossy, so a solution holds no directional distribution",
        ],
    });
    let white = b.material("white", Material::diffuse(WHITE));
    let [left, right] = walls(&mut b);
    let lamp = lamp(&mut b);
    let parts = Parts {
        floor: white,
        back: white,
        ceiling: white,
        left,
        right,
        tall: white,
        low: white,
        lamp,
    };
    build(&mut b, &parts);
    b.finish()
}

/// Glossy floor, back wall and tall block.
pub(crate) fn glossy() -> GeneratedScene {
    let mut b = SceneBuilder::new(About {
        name: "cornell_box_glossy",
        title: "The box of cornell_box with a glossy floor, back wall and tall block",
        stresses: "glossy to glossy transport over several bounces, lobes from wide (Ns 12) to narrow (Ns 90)",
        known: &[
            "Geometry, lamp and emitted power equal those of cornell_box",
            "The tall block mirrors the coloured walls; the floor mirrors both blocks near their feet",
        ],
    });
    let white = b.material("white", Material::diffuse(WHITE));
    let [left, right] = walls(&mut b);
    let lamp = lamp(&mut b);
    let parts = Parts {
        floor: b.material(
            "floor",
            Material::glossy([0.3, 0.28, 0.26], [0.42; 3], 40.0),
        ),
        back: b.material("back", Material::glossy([0.34, 0.33, 0.3], [0.35; 3], 12.0)),
        ceiling: white,
        left,
        right,
        tall: b.material(
            "tall_block",
            Material::glossy([0.14, 0.12, 0.08], [0.66, 0.6, 0.5], 90.0),
        ),
        low: white,
        lamp,
    };
    build(&mut b, &parts);
    b.camera(Camera {
        name: "inside",
        eye: [0.8, 1.3, 0.9],
        target: [-0.3, 0.4, -0.4],
        fov_y_degrees: 60.0,
        size: [512, 512],
    });
    b.finish()
}

fn walls(b: &mut SceneBuilder) -> [MaterialId; 2] {
    [
        b.material("brick", Material::diffuse([0.62, 0.12, 0.07])),
        b.material("teal", Material::diffuse([0.07, 0.36, 0.4])),
    ]
}

fn lamp(b: &mut SceneBuilder) -> MaterialId {
    b.material(
        "lamp",
        Material::diffuse([0.6; 3]).emitting([14.0, 11.5, 8.0]),
    )
}

fn build(b: &mut SceneBuilder, parts: &Parts) {
    let (w, h, d) = (HALF_WIDTH, HEIGHT, HALF_DEPTH);
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    b.object("room");
    for (material, origin, u, v) in [
        (parts.floor, dvec3(-w, 0.0, d), 2.0 * w * x, -2.0 * d * z),
        (parts.back, dvec3(-w, 0.0, -d), 2.0 * w * x, h * y),
        (parts.left, dvec3(-w, 0.0, d), -2.0 * d * z, h * y),
        (parts.right, dvec3(w, 0.0, -d), 2.0 * d * z, h * y),
    ] {
        rectangle(b, material, Rectangle { origin, u, v });
    }
    // The ceiling is a frame about the lamp: its outer edges are the walls', its inner ones the lamp's.
    let ceiling = Rectangle {
        origin: dvec3(-w, h, -d),
        u: 2.0 * w * x,
        v: 2.0 * d * z,
    };
    let hole = Rectangle {
        origin: dvec3(-0.3, h, -0.3),
        u: 0.6 * x,
        v: 0.44 * z,
    };
    border(b, parts.ceiling, ceiling, hole);
    b.object("lamp");
    rectangle(b, parts.lamp, hole);
    for (name, material, place, half, height) in [
        (
            "tall_block",
            parts.tall,
            at(-0.4, 0.0, -0.36, 24.0),
            0.27,
            1.15,
        ),
        (
            "low_block",
            parts.low,
            at(0.38, 0.0, 0.28, -17.0),
            0.3,
            0.55,
        ),
    ] {
        b.object(name);
        b.placed(place, |b| {
            let (min, max) = (dvec3(-half, 0.0, -half), dvec3(half, height, half));
            cuboid(b, material, min, max, &[Side::Bottom]);
        });
    }
    b.camera(Camera {
        name: "front",
        eye: [0.0, 0.95, 3.75],
        target: [0.0, 0.94, 0.0],
        fov_y_degrees: 40.0,
        size: [512, 512],
    });
}
