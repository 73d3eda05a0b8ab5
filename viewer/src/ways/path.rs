//! Path tracing on the processor: the reference. Progressive, with the variance of every pixel.

use crate::camera::View;
use rayon::prelude::*;
use sheen_formats::image::Image;
use sheen_solver::geometry::hash;
use sheen_solver::path::Sampler;
use sheen_solver::{Observer, PathTracer, Progress, Rgb};
use std::time::{Duration, Instant};

/// Passes that the samples of a pixel are spread over, at least: their means tell the variance.
const PASSES: u32 = 8;
/// Samples of a pass, at most: a picture is there early.
const MOST_A_PASS: u32 = 64;
/// Samples of a pass where time is limited.
const TIMED_PASS: u32 = 4;
/// Rows between two reports.
const BAND: u32 = 8;

/// How long to trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Samples per pixel, rounded up to whole passes.
    pub samples: u32,
    /// No pass starts after this time; the first one always does.
    pub time_limit: Option<Duration>,
}

/// A traced picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Traced {
    /// Mean radiance of each pixel's square.
    pub image: Image,
    /// Variance of that mean, per channel; `None` after a single pass.
    pub variance: Option<Image>,
    /// Samples of each pixel.
    pub samples: u32,
}

/// Sums over the passes of a pixel: of their means, and of the squares of these.
#[derive(Clone, Copy, Default)]
struct Sums {
    means: [f64; 3],
    squares: [f64; 3],
}

/// Traces `view`. `seed`: runs with different ones are independent; the same one gives the same bits for any number of
/// threads, unless time ends it. The observer is asked after every few rows; stopped, finished passes are kept, of the
/// first one what there is.
pub fn trace(
    tracer: &PathTracer,
    view: &View,
    budget: Budget,
    seed: u32,
    observer: &mut dyn Observer,
) -> Traced {
    let started = Instant::now();
    let wanted = budget.samples.max(1);
    let a_pass = match budget.time_limit {
        Some(_) => TIMED_PASS.min(wanted),
        // Powers of two fill space most evenly.
        None => 1 << (wanted / PASSES).clamp(1, MOST_A_PASS).ilog2(),
    };
    let passes = wanted.div_ceil(a_pass);
    let count = view.width as usize * view.height as usize;
    let mut sums = vec![Sums::default(); count];
    let mut done = 0;
    'passes: for pass in 0..passes {
        let is_late = budget
            .time_limit
            .is_some_and(|limit| started.elapsed() >= limit);
        if is_late && pass > 0 {
            break;
        }
        let mut means = vec![[0.0f64; 3]; count];
        let band = (BAND * view.width) as usize;
        for (index, pixels) in means.chunks_mut(band).enumerate() {
            let first = index * band;
            pixels.par_iter_mut().enumerate().for_each(|(i, mean)| {
                let pixel = (first + i) as u32;
                *mean = mean_of_pass(tracer, view, pixel, a_pass, hash::mix(seed, pass));
            });
            let part = (first + pixels.len()) as f32 / count as f32;
            let by_samples = (pass as f32 + part) / passes as f32;
            let by_time = budget.time_limit.map_or(0.0, |limit| {
                started.elapsed().as_secs_f32() / limit.as_secs_f32()
            });
            let progress = Progress {
                phase: "paths",
                done: by_samples.max(by_time).min(1.0),
            };
            if observer.report(&progress).is_break() {
                if pass == 0 {
                    add(&mut sums, &means);
                    done = 1;
                }
                break 'passes;
            }
        }
        add(&mut sums, &means);
        done = pass + 1;
    }
    Traced {
        image: image(
            view,
            sums.iter()
                .map(|sum| sum.means.map(|channel| channel / f64::from(done))),
        ),
        variance: (done > 1).then(|| image(view, sums.iter().map(|sum| variance(sum, done)))),
        samples: done * a_pass,
    }
}

fn mean_of_pass(tracer: &PathTracer, view: &View, pixel: u32, samples: u32, seed: u32) -> [f64; 3] {
    let (column, row) = (pixel % view.width, pixel / view.width);
    let mut sum = [0.0; 3];
    for index in 0..samples {
        let mut sampler = Sampler::new(pixel, index, seed);
        let [x, y, ..] = sampler.draw();
        let (x, y) = (
            f64::from(column) + f64::from(x),
            f64::from(row) + f64::from(y),
        );
        let direction = view.direction(x, y).as_vec3();
        let radiance = tracer.radiance(view.eye, direction, &mut sampler);
        for (total, value) in sum.iter_mut().zip(radiance.to_array()) {
            *total += f64::from(value);
        }
    }
    sum.map(|total| total / f64::from(samples))
}

fn add(sums: &mut [Sums], means: &[[f64; 3]]) {
    for (sum, mean) in sums.iter_mut().zip(means) {
        for (channel, &value) in mean.iter().enumerate() {
            sum.means[channel] += value;
            sum.squares[channel] += value * value;
        }
    }
}

/// Variance of the mean over `passes` passes.
fn variance(sum: &Sums, passes: u32) -> [f64; 3] {
    let count = f64::from(passes);
    std::array::from_fn(|channel| {
        let mean = sum.means[channel] / count;
        let spread = (sum.squares[channel] / count - mean * mean).max(0.0);
        spread / (count - 1.0)
    })
}

fn image(view: &View, pixels: impl Iterator<Item = [f64; 3]>) -> Image {
    Image {
        width: view.width,
        height: view.height,
        pixels: pixels
            .map(|pixel| Rgb::from(pixel.map(|channel| channel as f32)))
            .collect(),
    }
}
