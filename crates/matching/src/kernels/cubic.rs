//! What lies between samples (Catmull & Rom 1974; Keys 1981).

/// The value and the slope of the cubic through four samples, the part `t` of the way from the second to the third.
#[inline(always)]
pub(crate) fn cubic([a, b, c, d]: [f32; 4], t: f32) -> (f32, f32) {
    let line = c - a;
    let square = 2.0 * a - 5.0 * b + 4.0 * c - d;
    let cube = 3.0 * (b - c) + d - a;
    let value = b + 0.5 * t * (line + t * (square + t * cube));
    let slope = 0.5 * (line + t * (2.0 * square + t * 3.0 * cube));
    (value, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_followed_and_samples_are_met() {
        let parabola = |x: f32| 3.0 * x * x - 2.0 * x + 7.0;
        let samples = [-1.0, 0.0, 1.0, 2.0].map(parabola);
        for t in [0.0, 0.25, 0.5, 1.0] {
            assert_eq!(cubic(samples, t), (parabola(t), 6.0 * t - 2.0));
        }
        let step = [0.0, 0.0, 8.0, 8.0];
        assert_eq!([0.0, 0.5, 1.0].map(|t| cubic(step, t)), [(0.0, 4.0), (4.0, 10.0), (8.0, 4.0)]);
    }
}
