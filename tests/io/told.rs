//! What a run tells and what a check warns of, as a user with nothing but scene files and the command line meets it.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;
use supercoil::io::vtk::read_vtp;
use supercoil::math::Vec3;

use crate::program::{folder, number, run, supercoil, table};

fn warnings(dir: &Path, scene: &str) -> String {
    let file = dir.join("scene.toml");
    std::fs::write(&file, scene).unwrap();
    let out = supercoil(&["check", file.to_str().unwrap()]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8_lossy(&out.stderr).into_owned()
}

const MINICIRCLE: &str = r#"
[[rods]]
name = "dna"
closed = true
shape = { kind = "circle" }
dna = { base_pairs = 336 }
elements = 24
fasten = 1
[[stages]]
ramp = { sigma = { to = -0.07 } }
steps = 8
[picture]
size = [320, 240]
camera = [1.0, 0.5, 0.3]
color_by = "curvature"
scale_bar = true
transparent = true
"#;

#[test]
fn a_run_leaves_a_table_that_explains_itself() {
    let dir = folder("minicircle");
    let (code, _, error) = run(&dir, MINICIRCLE);
    assert!(code == 2 && error.contains("fasten"), "{code} {error}");
    let (code, printed, error) = run(&dir, &MINICIRCLE.replace("fasten = 1\n", ""));
    assert_eq!(code, 0, "{error}");
    let out = dir.join("out");
    let (columns, rows) = table(&out.join("table.csv"));
    let (_, legend) = table(&out.join("table_columns.csv"));
    assert_eq!(legend.iter().map(|row| row["column"].clone()).collect::<Vec<_>>(), columns);
    assert!(legend.iter().any(|row| row["column"] == "total_energy" && row["unit"] == "pN nm"));
    let last = rows.last().unwrap();
    assert!((number(last, "sigma") + 0.07).abs() < 1e-12 && (number(last, "excess_link") + 0.07 * 32.0).abs() < 1e-12);
    assert!((number(last, "link") - number(last, "twist") - number(last, "writhe")).abs() < 1e-9);
    let energies = ["stretching", "shearing", "bending", "twisting", "contact"];
    let sum: f64 = energies.iter().map(|kind| number(last, &format!("{kind}_energy"))).sum();
    assert!((sum - number(last, "total_energy")).abs() < 1e-9 * sum);
    assert_eq!((last["knot"].as_str(), last["status"].as_str()), ("0_1", "converged"));
    // the snap is noted in the table, below the printed one, and drawn as a jump
    let snapped = rows.iter().find(|row| number(row, "energy_released") > 0.0).unwrap();
    assert!(snapped["notes"].starts_with("snap"), "{}", snapped["notes"]);
    assert!(printed.contains(&format!("* step {}: snap", snapped["step"])), "{printed}");
    let plot = supercoil(&["plot", out.to_str().unwrap(), "--x", "excess_link", "--y", "writhe,twist"]);
    assert!(plot.status.success(), "{}", String::from_utf8_lossy(&plot.stderr));
    let drawn = std::fs::read_to_string(out.join("writhe_twist.svg")).unwrap();
    assert!(drawn.contains("snap") && drawn.contains("excess_link, turns"));
    let slip = supercoil(&["plot", out.to_str().unwrap(), "--x", "excess_lnk", "--y", "writhe"]);
    assert!(String::from_utf8_lossy(&slip.stderr).contains("one of step, stage"));
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Wires as of examples/strand.toml: each line of contact between neighbours is one site, its pressure adds up to its
/// force, and wires laid alike bear one torque.
#[test]
fn lines_of_contact_have_their_pressure() {
    let dir = folder("strand");
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/strand.toml")).unwrap();
    let (code, _, error) = run(&dir, &text.replace("turns = 0.5", "turns = 0.25").replace("steps = 6", "steps = 3"));
    assert_eq!(code, 0, "{error}");
    for (name, column, unit) in [
        ("table", "total_energy", "N mm"),
        ("sites", "force", "N"),
        ("lines", "pressure", "N/mm"),
        ("final_state", "arc_length", "mm"),
        ("resultants", "tension", "N"),
        ("resultants", "torque", "N mm"),
    ] {
        let (columns, _) = table(&dir.join(format!("out/{name}.csv")));
        let (_, legend) = table(&dir.join(format!("out/{name}_columns.csv")));
        assert_eq!(legend.iter().map(|row| row["column"].clone()).collect::<Vec<_>>(), columns, "{name}");
        assert!(legend.iter().any(|row| row["column"] == column && row["unit"] == unit), "{name}: {legend:?}");
        assert!(legend.iter().all(|row| !row["meaning"].is_empty()), "{name}: {legend:?}");
    }
    let (_, sites) = table(&dir.join("out/sites.csv"));
    let (_, lines) = table(&dir.join("out/lines.csv"));
    let (_, rows) = table(&dir.join("out/table.csv"));
    let is_of = |site: &&BTreeMap<String, String>, a: &str, b: &str| {
        site["rod_a"] == a && site["rod_b"] == b && site["kind"] == "line"
    };
    let between = |a: &str, b: &str| sites.iter().filter(|site| is_of(site, a, b)).count();
    assert_eq!([between("w1", "w2"), between("w1", "w6"), between("w3", "w5")], [1, 1, 0]);
    let mut found = 0;
    for (index, site) in sites.iter().enumerate().filter(|(_, site)| site["kind"] == "line") {
        let own: Vec<_> = lines.iter().filter(|row| row["site"] == index.to_string()).collect();
        let sum: f64 = own.iter().map(|row| number(row, "pressure")).sum();
        let spacing = number(site, "length") / own.len() as f64;
        let force = number(site, "force");
        assert!((sum * spacing - force).abs() < 1e-6 * force, "{} {force}", sum * spacing);
        assert!((number(site, "pressure") * number(site, "length") - force).abs() < 1e-9 * force);
        assert!(own.windows(2).all(|pair| number(pair[0], "arc_a") < number(pair[1], "arc_a")));
        found += 1;
    }
    assert!(found >= 6, "{found} of {}", sites.len());
    let last = rows.last().unwrap();
    assert!((number(last, "w1_end_turned") - 0.25).abs() < 1e-12);
    let torques = ["w1", "w2", "w3", "w4", "w5", "w6"].map(|wire| number(last, &format!("{wire}_end_torque")));
    assert!(torques.iter().all(|torque| *torque > 0.0 && (torque / torques[0] - 1.0).abs() < 1e-3), "{torques:?}");
    std::fs::remove_dir_all(&dir).unwrap();
}

const TWO_WIRES: &str = r#"
units = { length = "mm", force = "N" }
loads = [{ rod = "a", at = "end", force = [0, 0, 2000] }, { rod = "b", at = "end", force = [0, 0, 2000] }]
[[rods]]
name = "a"
elements = 16
section = { young = 2e5, poisson = 0.3, circle = 1.5 }
shape = { kind = "line", start = [1.503, 0, 0], direction = [0, 0, 1], length = 120.0 }
[[rods]]
name = "b"
elements = 16
section = { young = 2e5, poisson = 0.3, circle = 1.5 }
shape = { kind = "line", start = [-1.503, 0, 0], direction = [0, 0, 1], length = 120.0 }
[[supports]]
rod = ["a", "b"]
at = "start"
position = true
rotation = true
[[supports]]
rod = ["a", "b"]
at = "end"
position = ["x", "y"]
rotation = true
[[stages]]
ramp = { load = 1.0 }
[[stages]]
ramp = { rotation = { rod = ["a", "b"], at = "end", axis = [0, 0, 1], through = [0, 0, 0], turns = 1.0 } }
steps = 4
[output]
picture = false
"#;

/// Largest deviation of a number from the mean of its neighbours, over the mean of all, where a line is away from its
/// ends.
fn sawtooth(along: &[f64]) -> f64 {
    let inner = &along[along.len() / 4..along.len() - along.len() / 4];
    let mean = inner.iter().sum::<f64>() / inner.len() as f64;
    inner.windows(3).map(|three| (three[1] - 0.5 * (three[0] + three[2])).abs() / mean).fold(0.0, f64::max)
}

/// The contact force per length that ParaView, pictures and the viewer show has the resultant of the forces on nodes,
/// and no sawtooth of the mesh: the forces on nodes have one.
#[test]
fn shown_pressure_has_the_resultant_and_no_sawtooth() {
    for elements in [16, 27] {
        let dir = folder("two_wires");
        let (code, _, error) = run(&dir, &TWO_WIRES.replace("elements = 16", &format!("elements = {elements}")));
        assert_eq!(code, 0, "{error}");
        let spacing = 120.0 / (3 * elements) as f64;
        for rod in read_vtp(&dir.join("out/step_0005.vtp")).unwrap() {
            let (on_nodes, shown) =
                (&rod.vectors["contact_force_on_node"], &rod.vectors["smoothed_contact_force_per_length"]);
            let last = shown.len() - 1;
            let share = |k: usize| if k == 0 || k == last { 0.5 * spacing } else { spacing };
            let of_shown: Vec3 = shown.iter().enumerate().map(|(k, force)| force * share(k)).sum();
            let of_nodes: Vec3 = on_nodes.iter().sum();
            let all: f64 = on_nodes.iter().map(|force| force.norm()).sum();
            assert!((of_shown - of_nodes).norm() < 1e-12 * all, "{of_shown} {of_nodes} of {all}");
            let raw: Vec<f64> = on_nodes.iter().enumerate().map(|(k, force)| force.norm() / share(k)).collect();
            let [raw, shown] = [raw, shown.iter().map(|force| force.norm()).collect()].map(|along| sawtooth(&along));
            assert!(shown < 0.02 && raw > 5.0 * shown, "{elements} elements: {shown} of {raw}");
        }
        std::fs::remove_dir_all(&dir).unwrap();
    }
}

const ARC: &str = r#"
[[rods]]
shape = { kind = "line", length = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.2 }
elements = 8
[[supports]]
at = "start"
position = true
rotation = true
[[stages]]
ramp = { natural = { curvature = [4.0, 0.0] } }
steps = 4
[output]
vtk = false
"#;

/// Symptom: a rod bent more tightly than its tube allows was "converged", exit code 0. Now it has a status of its own.
#[test]
fn tubes_inside_each_other_have_a_status() {
    let dir = folder("overlap");
    let (code, _, error) = run(&dir, ARC);
    assert_eq!(code, 0, "{error}");
    let (code, again, error) = run(&dir, &ARC.replace("[4.0, 0.0]", "[5.5, 0.0]"));
    assert_eq!(code, 4, "{again}{error}");
    assert!(
        again.contains("overlap after") && error.contains("as tightly as its contact radius allows"),
        "{again}{error}"
    );
    let summary = std::fs::read_to_string(dir.join("out/summary.json")).unwrap();
    assert!(summary.contains("\"converged\": false") && summary.contains("\"status\": \"overlap\""));
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn slips_are_warned_of() {
    let dir = folder("warnings");
    let ring = |keys: &str, to: f64| {
        format!(
            "[[rods]]\nclosed = true\nshape = {{ kind = \"circle\", length = 100.0 }}\n\
             section = {{ bending = 200.0, twisting = 300.0, stretching = 1e3, shearing = 1e3, contact_radius = 1.0 \
             }}\n\
             elements = 48\n{keys}\n[[stages]]\nramp = {{ excess_link = {{ to = {to:?} }} }}\nsteps = 30\n"
        )
    };
    assert_eq!(warnings(&dir, &ring("", -3.0)), "");
    let told = warnings(&dir, &ring("", -30.0));
    assert!(told.contains("-30 turns") || told.contains("30 turns on 48 elements, 4.8 nodes a turn"), "{told}");
    let wound = "natural = { curvature = [0.0, 0.0], twist = 2.0106192982974678 }"; // 32 turns
    let told = warnings(&dir, &ring(wound, -32.0));
    assert!(told.contains("is link meant?"), "{told}");
    assert!(told.contains("80° of natural twist from node to node"), "{told}");
    let told = warnings(&dir, &ring("", -3.0).replace("contact_radius = 1.0", "contact_radius = 1e-6"));
    assert!(told.contains("are both in one unit?"), "{told}");
    std::fs::remove_dir_all(&dir).unwrap();
}

/// The schema knows the keys of every example and of every scene to begin with, and the type of each value.
#[test]
fn the_schema_fits_the_examples() {
    let out = supercoil(&["help", "schema"]);
    let schema: Value = serde_json::from_slice(&out.stdout).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut count = 0;
    for folder in ["examples", "assets/scenes"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|ending| ending == "toml") {
                let scene: toml::Table = toml::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
                let scene = serde_json::to_value(scene).unwrap();
                fits(&schema, &schema, &scene).unwrap_or_else(|place| panic!("{}: {place}", path.display()));
                count += 1;
            }
        }
    }
    assert!(count >= 16, "{count}");
    let bad = serde_json::json!({ "rods": [{ "elements": "many" }] });
    assert_eq!(fits(&schema, &schema, &bad), Err(".rods[].elements".to_owned()));
    let unknown = serde_json::json!({ "stages": [{ "ramp": { "excess_lnk": {} } }] });
    assert!(fits(&schema, &schema, &unknown).is_err());
    let without_rods = serde_json::json!({ "planar": true });
    assert_eq!(fits(&schema, &schema, &without_rods), Err(".rods (missing)".to_owned()));
    let too_many = serde_json::json!({ "rods": [], "solver": { "threads": 1025 } });
    assert_eq!(fits(&schema, &schema, &too_many), Err(".solver.threads".to_owned()));
    let described = schema["$defs"]["RodText"]["properties"]["excess_link"]["description"].as_str().unwrap();
    assert!(described.contains("number, turns") && described.contains("closed rods"), "{described}");
}

/// As much of JSON Schema as the schema of scenes uses; the place that does not fit.
fn fits(root: &Value, schema: &Value, value: &Value) -> Result<(), String> {
    if let Some(name) = schema["$ref"].as_str() {
        return fits(root, &root["$defs"][name.rsplit('/').next().unwrap()], value);
    }
    if let Some(ways) = schema["anyOf"].as_array().or(schema["oneOf"].as_array()) {
        let tried: Vec<_> = ways.iter().map(|way| fits(root, way, value)).collect();
        return tried.iter().find(|way| way.is_ok()).unwrap_or(&tried[0]).clone();
    }
    let refused = |wrong: bool| if wrong { Err(String::new()) } else { Ok(()) };
    refused(schema["enum"].as_array().is_some_and(|words| !words.contains(value)))?;
    refused(schema.get("const").is_some_and(|word| word != value))?;
    let is = |kind: &str| match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        _ => value.is_number(),
    };
    refused(schema["type"].as_str().is_some_and(|kind| !is(kind)))?;
    if let Some(number) = value.as_f64() {
        let bound = |name: &str| schema[name].as_f64();
        refused(bound("minimum").is_some_and(|least| number < least))?;
        refused(bound("maximum").is_some_and(|most| number > most))?;
        refused(bound("exclusiveMinimum").is_some_and(|above| number <= above))?;
        refused(bound("exclusiveMaximum").is_some_and(|below| number >= below))?;
    }
    if let (Some(items), Some(list)) = (schema.get("items"), value.as_array()) {
        list.iter().try_for_each(|item| fits(root, items, item)).map_err(|place| format!("[]{place}"))?;
        refused(schema["minItems"].as_u64().is_some_and(|least| (list.len() as u64) < least))?;
        refused(schema["maxItems"].as_u64().is_some_and(|most| list.len() as u64 > most))?;
    }
    let Some(table) = value.as_object() else { return Ok(()) };
    for (key, value) in table {
        match schema["properties"].get(key) {
            Some(inner) => fits(root, inner, value).map_err(|place| format!(".{key}{place}"))?,
            None if schema["additionalProperties"] == false => return Err(format!(".{key} (unknown)")),
            None => {}
        }
    }
    let mut required = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
    required.find(|key| !table.contains_key(*key)).map_or(Ok(()), |key| Err(format!(".{key} (missing)")))
}

