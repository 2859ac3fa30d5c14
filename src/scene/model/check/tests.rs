use super::*;
use crate::rod::{Natural, RodMesh, Section, Shape};
use crate::scene::{Contact, LineLoad, NodeLoad, Support};

const START: NodeRef = NodeRef { rod: 0, node: 0 };
const END: NodeRef = NodeRef { rod: 0, node: 8 };

fn section(radius: f64) -> Section {
    Section::isotropic(1.0, 1.5, 100.0, 100.0, radius)
}

fn beam() -> Rod {
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 };
    Rod::new("beam", &shape, RodMesh::open(4, 2), section(0.1), Natural::Straight).unwrap()
}

fn ring() -> Rod {
    let shape = Shape::Circle { length: 6.0, center: Vec3::zeros(), normal: Vec3::z() };
    Rod::new("ring", &shape, RodMesh::closed(4, 2), section(0.1), Natural::Straight).unwrap()
}

fn loaded(supports: Vec<Support>) -> Model {
    let load = NodeLoad { node: END, force: Vec3::y(), moment: Vec3::zeros() };
    Model { rods: vec![beam()], supports, loads: vec![load], ..Default::default() }
}

fn refusal(model: &Model) -> String {
    model.check().unwrap_err().to_string()
}

#[test]
fn mechanisms_are_found_and_named() {
    assert!(loaded(vec![Support::clamp(START)]).check().is_ok());
    let text = refusal(&loaded(vec![]));
    assert!(text.starts_with("rods.beam: loads[0] acts on it, and nothing holds it"), "{text}");
    let rail = |along: usize| {
        let mut position = [true; 3];
        position[along] = false;
        loaded(vec![Support { node: START, position, rotation: [true; 3] }])
    };
    assert!(refusal(&rail(1)).contains("along (0, 1, 0)"), "{}", refusal(&rail(1)));
    // forces do no work along the rail
    assert!(rail(2).check().is_ok());
    // what can only turn comes to hang
    assert!(loaded(vec![Support::pin(START)]).check().is_ok());
    assert!(loaded(vec![Support::pin(START), Support::pin(END)]).check().is_ok());
}

/// Moments that keep their axis drive a rod round for ever where it can turn about it, unless forces could hold them.
#[test]
fn moments_about_free_axes_are_refused() {
    let turned = |supports: Vec<Support>, moment: Vec3, force: Vec3| {
        let mut model = loaded(supports);
        model.loads[0] = NodeLoad { node: END, force, moment };
        model.check().map_err(|error| error.to_string())
    };
    let pins = || vec![Support::pin(START), Support::pin(END)];
    let about_x = turned(pins(), Vec3::x(), Vec3::zeros()).unwrap_err();
    assert!(about_x.contains("loads[0] turns it about the axis (1, 0, 0)"), "{about_x}");
    assert_eq!(turned(pins(), Vec3::y(), Vec3::zeros()), Ok(()), "pins hold it");
    let spin = Support { node: START, position: [false; 3], rotation: [true, false, false] };
    assert_eq!(turned([pins(), vec![spin]].concat(), Vec3::x(), Vec3::zeros()), Ok(()));
    let pin = || vec![Support::pin(START)];
    assert!(turned(pin(), Vec3::y() * 3.0, -Vec3::z()).is_err(), "more than the force's lever, the whole length");
    assert_eq!(turned(pin(), Vec3::y(), -Vec3::z()), Ok(()), "a pendulum held aside");
    assert!(turned(pin(), Vec3::z(), -Vec3::z()).is_err(), "a force along the axis holds nothing");
}

#[test]
fn a_planar_rod_needs_fewer_supports() {
    let roller = Support { node: END, position: [false, true, false], rotation: [false; 3] };
    let mut model = loaded(vec![Support::pin(START), roller]);
    model.planar = true;
    assert!(model.check().is_ok());
    model.supports.pop();
    assert!(model.check().is_ok());
    model.supports.pop();
    assert!(refusal(&model).contains("along (0, 1, 0)"), "{}", refusal(&model));
}

#[test]
fn rods_may_float_as_long_as_no_dead_force_drives_them() {
    let ring_alone = Model { rods: vec![ring()], ..Default::default() };
    assert!(ring_alone.check().is_ok());
    assert!(ring_alone.check_stages(&[stage(Ramp::ExcessLink { rod: 0, to: -3.0 })]).is_ok());
    let mut both = Model { rods: vec![ring(), beam()], ..Default::default() };
    assert!(both.check().is_ok());
    both.line_loads = vec![LineLoad::of_force(0, Vec3::z())];
    assert!(both.check().is_ok(), "the beam may catch the ring");
    both.contact = Contact::NONE;
    assert!(refusal(&both).contains("rods.ring: line_loads[0] acts on it"));
}

