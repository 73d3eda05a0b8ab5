//! A log-log plot as SVG.

use std::fmt::Write;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 400.0;
/// Left and bottom hold the numbers.
const MARGIN: f64 = 64.0;

/// One axis: from its first to its last power of ten.
struct Axis {
    first: i32,
    last: i32,
    from: f64,
    to: f64,
}

impl Axis {
    fn around(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x.log10()), high.max(x.log10()))
        });
        let first = low.floor() as i32;
        Self {
            first,
            last: (high.ceil() as i32).max(first + 1),
            from,
            to,
        }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value.log10() - f64::from(self.first)) / f64::from(self.last - self.first);
        self.from + share * (self.to - self.from)
    }
}

/// Points of one curve, each with its label, over named axes. Points that are not above zero are left out; `None` when
/// none is left.
pub fn log_log(title: &str, names: [&str; 2], points: &[(f64, f64, String)]) -> Option<String> {
    let shown: Vec<_> = points
        .iter()
        .filter(|(x, y, _)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite())
        .collect();
    if shown.is_empty() {
        return None;
    }
    let across = Axis::around(shown.iter().map(|p| p.0), MARGIN, WIDTH - MARGIN * 0.5);
    let up = Axis::around(shown.iter().map(|p| p.1), HEIGHT - MARGIN, MARGIN * 0.5);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"{}\" y=\"20\" text-anchor=\"middle\">{}</text>\n",
        WIDTH * 0.5,
        escaped(title)
    );
    // Writing to a String does not fail.
    for power in across.first..=across.last {
        let x = across.at(10f64.powi(power));
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {:.1}V{:.1}\" stroke=\"#ccc\"/><text x=\"{x:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\">{}</text>",
            up.from,
            up.to,
            up.from + 18.0,
            number(power)
        );
    }
    for power in up.first..=up.last {
        let y = up.at(10f64.powi(power));
        let _ = writeln!(
            svg,
            "<path d=\"M{:.1} {y:.1}H{:.1}\" stroke=\"#ccc\"/><text x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"end\">{}</text>",
            across.from,
            across.to,
            across.from - 6.0,
            y + 4.0,
            number(power)
        );
    }
    let line: Vec<String> = shown
        .iter()
        .map(|(x, y, _)| format!("{:.1},{:.1}", across.at(*x), up.at(*y)))
        .collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#06c\" stroke-width=\"2\"/>",
        line.join(" ")
    );
    for (x, y, label) in shown {
        let (x, y) = (across.at(*x), up.at(*y));
        let _ = writeln!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"#06c\"/><text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            x + 8.0,
            y - 6.0,
            escaped(label)
        );
    }
    let [name_x, name_y] = names.map(escaped);
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{name_x}</text>\n\
         <text transform=\"translate(16 {:.1}) rotate(-90)\" text-anchor=\"middle\">{name_y}</text>\n</svg>",
        0.5 * (across.from + across.to),
        HEIGHT - 16.0,
        0.5 * (up.from + up.to)
    );
    Some(svg)
}

fn number(power: i32) -> String {
    if (-3..=4).contains(&power) {
        format!("{}", 10f64.powi(power))
    } else {
        format!("1e{power}")
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_where_their_logarithms_are() {
        let axis = Axis::around([0.02, 30.0].into_iter(), 0.0, 400.0);
        assert_eq!((axis.first, axis.last), (-2, 2));
        assert!((axis.at(1.0) - 200.0).abs() < 1e-9);
        assert!((axis.at(0.1) - 100.0).abs() < 1e-9);
    }

    #[test]
    fn what_has_no_logarithm_is_left_out() {
        let point = |x, y| (x, y, "a<b".to_owned());
        assert!(log_log("t", ["x", "y"], &[point(0.0, 1.0)]).is_none());
        let svg =
            log_log("t", ["x", "y"], &[point(1.0, 1.0), point(2.0, -1.0)]).expect("one point");
        assert_eq!(svg.matches("<circle").count(), 1);
        assert!(svg.contains("a&lt;b"));
    }
}
