//! Draws a solution on the graphics device: glossy vertices are evaluated towards the eye, triangles rasterised.

use super::Shading;
use super::chunks::{self, Limits};
use crate::camera::{Tile, View};
use crate::gpu::layout::{FrameUniforms, GlassCorner, ResolveUniforms};
use crate::gpu::timing::FrameTimer;
use crate::gpu::{Gpu, GpuError, readback};
use crate::passes::FrameGroup;
use crate::passes::evaluate::Evaluate;
use crate::passes::geometry::{Geometry, MeshBuffers, MeshPart, VertexList};
use crate::passes::resolve::{Output, Resolve};
use crate::passes::targets::{RADIANCE_FORMAT, Targets, texture};
use sheen_formats::image::Image;
use sheen_solver::Solution;
use wgpu::BufferUsages;

/// Samples across and down that one tile of an off-screen image takes: 64 MiB of radiance.
const TILE_SAMPLES: u32 = 2048;
/// Vertices of one buffer of lines or glass: 24 bytes each, under 256 MiB; a multiple of 2 and of 3.
const LIST_VERTICES: usize = 9_999_996;

#[derive(Debug)]
struct Part {
    mesh: MeshBuffers,
    evaluation: wgpu::BindGroup,
    shading: wgpu::BindGroup,
    glossy_count: u32,
}

/// What a frame shows besides radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overlay {
    /// Draw the edges of hierarchy elements.
    pub wireframe: bool,
    /// Tint of glossy triangles, 0..1.
    pub glossy_tint: f32,
    /// Radiance of lines [W·sr⁻¹·m⁻²].
    pub line_radiance: f32,
}

/// A solution on the device, with the pipelines that draw it.
#[derive(Debug)]
pub struct SolutionRenderer {
    frame: FrameGroup,
    evaluate: Evaluate,
    geometry: Geometry,
    resolve: Resolve,
    parts: Vec<Part>,
    lines: Option<Vec<VertexList>>,
    glass: Vec<VertexList>,
    /// Of the solution, on the device.
    bytes: u64,
    /// Where light is evaluated.
    pub shading: Shading,
}

fn lists<T: bytemuck::Pod>(gpu: &Gpu, label: &str, vertices: &[T]) -> Vec<VertexList> {
    vertices
        .chunks(LIST_VERTICES)
        .map(|part| VertexList {
            buffer: gpu.buffer(label, part, BufferUsages::VERTEX),
            count: part.len() as u32,
        })
        .collect()
}

impl SolutionRenderer {
    /// Uploads `solution` in parts of at most `limits`.
    pub fn new(gpu: &Gpu, solution: &Solution, limits: Limits) -> Result<Self, GpuError> {
        let frame = FrameGroup::new(gpu);
        let evaluate = Evaluate::new(gpu, &frame);
        let geometry = Geometry::new(gpu, &frame);
        let mut bytes = 0;
        let parts = chunks::cut(solution, limits)
            .into_iter()
            .map(|chunk| {
                let mesh = MeshBuffers {
                    positions: gpu.buffer(
                        "positions",
                        &chunk.positions,
                        BufferUsages::VERTEX | BufferUsages::STORAGE,
                    ),
                    colours: gpu.buffer(
                        "colours",
                        &chunk.colours,
                        BufferUsages::VERTEX | BufferUsages::STORAGE,
                    ),
                    indices: gpu.buffer(
                        "triangles",
                        chunk.triangles.as_flattened(),
                        BufferUsages::INDEX | BufferUsages::STORAGE,
                    ),
                    index_count: 3 * chunk.triangles.len() as u32,
                };
                let glossy = gpu.buffer("glossy vertices", &chunk.glossy, BufferUsages::STORAGE);
                let words = gpu.buffer("distributions", &chunk.words, BufferUsages::STORAGE);
                let shaded = gpu.buffer("vertices", &chunk.shaded, BufferUsages::STORAGE);
                bytes += [&mesh.positions, &mesh.colours, &mesh.indices]
                    .into_iter()
                    .chain([&glossy, &words, &shaded])
                    .map(wgpu::Buffer::size)
                    .sum::<u64>();
                Part {
                    evaluation: evaluate.bind(gpu, &glossy, &words, &mesh.colours),
                    shading: geometry.bind(gpu, &mesh, &shaded, &words),
                    mesh,
                    glossy_count: chunk.glossy.len() as u32,
                }
            })
            .collect();
        let corners: Vec<GlassCorner> = solution
            .glass_corners
            .iter()
            .zip(&solution.glass_material)
            .flat_map(|(corners, &material)| {
                let tint = solution.materials[material as usize]
                    .transmission
                    .to_array();
                corners.map(|corner| GlassCorner {
                    position: corner.to_array(),
                    tint,
                })
            })
            .collect();
        let glass = lists(gpu, "glass", &corners);
        bytes += glass.iter().map(|list| list.buffer.size()).sum::<u64>();
        let renderer = Self {
            geometry,
            shading: Shading::default(),
            resolve: Resolve::new(gpu),
            glass,
            bytes,
            lines: None,
            frame,
            evaluate,
            parts,
        };
        gpu.check()?;
        Ok(renderer)
    }

