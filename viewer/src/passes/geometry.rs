//! Draws triangles, wireframe lines and glass.

use super::targets::{DEPTH_FORMAT, RADIANCE_FORMAT, TINT_FORMAT, Targets};
use super::{FrameGroup, buffer, entry};
use crate::gpu::{Gpu, shaders};
use wgpu::VertexFormat::{Float32x3, Float32x4};

/// Pipelines of what is drawn.
#[derive(Debug)]
pub struct Geometry {
    mesh: wgpu::RenderPipeline,
    shade: wgpu::RenderPipeline,
    shade_layout: wgpu::BindGroupLayout,
    lines: wgpu::RenderPipeline,
    glass: wgpu::RenderPipeline,
}

/// Buffers of a part of the mesh.
#[derive(Debug)]
pub struct MeshBuffers {
    /// Positions, three f32 each.
    pub positions: wgpu::Buffer,
    /// Radiance and glossy flag, four f32 each.
    pub colours: wgpu::Buffer,
    /// Corners of triangles, u32.
    pub indices: wgpu::Buffer,
    /// Number of `indices`.
    pub index_count: u32,
}

/// What of it is drawn.
#[derive(Clone, Copy, Debug)]
pub enum MeshPart<'a> {
    /// With the radiance of its vertices.
    Coloured(&'a MeshBuffers),
    /// Shaded sample by sample: what [`Geometry::bind`] made, and the number of corners.
    Shaded(&'a wgpu::BindGroup, u32),
}

/// A plain list of vertices.
#[derive(Debug)]
pub struct VertexList {
    /// The vertices.
    pub buffer: wgpu::Buffer,
    /// How many.
    pub count: u32,
}

fn vertex_buffer<'a>(
    stride: u64,
    attributes: &'a [wgpu::VertexAttribute],
) -> Option<wgpu::VertexBufferLayout<'a>> {
    Some(wgpu::VertexBufferLayout {
        array_stride: stride,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes,
    })
}

struct Plan<'a> {
    shader: shaders::Shader,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    group: Option<&'a wgpu::BindGroupLayout>,
    topology: wgpu::PrimitiveTopology,
    cull: Option<wgpu::Face>,
    target: wgpu::ColorTargetState,
    writes_depth: bool,
}

fn pipeline(gpu: &Gpu, frame: &FrameGroup, plan: &Plan<'_>) -> wgpu::RenderPipeline {
    let module = plan.shader.module(&gpu.device);
    let layout = gpu
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(plan.shader.label),
            bind_group_layouts: &[Some(&frame.layout), plan.group]
                [..1 + usize::from(plan.group.is_some())],
            immediate_size: 0,
        });
    gpu.device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(plan.shader.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: plan.buffers,
            },
            primitive: wgpu::PrimitiveState {
                topology: plan.topology,
                front_face: wgpu::FrontFace::Ccw,
                cull_mode: plan.cull,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(plan.writes_depth),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(plan.target.clone())],
            }),
            multiview_mask: None,
            cache: None,
        })
}

