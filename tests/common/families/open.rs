//! Open rods: clamped, moved, pulled and turned, curled.

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, UnitVector3};
use supercoil::math::Vec3;

use super::Random;
use super::draft::{Draft, Mesh, list, short};
use super::material::Material;

const ONLY: &str = "\"rod\"";
/// Most turns of a rod whose length is given as 1.
const MOST_TURNS: f64 = 20.0;
/// M L/B at which a clamped rod that is twisted without tension buckles (Greenhill).
const GREENHILL: f64 = 8.99;

fn line(direction: &Vec3, length: f64) -> String {
    format!("kind = \"line\", direction = {}, length = {:?}", list(direction), short(length))
}

fn rotation(at: &str, axis: &Vec3, turns: f64) -> String {
    format!("rotation = {{ at = \"{at}\", axis = {}, turns = {:?} }}", list(axis), short(turns))
}

fn displacement(at: &str, to: &Vec3) -> String {
    format!("displacement = {{ at = \"{at}\", to = {} }}", list(to))
}

/// Steps of a stage that turns an end: so many a turn, at least four, at most a hundred.
fn steps(random: &mut Random, turns: f64) -> usize {
    (turns.abs() * random.log_between(1.0, 12.0)).ceil().clamp(4.0, 100.0) as usize
}

/// Along x, or anywhere.
fn some_direction(random: &mut Random) -> Vec3 {
    if random.chance(0.5) { Vec3::x() } else { random.direction().map(short) }
}

/// Clamped at both ends, turned and brought together: at once or one after the other.
pub fn clamped(draft: &mut Draft, random: &mut Random) {
    let radius = 0.5 * random.log_between(0.005, 0.04);
    let material = Material::isotropic(random, radius);
    turned_and_shortened(draft, random, &material, &[]);
}

/// The same with unlike bending stiffnesses; some are bent by nature.
pub fn anisotropic(draft: &mut Draft, random: &mut Random) {
    let radius = 0.5 * random.log_between(0.005, 0.04);
    let material = Material::anisotropic(random, radius);
    let roll = format!("roll = {:?}", short(random.between(0.0, 0.5)));
    let curvature = [random.between(-3.0, 3.0), random.between(-3.0, 3.0)].map(short);
    let natural = format!("natural = {{ curvature = {curvature:?}, twist = 0.0 }}");
    let bent = random.chance(0.3);
    let more: &[&str] = if bent { &[&roll, &natural] } else { &[&roll] };
    turned_and_shortened(draft, random, &material, more);
}

fn turned_and_shortened(draft: &mut Draft, random: &mut Random, material: &Material, more: &[&str]) {
    let axis = some_direction(random);
    let by = random.between(0.1, 0.65);
    // as a link per diameter of length: what is gained by shortening may be wound up
    let link = random.between(0.1, 1.0) * (0.02 + 0.12 * by);
    let turns = random.sign() * (link / material.diameter()).min(MOST_TURNS);
    draft.mesh(Mesh::random(random));
    draft.rod("rod", (&line(&axis, 1.0), 1.0), material, more);
    draft.clamp(ONLY, "\"start\"");
    draft.clamp(ONLY, "\"end\"");
    let shorter = displacement("end", &(axis.normalize() * -by));
    let turned = rotation("end", &axis, turns);
    let (for_way, for_turns) = (4 + random.below(20) as usize, steps(random, turns));
    match random.below(3) {
        0 => draft.stage(&format!("{shorter}, {turned}"), for_way.max(for_turns)),
        1 => {
            draft.stage(&shorter, for_way);
            draft.stage(&turned, for_turns);
        }
        _ => {
            draft.stage(&turned, for_turns);
            draft.stage(&shorter, for_way);
        }
    }
}

