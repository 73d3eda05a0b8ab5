//! What every iteration does, whatever scheme it belongs to: propagate exitant light, reflect what arrived, pull.

use super::arrived::Arrived;
use super::collected::Collected;
use super::escape::{Escape, escape};
use super::gathering::gather;
use super::reflecting::Ledger;
use super::shooting::shoot;
use super::{Prepared, Watch};
use crate::config::{Scheme, Settings};
use crate::error::SolveError;
use crate::hierarchy::{Hierarchy, NodeId};
use crate::radiometry::Rgb;
use crate::stats::Stats;
use crate::transport::clustering::Surfaces;
use crate::transport::exitant::Exitant;
use crate::transport::illumination::SampleSets;
use crate::transport::openness::Openness;
use crate::transport::propagate::{Accuracy, Arrivals, Gloss, LinkRecord, LinkStats, Propagation};
use crate::transport::pull::{PullConfig, pull};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::time::Instant;

/// Transport done: hierarchy, all light that arrives and leaves.
pub struct Transported {
    /// Clusters and elements as refined.
    pub hierarchy: Hierarchy,
    /// Light that arrived, per node: as samples, what may be mirrored.
    pub arrived: Arrived,
    /// All light that leaves, emission and every reflection.
    pub total: Exitant,
    /// Irradiance per node; zero for inner nodes.
    pub irradiance: Vec<Rgb>,
    /// Area per node.
    pub leaf_area: Vec<f32>,
    /// Gloss per cluster.
    pub cluster_gloss: Vec<Gloss>,
    /// Counters until now.
    pub stats: Stats,
}

/// As reports name it.
pub(super) const PHASE: &str = "light transport";

/// More reflections than any lossy scene needs before its unshot power is below the default share.
pub(super) const MAX_ITERATIONS: u64 = 4096;

/// Runs the iterations. Errors: light that is not finite.
pub(crate) fn transport(
    prepared: &Prepared,
    settings: &Settings,
    watch: &mut Watch<'_>,
) -> Result<Transported, SolveError> {
    let mut iteration = Iteration::new(prepared, settings);
    match settings.scheme {
        Scheme::Shooting => shoot(&mut iteration, watch)?,
        Scheme::Gathering => gather(&mut iteration, watch)?,
    }
    Ok(iteration.finish())
}

/// Light transport alone, nothing is gathered at vertices: for those who want to check elements. Errors: light that is
/// not finite.
pub fn transported(prepared: &Prepared, settings: &Settings) -> Result<Transported, SolveError> {
    transport(prepared, settings, &mut Watch::new(&mut (), None, None))
}

/// Everything about the links of the first iteration, where senders are emitters and their radiance is exact.
pub struct FirstLinks {
    /// Clusters and elements as refined by them.
    pub hierarchy: Hierarchy,
    /// Emitted light; only the nodes that it names can send.
    pub emitted: Exitant,
    /// The links with their bounds.
    pub records: Vec<LinkRecord>,
    /// Irradiance samples that they left.
    pub samples: SampleSets,
}

/// Propagates emitted light once and keeps every link, for those who want to check bounds (§3.1).
pub fn first_links(prepared: &Prepared, settings: &Settings) -> FirstLinks {
    let mut first = Iteration::new(prepared, settings);
    let emitted = first.sent.clone();
    let power = emitted.power.first().copied().unwrap_or(0.0);
    let mut records = Vec::new();
    let mut samples = SampleSets::default();
    let environment = prepared.environment();
    let mut hierarchy = std::mem::take(&mut first.hierarchy);
    let propagation = Propagation {
        environment: &environment,
        exitant: &emitted,
        node_count: hierarchy.nodes.len(),
        cluster_gloss: &first.cluster_gloss,
        accuracy: Accuracy {
            tolerance: settings.link_tolerance * power,
            most_irradiance: settings.link_irradiance * power / hierarchy.node(0).area,
            min_radius: settings.min_radius,
            strata: settings.strata,
            visibility: settings.visibility,
        },
        with_point_lights: true,
        seed: 0,
        record: true,
    };
    let mut go_on = |_| ControlFlow::Continue(());
    propagation.run(&mut hierarchy, &mut samples, &mut records, &mut go_on);
    FirstLinks {
        hierarchy,
        emitted,
        records,
        samples,
    }
}

