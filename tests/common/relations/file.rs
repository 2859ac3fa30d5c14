//! Any problem as a scene file: nodes and frames as a state, varying sections and natural strains as tables.

use std::fmt::Write;
use std::path::Path;
use std::sync::{Arc, Mutex};

use supercoil::InputError;
use supercoil::io::csv::{RodState, write_state};
use supercoil::math::Vec3;
use supercoil::rod::{Along, Averaged, Natural, Rod, RodNumber};
use supercoil::scene::{
    ContactLaw, JointKind, NodeRef, ObstacleNumber, Ramp, Scene, Skeleton, Stage, Support, SupportChange, Units,
};

use super::motion::Problem;

/// Writes the problem and reads it back.
pub fn write(problem: &Problem, path: &Path) -> Result<Problem, InputError> {
    let refuse = |error: std::io::Error| InputError::File { path: path.to_owned(), reason: error.to_string() };
    let state = |rod: &Rod| RodState {
        arc_lengths: (0..rod.num_nodes()).map(|node| rod.spacing() * node as f64).collect(),
        positions: rod.positions.clone(),
        frames: rod.frames.clone(),
    };
    let states: Vec<RodState> = problem.model.rods.iter().map(state).collect();
    let folder = path.parent().unwrap_or(path);
    std::fs::create_dir_all(folder).map_err(refuse)?;
    write_state(&path.with_extension("csv"), &states, &Units::default())?;
    let mut tables = Vec::new();
    std::fs::write(path, text(problem, path, &mut tables)).map_err(refuse)?;
    for (file, table) in tables {
        std::fs::write(folder.join(file), table).map_err(refuse)?;
    }
    Scene::read(path).map(|scene| Problem { model: scene.model, stages: scene.stages })
}

fn list(v: &Vec3) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}

fn axes(held: [bool; 3]) -> String {
    let names = ["x", "y", "z"].iter().zip(held).filter(|(_, held)| *held).map(|(name, _)| format!("{name:?}"));
    match held {
        [true, true, true] => "true".to_owned(),
        [false, false, false] => "false".to_owned(),
        _ => format!("[{}]", names.collect::<Vec<_>>().join(", ")),
    }
}

/// Arc lengths and values of a table, and whether it has points; pieces begin with their ends.
fn rows<T: Averaged>(along: &Along<T>) -> Vec<(f64, T)> {
    let found = Arc::new(Mutex::new(Vec::new()));
    let keep = Arc::clone(&found);
    let _ = along.map(1.0, move |arc, value| {
        keep.lock().unwrap_or_else(|poisoned| panic!("{poisoned}")).push((arc, value));
        value
    });
    let list = found.lock().unwrap_or_else(|poisoned| panic!("{poisoned}"));
    list.clone()
}

/// Lines `s` or `from,to` with the numbers of each value.
fn table<T: Averaged>(along: &Along<T>, head: &str, numbers: impl Fn(&T, f64) -> Vec<f64>) -> String {
    let rows = rows(along);
    let points = rows[0].0 == 0.0;
    let mut out = format!("{}{head}\n", if points { "s," } else { "from,to," });
    let mut from = 0.0;
    for (arc, value) in &rows {
        let start = if points { String::new() } else { format!("{from:?},") };
        let cells: Vec<String> = numbers(value, *arc).iter().map(|it| format!("{it:?}")).collect();
        let _ = writeln!(out, "{start}{arc:?},{}", cells.join(","));
        from = *arc;
    }
    out
}

const STRAINS: [&str; 6] = ["gamma1", "gamma2", "gamma3", "kappa1", "kappa2", "kappa3"];
const STIFFNESSES: [&str; 6] = ["shearing1", "shearing2", "stretching", "bending1", "bending2", "twisting"];

