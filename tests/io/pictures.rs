//! Pictures: what must be true of any (sizes, background, determinism, cost), and a gallery to look at.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::time::Instant;
use supercoil::io::picture::{
    Palette, Picture, PlotSpec, Series, SeriesStyle, Spot, Stripe, Tube, TubePicture, View, colors_by_value,
    film_strip, plot_lines,
};
use supercoil::io::vtk::{PvdWriter, VtkRod, VtkStep, write_vtp};
use supercoil::math::Vec3;

fn torus_knot(n: usize) -> Vec<Vec3> {
    let at = |t: f64| {
        let rho = 2.0 + (3.0 * t).cos();
        Vec3::new(rho * (2.0 * t).cos(), rho * (2.0 * t).sin(), (3.0 * t).sin())
    };
    (0..n).map(|i| at(TAU * i as f64 / n as f64)).collect()
}

/// Material direction that turns `turns` times relative to the projected z axis.
fn direction(points: &[Vec3], turns: f64) -> Vec<Vec3> {
    let n = points.len();
    let at = |i: usize| {
        let tangent = (points[(i + 1) % n] - points[(i + n - 1) % n]).normalize();
        let reference = Vec3::new(0.13, 0.21, 0.97);
        let u = (reference - tangent * tangent.dot(&reference)).normalize();
        let (sin, cos) = (TAU * turns * i as f64 / n as f64).sin_cos();
        u * cos + tangent.cross(&u) * sin
    };
    (0..n).map(at).collect()
}

/// A plectoneme: two strands wound about the x axis, joined by round end loops. `wound` = 0 is a flat racetrack.
fn plectoneme(n: usize, turns: f64, wound: f64) -> Vec<Vec3> {
    let (half, radius) = (10.0, 0.5 + (1.0 - wound) * 2.0);
    let at = |i: usize| {
        let s = 4.0 * i as f64 / n as f64;
        let side = if s < 2.0 { 1.0 } else { -1.0 };
        let along = if s < 2.0 { s - 1.0 } else { 3.0 - s };
        // Radius opens towards the ends and closes at the tip.
        let to_tip = half * (1.0 - along.abs());
        let bulge = radius + 0.9 * (-(to_tip - 2.0).powi(2) / 1.5).exp() * wound;
        let rho = bulge * (1.0 - (1.0 - (to_tip / 2.0).min(1.0)).powi(2)).max(0.0).sqrt();
        let angle = TAU * turns * 0.5 * along * wound;
        Vec3::new(half * along, side * rho * angle.cos(), side * rho * angle.sin())
    };
    (0..n).map(at).collect()
}

fn knot_tube(n: usize, stripe: bool) -> Tube {
    let points = torus_knot(n);
    let values: Vec<f64> = (0..n).map(|i| (TAU * 3.0 * i as f64 / n as f64).sin()).collect();
    let stripe = stripe.then(|| Stripe::along(direction(&points, 6.0)));
    Tube { colors: colors_by_value(&values, Palette::Viridis, None), points, radii: vec![0.42], closed: true, stripe }
}

#[test]
fn a_tube_is_drawn_on_the_background_and_fits() {
    let picture = TubePicture { tubes: vec![knot_tube(60, true)], width: 200, height: 150, ..TubePicture::default() };
    let drawn = picture.render().unwrap();
    assert_eq!((drawn.width(), drawn.height(), drawn.pixels().len()), (200, 150, 200 * 150 * 3));
    let is_tube = |c: usize, r: usize| drawn.pixel(c, r) != [255, 255, 255];
    let covered = (0..150).flat_map(|r| (0..200).map(move |c| (c, r))).filter(|&(c, r)| is_tube(c, r)).count();
    assert!((4_000..20_000).contains(&covered), "{covered} pixels");
    let on_border =
        (0..200).any(|c| is_tube(c, 0) || is_tube(c, 149)) || (0..150).any(|r| is_tube(0, r) || is_tube(199, r));
    assert!(!on_border);
}

