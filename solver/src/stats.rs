//! Counters, bytes and seconds of a solve. The names are those of the `--stats` file.

use serde::{Deserialize, Serialize};

/// What a solve did and what it cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Stats {
    /// The scene as it was solved.
    pub scene: SceneStats,
    /// The solve.
    pub solve: SolveStats,
}

/// Size of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SceneStats {
    /// Triangles read.
    pub triangles: u64,
    /// Patches (quads and triangles) that the hierarchy starts from, one a side.
    pub patches: u64,
    /// Patches with a glossy material.
    pub glossy_patches: u64,
}

/// Size and cost of the solution.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SolveStats {
    /// Quality number of the solve.
    pub quality: f64,
    /// Elapsed [s].
    pub wall_s: f64,
    /// Processor time of all threads [s].
    pub cpu_s: f64,
    /// Reflections that were followed.
    pub iterations: u64,
    /// Power that surfaces sent on after each of them [W].
    pub reflected_w: Vec<f64>,
    /// Elements of the hierarchy, inner ones and leaves.
    pub elements: u64,
    /// Elements without children.
    pub leaves: u64,
    /// Clusters above the patches.
    pub clusters: u64,
    /// Links accepted, all iterations.
    pub links: u64,
    /// Of these, links between two single patches (or parts of them).
    pub patch_links: u64,
    /// Visibility rays cast.
    pub rays: u64,
    /// Illumination samples of the transport.
    pub illumination_samples: u64,
    /// Links and samples of the gathering at vertices.
    pub vertex_links: u64,
    /// Directional distributions made.
    pub distributions: u64,
    /// Basis functions (leaf cells) in them.
    pub basis_functions: u64,
    /// BRDF evaluations of the reflection.
    pub brdf_evaluations: u64,
    /// Power emitted [W].
    pub emitted_w: f64,
    /// Power absorbed by surfaces, those that light is taken not to reach among them, and by clear glass on the way [W].
    pub absorbed_w: f64,
    /// Power not yet followed when the solve was stopped [W]. Otherwise zero: what few iterations leave is summed as the
    /// series that it would become.
    pub unshot_w: f64,
    /// Power that left the scene [W], measured by rays of its own.
    pub escaped_w: f64,
    /// Power that links lost and that their receivers were given back [W]; negative where they had gained.
    pub corrected_w: f64,
    /// Largest resident memory of the process [B].
    pub peak_rss_bytes: u64,
    /// Memory by kind.
    pub bytes: ByteStats,
    /// Time by phase.
    pub phases_s: PhaseStats,
}

/// Memory by kind [B].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ByteStats {
    /// Elements, clusters, bounds, and the mesh that is shown.
    pub hierarchy: u64,
    /// Illumination samples.
    pub illumination_samples: u64,
    /// Directional distributions, of elements and of vertices.
    pub distributions: u64,
    /// All of these, which do not stand beside each other all the time.
    pub total: u64,
}

/// Time by phase [s], elapsed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PhaseStats {
    /// Reading the scene.
    pub load: f64,
    /// Patches, clusters, ray acceleration structure.
    pub hierarchy: f64,
    /// Link refinement, visibility included.
    pub propagate: f64,
    /// The part of propagation that is visibility (summed over threads, divided by their number).
    pub visibility: f64,
    /// Illumination samples to the leaves.
    pub push: f64,
    /// Reflection.
    pub reflect: f64,
    /// Leaving light to the root.
    pub pull: f64,
    /// Vertices, mesh, packing.
    pub export: f64,
}
