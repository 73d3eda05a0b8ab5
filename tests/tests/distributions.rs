//! The directional basis (exact cases 2f).
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::Rgb;
use sheen_solver::directional::{Basis, Projection, Projector, Source, packed};
use sheen_solver::geometry::sampling::{sphere_direction, spread};

/// Half the cells' size must leave this share of a quadratic error: a quarter, and what finite cells are off that. An
/// octant, a quarter of a turn wide, is not small: from level 1 on, and from level 2 on those of a tetrahedron.
const QUARTER: f64 = 0.3;

/// Colours are stored with nine bits: errors are not measured below.
const ROUNDING: f64 = 4e-3;

struct Linear(Vec3);

impl Source for Linear {
    fn eval(&mut self, _: &[u32], direction: Vec3) -> Rgb {
        Rgb::splat(1.0 + self.0.dot(direction))
    }
    fn narrow(&self, _: &mut Vec<u32>, _: std::ops::Range<usize>, _: Vec3, _: usize) {}
    fn candidate_count(&self) -> u32 {
        0
    }
}

#[test]
fn the_error_of_a_linear_function_is_quadratic_in_the_size_of_cells() {
    const DIRECTIONS: u32 = 20_000;
    let axis = Vec3::new(0.4, -0.5, 0.6);
    for (basis, first) in [(Basis::Haar, 1), (Basis::Uniform, 2)] {
        let error = |level: u32| {
            let how = Projection {
                min_level: level,
                max_level: level,
                epsilon: 1.0,
                floor: 0.0,
                relative: true,
                horizon: None,
                integral: None,
                basis,
            };
            let mut words = Vec::new();
            let cost = Projector::default().project(&mut Linear(axis), &how, &mut words);
            assert!(packed::is_well_formed(&words));
            let expected = match basis {
                Basis::Haar => 8 * 4u64.pow(level),
                Basis::Uniform => 2 * 4u64.pow(level) + 2,
            };
            assert_eq!(cost.basis_functions, expected);
            let wrong = |i: u32| {
                let direction = sphere_direction(spread(i));
                f64::from(packed::evaluate(&words, direction).g - 1.0 - axis.dot(direction))
            };
            let squares: f64 = (0..DIRECTIONS).map(|i| wrong(i).powi(2)).sum();
            (squares / f64::from(DIRECTIONS)).sqrt()
        };
        let mut last = error(first);
        println!("{basis:?}, level {first}: rms error {last:.5}");
        for level in first + 1..first + 4 {
            let now = error(level);
            println!(
                "level {level}: rms error {now:.5}, {:.3} of the last",
                now / last
            );
            assert!(
                now < QUARTER * last || now < ROUNDING,
                "level {level}: {now} after {last}"
            );
            last = now;
        }
    }
}
