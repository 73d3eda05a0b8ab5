//! `sheen info FILE`

use super::input;
use sheen_solver::{Camera, Gloss, Material, Rgb, Scene, Solution};
use std::f64::consts::PI;
use std::fmt::{Result as FmtResult, Write};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scene (.obj, .mgf) or solution (.sheen)
    file: PathBuf,
    /// Repair faults of the scene that can be repaired, and say so, instead of refusing it
    #[arg(long)]
    lenient: bool,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let mut text = String::new();
    if input::is_solution(&args.file) {
        write_solution(&mut text, &sheen_formats::solution::read(&args.file)?)?;
    } else {
        write_scene(
            &mut text,
            &input::load_scene(&args.file, args.lenient)?.scene,
        )?;
    }
    super::print(&text)
}

fn count(text: &mut String, name: &str, value: usize) -> FmtResult {
    writeln!(text, "{name:16} {value}")
}

fn bounds(text: &mut String, (low, high): (glam::Vec3, glam::Vec3)) -> FmtResult {
    writeln!(
        text,
        "{:16} ({}, {}, {}) to ({}, {}, {}) m",
        "bounds", low.x, low.y, low.z, high.x, high.y, high.z
    )
}

fn rgb(c: Rgb) -> String {
    format!("({:.4}, {:.4}, {:.4})", c.r, c.g, c.b)
}

/// One line a material; `triangles` counts those that have it.
fn materials(text: &mut String, materials: &[Material], triangles: &[usize]) -> FmtResult {
    count(text, "materials", materials.len())?;
    for (material, triangles) in materials.iter().zip(triangles) {
        write!(
            text,
            "  '{}': {triangles} triangles, diffuse {}",
            material.name,
            rgb(material.diffuse)
        )?;
        match material.gloss {
            Gloss::None => {}
            Gloss::Phong { specular, exponent } => {
                write!(text, ", Phong {} exponent {exponent}", rgb(specular))?
            }
            Gloss::Ward {
                specular,
                roughness,
            } => write!(text, ", Ward {} roughness {roughness}", rgb(specular))?,
        }
        if material.is_glass() {
            write!(text, ", clear {}", rgb(material.transmission))?;
        }
        if !material.emission.is_black() {
            write!(text, ", emits {} W/(sr m2)", rgb(material.emission))?;
        }
        writeln!(
            text,
            "{}",
            if material.two_sided {
                ""
            } else {
                ", one-sided"
            }
        )?;
    }
    Ok(())
}

fn cameras(text: &mut String, cameras: &[Camera]) -> FmtResult {
    count(text, "cameras", cameras.len())?;
    for c in cameras {
        let (eye, target) = (c.eye, c.target);
        writeln!(
            text,
            "  '{}': {}x{}, {} degrees, from {},{},{} to {},{},{}",
            c.name,
            c.width,
            c.height,
            c.fov_y_degrees,
            eye.x,
            eye.y,
            eye.z,
            target.x,
            target.y,
            target.z
        )?;
    }
    Ok(())
}

/// Power that leaves the scene's emitters [W], per channel: π L A a side, 4π I a point light.
fn emitted_watts(scene: &Scene) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let mut add = |colour: Rgb, factor: f64| {
        for (total, value) in sum.iter_mut().zip(colour.to_array()) {
            *total += f64::from(value) * factor;
        }
    };
    for triangle in scene.triangles() {
        let [a, b, c] = scene.corners(triangle).map(|corner| corner.as_dvec3());
        let material = &scene.materials()[triangle.material as usize];
        let sides = if material.emits_from_back { 2.0 } else { 1.0 };
        add(
            material.emission,
            PI * sides * 0.5 * (b - a).cross(c - a).length(),
        );
    }
    for light in scene.point_lights() {
        add(light.intensity, 4.0 * PI);
    }
    sum
}

fn write_scene(text: &mut String, scene: &Scene) -> FmtResult {
    let mut uses = vec![0; scene.materials().len()];
    let (mut glossy, mut clear) = (0, 0);
    for triangle in scene.triangles() {
        let material = &scene.materials()[triangle.material as usize];
        uses[triangle.material as usize] += 1;
        glossy += usize::from(material.is_glossy());
        clear += usize::from(material.is_glass());
    }
    count(text, "triangles", scene.triangles().len())?;
    count(text, "  glossy", glossy)?;
    count(text, "  clear", clear)?;
    count(
        text,
        "  smooth",
        scene
            .triangles()
            .iter()
            .filter(|t| t.normals.is_some())
            .count(),
    )?;
    count(text, "points", scene.points().len())?;
    count(text, "point lights", scene.point_lights().len())?;
    let watts = emitted_watts(scene);
    writeln!(
        text,
        "{:16} {:.6} W (R {:.6}, G {:.6}, B {:.6})",
        "emitted",
        watts.iter().sum::<f64>(),
        watts[0],
        watts[1],
        watts[2]
    )?;
    bounds(text, scene.bounds())?;
    materials(text, scene.materials(), &uses)?;
    cameras(text, scene.cameras())
}

fn write_solution(text: &mut String, solution: &Solution) -> FmtResult {
    let mut uses = vec![0; solution.materials.len()];
    let of_mesh = solution
        .triangles
        .iter()
        .map(|t| solution.material[t[0] as usize]);
    for material in of_mesh.chain(solution.glass_material.iter().copied()) {
        uses[material as usize] += 1;
    }
    count(text, "triangles", solution.triangles.len())?;
    count(text, "clear triangles", solution.glass_corners.len())?;
    count(text, "vertices", solution.position.len())?;
    count(text, "  glossy", crate::panels::glossy_vertices(solution))?;
    count(
        text,
        "distributions B",
        4 * solution.distribution_words.len(),
    )?;
    bounds(text, solution.bounds())?;
    materials(text, &solution.materials, &uses)?;
    cameras(text, &solution.cameras)?;
    writeln!(text, "statistics")?;
    for (name, value) in crate::panels::statistics(&solution.stats) {
        writeln!(text, "  {name:30} {value}")?;
    }
    Ok(())
}
