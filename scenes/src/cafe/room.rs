//! The shell of the café: floor, panelled walls, ceiling with beams, door, windows, columns, pictures.
//!
//! The shell is one welded surface without hidden parts: walls stop where a window, the door or a
//! built-in cabinet begins, and tiles stop at what is built on the floor.

use glam::{DVec3, dvec2, dvec3};

use super::palette::Palette;
use crate::builder::{MaterialId, SceneBuilder};
use crate::shapes::{
    Ends, Profile, Rectangle, arc_path, at, border, cuboid, framed, lathe, rectangle, tube,
};

/// Height of the room [m].
pub(crate) const HEIGHT: f64 = 3.0;

/// Half the inner width and depth, between skirting boards [m].
const HALF_X: f64 = 3.0;
const HALF_Z: f64 = 4.5;

/// Side of a floor tile; walls are divided alike.
const TILE: f64 = 0.6;

/// The plaster lies this far behind the skirting boards.
const WALL: f64 = 0.015;

/// Skirting, panels, chair rail and plaster from below to above: distance behind the skirting, and height.
const WALL_PROFILE: [(f64, f64); 9] = [
    (0.0, 0.0),
    (0.0, 0.12),
    (WALL, 0.12),
    (WALL, 0.86),
    (-0.005, 0.86),
    (-0.005, 0.92),
    (WALL, 0.92),
    (WALL, 2.4),
    (WALL, HEIGHT),
];

/// Bands of [`WALL_PROFILE`] that are treated apart.
const PANELS: usize = 2;
const PLASTER: usize = 6;

/// The bar's fixed parts stand here; they match the tiles.
pub(crate) const BAR_Z: [f64; 2] = [-3.3, 1.5];
pub(crate) const COUNTER_X: [f64; 2] = [1.2, 1.8];
pub(crate) const CABINET_X: [f64; 2] = [2.4, HALF_X + WALL];

/// Beams: middles, half width, underside.
const BEAMS_Z: [f64; 4] = [-3.15, -1.05, 1.05, 3.15];
const BEAM_HALF: f64 = 0.12;
const BEAM_BOTTOM: f64 = 2.82;

/// Columns stand under two of the beams.
const COLUMNS: [(f64, f64); 2] = [(-0.72, -3.15), (-0.72, 1.05)];

/// One wall as its front is seen: where it starts, to the right, and inwards.
struct Wall {
    name: &'static str,
    middle: DVec3,
    right: DVec3,
    inward: DVec3,
    breaks: Vec<f64>,
}

impl Wall {
    /// `s` to the right of the middle, `behind` the skirting, at a height; ends meet the next wall.
    fn point(&self, k: usize, (behind, y): (f64, f64)) -> DVec3 {
        let last = self.breaks.len() - 1;
        let s = match k {
            0 => self.breaks[0] - behind,
            k if k == last => self.breaks[k] + behind,
            k => self.breaks[k],
        };
        self.middle + s * self.right - behind * self.inward + y * DVec3::Y
    }

    fn cell(&self, k: usize, band: usize) -> [DVec3; 4] {
        let (low, high) = (WALL_PROFILE[band], WALL_PROFILE[band + 1]);
        [
            self.point(k, low),
            self.point(k + 1, low),
            self.point(k + 1, high),
            self.point(k, high),
        ]
    }
}

/// Multiples of the tile from `-half` to `half`.
fn tile_breaks(half: f64) -> Vec<f64> {
    let count = (2.0 * half / TILE).round() as usize;
    (0..=count).map(|k| k as f64 * TILE - half).collect()
}

fn inside(x: f64, [low, high]: [f64; 2]) -> bool {
    low < x && x < high
}

/// Everything that belongs to the building, and what hangs on its walls.
pub(crate) fn build(b: &mut SceneBuilder, p: &Palette) {
    floor(b, p);
    walls(b, p);
    ceiling(b, p);
    door(b, p);
    for z in [-2.1, 2.1] {
        b.object("window");
        window(b, p, z);
    }
    for (x, z) in COLUMNS {
        b.object("column");
        b.placed(at(x, 0.0, z, 0.0), |b| column(b, p));
    }
    pictures(b, p);
    clock(b, p);
}