fn text(problem: &Problem, path: &Path, tables: &mut Vec<(String, String)>) -> String {
    let model = &problem.model;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut out = format!("planar = {}\n\n[contact]\n", model.planar);
    match model.contact.law {
        ContactLaw::None => out.push_str("law = \"none\"\n"),
        ContactLaw::Penalty { stiffness } => {
            let _ = writeln!(out, "law = \"penalty\"\nstiffness = {stiffness:?}");
        }
        ContactLaw::AugmentedLagrangian { stiffness, tol_penetration } => {
            let _ = writeln!(out, "stiffness = {stiffness:?}\ntol_penetration = {tol_penetration:?}");
        }
        ContactLaw::ByMesh { tol_penetration, .. } => {
            let _ = writeln!(out, "tol_penetration = {tol_penetration:?}");
        }
    }
    if let Some(charges) = model.electrostatics {
        let (strength, debye) = (charges.strength, charges.debye_length);
        let _ = writeln!(out, "electrostatics = {{ strength = {strength:?}, debye_length = {debye:?} }}");
    }
    for (index, rod) in model.rods.iter().enumerate() {
        out.push_str(&rod_text(rod, &stem, index, tables));
    }
    let name = |rod: usize| format!("rod = {:?}", model.rods[rod].name);
    let at = |node: NodeRef| format!("{}, at = {}", name(node.rod), node.node);
    for it in &model.supports {
        let _ = writeln!(out, "\n[[supports]]\n{}", held(it, &name).join("\n"));
    }
    for it in &model.joints {
        let _ = writeln!(out, "\n[[joints]]\na = {{ {} }}\nb = {{ {} }}", at(it.a), at(it.b));
        let _ = writeln!(out, "kind = {:?}", it.kind.name());
        if let JointKind::Hinge { axis } = &it.kind {
            let _ = writeln!(out, "axis = {}", list(axis));
        }
    }
    for it in &model.loads {
        let (force, moment) = (list(&it.force), list(&it.moment));
        let (rod, node) = (name(it.node.rod), it.node.node);
        let _ = writeln!(out, "\n[[loads]]\n{rod}\nat = {node}\nforce = {force}\nmoment = {moment}");
    }
    for it in &model.line_loads {
        let (force, moment) = (list(&it.force), list(&it.moment));
        let _ = writeln!(out, "\n[[line_loads]]\n{}\nforce = {force}\nmoment = {moment}", name(it.rod));
    }
    for it in &model.obstacles {
        let (name, size) = (&it.name, format!("radius = {:?}\nside = \"{:?}\"", it.radius, it.side).to_lowercase());
        let _ = match &it.skeleton {
            Skeleton::Plane { point, normal } => {
                let (point, normal) = (list(point), list(normal));
                writeln!(out, "\n[[planes]]\nname = {name:?}\npoint = {point}\nnormal = {normal}")
            }
            Skeleton::Point { point } => {
                let point = list(point);
                writeln!(out, "\n[[obstacles]]\nname = {name:?}\nshape = \"sphere\"\npoint = {point}\n{size}")
            }
            Skeleton::Line { point, axis } => {
                let place = format!("point = {}\naxis = {}", list(point), list(axis));
                writeln!(out, "\n[[obstacles]]\nname = {name:?}\nshape = \"cylinder\"\n{place}\n{size}")
            }
            Skeleton::Piece { .. } => unreachable!("no relation has bodies that nodes carry"),
        };
    }
    for stage in &problem.stages {
        let _ = writeln!(out, "\n[[stages]]\nsteps = {}", stage.steps);
        out.push_str(&ramps(problem, stage, &name, &at));
    }
    out
}

/// The keys of a support.
fn held(support: &Support, name: &dyn Fn(usize) -> String) -> [String; 4] {
    let (position, rotation) = (axes(support.position), axes(support.rotation));
    let at = format!("at = {}", support.node.node);
    [name(support.node.rod), at, format!("position = {position}"), format!("rotation = {rotation}")]
}

