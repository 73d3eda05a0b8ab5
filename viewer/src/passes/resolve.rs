//! Averages samples to pixels: linear radiance for files, display colours for the window.

use super::targets::{RADIANCE_FORMAT, Targets};
use super::{buffer, entry};
use crate::gpu::layout::ResolveUniforms;
use crate::gpu::{Gpu, shaders};

/// What the window shows: sRGB-encoded by the shader.
pub const DISPLAY_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// What comes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Radiance, [`RADIANCE_FORMAT`].
    Linear,
    /// Encoded, [`DISPLAY_FORMAT`].
    Display,
}

/// The pipelines.
#[derive(Debug)]
pub struct Resolve {
    linear: wgpu::RenderPipeline,
    display: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    uniforms: wgpu::Buffer,
}

impl Resolve {
    /// Compiles them.
    pub fn new(gpu: &Gpu) -> Self {
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let stage = wgpu::ShaderStages::FRAGMENT;
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("resolve"),
                entries: &[
                    entry(0, stage, buffer(wgpu::BufferBindingType::Uniform)),
                    entry(1, stage, texture),
                    entry(2, stage, texture),
                ],
            });
        let pipeline_layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("resolve"),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
        let module = shaders::RESOLVE.module(&gpu.device);
        let pipeline = |entry_point, format: wgpu::TextureFormat| {
            gpu.device
                .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some("resolve"),
                    layout: Some(&pipeline_layout),
                    vertex: wgpu::VertexState {
                        module: &module,
                        entry_point: Some("vertex"),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        buffers: &[],
                    },
                    primitive: wgpu::PrimitiveState::default(),
                    depth_stencil: None,
                    multisample: wgpu::MultisampleState::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &module,
                        entry_point: Some(entry_point),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        targets: &[Some(format.into())],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
        };
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        Self {
            linear: pipeline("linear", RADIANCE_FORMAT),
            display: pipeline("display", DISPLAY_FORMAT),
            uniforms: gpu.buffer("resolve", &[ResolveUniforms::default()], usage),
            layout,
        }
    }

    /// Binds the samples.
    pub fn bind(&self, gpu: &Gpu, targets: &Targets) -> wgpu::BindGroup {
        let view = |binding, view| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::TextureView(view),
        };
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("resolve"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: self.uniforms.as_entire_binding(),
                },
                view(1, &targets.radiance),
                view(2, &targets.tint),
            ],
        })
    }

    /// Takes effect with the next submission.
    pub fn write(&self, gpu: &Gpu, uniforms: &ResolveUniforms) {
        gpu.queue
            .write_buffer(&self.uniforms, 0, bytemuck::bytes_of(uniforms));
    }

    /// Fills `target`.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        samples: &wgpu::BindGroup,
        target: &wgpu::TextureView,
        output: Output,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("resolve"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            timestamp_writes: timestamps,
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(match output {
            Output::Linear => &self.linear,
            Output::Display => &self.display,
        });
        pass.set_bind_group(0, samples, &[]);
        pass.draw(0..3, 0..1);
    }
}
