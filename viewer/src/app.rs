//! The frame loop of the window: moves the eye, draws a frame into the middle, a panel beside it.

use crate::camera::{Motion, View, Walker};
use crate::gpu::timing::FrameTimer;
use crate::gpu::{Gpu, GpuError};
use crate::panels::{self, Facts, FrameFigures, Settings};
use crate::script::Script;
use crate::steering;
use crate::tonemap;
use crate::ways::Shading;
use crate::ways::chunks::Limits;
use crate::ways::solution::{DrawSettings, Overlay, SolutionRenderer, WindowTargets};
use crate::window::WindowError;
use eframe::egui_wgpu::RenderState;
use glam::Vec3;
use sheen_solver::{Camera, Solution};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Turn of the eye about its target by a drag across the panel [rad].
const ORBIT_DRAG: f32 = std::f32::consts::TAU;
/// Dolly per point that the wheel scrolls.
const DOLLY_RATE: f32 = 0.002;
/// Pixels across of the image that the automatic exposure looks at.
const EXPOSURE_WIDTH: u32 = 160;
/// Share of a new measurement in a shown time.
const SMOOTHING: f64 = 0.1;
/// A gap between frames that is no frame time: the window was idle [ms].
const IDLE_MS: f64 = 1000.0;

/// What a closed window leaves behind.
pub(crate) type Fault = Arc<Mutex<Option<WindowError>>>;

fn set_fault(fault: &Fault, error: WindowError) {
    if let Ok(mut slot) = fault.lock() {
        slot.get_or_insert(error);
    }
}

/// The state behind the window.
pub(crate) struct WalkApp {
    solution: Arc<Solution>,
    bounds: (Vec3, Vec3),
    state: RenderState,
    gpu: Gpu,
    renderer: SolutionRenderer,
    timer: Option<FrameTimer>,
    panel: Option<(WindowTargets, egui::TextureId)>,
    walker: Walker,
    settings: Settings,
    /// Factor before display encoding at 0 stops.
    exposure: f64,
    facts: Facts,
    figures: FrameFigures,
    last_frame: Instant,
    frame_count: u32,
    script: Option<Script>,
    fault: Fault,
}

impl WalkApp {
    /// Uploads `solution` to the window's device and puts the eye at `camera`.
    pub(crate) fn new(
        context: &eframe::CreationContext<'_>,
        solution: Arc<Solution>,
        camera: &Camera,
        script: Option<Script>,
        fault: Fault,
    ) -> Result<Self, GpuError> {
        let state = context
            .wgpu_render_state
            .clone()
            .ok_or_else(|| GpuError::NoAdapter {
                reason: "the window has none".to_owned(),
            })?;
        let gpu = Gpu::from_device(
            state.device.clone(),
            state.queue.clone(),
            state.adapter.get_info(),
        );
        let renderer = SolutionRenderer::new(&gpu, &solution, Limits::default())?;
        let bounds = solution.bounds();
        let mut app = Self {
            timer: FrameTimer::new(&gpu),
            walker: Walker::new(camera, bounds),
            settings: Settings {
                stops: 0.0,
                wireframe: false,
                show_glossy: false,
                // A program on the processor has no power to spare.
                samples: if gpu.is_software() { 1 } else { 2 },
                is_continuous: false,
                shade_samples: !gpu.is_software(),
                wants_exposure: false,
            },
            exposure: 1.0,
            facts: Facts::new(&solution),
            figures: FrameFigures {
                device: gpu.info.name.clone(),
                ..FrameFigures::default()
            },
            last_frame: Instant::now(),
            frame_count: 0,
            panel: None,
            solution,
            bounds,
            state,
            gpu,
            renderer,
            script,
            fault,
        };
        app.expose(camera.width, camera.height)?;
        Ok(app)
    }

    /// Picks the exposure for what the eye sees.
    fn expose(&mut self, width: u32, height: u32) -> Result<(), GpuError> {
        let camera = self.walker.camera(
            EXPOSURE_WIDTH,
            (EXPOSURE_WIDTH * height / width.max(1)).max(1),
        );
        if let Ok(view) = View::new(&camera, self.bounds) {
            let image = self.renderer.render(&self.gpu, &view, 1)?;
            self.exposure = tonemap::default_exposure(&image.pixels);
        }
        Ok(())
    }

    /// Moves the eye by keys and mouse; true when it moved.
    fn steer(&mut self, ui: &egui::Ui, response: &egui::Response) -> bool {
        let before = self.walker.camera(1, 1);
        let size = response.rect.size();
        let drag = response.drag_delta();
        if drag != egui::Vec2::ZERO {
            match self.walker.motion {
                // The scene follows the pointer.
                Motion::Fly => {
                    let angle = self.walker.fov_y_degrees().to_radians() / size.y.max(1.0);
                    self.walker.turn(-drag.x * angle, drag.y * angle);
                }
                Motion::Orbit => {
                    let angle = ORBIT_DRAG / size.x.max(1.0);
                    self.walker.turn(drag.x * angle, -drag.y * angle);
                }
            }
        }
        let scroll = if response.hovered() {
            ui.input(|input| input.smooth_scroll_delta().y)
        } else {
            0.0
        };
        if scroll != 0.0 {
            self.walker.dolly((-scroll * DOLLY_RATE).exp());
        }
        if !ui.ctx().egui_wants_keyboard_input() {
            ui.input(|input| steering::by_keys(&mut self.walker, input));
        }
        before != self.walker.camera(1, 1)
    }

