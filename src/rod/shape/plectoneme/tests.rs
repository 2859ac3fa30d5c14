use super::*;
use crate::math::link::{writhe, writhe_smooth};

const SAMPLES: [(f64, f64, f64); 5] =
    [(150.0, 5.0, 0.4), (300.0, 5.0, -0.2), (400.0, 2.0, 0.7), (80.0, 1.0, -FRAC_PI_4), (500.0, 3.0, 0.05)];

fn plectonemes() -> impl Iterator<Item = Plectoneme> {
    SAMPLES.into_iter().map(|(length, distance, angle)| Plectoneme::of_angle(length, distance, angle).unwrap())
}

/// Length, writhe and bending energy are sums of closed forms and quadratures: against the placed curve.
#[test]
fn the_formulas_are_those_of_the_curve() {
    for p in plectonemes() {
        let axis = AxisCurve::new(&p.axis, p.distance).unwrap();
        let wound = WoundStrands { half_loop: p.half_loop(), height: p.helix_height(), axis: &axis };
        let measured = Measured::new(&wound, &wound.breaks(1));
        assert!((measured.length() / p.length - 1.0).abs() < 1e-13, "{} {p:?}", measured.length());
        let curve = |u: f64| {
            let [position, tangent] = wound.at(6.0 * u);
            (position, tangent)
        };
        let panels = 6 * (40.0 * (1.0 + p.turns().abs())) as usize;
        let found = writhe_smooth(&curve, panels);
        assert!((found - p.writhe()).abs() < 1e-9, "{found} {} {p:?}", p.writhe());
        let bending = |num: usize| {
            let placement = p.place(num).unwrap();
            let (x, h) = (&placement.positions, p.length / num as f64);
            let second = |i: usize| (x[(i + 1) % num] - x[i] * 2.0 + x[(i + num - 1) % num]) / (h * h);
            0.5 * h * (0..num).map(|i| second(i).norm_squared()).sum::<f64>()
        };
        let [coarse, fine] = [4000, 8000].map(bending);
        let limit = fine + (fine - coarse) / 3.0;
        assert!((limit / p.bending() - 1.0).abs() < 1e-5, "{limit} {} {p:?}", p.bending());
    }
}

/// Nodes are those of a finer placement, the distance across is `distance`, and the curvature has no jumps.
#[test]
fn nodes_are_even_and_opposite() {
    for p in plectonemes() {
        let [coarse, fine] = [300, 9600].map(|num| p.place(num).unwrap());
        for i in 0..300 {
            assert!((coarse.positions[i] - fine.positions[32 * i]).norm() < 1e-11 * p.length);
            assert!(coarse.frames[i].angle_to(&fine.frames[32 * i]) < 1e-7, "{i} {p:?}");
        }
        let (x, h) = (&fine.positions, p.length / 9600.0);
        let axial = |v: &Vec3| v.x.abs(); // along x by default
        for i in 1..4800 {
            let (a, b) = (x[i], x[9600 - i]);
            assert!((a.x - b.x).abs() < 1e-9 * p.length && (a + b).yz().norm() < 1e-9 * p.length, "{i} {p:?}");
            assert!((a - b).norm() > p.distance - 1e-9 * p.length || axial(&a) > 0.5 * p.helix_height(), "{i} {p:?}");
        }
        let second = |i: usize| (x[(i + 1) % 9600] - x[i] * 2.0 + x[(i + 9599) % 9600]) / (h * h);
        let radius = 0.5 * p.distance;
        for i in 0..9600 {
            let jump = (second((i + 1) % 9600) - second(i)).norm();
            assert!(jump < 8.0 * h / (radius * radius), "{i}: {jump} {p:?}");
            assert!(second(i).norm() * radius < 0.9, "curvature {} at {i} {p:?}", second(i).norm());
        }
    }
}

#[test]
fn frames_are_twist_free() {
    for p in plectonemes() {
        let num = 4000;
        let placement = p.place(num).unwrap();
        let twist: f64 = (0..num - 1)
            .map(|i| {
                let (x, q) = (&placement.positions, &placement.frames);
                let reflect = |v: Vec3, n: &Vec3| v - n * (2.0 * n.dot(&v) / n.norm_squared());
                let chord = x[i + 1] - x[i];
                let (d1, d3) = (reflect(q[i] * Vec3::x(), &chord), reflect(q[i] * Vec3::z(), &chord));
                let carried = reflect(d1, &(q[i + 1] * Vec3::z() - d3));
                (q[i + 1] * Vec3::y()).dot(&carried).atan2((q[i + 1] * Vec3::x()).dot(&carried))
            })
            .sum();
        // double reflection, the test's own tool, is of fourth order in the spacing
        assert!(twist.abs() < 1e-4, "{twist:e} {p:?}");
    }
}

