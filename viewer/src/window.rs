//! Opens the window, where there is a display and an adapter that can draw on it.

use crate::app::{Fault, WalkApp};
use crate::gpu::{GpuError, device_descriptor};
use crate::script::Script;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use sheen_solver::{Camera, Solution};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why a window was not opened or did not last.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WindowError {
    /// No display, or no adapter that can draw on it.
    #[error("no window could be opened: {reason}")]
    NoWindow {
        /// What is missing.
        reason: String,
    },
    /// A frame failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The screenshot could not be written.
    #[error(transparent)]
    Screenshot(#[from] sheen_formats::FormatError),
}

static IS_OPENING: AtomicBool = AtomicBool::new(false);

/// True while a window is being opened: a panic then means that there is none, and is no news.
pub(crate) fn is_opening() -> bool {
    IS_OPENING.load(Ordering::Relaxed)
}

/// True when there is a display to ask for a window: on Unix both window systems say where they are.
fn has_display() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(not(all(unix, not(target_os = "macos")))) || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}

/// Opens the window on `solution` at `camera`; returns when it is closed, by a person or at the end of `script`.
pub fn run(
    title: &str,
    solution: Arc<Solution>,
    camera: &Camera,
    script: Option<Script>,
) -> Result<(), WindowError> {
    if !has_display() {
        let reason = "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set)".to_owned();
        return Err(WindowError::NoWindow { reason });
    }
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    // Compute passes are needed: no OpenGL.
    setup.instance_descriptor.backends =
        wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    setup.device_descriptor = Arc::new(device_descriptor);
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title(format!("sheen: {title}"))
            .with_inner_size([1280.0, 800.0]),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WgpuSetup::CreateNew(setup),
            ..WgpuConfiguration::default()
        },
        ..eframe::NativeOptions::default()
    };
    let fault = Fault::default();
    let is_open = Arc::new(AtomicBool::new(false));
    let (app_fault, app_open, camera) = (Arc::clone(&fault), Arc::clone(&is_open), camera.clone());
    let create: eframe::AppCreator<'static> = Box::new(move |context| {
        let app = WalkApp::new(context, solution, &camera, script, app_fault)?;
        app_open.store(true, Ordering::Relaxed);
        IS_OPENING.store(false, Ordering::Relaxed);
        Ok(Box::new(app))
    });
    // The window library panics where a system library that it loads at run time is missing.
    IS_OPENING.store(true, Ordering::Relaxed);
    let opened = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        eframe::run_native("sheen", options, create)
    }));
    IS_OPENING.store(false, Ordering::Relaxed);
    if let Some(error) = fault.lock().ok().and_then(|mut slot| slot.take()) {
        return Err(error);
    }
    match opened {
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) => Err(WindowError::NoWindow {
            reason: error.to_string(),
        }),
        Err(panic) if is_open.load(Ordering::Relaxed) => std::panic::resume_unwind(panic),
        Err(_) => Err(WindowError::NoWindow {
            reason: "the window system could not be started".to_owned(),
        }),
    }
}
