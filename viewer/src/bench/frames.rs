//! Frames of a walk through a solution: time on the graphics device by step, frames a second, memory there.

use super::table::{Table, Value};
use crate::camera::{View, Walker};
use crate::gpu::timing::{FrameTimer, FrameTimes};
use crate::gpu::{Gpu, GpuError};
use crate::tonemap;
use crate::ways::Shading;
use crate::ways::chunks::Limits;
use crate::ways::solution::{DrawSettings, Overlay, SolutionRenderer, WindowTargets};
use sheen_solver::{Observer, Progress, SceneError, Solution};
use std::f32::consts::TAU;
use std::time::Instant;

/// How much is drawn.
#[derive(Clone, Debug)]
pub struct Walk {
    /// Width and height of the pictures.
    pub sizes: Vec<(u32, u32)>,
    /// Samples across and down a pixel.
    pub across: Vec<u32>,
    /// Frames of each row.
    pub frames: u32,
    /// A row ends after this long, however few they were [s].
    pub seconds: f64,
}

impl Default for Walk {
    fn default() -> Self {
        Self {
            sizes: vec![(1280, 720), (1920, 1080), (3840, 2160)],
            across: vec![1, 2],
            frames: 360,
            seconds: 10.0,
        }
    }
}

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum FramesError {
    /// There is no device, or it failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A camera cannot make a picture.
    #[error(transparent)]
    Camera(#[from] SceneError),
    /// A picture does not fit on the device.
    #[error(
        "{width}x{height} with {across} x {across} samples a pixel: expected at most {most} samples along each side"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Samples along each side of a pixel.
        across: u32,
        /// The device's limit.
        most: u32,
    },
}

/// Frames before the first that counts: buffers are filled, clocks rise.
const WARM_UP: u32 = 8;

/// Walks through `solution`: at each of its cameras the eye turns round once. Each row is drawn twice, frame by frame for
/// the time on the device, which is that of its passes, and without waiting for frames a second.
pub fn frames(
    gpu: &Gpu,
    solution: &Solution,
    walk: &Walk,
    observer: &mut dyn Observer,
) -> Result<Table, FramesError> {
    let mut table = Table::new(
        "frames",
        "A walk: the eye turns round at each camera",
        &[
            "shading",
            "pixels",
            "samples a pixel",
            "frames",
            "device ms, median",
            "99th percentile",
            "evaluate",
            "geometry",
            "resolve",
            "frames a second",
        ],
    );
    let most = gpu.device.limits().max_texture_dimension_2d;
    for (&(width, height), &across) in pairs(&walk.sizes, &walk.across) {
        if width.max(height).saturating_mul(across) > most {
            return Err(FramesError::Size {
                width,
                height,
                across,
                most,
            });
        }
    }
    let started = Instant::now();
    let mut renderer = SolutionRenderer::new(gpu, solution, Limits::default())?;
    wait(gpu)?;
    let upload_s = started.elapsed().as_secs_f64();
    let rows = 2 * walk.sizes.len() * walk.across.len();
    for (shading, name) in [
        (Shading::Samples, "samples"),
        (Shading::Vertices, "vertices"),
    ] {
        renderer.shading = shading;
        for (&(width, height), &across) in pairs(&walk.sizes, &walk.across) {
            let done = table.rows.len() as f32 / rows as f32;
            let progress = Progress {
                phase: "frames",
                done,
            };
            if observer.report(&progress).is_break() {
                return Ok(table);
            }
            let row = Row {
                gpu,
                solution,
                renderer: &renderer,
                targets: renderer.window_targets(gpu, width, height, across),
                frames: walk.frames,
                seconds: walk.seconds,
            };
            let times = row.on_device()?;
            let (count, seconds) = row.without_waiting()?;
            let milliseconds = |value: Option<f64>| match value {
                Some(seconds) => Value::Fixed(seconds * 1e3, 3),
                None => Value::None,
            };
            let mean = |of: fn(&FrameTimes) -> f64| {
                let sum: f64 = times.iter().map(of).sum();
                milliseconds((!times.is_empty()).then(|| sum / times.len() as f64))
            };
            table.rows.push(vec![
                Value::Text(name.to_owned()),
                Value::Text(format!("{width}x{height}")),
                Value::Count(u64::from(across * across)),
                Value::Count(u64::from(count)),
                milliseconds(percentile(&times, 0.5)),
                milliseconds(percentile(&times, 0.99)),
                mean(|times| times.evaluate),
                mean(|times| times.geometry),
                mean(|times| times.resolve),
                Value::Fixed(f64::from(count) / seconds, 1),
            ]);
        }
    }
    table.notes = vec![
        device(gpu),
        format!(
            "{} triangles, {} vertices, {} of them with a distribution; {:.1} MiB on the device, there after {upload_s:.2} s.",
            solution.triangles.len(),
            solution.position.len(),
            renderer.glossy_count(),
            renderer.bytes() as f64 / f64::from(1 << 20),
        ),
    ];
    Ok(table)
}

