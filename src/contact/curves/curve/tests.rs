use super::*;

fn sample() -> Cubic {
    Cubic {
        b: [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 2.0, 0.5), Vec3::new(3.0, -1.0, 1.0), Vec3::new(4.0, 0.5, 0.0)],
    }
}

#[test]
fn hermite_ends_and_derivatives() {
    let (p0, m0, p1, m1) = (Vec3::x(), Vec3::y(), Vec3::z(), Vec3::new(1.0, 2.0, 3.0));
    let c = Cubic::from_hermite(p0, m0, p1, m1);
    assert_eq!(c.point(0.0), p0);
    assert_eq!(c.point(1.0), p1);
    assert!((c.derivatives(0.0).1 - m0).norm() < 1e-15);
    assert!((c.derivatives(1.0).1 - m1).norm() < 1e-14);
    let h = 1e-5;
    let (_, d, dd) = c.derivatives(0.3);
    assert!(((c.point(0.3 + h) - c.point(0.3 - h)) / (2.0 * h) - d).norm() < 1e-9);
    let second = (c.derivatives(0.3 + h).1 - c.derivatives(0.3 - h).1) / (2.0 * h);
    assert!((second - dd).norm() < 1e-8);
}

#[test]
fn split_reproduces_the_curve() {
    let c = sample();
    let (l, r) = c.split();
    for i in 0..=10 {
        let u = f64::from(i) / 10.0;
        assert!((l.point(u) - c.point(u / 2.0)).norm() < 1e-14);
        assert!((r.point(u) - c.point(0.5 + u / 2.0)).norm() < 1e-14);
    }
    assert!(l.bulge() < c.bulge() && l.turning_bound() + r.turning_bound() <= c.turning_bound() + 1e-12);
}

#[test]
fn bulge_bounds_the_distance_from_the_chord() {
    let c = sample();
    let worst = (0..=1000)
        .map(|i| distance_to_segment(&(c.point(f64::from(i) / 1000.0) - c.b[0]), &c.chord()))
        .fold(0.0, f64::max);
    assert!(worst <= c.bulge() && c.bulge() < 2.5 * worst, "{worst} {}", c.bulge());
}

#[test]
fn turning_of_degenerate_polygons() {
    let (o, x, y) = (Vec3::zeros(), Vec3::x(), Vec3::y());
    assert_eq!(Cubic { b: [o; 4] }.turning_bound(), 0.0);
    assert_eq!(Cubic { b: [o, o, x, x] }.turning_bound(), 0.0);
    let half_pi = std::f64::consts::FRAC_PI_2;
    for unit in [1.0, 1e-160, 1e150] {
        assert!((Cubic { b: [o, x * unit, x * unit, (x + y) * unit] }.turning_bound() - half_pi).abs() < 1e-15);
    }
    let straight = Cubic::straight(o, Vec3::new(1.0, 2.0, 3.0));
    assert!(straight.turning_bound() < 1e-15);
}

/// Small angles take a series, and none feels the vectors' sizes.
#[test]
fn angles_are_right_to_rounding() {
    for k in 0..400 {
        let exact = 1e-18 * 1.12_f64.powi(k).min(3e18);
        let (sin, cos) = exact.sin_cos();
        for (size, other) in [(1.0, 1.0), (3e-5, 7e8), (1e-200, 1e-150), (2e80, 1e-80), (1e-59, 1e-59)] {
            let ours = angle(&(Vec3::x() * size), &(Vec3::new(cos, 0.6 * sin, -0.8 * sin) * other));
            assert!((ours - exact).abs() <= 4.0 * f64::EPSILON * exact, "{exact}, {size}, {other}: {ours}");
        }
    }
}

#[test]
fn set_indexing() {
    let p = [Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 1.0, 0.0), Vec3::y()];
    let set = CurveSet::from_polylines(&[(&p, 0.1, false), (&p, 0.2, true)]).unwrap();
    assert_eq!(set.len(), 7);
    assert_eq!((set.curve_of(2), set.curve_of(3)), (0, 1));
    assert_eq!((set.next(2), set.prev(0), set.next(6), set.prev(3)), (None, None, Some(3), Some(6)));
    assert_eq!(set.arc_length(1, 0.5), 1.5);
    assert_eq!(set.radius_of(4), 0.2);
}
