//! Evaluates the glossy vertices of each chunk towards the eye.

use super::{FrameGroup, buffer, entry};
use crate::gpu::{Gpu, shaders};

/// Vertices a workgroup evaluates; stands in `evaluate.wgsl`.
const WORKGROUP: u32 = 64;

/// The pipeline.
#[derive(Debug)]
pub struct Evaluate {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

impl Evaluate {
    /// Compiles it.
    pub fn new(gpu: &Gpu, frame: &FrameGroup) -> Self {
        let stage = wgpu::ShaderStages::COMPUTE;
        let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("evaluate"),
                entries: &[
                    entry(0, stage, storage(true)),
                    entry(1, stage, storage(true)),
                    entry(2, stage, storage(false)),
                ],
            });
        let pipeline_layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("evaluate"),
                bind_group_layouts: &[Some(&frame.layout), Some(&layout)],
                immediate_size: 0,
            });
        let pipeline = gpu
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("evaluate"),
                layout: Some(&pipeline_layout),
                module: &shaders::EVALUATE.module(&gpu.device),
                entry_point: Some("evaluate"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
        Self { pipeline, layout }
    }

    /// Binds the buffers of a chunk.
    pub fn bind(
        &self,
        gpu: &Gpu,
        glossy: &wgpu::Buffer,
        words: &wgpu::Buffer,
        colours: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let [glossy, words, colours] =
            [glossy, words, colours].map(wgpu::Buffer::as_entire_binding);
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("evaluate"),
            layout: &self.layout,
            entries: &[entry(0, glossy), entry(1, words), entry(2, colours)],
        })
    }

    /// Evaluates `count` vertices for each group.
    pub fn record<'a>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameGroup,
        chunks: impl Iterator<Item = (&'a wgpu::BindGroup, u32)>,
        timestamps: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("evaluate"),
            timestamp_writes: timestamps,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &frame.group, &[]);
        for (group, count) in chunks.filter(|&(_, count)| count > 0) {
            pass.set_bind_group(1, group, &[]);
            pass.dispatch_workgroups(count.div_ceil(WORKGROUP), 1, 1);
        }
    }
}