/// A line that leads out of the picture is there at its border, and the rod stays in its place.
#[test]
fn lines_are_thin_and_do_not_move_the_view() {
    let points: Vec<Vec3> = (0..20).map(|i| Vec3::x() * f64::from(i)).collect();
    let tube = Tube { points, radii: vec![1.0], closed: false, colors: vec![[0, 0, 255]], stripe: None };
    let view = View::Along { forward: -Vec3::z(), up: Vec3::y() };
    let alone = TubePicture { tubes: vec![tube], width: 300, height: 100, view, ..TubePicture::default() };
    let line = [Vec3::new(-1e3, -2.0, 0.0), Vec3::new(1e3, -2.0, 0.0)];
    let [without, with] = [&alone, &TubePicture { lines: vec![line], ..alone.clone() }].map(|p| p.render().unwrap());
    let changed = |column: usize| (0..100).filter(|&r| with.pixel(column, r) != without.pixel(column, r)).count();
    assert!([0, 150, 299].into_iter().all(|column| (1..=3).contains(&changed(column))), "{}", changed(150));
    let gone = TubePicture { lines: vec![[Vec3::zeros(), Vec3::repeat(f64::NAN)]], ..alone };
    assert!(gone.render().unwrap_err().to_string().contains("lines[0]"));
}

/// A curve along z lies along the longer side; its stripe shows, and a spot colours only what it touches.
#[test]
fn automatic_view_stripe_and_spot() {
    let points: Vec<Vec3> = (0..20).map(|i| Vec3::z() * f64::from(i)).collect();
    let stripe = Stripe {
        color: [255, 0, 0],
        ..Stripe::along((0..20).map(|i| Vec3::x() * 2.0 - Vec3::y() * f64::from(i) * 0.1).collect())
    };
    let tube = Tube { points, radii: vec![1.0], closed: false, colors: vec![[0, 0, 255]], stripe: Some(stripe) };
    let view = View::Along { forward: -Vec3::x(), up: Vec3::y() };
    let mut picture = TubePicture { tubes: vec![tube], width: 300, height: 100, view, ..TubePicture::default() };
    picture.spots = vec![Spot { center: Vec3::new(1.0, 0.0, 3.0), radius: 0.8, color: [0, 255, 0] }];
    let count = |p: &Picture, channel: usize| {
        p.pixels().chunks(3).filter(|c| (0..3).all(|k| k == channel || c[k] < c[channel] / 2)).count()
    };
    let drawn = picture.render().unwrap();
    let [red, green, blue] = [0, 1, 2].map(|k| count(&drawn, k));
    assert!(red > 200 && green > 20 && blue > 1000, "{red} {green} {blue}");
    picture.spots.clear();
    assert_eq!(count(&picture.render().unwrap(), 1), 0);
    let automatic = TubePicture { view: View::Auto, ..picture }.render().unwrap();
    let colored = |p: &Picture, c: usize, r: usize| p.pixel(c, r) != [255; 3];
    assert!((30..270).all(|c| colored(&automatic, c, 50)) && !(0..300).any(|c| colored(&automatic, c, 20)));
}

/// A tapered tube is as wide at each place as its radius there.
#[test]
fn tapered_tubes_are_drawn_tapered() {
    let radius = |x: f64| 0.2 + 0.08 * x;
    let points: Vec<Vec3> = (0..=10).map(|i| Vec3::x() * f64::from(i)).collect();
    let tube = Tube { radii: points.iter().map(|point| radius(point.x)).collect(), points, ..Tube::default() };
    let view = View::Along { forward: -Vec3::z(), up: Vec3::y() };
    let visible_width = Some(14.0);
    let picture = TubePicture {
        tubes: vec![tube.clone()],
        width: 700,
        height: 300,
        view,
        visible_width,
        ..TubePicture::default()
    };
    let drawn = picture.render().unwrap();
    let width = |column: usize| (0..300).filter(|&row| drawn.pixel(column, row) != [255; 3]).count() as f64;
    // 50 pixels a length; the picture's middle is that of the tube with its round ends, x from -0.2 to 11
    for column in (140..600).step_by(20) {
        let x = 5.4 + (column as f64 + 0.5 - 350.0) / 50.0;
        let exact = 100.0 * radius(x);
        assert!((width(column) - exact).abs() < 2.5, "{x}: {} {exact}", width(column));
    }
    let wrong = TubePicture { tubes: vec![Tube { radii: vec![0.1; 3], ..tube }], ..picture };
    assert!(wrong.render().unwrap_err().to_string().contains("tubes[0].radii"));
}