fn pairs<'a, A, B>(first: &'a [A], second: &'a [B]) -> impl Iterator<Item = (&'a A, &'a B)> {
    first
        .iter()
        .flat_map(move |a| second.iter().map(move |b| (a, b)))
}

/// What it was measured on.
fn device(gpu: &Gpu) -> String {
    let info = &gpu.info;
    let mut text = format!("Device: {}, {}", info.name, info.backend);
    for part in [&info.driver, &info.driver_info] {
        if !part.is_empty() {
            text = format!("{text}, {part}");
        }
    }
    text + "."
}

/// A share of all frames takes no longer [s]; `None` without frames.
fn percentile(times: &[FrameTimes], share: f64) -> Option<f64> {
    let mut totals: Vec<f64> = times.iter().map(FrameTimes::total).collect();
    totals.sort_by(f64::total_cmp);
    let at = (share * totals.len() as f64).ceil() as usize;
    totals.get(at.max(1) - 1).copied()
}

fn wait(gpu: &Gpu) -> Result<(), GpuError> {
    let polled = gpu.device.poll(wgpu::PollType::wait_indefinitely());
    polled.map_err(|error| GpuError::Device {
        reason: error.to_string(),
    })?;
    gpu.check()
}

/// What is drawn for a row of the table.
struct Row<'a> {
    gpu: &'a Gpu,
    solution: &'a Solution,
    renderer: &'a SolutionRenderer,
    targets: WindowTargets,
    frames: u32,
    seconds: f64,
}

impl Row<'_> {
    /// The eye in one of the frames.
    fn view(&self, frame: u32) -> Result<View, SceneError> {
        let cameras = &self.solution.cameras;
        let on_its_way = f64::from(frame % self.frames) / f64::from(self.frames);
        let at = on_its_way * cameras.len() as f64;
        let bounds = self.solution.bounds();
        let mut walker = Walker::new(&cameras[at as usize % cameras.len()], bounds);
        walker.turn(at.fract() as f32 * TAU, 0.0);
        let (width, height) = (self.targets.width, self.targets.height);
        View::new(&walker.camera(width, height), bounds)
    }

    fn draw(&self, frame: u32, timer: Option<&FrameTimer>) -> Result<(), FramesError> {
        let settings = DrawSettings {
            overlay: Overlay::default(),
            exposure: tonemap::for_shader(1.0),
            timer,
        };
        let view = self.view(frame)?;
        self.renderer
            .draw(self.gpu, &self.targets, &view, &settings);
        Ok(())
    }

    /// Time of each frame; none where the device does not tell.
    fn on_device(&self) -> Result<Vec<FrameTimes>, FramesError> {
        let mut times = Vec::new();
        let Some(timer) = FrameTimer::new(self.gpu) else {
            return Ok(times);
        };
        let started = Instant::now();
        for frame in 0..WARM_UP + self.frames {
            self.draw(frame, Some(&timer))?;
            // Asks for what the frame has left behind; and once it is there, takes it.
            timer.poll();
            wait(self.gpu)?;
            let found = timer.poll();
            if frame >= WARM_UP {
                times.extend(found);
            }
            if started.elapsed().as_secs_f64() > self.seconds && !times.is_empty() {
                break;
            }
        }
        Ok(times)
    }

    /// How many were drawn one after the other, and how long they took [s].
    fn without_waiting(&self) -> Result<(u32, f64), FramesError> {
        /// Frames that the processor may be ahead of the device.
        const AHEAD: u32 = 16;
        for frame in 0..WARM_UP.min(self.frames) {
            self.draw(frame, None)?;
        }
        wait(self.gpu)?;
        let started = Instant::now();
        let mut drawn = 0;
        while drawn < self.frames {
            self.draw(drawn, None)?;
            drawn += 1;
            if drawn % AHEAD == 0 {
                wait(self.gpu)?;
            }
            if started.elapsed().as_secs_f64() > self.seconds {
                break;
            }
        }
        wait(self.gpu)?;
        Ok((drawn, started.elapsed().as_secs_f64()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_is_one_of_the_times() {
        let of = |total: u32| FrameTimes {
            geometry: f64::from(total),
            ..FrameTimes::default()
        };
        let times: Vec<FrameTimes> = (1..=100).rev().map(of).collect();
        assert_eq!(percentile(&times, 0.5), Some(50.0));
        assert_eq!(percentile(&times, 0.99), Some(99.0));
        assert_eq!(percentile(&times[..1], 0.99), Some(100.0));
        assert_eq!(percentile(&[], 0.5), None);
    }
}