pub(super) fn mean(light: DVec3) -> f64 {
    light.element_sum() / 3.0
}

/// The state of a solve between iterations.
pub(super) struct Iteration<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) settings: &'a Settings,
    pub(super) hierarchy: Hierarchy,
    /// Light that has arrived: as samples, what glossy leaves will reflect again.
    pub(super) arrived: Arrived,
    /// What of it diffuse leaves have reflected.
    pub(super) collected: Collected,
    /// Emitted power of surfaces.
    pub(super) emitted: DVec3,
    /// The light that the next iteration sends, pulled.
    pub(super) sent: Exitant,
    cluster_gloss: Vec<Gloss>,
    pub(super) openness: Openness,
    pub(super) stats: Stats,
    links: LinkStats,
    /// Power that clear glass has absorbed, or sides that light is taken not to reach.
    pub(super) taken: f64,
}

impl<'a> Iteration<'a> {
    fn new(prepared: &'a Prepared, settings: &'a Settings) -> Self {
        let started = Instant::now();
        let hierarchy = prepared.hierarchy();
        let mut stats = Stats::default();
        stats.scene.patches = hierarchy.elements.len() as u64;
        let glossy = |e: &&crate::hierarchy::Element| prepared.lobes[e.material as usize].is_some();
        stats.scene.glossy_patches = hierarchy.elements.iter().filter(glossy).count() as u64;
        let cluster_gloss = gloss_of_clusters(prepared, &hierarchy);
        let openness = Openness::new(&hierarchy, &prepared.occluders);
        stats.solve.phases_s.hierarchy = prepared.seconds + started.elapsed().as_secs_f64();
        let mut first = Self {
            prepared,
            settings,
            hierarchy,
            arrived: Arrived::none(settings.method),
            collected: Collected::default(),
            emitted: DVec3::ZERO,
            sent: Exitant::default(),
            cluster_gloss,
            openness,
            stats,
            links: LinkStats::default(),
            taken: 0.0,
        };
        let config = first.reflect_config(0.0);
        let (emitted, _, ledger) =
            first.reflected(&Arrived::default(), &Collected::default(), &config, true);
        (first.sent, first.emitted) = (emitted, ledger.exitance);
        let how = first.pull_config(0.0);
        pull(&first.hierarchy, &mut first.sent, &how);
        first
    }

    fn pull_config(&self, emitted: f64) -> PullConfig {
        PullConfig {
            least: self.reflect_config(emitted).least,
            epsilon: self.settings.transport_epsilon,
            cluster_epsilon: self.settings.cluster_epsilon,
            basis: self.settings.basis,
        }
    }

    /// Power that is sent by point lights, per channel.
    pub(super) fn of_point_lights(&self) -> DVec3 {
        let lights = &self.prepared.frame.point_lights;
        lights.iter().map(|l| l.1.to_dvec3() * 4.0 * PI).sum()
    }

