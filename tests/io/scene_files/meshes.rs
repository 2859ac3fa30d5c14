//! Meshes and laws that a fidelity chooses.

use super::*;

/// One word sets what is left open; what is given wins. (Meshes: three, eight, sixteen elements a turn, 1 + 3 turns
/// here; nodes within 2, 0.7, 0.25 of the contact distance of 5, on 114.24.)
#[test]
fn a_fidelity_sets_what_is_left_open() {
    let scene = |fidelity: &str, from: &str, to: &str| {
        let open = RING.replace("elements = 12", "").replace("tol_penetration = 1e-8", "").replace(from, to);
        read(&format!("fidelity = \"{fidelity}\"\n{open}")).unwrap()
    };
    for (word, fidelity, elements, law, tol) in [
        ("draft", Fidelity::Draft, 12, (10.0, 1e-2), 1e-4),
        ("balanced", Fidelity::Balanced, 32, (10.0, 1e-4), 1e-6),
        ("reference", Fidelity::Reference, 64, (1000.0, 1e-8), 1e-8),
    ] {
        let open = scene(word, "", "");
        assert_eq!(open.fidelity, Some(fidelity));
        let rod = &open.model.rods[0];
        assert_eq!((rod.order, rod.num_elements), (3, elements));
        let (least, tol_penetration) = law;
        assert_eq!(open.model.contact.law, ContactLaw::ByMesh { least, tol_penetration });
        let hard = scene(word, "[contact]", "[contact]\nstiffness = 300.0");
        let law = ContactLaw::AugmentedLagrangian { stiffness: 300.0, tol_penetration };
        assert_eq!(hard.model.contact.law, law);
        assert_eq!(open.solver.tol_increment, Some(tol));
        // ten times as long at the same thickness: the contact distance decides
        let long = scene(word, "length = 114.24", "length = 1142.4");
        assert_eq!(long.model.rods[0].num_elements, [39, 109, 305][fidelity as usize]);
        let quadratic = scene(word, "[contact]", "order = 2\n[contact]");
        assert_eq!(quadratic.model.rods[0].num_nodes(), 3 * elements, "as many nodes");
        let given = scene(
            word,
            "[contact]\nlaw = \"augmented-lagrangian\"",
            "elements = 17\n[solver]\ntol_increment = 1e-5\n[contact]\nlaw = \"penalty\"\nstiffness = 3.0",
        );
        assert_eq!(given.model.rods[0].num_elements, 17);
        assert_eq!(given.model.contact.law, ContactLaw::Penalty { stiffness: 3.0 });
        assert_eq!(given.solver.tol_increment, Some(1e-5));
        let off = scene(word, "law = \"augmented-lagrangian\"", "law = \"none\"");
        assert_eq!((off.model.contact.law, off.model.rods[0].num_elements), (ContactLaw::None, elements));
    }
    refused(
        RING,
        "title = \"ring\"",
        "fidelity = \"fine\"",
        &["fidelity", "`fine`", "`draft`, `balanced`, `reference`"],
    );
}

/// What a rod will go through is read from shapes, natural strains, moved supports and loads.
#[test]
fn meshes_foresee_what_a_scene_asks_for() {
    let elements = |shape: &str, rest: &str| {
        let closed = ["circle", "knot", "plectoneme", "closed"].iter().any(|word| shape.contains(word));
        let text = format!(
            "fidelity = \"balanced\"\n[contact]\nlaw = \"none\"\n[[rods]]\nname = \"a\"\nclosed = {closed}\n\
             shape = {{ {shape} }}\n\
             section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }}\n\
             {rest}"
        );
        read(&text).unwrap().model.rods[0].num_elements
    };
    let clamp = "[[supports]]\nat = \"start\"\nposition = true\nrotation = true\n";
    let clamps = format!("{clamp}[[supports]]\nat = \"end\"\nposition = true\nrotation = true\n");
    let line = "kind = \"line\", length = 6.283185307179586";
    assert_eq!(elements(line, ""), 8);
    assert_eq!(elements("kind = \"helix\", radius = 1.0, pitch = 1.0, turns = 5.0", ""), 40);
    assert_eq!(elements("kind = \"circle\", length = 1.0", "excess_link = -2.0"), 24);
    assert_eq!(elements(line, "natural = { curvature = [3.0, 0.0], twist = 4.0 }"), 40);
    let turned = "[[stages]]\nramp = { rotation = { at = \"end\", axis = [1, 0, 0], turns = -7.0 } }\nsteps = 1";
    assert_eq!(elements(line, &format!("{clamps}{turned}")), 56);
    let moved = "[[stages]]\nramp = { rotation = { at = \"end\", axis = [1, 0, 0], turns = 2.0 }, displacement = { at \
        = \"end\", to = [-1, 0, 0] } }\nsteps = 1";
    assert_eq!(elements(line, &format!("{clamps}{moved}")), 24);
    for (load, turns) in [("force = [0, 0, -4.0]", 2.0 * 1.5f64.sqrt()), ("moment = [0, 3.0, 0]", 4.5)] {
        let loaded = format!("{clamp}[[loads]]\nat = \"end\"\n{load}\n[[stages]]\nramp = {{ load = 1.5 }}\nsteps = 1");
        assert_eq!(elements(line, &loaded), (8.0 * turns).ceil() as usize, "{load}");
    }
    let line_load =
        format!("{clamp}[[line_loads]]\nforce = [0, 0, -13.5]\n[[stages]]\nramp = {{ load = 2.0 }}\nsteps = 1");
    assert_eq!(elements(line, &line_load), 24);
    // measured: a trefoil turns between 2 and 5 times, and a curve through points as they say
    let knot = elements("kind = \"torus_knot\", length = 1.0, windings = [2, 3]", "");
    assert!((16..=40).contains(&knot), "{knot}");
    let plectoneme = elements("kind = \"plectoneme\", length = 1.0, distance = 0.01", "excess_link = 4.0");
    assert!((40..=64).contains(&plectoneme), "{plectoneme}");
}

/// A load bends the rods that are joined to the one it acts on, too.
#[test]
fn meshes_foresee_loads_on_joined_rods() {
    let open = |text: &str| format!("fidelity = \"balanced\"\n{}", text.replace("elements = 4", ""));
    let elements =
        |text: &str| read(&open(text)).unwrap().model.rods.iter().map(|rod| rod.num_elements).collect::<Vec<_>>();
    let heavy = HALVES.replace("[0, 0.2, -1]", "[0, 0, -400]");
    let of = elements(&heavy);
    assert!(of[0] == of[1] && of[0] > elements(HALVES)[0], "{of:?}");
}