    /// True when something clear is drawn.
    pub fn has_glass(&self) -> bool {
        !self.glass.is_empty()
    }

    /// Bytes of the solution on the device, without the wireframe.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Vertices on the device that have a distribution; those that several parts use count for each.
    pub fn glossy_count(&self) -> u64 {
        self.parts
            .iter()
            .map(|part| u64::from(part.glossy_count))
            .sum()
    }

    /// Uploads the wireframe, once.
    pub fn prepare_wireframe(&mut self, gpu: &Gpu, solution: &Solution) {
        if self.lines.is_none() {
            self.lines = Some(lists(gpu, "wireframe", &chunks::wireframe(solution)));
        }
    }

    fn write_frame(&self, gpu: &Gpu, view: &View, tile: Tile, overlay: Overlay) {
        self.frame.write(
            gpu,
            &FrameUniforms {
                clip_from_relative: view.clip_from_relative(tile).to_cols_array_2d(),
                eye: view.eye.to_array(),
                glossy_tint: overlay.glossy_tint,
                line_radiance: [overlay.line_radiance; 3],
                padding: 0.0,
            },
        );
    }

    fn record_evaluation(&self, encoder: &mut wgpu::CommandEncoder, timer: Option<&FrameTimer>) {
        let chunks = self
            .parts
            .iter()
            .filter(|_| self.shading == Shading::Vertices)
            .map(|part| (&part.evaluation, part.glossy_count));
        self.evaluate
            .record(encoder, &self.frame, chunks, timer.map(FrameTimer::begin));
    }

