//! 2^x and ln x that the compiler can vectorise, unlike those of the standard library.

use super::instructions::multiply_add;
use std::f64::consts::{LN_2, SQRT_2};

/// 1.5 * 2^52: adding it leaves the nearest integer in the low bits of the sum.
const ROUND_TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// Below this, 2^x is taken as 2^-1000 (1e-301): a normal number, negligible in every sum.
const MIN_ARGUMENT: f64 = -1000.0;

/// 2^r on -1/2 to 1/2 in powers of r from the first; minimax (Remez), 2e-16 relative.
const POWERS: [f64; 10] = [
    0.693_147_180_559_949_7,
    0.240_226_506_959_087_68,
    0.055_504_108_664_458_84,
    0.009_618_129_108_034_62,
    0.001_333_355_822_856_08,
    1.540_352_996_109_229e-4,
    1.525_265_811_689_166_4e-5,
    1.321_566_285_469_209_8e-6,
    1.020_853_785_087_644_6e-7,
    7.037_275_524_948_65e-9,
];

/// ln((1 + s) / (1 - s)) / s in powers of s^2, |s| <= (sqrt 2 - 1) / (sqrt 2 + 1); minimax, 1e-18.
const LOGARITHM: [f64; 8] = [
    2.0,
    0.666_666_666_666_676_5,
    0.399_999_999_992_988_8,
    0.285_714_287_613_471_06,
    0.222_221_969_882_120_17,
    0.181_836_350_958_308_38,
    0.153_124_437_190_844_48,
    0.148_105_302_088_233_03,
];

const MANTISSA_BITS: u32 = 52;
const MANTISSA: u64 = (1 << MANTISSA_BITS) - 1;
const BITS_OF_ONE: u64 = 1023 << MANTISSA_BITS;

/// 2^x for x <= 1000, within 1e-15 relative for x >= -1000.
#[inline(always)]
pub(super) fn exp2<const FUSED: bool>(x: f64) -> f64 {
    let x = if x > MIN_ARGUMENT { x } else { MIN_ARGUMENT };
    let shifted = x + ROUND_TO_INTEGER;
    let r = x - (shifted - ROUND_TO_INTEGER);
    let c = &POWERS;
    let fma = multiply_add::<FUSED>;
    let r2 = r * r;
    let r4 = r2 * r2;
    let first = fma(fma(c[2], r, c[1]), r2, fma(c[0], r, 1.0));
    let middle = fma(fma(c[6], r, c[5]), r2, fma(c[4], r, c[3]));
    let last = fma(c[9], r2, fma(c[8], r, c[7]));
    let value = fma(fma(last, r4, middle), r4, first);
    f64::from_bits(
        value
            .to_bits()
            .wrapping_add(shifted.to_bits() << MANTISSA_BITS),
    )
}

/// ln x for normal x > 0, within 1e-15 of it or relative to it.
#[inline(always)]
pub(super) fn ln<const FUSED: bool>(x: f64) -> f64 {
    let bits = x.to_bits();
    let significand = f64::from_bits(bits & MANTISSA | BITS_OF_ONE);
    let large = significand > SQRT_2;
    let m = if large {
        0.5 * significand
    } else {
        significand
    };
    // The exponent's bits as the low bits of a large number: an integer made a float without converting.
    let biased =
        f64::from_bits(bits >> MANTISSA_BITS | ROUND_TO_INTEGER.to_bits()) - ROUND_TO_INTEGER;
    let exponent = biased - if large { 1022.0 } else { 1023.0 };
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let series = LOGARITHM
        .iter()
        .rev()
        .fold(0.0, |sum, &c| multiply_add::<FUSED>(sum, z, c));
    multiply_add::<FUSED>(exponent, LN_2, s * series)
}

#[cfg(test)]
mod tests {
    use super::{exp2, ln};

    #[test]
    fn powers_of_two_agree_with_the_standard_library() {
        let mut worst = 0.0f64;
        for i in 0..2_000_000 {
            let x = -999.9 + 0.000_5 * f64::from(i);
            worst = worst.max((exp2::<false>(x) / x.exp2() - 1.0).abs());
            worst = worst.max((exp2::<true>(x) / x.exp2() - 1.0).abs());
        }
        assert!(worst < 1e-15, "{worst}");
        assert_eq!(exp2::<true>(0.0), 1.0);
        assert_eq!(exp2::<false>(f64::NEG_INFINITY), exp2::<false>(-1000.0));
        assert!(exp2::<false>(f64::NEG_INFINITY) < 1e-300);
    }

    #[test]
    fn logarithms_agree_with_the_standard_library() {
        let mut worst = 0.0f64;
        for i in 0..1_000_000 {
            let x = (-600.0 + 0.001_2 * f64::from(i)).exp();
            for y in [x, 1.0 + x.min(1e300).recip()] {
                let expected = y.ln();
                worst = worst.max((ln::<false>(y) - expected).abs() / expected.abs().max(1.0));
            }
        }
        assert!(worst < 1e-15, "{worst}");
        assert_eq!(ln::<false>(1.0), 0.0);
    }
}
