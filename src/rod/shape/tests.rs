use std::f64::consts::PI;

use super::*;

fn helix_shape() -> Shape {
    Shape::Helix {
        center: Vec3::new(1.0, -2.0, 0.5),
        axis: Vec3::new(0.3, 0.2, 1.0),
        radius: 0.7,
        pitch: -0.9,
        turns: 2.3,
    }
}

fn open_shapes() -> Vec<Shape> {
    let arc = Shape::Arc {
        start: Vec3::new(0.1, 0.2, 0.3),
        tangent: Vec3::new(1.0, 1.0, 0.0),
        towards: Vec3::new(0.0, 1.0, 1.0),
        radius: 3.0,
        angle: 1.9,
    };
    let line = Shape::Line { start: Vec3::x(), direction: Vec3::new(0.0, 0.0, -4.0), length: 2.0 };
    let wave = (0..40).map(f64::from).map(|t| Vec3::new(t, (0.4 * t).sin() * 3.0, (0.3 * t).cos() * 2.0)).collect();
    vec![line, arc, helix_shape(), Shape::Points(wave)]
}

/// Twist between two frames by double reflection (Wang et al. 2008), fourth order.
fn twist_between(x: [&Vec3; 2], q: [&Quat; 2]) -> f64 {
    let v1 = x[1] - x[0];
    let reflect = |v: Vec3, n: &Vec3| v - n * (2.0 * n.dot(&v) / n.norm_squared());
    let (d1, d3) = (reflect(q[0] * Vec3::x(), &v1), reflect(q[0] * Vec3::z(), &v1));
    let v2 = q[1] * Vec3::z() - d3;
    let carried = if v2.norm() < 1e-300 { d1 } else { reflect(d1, &v2) };
    (q[1] * Vec3::y()).dot(&carried).atan2((q[1] * Vec3::x()).dot(&carried))
}

#[test]
fn tangents_are_derivatives_and_arc_lengths_equal() {
    for shape in open_shapes() {
        let fine = shape.place(false, 4000).unwrap();
        let h = fine.length / 4000.0;
        for i in 2..3999 {
            let p = |k: usize| fine.positions[k];
            let derivative = ((p(i + 1) - p(i - 1)) * 8.0 - (p((i + 2).min(4000)) - p(i - 2))) / (12.0 * h);
            // third derivatives of the spline jump at its knots, which costs the difference quotient its fourth order
            assert!((derivative - fine.frames[i] * Vec3::z()).norm() < 1e-5, "{shape:?} node {i}");
        }
    }
}

#[test]
fn frames_are_twist_free() {
    for shape in open_shapes() {
        let fine = shape.place(false, 8000).unwrap();
        let total: f64 = (0..8000)
            .map(|i| {
                let (x, q) = (&fine.positions, &fine.frames);
                twist_between([&x[i], &x[i + 1]], [&q[i], &q[i + 1]])
            })
            .sum();
        // the jumps of the third derivative at the knots of a spline cost double reflection, the test's own tool, its
        // order
        let tolerance = if matches!(shape, Shape::Points(_)) { 1e-6 } else { 1e-11 };
        assert!(total.abs() < tolerance, "{total:e} {shape:?}");
    }
}

/// A coarse placement has the very frames of a fine one: nothing depends on the spacing of nodes.
#[test]
fn frames_do_not_depend_on_the_number_of_nodes() {
    for shape in open_shapes() {
        let (coarse, fine) = (shape.place(false, 7).unwrap(), shape.place(false, 700).unwrap());
        for i in 0..8 {
            let angle = coarse.frames[i].angle_to(&fine.frames[100 * i]);
            assert!(angle < 1e-12, "{angle:e} {shape:?}");
            assert!((coarse.positions[i] - fine.positions[100 * i]).norm() < 1e-12 * coarse.length);
        }
    }
}

