//! Several rods: names, lists and joints.

use super::*;

/// Where the last node of the last rod comes to rest at the end of the first stage.
fn tip(scene: Scene) -> Vec3 {
    let mut solver = Solver::new(scene.model, Options::default()).unwrap();
    let report = solver.step_through(&scene.stages[0]).unwrap();
    assert_eq!(report.status, Status::Converged);
    let engine = solver.engine();
    engine.positions(engine.model().rods.len() - 1).last().copied().unwrap()
}

#[test]
fn joined_halves_bend_like_the_whole() {
    let scene = read(HALVES).unwrap();
    let (near, far) = (NodeRef { rod: 0, node: 12 }, NodeRef { rod: 1, node: 0 });
    assert_eq!(scene.model.joints, [Joint::rigid(near, far)]);
    let without = HALVES.split("[[joints]]").next().unwrap();
    let loads = HALVES.split("[[loads]]").nth(1).unwrap();
    let loose = format!("{without}[[loads]]{loads}");
    assert!(read(&loose).unwrap_err().to_string().contains("rods.far: loads[0] acts on it"));
    let clamp = &loose[loose.find("[[supports]]").unwrap()..loose.find("[[loads]]").unwrap()];
    let whole = format!(
        "contact = {{ law = \"none\" }}\n[[rods]]\nshape = {{ kind = \"line\", length = 2.0 }}\n\
         section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4 }}\nelements = 8\n\
         {clamp}[[loads]]{loads}"
    );
    let whole = read(&whole.replace("rod = \"near\"", "").replace("rod = \"far\"", "")).unwrap();
    assert_eq!(whole.model.rods[0].name, "rod");
    let (halves, whole) = (tip(scene), tip(whole));
    assert!(whole.z < -0.9, "bent: {whole}");
    assert!((halves - whole).norm() < 1e-11, "{halves} {whole}");
    // their tubes overlap at the joint, and contact is left out there
    let thick = HALVES.replace("1e4 }", "1e4, contact_radius = 0.05 }").replace("contact = { law = \"none\" }", "");
    let thick = tip(read(&thick).unwrap());
    assert!((thick - whole).norm() < 1e-11, "{thick} {whole}");
}

#[test]
fn joints_that_cannot_be_are_refused() {
    refused(
        HALVES,
        "b = { rod = \"far\"",
        "b = { rod = \"fur\"",
        &["joints[0].b.rod = \"fur\": must be one of \"near\""],
    );
    refused(HALVES, "a = { rod = \"near\", ", "a = { ", &["joints[0].a.rod: missing: one of \"near\", \"far\""]);
    refused(HALVES, "b = { rod = \"far\", at = \"start\" }", "", &["missing field `b`", "line 18"]);
    refused(HALVES, "at = \"start\" }", "at = 13 }", &["joints[0].b.at = 13", "the index of a node"]);
    refused(HALVES, "at = \"start\" }", "at = 1 }", &["joints[0]: joins nodes that are 0.08", "they must coincide"]);
    refused(HALVES, "rod = \"far\", at = \"start\" }", "rod = \"near\", at = \"end\" }", &["joins a node to itself"]);
    let charged = ["joints[0]: joins two charged rods", "contact_radius of 0"];
    let thick = HALVES.replace("1e4 }", "1e4, contact_radius = 0.01 }");
    let charges = "contact = { electrostatics = { strength = 1.0, debye_length = 0.01 } }";
    refused(&thick, "contact = { law = \"none\" }", charges, &charged);
    let moved = "displacement = { rod = \"far\", at = \"start\", to = [0, 0, 1] }, load =";
    refused(HALVES, "load =", moved, &["is displaced in a direction that no support fixes"]);
}

#[test]
fn rods_are_named_where_there_are_several() {
    let nameless = HALVES.replace("name = \"far\"", "");
    let message = read(&nameless).unwrap_err().to_string();
    assert!(message.starts_with("rods[1].name: missing: where there are several rods, each needs a name"), "{message}");
    refused(HALVES, "name = \"far\"", "name = \"near\"", &["rods[1].name = \"near\": must be a name that no other"]);
    let only = read(&BEAM.replace("name = \"beam\"", "")).unwrap();
    assert_eq!(only.model.rods[0].name, "rod");
}

