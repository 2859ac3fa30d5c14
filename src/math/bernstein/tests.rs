use super::*;

/// Bernstein coefficients of c Π (t − r).
fn from_roots(r: &[f64], c: f64) -> Vec<f64> {
    // Multiply Bernstein polynomials by (t − r) = −r (1−t) + (1−r) t.
    let mut b = vec![c];
    for &root in r {
        let n = b.len();
        let mut next = vec![0.0; n + 1];
        for i in 0..=n {
            let from_left = if i > 0 { b[i - 1] * i as f64 / n as f64 } else { 0.0 };
            let from_same = if i < n { b[i] * (n - i) as f64 / n as f64 } else { 0.0 };
            next[i] = (1.0 - root) * from_left - root * from_same;
        }
        b = next;
    }
    b
}

fn find(b: &[f64]) -> Vec<f64> {
    let mut out = Roots::new();
    roots(b, &mut out);
    out.as_slice().to_vec()
}

#[test]
fn simple_roots_to_machine_precision_at_any_scale() {
    let r = [0.1, 0.25, 0.5, 0.7, 0.99];
    for scale in [1.0, 1e-150, 1e150, 1e-290, -3.7] {
        let found = find(&from_roots(&r, scale));
        assert_eq!(found.len(), 5, "{scale}: {found:?}");
        for (a, b) in found.iter().zip(&r) {
            assert!((a - b).abs() < 1e-13, "{a} {b}");
        }
    }
}

/// A change of sign leads to its own root, not to one just beyond the end, where the secant starts.
#[test]
fn a_root_beyond_the_end_is_not_mistaken_for_the_one_inside() {
    for beyond in [1.0 + 1e-16, 1.0 + 1e-15, 1.0 + 1e-13, 1.0 + 1e-9] {
        let found = find(&from_roots(&[0.1, beyond, 3.0], 1.0));
        assert!((found[0] - 0.1).abs() < 1e-14, "{beyond}: {found:?}");
    }
}

#[test]
fn ends_and_midpoint_are_exact() {
    let mut out = Roots::new();
    roots(&from_roots(&[0.0, 0.5, 1.0], 1.0), &mut out);
    assert_eq!(out.as_slice(), &[0.0, 0.5, 1.0]);
    let crossings: Vec<_> = out.iter().map(|r| r.crossing).collect();
    assert_eq!(crossings, [SignChange::Rising, SignChange::Falling, SignChange::Rising]);
}

#[test]
fn multiple_roots_are_one() {
    let mut out = Roots::new();
    for (r, crossing) in [
        (&[0.3, 0.3][..], SignChange::Touching),
        (&[0.3, 0.3, 0.3], SignChange::Rising),
        (&[0.5, 0.5], SignChange::Touching),
        (&[0.3, 0.3 + 1e-12], SignChange::Touching),
    ] {
        roots(&from_roots(r, 1.0), &mut out);
        assert!(out.as_slice().len() <= 1, "{r:?} {out:?}");
        for root in out.iter() {
            assert_eq!(root.crossing, crossing);
            assert!((root.t - r[0]).abs() < 3e-5, "{r:?} {root:?}");
        }
    }
}

#[test]
fn odd_multiple_root_is_never_lost() {
    assert_eq!(find(&from_roots(&[0.3, 0.3, 0.3, 0.3, 0.3], 1.0)).len(), 1);
}

#[test]
fn near_double_roots_are_separated_when_f64_can() {
    let found = find(&from_roots(&[0.3, 0.3 + 1e-6], 1.0));
    assert_eq!(found.len(), 2);
    assert!((found[0] - 0.3).abs() < 1e-9 && (found[1] - 0.300001).abs() < 1e-9);
}

#[test]
fn degenerate_inputs() {
    let mut out = Roots::new();
    roots(&[0.0; 6], &mut out);
    assert!(out.identically_zero() && out.as_slice().is_empty());
    for b in [&[][..], &[1.0], &[f64::NAN, 1.0], &[-1.0, f64::INFINITY]] {
        roots(b, &mut out);
        assert!(out.as_slice().is_empty() && !out.identically_zero());
    }
    assert_eq!(find(&[0.0, 0.0, 1.0]), [0.0]);
    assert_eq!(find(&[1.0, 0.0, 0.0]), [1.0]);
}

#[test]
fn tiny_root_keeps_relative_precision() {
    let found = find(&[-1e-30, 1.0]);
    assert!((found[0] - 1e-30).abs() < 1e-45);
}

#[test]
fn helpers() {
    let b = from_roots(&[0.2, 0.9], 2.0);
    assert!((eval(&b, 0.4) - 2.0 * 0.2 * -0.5).abs() < 1e-15);
    assert!((eval(&derivative(&b)[..2], 0.4) - 2.0 * (0.2 - 0.5)).abs() < 1e-15);
    assert_eq!(derivative(&[3.0])[0], 0.0);
}