/// Distance of a segment from the origin.
fn distance(from: &Vec3, to: &Vec3) -> f64 {
    let way = to - from;
    let t = (-from.dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
    (from + way * t).norm()
}

/// Both ends moved and turned anyhow, one of them twisted on the way.
pub fn paths(draft: &mut Draft, random: &mut Random) {
    let radius = 0.5 * random.log_between(0.006, 0.03);
    let material = Material::isotropic(random, radius);
    draft.mesh(Mesh::random(random));
    let mut between = Vec3::x();
    // the tangent at the end
    let mut tangent = Vec3::x();
    if random.chance(0.5) {
        draft.rod("rod", (&line(&Vec3::x(), 1.0), 1.0), &material, &[]);
    } else {
        let turns = short(random.between(0.1, 0.6));
        let bend = 1.0 / (TAU * turns);
        let shape = format!(
            "kind = \"arc\", radius = {bend:?}, turns = {turns:?}, start = [0, 0, 0], tangent = [1, 0, 0], towards = \
             [0, 1, 0]"
        );
        draft.rod("rod", (&shape, 1.0), &material, &[]);
        let angle = TAU * turns;
        between = Vec3::new(angle.sin(), 1.0 - angle.cos(), 0.0) * bend;
        tangent = Vec3::new(angle.cos(), angle.sin(), 0.0);
    }
    draft.clamp(ONLY, "\"start\"");
    draft.clamp(ONLY, "\"end\"");
    let (from, mut turned) = (between, [0.0; 2]);
    let mut place = Vec3::zeros();
    let legs = 2 + random.below(3);
    let twisted = random.below(legs);
    for leg in 0..legs {
        let next = loop {
            let next = random.direction() * random.between(0.15, 0.8);
            if distance(&between, &next) > 0.12 {
                break next;
            }
        };
        between = next;
        place += random.direction() * random.between(0.0, 0.2);
        let mut ramp = format!(
            "displacement = [{{ at = \"start\", to = {} }}, {{ at = \"end\", to = {} }}]",
            list(&place),
            list(&(place + between - from))
        );
        let way = 6 + random.below(15) as usize;
        if leg == twisted {
            let turns = random.sign() * random.between(0.3, 1.0) * 0.05 / material.diameter();
            turned[1] += turns;
            draft.stage(&ramp, way);
            let steps = steps(random, turns);
            draft.stage(&rotation("end", &tangent, turned[1]), steps);
        } else {
            let axes = [random.direction(), random.direction()];
            let angles = [random.between(-0.2, 0.2), random.between(-0.2, 0.2)];
            (0..2).for_each(|k| turned[k] += angles[k]);
            tangent = UnitQuaternion::from_axis_angle(&UnitVector3::new_normalize(axes[1]), TAU * angles[1]) * tangent;
            let turn = |k: usize, at: &str| {
                format!("{{ at = \"{at}\", axis = {}, turns = {:?} }}", list(&axes[k]), short(turned[k]))
            };
            ramp += &format!(", rotation = [{}, {}]", turn(0, "start"), turn(1, "end"));
            draft.stage(&ramp, way);
        }
    }
}

/// Angle of the strands of a plectoneme to its axis under tension, its end free to turn: F R²/B = sin⁴α (½ + 1/cos 2α).
fn angle_under(tension: f64) -> f64 {
    let (mut low, mut high) = (0.0f64, 0.25 * PI);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let there = middle.sin().powi(4) * (0.5 + 1.0 / (2.0 * middle).cos());
        *(if there < tension { &mut low } else { &mut high }) = middle;
    }
    low
}

/// Turns for a rod pulled by a force, one end turned: some short of the snap, others up to where 85 % of the rod are in
/// the plectoneme. Where the loop at its end would be as long as the rod, fewer than buckle it.
fn turns_under(random: &mut Random, force: f64, length: f64, material: &Material) -> f64 {
    let (bending, twisting, radius) = (material.bending[0], material.twisting, material.radius);
    let buckling = ((2.0 * (bending * force).sqrt()).powi(2) + (GREENHILL * bending / length).powi(2)).sqrt() * length
        / (TAU * twisting);
    let tension = force * radius * radius / bending;
    if tension > 0.4 {
        return buckling * random.between(0.7, 1.7); // a solenoid
    }
    let alpha = angle_under(tension);
    let end_loop = TAU * (bending / (2.0 * force)).sqrt();
    let room = 0.85 * length - end_loop;
    if room <= 0.0 {
        return buckling * random.between(0.5, 0.9); // past the snap its ends would meet
    }
    let moment = 2.0 * bending * alpha.sin().powi(3) * alpha.cos() / (radius * (2.0 * alpha).cos());
    let in_twist = moment * length / (TAU * twisting);
    // strands cross twice in a turn of the superhelix, which takes 4πR/sin α of the rod
    let in_plectoneme = random.between(0.2, 1.0) * room * alpha.sin() / (TAU * radius);
    (in_twist + in_plectoneme).max(buckling * random.between(0.6, 1.1))
}