#[test]
fn references_and_numbers_are_checked() {
    assert_eq!(refusal(&Model::default()), "rods = 0: must be at least 1");
    let far = Support::clamp(NodeRef { rod: 0, node: 9 });
    assert!(refusal(&loaded(vec![far])).starts_with("supports[0].node = 9"));
    let nowhere = Support::clamp(NodeRef { rod: 1, node: 0 });
    assert!(refusal(&loaded(vec![nowhere])).starts_with("supports[0].rod = 1"));
    let mut model = loaded(vec![Support::clamp(START)]);
    model.loads[0].moment.y = f64::NAN;
    assert!(refusal(&model).starts_with("loads[0].moment = (0, NaN, 0)"));
    let mut model = loaded(vec![Support::clamp(START)]);
    model.contact.law = ContactLaw::AugmentedLagrangian { stiffness: 1.0, tol_penetration: 2.0 };
    assert!(refusal(&model).starts_with("contact.tol_penetration = 2"));
    model.contact.law = ContactLaw::Penalty { stiffness: 0.0 };
    assert!(refusal(&model).starts_with("contact.stiffness = 0"));
}

#[test]
fn planar_means_planar() {
    let planar = |rod: Rod| Model { rods: vec![rod], planar: true, ..Default::default() };
    assert!(planar(ring()).check().is_ok());
    let mut tilted = ring();
    tilted.positions[3].z = 0.1;
    assert!(refusal(&planar(tilted)).contains("planar = true, but z = 0.1 is not 0 at node 3"));
    let mut curved = beam();
    curved.natural = Natural::Uniform { kappa: [0.0, 0.5, 0.0] };
    assert!(refusal(&planar(curved)).contains("natural curvature"));
    let mut curved = beam();
    curved.natural = Natural::Uniform { kappa: [0.5, 0.0, 0.0] };
    assert!(planar(curved).check().is_ok());
    let mut model = loaded(vec![Support::clamp(START)]);
    model.planar = true;
    model.loads[0].force.z = 1.0;
    assert!(refusal(&model).starts_with("loads[0]: planar = true"));
}

fn stage(ramp: Ramp) -> Stage {
    Stage::new(vec![ramp], 3)
}

#[test]
fn ramps_are_checked() {
    let model = Model { rods: vec![beam()], supports: vec![Support::clamp(START)], ..Default::default() };
    let refusal = |ramp: Ramp| model.check_stages(&[stage(ramp)]).unwrap_err().to_string();
    assert!(refusal(Ramp::ExcessLink { rod: 0, to: 1.0 }).contains("\"beam\" is open"));
    assert!(refusal(Ramp::Load { to: 1.0 }).contains("no loads to ramp"));
    assert!(refusal(Ramp::Pressure { rod: 0, to: 1.0 }).contains("pressure"));
    let turn = |node: NodeRef, axis: Vec3, to: f64| Ramp::Rotation { node, axis, to };
    assert!(refusal(turn(END, Vec3::x(), 1.0)).contains("add one with rotation = true"));
    assert!(refusal(turn(START, Vec3::zeros(), 1.0)).contains("axis = (0, 0, 0)"));
    assert!(refusal(turn(START, Vec3::x(), f64::NAN)).contains("turns = NaN"));
    assert!(model.check_stages(&[stage(turn(START, Vec3::x(), 3.0))]).is_ok());
    assert!(refusal(Ramp::Displacement { node: END, to: Vec3::x() }).contains("add one with position = true"));
    let twice = Stage::new(vec![turn(START, Vec3::x(), 1.0), turn(START, Vec3::y(), 2.0)], 1);
    assert!(model.check_stages(&[twice]).unwrap_err().to_string().contains("ramped twice"));
    let idle = Stage::new(vec![], 0);
    assert_eq!(model.check_stages(&[idle]).unwrap_err().to_string(), "stages[0].steps = 0: must be at least 1");
    // symptom: 10^18 steps went on for ever; mechanism: past a hundredth of the way a step no longer changed the
    // fraction
    let endless = Stage::new(vec![turn(START, Vec3::x(), 3.0)], 1_000_000_001);
    let text = model.check_stages(&[endless]).unwrap_err().to_string();
    assert_eq!(text, "stages[0].steps = 1000000001: must be at most 1000000000");
}

/// What two pins leave free, a rotation about the line between them, costs nothing: one of them may be moved.
#[test]
fn pinned_rods_may_be_moved() {
    let supports = vec![Support::pin(START), Support::pin(END)];
    let model = Model { rods: vec![beam()], supports, ..Default::default() };
    assert!(model.check().is_ok());
    assert!(model.check_stages(&[stage(Ramp::Displacement { node: END, to: -Vec3::x() })]).is_ok());
}
