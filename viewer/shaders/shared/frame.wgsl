// Group 0: what every pass of a frame shares. The mirror is `FrameUniforms` in gpu/layout.rs.
struct Frame {
    clip_from_relative: mat4x4<f32>, // of a point relative to the eye [m]
    eye: vec3<f32>,                  // in world space [m]
    glossy_tint: f32,                // 0: off, 1: glossy triangles in the tint alone
    line_radiance: vec3<f32>,        // of wireframe lines [W·sr⁻¹·m⁻²]
    padding: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