fn rod_text(rod: &Rod, stem: &str, index: usize, tables: &mut Vec<(String, String)>) -> String {
    let section = &rod.section;
    let mut out = format!("\n[[rods]]\nname = {:?}\nclosed = {}\norder = {}\n", rod.name, rod.closed, rod.order);
    let _ = writeln!(
        out,
        "elements = {}\nshape = {{ kind = \"state\", file = \"{stem}.csv\", rod = {index} }}",
        rod.num_elements
    );
    if rod.closed {
        let _ = writeln!(out, "excess_link = {:?}", rod.start_excess_link);
    }
    let radius = section.contact_radius;
    if let Some(stiffness) = &rod.stiffness {
        let pairs: Vec<(usize, usize)> = (0..6).flat_map(|i| (i + 1..6).map(move |j| (i, j))).collect();
        let couplings = pairs.iter().map(|&(i, j)| format!("{}_{}", STRAINS[i], STRAINS[j])).collect::<Vec<_>>();
        let radii = rod.contact_radii.clone();
        let head = format!("{},{}", STIFFNESSES.join(","), couplings.join(","));
        let head = head + if radii.is_some() { ",contact_radius" } else { "" };
        let numbers = |c: &supercoil::rod::Stiffness, arc: f64| {
            let couplings = pairs.iter().map(|&(i, j)| c[(i, j)]);
            let radius = radii.as_ref().map(|radii| radii.at(arc));
            (0..6).map(|k| c[(k, k)]).chain(couplings).chain(radius).collect()
        };
        if rows(stiffness).len() == 1 {
            let matrix = rows(stiffness)[0].1;
            let lines: Vec<Vec<f64>> = (0..6).map(|i| (0..6).map(|j| matrix[(i, j)]).collect()).collect();
            let _ = writeln!(out, "section = {{ stiffness = {lines:?}, contact_radius = {radius:?} }}");
        } else {
            let file = format!("{stem}_section_{index}.csv");
            tables.push((file.clone(), table(stiffness, &head, numbers)));
            let radius = if radii.is_some() { String::new() } else { format!(", contact_radius = {radius:?}") };
            let _ = writeln!(out, "section = {{ table = \"{file}\"{radius} }}");
        }
    } else {
        let _ = writeln!(
            out,
            "section = {{ bending = {:?}, twisting = {:?}, stretching = {:?}, shearing = {:?}, contact_radius = \
             {radius:?} }}",
            section.bending, section.twisting, section.stretching, section.shearing
        );
    }
    match &rod.natural {
        Natural::Straight => {}
        Natural::Uniform { kappa: [k1, k2, k3] } => {
            let _ = writeln!(out, "natural = {{ curvature = [{k1:?}, {k2:?}], twist = {k3:?} }}");
        }
        Natural::AsShaped => out.push_str("natural = \"as-shaped\"\n"),
        Natural::Varying(along) => {
            let file = format!("{stem}_natural_{index}.csv");
            tables.push((file.clone(), table(along, &STRAINS.join(","), |it, _| it.iter().copied().collect())));
            let _ = writeln!(out, "natural = {{ table = \"{file}\" }}");
        }
    }
    out
}