fn floor(b: &mut SceneBuilder, p: &Palette) {
    b.object("floor");
    let (xs, zs) = (tile_breaks(HALF_X), tile_breaks(HALF_Z));
    for (j, z) in zs.windows(2).enumerate() {
        for (i, x) in xs.windows(2).enumerate() {
            let (mx, mz) = ((x[0] + x[1]) / 2.0, (z[0] + z[1]) / 2.0);
            if inside(mz, BAR_Z) && (inside(mx, COUNTER_X) || inside(mx, CABINET_X)) {
                continue;
            }
            let material = if (i + j) % 2 == 0 {
                p.tile_light
            } else {
                p.tile_dark
            };
            let tile = Rectangle {
                origin: dvec3(x[0], 0.0, z[1]),
                u: (x[1] - x[0]) * DVec3::X,
                v: (z[0] - z[1]) * DVec3::Z,
            };
            rectangle(b, material, tile);
        }
    }
}

/// The door's frame takes this part of the near wall, the windows these of the wall to the left.
const DOOR_X: [f64; 2] = [-0.1, 1.3];
const WINDOWS_Z: [[f64; 2]; 2] = [[-3.3, -0.9], [0.9, 3.3]];

fn walls(b: &mut SceneBuilder, p: &Palette) {
    let (x, z) = (DVec3::X, DVec3::Z);
    let mut near = tile_breaks(HALF_X);
    for s in &mut near {
        // Seen from inside, x runs to the left: the frame's sides replace the nearest tile joints.
        if (*s + 1.2).abs() < 1e-6 {
            *s = -DOOR_X[1];
        } else if s.abs() < 1e-6 {
            *s = -DOOR_X[0];
        }
    }
    for wall in [
        Wall {
            name: "wall_far",
            middle: -HALF_Z * z,
            right: x,
            inward: z,
            breaks: tile_breaks(HALF_X),
        },
        Wall {
            name: "wall_bar",
            middle: HALF_X * x,
            right: z,
            inward: -x,
            breaks: tile_breaks(HALF_Z),
        },
        Wall {
            name: "wall_door",
            middle: HALF_Z * z,
            right: -x,
            inward: -z,
            breaks: near,
        },
        Wall {
            name: "wall_windows",
            middle: -HALF_X * x,
            right: -z,
            inward: x,
            breaks: tile_breaks(HALF_Z),
        },
    ] {
        b.object(wall.name);
        for k in 0..wall.breaks.len() - 1 {
            let middle = wall.middle + 0.5 * (wall.breaks[k] + wall.breaks[k + 1]) * wall.right;
            for band in 0..WALL_PROFILE.len() - 1 {
                let absent = match wall.name {
                    "wall_bar" => band < PLASTER && inside(middle.z, BAR_Z),
                    "wall_door" => band <= PLASTER && inside(middle.x, DOOR_X),
                    "wall_windows" => {
                        band == PLASTER && WINDOWS_Z.iter().any(|&w| inside(middle.z, w))
                    }
                    _ => false,
                };
                if absent {
                    continue;
                }
                let corners = wall.cell(k, band);
                if band == PANELS {
                    let outer = Rectangle {
                        origin: corners[0],
                        u: corners[1] - corners[0],
                        v: corners[3] - corners[0],
                    };
                    let panel = framed(b, p.wainscot, outer, 0.07, 0.02, 0.012);
                    rectangle(b, p.wainscot, panel);
                } else {
                    let material = if band < PLASTER { p.trim } else { p.plaster };
                    b.face(material, &corners);
                }
            }
        }
    }
}

fn ceiling(b: &mut SceneBuilder, p: &Palette) {
    b.object("ceiling");
    let half = HALF_X + WALL;
    let xs = [-half, -1.8, -0.6, 0.6, 1.8, half];
    // Along z the ceiling falls to the beams' undersides and rises again.
    let mut outline = vec![(-HALF_Z - WALL, HEIGHT, p.ceiling)];
    for z in BEAMS_Z {
        outline.push((z - BEAM_HALF, HEIGHT, p.beam));
        outline.push((z - BEAM_HALF, BEAM_BOTTOM, p.beam));
        outline.push((z + BEAM_HALF, BEAM_BOTTOM, p.beam));
        outline.push((z + BEAM_HALF, HEIGHT, p.ceiling));
    }
    outline.push((HALF_Z + WALL, HEIGHT, p.ceiling));
    for step in outline.windows(2) {
        let ((z0, y0, material), (z1, y1, _)) = (step[0], step[1]);
        for x in xs.windows(2) {
            b.face(
                material,
                &[
                    dvec3(x[0], y0, z0),
                    dvec3(x[1], y0, z0),
                    dvec3(x[1], y1, z1),
                    dvec3(x[0], y1, z1),
                ],
            );
        }
    }
}

