//! Time of a frame on the device, by timestamp queries. Silent where the adapter has none.

use super::Gpu;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const IDLE: u8 = 0;
const MAPPING: u8 = 1;
const READY: u8 = 2;

/// Ends of the first pass and of the last.
const TIMESTAMPS: u32 = 4;
/// Bytes that they take.
const TICKS: u64 = 8 * TIMESTAMPS as u64;

/// Time of the steps of a frame on the device [s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Glossy vertices, where these are evaluated.
    pub evaluate: f64,
    /// Triangles, lines and glass.
    pub geometry: f64,
    /// Samples become pixels.
    pub resolve: f64,
}

impl FrameTimes {
    /// Of all steps [s].
    pub fn total(&self) -> f64 {
        self.evaluate + self.geometry + self.resolve
    }
}

/// Timestamps before and after the first pass and the last.
#[derive(Debug)]
pub struct FrameTimer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    mapped: wgpu::Buffer,
    state: Arc<AtomicU8>,
    nanoseconds_per_tick: f32,
}

impl FrameTimer {
    /// `None` where the device has no timestamp queries.
    pub fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
        {
            return None;
        }
        let buffer = |label, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: TICKS,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("frame time"),
                ty: wgpu::QueryType::Timestamp,
                count: TIMESTAMPS,
            }),
            resolved: buffer(
                "frame ticks",
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            ),
            mapped: buffer(
                "frame ticks read",
                wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            ),
            state: Arc::new(AtomicU8::new(IDLE)),
            nanoseconds_per_tick: gpu.queue.get_timestamp_period(),
        })
    }

    /// For the first pass of the frame, a compute pass.
    pub fn begin(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// For the last pass of the frame, a render pass.
    pub fn end(&self) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2),
            end_of_pass_write_index: Some(3),
        }
    }

    /// After the last pass: copies the ticks out, unless an earlier copy is still under way.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..TIMESTAMPS, &self.resolved, 0);
        if self.state.load(Ordering::Acquire) == IDLE {
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.mapped, 0, TICKS);
        }
    }

    /// After submission: the times of an earlier frame, once they are known.
    pub fn poll(&self) -> Option<FrameTimes> {
        match self.state.load(Ordering::Acquire) {
            IDLE => {
                self.state.store(MAPPING, Ordering::Release);
                let state = Arc::clone(&self.state);
                self.mapped
                    .slice(..)
                    .map_async(wgpu::MapMode::Read, move |result| {
                        state.store(if result.is_ok() { READY } else { IDLE }, Ordering::Release);
                    });
                None
            }
            READY => {
                let bytes = self.mapped.slice(..).get_mapped_range().ok()?.to_vec();
                self.mapped.unmap();
                self.state.store(IDLE, Ordering::Release);
                let tick = |index: usize| {
                    let bytes = bytes[8 * index..][..8].try_into();
                    u64::from_le_bytes(bytes.unwrap_or_default())
                };
                let seconds = |from: usize| {
                    let ticks = tick(from + 1).saturating_sub(tick(from));
                    ticks as f64 * f64::from(self.nanoseconds_per_tick) * 1e-9
                };
                Some(FrameTimes {
                    evaluate: seconds(0),
                    geometry: seconds(1),
                    resolve: seconds(2),
                })
            }
            _ => None,
        }
    }
}