impl Geometry {
    /// Compiles the pipelines.
    pub fn new(gpu: &Gpu, frame: &FrameGroup) -> Self {
        let radiance = wgpu::ColorTargetState::from(RADIANCE_FORMAT);
        let multiply = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::Dst,
            dst_factor: wgpu::BlendFactor::Zero,
            operation: wgpu::BlendOperation::Add,
        };
        let tint = wgpu::ColorTargetState {
            format: TINT_FORMAT,
            blend: Some(wgpu::BlendState {
                color: multiply,
                alpha: multiply,
            }),
            write_mask: wgpu::ColorWrites::ALL,
        };
        let position = wgpu::vertex_attr_array![0 => Float32x3];
        let colour = wgpu::vertex_attr_array![1 => Float32x4];
        let pair = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
        debug_assert_eq!((Float32x3.size(), Float32x4.size()), (12, 16));
        let mesh = Plan {
            shader: shaders::MESH,
            buffers: &[vertex_buffer(12, &position), vertex_buffer(16, &colour)],
            group: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
            // What is seen from both sides stands in the mesh twice.
            cull: Some(wgpu::Face::Back),
            target: radiance.clone(),
            writes_depth: true,
        };
        let stage = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let storage = buffer(wgpu::BufferBindingType::Storage { read_only: true });
        let shade_layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("shade"),
                entries: &[0, 1, 2, 3].map(|binding| entry(binding, stage, storage)),
            });
        let shade = Plan {
            shader: shaders::SHADE,
            buffers: &[],
            group: Some(&shade_layout),
            target: radiance.clone(),
            ..mesh
        };
        let lines = Plan {
            shader: shaders::LINES,
            buffers: &[vertex_buffer(24, &pair)],
            group: None,
            topology: wgpu::PrimitiveTopology::LineList,
            cull: None,
            target: radiance,
            writes_depth: false,
        };
        let glass = Plan {
            shader: shaders::GLASS,
            buffers: &[vertex_buffer(24, &pair)],
            group: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull: None,
            target: tint,
            writes_depth: false,
        };
        Self {
            shade: pipeline(gpu, frame, &shade),
            mesh: pipeline(gpu, frame, &mesh),
            lines: pipeline(gpu, frame, &lines),
            glass: pipeline(gpu, frame, &glass),
            shade_layout,
        }
    }

    /// Binds the buffers of a chunk to be shaded sample by sample.
    pub fn bind(
        &self,
        gpu: &Gpu,
        mesh: &MeshBuffers,
        vertices: &wgpu::Buffer,
        words: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let buffers = [&mesh.positions, &mesh.indices, vertices, words];
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shade"),
            layout: &self.shade_layout,
            entries: &entries,
        })
    }

    /// Draws the opaque mesh and the lines over it, then the glass before it.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameGroup,
        targets: &Targets,
        mesh: &[MeshPart<'_>],
        lines: &[VertexList],
        glass: &[VertexList],
    ) {
        let depth = |load, store| {
            Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(wgpu::Operations { load, store }),
                stencil_ops: None,
            })
        };
        let colour = |view, clear| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(clear),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("mesh"),
                color_attachments: &[colour(&targets.radiance, wgpu::Color::BLACK)],
                depth_stencil_attachment: depth(wgpu::LoadOp::Clear(0.0), wgpu::StoreOp::Store),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_bind_group(0, &frame.group, &[]);
            for part in mesh {
                match part {
                    MeshPart::Coloured(part) => {
                        pass.set_pipeline(&self.mesh);
                        pass.set_vertex_buffer(0, part.positions.slice(..));
                        pass.set_vertex_buffer(1, part.colours.slice(..));
                        pass.set_index_buffer(part.indices.slice(..), wgpu::IndexFormat::Uint32);
                        pass.draw_indexed(0..part.index_count, 0, 0..1);
                    }
                    MeshPart::Shaded(group, corners) => {
                        pass.set_pipeline(&self.shade);
                        pass.set_bind_group(1, *group, &[]);
                        pass.draw(0..*corners, 0..1);
                    }
                }
            }
            pass.set_pipeline(&self.lines);
            draw(&mut pass, lines);
        }
        if !glass.is_empty() {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("glass"),
                color_attachments: &[colour(&targets.tint, wgpu::Color::WHITE)],
                depth_stencil_attachment: depth(wgpu::LoadOp::Load, wgpu::StoreOp::Store),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_bind_group(0, &frame.group, &[]);
            pass.set_pipeline(&self.glass);
            draw(&mut pass, glass);
        }
    }
}

fn draw(pass: &mut wgpu::RenderPass<'_>, lists: &[VertexList]) {
    for list in lists {
        pass.set_vertex_buffer(0, list.buffer.slice(..));
        pass.draw(0..list.count, 0..1);
    }
}