const ARCH: &str = r#"
planar = true
[[rods]]
shape = { kind = "arc", radius = 1.0, turns = 0.2, tangent = [0.8090169943749475, 0.5877852522924731, 0.0], towards = [
    0.5877852522924731, -0.8090169943749475, 0.0
] }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.0 }
natural = "as-shaped"
elements = 16
[[supports]]
at = "start"
position = true
[[supports]]
at = "end"
position = true
[[loads]]
at = 24
force = [0.0, -30.0, 0.0]
[[stages]]
ramp = { load = 1.0 }
follow = { max_step = 0.1, max_points = 60 }
[output]
vtk = false
picture = false
"#;

/// An arch that snaps under its load is followed through the limit point: the load falls while the crown goes on down.
#[test]
fn paths_are_followed_through_limit_points() {
    let dir = folder("arch");
    let (code, printed, error) = run(&dir, ARCH);
    assert_eq!(code, 0, "{error}");
    assert!(printed.contains("limit point: what is ramped turns back at"), "{printed}");
    let (_, rows) = table(&dir.join("out/table.csv"));
    let loads: Vec<f64> = rows.iter().map(|row| number(row, "load")).collect();
    let top = loads.iter().take_while(|load| **load < 1.0).copied().fold(0.0, f64::max);
    let falls = loads.windows(2).any(|pair| pair[1] < pair[0] - 1e-3);
    assert!(falls && top > 0.05, "{loads:?}");
    // both supports bear the load at every point of the path
    for row in &rows {
        let held = number(row, "start_force_y") + number(row, "end_force_y");
        assert!((held - 30.0 * number(row, "load")).abs() < 1e-6, "{held} {row:?}");
    }
    let (code, _, error) = run(&dir, &ARCH.replace("[output]", "[[stages]]\nramp = { load = 0.0 }\n[output]"));
    assert!(code == 2 && error.contains("only for the last stage"), "{error}");
    std::fs::remove_dir_all(&dir).unwrap();
}

const CHARGED: &str = r#"
units = { length = "nm", force = "pN" }
[[rods]]
name = "dna"
closed = true
shape = { kind = "circle" }
dna = { base_pairs = 300 }
elements = 40
[contact]
electrostatics = { salt_mM = 100 }
[[stages]]
ramp = { excess_link = { to = -1.4 } }
steps = 7
"#;

/// Symptom: Newton's iterations left the circle by themselves within step 6, and nothing told of a snap.
#[test]
fn a_snap_is_told_where_no_unstable_state_was_met() {
    let dir = folder("snap_within_a_step");
    let (code, printed, error) = run(&dir, CHARGED);
    assert_eq!(code, 0, "{error}");
    let (_, rows) = table(&dir.join("out/table.csv"));
    let snapped: Vec<_> = rows.iter().filter(|row| number(row, "energy_released") != 0.0).collect();
    assert_eq!(snapped.iter().map(|row| row["step"].as_str()).collect::<Vec<_>>(), ["6"]);
    assert!(printed.contains("* step 6: snap"), "{printed}");
    std::fs::remove_dir_all(&dir).unwrap();
}