fn door(b: &mut SceneBuilder, p: &Palette) {
    b.object("door");
    // As seen from inside: u towards -x.
    let front = HALF_Z - 0.015;
    let leaf_z = HALF_Z + 0.1;
    let [x0, x1] = DOOR_X;
    let (width, casing) = (x1 - x0, 0.1);
    let point = |u: f64, y: f64, z: f64| dvec3(x1 - u, y, z);
    let outer = [(0.0, 0.0), (0.0, 2.4), (width, 2.4), (width, 0.0)];
    let inner = [
        (casing, 0.0),
        (casing, 2.4 - casing),
        (width - casing, 2.4 - casing),
        (width - casing, 0.0),
    ];
    for k in 0..3 {
        let ((ou, oy), (pu, py)) = (outer[k], outer[k + 1]);
        let ((iu, iy), (ju, jy)) = (inner[k], inner[k + 1]);
        let wall = HALF_Z + WALL;
        b.face(
            p.trim,
            &[
                point(ou, oy, wall),
                point(ou, oy, front),
                point(pu, py, front),
                point(pu, py, wall),
            ],
        );
        b.face(
            p.trim,
            &[
                point(ou, oy, front),
                point(iu, iy, front),
                point(ju, jy, front),
                point(pu, py, front),
            ],
        );
        b.face(
            p.trim,
            &[
                point(iu, iy, front),
                point(iu, iy, leaf_z),
                point(ju, jy, leaf_z),
                point(ju, jy, front),
            ],
        );
    }
    let half = 0.5 * width - casing;
    for leaf in 0..2 {
        let start = casing + half * f64::from(leaf);
        // Between the casings the floor goes on to the leaves.
        let threshold = Rectangle {
            origin: point(start, 0.0, HALF_Z),
            u: -half * DVec3::X,
            v: (leaf_z - HALF_Z) * DVec3::Z,
        };
        rectangle(b, p.tile_dark, threshold);
        let part = |y0: f64, y1: f64| Rectangle {
            origin: point(start, y0, leaf_z),
            u: -half * DVec3::X,
            v: (y1 - y0) * DVec3::Y,
        };
        let lower = framed(b, p.door, part(0.0, 0.9), 0.09, 0.03, 0.015);
        rectangle(b, p.door, lower);
        let upper = framed(b, p.door, part(0.9, 2.3), 0.09, 0.0, 0.03);
        for pane in upper.cells(1, 2) {
            let glass = framed(b, p.door, pane, 0.012, 0.0, 0.006);
            rectangle(b, p.window, glass);
        }
        // A handle beside the joint of the leaves.
        let u = start + if leaf == 0 { half - 0.045 } else { 0.045 };
        let grip = arc_path(
            point(u, 1.1, leaf_z),
            DVec3::Y,
            -DVec3::Z,
            0.07,
            [0.0, 180.0],
            6,
        );
        tube(b, p.brass, &grip, DVec3::X, 0.009, 6, Ends::Open);
    }
}

fn window(b: &mut SceneBuilder, p: &Palette, z: f64) {
    let outer = Rectangle {
        origin: dvec3(-HALF_X - WALL, 0.92, z + 1.2),
        u: -2.4 * DVec3::Z,
        v: 1.48 * DVec3::Y,
    };
    let recess = outer.inset(0.0, 0.1);
    border(b, p.window_frame, outer, recess);
    let opening = framed(b, p.window_frame, recess, 0.04, 0.01, 0.01);
    for (row, count) in [(dvec2(0.0, 0.7), 4), (dvec2(0.7, 1.0), 4)] {
        for pane in opening
            .part(dvec2(0.0, row.x), dvec2(1.0, row.y))
            .cells(count, 1)
        {
            let glass = framed(b, p.window_frame, pane, 0.02, 0.006, 0.012);
            rectangle(b, p.window, glass);
        }
    }
}

/// A slim cast-iron column between floor and beam.
fn column(b: &mut SceneBuilder, p: &Palette) {
    let profile = Profile::from(0.14, 0.0)
        .line(0.14, 0.08)
        .curve(&[[0.1, 0.12], [0.085, 0.18]])
        .line(0.075, 0.9)
        .curve(&[[0.09, 0.91], [0.09, 0.95], [0.072, 0.96]])
        .line(0.06, 2.6)
        .curve(&[[0.07, 2.7], [0.11, 2.77]])
        .line(0.11, BEAM_BOTTOM);
    lathe(b, p.iron, 12, &profile);
}