    fn record_geometry(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        overlay: Overlay,
    ) {
        let parts = self.parts.iter();
        let mesh: Vec<MeshPart<'_>> = match self.shading {
            Shading::Vertices => parts.map(|part| MeshPart::Coloured(&part.mesh)).collect(),
            Shading::Samples => parts
                .map(|part| MeshPart::Shaded(&part.shading, part.mesh.index_count))
                .collect(),
        };
        let lines = self
            .lines
            .as_deref()
            .filter(|_| overlay.wireframe)
            .unwrap_or_default();
        self.geometry
            .record(encoder, &self.frame, targets, &mesh, lines, &self.glass);
    }

    /// Renders `view` off-screen; a pixel is the mean over `across` × `across` samples at the middles of its cells.
    pub fn render(&self, gpu: &Gpu, view: &View, across: u32) -> Result<Image, GpuError> {
        let (width, height) = (view.width, view.height);
        let tile_size = (TILE_SAMPLES / across).max(1);
        let targets = Targets::new(
            gpu,
            tile_size.min(width) * across,
            tile_size.min(height) * across,
            self.has_glass(),
        );
        let samples = self.resolve.bind(gpu, &targets);
        let pixels = texture(
            gpu,
            "pixels",
            RADIANCE_FORMAT,
            tile_size.min(width),
            tile_size.min(height),
        );
        let target = pixels.create_view(&wgpu::TextureViewDescriptor::default());
        let has_glass = u32::from(self.has_glass());
        self.resolve.write(
            gpu,
            &ResolveUniforms {
                samples: across,
                has_glass,
                exposure: 1.0,
                padding: 0,
            },
        );
        let mut image = vec![sheen_solver::Rgb::BLACK; width as usize * height as usize];
        let mut is_evaluated = false;
        for y in (0..height).step_by(tile_size as usize) {
            for x in (0..width).step_by(tile_size as usize) {
                // Tiles at the border keep their size, so that every tile is scaled alike.
                let tile = Tile {
                    x,
                    y,
                    width: tile_size.min(width),
                    height: tile_size.min(height),
                };
                self.write_frame(gpu, view, tile, Overlay::default());
                let descriptor = wgpu::CommandEncoderDescriptor {
                    label: Some("tile"),
                };
                let mut encoder = gpu.device.create_command_encoder(&descriptor);
                if !is_evaluated {
                    self.record_evaluation(&mut encoder, None);
                    is_evaluated = true;
                }
                self.record_geometry(&mut encoder, &targets, Overlay::default());
                self.resolve
                    .record(&mut encoder, &samples, &target, Output::Linear, None);
                gpu.queue.submit([encoder.finish()]);
                let (columns, rows) = (tile.width.min(width - x), tile.height.min(height - y));
                let read = readback::read_rgb(gpu, &pixels, columns, rows)?;
                for (row, line) in read.chunks_exact(columns as usize).enumerate() {
                    let start = (y as usize + row) * width as usize + x as usize;
                    image[start..start + columns as usize].copy_from_slice(line);
                }
            }
        }
        Ok(Image {
            width,
            height,
            pixels: image,
        })
    }

    /// Draws one frame of the window into `target` and submits it.
    pub fn draw(
        &self,
        gpu: &Gpu,
        window: &WindowTargets,
        view: &View,
        settings: &DrawSettings<'_>,
    ) {
        self.write_frame(gpu, view, view.whole(), settings.overlay);
        self.resolve.write(
            gpu,
            &ResolveUniforms {
                samples: window.across,
                has_glass: u32::from(self.has_glass()),
                exposure: settings.exposure,
                padding: 0,
            },
        );
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("frame"),
            });
        self.record_evaluation(&mut encoder, settings.timer);
        self.record_geometry(&mut encoder, &window.targets, settings.overlay);
        let timestamps = settings.timer.map(FrameTimer::end);
        self.resolve.record(
            &mut encoder,
            &window.samples,
            &window.display,
            Output::Display,
            timestamps,
        );
        if let Some(timer) = settings.timer {
            timer.resolve(&mut encoder);
        }
        gpu.queue.submit([encoder.finish()]);
    }

    /// Targets for a window's panel of this size.
    pub fn window_targets(&self, gpu: &Gpu, width: u32, height: u32, across: u32) -> WindowTargets {
        let targets = Targets::new(gpu, width * across, height * across, self.has_glass());
        let display = texture(
            gpu,
            "panel",
            crate::passes::resolve::DISPLAY_FORMAT,
            width,
            height,
        );
        WindowTargets {
            width,
            height,
            across,
            samples: self.resolve.bind(gpu, &targets),
            display: display.create_view(&wgpu::TextureViewDescriptor::default()),
            targets,
        }
    }
}

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug)]
pub struct DrawSettings<'a> {
    /// Lines and tints.
    pub overlay: Overlay,
    /// Factor before display encoding.
    pub exposure: f32,
    /// Measures the frame.
    pub timer: Option<&'a FrameTimer>,
}

/// Targets of a panel of the window.
#[derive(Debug)]
pub struct WindowTargets {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples across and down a pixel.
    pub across: u32,
    /// What is shown.
    pub display: wgpu::TextureView,
    targets: Targets,
    samples: wgpu::BindGroup,
}