#[test]
fn asked_turns_are_met() {
    for (length, distance, turns) in [(100.0, 2.0, 3.0), (100.0, 2.0, -4.1), (3000.0, 1.0, 200.0), (50.0, 2.0, 0.4)] {
        let p = Plectoneme::of_turns(length, distance, turns).unwrap();
        assert!((p.turns() - turns).abs() < 1e-12 * turns.abs().max(1.0), "{} {turns}", p.turns());
        assert!(p.place(30).is_ok());
    }
}

/// Of all angles and loop sizes the chosen ones have the least energy: both derivatives vanish (or point out of the
/// range), the second ones are positive, and a coarse search over everything finds nothing lower.
#[test]
fn the_energy_is_least() {
    for (length, distance, ratio, link) in
        [(114.24, 5.0, 1.5, -3.0), (914.0, 5.0, 1.5, -15.3), (1.0, 0.01, 1.5, 4.773), (1.0, 0.002, 0.8, -30.0)]
    {
        let best = Plectoneme::of_link(length, distance, 1.0, ratio, link).unwrap();
        assert!(best.angle * link < 0.0 && best.writhe() * link > 0.0);
        let of =
            |angle: f64, size: f64| energy::energy(&Plectoneme { angle, loop_size: size, ..best.clone() }, ratio, link);
        let (a, s, least) = (best.angle, best.loop_size, of(best.angle, best.loop_size));
        let h = 1e-4;
        let [up, down] = [1.0 + h, 1.0 - h].map(|f| of(a * f, s));
        assert!(((up - down) / (2.0 * h)).abs() < 1e-5 * least && up + down > 2.0 * least, "angle {best:?}");
        let [up, down] = [1.0 + h, 1.0 - h].map(|f| of(a, s * f));
        let slope = (up - down) / (2.0 * h);
        let at_bound = s < 2.0 * distance * 1.000001;
        assert!(slope.abs() < 1e-5 * least || (at_bound && slope > 0.0), "loops {slope} {least} {best:?}");
        for i in 1..40 {
            for k in 0..40 {
                let (angle, size) = (FRAC_PI_4 * f64::from(i) / 40.0, 2.0 * distance * 1.1_f64.powi(k));
                let other = Plectoneme { angle: angle.copysign(a), loop_size: size, ..best.clone() };
                if other.check().is_ok() {
                    assert!(of(other.angle, size) >= least * (1.0 - 1e-12), "{other:?} is lower than {best:?}");
                }
            }
        }
    }
}

/// Far longer than its loops a plectoneme has the closed form's angle, and the moment of a plectoneme under end load.
#[test]
fn long_plectonemes_follow_the_closed_form() {
    for (ratio, density) in [(1.5, 0.05), (0.7, 0.2), (2.0, 0.4)] {
        let (length, distance) = (1e6, 1.0);
        let alpha = superhelix_angle(distance, ratio, density).unwrap();
        let best = Plectoneme::of_link(length, distance, 1.0, ratio, density * length).unwrap();
        assert!((-best.angle - alpha).abs() < 1e-4, "{} {alpha}", best.angle);
        let radius = 0.5 * distance;
        let writhe = (2.0 * alpha).sin() / (4.0 * PI * radius);
        let moment = TAU * ratio * (density - writhe);
        let expected = 2.0 * alpha.sin().powi(3) * alpha.cos() / (radius * (2.0 * alpha).cos());
        assert!((moment / expected - 1.0).abs() < 1e-12, "{moment} {expected}");
    }
}

/// The other hand is the mirror image.
#[test]
fn both_hands_are_alike() {
    let [left, right] = [6.0, -6.0].map(|link| Plectoneme::of_link(300.0, 4.0, 1.0, 1.5, link).unwrap());
    assert_eq!(left, Plectoneme { angle: -right.angle, ..right.clone() });
    assert_eq!(left.writhe(), -right.writhe());
    assert!(left.writhe() > 0.0);
    let [a, b] = [&left, &right].map(|p| p.place(300).unwrap());
    for (a, b) in a.positions.iter().zip(&b.positions) {
        // the axis runs along x; angle 0 lies along z, the frame's d1
        assert!((a - Vec3::new(b.x, -b.y, b.z)).norm() < 1e-11);
    }
    let points = &right.place(2000).unwrap().positions;
    assert!((writhe(points, true) - right.writhe()).abs() < 1e-3);
}

