//! The bar: counter with stools before it, cabinet with coffee machine behind, shelves above.

use glam::{DVec3, dvec3};

use super::palette::Palette;
use super::room::{BAR_Z, CABINET_X, COUNTER_X};
use super::{furniture, tableware};
use crate::builder::{MaterialId, SceneBuilder};
use crate::shapes::{
    Ends, Profile, Rectangle, Side, at, border, cuboid, framed, lathe, rectangle, strut, tube,
};

/// Upper sides of counter and cabinet [m]; the cabinet's is the chair rail's.
const COUNTER_TOP: f64 = 1.07;
const CABINET_TOP: f64 = 0.92;

/// Width of a panel: that of a floor tile.
const PANEL: f64 = 0.6;

/// Counter, cabinet, shelves, stools and what stands on them.
pub(crate) fn build(b: &mut SceneBuilder, p: &Palette) {
    counter(b, p);
    cabinet(b, p);
    shelves(b, p);
    for k in 0..5 {
        b.object(format!("stool_{k}"));
        b.placed(
            at(0.74, 0.0, -2.8 + 0.95 * f64::from(k), 7.0 * f64::from(k)),
            |b| furniture::stool(b, p),
        );
    }
    on_the_counter(b, p);
    on_the_cabinet(b, p);
}

/// An upright board: plinth of 0.1 m, then a framed panel.
fn panelled(
    b: &mut SceneBuilder,
    [plinth, frame, panel]: [MaterialId; 3],
    foot: DVec3,
    u: DVec3,
    height: f64,
) {
    rectangle(
        b,
        plinth,
        Rectangle {
            origin: foot,
            u,
            v: 0.1 * DVec3::Y,
        },
    );
    let above = Rectangle {
        origin: foot + 0.1 * DVec3::Y,
        u,
        v: (height - 0.1) * DVec3::Y,
    };
    let middle = framed(b, frame, above, 0.06, 0.025, 0.02);
    rectangle(b, panel, middle);
}

/// Foot points of the panels along the bar.
fn along_bar(x: f64) -> impl Iterator<Item = DVec3> {
    let count = ((BAR_Z[1] - BAR_Z[0]) / PANEL).round() as u32;
    (0..count).map(move |k| dvec3(x, 0.0, BAR_Z[0] + PANEL * f64::from(k)))
}

fn counter(b: &mut SceneBuilder, p: &Palette) {
    b.object("counter");
    let under = COUNTER_TOP - 0.05;
    let ([x0, x1], [z0, z1]) = (COUNTER_X, BAR_Z);
    let (x, z) = (DVec3::X, DVec3::Z);
    let outside = [p.trim, p.counter_frame, p.counter_panel];
    for foot in along_bar(x0) {
        panelled(b, outside, foot, PANEL * z, under);
    }
    panelled(b, outside, dvec3(x1, 0.0, z0), (x0 - x1) * x, under);
    panelled(b, outside, dvec3(x0, 0.0, z1), (x1 - x0) * x, under);
    for foot in along_bar(x1) {
        let back = Rectangle {
            origin: foot + PANEL * z,
            u: -PANEL * z,
            v: under * DVec3::Y,
        };
        rectangle(b, p.counter_frame, back);
    }
    // The top overhangs on all sides and has a chamfer.
    let (low, high) = (
        dvec3(1.02, COUNTER_TOP, z0 - 0.06),
        dvec3(1.85, COUNTER_TOP, z1 + 0.06),
    );
    let top = Rectangle {
        origin: dvec3(low.x, high.y, high.z),
        u: (high.x - low.x) * x,
        v: (low.z - high.z) * z,
    };
    let (edge, bottom, face) = (
        top.inset(0.0, 0.012),
        top.inset(0.0, 0.05),
        top.inset(0.012, 0.0),
    );
    border(b, p.counter_top, bottom, edge);
    border(b, p.counter_top, edge, face);
    rectangle(b, p.counter_top, face);
    let below = |low: DVec3, high: DVec3| Rectangle {
        origin: dvec3(low.x, under, low.z),
        u: (high.x - low.x) * x,
        v: (high.z - low.z) * z,
    };
    border(
        b,
        p.counter_frame,
        below(low, high),
        below(dvec3(x0, 0.0, z0), dvec3(x1, 0.0, z1)),
    );

    b.object("foot_rail");
    let rail = [dvec3(1.06, 0.2, z0 + 0.05), dvec3(1.06, 0.2, z1 - 0.05)];
    tube(b, p.brass, &rail, DVec3::Y, 0.018, 7, Ends::Capped);
    for k in [1, 3, 5, 7] {
        let foot = dvec3(x0, 0.2, z0 + PANEL * f64::from(k));
        tube(
            b,
            p.brass,
            &[dvec3(1.06, 0.2, foot.z), foot],
            DVec3::Y,
            0.009,
            5,
            Ends::Open,
        );
    }
}

