//! `repr(C)` mirrors of the structures in `viewer/shaders`. A test compares their offsets.

use bytemuck::{Pod, Zeroable};

/// `Frame` of `shared/frame.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FrameUniforms {
    /// Clip space from points relative to the eye, column-major.
    pub clip_from_relative: [[f32; 4]; 4],
    /// Eye in world space [m].
    pub eye: [f32; 3],
    /// How much glossy triangles are tinted, 0..1.
    pub glossy_tint: f32,
    /// Radiance of wireframe lines [W·sr⁻¹·m⁻²].
    pub line_radiance: [f32; 3],
    /// Unused.
    pub padding: f32,
}

/// `GlossyVertex` of `evaluate.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GlossyVertex {
    /// World space [m].
    pub position: [f32; 3],
    /// Start of its distribution in the chunk's words.
    pub offset: u32,
    /// Part of the radiance that does not depend on direction.
    pub radiance: [f32; 3],
    /// Entry of the chunk's colours.
    pub vertex: u32,
}

/// `ShadedVertex` of `shade.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ShadedVertex {
    /// Unit.
    pub normal: [f32; 3],
    /// Start of its distribution in the chunk's words, or `NO_DISTRIBUTION`.
    pub offset: u32,
    /// Part of the radiance that does not depend on direction.
    pub radiance: [f32; 3],
    /// Unused.
    pub padding: u32,
}

/// `Resolve` of `resolve.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ResolveUniforms {
    /// Samples across and down a pixel.
    pub samples: u32,
    /// Not 0: the tint texture counts.
    pub has_glass: u32,
    /// Factor before display encoding.
    pub exposure: f32,
    /// Unused.
    pub padding: u32,
}

/// A corner of a clear surface, as `glass.wgsl` takes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GlassCorner {
    /// World space [m].
    pub position: [f32; 3],
    /// Part of the light that passes.
    pub tint: [f32; 3],
}

/// An end of a wireframe line, as `lines.wgsl` takes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LineEnd {
    /// World space [m].
    pub position: [f32; 3],
    /// Of the triangle it belongs to; any length.
    pub face_normal: [f32; 3],
}