/// A list of rods stands for as many tables; turned about an axis through a point, nodes are carried round together.
#[test]
fn lists_of_rods_stand_for_each() {
    let both = "rod = [\"near\", \"far\"]\nat = \"end\"\nposition = true\nrotation = true";
    let text = HALVES.replacen("[[joints]]", &format!("[[supports]]\n{both}\n[[joints]]"), 1);
    let nodes = |scene: &Scene| scene.model.supports.iter().map(|s| (s.node.rod, s.node.node)).collect::<Vec<_>>();
    assert_eq!(nodes(&read(&text).unwrap()), [(0, 0), (0, 12), (1, 12)]);
    refused(&text, "\"near\", \"far\"", "\"near\", \"fur\"", &["supports[1].rod = \"fur\": must be one of"]);
    refused(&text, "\"near\", \"far\"", "\"far\", \"far\"", &["supports[1].rod = \"far\": must be named once"]);
    refused(&text, "\"near\", \"far\"", "", &["invalid length 0", "the name of a rod or a list of names"]);
    refused(&text, "[\"near\", \"far\"]", "3", &["the name of a rod or a list of names"]);
    let turn = "rotation = { rod = \"far\", at = \"end\", axis = [1, 0, 0], through = [0, 1, 0], turns = 2.0 }";
    let turned = text.replace("ramp = { load = 1.0 }", &format!("ramp = {{ load = 1.0, {turn} }}"));
    let node = NodeRef { rod: 1, node: 12 };
    let about = Ramp::RotationAbout { node, axis: Vec3::x(), through: Vec3::y(), to: 2.0 };
    assert_eq!(read(&turned).unwrap().stages[0].ramps, [about, Ramp::Load { to: 1.0 }]);
    refused(&turned, "[0, 1, 0], turns", "[0, nan, 0], turns", &["stages[0].ramp.rotation.through = (0, NaN, 0)"]);
    refused(&turned, "turns = 2.0", "turns = 2e9", &["stages[0].ramp.rotation.turns = 2000000000: must be at most"]);
}

#[test]
fn joints_are_rigid_pins_or_hinges() {
    let kinds = |more: &str| {
        read(&HALVES.replacen("[[joints]]", &format!("[[joints]]\n{more}"), 1)).map(|scene| scene.model.joints[0].kind)
    };
    assert_eq!(kinds("").unwrap(), JointKind::Rigid);
    assert_eq!(kinds("kind = \"rigid\"").unwrap(), JointKind::Rigid);
    assert_eq!(
        kinds("kind = \"hinge\"\naxis = [0, 2, 0]").unwrap(),
        JointKind::Hinge { axis: Vec3::new(0.0, 2.0, 0.0) }
    );
    for (more, parts) in [
        ("kind = \"hinge\"", &["joints[0].axis: is missing", "needs an axis"][..]),
        ("kind = \"pin\"\naxis = [0, 1, 0]", &["joints[0].axis: is of hinges only"]),
        ("axis = [0, 1, 0]", &["joints[0].axis: is of hinges only"]),
        ("kind = \"hinge\"\naxis = [0, 0, 0]", &["joints[0].axis = (0, 0, 0)", "finite and not zero"]),
        ("kind = \"hinge\"\naxis = [0, nan, 0]", &["joints[0].axis = (0, NaN, 0)", "finite and not zero"]),
        ("kind = \"hinge\"\naxis = [0, 1]", &["a list of 3 numbers"]),
        ("kind = \"ball\"", &["unknown variant `ball`", "`rigid`, `pin`, `hinge`"]),
    ] {
        let message = kinds(more).unwrap_err().to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{more}: {message}");
    }
    // what a pin lets go is held by nothing: a moment about it would turn the rod for ever
    let pinned = HALVES.replacen("[[joints]]", "[[joints]]\nkind = \"pin\"", 1);
    assert!(read(&pinned).is_ok());
    let message = read(&pinned.replacen("force =", "moment = [0, 10, 0]\nforce =", 1)).unwrap_err().to_string();
    assert!(message.contains("rods.far: loads[0] turns it about the axis (0, 1, 0)"), "{message}");
    // supports at a hinge hold all rotations or none
    let partly = "[[supports]]\nrod = \"far\"\nat = \"start\"\nrotation = [\"x\", \"y\"]\n[[joints]]\n\
        kind = \"hinge\"\naxis = [0, 0, 1]";
    let message = read(&HALVES.replacen("[[joints]]", partly, 1)).unwrap_err().to_string();
    assert!(message.contains("joints[0]: rod \"") && message.contains("hold 2 of three rotations"), "{message}");
}

/// A load on a list of rods acts on each, at a node or along it.
#[test]
fn loads_of_a_list_act_on_each_rod() {
    let more = "line_loads = [{ rod = [\"near\", \"far\"], force = [0, 0, -1] }]\n";
    let text = HALVES.replacen("[[rods]]", &format!("{more}[[rods]]"), 1).replacen(
        "[[loads]]\nrod = \"far\"",
        "[[loads]]\nrod = [\"far\", \"near\"]",
        1,
    );
    let model = read(&text).unwrap().model;
    assert_eq!(model.loads.iter().map(|load| (load.node.rod, load.node.node)).collect::<Vec<_>>(), [(1, 12), (0, 12)]);
    assert_eq!(model.loads[0].force, model.loads[1].force);
    assert_eq!(model.line_loads, [0, 1].map(|rod| LineLoad::of_force(rod, -Vec3::z())));
    refused(&text, "[\"far\", \"near\"]", "[\"far\", \"far\"]", &["loads[0].rod = \"far\": must be named once"]);
    refused(&text, "[\"near\", \"far\"]", "[\"near\", \"fur\"]", &["line_loads[0].rod = \"fur\": must be one of"]);
}