    /// Propagates the light that is sent; `seed` chooses the rays of stray light.
    pub(super) fn propagated(
        &mut self,
        with_point_lights: bool,
        seed: u32,
        emitted: f64,
        watch: &mut Watch<'_>,
        done: f32,
    ) -> Arrived {
        let started = Instant::now();
        let environment = self.prepared.environment();
        let propagation = Propagation {
            environment: &environment,
            exitant: &self.sent,
            node_count: self.hierarchy.nodes.len(),
            cluster_gloss: &self.cluster_gloss,
            accuracy: Accuracy {
                tolerance: self.settings.link_tolerance * emitted as f32,
                most_irradiance: self.settings.link_irradiance * emitted as f32
                    / self.hierarchy.node(0).area,
                min_radius: self.settings.min_radius,
                strata: self.settings.strata,
                visibility: self.settings.visibility,
            },
            with_point_lights,
            seed,
            record: false,
        };
        let mut new = Arrived::none(self.settings.method);
        if let Arrived::Reflected(_) = &new {
            // What is pushed at once finds the leaves that there are.
            self.openness
                .look(&self.hierarchy, &self.prepared.occluders);
        }
        let held = self.held();
        let mut report = |new: usize| watch.report(PHASE, done, held + new);
        let config = self.reflect_config(emitted);
        let surfaces = Surfaces {
            lobes: &self.prepared.lobes,
            diffuse: &self.prepared.diffuse,
            openness: &self.openness,
        };
        let mut pushing;
        let arrivals: &mut dyn Arrivals = match &mut new {
            Arrived::Samples(samples) => samples,
            Arrived::Reflected(reflections) => {
                pushing = reflections.pushing(surfaces, config);
                &mut pushing
            }
        };
        let links = propagation.run(&mut self.hierarchy, arrivals, &mut Vec::new(), &mut report);
        self.links.add(&links);
        let solve = &mut self.stats.solve;
        solve.illumination_samples += links.samples;
        if let Arrived::Samples(samples) = &mut new {
            self.openness
                .look(&self.hierarchy, &self.prepared.occluders);
            samples.ask(&self.hierarchy, &self.openness);
        }
        if let Arrived::Reflected(reflections) = &mut new {
            reflections.settle(&self.hierarchy);
            // What is sent, what it becomes, and what was sent before.
            let held = self.sent.bytes() + reflections.bytes() + self.arrived.bytes();
            solve.bytes.distributions = solve.bytes.distributions.max(held as u64);
            solve.distributions += reflections.cost.distributions;
            solve.basis_functions += reflections.cost.basis_functions;
            solve.brdf_evaluations += reflections.cost.brdf_evaluations;
        }
        solve.phases_s.propagate += started.elapsed().as_secs_f64();
        new
    }

    /// Bytes of all that is kept from one iteration to the next.
    pub(super) fn held(&self) -> usize {
        self.prepared.bytes()
            + self.hierarchy.bytes()
            + self.openness.bytes()
            + self.arrived.bytes()
            + self.collected.bytes()
            + self.sent.bytes()
    }

    /// Keeps what has arrived and been reflected: samples for glossy leaves, which reflect them all together in the end, of
    /// all else only what they have collected.
    pub(super) fn accumulate(&mut self, new: Arrived) {
        let (hierarchy, lobes) = (&self.hierarchy, &self.prepared.lobes);
        let keep = |id: NodeId| match hierarchy.element_of(id) {
            Some(element) => lobes[element.material as usize].is_some(),
            None => self.cluster_gloss[id as usize].share > 0.0,
        };
        self.arrived.absorb(hierarchy, new, keep);
    }

    /// What of the light that is sent, a `share` of the emitted, leaves the scene.
    pub(super) fn escape(&self, with_point_lights: bool, share: f64) -> Escape {
        const RAYS: f64 = 524_288.0;
        const LEAST_RAYS: f64 = 4096.0;
        let lights: &[(Vec3, Rgb)] = if with_point_lights {
            &self.prepared.frame.point_lights
        } else {
            &[]
        };
        let rays = (RAYS * share).clamp(LEAST_RAYS, RAYS) as u32;
        escape(self.prepared, &self.hierarchy, &self.sent, lights, rays)
    }

    /// Makes what `arrived` becomes the light that is sent next, with all emission or without. Irradiance per node, and
    /// the sums.
    pub(super) fn send(
        &mut self,
        arrived: &Arrived,
        emission: bool,
        emitted: f64,
    ) -> (Vec<Rgb>, Ledger) {
        let started = Instant::now();
        self.sent = Exitant::default();
        let config = self.reflect_config(emitted);
        let (sent, irradiance, ledger) =
            self.reflected(arrived, &Collected::default(), &config, emission);
        self.sent = sent;
        self.stats.solve.phases_s.reflect += started.elapsed().as_secs_f64();
        let started = Instant::now();
        let how = self.pull_config(emitted);
        pull(&self.hierarchy, &mut self.sent, &how);
        let solve = &mut self.stats.solve;
        solve.phases_s.pull += started.elapsed().as_secs_f64();
        let bytes = &mut solve.bytes.distributions;
        *bytes = (*bytes).max(self.sent.bytes() as u64);
        (irradiance, ledger)
    }

