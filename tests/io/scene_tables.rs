//! Natural strains, stiffnesses and sequences of scene files.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::path::{Path, PathBuf};

use supercoil::rod::Natural;
use supercoil::scene::Scene;
use supercoil::solve::{Options, Solver, Status};

const RING: &str = r#"
[[rods]]
closed = true
shape = { kind = "circle", length = 4.0 }
section = { SECTION, contact_radius = 0.01 }
EXTRA
elements = 24
"#;
const PLAIN: &str = "bending = 2.0, twisting = 3.0, stretching = 900.0, shearing = 900.0";

/// A folder of its own with files in it.
fn folder(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("scene_tables_{name}"));
    std::fs::create_dir_all(&folder).unwrap();
    files.iter().for_each(|(name, text)| std::fs::write(folder.join(name), text).unwrap());
    folder
}

fn read(folder: &Path, section: &str, extra: &str) -> Result<Scene, String> {
    let text = RING.replace("SECTION", section).replace("EXTRA", extra);
    Scene::from_toml(&text, folder).map_err(|error| error.to_string())
}

#[test]
fn tables_mean_what_they_say() {
    let stiffness =
        "from,to,bending,twisting,stretching,shearing,kappa1_kappa3\n0,1,2,3,900,900,0.5\n1,4,4,3,900,900,0\n";
    let natural = "s,kappa1,kappa3\n0,0,0.5\n2,1,0.5\n4,0,0.5\n";
    let folder = folder("tables", &[("c.csv", stiffness), ("k.csv", natural)]);
    let scene = read(&folder, "table = \"c.csv\"", "natural = { table = \"k.csv\" }").unwrap();
    let rod = &scene.model.rods[0];
    // means along the rod, for scales
    assert_eq!((rod.section.bending, rod.section.twisting, rod.section.contact_radius), ([3.5; 2], 3.0, 0.01));
    let along = rod.stiffness.as_ref().unwrap();
    assert_eq!((along.at(0.5)[(3, 5)], along.at(2.0)[(5, 3)], along.at(2.0)[(4, 4)]), (0.5, 0.0, 4.0));
    let Natural::Varying(natural) = &rod.natural else { panic!("{:?}", rod.natural) };
    assert_eq!(natural.at(1.0).as_slice(), [0.0, 0.0, 1.0, 0.5, 0.0, 0.5]);
    let rows = "[[9e2,0,0,0,0,0],[0,9e2,0,0,0,0],[0,0,9e2,0,0,0],[0,0,0,2,0,0.5],[0,0,0,0,2,0],[0,0,0,0.5,0,3]]";
    let scene = read(&folder, &format!("stiffness = {rows}"), "").unwrap();
    assert_eq!(scene.model.rods[0].stiffness.as_ref().unwrap().at(3.0)[(3, 5)], 0.5);
}

#[test]
fn a_section_table_with_radii_tapers_the_rod() {
    let cone = "s,bending,twisting,stretching,shearing,contact_radius\n0,2,3,900,900,0.01\n4,2,3,900,900,0.03\n";
    let folder = folder("cone", &[("cone.csv", cone)]);
    let text = RING.replace("section = { SECTION, contact_radius = 0.01 }", "section = { table = \"cone.csv\" }");
    let scene = Scene::from_toml(&text.replace("EXTRA", ""), &folder).unwrap();
    let rod = &scene.model.rods[0];
    // 72 segments, each with the radius at its middle
    for (segment, radius) in [(0, 0.01 + 0.02 / 144.0), (35, 0.02 - 0.02 / 144.0), (71, 0.03 - 0.02 / 144.0)] {
        assert!((rod.contact_radius_of(segment) - radius).abs() < 1e-15, "{segment}");
    }
    let refused = read(&folder, "table = \"cone.csv\"", "").map(|_| ()).unwrap_err();
    assert!(refused.contains("section.contact_radius: the table has a column contact_radius"), "{refused}");
    let ramped =
        format!("{text}\n[[stages]]\nramp = {{ section = {{ contact_radius = 0.02 }} }}\n").replace("EXTRA", "");
    let refused = Scene::from_toml(&ramped, &folder).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("has a contact radius that varies along it"), "{refused}");
}