fn cabinet(b: &mut SceneBuilder, p: &Palette) {
    b.object("cabinet");
    let ([x0, x1], [z0, z1]) = (CABINET_X, BAR_Z);
    let (under, front) = (CABINET_TOP - 0.04, x0 - 0.04);
    let (y, z) = (DVec3::Y, DVec3::Z);
    for foot in along_bar(x0) {
        panelled(
            b,
            [p.trim, p.counter_frame, p.counter_frame],
            foot,
            PANEL * z,
            under,
        );
        let origin = dvec3(front, under, foot.z);
        rectangle(
            b,
            p.counter_top,
            Rectangle {
                origin,
                u: (x0 - front) * DVec3::X,
                v: PANEL * z,
            },
        );
        rectangle(
            b,
            p.counter_top,
            Rectangle {
                origin,
                u: PANEL * z,
                v: 0.04 * y,
            },
        );
        let origin = dvec3(front, CABINET_TOP, foot.z);
        rectangle(
            b,
            p.counter_top,
            Rectangle {
                origin,
                u: PANEL * z,
                v: (x1 - front) * DVec3::X,
            },
        );
        let grip = dvec3(x0 - 0.014, 0.85, foot.z + 0.5 * PANEL);
        tube(
            b,
            p.brass,
            &[grip - 0.06 * z, grip + 0.06 * z],
            y,
            0.009,
            5,
            Ends::Capped,
        );
    }
    for (end, from, to) in [(z0, 1, 0), (z1, 0, 1)] {
        let board = |b: &mut SceneBuilder, material, x: [f64; 2], y0: f64, height: f64| {
            let origin = dvec3(x[from], y0, end);
            rectangle(
                b,
                material,
                Rectangle {
                    origin,
                    u: (x[to] - x[from]) * DVec3::X,
                    v: height * y,
                },
            );
        };
        board(b, p.counter_frame, [x0, x1], 0.0, under);
        board(b, p.counter_top, [front, x1], under, 0.04);
    }
}

/// Shelves between two uprights, fixed to the wall.
fn shelves(b: &mut SceneBuilder, p: &Palette) {
    b.object("shelves");
    let (front, wall) = (2.775, CABINET_X[1]);
    let (z0, z1) = (-3.1, -0.4);
    let board = |b: &mut SceneBuilder, y: [f64; 2], z: [f64; 2], omit: &[Side]| {
        cuboid(
            b,
            p.shelf,
            dvec3(front, y[0], z[0]),
            dvec3(wall, y[1], z[1]),
            omit,
        );
    };
    for z in [[z0 - 0.03, z0], [z1, z1 + 0.03]] {
        board(b, [1.3, 2.2], z, &[Side::Right, Side::Top]);
    }
    board(b, [2.2, 2.23], [z0 - 0.05, z1 + 0.05], &[Side::Right]);
    let between = [Side::Right, Side::Back, Side::Front];
    for (row, y) in [1.39, 1.79].into_iter().enumerate() {
        board(b, [y, y + 0.03], [z0, z1], &between);
        b.object(format!("shelf_goods_{row}"));
        for k in 0..10 {
            let z = z0 + 0.16 + 0.264 * f64::from(k);
            let (kind, depth) = ((k * 7 + row as u32 * 5) % 11, 0.015 * f64::from(k * 5 % 3));
            b.placed(at(2.89 + depth, y + 0.03, z, 0.0), |b| match kind {
                0 | 4 => tableware::jar(b, p, p.cups[(k as usize + row) % 3]),
                8 => tableware::carafe(b, p),
                _ => tableware::bottle(b, p.bottles[kind as usize % 5], (k as usize * 2 + row) % 3),
            });
        }
        b.object("shelf");
    }
}

fn on_the_counter(b: &mut SceneBuilder, p: &Palette) {
    b.object("on_the_counter");
    b.placed(at(1.52, COUNTER_TOP, -0.75, 10.0), |b| {
        tableware::cake_stand(b, p, p.icing)
    });
    for (x, z, turn) in [(1.22, -1.95, 20.0), (1.2, 0.42, 250.0)] {
        let cup = p.cups[(turn / 100.0) as usize % 3];
        b.placed(at(x, COUNTER_TOP, z, turn), |b| {
            tableware::cup_and_saucer(b, p, cup)
        });
    }
    b.placed(at(1.62, COUNTER_TOP, 0.9, 0.0), |b| {
        tableware::jar(b, p, p.cups[1])
    });
    b.placed(at(1.6, COUNTER_TOP, 1.12, 0.0), |b| tableware::vase(b, p));
    b.placed(at(1.6, COUNTER_TOP, -1.6, 0.0), |b| {
        tableware::plates(b, p, 3)
    });
}

