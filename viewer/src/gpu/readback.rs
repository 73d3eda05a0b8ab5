//! Textures back to memory.

use super::{Gpu, GpuError};
use sheen_solver::Rgb;

/// Bytes of a texel of `Rgba32Float`.
const TEXEL: u32 = 16;

/// Pixels of an `Rgba32Float` texture's corner of this size, row by row. Waits for the device.
pub fn read_rgb(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    width: u32,
    height: u32,
) -> Result<Vec<Rgb>, GpuError> {
    let row = (width * TEXEL).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor {
            label: Some("readback"),
        });
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = map(gpu, &buffer)?;
    let pixels = bytes
        .chunks_exact(row as usize)
        .flat_map(|line| line[..(width * TEXEL) as usize].chunks_exact(TEXEL as usize))
        .map(|texel| {
            let texel: [f32; 4] = bytemuck::pod_read_unaligned(texel);
            Rgb::new(texel[0], texel[1], texel[2])
        })
        .collect();
    Ok(pixels)
}

/// The bytes of a mappable buffer. Waits for the device.
pub fn map(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
    let fault = |reason: String| GpuError::Device { reason };
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer
        .slice(..)
        .map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only when polling failed, which is reported below.
            let _ = sender.send(result);
        });
    let polled = gpu.device.poll(wgpu::PollType::wait_indefinitely());
    gpu.check()?;
    polled.map_err(|error| fault(error.to_string()))?;
    receiver
        .recv()
        .map_err(|error| fault(error.to_string()))?
        .map_err(|error| fault(error.to_string()))?;
    let bytes = buffer
        .slice(..)
        .get_mapped_range()
        .map_err(|error| fault(error.to_string()))?
        .to_vec();
    buffer.unmap();
    Ok(bytes)
}