#[test]
fn bad_tables_are_refused_with_file_line_and_value() {
    let bad = "from,to,bending,twisting,stretching,shearing,kappa1_kappa3\n0,4,2,3,900,900,2.5\n";
    let short = "from,to,kappa1\n0,3.5,0.1\n";
    let gap = "from,to,kappa1\n0,1,0.1\n1.5,4,0.2\n";
    let tight = "from,to,kappa3\n0,2,0.1\n2,4,60\n";
    let folder = folder("bad", &[("c.csv", bad), ("short.csv", short), ("gap.csv", gap), ("tight.csv", tight)]);
    for (section, extra, parts) in [
        ("table = \"c.csv\"", "", &["c.csv: line 2: the stiffness: is not positive definite"][..]),
        (PLAIN, "natural = { table = \"short.csv\" }", &["natural: ends at s = 3.5, but the rod is 4 long"]),
        (PLAIN, "natural = { table = \"gap.csv\" }", &["gap.csv: line 3: from = 1.5: must be 1", "gap"]),
        (PLAIN, "natural = { table = \"none.csv\" }", &["none.csv", "No such file"]),
        (PLAIN, "natural = { table = \"tight.csv\" }", &["natural.kappa: turns by", "at s = 4", "use more elements"]),
        (PLAIN, "natural = { table = \"gap.csv\", twist = 1 }", &["remove curvature and twist"]),
        ("table = \"c.csv\", bending = 2.0", "", &["c.csv: line 2"]),
        ("stiffness = [[1]]", "", &["a list of 6 numbers"]),
        (
            PLAIN,
            "sequence = { letters = \"ACGT\", steps = \"ideal\" }",
            &["the sequence gives the stiffness", "section"],
        ),
        ("young = 1", "sequence = { letters = \"ACGT\", steps = \"ideal\" }", &["section"]),
    ] {
        let found = read(&folder, section, extra).map(|_| ()).unwrap_err();
        assert!(parts.iter().all(|part| found.contains(part)), "{section} {extra}: {found}");
    }
}

#[test]
fn a_ring_with_a_sequence_comes_to_rest() {
    let letters = "GCTTATAACGGATCCATTGCAGTCAGGTACCAATTCGCAAATTTGGCTTAACGATCGATCCGGTATACGT";
    let fasta = format!(">ring\n{letters}\n");
    let folder = folder("sequence", &[("ring.fasta", &fasta)]);
    let sequence = supercoil::dna::sequence::Sequence::parse(letters).unwrap();
    let steps = supercoil::dna::sequence::Steps::protein_dna_1998().unwrap();
    let helix = sequence.helix(&steps, true).unwrap();
    let link = helix.turns.round();
    let scene = format!(
        "[[rods]]\nclosed = true\nshape = {{ kind = \"circle\", length = {} }}\nsection = {{ contact_radius = 0.0 }}\n\
         sequence = {{ fasta = \"ring.fasta\", steps = \"protein-dna-1998\" }}\nlink = {link}\nelements = 70\n",
        helix.length
    );
    let model = Scene::from_toml(&scene, &folder).unwrap().model;
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let report = solver.find_equilibrium();
    assert_eq!(
        (report.status, report.num_unstable),
        (Status::Converged, 0),
        "{:?}",
        report.history.iter().map(Vec::len).collect::<Vec<_>>()
    );
    println!("{:?}", report.history.iter().map(Vec::len).collect::<Vec<_>>());
    let wrong = scene.replace("circle\", length = ", "circle\", length = 2");
    let refused = Scene::from_toml(&wrong, &folder).unwrap_err().to_string();
    assert!(refused.contains("natural: ends at s = "), "{refused}");
    for (from, to, reason) in [
        ("protein-dna-1998", "olson", "sequence.steps = \"olson\": must be \"ideal\", \"protein-dna-1998\" or a file"),
        ("fasta = \"ring.fasta\"", "letters = \"ACGU\"", "sequence, base 4 = \"U\": must be A, C, G or T"),
        ("fasta = \"ring.fasta\"", "letters = \"ACGT\", fasta = \"ring.fasta\"", "give either fasta = file or letters"),
    ] {
        let refused = Scene::from_toml(&scene.replace(from, to), &folder).unwrap_err().to_string();
        assert!(refused.contains(reason), "{refused}");
    }
}

/// The soft direction of bending turns with the helix, which may turn in the ring at nearly no cost: once the start
/// counted as unstable.
#[test]
fn a_helical_anisotropic_ring_comes_to_rest() {
    let set = ["stages.0.ramp.link.to=31.0", "stages.0.steps=2"].map(str::to_owned);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/helical_anisotropic_ring.toml");
    let scene = Scene::read_with(&path, &set).unwrap();
    let run = supercoil::solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
        assert_eq!(progress.report.num_unstable, 0);
        std::ops::ControlFlow::Continue(())
    });
    assert_eq!(run.unwrap().status, Status::Converged);
}

