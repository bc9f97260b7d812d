//! Functions of one number that give the same bits on every machine.
//!
//! IEEE 754 rounds `+ - * /` and `sqrt` in exactly one way, and Rust never fuses or reorders them;
//! the platform's `sin`, `exp` and `powf` may differ in the last bit, and a last bit can move a
//! pixel's grey. So this crate calls none of them: turns are made from tangents of half angles
//! ([`crate::vector::Frame::about`]), and the few powers are computed here. `f64::min` and `max`
//! are avoided too, since the sign of a zero that they return is not defined.

/// The smaller one; `b` when they are equal.
#[inline]
pub(crate) fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger one; `b` when they are equal.
#[inline]
pub(crate) fn greatest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// From `a` at 0 to `b` at 1.
#[inline]
pub(crate) fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// 0 up to `from`, 1 past `to`, and between them the cubic whose ends are flat.
#[inline]
pub(crate) fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let s = ((x - from) / (to - from)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Base-2 logarithm of a positive normal number, to about 1e-12.
fn log2(x: f64) -> f64 {
    const FRACTION: u64 = (1 << 52) - 1;
    let bits = x.to_bits();
    let mut exponent = ((bits >> 52) as i64 - 1023) as f64;
    let mut m = f64::from_bits(bits & FRACTION | 1023 << 52);
    if m > std::f64::consts::SQRT_2 {
        m *= 0.5;
        exponent += 1.0;
    }
    // ln m = 2 artanh(s) = 2 (s + s^3/3 + s^5/5 + ...), and |s| < 0.172.
    let s = (m - 1.0) / (m + 1.0);
    let square = s * s;
    let mut series = 0.0;
    for k in (0..7).rev() {
        series = series * square + 1.0 / f64::from(2 * k + 1);
    }
    exponent + 2.0 * s * series * std::f64::consts::LOG2_E
}

/// 2 to the power `x`, to about 1e-12 relative; 0 or infinity past the range of `f64`.
pub(crate) fn exp2(x: f64) -> f64 {
    if x < -1020.0 {
        return 0.0;
    }
    if x > 1023.0 {
        return f64::INFINITY;
    }
    let whole = x.round();
    let y = (x - whole) * std::f64::consts::LN_2;
    let mut series = 1.0;
    for k in (1..12).rev() {
        series = 1.0 + series * y / f64::from(k);
    }
    series * f64::from_bits(((whole as i64 + 1023) as u64) << 52)
}

/// `base` to the power `exponent`; 0 for a base that is not positive.
pub(crate) fn power(base: f64, exponent: f64) -> f64 {
    if base < f64::MIN_POSITIVE { 0.0 } else { exp2(exponent * log2(base)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::disallowed_methods)] // compared with, not rendered by
    fn powers_agree_with_the_standard_library() {
        for i in 1..400 {
            let base = f64::from(i) * f64::from(i) * 1e-4;
            for exponent in [-2.5, -1.0, 1.0 / 2.2, 0.5, 1.0, 2.2, 7.0] {
                let (own, std) = (power(base, exponent), base.powf(exponent));
                assert!((own / std - 1.0).abs() < 1e-10, "{base}^{exponent}: {own} {std}");
            }
        }
        assert_eq!(power(0.0, 0.45), 0.0);
        assert_eq!(power(1.0, 0.45), 1.0);
    }

    #[test]
    fn smoothstep_is_flat_outside() {
        assert_eq!(smoothstep(1.0, 2.0, 0.5), 0.0);
        assert_eq!(smoothstep(1.0, 2.0, 1.5), 0.5);
        assert_eq!(smoothstep(1.0, 2.0, 9.0), 1.0);
    }
}