#[test]
fn same_bytes_for_any_number_of_threads() {
    let picture = TubePicture { tubes: vec![knot_tube(200, true)], width: 160, height: 120, ..TubePicture::default() };
    let run = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| picture.render().unwrap())
    };
    assert!(run(1) == run(4));
}

#[test]
fn extremes_are_drawn_or_refused() {
    let small = |tube: Tube| TubePicture { tubes: vec![tube], width: 40, height: 30, ..TubePicture::default() };
    let tube = |points: Vec<Vec3>| Tube { points, radii: vec![0.1], ..Tube::default() };
    for points in [vec![], vec![Vec3::x()], vec![Vec3::x(); 3], vec![Vec3::zeros(), Vec3::x() * 1e9]] {
        for closed in [false, true] {
            assert!(small(Tube { closed, ..tube(points.clone()) }).render().is_ok(), "{points:?}");
        }
    }
    for scale in [1e-9, 1e9] {
        let points = torus_knot(50).iter().map(|p| p * scale).collect();
        let drawn = small(Tube { points, radii: vec![0.4 * scale], closed: true, ..Tube::default() }).render().unwrap();
        assert!(drawn.pixel(20, 3) != [255; 3] || drawn.pixels().iter().any(|c| *c < 200), "{scale}");
    }
    let error = small(tube(vec![Vec3::zeros(), Vec3::repeat(f64::NAN)])).render().unwrap_err().to_string();
    assert!(error.starts_with("tubes[0].points[1] = (NaN"), "{error}");
    assert!(small(Tube { radii: vec![0.0], ..tube(torus_knot(5)) }).render().is_err());
    assert!(small(Tube { colors: vec![[0; 3]; 2], ..tube(torus_knot(5)) }).render().is_err());
    assert!(small(Tube { stripe: Some(Stripe::along(vec![])), ..tube(torus_knot(5)) }).render().is_err());
    assert!(TubePicture { width: 9000, height: 9000, ..TubePicture::default() }.render().is_err());
    assert!(TubePicture { width: 0, ..TubePicture::default() }.render().is_err());
    assert!(
        TubePicture { view: View::Along { forward: Vec3::z(), up: Vec3::z() }, ..TubePicture::default() }
            .render()
            .is_err()
    );
}

/// Two thousand segments at 1200×900; the bound is generous because test machines are shared.
#[test]
fn a_picture_takes_about_a_second() {
    let picture = TubePicture { tubes: vec![knot_tube(2000, true)], ..TubePicture::default() };
    let start = Instant::now();
    picture.render().unwrap();
    let taken = start.elapsed();
    println!("2000 segments at 1200x900: {taken:?}");
    assert!(taken.as_secs_f64() < 8.0);
}

/// Where the gallery goes: `SUPERCOIL_GALLERY`, or the system's temporary folder.
fn gallery() -> PathBuf {
    let folder = std::env::var_os("SUPERCOIL_GALLERY").map_or_else(std::env::temp_dir, PathBuf::from);
    std::fs::create_dir_all(&folder).expect("a folder that can be written");
    folder
}

fn plectoneme_picture(wound: f64, size: (usize, usize)) -> TubePicture {
    let points = plectoneme(600, 6.0, wound);
    let height: Vec<f64> = points.iter().map(|p| (p.y.hypot(p.z)).min(1.4)).collect();
    let tube = Tube {
        colors: colors_by_value(&height, Palette::Plasma, Some((0.0, 1.8))),
        stripe: Some(Stripe::along(direction(&points, 14.0))),
        points,
        radii: vec![0.46],
        closed: true,
    };
    TubePicture {
        tubes: vec![tube],
        width: size.0,
        height: size.1,
        visible_width: Some(22.0),
        ..TubePicture::default()
    }
}

