//! Films of runs: glTF read back by another crate, the page's bytes, and what is left out of long ones.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use gltf::animation::{Interpolation, Property, util::ReadOutputs};
use gltf::mesh::Mode;
use gltf::{Gltf, Node, Primitive};
use supercoil::InputError;
use supercoil::io::run::run_scene;
use supercoil::io::view::{Film, FilmRod, Frame, FrameRod, GlbOptions, Quantity, of_run, write_page};
use supercoil::math::Vec3;
use supercoil::scene::{Obstacle, ObstaclePose, Scene};

/// A closed rod of `count` points on a circle of the given radius, its pressure rising along it.
fn ring(count: usize, radius: f64) -> FrameRod {
    let at = |i: usize| TAU * i as f64 / count as f64;
    FrameRod {
        points: (0..count).map(|i| radius * Vec3::new(at(i).cos(), at(i).sin(), 0.0)).collect(),
        directions: vec![Vec3::z(); count],
        pressure: (0..count).map(|i| i as f64).collect(),
        curvature: vec![1.0 / radius; count],
        twist_rate: vec![0.0; count],
        radii: vec![0.5],
        seam_turns: 0.0,
    }
}

fn film(count: usize, frames: usize) -> Film {
    let frame = |step: usize| Frame { step, rods: vec![ring(count, 10.0 + step as f64)], ..Frame::default() };
    let rods = vec![FilmRod { name: "ring".to_owned(), closed: true }];
    Film { title: "rings".to_owned(), rods, frames: (0..frames).map(frame).collect(), ..Film::default() }
}

fn read(film: &Film, color: Quantity) -> Gltf {
    // also validates
    Gltf::from_slice(&film.glb(&GlbOptions { color, ..GlbOptions::default() }).unwrap()).unwrap()
}

fn steps(file: &Gltf) -> Vec<Node<'_>> {
    let root = file.default_scene().unwrap().nodes().next().unwrap();
    root.children().collect()
}

fn primitive<'a>(node: &Node<'a>) -> Primitive<'a> {
    node.mesh().unwrap().primitives().next().unwrap()
}

#[test]
fn planes_are_grids_that_move_with_the_frames() {
    let mut film = film(40, 2);
    film.obstacles = vec![Obstacle::plane("table", Vec3::new(0.0, 0.0, -0.5), Vec3::z())];
    let at = |level: f64| ObstaclePose { level, ..ObstaclePose::default() };
    film.frames.iter_mut().zip([0.0, 0.25]).for_each(|(frame, height)| frame.placements = vec![at(height)]);
    let file = read(&film, Quantity::Strand);
    for (node, height) in steps(&file).iter().zip([-0.5, -0.25]) {
        let grid = node.mesh().unwrap().primitives().last().unwrap();
        let seen = grid.bounding_box();
        assert_eq!((grid.mode(), grid.material().name()), (Mode::Lines, Some("obstacles")));
        assert_eq!([seen.min[2], seen.max[2]], [height; 2]);
        assert!(seen.min[0] < -11.5 && seen.max[1] > 11.5, "beyond the rings: {seen:?}");
    }
    let page = film.page().unwrap();
    let image = |height: f64| format!("\"images\":[[[1.0,0.0,0.0,0.0],[0.0,1.0,0.0,0.0],[0.0,0.0,1.0,{height:?}]]]");
    assert!(page.contains("\"obstacle\":0") && page.contains(&image(0.0)) && page.contains(&image(0.25)));
    film.frames[0].placements.clear();
    assert!(film.page().unwrap_err().to_string().contains("frames[0].placements"));
}