    /// Targets of the panel's size, registered with egui.
    fn prepare_panel(&mut self, width: u32, height: u32) {
        let samples = self.settings.samples;
        let fits = |targets: &WindowTargets| {
            (targets.width, targets.height, targets.across) == (width, height, samples)
        };
        if self
            .panel
            .as_ref()
            .is_some_and(|(targets, _)| fits(targets))
        {
            return;
        }
        let targets = self
            .renderer
            .window_targets(&self.gpu, width, height, samples);
        let mut egui_renderer = self.state.renderer.write();
        if let Some((_, id)) = self.panel.take() {
            egui_renderer.free_texture(&id);
        }
        let filter = wgpu::FilterMode::Nearest;
        let id = egui_renderer.register_native_texture(&self.gpu.device, &targets.display, filter);
        self.panel = Some((targets, id));
    }

    fn overlay(&self, exposure: f32) -> Overlay {
        Overlay {
            wireframe: self.settings.wireframe,
            glossy_tint: if self.settings.show_glossy { 0.6 } else { 0.0 },
            // White on the display, at any exposure.
            line_radiance: exposure.recip(),
        }
    }

    /// Draws the scene into the middle of the window.
    fn show_view(&mut self, ui: &mut egui::Ui) {
        let response = ui.allocate_response(ui.available_size(), egui::Sense::click_and_drag());
        if self.steer(ui, &response) || self.settings.is_continuous {
            ui.ctx().request_repaint();
        }
        let largest = self.gpu.device.limits().max_texture_dimension_2d / self.settings.samples;
        let pixels = response.rect.size() * ui.ctx().pixels_per_point();
        let side = |length: f32| (length.round() as u32).clamp(1, largest);
        let (width, height) = (side(pixels.x), side(pixels.y));
        if std::mem::take(&mut self.settings.wants_exposure) {
            self.settings.stops = 0.0;
            if let Err(error) = self.expose(width, height) {
                set_fault(&self.fault, error.into());
            }
        }
        if self.settings.wireframe {
            self.renderer.prepare_wireframe(&self.gpu, &self.solution);
        }
        self.prepare_panel(width, height);
        let stops = f64::from(self.settings.stops);
        let exposure = tonemap::for_shader(self.exposure * stops.exp2());
        let overlay = self.overlay(exposure);
        let view = View::new(&self.walker.camera(width, height), self.bounds);
        if let (Some((targets, id)), Ok(view)) = (&self.panel, view) {
            let settings = DrawSettings {
                overlay,
                exposure,
                timer: self.timer.as_ref(),
            };
            self.renderer.shading = if self.settings.shade_samples {
                Shading::Samples
            } else {
                Shading::Vertices
            };
            self.renderer.draw(&self.gpu, targets, &view, &settings);
            let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            ui.painter()
                .image(*id, response.rect, whole, egui::Color32::WHITE);
        }
        self.figures.size = (width, height);
        if let Some(times) = self.timer.as_ref().and_then(FrameTimer::poll) {
            self.figures.gpu_ms = Some(smooth(self.figures.gpu_ms, times.total() * 1e3));
        }
    }

    /// Closes the window after a fault or at the end of the script.
    fn close_when_done(&mut self, context: &egui::Context) {
        if let Err(error) = self.gpu.check() {
            set_fault(&self.fault, error.into());
        }
        if self.fault.lock().is_ok_and(|slot| slot.is_some()) {
            context.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        let Some(script) = &self.script else { return };
        context.request_repaint();
        if self.frame_count != script.length() {
            return;
        }
        let (path, fault, window) = (
            script.path.clone(),
            Arc::clone(&self.fault),
            context.clone(),
        );
        context.request_screenshot(move |image| {
            let rgb: Vec<u8> = image
                .pixels
                .iter()
                .flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()])
                .collect();
            let [width, height] = image.size.map(|side| side as u32);
            if let Err(error) = sheen_formats::image::write_png(&path, &rgb, width, height) {
                set_fault(&fault, error.into());
            }
            window.send_viewport_cmd(egui::ViewportCommand::Close);
        });
    }
}

fn smooth(old: Option<f64>, new: f64) -> f64 {
    old.map_or(new, |old| old + (new - old) * SMOOTHING)
}

impl eframe::App for WalkApp {
    fn raw_input_hook(&mut self, _: &egui::Context, input: &mut egui::RawInput) {
        if let Some(script) = &self.script {
            script.play(self.frame_count, input);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let started = Instant::now();
        let interval_ms = (started - self.last_frame).as_secs_f64() * 1e3;
        self.last_frame = started;
        if interval_ms < IDLE_MS {
            self.figures.interval_ms = Some(smooth(self.figures.interval_ms, interval_ms));
        }
        egui::Panel::right("panel")
            .default_size(300.0)
            .show(ui, |ui| {
                panels::side(
                    ui,
                    &mut self.settings,
                    &mut self.walker,
                    &self.facts,
                    &self.figures,
                );
            });
        egui::CentralPanel::default()
            .frame(egui::Frame::NONE)
            .show(ui, |ui| self.show_view(ui));
        self.frame_count += 1;
        self.figures.record_ms = smooth(
            Some(self.figures.record_ms),
            started.elapsed().as_secs_f64() * 1e3,
        );
        self.close_when_done(ui.ctx());
    }
}