/// Measured points: the rise follows from their length where it is asked for; points too rough for the rod's thickness
/// are refused with a smoothing length that makes a rod of them, and does.
#[test]
fn measured_points_are_fitted_and_smoothed() {
    use std::fmt::Write as _;
    let (mut plain, mut rough) = ("x,y,z\n".to_owned(), "x,y,z\n".to_owned());
    for k in 0..120 {
        let angle = std::f64::consts::TAU * f64::from(k) / 120.0;
        // 400 base pairs of 0.36 nm; scatter of half a nanometre
        let radius = 400.0 * 0.36 / std::f64::consts::TAU;
        let off = 0.5 * (f64::from(k) * 2.3).sin();
        writeln!(plain, "{},{},0", radius * angle.cos(), radius * angle.sin()).unwrap();
        writeln!(rough, "{},{},{off}", (radius + off) * angle.cos(), (radius - off) * angle.sin()).unwrap();
    }
    let folder = folder("measured", &[("plain.csv", &plain), ("rough.csv", &rough)]);
    let scene = |shape: &str, dna: &str| {
        let text = format!("[[rods]]\nclosed = true\nshape = {{ {shape} }}\ndna = {{ {dna} }}\nelements = 96\n");
        Scene::from_toml(&text, &folder).map_err(|error| error.to_string())
    };
    let points = "kind = \"points\", file = \"plain.csv\"";
    let refused = scene(points, "base_pairs = 400").unwrap_err();
    assert!(refused.contains("agree within 1 %") && refused.contains("fit = \"rise\""), "{refused}");
    let fitted = scene(&format!("{points}, fit = \"rise\""), "base_pairs = 400").unwrap();
    assert!((fitted.model.rods[0].length / (400.0 * 0.36) - 1.0).abs() < 1e-3);
    let refused = scene(&format!("{points}, fit = \"rise\""), "base_pairs = 400, rise = 0.36").unwrap_err();
    assert!(refused.contains("shape.fit: takes the rise from the points"), "{refused}");
    let rough = "kind = \"points\", file = \"rough.csv\", fit = \"rise\"";
    let refused = scene(rough, "base_pairs = 400").unwrap_err();
    assert!(refused.contains("thicker than its own curvature"), "{refused}");
    let (_, rest) = refused.split_once("points with smooth = ").unwrap();
    let length = rest.split(' ').next().unwrap();
    assert!(scene(&format!("{rough}, smooth = {length}"), "base_pairs = 400").is_ok(), "{length}");
}

/// Knots by name and by braid word: the length asked for, closed rods only; the two curves of a link at one scale.
#[test]
fn knots_are_given_by_name_or_braid() {
    let read = |shape: &str| {
        let text = format!(
            "[[rods]]\nclosed = CLOSED\nshape = {{ kind = \"knot\", {shape} }}\n\
             section = {{ {PLAIN} contact_radius = 0.01 }}\nelements = 60\n"
        );
        let text = text.replace("CLOSED", if shape.contains("open") { "false" } else { "true" }).replace(", open", "");
        Scene::from_toml(&text.replace("900.0 ", "900.0, "), Path::new("")).map_err(|error| error.to_string())
    };
    for shape in
        ["name = \"7_4\"", "braid = [1, 1, 2, -1, 2, 2, 3, -2, 3]", "pd = [[1, 5, 2, 4], [3, 1, 4, 6], [5, 3, 6, 2]]"]
    {
        let rod = &read(&format!("{shape}, length = 100")).unwrap().model.rods[0];
        assert!((rod.length / 100.0 - 1.0).abs() < 1e-6, "{shape}: {}", rod.length);
    }
    let pair =
        [0, 1].map(|k| read(&format!("braid = [1, 1], component = {k}, distance = 2")).unwrap().model.rods.remove(0));
    assert!((pair[0].length / pair[1].length - 1.0).abs() < 1e-6, "{} {}", pair[0].length, pair[1].length);
    for (shape, reason) in [
        ("name = \"3_2\", length = 9", "shape.name = \"3_2\": must be a prime knot"),
        ("length = 9", "shape: a knot is given by its name, by a braid or by a PD code (pd), one"),
        ("pd = [[1, 5, 2, 4], [3, 1, 4, 6]], length = 9", "shape.pd: has the edge 2 at 1 places"),
        ("name = \"3_1\"", "shape.length: missing"),
        ("name = \"3_1\", length = 9, distance = 1", "shape.distance: follows from the length"),
        ("name = \"3_1\", length = 9, open", "shape: a knot is closed: set closed = true"),
        ("braid = [1, 1], length = 9", "shape.component: missing: these are 2 curves, a link"),
    ] {
        let refused = read(shape).map(|_| ()).unwrap_err();
        assert!(refused.contains(reason), "{shape}: {refused}");
    }
}
