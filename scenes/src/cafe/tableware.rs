//! Crockery, bottles and cakes; each stands on the local plane y = 0 and is open where it stands.

use glam::{DVec3, dvec3};

use super::palette::Palette;
use crate::builder::{MaterialId, SceneBuilder};
use crate::shapes::{Ends, Profile, arc_path, at, lathe, sphere, strut, tube};

/// A cup on its foot ring, with coffee in it and a handle towards +x.
pub(crate) fn cup(b: &mut SceneBuilder, p: &Palette, glaze: MaterialId) {
    let wall = Profile::from(0.022, 0.0)
        .curve(&[[0.036, 0.018], [0.042, 0.06]])
        .line(0.037, 0.048);
    lathe(b, glaze, 10, &wall);
    lathe(
        b,
        p.coffee,
        10,
        &Profile::from(0.037, 0.048).line(0.0, 0.048),
    );
    let handle = arc_path(
        dvec3(0.041, 0.034, 0.0),
        DVec3::X,
        DVec3::Y,
        0.017,
        [-110.0, 85.0],
        3,
    );
    tube(b, glaze, &handle, DVec3::Z, 0.004, 4, Ends::Open);
}

/// A cup on a saucer.
pub(crate) fn cup_and_saucer(b: &mut SceneBuilder, p: &Palette, glaze: MaterialId) {
    let saucer = Profile::from(0.04, 0.0)
        .line(0.076, 0.015)
        .line(0.04, 0.006)
        .line(0.022, 0.006);
    lathe(b, p.porcelain, 10, &saucer);
    b.placed(at(0.0, 0.006, 0.0, 0.0), |b| cup(b, p, glaze));
}

/// A carafe of glazed ware.
pub(crate) fn carafe(b: &mut SceneBuilder, p: &Palette) {
    let body = Profile::from(0.045, 0.0)
        .curve(&[
            [0.064, 0.025],
            [0.064, 0.08],
            [0.033, 0.15],
            [0.027, 0.185],
            [0.036, 0.225],
        ])
        .line(0.03, 0.225)
        .line(0.0, 0.17);
    lathe(b, p.bottles[3], 10, &body);
}

/// A slim vase with a few flowers.
pub(crate) fn vase(b: &mut SceneBuilder, p: &Palette) {
    let body = Profile::from(0.03, 0.0)
        .curve(&[[0.042, 0.03], [0.036, 0.08], [0.018, 0.13], [0.024, 0.165]])
        .line(0.02, 0.165)
        .line(0.0, 0.13);
    lathe(b, p.porcelain, 12, &body);
    for (k, degrees) in [20.0_f64, 145.0, 260.0].into_iter().enumerate() {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let out = dvec3(cos, 0.0, sin);
        let head = 0.055 * out + (0.27 + 0.025 * k as f64) * DVec3::Y;
        strut(
            b,
            p.leaves,
            [0.004 * out + 0.14 * DVec3::Y, head],
            [0.003, 0.003],
            4,
        );
        sphere(b, p.petals, head, 0.024, 7, 4);
    }
}

/// A lidded bowl with a knob.
pub(crate) fn sugar_bowl(b: &mut SceneBuilder, p: &Palette) {
    let body = Profile::from(0.025, 0.0)
        .curve(&[[0.043, 0.02], [0.042, 0.055]])
        .line(0.046, 0.058)
        .curve(&[[0.035, 0.07], [0.01, 0.078]])
        .line(0.012, 0.09)
        .line(0.0, 0.096);
    lathe(b, p.porcelain, 10, &body);
}

/// One of three shapes of bottle.
pub(crate) fn bottle(b: &mut SceneBuilder, glass: MaterialId, shape: usize) {
    let profile = match shape % 3 {
        0 => Profile::from(0.036, 0.0)
            .line(0.036, 0.17)
            .curve(&[[0.033, 0.19], [0.02, 0.215], [0.014, 0.235]])
            .line(0.014, 0.295)
            .line(0.0, 0.295),
        1 => Profile::from(0.045, 0.0)
            .line(0.047, 0.13)
            .curve(&[[0.04, 0.155], [0.022, 0.172]])
            .line(0.015, 0.235)
            .line(0.02, 0.24)
            .line(0.02, 0.26)
            .line(0.0, 0.26),
        _ => Profile::from(0.034, 0.0)
            .curve(&[[0.047, 0.03], [0.044, 0.09], [0.022, 0.15], [0.016, 0.2]])
            .line(0.016, 0.255)
            .line(0.0, 0.262),
    };
    lathe(b, glass, 8, &profile);
}

/// A storage jar with a wooden lid.
pub(crate) fn jar(b: &mut SceneBuilder, p: &Palette, glaze: MaterialId) {
    let body = Profile::from(0.055, 0.0)
        .line(0.065, 0.02)
        .line(0.065, 0.14)
        .line(0.055, 0.16);
    lathe(b, glaze, 10, &body);
    let lid = Profile::from(0.055, 0.16)
        .line(0.06, 0.16)
        .line(0.06, 0.18)
        .line(0.0, 0.18);
    lathe(b, p.shelf, 10, &lid);
}

/// A pile of plates.
pub(crate) fn plates(b: &mut SceneBuilder, p: &Palette, count: u32) {
    let mut profile = Profile::from(0.06, 0.0);
    for k in 0..count {
        let y = 0.012 * f64::from(k);
        let next = if k + 1 < count {
            [0.07, y + 0.012]
        } else {
            [0.065, y + 0.006]
        };
        profile = profile.line(0.11, y + 0.013).line(next[0], next[1]);
    }
    lathe(
        b,
        p.porcelain,
        14,
        &profile.line(0.0, 0.012 * f64::from(count) - 0.006),
    );
}

/// A cake on a footed stand.
pub(crate) fn cake_stand(b: &mut SceneBuilder, p: &Palette, icing: MaterialId) {
    let stand = Profile::from(0.08, 0.0)
        .curve(&[[0.05, 0.014], [0.02, 0.035], [0.018, 0.07]])
        .curve(&[[0.05, 0.108], [0.15, 0.115]])
        .line(0.15, 0.123)
        .line(0.115, 0.118);
    lathe(b, p.porcelain, 16, &stand);
    let sponge = Profile::from(0.115, 0.118).line(0.115, 0.165);
    lathe(b, p.cake, 16, &sponge);
    let top = Profile::from(0.115, 0.165)
        .curve(&[[0.121, 0.174], [0.117, 0.19], [0.095, 0.196]])
        .line(0.0, 0.196);
    lathe(b, icing, 16, &top);
    for k in 0..6 {
        let (sin, cos) = (f64::from(k) * 60.0_f64).to_radians().sin_cos();
        sphere(
            b,
            p.vinyl,
            dvec3(0.08 * cos, 0.206, 0.08 * sin),
            0.013,
            6,
            3,
        );
    }
}
