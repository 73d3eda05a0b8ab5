//! Hand-made solutions: a room with glossy surfaces, a lamp and a pane of glass.
#![allow(dead_code, reason = "each test binary uses its part")]

use glam::Vec3;
use sheen_formats::image::Image;
use sheen_solver::directional::octahedron;
use sheen_solver::directional::packed::{self, Part};
use sheen_solver::solution::NO_DISTRIBUTION;
use sheen_solver::{Camera, Gloss, Material, Rgb, Solution};
use sheen_viewer::gpu::Gpu;

/// The device, or `None` with a loud line; with SHEEN_REQUIRE_GPU=1 its absence is a failure.
pub(crate) fn gpu(test: &str) -> Option<Gpu> {
    match Gpu::headless() {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(
                std::env::var_os("SHEEN_REQUIRE_GPU").is_none_or(|v| v != "1"),
                "{test}: {error}"
            );
            eprintln!("\n######## SKIPPED: {test}: {error} ########\n");
            None
        }
    }
}

/// Packs `radiance` into a full tree of this level, one at least; faces below the horizon of `normal` stay black.
pub(crate) fn pack(
    level: usize,
    normal: Vec3,
    scale: f32,
    radiance: &dyn Fn(Vec3) -> Rgb,
) -> Vec<u32> {
    assert_eq!(scale.to_bits() & 0x007f_ffff, 0, "a power of two");
    let part = |(corners, depth): (octahedron::Corners, usize)| {
        if corners.iter().all(|corner| corner.dot(normal) <= 0.0) {
            return Part::Black;
        }
        if depth == level {
            return Part::Leaf;
        }
        let midpoints = octahedron::edge_midpoints(corners);
        let child = |child| {
            (
                octahedron::child_corners(corners, midpoints, child),
                depth + 1,
            )
        };
        let ([a, b, c], [m12, m20, m01]) = (corners, midpoints);
        Part::Split {
            children: [0, 1, 2, 3].map(child),
            colours: [a, b, c, m12, m20, m01]
                .map(|corner| packed::encode(radiance(corner) / scale)),
            is_mean: [false; 3],
        }
    };
    let octants = [0, 1, 2, 3, 4, 5, 6, 7].map(|octant| (octahedron::octant_corners(octant), 0));
    let mut words = Vec::new();
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let axes = axes.map(|axis| packed::encode(radiance(axis) / scale));
    packed::pack(scale, axes, octants, part, &mut words);
    assert!(packed::is_well_formed(&words));
    words
}

/// A lobe around `axis`.
pub(crate) fn lobe(axis: Vec3, exponent: i32, colour: Rgb) -> impl Fn(Vec3) -> Rgb {
    move |direction| colour * direction.dot(axis).max(0.0).powi(exponent)
}

fn material(name: &str, is_glossy: bool, transmission: Rgb) -> Material {
    let gloss = if is_glossy {
        Gloss::Phong {
            specular: Rgb::splat(0.3),
            exponent: 40.0,
        }
    } else {
        Gloss::None
    };
    Material {
        gloss,
        transmission,
        ..Material::lambert(name, Rgb::splat(0.4))
    }
}

/// An empty solution with materials matt, glossy, lamp and glass, and one camera.
pub(crate) fn empty() -> Solution {
    let mut lamp = material("lamp", false, Rgb::BLACK);
    lamp.emission = Rgb::new(20.0, 18.0, 15.0);
    Solution {
        materials: vec![
            material("matt", false, Rgb::BLACK),
            material("glossy", true, Rgb::BLACK),
            lamp,
            material("glass", false, Rgb::new(0.5, 0.8, 0.6)),
        ],
        cameras: vec![Camera {
            name: "front".to_owned(),
            eye: Vec3::new(0.3, 1.1, 3.4),
            target: Vec3::new(0.0, 0.7, 0.0),
            up: Vec3::Y,
            fov_y_degrees: 50.0,
            width: 160,
            height: 120,
        }],
        ..Solution::default()
    }
}