#[test]
fn circle_is_exact() {
    let circle = Shape::Circle { length: 4.0, center: Vec3::x(), normal: Vec3::z() * 1e-200 };
    let placement = circle.place(true, 12).unwrap();
    assert_eq!(placement.positions.len(), 12);
    let radius = 2.0 / PI;
    for (position, frame) in placement.positions.iter().zip(&placement.frames) {
        let outward = (position - Vec3::x()) / radius;
        assert!((outward.norm() - 1.0).abs() < 1e-15);
        assert!((frame * Vec3::x() - Vec3::z()).norm() < 1e-15);
        assert!((frame * Vec3::z() - Vec3::z().cross(&outward)).norm() < 1e-15);
    }
}

#[test]
fn helix_has_its_length_and_handedness() {
    let placement = helix_shape().place(false, 200).unwrap();
    assert!((placement.length - 2.3 * (TAU * 0.7).hypot(0.9)).abs() < 1e-13);
    let axis = Vec3::new(0.3, 0.2, 1.0).normalize();
    assert!(((placement.positions[200] - placement.positions[0]).dot(&axis) + 0.9 * 2.3).abs() < 1e-13);
}

#[test]
fn points_on_a_circle_give_the_circle() {
    let error = |count: usize| {
        let angles = (0..count).map(|i| TAU * i as f64 / count as f64);
        let points = angles.map(|a| Vec3::new(a.cos(), a.sin(), 2.0)).collect();
        let placement = Shape::Points(points).place(true, 11).unwrap();
        for frame in &placement.frames {
            assert!((frame * Vec3::x() - Vec3::z()).norm() < 1e-15);
        }
        (placement.length - TAU).abs()
    };
    let (coarse, fine) = (error(16), error(32));
    assert!(fine < 2e-5 && coarse / fine > 12.0, "{coarse:e} {fine:e}");
}

#[test]
fn two_points_make_a_line() {
    let placement = Shape::Points(vec![Vec3::zeros(), Vec3::new(3.0, 4.0, 0.0)]).place(false, 5).unwrap();
    assert!((placement.length - 5.0).abs() < 1e-14);
    assert!((placement.positions[2] - Vec3::new(1.2, 1.6, 0.0)).norm() < 1e-14);
}

#[test]
fn bad_shapes_are_refused_with_field_and_value() {
    let text = |shape: Shape, closed: bool| shape.place(closed, 4).unwrap_err().to_string();
    let line = |direction: Vec3, length: f64| Shape::Line { start: Vec3::zeros(), direction, length };
    assert_eq!(text(line(Vec3::x(), 0.0), false), "shape.length = 0: must be a finite number greater than 0");
    assert_eq!(text(line(Vec3::zeros(), 1.0), false), "shape.direction = (0, 0, 0): must be finite and not zero");
    assert!(text(line(Vec3::x(), 1.0), true).contains("a line is open"));
    assert!(text(helix_shape(), true).contains("a helix is open"));
    let circle = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    assert!(text(circle.clone(), false).contains("a circle is closed"));
    assert!(circle.place(true, 0).unwrap_err().to_string().contains("elements = 0"));
    let points = |rows: &[[f64; 3]]| Shape::Points(rows.iter().map(|&row| row.into()).collect());
    assert!(text(points(&[[0.0; 3], [1.0, f64::NAN, 0.0]]), false).starts_with("shape.points[1] = (1, NaN, 0)"));
    assert!(text(points(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), false).contains("points 1 and 2 coincide"));
    let repeated = points(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0; 3]]);
    assert!(text(repeated, true).contains("does not repeat its first point"));
    assert!(text(points(&[[0.0; 3], [1.0; 3]]), true).contains("at least 3 points"));
    // straight out and straight back: the frame cannot be carried round the tip, wherever nodes lie (without this,
    // quadrature of no numbers did not end)
    let back = points(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]]);
    for num_segments in [4, 9, 30] {
        let refused = back.place(false, num_segments).unwrap_err().to_string();
        assert!(refused.contains("turns back on itself in a cusp between points 1 and 2"), "{refused}");
    }
}
