//! Visibility rays a second: between random points of the surfaces, and those that a solve asks for.

use super::table::{Table, Value};
use glam::{Vec2, Vec3};
use sheen_solver::geometry::hash;
use sheen_solver::solve::{Prepared, transported};
use sheen_solver::transport::query::Query;
use sheen_solver::{Scene, SolveConfig, SolveError};
use std::time::Instant;

/// Random rays keep this share of their length away from their ends.
const GAP: f32 = 1e-4;
/// Of so many runs the fastest counts.
const RUNS: u32 = 3;

/// A ray: where it begins, and the way to its end.
pub type Segment = [Vec3; 2];

/// What was measured, and with what.
pub struct RayBench {
    /// Rays a second.
    pub table: Table,
    /// The rays by kind, in the scene's units.
    pub kinds: Vec<(&'static str, Vec<Segment>)>,
}

/// Times at most `most` rays of each kind on this thread. Errors: as a solve.
pub fn rays(scene: &Scene, config: &SolveConfig, most: usize) -> Result<RayBench, SolveError> {
    let settings = config.settings()?;
    let mut prepared = Prepared::new(scene, &settings);
    let random = random_queries(scene, &prepared, most);
    prepared.occluders.record(most);
    transported(&prepared, &settings)?;
    let solve = prepared.occluders.recorded();
    let mut table = Table::new(
        "rays",
        "Visibility rays, one thread",
        &["rays", "number", "blocked %", "million a second"],
    );
    let mut kinds = Vec::new();
    for (name, queries) in [("random", random), ("solve", solve)] {
        let (blocked, seconds) = timed(&prepared, &queries);
        let count = queries.len() as f64;
        table.rows.push(vec![
            Value::Text(name.to_owned()),
            Value::Count(queries.len() as u64),
            Value::Fixed(100.0 * blocked as f64 / count, 2),
            Value::Fixed(count / seconds * 1e-6, 3),
        ]);
        let segment = |query: &Query| {
            let (start, way) = query.part();
            let [start, end] = [start, start + way].map(|at| prepared.frame.position(at));
            [start, end - start]
        };
        kinds.push((name, queries.iter().map(segment).collect()));
    }
    table.notes.push(
        "Random rays join points that are spread evenly over all surfaces; those of a solve are its first between two points, in the order in which it asks."
            .to_owned(),
    );
    Ok(RayBench { table, kinds })
}

/// How many are blocked, and the least time that finding out takes [s].
fn timed(prepared: &Prepared, queries: &[Query]) -> (usize, f64) {
    let run = |_| {
        let started = Instant::now();
        let blocked = queries.iter().filter(|q| !prepared.occluders.passes(q));
        (blocked.count(), started.elapsed().as_secs_f64())
    };
    (0..RUNS)
        .map(run)
        .fold((0, f64::INFINITY), |(_, least), (blocked, seconds)| {
            (blocked, seconds.min(least))
        })
}

/// Between points that are spread evenly over all surfaces.
fn random_queries(scene: &Scene, prepared: &Prepared, count: usize) -> Vec<Query> {
    let corners = |t: &sheen_solver::Triangle| t.points.map(|p| prepared.frame.points[p as usize]);
    let mut area = 0.0f64;
    let until: Vec<f64> = scene
        .triangles()
        .iter()
        .map(|triangle| {
            let [a, b, c] = corners(triangle);
            area += f64::from((b - a).cross(c - a).length());
            area
        })
        .collect();
    let point = |seed: u32| {
        let at = f64::from(hash::unit(seed, 0)) * area;
        let triangle = until.partition_point(|&sum| sum <= at);
        let [a, b, c] = corners(&scene.triangles()[triangle.min(until.len() - 1)]);
        let uv = Vec2::new(hash::unit(seed, 1), hash::unit(seed, 2));
        let uv = if uv.element_sum() > 1.0 {
            Vec2::ONE - uv
        } else {
            uv
        };
        a + (b - a) * uv.x + (c - a) * uv.y
    };
    (0..count as u32)
        .map(|ray| Query::between(point(2 * ray), point(2 * ray + 1), GAP))
        .collect()
}

/// Rays as a NumPy array of n × 6 numbers of 32 bits.
pub fn npy(rays: &[Segment]) -> Vec<u8> {
    let mut header = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, 6), }}",
        rays.len()
    );
    // What precedes the numbers is a multiple of 64 bytes and ends with a line feed (NumPy's format 1.0).
    const BEFORE: usize = 10;
    let end = (BEFORE + header.len() + 1).next_multiple_of(64);
    header.extend(std::iter::repeat_n(' ', end - BEFORE - header.len() - 1));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    let numbers = rays.iter().flatten().flat_map(|v| v.to_array());
    bytes.extend(numbers.flat_map(f32::to_le_bytes));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_has_the_header_that_numpy_reads() {
        let rays = [[Vec3::X, Vec3::Y], [Vec3::Z, Vec3::NEG_X]];
        let bytes = npy(&rays);
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        assert_eq!(bytes.len(), 10 + length + 2 * 6 * 4);
        let header = std::str::from_utf8(&bytes[10..10 + length]).expect("text");
        assert!(header.contains("(2, 6)") && header.ends_with('\n'));
        assert_eq!(bytes[10 + length..][..4], 1.0f32.to_le_bytes());
    }
}
