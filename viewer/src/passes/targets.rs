//! Textures that a frame is drawn into.

use crate::gpu::Gpu;

/// Radiance of samples: f32, nothing is scaled and nothing saturates.
pub const RADIANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Product of the tints of the glass before a sample; within 0..1, and it must be blendable.
pub const TINT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Reversed: 1 near, 0 at infinity.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Targets of samples.
#[derive(Debug)]
pub struct Targets {
    /// Samples across.
    pub width: u32,
    /// Samples down.
    pub height: u32,
    /// [`RADIANCE_FORMAT`].
    pub radiance: wgpu::TextureView,
    /// [`TINT_FORMAT`]; one texel where there is no glass.
    pub tint: wgpu::TextureView,
    /// [`DEPTH_FORMAT`].
    pub depth: wgpu::TextureView,
}

/// A texture that is drawn into and read afterwards.
pub fn texture(
    gpu: &Gpu,
    label: &str,
    format: wgpu::TextureFormat,
    width: u32,
    height: u32,
) -> wgpu::Texture {
    let read = match format {
        RADIANCE_FORMAT => wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING,
        DEPTH_FORMAT => wgpu::TextureUsages::empty(),
        _ => wgpu::TextureUsages::TEXTURE_BINDING,
    };
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | read,
        view_formats: &[],
    })
}

impl Targets {
    /// Targets of this many samples.
    pub fn new(gpu: &Gpu, width: u32, height: u32, has_glass: bool) -> Self {
        let view = |label, format, width, height| {
            texture(gpu, label, format, width, height)
                .create_view(&wgpu::TextureViewDescriptor::default())
        };
        let (tint_width, tint_height) = if has_glass { (width, height) } else { (1, 1) };
        Self {
            width,
            height,
            radiance: view("radiance", RADIANCE_FORMAT, width, height),
            tint: view("tint", TINT_FORMAT, tint_width, tint_height),
            depth: view("depth", DEPTH_FORMAT, width, height),
        }
    }
}
