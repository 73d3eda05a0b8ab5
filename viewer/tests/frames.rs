//! Frames of a walk are measured, as a table.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{gpu, room};
use sheen_viewer::bench::frames::{FramesError, Walk, frames};
use sheen_viewer::bench::table::Value;

fn number(value: &Value) -> f64 {
    match value {
        Value::Count(count) => *count as f64,
        Value::Fixed(number, _) => *number,
        other => panic!("{other} is no number"),
    }
}

#[test]
fn a_walk_has_a_row_for_each_shading_and_size() {
    let Some(gpu) = gpu("frames") else { return };
    let solution = room();
    let walk = Walk {
        sizes: vec![(64, 48), (32, 24)],
        across: vec![1, 2],
        frames: 12,
        seconds: 60.0,
    };
    let table = frames(&gpu, &solution, &walk, &mut ()).unwrap();
    assert_eq!(table.rows.len(), 2 * 2 * 2);
    for row in &table.rows {
        assert_eq!(row.len(), table.columns.len());
        assert_eq!(row[3], Value::Count(12));
        assert!(number(&row[9]) > 0.0, "{row:?}");
        if matches!(row[4], Value::None) {
            continue;
        }
        // The steps make up the frame, and no frame is longer than the longest.
        let steps: f64 = row[6..9].iter().map(number).sum();
        assert!(steps > 0.0 && number(&row[4]) <= number(&row[5]), "{row:?}");
        assert!(steps <= 12.0 * number(&row[5]), "{row:?}");
    }
    assert!(table.notes[0].contains(&gpu.info.name), "{:?}", table.notes);
    let triangles = format!("{} triangles", solution.triangles.len());
    assert!(table.notes[1].contains(&triangles), "{:?}", table.notes);
}

#[test]
fn a_picture_that_does_not_fit_is_refused() {
    let Some(gpu) = gpu("frames") else { return };
    let most = gpu.device.limits().max_texture_dimension_2d;
    let walk = Walk {
        sizes: vec![(most, 8)],
        across: vec![2],
        ..Walk::default()
    };
    let error = frames(&gpu, &room(), &walk, &mut ()).unwrap_err();
    assert!(matches!(error, FramesError::Size { across: 2, .. }));
    assert!(error.to_string().contains(&most.to_string()), "{error}");
}
