//! Exponents of measured growth.

/// The exponent p of y = c xᵖ, by least squares of the logarithms. Points that are not above zero are left out; `None`
/// without two different x.
pub fn power_law(points: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let points: Vec<(f64, f64)> = points
        .filter(|&(x, y)| x > 0.0 && y > 0.0)
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    let count = points.len() as f64;
    let (x, y) = points
        .iter()
        .fold((0.0, 0.0), |(x, y), p| (x + p.0 / count, y + p.1 / count));
    let square: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let product: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (square > 0.0).then(|| product / square)
}

#[cfg(test)]
mod tests {
    use super::power_law;

    #[test]
    fn an_exponent_is_found_whatever_the_factor() {
        let points = [1.0, 3.0, 10.0, 0.0].map(|x: f64| (x, 7.0 * x.powf(1.25)));
        let found = power_law(points.into_iter()).expect("three points");
        assert!((found - 1.25).abs() < 1e-12, "{found}");
        assert_eq!(power_law([(2.0, 1.0)].into_iter()), None);
        assert_eq!(power_law([(2.0, 1.0), (2.0, 3.0)].into_iter()), None);
    }
}
