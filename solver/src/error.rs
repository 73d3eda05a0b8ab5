//! What can be wrong with a scene, and what can stop a solve.

/// A scene that cannot be solved as it stands.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The scene has no surface at all.
    #[error("the scene holds no surface: expected at least one triangle with an area")]
    NoSurface,
    /// An index points past the end of the table it indexes.
    #[error("triangle {triangle}: {kind} index {index} is out of range, {count} exist")]
    Index {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// `point`, `normal` or `material`.
        kind: &'static str,
        /// The index found.
        index: u32,
        /// Entries in that table.
        count: usize,
    },
    /// A position is NaN or infinite.
    #[error("triangle {triangle}: a corner is not finite (use --lenient to drop such triangles)")]
    NotFinite {
        /// Number of the triangle, from 0.
        triangle: usize,
    },
    /// A triangle has no area.
    #[error("triangle {triangle}: its corners span no area (use --lenient to drop such triangles)")]
    Degenerate {
        /// Number of the triangle, from 0.
        triangle: usize,
    },
    /// A triangle with the same corners and material stands in the scene already.
    #[error(
        "triangle {triangle}: has the same corners as triangle {first} (use --lenient to drop such triangles)"
    )]
    Duplicate {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// The earlier one.
        first: usize,
    },
    /// A shading normal is zero, not finite, not of unit length, or points away from its face.
    #[error(
        "triangle {triangle}: shading normal {normal:?} {reason} (use --lenient to rebuild it from the face)"
    )]
    Normal {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// As found.
        normal: [f32; 3],
        /// What is wrong with it.
        reason: &'static str,
    },
    /// Reflectance outside [0, 1], or diffuse + specular + transmitted above 1.
    #[error(
        "material '{material}': {what} is {value}, expected within 0..1 (use --lenient to rescale)"
    )]
    Reflectance {
        /// Name of the material.
        material: String,
        /// Which of its numbers.
        what: &'static str,
        /// As found.
        value: f32,
    },
    /// Roughness, exponent or another shape parameter outside its range.
    #[error("material '{material}': {what} is {value}, expected {expected}")]
    Parameter {
        /// Name of the material.
        material: String,
        /// Which of its numbers.
        what: &'static str,
        /// As found.
        value: f32,
        /// The range.
        expected: &'static str,
    },
    /// Emission or intensity that is NaN, negative or beyond any lamp.
    #[error("{light}: emission {value:?} must be finite, not negative and at most {limit:e}")]
    Emission {
        /// Material or lamp.
        light: String,
        /// As found, RGB.
        value: [f32; 3],
        /// Largest channel that is taken.
        limit: f32,
    },
    /// A camera that cannot make an image.
    #[error("camera '{camera}': {reason}")]
    Camera {
        /// Name of the camera.
        camera: String,
        /// What is wrong with it.
        reason: &'static str,
    },
}

/// Why a solve gave no solution.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// A knob outside its range.
    #[error("setting '{setting}' is {value}, expected {expected}")]
    Setting {
        /// Name of the knob.
        setting: &'static str,
        /// As given.
        value: f64,
        /// The range.
        expected: &'static str,
    },
    /// A surface that reflects everything: the series of reflections has no limit.
    #[error(
        "material '{material}' reflects {albedo} of what it receives: no finite solution exists, expected below 1"
    )]
    NoLoss {
        /// Name of the material.
        material: String,
        /// Its largest albedo.
        albedo: f32,
    },
    /// Its data does not fit into the memory limit, at no quality.
    #[error(
        "the scene needs more than {} MiB, the memory limit is {} MiB: give a higher --memory-limit, or a scene of fewer triangles",
        needed >> 20,
        limit >> 20
    )]
    Memory {
        /// As given [B].
        limit: u64,
        /// What was needed when the solve gave up [B]; all of it would be more.
        needed: u64,
    },
    /// The solution grew NaN or infinite.
    #[error("iteration {iteration}: the light of element {element} is not finite")]
    NotFinite {
        /// Iteration, from 0.
        iteration: usize,
        /// Element.
        element: u32,
    },
}
