//! The side panel of the window: settings, cameras, statistics. egui only, no graphics device.

use crate::camera::{Motion, Walker};
use sheen_solver::solution::NO_DISTRIBUTION;
use sheen_solver::{Camera, Solution, Stats};

/// How much slower and faster than usual a person may move.
const SPEED_RANGE: f32 = 16.0;

/// Vertices with a directional distribution.
pub fn glossy_vertices(solution: &Solution) -> usize {
    solution
        .distribution_offset
        .iter()
        .filter(|&&offset| offset != NO_DISTRIBUTION)
        .count()
}

/// Every figure of the statistics with its name, as in the `--stats` file.
pub fn statistics(stats: &Stats) -> Vec<(String, String)> {
    fn flatten(prefix: &str, value: &serde_json::Value, rows: &mut Vec<(String, String)>) {
        match value {
            serde_json::Value::Object(fields) => {
                for (name, value) in fields {
                    let name = if prefix.is_empty() {
                        name.clone()
                    } else {
                        format!("{prefix}.{name}")
                    };
                    flatten(&name, value, rows);
                }
            }
            serde_json::Value::Number(number) if number.is_f64() => {
                rows.push((
                    prefix.to_owned(),
                    format!("{:.4}", number.as_f64().unwrap_or(f64::NAN)),
                ));
            }
            // Lists are for files: a row is as wide as the panel.
            serde_json::Value::Array(_) => {}
            other => rows.push((prefix.to_owned(), other.to_string())),
        }
    }
    let mut rows = Vec::new();
    // Plain numbers with text keys: serialising them cannot fail, and no row is better than no window.
    if let Ok(value) = serde_json::to_value(stats) {
        flatten("", &value, &mut rows);
    }
    rows
}

/// What the person has set.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Exposure over the automatic one, in stops.
    pub stops: f32,
    /// Draw the edges of hierarchy elements.
    pub wireframe: bool,
    /// Tint glossy triangles.
    pub show_glossy: bool,
    /// Samples across and down a pixel.
    pub samples: u32,
    /// Draw frames even when nothing changes, to measure them.
    pub is_continuous: bool,
    /// Evaluate the light of glossy surfaces at every sample, not at vertices only.
    pub shade_samples: bool,
    /// Set by the button, cleared by the window.
    pub wants_exposure: bool,
}

/// What the panel tells of the frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameFigures {
    /// From one frame to the next, while frames follow each other [ms].
    pub interval_ms: Option<f64>,
    /// Processor time to record a frame [ms].
    pub record_ms: f64,
    /// Time of the passes on the device [ms].
    pub gpu_ms: Option<f64>,
    /// Panel size in pixels.
    pub size: (u32, u32),
    /// Adapter.
    pub device: String,
}

/// What does not change while the window is open.
#[derive(Clone, Debug)]
pub struct Facts {
    /// Of the solution.
    pub sizes: Vec<(String, String)>,
    /// Of the solve.
    pub statistics: Vec<(String, String)>,
    /// Of the scene.
    pub cameras: Vec<Camera>,
}

impl Facts {
    /// Gathers them.
    pub fn new(solution: &Solution) -> Self {
        let row = |name: &str, value: usize| (name.to_owned(), value.to_string());
        Self {
            sizes: vec![
                row("triangles", solution.triangles.len()),
                row("clear triangles", solution.glass_corners.len()),
                row("vertices", solution.position.len()),
                row("glossy vertices", glossy_vertices(solution)),
                row(
                    "distributions [KiB]",
                    solution.distribution_words.len() * 4 / 1024,
                ),
            ],
            statistics: statistics(&solution.stats),
            cameras: solution.cameras.clone(),
        }
    }
}

fn table(ui: &mut egui::Ui, name: &str, rows: &[(String, String)]) {
    egui::Grid::new(name)
        .num_columns(2)
        .striped(true)
        .show(ui, |ui| {
            for (name, value) in rows {
                ui.label(name);
                ui.monospace(value);
                ui.end_row();
            }
        });
}

fn frame_rows(figures: &FrameFigures) -> Vec<(String, String)> {
    let ms = |value: f64| format!("{value:.2} ms");
    let unknown = || "-".to_owned();
    vec![
        (
            "frame".to_owned(),
            figures.interval_ms.map_or_else(unknown, |value| {
                format!("{} ({:.0}/s)", ms(value), 1000.0 / value)
            }),
        ),
        ("processor".to_owned(), ms(figures.record_ms)),
        ("device".to_owned(), figures.gpu_ms.map_or_else(unknown, ms)),
        (
            "pixels".to_owned(),
            format!("{} x {}", figures.size.0, figures.size.1),
        ),
    ]
}

/// Shows the panel.
pub fn side(
    ui: &mut egui::Ui,
    settings: &mut Settings,
    walker: &mut Walker,
    facts: &Facts,
    figures: &FrameFigures,
) {
    egui::ScrollArea::vertical().show(ui, |ui| {
        ui.heading("Frame");
        table(ui, "frame", &frame_rows(figures));
        ui.small(&figures.device);
        ui.checkbox(&mut settings.is_continuous, "draw all the time");
        ui.add(egui::Slider::new(&mut settings.samples, 1..=4).text("samples across a pixel"));
        ui.checkbox(&mut settings.shade_samples, "glossy light at every sample");
        ui.separator();

        ui.heading("Eye");
        ui.horizontal(|ui| {
            ui.selectable_value(&mut walker.motion, Motion::Fly, "fly");
            ui.selectable_value(&mut walker.motion, Motion::Orbit, "orbit");
        });
        for camera in &facts.cameras {
            if ui.button(&camera.name).clicked() {
                walker.jump(camera);
            }
        }
        let range = walker.usual_speed / SPEED_RANGE..=walker.usual_speed * SPEED_RANGE;
        ui.add(
            egui::Slider::new(&mut walker.speed, range)
                .logarithmic(true)
                .text("m/s"),
        );
        ui.add(
            egui::Slider::new(walker.fov_y_degrees(), 5.0..=120.0).text("field of view, degrees"),
        );
        ui.small("W A S D, Q E: move · arrows, drag: look · shift: faster · wheel: nearer");
        ui.separator();

        ui.heading("Display");
        ui.horizontal(|ui| {
            ui.add(egui::Slider::new(&mut settings.stops, -8.0..=8.0).text("stops"));
            settings.wants_exposure |= ui.button("auto").clicked();
        });
        ui.checkbox(&mut settings.wireframe, "elements");
        ui.checkbox(&mut settings.show_glossy, "glossy triangles");
        ui.separator();

        ui.heading("Solution");
        table(ui, "sizes", &facts.sizes);
        egui::CollapsingHeader::new("Solve")
            .default_open(true)
            .show(ui, |ui| {
                table(ui, "statistics", &facts.statistics);
            });
    });
}