/// Wound about an arc, a helix and a spline: the length is the rod's, strands are the distance apart, the writhe hardly
/// changes.
#[test]
fn curved_axes() {
    let straight = Plectoneme::of_angle(2000.0, 2.0, 0.5).unwrap();
    let wave =
        (0..60).map(f64::from).map(|t| Vec3::new(20.0 * t, (0.3 * t).sin() * 40.0, (0.2 * t).cos() * 30.0)).collect();
    let arc = Shape::Arc { start: Vec3::zeros(), tangent: Vec3::x(), towards: Vec3::y(), radius: 300.0, angle: 3.0 };
    let coil = Shape::Helix { center: Vec3::zeros(), axis: Vec3::z(), radius: 40.0, pitch: 8.0, turns: 5.0 };
    for shape in [arc, coil, Shape::Points(wave)] {
        let p = straight.clone().about(Axis::Along(Box::new(shape)));
        let num = 12_000;
        let placement = p.place(num).unwrap();
        let (x, h) = (&placement.positions, 2000.0 / num as f64);
        let chord = |i: usize| (x[(i + 1) % num] - x[i]).norm();
        for i in 0..num {
            assert!((chord(i) / h - 1.0).abs() < 2e-3, "{i} {}", chord(i) / h); // chords of arcs of equal length
        }
        // Opposite nodes are not at exactly opposite places any more: the nearest point of the other strand is.
        for i in (800..5200).step_by(7) {
            let nearest = (num - i - 20..=num - i + 20).map(|j| (x[i] - x[j]).norm()).fold(f64::MAX, f64::min);
            assert!((nearest - 2.0).abs() < 0.01, "{i} {nearest}");
        }
        assert!((writhe(x, true) - straight.writhe()).abs() < 0.01 * straight.writhe().abs(), "{}", writhe(x, true));
        for i in 2..num - 2 {
            let tangent = ((x[i + 1] - x[i - 1]) * 8.0 - (x[i + 2] - x[i - 2])) / (12.0 * h);
            let error = (placement.frames[i] * Vec3::z() - tangent).norm();
            assert!(error < 3e-3, "{i}: {error}"); // third derivatives jump where helix and loop meet
        }
    }
}

#[test]
fn unfit_plectonemes_are_refused() {
    let text = |p: Result<Plectoneme, InputError>| p.unwrap_err().to_string();
    let of_link = |length: f64, distance: f64, link: f64| Plectoneme::of_link(length, distance, 1.0, 1.5, link);
    assert!(text(of_link(100.0, 2.0, 0.9)).contains("too small for a plectoneme: the flat circle has less energy"));
    assert!(text(of_link(20.0, 2.0, 3.0)).contains("too short for a plectoneme"));
    assert!(text(of_link(100.0, 2.0, 0.0)).starts_with("excess_link = 0"));
    assert!(text(of_link(100.0, -2.0, 1.0)).starts_with("shape.distance = -2"));
    assert!(text(of_link(f64::NAN, 2.0, 1.0)).starts_with("shape.length = NaN"));
    assert!(text(Plectoneme::of_link(100.0, 2.0, 0.0, 1.5, 3.0)).starts_with("section.bending = 0"));
    assert!(text(Plectoneme::of_angle(100.0, 2.0, 0.8)).starts_with("shape.angle = 0.8"));
    assert!(text(Plectoneme::of_turns(100.0, 2.0, 40.0)).starts_with("shape.turns = 40: must be no more"));
    assert!(superhelix_angle(1.0, 1.5, 0.0).is_err() && superhelix_angle(1.0, f64::NAN, 1.0).is_err());
    let good = Plectoneme::of_angle(600.0, 2.0, 0.5).unwrap();
    let place = |p: &Plectoneme| p.place(300).unwrap_err().to_string();
    assert!(place(&Plectoneme { loop_size: 3.0, ..good.clone() }).starts_with("shape.loop_size = 3"));
    let about = |shape: Shape| place(&good.clone().about(Axis::Along(Box::new(shape))));
    let helix = |radius: f64, pitch: f64, turns: f64| Shape::Helix {
        center: Vec3::zeros(),
        axis: Vec3::z(),
        radius,
        pitch,
        turns,
    };
    assert!(about(helix(40.0, 8.0, 1.0)).contains("but the plectoneme needs"));
    assert!(about(helix(20.0, 3.0, 9.0)).contains("of itself"));
    assert!(about(helix(1.5, 1.0, 90.0)).contains("shape.axis"));
    assert!(about(Shape::Circle { length: 9.0, center: Vec3::zeros(), normal: Vec3::z() }).contains("an open curve"));
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: -1.0 };
    assert!(about(line).contains("length = -1"));
}
