//! Does more work mean less error? One scene solved step by step along what users trade, quality for one, each solution
//! held against a reference picture and against paths over all surfaces.

use super::fit::power_law;
use crate::camera::View;
use crate::compare::{CompareError, compare};
use crate::verify::{Estimate, verify};
use crate::ways;
use sheen_formats::image::Image;
use sheen_solver::{Observer, PathTracer, Scene, SolveConfig, SolveError, solve};
use std::fmt::Write;

/// Pictures are averaged over blocks of so many pixels a side first: less noise of the reference.
const DOWNSAMPLE: u32 = 2;

/// The picture that solutions are held against.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Linear radiance.
    pub image: Image,
    /// Its noise: relMSE of the averaged picture against the true one.
    pub noise: f64,
    /// Where it comes from.
    pub source: String,
}

/// What is solved and measured.
#[derive(Clone, Debug)]
pub struct Step {
    /// As the table names it.
    pub label: String,
    /// How it is solved.
    pub config: SolveConfig,
}

/// One step.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    /// As it is named.
    pub step: String,
    /// Quality that it was solved at.
    pub quality: f64,
    /// Elapsed time of the solve [s].
    pub seconds: f64,
    /// The hierarchy, illumination samples and distributions [B].
    pub bytes: u64,
    /// Links, those to vertices included.
    pub links: u64,
    /// Elements of the hierarchy.
    pub elements: u64,
    /// relMSE against the reference, its noise subtracted; 99.9 % of the pixels.
    pub relmse: f64,
    /// Mean LDR-FLIP.
    pub flip: f64,
    /// Mean of the picture over that of the reference.
    pub ratio: f64,
    /// Over all surfaces and directions: see [`crate::verify`].
    pub bias: Estimate,
    /// The same.
    pub rms: Estimate,
}

