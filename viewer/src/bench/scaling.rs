//! How time and memory grow with a scene: one room with more and finer things in it.

use super::fit::power_law;
use super::table::{Table, Value};
use crate::memory::peak_during;
use glam::Vec3;
use sheen_solver::{
    Gloss, Material, Observer, Progress, Rgb, Scene, SceneError, SceneParts, SolveConfig,
    SolveError, Triangle, solve,
};
use std::f32::consts::{PI, TAU};

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum ScalingError {
    /// A solve failed.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The scene is not one.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// Half the sides of the room, and its height [m].
const HALF: f32 = 4.0;
const HEIGHT: f32 = 3.0;

const WALL: u32 = 0;
const FLOOR: u32 = 1;
const LAMP: u32 = 2;
const BALL: u32 = 3;
const STAND: u32 = 4;

/// About so many triangles: balls on stands, whose number and fineness both grow with the root of it.
pub fn room(triangles: u32) -> Result<Scene, SceneError> {
    let rows = (2.0 * (triangles as f32 / 1000.0).powf(0.25))
        .round()
        .max(1.0) as u32;
    let of_ball = triangles as f32 / (rows * rows) as f32;
    // Bands b with 2b segments each have 4b (b - 1) triangles.
    let bands = (0.5 + (0.25 + 0.25 * of_ball).sqrt()).round().max(3.0) as u32;
    let phong = |name: &str, diffuse: [f32; 3], exponent: f32| Material {
        gloss: Gloss::Phong {
            specular: Rgb::splat(0.4),
            exponent,
        },
        ..Material::lambert(name, Rgb::from(diffuse))
    };
    let mut parts = SceneParts {
        materials: vec![
            Material::lambert("wall", Rgb::new(0.6, 0.58, 0.5)),
            phong("floor", [0.25, 0.2, 0.15], 40.0),
            Material {
                emission: Rgb::splat(20.0),
                ..Material::lambert("lamp", Rgb::BLACK)
            },
            phong("ball", [0.3, 0.1, 0.1], 60.0),
            Material::lambert("stand", Rgb::splat(0.4)),
        ],
        ..SceneParts::default()
    };
    let (x, z) = (Vec3::X * HALF, Vec3::Z * HALF);
    let (low, high) = (Vec3::ZERO, Vec3::Y * HEIGHT);
    quad(
        &mut parts,
        [low - x + z, low + x + z, low + x - z, low - x - z],
        FLOOR,
    );
    quad(
        &mut parts,
        [high - x - z, high + x - z, high + x + z, high - x + z],
        WALL,
    );
    for (along, out) in [(x, -z), (-x, z), (z, x), (-z, -x)] {
        let corners = [
            low + out - along,
            low + out + along,
            high + out + along,
            high + out - along,
        ];
        quad(&mut parts, corners, WALL);
    }
    for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let middle = high * 0.98 + 0.5 * (x * i + z * j);
        let (u, v) = (x * 0.1, z * 0.1);
        quad(
            &mut parts,
            [
                middle - u - v,
                middle + u - v,
                middle + u + v,
                middle - u + v,
            ],
            LAMP,
        );
    }
    let step = 2.0 * HALF / rows as f32;
    for row in 0..rows {
        for column in 0..rows {
            let at = |k: u32| -HALF + (k as f32 + 0.5) * step;
            // Heights differ, so that things stand in each other's light.
            let height = 0.4 + 0.9 * ((row * 7 + column * 3) % 5) as f32 / 5.0;
            let foot = Vec3::new(at(column), 0.0, at(row));
            stand(&mut parts, foot, 0.15 * step, height);
            ball(
                &mut parts,
                foot + Vec3::Y * (height + 0.25 * step),
                0.25 * step,
                bands,
            );
        }
    }
    Ok(Scene::new(parts, false)?.0)
}

fn quad(parts: &mut SceneParts, corners: [Vec3; 4], material: u32) {
    let first = parts.points.len() as u32;
    parts.points.extend(corners);
    for points in [[0, 1, 2], [0, 2, 3]] {
        parts.triangles.push(Triangle {
            points: points.map(|p| first + p),
            normals: None,
            material,
        });
    }
}

/// A box without top and bottom.
fn stand(parts: &mut SceneParts, foot: Vec3, half: f32, height: f32) {
    let (x, z, up) = (Vec3::X * half, Vec3::Z * half, Vec3::Y * height);
    for (along, out) in [(x, z), (-x, -z), (z, -x), (-z, x)] {
        let (left, right) = (foot + out - along, foot + out + along);
        quad(parts, [left, right, right + up, left + up], STAND);
    }
}