    /// Errors: light that is not finite after `iteration`.
    pub(super) fn check_finite(&self, iteration: u64) -> Result<(), SolveError> {
        let powers = &self.sent.power;
        if powers[0].is_finite() {
            return Ok(());
        }
        let element = powers.iter().position(|p| !p.is_finite()).unwrap_or(0);
        Err(SolveError::NotFinite {
            iteration: iteration as usize,
            element: element as u32,
        })
    }

    fn finish(mut self) -> Transported {
        let started = Instant::now();
        let config = self.reflect_config(self.stats.solve.emitted_w);
        self.sent = Exitant::default();
        let arrived = std::mem::take(&mut self.arrived);
        let collected = std::mem::take(&mut self.collected);
        let (mut total, irradiance, ledger) = self.reflected(&arrived, &collected, &config, true);
        self.stats.solve.phases_s.reflect += started.elapsed().as_secs_f64();
        let how = self.pull_config(self.stats.solve.emitted_w);
        pull(&self.hierarchy, &mut total, &how);
        let solve = &mut self.stats.solve;
        let by_surfaces = mean(ledger.received - (ledger.exitance - self.emitted));
        solve.absorbed_w = by_surfaces + self.taken;
        solve.elements = self.hierarchy.elements.len() as u64;
        solve.leaves = self
            .hierarchy
            .elements
            .iter()
            .filter(|e| self.hierarchy.is_leaf(e.node))
            .count() as u64;
        solve.clusters = self.hierarchy.cluster_count() as u64;
        solve.links = self.links.links;
        solve.patch_links = self.links.patch_links;
        solve.rays = self.links.rays;
        solve.phases_s.visibility =
            self.links.visibility.as_secs_f64() / rayon::current_num_threads() as f64;
        solve.bytes.hierarchy =
            (self.hierarchy.bytes() + self.openness.bytes() + self.prepared.bytes()) as u64;
        let (samples, reflections) = match &arrived {
            Arrived::Samples(samples) => (samples.bytes(), 0),
            Arrived::Reflected(reflections) => (0, reflections.bytes()),
        };
        solve.bytes.illumination_samples = samples as u64;
        let held = (total.bytes() + reflections) as u64;
        solve.bytes.distributions = solve.bytes.distributions.max(held);
        let powers = [
            &mut solve.emitted_w,
            &mut solve.absorbed_w,
            &mut solve.unshot_w,
            &mut solve.escaped_w,
            &mut solve.corrected_w,
        ];
        for watts in powers.into_iter().chain(&mut solve.reflected_w) {
            *watts = self.prepared.frame.power(*watts) * 3.0;
        }
        Transported {
            leaf_area: self.hierarchy.nodes.iter().map(|n| n.area).collect(),
            hierarchy: self.hierarchy,
            arrived,
            total,
            irradiance,
            cluster_gloss: self.cluster_gloss,
            stats: self.stats,
        }
    }
}

/// Specular share and sharpest lobe of what lies below each cluster.
fn gloss_of_clusters(prepared: &Prepared, hierarchy: &Hierarchy) -> Vec<Gloss> {
    let mut specular_area = vec![0.0f32; hierarchy.nodes.len()];
    let mut gloss = vec![
        Gloss {
            share: 0.0,
            width: std::f32::consts::PI
        };
        hierarchy.nodes.len()
    ];
    for id in crate::transport::pull::bottom_up(hierarchy) {
        let at = id as usize;
        if let Some(element) = hierarchy.element_of(id) {
            let lobe = prepared.lobes[element.material as usize].as_ref();
            gloss[at] = Gloss::of(lobe, prepared.diffuse[element.material as usize]);
            specular_area[at] = gloss[at].share * hierarchy.node(id).reflecting_area;
        } else {
            for child in hierarchy.children(id) {
                specular_area[at] += specular_area[child as usize];
                if gloss[child as usize].share > 0.0 {
                    gloss[at].width = gloss[at].width.min(gloss[child as usize].width);
                }
            }
            gloss[at].share = specular_area[at] / hierarchy.node(id).reflecting_area;
        }
    }
    gloss
}