/// Symptom: the page read a key that it had no more, and stayed empty.
#[test]
fn scripts_read_what_the_page_has() {
    let page = film(40, 2).page().unwrap();
    let scripts = ["film", "shaders", "stage", "panel", "main"].map(|name| {
        let path = format!("{}/assets/view/{name}.js", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(path).unwrap()
    });
    let keys = scripts.iter().flat_map(|script| script.split("film.").skip(1)).map(|rest| {
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        &rest[..end]
    });
    let missing: Vec<&str> = keys.filter(|key| !page.contains(&format!("\"{key}\":"))).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn each_frame_is_a_node_that_the_animation_shows_for_its_time() {
    let file = read(&film(40, 4), Quantity::Strand);
    let blob = file.blob.as_deref().unwrap();
    let nodes = steps(&file);
    let scales: Vec<f32> = nodes.iter().map(|node| node.transform().decomposed().2[0]).collect();
    assert_eq!((scales, nodes[3].name()), (vec![0.0, 0.0, 0.0, 1.0], Some("step 3")));
    let animation = file.animations().next().unwrap();
    assert_eq!((file.animations().count(), animation.channels().count()), (1, 4));
    for (k, channel) in animation.channels().enumerate() {
        assert_eq!(channel.sampler().interpolation(), Interpolation::Step);
        assert_eq!((channel.target().node().index(), channel.target().property()), (nodes[k].index(), Property::Scale));
        let reader = channel.reader(|_| Some(blob));
        assert_eq!(reader.read_inputs().unwrap().collect::<Vec<_>>(), [0.0, 0.25, 0.5, 0.75, 1.0]);
        let Some(ReadOutputs::Scales(scales)) = reader.read_outputs() else { panic!("no scales") };
        let shown: Vec<usize> = scales.enumerate().filter(|(_, scale)| *scale == [1.0; 3]).map(|(i, _)| i).collect();
        // the last also at the end
        assert_eq!(shown, if k < 3 { vec![k] } else { vec![3, 4] });
    }
    // a single frame needs no animation
    assert_eq!(read(&film(40, 1), Quantity::Strand).animations().count(), 0);
}

#[test]
fn tubes_lie_about_their_rods_and_have_the_colours_of_the_quantity() {
    let file = read(&film(40, 2), Quantity::Pressure);
    let blob = file.blob.as_deref().unwrap();
    let root = file.default_scene().unwrap().nodes().next().unwrap();
    // two metres for the last frame's box
    let scale = root.transform().decomposed().2[0];
    assert!((scale * 11.0 * 2.0_f32.sqrt() - 1.0).abs() < 1e-5, "{scale}");
    let tube = primitive(&steps(&file)[1]);
    assert_eq!((tube.mode(), tube.material().name()), (Mode::Triangles, Some("ring")));
    let reader = tube.reader(|_| Some(blob));
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let normals: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
    for (p, n) in positions.iter().zip(&normals) {
        // distance from a ring of radius 11 about the origin, and the way there
        let around = (p[0].hypot(p[1]) - 11.0).hypot(p[2]);
        assert!((around - 0.5).abs() < 1e-3, "{p:?}");
        let outwards = n[2] * p[2] + (n[0] * p[0] + n[1] * p[1]) / p[0].hypot(p[1]) * (p[0].hypot(p[1]) - 11.0);
        assert!((outwards / 0.5 - 1.0).abs() < 2e-3, "{p:?} {n:?}");
    }
    let colors: Vec<[f32; 3]> = reader.read_colors(0).unwrap().into_rgb_f32().collect();
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert!(colors.len() == positions.len() && indices.iter().all(|&i| (i as usize) < positions.len()));
    // from viridis' dark violet at the first node to its yellow at the last, in linear light; the stripe is nearly
    // white
    let near = |a: &[f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 0.01);
    let (violet, yellow) = ([0.0578, 0.0003, 0.0887], [0.9823, 0.7991, 0.0185]);
    assert!(colors.iter().any(|c| near(c, violet)) && colors.iter().any(|c| near(c, yellow)));
    let white = colors.iter().filter(|c| c.iter().all(|&x| x > 0.85)).count();
    assert!(white > 0 && white * 6 < colors.len(), "{white} of {}", colors.len());
}

#[test]
fn rods_too_long_for_tubes_are_lines() {
    let file = read(&film(80_000, 1), Quantity::Curvature);
    let line = primitive(&steps(&file)[0]);
    assert_eq!(line.mode(), Mode::LineLoop);
    let positions = line.reader(|_| file.blob.as_deref()).read_positions().unwrap();
    assert_eq!(positions.len(), 80_000);
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let mut wrong = film(10, 1);
    wrong.frames[0].rods[0].twist_rate.pop();
    assert_eq!(wrong.page().unwrap_err().to_string(), "frames[0].rods[0].twist_rate = 9: must be one a point");
    let mut wrong = film(10, 1);
    wrong.frames[0].rods[0].points[3].y = f64::NAN;
    assert_eq!(
        wrong.glb(&GlbOptions::default()).unwrap_err().to_string(),
        "frames[0].rods[0].points = NaN: must be a finite number"
    );
    let still = GlbOptions { seconds_per_frame: 0.0, ..GlbOptions::default() };
    assert!(matches!(film(10, 1).glb(&still), Err(InputError::Value { .. })));
    assert_eq!(Quantity::from_name("twist_rate").unwrap(), Quantity::TwistRate);
    assert!(Quantity::from_name("heat").unwrap_err().to_string().contains("curvature"));
    // nothing to be shown is no failure
    assert!(
        Film::default().page().is_ok()
            && Gltf::from_slice(&Film::default().glb(&GlbOptions::default()).unwrap()).is_ok()
    );
}

const SCENE: &str = r#"
    title = "a < ring </script> & more"
    [[rods]]
    name = "ring"
    closed = true
    shape = { kind = "circle", length = 6.0 }
    section = { bending = 1.0, twisting = 1.5, stretching = 1e4, shearing = 1e4, contact_radius = 0.1 }
    elements = 12
    [[stages]]
    ramp = { excess_link = { to = 0.6 } }
    steps = 15
    [output]
    picture = false
"#;

fn run(name: &str, scene: &str) -> PathBuf {
    let dir = std::env::temp_dir().join(format!("supercoil_view_{}_{name}", std::process::id()));
    std::fs::remove_dir_all(&dir).ok();
    let scene = Scene::from_toml(scene, Path::new("")).unwrap();
    let _ = run_scene(scene, &dir, &mut |_| ControlFlow::Continue(())).unwrap();
    dir
}

/// The text of an element of the page.
fn text<'a>(page: &'a str, id: &str) -> &'a str {
    page.split_once(&format!("id=\"{id}\">")).unwrap().1.split_once("</script>").unwrap().0
}

