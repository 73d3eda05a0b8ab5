//! The shaders, joined from their parts.

/// A labelled WGSL source.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// Name in messages of the driver and of tests.
    pub label: &'static str,
    /// Parts, joined in this order.
    pub parts: &'static [&'static str],
    /// File names of the parts under `viewer/shaders`.
    pub files: &'static [&'static str],
}

impl Shader {
    /// The whole source.
    pub fn source(&self) -> String {
        self.parts.concat()
    }

    /// Compiles it.
    pub fn module(&self, device: &wgpu::Device) -> wgpu::ShaderModule {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.label),
            source: wgpu::ShaderSource::Wgsl(self.source().into()),
        })
    }
}

macro_rules! shader {
    ($label:literal: $($file:literal),+) => {
        Shader {
            label: $label,
            parts: &[$(include_str!(concat!("../../shaders/", $file))),+],
            files: &[$($file),+],
        }
    };
}

/// Glossy vertices towards the eye.
pub const EVALUATE: Shader =
    shader!("evaluate": "shared/frame.wgsl", "shared/directional.wgsl", "evaluate.wgsl");
/// Opaque triangles.
pub const MESH: Shader = shader!("mesh": "shared/frame.wgsl", "mesh.wgsl");
/// Opaque triangles, glossy ones shaded sample by sample.
pub const SHADE: Shader =
    shader!("shade": "shared/frame.wgsl", "shared/directional.wgsl", "shade.wgsl");
/// Clear triangles.
pub const GLASS: Shader = shader!("glass": "shared/frame.wgsl", "glass.wgsl");
/// Wireframe.
pub const LINES: Shader = shader!("lines": "shared/frame.wgsl", "lines.wgsl");
/// Samples to pixels.
pub const RESOLVE: Shader = shader!("resolve": "resolve.wgsl");

/// Every shader of the program.
pub const ALL: [Shader; 6] = [EVALUATE, MESH, SHADE, GLASS, LINES, RESOLVE];
