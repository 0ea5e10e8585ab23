//! Floats of either width in kernels that are compiled once for each.

use crate::blur::Sums;
use crate::diffusion::explicit::Real;

/// `f32` or `f64` with the few functions that hot loops need, all of which compile to
/// vector instructions and give the same bits whatever the vector's width.
///
/// Polynomials are written as sums of products, never as fused operations: these round
/// differently where the machine has none.
pub trait Float: Real + Default + Sums {
    /// Distance from 1 to the next number.
    const EPSILON: f64;
    /// `exp(-x)` for larger x is less than half of this type's rounding of 1.
    const NEGLIGIBLE: f64;

    /// Square root, rounded correctly.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;

    /// `exp(-x)` for `x` in [0, 80]; relative error below 5 roundings up to
    /// `x = 1`, growing in proportion to x.
    #[must_use]
    fn exp_negative(x: Self) -> Self;

    /// `ln(1 + y)` for `y` in [0, 1]; relative error below 3 roundings.
    #[must_use]
    fn ln_one_plus(y: Self) -> Self;
}

/// Coefficients of `sum_i r^i / i!`.
const EXPONENTIAL: [f64; 14] = {
    let mut terms = [1.0; 14];
    let mut i = 1;
    while i < 14 {
        terms[i] = terms[i - 1] / i as f64;
        i += 1;
    }
    terms
};

/// Coefficients of `atanh(z) / z = sum_i z^(2 i) / (2 i + 1)`.
const AREA_TANGENT: [f64; 16] = {
    let mut terms = [1.0; 16];
    let mut i = 1;
    while i < 16 {
        terms[i] = 1.0 / (2 * i + 1) as f64;
        i += 1;
    }
    terms
};

macro_rules! float {
    ($type:ty, $negligible:literal, $exponential:literal, $area:literal) => {
        impl Float for $type {
            const EPSILON: f64 = <$type>::EPSILON as f64;
            const NEGLIGIBLE: f64 = $negligible;

            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn exp_negative(x: Self) -> Self {
                // Adding 1.5 * 2^mantissa leaves the nearest integer in the low bits.
                const MANTISSA: u32 = <$type>::MANTISSA_DIGITS - 1;
                const SHIFT: $type = 1.5 * (1_u64 << MANTISSA) as $type;
                let exponent = x * -std::f64::consts::LOG2_E as $type;
                let shifted = exponent + SHIFT;
                let r = (exponent - (shifted - SHIFT)) * std::f64::consts::LN_2 as $type;
                let mut sum = EXPONENTIAL[$exponential] as $type;
                for i in (0..$exponential).rev() {
                    sum = sum * r + EXPONENTIAL[i] as $type;
                }
                let one: $type = 1.0;
                let scale = (shifted.to_bits() << MANTISSA).wrapping_add(one.to_bits());
                sum * <$type>::from_bits(scale)
            }

            #[inline(always)]
            fn ln_one_plus(y: Self) -> Self {
                let z = y / (2.0 + y);
                let square = z * z;
                let mut sum = AREA_TANGENT[$area] as $type;
                for i in (0..$area).rev() {
                    sum = sum * square + AREA_TANGENT[i] as $type;
                }
                (z + z) * sum
            }
        }
    };
}

// First terms left out: .347^8/8! = 5e-9 and (1/9)^7/15 = 1.4e-8; .347^14/14! = 4e-18 and
// (1/9)^16/33 = 2e-17.
float!(f32, 17.0, 7, 6);
float!(f64, 38.0, 13, 15);

#[cfg(test)]
mod tests {
    use super::Float;

    #[test]
    fn exponential_and_logarithm_against_libm() {
        let (mut worst, mut worst_single) = ([0.0_f64; 2], [0.0_f64; 2]);
        for i in 0..=8000 {
            let x = f64::from(i) * 0.01;
            let exact = libm::exp(-x);
            let scale = exact * x.max(1.0);
            worst[0] = worst[0].max((f64::exp_negative(x) - exact).abs() / scale);
            let single = f64::from(f32::exp_negative(x as f32));
            let exact = libm::exp(-f64::from(x as f32));
            worst_single[0] = worst_single[0].max((single - exact).abs() / (exact * x.max(1.0)));
            let y = f64::from(i + 1) / 8001.0;
            let exact = libm::log1p(y);
            worst[1] = worst[1].max((f64::ln_one_plus(y) - exact).abs() / exact);
            let single = f64::from(f32::ln_one_plus(y as f32));
            let exact = libm::log1p(f64::from(y as f32));
            worst_single[1] = worst_single[1].max((single - exact).abs() / exact);
        }
        for (worst, epsilon) in [(worst, f64::EPSILON), (worst_single, f64::from(f32::EPSILON))] {
            assert!(worst[0] < 2.5 * epsilon && worst[1] < 2.0 * epsilon, "{worst:?}");
        }
    }
}