fn on_the_cabinet(b: &mut SceneBuilder, p: &Palette) {
    b.object("coffee_machine");
    b.placed(at(2.72, CABINET_TOP, 0.55, -90.0), |b| coffee_machine(b, p));
    b.object("on_the_cabinet");
    for (k, z) in [-0.1, -0.3, -0.5].into_iter().enumerate() {
        b.placed(at(2.8, CABINET_TOP, z, 0.0), |b| {
            tableware::jar(b, p, p.bottles[[4, 1, 3][k]])
        });
    }
    b.placed(at(2.7, CABINET_TOP, -1.4, 0.0), |b| {
        tableware::plates(b, p, 4)
    });
    for k in 0..3 {
        b.placed(
            at(2.62, CABINET_TOP, -2.0 - 0.13 * f64::from(k), 160.0),
            |b| tableware::cup(b, p, p.cups[0]),
        );
    }
}

/// An espresso machine; its front is towards +z.
fn coffee_machine(b: &mut SceneBuilder, p: &Palette) {
    for (x, z) in [(-0.31, -0.18), (0.31, -0.18), (-0.31, 0.18), (0.31, 0.18)] {
        strut(
            b,
            p.rubber,
            [dvec3(x, 0.0, z), dvec3(x, 0.05, z)],
            [0.022, 0.018],
            6,
        );
    }
    // Tray, back and head stand on each other, open where they touch.
    let half = 0.38;
    cuboid(
        b,
        p.chrome,
        dvec3(-half, 0.05, -0.22),
        dvec3(half, 0.13, 0.22),
        &[Side::Top],
    );
    let tray = Rectangle {
        origin: dvec3(-half, 0.13, 0.22),
        u: 2.0 * half * DVec3::X,
        v: -0.22 * DVec3::Z,
    };
    let grate = framed(b, p.chrome, tray, 0.015, 0.0, 0.006);
    rectangle(b, p.rubber, grate);
    cuboid(
        b,
        p.chrome,
        dvec3(-half, 0.13, -0.22),
        dvec3(half, 0.36, 0.0),
        &[Side::Bottom, Side::Top],
    );
    cuboid(
        b,
        p.machine,
        dvec3(-half - 0.02, 0.36, -0.24),
        dvec3(half + 0.02, 0.47, 0.18),
        &[Side::Top],
    );
    let lid = Rectangle {
        origin: dvec3(-half - 0.02, 0.47, 0.18),
        u: 2.0 * (half + 0.02) * DVec3::X,
        v: -0.42 * DVec3::Z,
    };
    let warm = framed(b, p.chrome, lid, 0.02, 0.0, -0.015);
    rectangle(b, p.chrome, warm);
    for x in [-0.17, 0.17] {
        b.placed(at(x, 0.0, 0.1, 0.0), |b| {
            let group = Profile::from(0.0, 0.26)
                .line(0.03, 0.26)
                .line(0.034, 0.295)
                .line(0.042, 0.295)
                .line(0.042, 0.36);
            lathe(b, p.chrome, 10, &group);
            let handle = [dvec3(0.0, 0.28, 0.02), dvec3(0.0, 0.262, 0.17)];
            tube(b, p.rubber, &handle, DVec3::X, 0.012, 6, Ends::Capped);
        });
        let knob = [dvec3(1.7 * x, 0.415, 0.17), dvec3(1.7 * x, 0.415, 0.205)];
        tube(b, p.chrome, &knob, DVec3::Y, 0.02, 8, Ends::Capped);
        let wand = [dvec3(2.0 * x, 0.37, 0.13), dvec3(2.05 * x, 0.2, 0.17)];
        let across = (wand[1] - wand[0]).cross(DVec3::Z).normalize();
        tube(b, p.chrome, &wand, across, 0.006, 6, Ends::Capped);
    }
    for k in 0..3 {
        let place = at(
            -0.2 + 0.13 * f64::from(k),
            0.485,
            -0.02 - 0.06 * f64::from(k % 2),
            70.0,
        );
        b.placed(place, |b| tableware::cup(b, p, p.cups[0]));
    }
}