fn ramps(problem: &Problem, stage: &Stage, name: &dyn Fn(usize) -> String, at: &dyn Fn(NodeRef) -> String) -> String {
    let ramps = &stage.ramps;
    let mut lists: Vec<(&str, Vec<String>)> = Vec::new();
    let mut single = Vec::new();
    let mut add = |key: &'static str, entry: String| match lists.iter_mut().find(|(known, _)| *known == key) {
        Some((_, entries)) => entries.push(entry),
        None => lists.push((key, vec![entry])),
    };
    for ramp in ramps {
        match ramp {
            Ramp::ExcessLink { rod, to } => add("excess_link", format!("{}, to = {to:?}", name(*rod))),
            Ramp::Rotation { node, axis, to } => {
                add("rotation", format!("{}, axis = {}, turns = {to:?}", at(*node), list(axis)));
            }
            Ramp::RotationAbout { node, axis, through, to } => {
                let (axis, through) = (list(axis), list(through));
                add("rotation", format!("{}, axis = {axis}, through = {through}, turns = {to:?}", at(*node)));
            }
            Ramp::Displacement { node, to } => add("displacement", format!("{}, to = {}", at(*node), list(to))),
            Ramp::Pose { node, pose } => {
                let position = pose.position.map(|p| format!(", position = {}", list(&p))).unwrap_or_default();
                let frame = pose.frame.map(|q| format!(", quaternion = [{:?}, {:?}, {:?}, {:?}]", q.w, q.i, q.j, q.k));
                add("pose", format!("{}{position}{}", at(*node), frame.unwrap_or_default()));
            }
            Ramp::Load { to } => single.push(format!("load = {to:?}")),
            Ramp::Obstacle { obstacle, which, to } => {
                let obstacle = &problem.model.obstacles[*obstacle];
                match which {
                    ObstacleNumber::Level if obstacle.is_plane() => {
                        add("plane", format!("name = {:?}, to = {to:?}", obstacle.name));
                    }
                    ObstacleNumber::Level => add("obstacle", format!("name = {:?}, radius = {to:?}", obstacle.name)),
                    _ => panic!("no relation moves an obstacle so"),
                }
            }
            Ramp::Pressure { rod, to } => add("pressure", format!("{}, to = {to:?}", name(*rod))),
            Ramp::Number { rod, which: RodNumber::Length, to } => add("length", format!("{}, to = {to:?}", name(*rod))),
            Ramp::Number { .. } => {}
        }
    }
    for (rod, it) in problem.model.rods.iter().enumerate() {
        let to = |wanted: RodNumber| {
            ramps.iter().find_map(|ramp| match ramp {
                Ramp::Number { rod: of, which, to } if (*of, *which) == (rod, wanted) => Some(*to),
                _ => None,
            })
        };
        let pair = |key: &str, [a, b]: [RodNumber; 2]| {
            let given = [to(a), to(b)];
            let value = |k: usize, which: RodNumber| given[k].unwrap_or_else(|| it.number(which));
            given.iter().any(Option::is_some).then(|| format!("{key} = [{:?}, {:?}]", value(0, a), value(1, b)))
        };
        let one = |key: &str, which: RodNumber| to(which).map(|to| format!("{key} = {to:?}"));
        let section = [
            one("contact_radius", RodNumber::ContactRadius),
            pair("bending", [RodNumber::Bending1, RodNumber::Bending2]),
            one("twisting", RodNumber::Twisting),
            one("stretching", RodNumber::Stretching),
            pair("shearing", [RodNumber::Shearing1, RodNumber::Shearing2]),
        ];
        let natural =
            [pair("curvature", [RodNumber::Curvature1, RodNumber::Curvature2]), one("twist", RodNumber::Twist)];
        for (key, keys) in [("section", section.to_vec()), ("natural", natural.to_vec())] {
            let given: Vec<String> = keys.into_iter().flatten().collect();
            if !given.is_empty() {
                add(key, format!("{}, {}", name(rod), given.join(", ")));
            }
        }
    }
    let of_list = |(key, entries): (&str, Vec<String>)| {
        let entries: Vec<String> = entries.iter().map(|entry| format!("{{ {entry} }}")).collect();
        format!("{key} = [{}]", entries.join(", "))
    };
    single.extend(lists.into_iter().map(of_list));
    let mut out = format!("ramp = {{ {} }}\n", single.join(", "));
    let (mut hold, mut release) = (Vec::new(), Vec::new());
    for change in &stage.supports {
        let entries = if matches!(change, SupportChange::Hold(_)) { &mut hold } else { &mut release };
        entries.push(format!("{{ {} }}", held(change.support(), name).join(", ")));
    }
    for (key, entries) in [("hold", hold), ("release", release)] {
        if !entries.is_empty() {
            let _ = writeln!(out, "{key} = [{}]", entries.join(", "));
        }
    }
    out
}