/// A smooth ball of `bands` from pole to pole.
fn ball(parts: &mut SceneParts, centre: Vec3, radius: f32, bands: u32) {
    let segments = 2 * bands;
    let (first_point, first_normal) = (parts.points.len() as u32, parts.normals.len() as u32);
    for band in 0..=bands {
        let ring = if band == 0 || band == bands {
            1
        } else {
            segments
        };
        let (out, up) = (PI * band as f32 / bands as f32).sin_cos();
        for segment in 0..ring {
            let (sine, cosine) = (TAU * segment as f32 / segments as f32).sin_cos();
            let normal = Vec3::new(out * cosine, up, -out * sine);
            parts.points.push(centre + normal * radius);
            parts.normals.push(normal);
        }
    }
    let vertex = |band: u32, segment: u32| match band {
        0 => 0,
        _ if band == bands => 1 + (bands - 1) * segments,
        _ => 1 + (band - 1) * segments + segment % segments,
    };
    let mut push = |corners: [u32; 3]| {
        parts.triangles.push(Triangle {
            points: corners.map(|c| first_point + c),
            normals: Some(corners.map(|c| first_normal + c)),
            material: BALL,
        });
    };
    for band in 0..bands {
        for segment in 0..segments {
            let (a, b) = (vertex(band, segment), vertex(band, segment + 1));
            let (c, d) = (vertex(band + 1, segment), vertex(band + 1, segment + 1));
            if band > 0 {
                push([a, d, b]);
            }
            if band + 1 < bands {
                push([a, c, d]);
            }
        }
    }
}

/// Solves rooms of about so many `triangles` each. Stopped by the observer: the rows that are there.
pub fn scaling(
    triangles: &[u32],
    config: &SolveConfig,
    observer: &mut dyn Observer,
) -> Result<Table, ScalingError> {
    let mut table = Table::new(
        "scaling",
        &format!(
            "One room with more and finer things in it, quality {}",
            config.quality.value()
        ),
        &[
            "triangles",
            "patches",
            "elements",
            "links",
            "rays",
            "s",
            "s a million",
            "MiB",
            "bytes a triangle",
        ],
    );
    let mut grown = Vec::new();
    for &triangles in triangles {
        let scene = room(triangles)?;
        let count = scene.triangles().len() as f64;
        let (solution, bytes) = peak_during(|| solve(&scene, config, observer));
        let stats = solution?.stats;
        let done = Progress {
            phase: "scaling",
            done: (table.rows.len() + 1) as f32,
        };
        if observer.report(&done).is_break() {
            break;
        }
        let seconds = stats.solve.wall_s;
        grown.push((count, seconds, bytes as f64));
        table.rows.push(vec![
            Value::Count(scene.triangles().len() as u64),
            Value::Count(stats.scene.patches),
            Value::Count(stats.solve.elements),
            Value::Count(stats.solve.links + stats.solve.vertex_links),
            Value::Count(stats.solve.rays),
            Value::Fixed(seconds, 2),
            Value::Fixed(seconds / count * 1e6, 1),
            Value::Fixed(bytes as f64 / f64::from(1 << 20), 1),
            Value::Fixed(bytes as f64 / count, 0),
        ]);
    }
    let time = power_law(grown.iter().map(|&(count, seconds, _)| (count, seconds)));
    let memory = power_law(grown.iter().map(|&(count, _, bytes)| (count, bytes)));
    if let (Some(time), Some(memory)) = (time, memory) {
        table.notes.push(format!(
            "Time grows as triangles to the power {time:.2}, memory to the power {memory:.2}."
        ));
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rooms_have_about_as_many_triangles_as_asked_for() {
        for asked in [1_000, 30_000, 1_000_000] {
            let scene = room(asked).expect("a scene");
            let share = scene.triangles().len() as f32 / asked as f32;
            assert!((0.8..1.25).contains(&share), "{asked}: {share}");
        }
    }

    #[test]
    fn everything_faces_outwards() {
        let scene = room(3_000).expect("a scene");
        for triangle in scene.triangles().iter().filter(|t| t.normals.is_some()) {
            let [a, b, c] = triangle.points.map(|p| scene.points()[p as usize]);
            let normals = triangle.normals.expect("filtered");
            let shading: Vec3 = normals.iter().map(|&n| scene.normals()[n as usize]).sum();
            assert!((b - a).cross(c - a).dot(shading) > 0.0, "{a} {b} {c}");
        }
    }
}