/// A ladder of steps, cheapest first.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Ladder {
    /// What the scene is called.
    pub scene: String,
    /// Where the reference picture comes from.
    pub reference: String,
    /// What rises from step to step.
    pub dimension: String,
    /// What was measured.
    pub rows: Vec<Row>,
    /// Slope of log relMSE over log seconds, by least squares; `None` below two rows.
    pub slope: Option<f64>,
}

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum LadderError {
    /// A solve failed.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The reference does not fit.
    #[error(transparent)]
    Compare(#[from] CompareError),
}

impl Truth {
    /// Of a traced picture with the variance of its pixels.
    pub fn traced(traced: ways::path::Traced) -> Self {
        let image = traced.image;
        let count = image.pixels.len() as f64;
        let luminance = image
            .pixels
            .iter()
            .map(|p| f64::from(p.luminance()))
            .sum::<f64>()
            / count;
        // As relMSE is defined by `compare`.
        let floor = 1e-2 * luminance * luminance;
        let noise = traced.variance.map_or(0.0, |variance| {
            let of_pixel = |(value, variance): (&sheen_solver::Rgb, &sheen_solver::Rgb)| {
                let channels = value.to_array().into_iter().zip(variance.to_array());
                channels
                    .map(|(v, s)| f64::from(s) / (f64::from(v).powi(2) + floor))
                    .sum::<f64>()
                    / 3.0
            };
            let pixels = image.pixels.iter().zip(&variance.pixels);
            pixels.map(of_pixel).sum::<f64>() / count
        });
        Self {
            noise: noise / f64::from(DOWNSAMPLE * DOWNSAMPLE),
            source: format!("path tracing, {} paths a pixel", traced.samples),
            image,
        }
    }
}

/// Solves `scene` at each of `steps`, and measures. Stopped by the observer: the rows that are there.
pub fn climb(
    name: &str,
    scene: &Scene,
    (dimension, steps): (&str, &[Step]),
    view: &View,
    truth: &Truth,
    probes: u32,
    observer: &mut dyn Observer,
) -> Result<Ladder, LadderError> {
    let tracer = PathTracer::new(scene);
    let mut rows = Vec::new();
    for step in steps {
        let solution = solve(scene, &step.config, observer)?;
        let image = ways::cpu::render(&solution, view, ways::ACROSS);
        let compared = compare(&image, &truth.image, DOWNSAMPLE, None)?;
        let Some(found) = verify(&solution, &tracer, probes, 0, observer) else {
            break;
        };
        let done = sheen_solver::Progress {
            phase: "ladder",
            done: (rows.len() + 1) as f32 / steps.len() as f32,
        };
        if observer.report(&done).is_break() {
            break;
        }
        let stats = &solution.stats.solve;
        rows.push(Row {
            step: step.label.clone(),
            quality: stats.quality,
            seconds: stats.wall_s,
            bytes: stats.bytes.total,
            links: stats.links + stats.vertex_links,
            elements: stats.elements,
            relmse: compared.relmse_trim999 - truth.noise,
            flip: compared.flip,
            ratio: compared.mean_ratio,
            bias: found.all.bias,
            rms: found.all.rms,
        });
    }
    Ok(Ladder {
        scene: name.to_owned(),
        reference: truth.source.clone(),
        dimension: dimension.to_owned(),
        slope: slope(&rows),
        rows,
    })
}

/// The exponent of relMSE over seconds.
fn slope(rows: &[Row]) -> Option<f64> {
    power_law(rows.iter().map(|row| (row.seconds, row.relmse)))
}

impl Ladder {
    /// Times longer for half of the relMSE, by the slope; `None` where error does not fall with time.
    pub fn cost_of_half(&self) -> Option<f64> {
        self.slope
            .filter(|&slope| slope < 0.0)
            .map(|slope| 2f64.powf(-1.0 / slope))
    }

    /// As a table in Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "{} against {}\n\n| {} ",
            self.scene, self.reference, self.dimension
        );
        text.push_str(
            "| s | MiB | links | elements | relMSE | FLIP | ratio | bias % | rms error % |\n\
             |--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
        );
        for row in &self.rows {
            let percent = |e: &Estimate| [e.value, e.low, e.high].map(|x| 100.0 * x);
            let ([bias, bias_low, bias_high], [rms, rms_low, rms_high]) =
                (percent(&row.bias), percent(&row.rms));
            // Writing to a String does not fail.
            let _ = writeln!(
                text,
                "| {} | {:.2} | {:.1} | {} | {} | {:.5} | {:.4} | {:.4} | {bias:+.2} ({bias_low:+.2} to {bias_high:+.2}) \
                 | {rms:.1} ({rms_low:.1} to {rms_high:.1}) |",
                row.step,
                row.seconds,
                row.bytes as f64 / f64::from(1 << 20),
                row.links,
                row.elements,
                row.relmse,
                row.flip,
                row.ratio,
            );
        }
        text.push('\n');
        text.push_str(&match (self.slope, self.cost_of_half()) {
            (Some(slope), Some(cost)) => format!(
                "relMSE goes as time to the power {slope:.2}: half of it costs {cost:.1} times the time\n"
            ),
            (Some(slope), None) => {
                format!("relMSE does not fall with time: it goes as time to the power {slope:.2}\n")
            }
            _ => String::new(),
        });
        text
    }

    /// As CSV.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "step,quality,seconds,bytes,links,elements,relmse,flip,ratio,bias,bias_low,bias_high,rms,rms_low,rms_high\n",
        );
        for row in &self.rows {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                row.step,
                row.quality,
                row.seconds,
                row.bytes,
                row.links,
                row.elements,
                row.relmse,
                row.flip,
                row.ratio,
                row.bias.value,
                row.bias.low,
                row.bias.high,
                row.rms.value,
                row.rms.low,
                row.rms.high,
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(seconds: f64, relmse: f64) -> Row {
        let none = Estimate {
            value: 0.0,
            low: 0.0,
            high: 0.0,
        };
        Row {
            step: "0".into(),
            quality: 0.0,
            seconds,
            bytes: 1 << 20,
            links: 1,
            elements: 2,
            relmse,
            flip: 0.1,
            ratio: 1.0,
            bias: none,
            rms: none,
        }
    }

    #[test]
    fn a_power_law_has_its_exponent() {
        let rows: Vec<Row> = [1.0, 3.0, 10.0]
            .map(|t: f64| row(t, 0.5 * t.powf(-0.8)))
            .into();
        let ladder = Ladder {
            scene: "s".into(),
            reference: "r".into(),
            dimension: "quality".into(),
            slope: slope(&rows),
            rows,
        };
        assert!((ladder.slope.expect("three rows") + 0.8).abs() < 1e-12);
        let cost = ladder.cost_of_half().expect("it falls");
        assert!((cost - 2f64.powf(1.25)).abs() < 1e-9, "{cost}");
        assert_eq!(ladder.csv().lines().count(), 4);
        assert!(ladder.markdown().contains("power -0.80"));
    }

    #[test]
    fn one_row_has_no_slope() {
        assert_eq!(slope(&[row(1.0, 0.1)]), None);
        assert_eq!(slope(&[row(1.0, 0.1), row(1.0, 0.2)]), None);
    }
}
