//! Steps of a frame: evaluate glossy vertices, draw triangles, lines and glass, resolve samples to pixels.

pub mod evaluate;
pub mod geometry;
pub mod resolve;
pub mod targets;

use wgpu::BindingType;

/// An entry of a bind group layout.
fn entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    ty: BindingType,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    }
}

/// A buffer of the kind that a shader declares.
fn buffer(ty: wgpu::BufferBindingType) -> BindingType {
    BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

/// Group 0 of every pass but the last: the frame.
#[derive(Debug)]
pub struct FrameGroup {
    /// Its layout.
    pub layout: wgpu::BindGroupLayout,
    /// The group.
    pub group: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
}

impl FrameGroup {
    /// One frame's uniforms, to be overwritten.
    pub fn new(gpu: &crate::gpu::Gpu) -> Self {
        let stages = wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::VERTEX_FRAGMENT;
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("frame"),
                entries: &[entry(0, stages, buffer(wgpu::BufferBindingType::Uniform))],
            });
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let uniforms = gpu.buffer(
            "frame",
            &[crate::gpu::layout::FrameUniforms::default()],
            usage,
        );
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: uniforms.as_entire_binding(),
            }],
        });
        Self {
            layout,
            group,
            uniforms,
        }
    }

    /// Takes effect with the next submission.
    pub fn write(&self, gpu: &crate::gpu::Gpu, frame: &crate::gpu::layout::FrameUniforms) {
        gpu.queue
            .write_buffer(&self.uniforms, 0, bytemuck::bytes_of(frame));
    }
}