/// Adds a grid of `n` × `n` quads on the parallelogram, its front on the side of `u` × `v`.
pub(crate) fn add_grid(
    solution: &mut Solution,
    (corner, u, v): (Vec3, Vec3, Vec3),
    n: u32,
    material: u32,
    radiance: &dyn Fn(Vec3) -> Rgb,
    distribution: Option<&dyn Fn(Vec3) -> Vec<u32>>,
) {
    let first = solution.position.len() as u32;
    let normal = u.cross(v).normalize();
    for j in 0..=n {
        for i in 0..=n {
            let position = corner + u * (i as f32 / n as f32) + v * (j as f32 / n as f32);
            solution.position.push(position);
            solution.normal.push(normal);
            solution.radiance.push(radiance(position));
            solution.material.push(material);
            let offset = distribution.map_or(NO_DISTRIBUTION, |pack| {
                let start = solution.distribution_words.len() as u32;
                solution.distribution_words.extend(pack(position));
                start
            });
            solution.distribution_offset.push(offset);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let at = |di: u32, dj: u32| first + (j + dj) * (n + 1) + i + di;
            solution.triangles.push([at(0, 0), at(1, 0), at(1, 1)]);
            solution.element_edges.push(0b011);
            solution.triangles.push([at(0, 0), at(1, 1), at(0, 1)]);
            solution.element_edges.push(0b110);
        }
    }
}

/// A glossy floor that mirrors a lamp at (0, 2, -1), a matt back wall, the lamp, a box's side, a pane of glass.
pub(crate) fn room() -> Solution {
    let mut s = empty();
    let lamp = Vec3::new(0.0, 2.0, -1.0);
    let floor = move |position: Vec3| {
        let incoming = (lamp - position).normalize();
        let mirrored = Vec3::new(-incoming.x, incoming.y, -incoming.z);
        pack(
            3,
            Vec3::Y,
            8.0,
            &lobe(mirrored, 12, Rgb::new(3.0, 2.5, 1.5)),
        )
    };
    let falloff = move |position: Vec3| {
        Rgb::new(0.5, 0.4, 0.6) * (1.0 / (0.5 + position.distance_squared(lamp)))
    };
    let floor_at = (Vec3::new(-2.0, 0.0, 2.0), Vec3::X * 4.0, Vec3::NEG_Z * 4.0);
    add_grid(&mut s, floor_at, 12, 1, &falloff, Some(&floor));
    let wall_at = (Vec3::new(-2.0, 0.0, -2.0), Vec3::X * 4.0, Vec3::Y * 2.5);
    add_grid(&mut s, wall_at, 8, 0, &falloff, None);
    let lamp_at = (
        lamp + Vec3::new(-0.3, 0.0, -0.3),
        Vec3::X * 0.6,
        Vec3::Z * 0.6,
    );
    add_grid(&mut s, lamp_at, 1, 2, &|_| Rgb::new(20.0, 18.0, 15.0), None);
    // A tilted panel that casts a silhouette on the floor, glossy too, seen from both sides: twice in the mesh.
    let (u, v) = (Vec3::new(0.8, 0.1, 0.3), Vec3::new(-0.1, 0.9, 0.1));
    let corner = Vec3::new(-1.2, 0.2, -0.4);
    let panel = |normal: Vec3| {
        move |position: Vec3| {
            pack(
                2,
                normal,
                1.0,
                &lobe(normal, 3, Rgb::new(0.3, 0.6, 0.9) * (1.0 + position.y)),
            )
        }
    };
    let normal = u.cross(v).normalize();
    add_grid(&mut s, (corner, u, v), 3, 1, &falloff, Some(&panel(normal)));
    add_grid(
        &mut s,
        (corner, v, u),
        3,
        1,
        &|_| Rgb::new(0.1, 0.02, 0.02),
        Some(&panel(-normal)),
    );
    let (a, b) = (Vec3::new(0.3, 0.1, 0.9), Vec3::new(1.3, 0.1, 0.5));
    let up = Vec3::Y * 1.2;
    s.glass_corners = vec![[a, b, b + up], [a, b + up, a + up]];
    s.glass_material = vec![3, 3];
    s
}

/// Largest difference of a channel of every pixel, of 255, after tone mapping alike.
pub(crate) fn display_differences(a: &Image, b: &Image) -> Vec<u8> {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let exposure = sheen_viewer::tonemap::default_exposure(&a.pixels);
    let bytes = |image: &Image| sheen_viewer::tonemap::display_bytes(&image.pixels, exposure);
    let differences: Vec<u8> = bytes(a)
        .iter()
        .zip(bytes(b))
        .map(|(x, y)| x.abs_diff(y))
        .collect();
    differences
        .chunks_exact(3)
        .map(|pixel| pixel.iter().copied().max().unwrap_or(0))
        .collect()
}
