//! Errors as colours: black, purple, orange, pale yellow.

/// Polynomial fit of the "magma" colour map of matplotlib (CC0), by powers of the value.
const MAGMA: [[f64; 3]; 7] = [
    [
        -0.002136485053939582,
        -0.000749655052795221,
        -0.005386127855323933,
    ],
    [0.2516605407371642, 0.6775232436837668, 2.494026599312351],
    [8.353717279216625, -3.577719514958484, 0.3144679030132573],
    [-27.66873308576866, 14.26473078096533, -13.64921318813922],
    [52.17613981234068, -27.94360607168351, 12.94416944238394],
    [-50.76852536473588, 29.04658282127291, 4.23415299384598],
    [18.65570506591883, -11.48977351997711, -5.601961508734096],
];

/// sRGB bytes of a value within 0..1; others are clamped.
pub fn magma(value: f32) -> [u8; 3] {
    let x = f64::from(value).clamp(0.0, 1.0);
    let channel = |i: usize| MAGMA.iter().rev().fold(0.0, |sum, c| sum * x + c[i]);
    [0, 1, 2].map(|i| (channel(i).clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
}

/// sRGB bytes of a map of values, three a pixel.
pub fn image(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|&value| magma(value)).collect()
}

#[cfg(test)]
mod tests {
    use super::magma;

    #[test]
    fn the_map_grows_lighter() {
        let sum = |value| magma(value).iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!(sum(0.0) < 10 && sum(1.0) > 600);
        assert!((1..=10).all(|i| sum(i as f32 / 10.0) > sum((i - 1) as f32 / 10.0)));
        assert_eq!(magma(2.0), magma(1.0));
    }
}
