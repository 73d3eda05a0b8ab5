//! Shooting (§3.4): iteration i moves only light that has been reflected exactly i times.
//!
//! New samples are reflected once, then appended to the accumulated ones; distributions live for one iteration. At
//! the end all accumulated samples are reflected together: that is the exitant light that the export gathers.

use super::escape::{Escape, escape};
use super::series::{Drift, conserving, geometric};
use super::{Emission, Prepared, Watch};
use crate::config::Settings;
use crate::directional::Projector;
use crate::error::SolveError;
use crate::hierarchy::{Hierarchy, NodeId};
use crate::radiometry::Rgb;
use crate::stats::Stats;
use crate::transport::exitant::Exitant;
use crate::transport::illumination::SampleSets;
use crate::transport::openness::Openness;
use crate::transport::propagate::{Accuracy, Gloss, LinkRecord, LinkStats, Propagation};
use crate::transport::pull::pull;
use crate::transport::reflect::{ReflectConfig, Reflected, Surface, reflect};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::time::Instant;

/// Transport done: hierarchy, all light that arrives and leaves.
pub struct Transported {
    /// Clusters and elements as refined.
    pub hierarchy: Hierarchy,
    /// Accumulated samples per node.
    pub samples: SampleSets,
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
const PHASE: &str = "light transport";

/// More reflections than any lossy scene needs before its unshot power is below the default share.
const MAX_ITERATIONS: u64 = 4096;

/// Runs the iterations. Errors: light that is not finite.
pub(crate) fn transport(
    prepared: &Prepared,
    settings: &Settings,
    watch: &mut Watch<'_>,
) -> Result<Transported, SolveError> {
    let mut shooting = Shooting::new(prepared, settings);
    shooting.run(watch)?;
    Ok(shooting.finish())
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
    let mut shooting = Shooting::new(prepared, settings);
    let emitted = shooting.unshot.clone();
    let power = emitted.power.first().copied().unwrap_or(0.0);
    let mut records = Vec::new();
    let mut samples = SampleSets::default();
    let environment = prepared.environment();
    let mut hierarchy = std::mem::take(&mut shooting.hierarchy);
    let propagation = Propagation {
        environment: &environment,
        exitant: &emitted,
        node_count: hierarchy.nodes.len(),
        cluster_gloss: &shooting.cluster_gloss,
        accuracy: Accuracy {
            tolerance: settings.link_tolerance * power,
            most_irradiance: settings.link_irradiance * power / hierarchy.node(0).area,
            min_radius: settings.min_radius,
            strata: settings.strata,
        },
        with_point_lights: true,
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

/// Power that all surfaces receive and that they send on, per channel.
#[derive(Clone, Copy, Debug, Default)]
struct Ledger {
    received: DVec3,
    exitance: DVec3,
}

fn mean(light: DVec3) -> f64 {
    light.element_sum() / 3.0
}

/// The state of the iteration.
pub(crate) struct Shooting<'a> {
    prepared: &'a Prepared,
    settings: &'a Settings,
    hierarchy: Hierarchy,
    accumulated: SampleSets,
    /// Emitted power of surfaces.
    emitted: DVec3,
    unshot: Exitant,
    cluster_gloss: Vec<Gloss>,
    openness: Openness,
    stats: Stats,
    links: LinkStats,
    /// Power that clear glass has absorbed.
    in_glass: f64,
}

impl<'a> Shooting<'a> {
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
        let mut shooting = Self {
            prepared,
            settings,
            hierarchy,
            accumulated: SampleSets::default(),
            emitted: DVec3::ZERO,
            unshot: Exitant::default(),
            cluster_gloss,
            openness,
            stats,
            links: LinkStats::default(),
            in_glass: 0.0,
        };
        let config = shooting.reflect_config(0.0);
        let (emitted, _, ledger) = shooting.reflected(&SampleSets::default(), &config, true);
        (shooting.unshot, shooting.emitted) = (emitted, ledger.exitance);
        pull(
            &shooting.hierarchy,
            &mut shooting.unshot,
            settings.transport_epsilon,
        );
        shooting
    }

    fn run(&mut self, watch: &mut Watch<'_>) -> Result<(), SolveError> {
        let point_lights = &self.prepared.frame.point_lights;
        let of_lights = point_lights.iter().map(|l| l.1.to_dvec3() * 4.0 * PI);
        // Unshot light as `unshot` has it, and what it must be multiplied with.
        let mut sent = self.emitted + of_lights.sum::<DVec3>();
        let mut factor = DVec3::ONE;
        let emitted = mean(sent);
        let solve = &mut self.stats.solve;
        (solve.emitted_w, solve.unshot_w) = (emitted, emitted);
        if emitted <= 0.0 {
            return Ok(());
        }
        let goal = f64::from(self.settings.unshot_share);
        let mut drift = Drift::new(&self.hierarchy, &self.unshot, &self.prepared.detail);
        let mut open = 1.0;
        for iteration in 0..MAX_ITERATIONS {
            // Each reflection weakens the light: progress goes with the logarithm of what is open.
            let done = 0.5 * (1.0 - (open / goal).ln() / (1.0 / goal).ln()) as f32;
            let escape = self.escape(iteration == 0, mean(sent * factor) / emitted);
            let mut new = self.propagated(iteration == 0, emitted, watch, done);
            let reflected = self.reflected_new(&new, emitted);
            let _ = watch.report(PHASE, done, self.held() + new.bytes());
            self.stats.solve.iterations = iteration + 1;
            self.check_finite(iteration)?;

            let stopped = watch.is_stopped();
            let correction = if stopped {
                DVec3::ONE
            } else {
                conserving(sent, &escape, reflected.received)
            };
            let shot = sent * factor;
            factor *= correction;
            let left = reflected.exitance * factor;
            self.stats.solve.reflected_w.push(mean(left));
            let tail = if stopped {
                DVec3::ONE
            } else {
                geometric(shot, left)
            };
            let ratio = mean(left) / mean(shot);
            let wrong = drift.error(&self.unshot, mean(factor), ratio);
            let brightest = drift.brightest(&self.unshot, mean(factor));
            open = wrong.min(brightest.max(mean(left) / emitted));
            let is_last = stopped || open <= goal;

            // The last iteration stands for all that would follow.
            let weight = if is_last { factor * tail } else { factor };
            new.scale(Rgb::from(weight.to_array().map(|c| c as f32)));
            let started = Instant::now();
            self.accumulated.absorb(new);
            let solve = &mut self.stats.solve;
            solve.phases_s.push += started.elapsed().as_secs_f64();
            let weight = if is_last { tail } else { DVec3::ONE };
            solve.escaped_w += mean(escape.share * shot * weight);
            self.in_glass += mean(escape.in_glass * shot * weight);
            solve.corrected_w += mean(reflected.received * (factor - factor / correction) * weight);
            sent = reflected.exitance;
            if is_last {
                // Of an iteration that was stopped, some receivers had nothing yet.
                let arrived = reflected.received * factor;
                let on_its_way = shot * (1.0 - escape.share - escape.in_glass) - arrived;
                solve.unshot_w = if stopped {
                    mean(left) + mean(on_its_way).max(0.0)
                } else {
                    0.0
                };
                break;
            }
            solve.unshot_w = mean(left);
        }
        Ok(())
    }

    /// Propagates the unshot light.
    fn propagated(
        &mut self,
        with_point_lights: bool,
        emitted: f64,
        watch: &mut Watch<'_>,
        done: f32,
    ) -> SampleSets {
        let started = Instant::now();
        let environment = self.prepared.environment();
        let propagation = Propagation {
            environment: &environment,
            exitant: &self.unshot,
            node_count: self.hierarchy.nodes.len(),
            cluster_gloss: &self.cluster_gloss,
            accuracy: Accuracy {
                tolerance: self.settings.link_tolerance * emitted as f32,
                most_irradiance: self.settings.link_irradiance * emitted as f32
                    / self.hierarchy.node(0).area,
                min_radius: self.settings.min_radius,
                strata: self.settings.strata,
            },
            with_point_lights,
            record: false,
        };
        let mut new = SampleSets::default();
        let held = self.held();
        let mut report = |new: usize| watch.report(PHASE, done, held + new);
        let links = propagation.run(&mut self.hierarchy, &mut new, &mut Vec::new(), &mut report);
        self.links.add(&links);
        let solve = &mut self.stats.solve;
        solve.illumination_samples += new.len() as u64;
        solve.phases_s.propagate += started.elapsed().as_secs_f64();
        new
    }

    /// Bytes of all that is kept from one iteration to the next.
    fn held(&self) -> usize {
        self.prepared.bytes()
            + self.hierarchy.bytes()
            + self.openness.bytes()
            + self.accumulated.bytes()
            + self.unshot.bytes()
    }

    /// What of the unshot light, a `share` of the emitted, leaves the scene.
    fn escape(&self, with_point_lights: bool, share: f64) -> Escape {
        const RAYS: f64 = 524_288.0;
        const LEAST_RAYS: f64 = 4096.0;
        let lights: &[(Vec3, Rgb)] = if with_point_lights {
            &self.prepared.frame.point_lights
        } else {
            &[]
        };
        let rays = (RAYS * share).clamp(LEAST_RAYS, RAYS) as u32;
        escape(self.prepared, &self.hierarchy, &self.unshot, lights, rays)
    }

    /// Makes what `new` samples leave the unshot light.
    fn reflected_new(&mut self, new: &SampleSets, emitted: f64) -> Ledger {
        let started = Instant::now();
        self.unshot = Exitant::default();
        let config = self.reflect_config(emitted);
        let (unshot, _, ledger) = self.reflected(new, &config, false);
        self.unshot = unshot;
        self.stats.solve.phases_s.reflect += started.elapsed().as_secs_f64();
        let started = Instant::now();
        pull(
            &self.hierarchy,
            &mut self.unshot,
            self.settings.transport_epsilon,
        );
        let solve = &mut self.stats.solve;
        solve.phases_s.pull += started.elapsed().as_secs_f64();
        let bytes = &mut solve.bytes.distributions;
        *bytes = (*bytes).max(self.unshot.bytes() as u64);
        ledger
    }

    /// Errors: light that is not finite after `iteration`.
    fn check_finite(&self, iteration: u64) -> Result<(), SolveError> {
        let powers = &self.unshot.power;
        if powers[0].is_finite() {
            return Ok(());
        }
        let element = powers.iter().position(|p| !p.is_finite()).unwrap_or(0);
        Err(SolveError::NotFinite {
            iteration: iteration as usize,
            element: element as u32,
        })
    }

    fn reflect_config(&self, emitted: f64) -> ReflectConfig {
        // The mean radiance of the scene were all its light spread evenly.
        let mean = (emitted / (PI * f64::from(self.hierarchy.node(0).area))) as f32;
        ReflectConfig {
            epsilon: self.settings.transport_epsilon,
            max_level: self.settings.transport_level,
            floor: 0.3,
            least: self.settings.least_directional * mean,
            conserve: true,
        }
    }

    /// Exitant light of all leaves in answer to `samples`, not pulled yet; irradiance per node; and the sums.
    fn reflected(
        &mut self,
        samples: &SampleSets,
        config: &ReflectConfig,
        emission: bool,
    ) -> (Exitant, Vec<Rgb>, Ledger) {
        let hierarchy = &self.hierarchy;
        let prepared = self.prepared;
        let leaves: Vec<NodeId> = hierarchy
            .elements
            .iter()
            .map(|e| e.node)
            .filter(|&id| hierarchy.is_leaf(id))
            .collect();
        let openness = &self.openness;
        let reflected: Vec<Reflected> = leaves
            .par_iter()
            .with_max_len(64)
            .map_init(
                || (Projector::default(), Vec::new()),
                |(projector, field), &id| {
                    let element = &hierarchy.elements[hierarchy.node(id).element as usize];
                    let material = element.material as usize;
                    field.clear();
                    // Moved directions leave gaps in the lobes that links were refined for.
                    let glossy = prepared.lobes[material].is_some();
                    samples.field(hierarchy, id, glossy, openness, field);
                    let emission = if emission {
                        prepared.emission(element.patch, element.back)
                    } else {
                        Emission::default()
                    };
                    // What light cannot reach has its share of what larger parts received; it is next to nothing.
                    let is_dark = field.is_empty() || element.exposed.is_none();
                    if is_dark && emission == Emission::default() {
                        return Reflected::default();
                    }
                    let surface = Surface {
                        normal: hierarchy.shading_normal(element),
                        diffuse: prepared.diffuse[material],
                        lobe: prepared.lobes[material].as_ref(),
                        compensating: emission.compensating,
                        bend: hierarchy.bend(element),
                    };
                    let mut reflected = reflect(field, &surface, config, projector);
                    reflected.diffuse += emission.even;
                    reflected.exitance += emission.even * PI as f32;
                    reflected
                },
            )
            .collect();
        let mut exitant = Exitant::dark(hierarchy);
        let mut irradiance = vec![Rgb::BLACK; hierarchy.nodes.len()];
        let mut ledger = Ledger::default();
        for (&id, reflected) in leaves.iter().zip(reflected) {
            let area = hierarchy.node(id).area;
            ledger.received += reflected.irradiance.to_dvec3() * f64::from(area);
            ledger.exitance += reflected.exitance.to_dvec3() * f64::from(area);
            irradiance[id as usize] = reflected.irradiance;
            let at = id as usize;
            exitant.diffuse[at] += reflected.diffuse;
            exitant.power[at] += reflected.exitance.mean() * area;
            exitant.peak[at] = exitant.diffuse[at].mean();
            if let Some(words) = &reflected.distribution {
                exitant.peak[at] += crate::directional::packed::peak(words);
                self.stats.solve.distributions += 1;
            }
            exitant.distribution[at] = reflected.distribution;
            self.stats.solve.basis_functions += reflected.cost.basis_functions;
            self.stats.solve.brdf_evaluations += reflected.brdf_evaluations;
        }
        (exitant, irradiance, ledger)
    }

    fn finish(mut self) -> Transported {
        let started = Instant::now();
        let config = self.reflect_config(self.stats.solve.emitted_w);
        self.unshot = Exitant::default();
        let samples = std::mem::take(&mut self.accumulated);
        let (mut total, irradiance, ledger) = self.reflected(&samples, &config, true);
        self.stats.solve.phases_s.reflect += started.elapsed().as_secs_f64();
        pull(&self.hierarchy, &mut total, self.settings.transport_epsilon);
        let solve = &mut self.stats.solve;
        let by_surfaces = mean(ledger.received - (ledger.exitance - self.emitted));
        solve.absorbed_w = by_surfaces + self.in_glass;
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
        solve.bytes.illumination_samples = samples.bytes() as u64;
        solve.bytes.distributions = solve.bytes.distributions.max(total.bytes() as u64);
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
            samples,
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
