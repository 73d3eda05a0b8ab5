//! `cafe`: a room of 6 m by 9 m by 3 m with a bar, tables, and spherical lamps.
//!
//! x points from the windows to the bar, z from the far wall to the door. This file places things and
//! names their materials; the other files say how they are made.

mod bar;
mod furniture;
mod palette;
mod room;
mod tableware;

use crate::builder::{About, Camera, GeneratedScene, SceneBuilder};
use crate::shapes::at;
use palette::Palette;

/// Where tables stand: x, z, and the directions of their chairs (degrees from +z towards +x).
const TABLES: [(f64, f64, &[f64]); 4] = [
    (-1.75, -2.1, &[62.0, 158.0, 231.0, 328.0]),
    (-1.8, 0.05, &[84.0, 176.0, 300.0]),
    (-1.75, 2.1, &[28.0, 128.0, 222.0]),
    (1.7, 3.05, &[78.0, 196.0, 305.0]),
];

/// Lamps over tables and bar: x, height of the centre, z.
const LAMPS: [(f64, f64, f64); 6] = [
    (-1.7, 2.12, -2.1),
    (-1.7, 2.12, 0.0),
    (-1.7, 2.12, 2.1),
    (1.45, 2.0, -2.1),
    (1.45, 2.0, 0.0),
    (1.5, 2.12, 2.4),
];

/// The whole café.
pub(crate) fn scene() -> GeneratedScene {
    let mut b = SceneBuilder::new(About {
        name: "cafe",
        title: "Café with a tiled glossy floor, panelled walls, a bar with stools, tables, crockery and six pendant lamps",
        stresses: "everything at once, at the size of a real room: many small glossy patches, curved smooth \
                   surfaces, soft shadows of six area lights, highlights on floor and tables",
        known: &[
            "Inner size 6 m by 9 m by 3 m, closed: all emitted power is absorbed inside",
            "Six spherical lamps of radius 0.16 m emit (11, 8.8, 6) W/(sr m²); plaster shows about 0.1 W/(sr m²)",
        ],
    });
    let p = Palette::new(&mut b);
    room::build(&mut b, &p);
    bar::build(&mut b, &p);

    for (number, &(x, z, chairs)) in TABLES.iter().enumerate() {
        b.object(format!("table_{number}"));
        b.placed(at(x, 0.0, z, 0.0), |b| furniture::table(b, &p));
        for (k, &direction) in chairs.iter().enumerate() {
            let (sin, cos) = direction.to_radians().sin_cos();
            // Nobody pushes chairs back to exactly the same place.
            let away = 0.56 + 0.03 * ((number * 5 + k * 3) % 4) as f64;
            let turn = direction + 9.0 * ((number * 2 + k * 3) % 3) as f64 - 9.0;
            let seat = p.chair_seats[(number + k) % p.chair_seats.len()];
            b.object(format!("chair_{number}_{k}"));
            b.placed(at(x + away * sin, 0.0, z + away * cos, turn), |b| {
                furniture::chair(b, &p, seat)
            });
        }
        b.object(format!("crockery_{number}"));
        for (k, &direction) in chairs.iter().enumerate().take(2) {
            let (sin, cos) = direction.to_radians().sin_cos();
            let cup = p.cups[(number + k) % p.cups.len()];
            let place = at(
                x + 0.25 * sin,
                furniture::TABLE_HEIGHT,
                z + 0.25 * cos,
                direction + 40.0,
            );
            b.placed(place, |b| tableware::cup_and_saucer(b, &p, cup));
        }
        b.placed(
            at(x + 0.05, furniture::TABLE_HEIGHT, z - 0.04, 0.0),
            |b| match number % 2 {
                0 => tableware::carafe(b, &p),
                _ => tableware::vase(b, &p),
            },
        );
        b.placed(at(x - 0.1, furniture::TABLE_HEIGHT, z + 0.06, 30.0), |b| {
            tableware::sugar_bowl(b, &p)
        });
    }
    for (k, &(x, y, z)) in LAMPS.iter().enumerate() {
        b.object(format!("lamp_{k}"));
        b.placed(at(x, y, z, 0.0), |b| {
            furniture::pendant_lamp(b, &p, room::HEIGHT - y)
        });
    }
    for (k, (x, z)) in [(-2.55, 4.05), (-2.55, -4.05)].into_iter().enumerate() {
        b.object(format!("plant_{k}"));
        b.placed(at(x, 0.0, z, 20.0 * k as f64), |b| furniture::plant(b, &p));
    }

    for (name, eye, target, fov_y_degrees) in [
        ("entrance", [-0.3, 1.5, 4.3], [0.3, 1.0, -0.6], 56.0),
        ("counter", [0.1, 1.5, -4.0], [0.5, 1.0, 1.0], 58.0),
        ("table", [-2.6, 1.5, 1.25], [-0.3, 0.82, -1.1], 56.0),
        ("barista", [2.1, 1.5, -4.15], [1.35, 1.05, 0.5], 62.0),
    ] {
        b.camera(Camera {
            name,
            eye,
            target,
            fov_y_degrees,
            size: [640, 480],
        });
    }
    b.finish()
}