/// Writes pictures to look at.
#[test]
#[ignore = "slow: draws a gallery"]
fn draw_gallery() {
    let folder = gallery();
    let save = |name: &str, picture: &TubePicture| -> Picture {
        let start = Instant::now();
        let drawn = picture.render().unwrap();
        println!("{name}: {:?}", start.elapsed());
        drawn.save_png(&folder.join(name)).unwrap();
        drawn
    };
    save("knot.png", &TubePicture { tubes: vec![knot_tube(120, true)], ..TubePicture::default() });
    save(
        "knot_dark.png",
        &TubePicture { tubes: vec![knot_tube(120, false)], background: [18, 20, 28], ..TubePicture::default() },
    );
    let mut contact = plectoneme_picture(1.0, (1200, 500));
    let radius = 0.62;
    contact.tubes[0].colors = vec![[70, 130, 190]];
    contact.spots =
        (-14..=14).map(|i| Spot { center: Vec3::x() * 0.5 * f64::from(i), radius, color: [255, 90, 30] }).collect();
    save("plectoneme.png", &contact);
    let frames: Vec<(Picture, String)> = (0..6)
        .map(|i| (plectoneme_picture(f64::from(i) / 5.0, (640, 300)).render().unwrap(), format!("ΔLk = {}", 2 * i)))
        .collect();
    film_strip(&frames, 2, [255; 3]).unwrap().save_png(&folder.join("strip.png")).unwrap();
    let points = plectoneme(200_000, 120.0, 1.0).iter().map(|p| Vec3::new(p.x * 12.0, p.y, p.z)).collect();
    let long = Tube { points, radii: vec![0.45], closed: true, ..Tube::default() };
    save("long.png", &TubePicture { tubes: vec![long], width: 2000, height: 200, ..TubePicture::default() });
    let mut text = Picture::filled(700, 220, [255; 3]);
    for (row, line) in [
        "!\"#$%&'()*+,-./0123456789:;<=>?@",
        "ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_`",
        "abcdefghijklmnopqrstuvwxyz{|}~",
        "Δσκ−±°· Wr = 4.18, ΔLk = −0.06",
    ]
    .iter()
    .enumerate()
    {
        text.write(line, [10, 10 + 50 * row], 22, [30, 30, 40]);
    }
    text.save_png(&folder.join("font.png")).unwrap();
    draw_plots(&folder);
    write_paraview(&folder);
}

fn draw_plots(folder: &Path) {
    let curve = |f: &dyn Fn(f64) -> f64, n: i32| (1..=n).map(|i| f64::from(i) * 0.1).map(|x| (x, f(x))).collect();
    let series = vec![
        Series { name: "writhe".into(), points: curve(&|x| x.sin() * 2.0, 60), style: SeriesStyle::Line },
        Series { name: "exact".into(), points: curve(&|x| x.cos(), 60), style: SeriesStyle::Dashed },
        Series { name: "measured".into(), points: curve(&|x| (x * 0.5).sin(), 60), style: SeriesStyle::LinePoints },
    ];
    let plot = PlotSpec {
        title: "Writhe of a twisted ring".into(),
        x_label: "excess link ΔLk (turns)".into(),
        y_label: "Wr (turns)".into(),
        series,
        ..PlotSpec::default()
    };
    plot_lines(&folder.join("plot.svg"), &plot).expect("a plot");
    let power = |p: i32| (3..10).map(|i| f64::powi(2.0, i)).map(|x| (x, 0.3 * x.powi(-p))).collect();
    let series =
        [2, 4, 6].map(|p| Series { name: format!("order {p}"), points: power(p), style: SeriesStyle::LinePoints });
    let plot = PlotSpec {
        title: "Error against elements".into(),
        x_label: "elements".into(),
        y_label: "tip error / L".into(),
        series: series.into(),
        log_x: true,
        log_y: true,
        ..PlotSpec::default()
    };
    plot_lines(&folder.join("plot_log.svg"), &plot).expect("a plot");
}

fn write_paraview(folder: &Path) {
    let mut collection = PvdWriter::new(folder.join("knot.pvd"));
    for step in 0..3 {
        let (ring, line) = (torus_knot(50 + step), vec![Vec3::zeros(), Vec3::x(), Vec3::y()]);
        let d1 = direction(&ring, 2.0);
        let scalars = vec![("pressure", (0..ring.len()).map(|i| i as f64).collect())];
        let rods = [
            VtkRod { points: &ring, closed: true, scalars, vectors: vec![("d1", d1)] },
            VtkRod { points: &line, ..VtkRod::default() },
        ];
        let file = folder.join(format!("knot_{step}.vtp"));
        let step_data = VtkStep { numbers: vec![("TimeValue", step as f64), ("excess link", 0.5)], units: vec![] };
        write_vtp(&file, &rods, &step_data).expect("a file");
        collection.push(step as f64, &[&file]).expect("a collection");
    }
}
