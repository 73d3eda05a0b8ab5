//! Tables, chairs, stools, lamps and plants; each stands at the local origin, y up.

use glam::{DVec3, dvec3};

use super::palette::Palette;
use crate::builder::{MaterialId, SceneBuilder};
use crate::shapes::{Ends, Profile, bent_board, lathe, ring, sphere, strut, tube};

/// Upper side of a table [m].
pub(crate) const TABLE_HEIGHT: f64 = 0.75;

/// Radius of a lamp [m].
const LAMP_RADIUS: f64 = 0.16;

/// A round table with a brass edge on an iron foot.
pub(crate) fn table(b: &mut SceneBuilder, p: &Palette) {
    let (radius, under) = (0.41, TABLE_HEIGHT - 0.03);
    let foot = Profile::from(0.25, 0.0)
        .line(0.25, 0.012)
        .curve(&[[0.13, 0.03], [0.04, 0.1]])
        .line(0.03, under);
    lathe(b, p.iron, 12, &foot);
    lathe(
        b,
        p.chair_wood,
        24,
        &Profile::from(0.0, under).line(radius, under),
    );
    let edge = Profile::from(radius, under).arc([radius, TABLE_HEIGHT - 0.015], 180.0, 2);
    lathe(b, p.brass, 24, &edge);
    let top = Profile::from(radius, TABLE_HEIGHT)
        .line(0.2, TABLE_HEIGHT)
        .line(0.0, TABLE_HEIGHT);
    lathe(b, p.table_top, 24, &top);
}

/// A bentwood chair; who sits on it looks towards -z.
pub(crate) fn chair(b: &mut SceneBuilder, p: &Palette, seat: MaterialId) {
    let (under, top, radius) = (0.425, 0.46, 0.195);
    let rim = Profile::from(0.0, under)
        .line(radius - 0.012, under)
        .line(radius, under + 0.012);
    lathe(b, p.chair_wood, 12, &rim);
    let cushion = Profile::from(radius, under + 0.012)
        .curve(&[[radius, top - 0.012], [radius - 0.02, top]])
        .line(0.0, top);
    lathe(b, seat, 12, &cushion);
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let ends = [
            dvec3(0.165 * x, 0.0, 0.165 * z),
            dvec3(0.12 * x, under, 0.12 * z),
        ];
        strut(b, p.chair_wood, ends, [0.012, 0.016], 4);
    }
    let (rail, bend) = (0.68, 0.205);
    for degrees in [-44.0_f64, 0.0, 44.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let ends = [
            dvec3(0.16 * sin, top, 0.16 * cos),
            dvec3(bend * sin, rail, bend * cos),
        ];
        strut(b, p.chair_wood, ends, [0.009, 0.007], 5);
    }
    bent_board(
        b,
        p.chair_wood,
        [bend - 0.011, bend + 0.011],
        [rail, 0.83],
        60.0,
        6,
    );
}

/// A bar stool with a padded seat and a foot ring.
pub(crate) fn stool(b: &mut SceneBuilder, p: &Palette) {
    let under = 0.7;
    let stand = Profile::from(0.19, 0.0)
        .line(0.19, 0.01)
        .curve(&[[0.09, 0.03], [0.032, 0.075]])
        .line(0.028, 0.66)
        .line(0.09, under);
    lathe(b, p.chrome, 12, &stand);
    let pan = Profile::from(0.09, under)
        .line(0.17, under)
        .line(0.18, under + 0.012);
    lathe(b, p.chrome, 12, &pan);
    let pad = Profile::from(0.18, under + 0.012).curve(&[
        [0.19, under + 0.035],
        [0.172, under + 0.068],
        [0.1, under + 0.08],
        [0.0, under + 0.082],
    ]);
    lathe(b, p.vinyl, 12, &pad);
    ring(b, p.chrome, 0.27, 0.15, 0.01, 12, 5);
    for degrees in [30.0_f64, 150.0, 270.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let out = dvec3(cos, 0.0, sin);
        let path = [0.02, 0.15].map(|r| r * out + 0.27 * DVec3::Y);
        tube(b, p.chrome, &path, DVec3::Y, 0.007, 5, Ends::Open);
    }
}

/// A luminous sphere about the origin, on a cord from a ceiling `drop` above.
pub(crate) fn pendant_lamp(b: &mut SceneBuilder, p: &Palette, drop: f64) {
    sphere(b, p.lamp, DVec3::ZERO, LAMP_RADIUS, 16, 8);
    // The holder begins just inside the sphere.
    let holder = Profile::from(0.05, 0.15)
        .line(0.05, 0.185)
        .line(0.006, 0.21);
    lathe(b, p.brass, 8, &holder);
    strut(
        b,
        p.cord,
        [0.21 * DVec3::Y, (drop - 0.035) * DVec3::Y],
        [0.006; 2],
        5,
    );
    let canopy = Profile::from(0.006, drop - 0.035).curve(&[[0.04, drop - 0.025], [0.055, drop]]);
    lathe(b, p.brass, 10, &canopy);
}

/// A pot with a spray of long pointed leaves.
pub(crate) fn plant(b: &mut SceneBuilder, p: &Palette) {
    let pot = Profile::from(0.13, 0.0)
        .line(0.175, 0.32)
        .line(0.19, 0.32)
        .line(0.19, 0.37)
        .line(0.17, 0.37)
        .line(0.165, 0.34);
    lathe(b, p.terracotta, 12, &pot);
    lathe(b, p.soil, 12, &Profile::from(0.165, 0.34).line(0.0, 0.34));
    for k in 0..12 {
        // The golden angle spreads the leaves; outer ones lean farther.
        let turn = 2.399_963 * f64::from(k);
        let lean = 0.1 + 0.022 * f64::from(k);
        let out = dvec3(turn.cos(), 0.0, turn.sin());
        let tall = 1.25 - 0.035 * f64::from(k) + 0.06 * f64::from(k % 3);
        let root = 0.02 * out + 0.335 * DVec3::Y + 0.005 * f64::from(k) * out;
        let knee = 0.5 * lean * out + (0.34 + 0.55 * (tall - 0.34)) * DVec3::Y;
        let tip = 1.5 * lean * out + tall * DVec3::Y;
        strut(b, p.leaves, [root, knee], [0.012, 0.026], 5);
        strut(b, p.leaves, [knee, tip], [0.026, 0.0], 5);
    }
}
