//! Bounds on links (§3.1) against brute force: Emin ≤ E ≤ Emax at random points of the receiver.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::{DVec3, Vec3};
use sheen_solver::config::{Quality, Settings};
use sheen_solver::geometry::Polygon;
use sheen_solver::hierarchy::{Hierarchy, NONE, NodeId};
use sheen_solver::solve::{FirstLinks, Prepared, first_links};
use sheen_solver::transport::link::Sender;
use sheen_solver::{Scene, transport::propagate::LinkRecord};
use sheen_tests::measure::{Random, lambert, relative, solid_angle};
use sheen_tests::scenes;
use sheen_tests::shared::shared;

/// Links that are looked at.
const LINKS: usize = 10_000;
/// This share of them must hold.
const SHARE: f64 = 0.999;
/// Sender parts of a link, about; each with a ray of its own.
const PARTS: usize = 256;
/// Bounds are f32 with some tens of roundings, the quadrature is exact per part but for its visibility.
const SLACK: f64 = 1e-3;

/// Elements below `id` that existed when the emitted light was computed and that emit.
fn emitting(links: &FirstLinks, id: NodeId, take: &mut Vec<NodeId>) {
    let count = links.emitted.len() as NodeId;
    if links.hierarchy.element_of(id).is_some() {
        if links.emitted.peak[id as usize] > 0.0 {
            take.push(id);
        }
        return;
    }
    for child in links.hierarchy.children(id).filter(|&child| child < count) {
        emitting(links, child, take);
    }
}

/// Splits `polygons` until there are about [`PARTS`] of them.
fn split(mut polygons: Vec<(Polygon, u32, f64)>) -> Vec<(Polygon, u32, f64)> {
    while polygons.len() * 4 <= PARTS {
        polygons = polygons
            .iter()
            .flat_map(|&(polygon, patch, radiance)| {
                (0..4).map(move |child| (polygon.child(child), patch, radiance))
            })
            .collect();
    }
    polygons
}

/// A random point on a random element below `id`, its normal and its patch.
fn random_point(hierarchy: &Hierarchy, id: NodeId, random: &mut Random) -> (Vec3, Vec3, u32) {
    let mut at = id;
    while hierarchy.element_of(at).is_none() {
        let children = hierarchy.children(at);
        at = children.start + random.below(children.len()) as NodeId;
    }
    let element = hierarchy.element_of(at).unwrap();
    (
        element.polygon.point(random.square()),
        element.normal,
        element.patch,
    )
}

/// Irradiance at a random point of the receiver, and what it were if nothing stood between: on its plane, or normal
/// irradiance where it is a cluster.
fn brute_force(
    prepared: &Prepared,
    links: &FirstLinks,
    record: &LinkRecord,
    random: &mut Random,
) -> (f64, f64) {
    let hierarchy = &links.hierarchy;
    let (point, normal, patch) = random_point(hierarchy, record.receiver, random);
    let is_cluster = hierarchy.element_of(record.receiver).is_none();
    let sender = Sender::new(hierarchy, record.sender);
    let radiance = |id: NodeId| f64::from(links.emitted.diffuse[id as usize].mean());
    let polygons = match sender.polygon {
        Some(polygon) => vec![(polygon, sender.patch, radiance(record.sender.node))],
        None => {
            let mut ids = Vec::new();
            emitting(links, record.sender.node, &mut ids);
            ids.iter()
                .map(|&id| {
                    let element = hierarchy.element_of(id).unwrap();
                    (element.polygon, element.patch, radiance(id))
                })
                .collect()
        }
    };
    let (mut sum, mut unoccluded) = (0.0, 0.0);
    for (polygon, sender_patch, radiance) in split(polygons) {
        let front = polygon.vector_area().as_dvec3();
        let corners = relative(polygon.corners(), point);
        if front.dot(corners[0]) >= 0.0 {
            continue;
        }
        let seen = if is_cluster {
            (1..corners.len() - 1)
                .map(|i| solid_angle([corners[0], corners[i], corners[i + 1]]))
                .sum()
        } else {
            lambert(&corners, DVec3::from(normal))
        };
        if seen > 0.0 {
            let ends = [patch, sender_patch];
            let passed = prepared
                .occluders
                .transmittance(point, polygon.centre(), ends);
            sum += seen * radiance * f64::from(passed.mean());
            unoccluded += seen * radiance;
        }
    }
    (sum, unoccluded)
}

fn check(name: &str, scene: &Scene) {
    let settings = Settings::of(Quality::DEFAULT);
    let prepared = Prepared::new(scene, &settings);
    let links = first_links(&prepared, &settings);
    links.hierarchy.assert_well_formed();
    let mut random = Random::new(7);
    let count = links.records.len();
    let with_low = links
        .records
        .iter()
        .filter(|record| record.low > 0.0)
        .count();
    let (mut held, mut low_known, mut clusters) = (0, 0, 0);
    let mut looseness = Vec::new();
    let mut worst: Option<(f64, f64, LinkRecord)> = None;
    let looked = count.min(LINKS);
    for index in 0..looked {
        let record = if count <= LINKS {
            links.records[index]
        } else {
            links.records[random.below(count)]
        };
        let (found, unoccluded) = brute_force(&prepared, &links, &record, &mut random);
        let (low, high) = (f64::from(record.low), f64::from(record.high));
        low_known += usize::from(low > 0.0);
        if unoccluded > 0.0 {
            looseness.push(high / unoccluded);
        }
        let receiver = links.hierarchy.element_of(record.receiver);
        clusters += usize::from(
            receiver.is_none() || Sender::new(&links.hierarchy, record.sender).patch == NONE,
        );
        // What is below a millionth of the upper bound is rounding of points on planes.
        let slack = SLACK * found + 1e-6 * high;
        let excess = (found - slack - high).max(low - found - slack);
        if excess <= 0.0 {
            held += 1;
        } else if worst
            .as_ref()
            .is_none_or(|(most, ..)| excess / high > *most)
        {
            worst = Some((excess / high, found, record));
        }
    }
    let share = held as f64 / looked as f64;
    looseness.sort_by(f64::total_cmp);
    let at = |part: f64| looseness[(looseness.len() as f64 * part) as usize];
    println!(
        "{name}: {count} links ({with_low} with a lower bound), {looked} looked at ({clusters} with a cluster, {low_known} with a \
         lower bound), {held} hold: {:.3} %; upper bound over unoccluded irradiance: median {:.2}, 95 % below {:.2}; worst {worst:?}",
        share * 100.0,
        at(0.5),
        at(0.95)
    );
    // Bounds that say nothing would hold as well: a median of 4 is far above what boxes cost and far below nothing.
    assert!(
        looseness.len() * 2 > looked && at(0.5) < 4.0,
        "{name}: bounds that say nothing, {}",
        at(0.5)
    );
    assert!(
        share >= SHARE,
        "{name}: {} of {looked} fail, worst {worst:?}",
        looked - held
    );
}

#[test]
fn links_of_the_cafe() {
    check("cafe", &scenes::own("cafe"));
}

#[test]
fn links_of_the_soda_shoppe() {
    let Some(shared) = shared("links_of_the_soda_shoppe") else {
        return;
    };
    check(
        "soda",
        &scenes::load(&shared.join("reference/scenes/soda.mgf")),
    );
}

#[test]
fn links_of_the_glossy_box() {
    check("cornell_box_glossy", &scenes::own("cornell_box_glossy"));
}
