//! Sums with their rounding errors.

use crate::math::Vec3;

/// a + b as rounded, and its rounding error (Knuth, The Art of Computer Programming 2, section 4.2.2):
/// the two together are exact, whichever is larger, unless the sum overflows.
#[inline]
pub(crate) fn two_sum(a: &Vec3, b: &Vec3) -> (Vec3, Vec3) {
    let sum = a + b;
    let b_in_sum = sum - a;
    (sum, (a - (sum - b_in_sum)) + (b - b_in_sum))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sum_and_remainder_are_exact() {
        // representable sums of powers of two, told by integer arithmetic
        let a = Vec3::new(1.0, -(2f64.powi(60)), 3.0);
        let b = Vec3::new(2f64.powi(-70), 1.0 + 2f64.powi(-20), -2f64.powi(-54));
        let (sum, lost) = two_sum(&a, &b);
        assert_eq!(sum, Vec3::new(1.0, -(2f64.powi(60)), 3.0));
        assert_eq!(lost, b);
        assert_eq!(two_sum(&b, &a), (sum, lost));
        let (sum, lost) = two_sum(&Vec3::repeat(0.1), &Vec3::repeat(0.2));
        // 0.1 + 0.2 in units of 2⁻⁵⁷, as integers
        let units = |x: f64| (x * 2f64.powi(57)) as i64;
        assert_eq!(units(sum.x) + units(lost.x), units(0.1) + units(0.2));
        assert!(lost.x != 0.0);
    }
}