/// A run leaves a page; made again from the run's files, or by another run of the scene, it has the same bytes.
#[test]
fn the_page_of_a_run_is_the_same_every_time() {
    let (dir, again) = (run("first", SCENE), run("second", SCENE));
    let page = |dir: &Path| std::fs::read_to_string(dir.join("view.html")).unwrap();
    let first = page(&dir);
    assert!(first == page(&again), "another run, other bytes");
    std::fs::remove_file(dir.join("view.html")).unwrap();
    assert_eq!(write_page(&dir).unwrap(), dir.join("view.html"));
    assert!(first == page(&dir), "made again, other bytes");
    assert!(first.contains("<title>a &lt; ring &lt;/script&gt; &amp; more</title>"));
    let head: serde_json::Value = serde_json::from_str(text(&first, "film")).unwrap();
    assert_eq!(
        (head["title"].as_str(), head["frames"].as_array().unwrap().len()),
        (Some("a < ring </script> & more"), 16)
    );
    assert_eq!((&head["rows"][15][0], &head["rows"][15][1]), (&15.0.into(), &0.6.into()));
    // 36 nodes of 36 bytes in base64
    assert_eq!(text(&first, "frame15").len(), 36 * 36 / 3 * 4);
    // nothing is fetched from elsewhere
    assert!(
        !["http:", "https:", "//cdn", "import("]
            .iter()
            .any(|word| first.replace("http://www.w3.org/2000/svg", "").contains(word))
    );
    for dir in [dir, again] {
        std::fs::remove_dir_all(dir).unwrap();
    }
}

#[test]
fn what_is_too_much_is_left_out_and_told() {
    let dir = run("thinned", SCENE);
    let whole = of_run(&dir, usize::MAX).unwrap();
    assert!(
        whole.note.starts_with("At the end") && whole.frames.len() == 16 && whole.frames[3].rods[0].points.len() == 36
    );
    // every other step, as 12 are kept in any case, then nodes
    let few = of_run(&dir, 36 * 15).unwrap();
    assert_eq!(few.frames.iter().map(|frame| frame.step).collect::<Vec<_>>(), [1, 3, 5, 7, 9, 11, 13, 15]);
    assert!(few.note.ends_with(" 8 of 16 steps are shown."), "{}", few.note);
    let fewer = of_run(&dir, 8 * 20).unwrap();
    assert!(fewer.note.contains(" 8 of 16 steps are shown. ") && fewer.note.contains("of 36 nodes are shown"));
    let told: f64 = fewer.note.split("within ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    for (frame, all) in fewer.frames.iter().zip(&few.frames) {
        let (kept, all) = (&frame.rods[0].points, &all.rods[0].points);
        assert!(kept.len() <= 20 && kept.len() > 4 && frame.rods[0].directions[0] == Vec3::zeros());
        for point in all {
            let near = |a: &Vec3, b: &Vec3| {
                let along = ((point - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                (point - a.lerp(b, along)).norm()
            };
            let closing = [kept[kept.len() - 1], kept[0]];
            let pairs = kept.windows(2).chain([closing.as_slice()]);
            let distance = pairs.map(|pair| near(&pair[0], &pair[1])).fold(f64::INFINITY, f64::min);
            assert!(distance <= 1.01 * told, "{distance} {told}");
        }
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn folders_without_what_is_shown_are_refused() {
    let dir = run("bare", &SCENE.replace("picture = false", "picture = false\nvtk = false"));
    assert!(!dir.join("view.html").exists());
    let error = write_page(&dir).unwrap_err().to_string();
    assert!(error.contains("holds no step_….vtp files"), "{error}");
    std::fs::remove_dir_all(&dir).unwrap();
    assert!(matches!(write_page(&dir), Err(InputError::File { .. })));
    let dir = run("off", &SCENE.replace("picture = false", "picture = false\nview = false"));
    assert!(!dir.join("view.html").exists() && dir.join("step_0015.vtp").exists());
    std::fs::remove_dir_all(&dir).unwrap();
}