/// A frame that hangs on a wall; returns what is inside. Local: z off the wall.
fn hung_frame(
    b: &mut SceneBuilder,
    material: MaterialId,
    width: f64,
    height: f64,
    frame: f64,
) -> Rectangle {
    let wall = Rectangle {
        origin: dvec3(-width / 2.0, -height / 2.0, 0.0),
        u: width * DVec3::X,
        v: height * DVec3::Y,
    };
    let front = wall.inset(0.0, -0.03);
    border(b, material, wall, front);
    framed(b, material, front, frame, 0.015, 0.012)
}

fn pictures(b: &mut SceneBuilder, p: &Palette) {
    let far = -HALF_Z - WALL;
    let left = -HALF_X - WALL;
    // Place, yaw and width; then the colours of the cells from below to above, row by row.

    let hung: [(f64, f64, f64, f64); 5] = [
        (-1.75, far, 0.0, 1.0),
        (-0.25, far, 0.0, 0.66),
        (1.15, far, 0.0, 1.0),
        (left, 0.0, 90.0, 0.7),
        (-1.5, -far, 180.0, 0.9),
    ];
    let colours: [&[usize]; 5] = [
        &[1, 0, 4, 3, 2, 3, 5, 5, 2],
        &[4, 1, 0, 3, 2, 5],
        &[5, 2, 5, 1, 3, 0, 4, 3, 1],
        &[0, 1, 5, 3, 3, 2],
        &[2, 5, 1, 3, 0, 3],
    ];
    for ((x, z, yaw, width), colours) in hung.into_iter().zip(colours) {
        let (columns, height) = if width < 0.8 { (2, 0.85) } else { (3, 0.72) };
        b.object("picture");
        b.placed(at(x, 1.64, z, yaw), |b| {
            let canvas = hung_frame(b, p.gilt, width, height, 0.035);
            let mount = framed(b, p.chalk, canvas, 0.05, 0.0, 0.004);
            let rows = colours.len() as u32 / columns;
            for (cell, &colour) in mount.cells(columns, rows).into_iter().zip(colours) {
                rectangle(b, p.paints[colour], cell);
            }
        });
    }
    b.object("menu_board");
    b.placed(at(HALF_X + WALL, 1.78, 0.62, -90.0), |b| {
        let slate = hung_frame(b, p.shelf, 1.5, 0.95, 0.05);
        rectangle(b, p.board, slate);
        // Chalk: a headline, then two columns of dishes and prices, 2 mm before the slate.
        let before = slate.inset(0.0, -0.002);
        let stroke = |b: &mut SceneBuilder, x: [f64; 2], y: f64, height: f64| {
            rectangle(
                b,
                p.chalk,
                before.part(dvec2(x[0], y), dvec2(x[1], y + height)),
            );
        };
        stroke(b, [0.32, 0.68], 0.84, 0.06);
        stroke(b, [0.4, 0.6], 0.79, 0.015);
        for row in 0..7 {
            let y = 0.08 + 0.1 * f64::from(row);
            let length = 0.04 * f64::from((row * 5) % 4);
            stroke(b, [0.06, 0.24 + length], y, 0.03);
            stroke(b, [0.4, 0.46], y, 0.03);
            stroke(b, [0.55, 0.86 - length], y, 0.03);
            stroke(b, [0.9, 0.95], y, 0.03);
        }
    });
}

fn clock(b: &mut SceneBuilder, p: &Palette) {
    b.object("clock");
    let upright = at(0.6, 2.68, HALF_Z + WALL, 180.0)
        * glam::DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2);
    b.placed(upright, |b| {
        // Axis along local y, which is off the wall.
        let rim = Profile::from(0.17, 0.0)
            .line(0.17, 0.02)
            .curve(&[[0.165, 0.032], [0.155, 0.037], [0.145, 0.032]])
            .line(0.14, 0.02);
        lathe(b, p.brass, 20, &rim);
        lathe(
            b,
            p.porcelain,
            20,
            &Profile::from(0.14, 0.02).line(0.0, 0.02),
        );
        for (angle, length, y) in [(300.0, 0.075, 0.022), (50.0, 0.115, 0.025)] {
            b.placed(at(0.0, y, 0.0, angle), |b| {
                cuboid(
                    b,
                    p.rubber,
                    dvec3(-0.005, 0.0, -0.015),
                    dvec3(0.005, 0.002, length),
                    &[],
                );
            });
        }
    });
}