/// DNA held in magnetic tweezers: pulled, then turned.
pub fn tweezers(draft: &mut Draft, random: &mut Random) {
    let material = Material::dna(random);
    let (force, length) = (random.log_between(0.1, 20.0), random.log_between(100.0, 2000.0).round());
    let turns = random.sign() * turns_under(random, force, length, &material);
    draft.line("units = { length = \"nm\", force = \"pN\" }");
    draft.mesh(Mesh::random(random));
    draft.rod("rod", (&line(&Vec3::x(), length), length), &material, &[]);
    draft.clamp(ONLY, "\"start\"");
    draft.support(ONLY, "\"end\"", "[\"y\", \"z\"]", "true");
    draft.load(ONLY, "\"end\"", &(Vec3::x() * force));
    draft.stage("load = 1.0", 1);
    let steps = steps(random, turns);
    draft.stage(&rotation("end", &Vec3::x(), turns), steps);
}

/// Turned at a clamp that may slide along the axis, with and without pull; the other end clamped, or held in its place
/// and against turning about the axis only if it is pulled. From 20 to 500 diameters long.
pub fn sliding(draft: &mut Draft, random: &mut Random) {
    let radius = 0.5 / random.log_between(20.0, 500.0);
    let material = Material::isotropic(random, radius);
    let pull = random.chance(0.5).then(|| random.log_between(5.0, 1000.0).min(0.15 * material.stretching));
    let turns = match pull {
        Some(force) => turns_under(random, force, 1.0, &material),
        None => (random.between(0.03, 0.15) / material.diameter()).max(1.2),
    };
    let turns = random.sign() * turns.min(MOST_TURNS);
    // without pull a hinged rod folds up until its ends meet
    let held = if pull.is_some() && random.chance(0.5) { "[\"x\"]" } else { "true" };
    draft.mesh(Mesh::random(random));
    draft.rod("rod", (&line(&Vec3::x(), 1.0), 1.0), &material, &[]);
    draft.support(ONLY, "\"start\"", "true", held);
    draft.support(ONLY, "\"end\"", "[\"y\", \"z\"]", "true");
    if let Some(force) = pull {
        draft.load(ONLY, "\"end\"", &(Vec3::x() * force));
        draft.stage("load = 1.0", 1 + random.below(2) as usize);
    }
    let steps = steps(random, turns);
    draft.stage(&rotation("end", &Vec3::x(), turns), steps);
}

/// Straight at the start, curled by nature, loaded: a cantilever, or clamped at both ends.
pub fn curls(draft: &mut Draft, random: &mut Random) {
    let radius = 0.5 * random.log_between(0.003, 0.02);
    let material =
        if random.chance(0.3) { Material::anisotropic(random, radius) } else { Material::isotropic(random, radius) };
    let curl = TAU * random.between(0.3, 3.5);
    let towards = random.between(0.0, TAU);
    let curvature = [curl * towards.cos(), curl * towards.sin()].map(short);
    let twist = short(random.between(-12.0, 12.0));
    let natural = format!("natural = {{ curvature = {curvature:?}, twist = {twist:?} }}");
    draft.mesh(Mesh::random(random));
    draft.rod("rod", (&line(&Vec3::x(), 1.0), 1.0), &material, &[&natural]);
    draft.clamp(ONLY, "\"start\"");
    let steps = 1 + random.below(20) as usize;
    let weight = random.direction() * random.between(0.0, 15.0);
    if random.chance(0.4) {
        draft.clamp(ONLY, "\"end\"");
        draft.line(&format!("[[line_loads]]\nforce = {}", list(&weight)));
        draft.stage("load = 1.0", steps);
        let by = displacement("end", &(Vec3::x() * -random.between(0.1, 0.6)));
        draft.stage(&by, 4 + random.below(12) as usize);
        return;
    }
    if random.chance(0.5) {
        draft.line(&format!("[[line_loads]]\nforce = {}", list(&weight)));
    } else {
        draft.load(ONLY, "\"end\"", &weight);
    }
    draft.stage("load = 1.0", steps);
}
