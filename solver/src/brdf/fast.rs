//! exp2 and log2 to single precision in plain arithmetic, so that loops over samples become vector code, and so that
//! every machine gives the same bits.

/// 2ˣ for x ≤ 127; zero below -126. Relative error below 3e-7.
#[inline]
pub(crate) fn exp2(x: f32) -> f32 {
    // Adding this leaves the nearest integer in the low bits of the mantissa.
    const ROUND: f32 = 12_582_912.0;
    let clamped = x.max(-126.0);
    let rounded = clamped + ROUND;
    let whole = rounded.to_bits().wrapping_sub(ROUND.to_bits());
    let f = clamped - (rounded - ROUND);
    let p = 1.0
        + f * (std::f32::consts::LN_2
            + f * (0.240_226_5
                + f * (0.055_504_11
                    + f * (0.009_618_129 + f * (0.001_333_355_8 + f * 0.000_154_035)))));
    let scale = f32::from_bits(whole.wrapping_add(127) << 23);
    if x < -126.0 { 0.0 } else { p * scale }
}

/// log₂ x for normal x > 0. Error below 2e-7 of the result near 1.
#[inline]
pub(crate) fn log2(x: f32) -> f32 {
    // Mantissa within [√½, √2).
    let bits = x.to_bits().wrapping_sub(0x3f35_04f3);
    let exponent = (bits as i32) >> 23;
    let m = f32::from_bits((bits & 0x007f_ffff).wrapping_add(0x3f35_04f3));
    let s = (m - 1.0) / (m + 1.0);
    let t = s * s;
    // 2/ln 2 · (s + s³/3 + s⁵/5 + s⁷/7 + s⁹/9)
    let series =
        s * (2.885_39 + t * (0.961_796_7 + t * (0.577_078 + t * (0.412_198_57 + t * 0.320_598_9))));
    exponent as f32 + series
}

#[cfg(test)]
mod tests {
    #[test]
    fn they_are_inverse_and_close_to_the_library() {
        for i in 1..2000 {
            let x = i as f32 * 0.01;
            assert!(
                (super::log2(x) - x.log2()).abs() <= 3e-7 * x.log2().abs().max(1.0),
                "{x}"
            );
            let y = -x * 6.0;
            assert!((super::exp2(y) / y.exp2() - 1.0).abs() < 1e-6, "{y}");
        }
        assert_eq!(
            (super::exp2(-200.0), super::exp2(0.0), super::log2(1.0)),
            (0.0, 1.0, 0.0)
        );
    }
}
