//! Several rods: links, cables, beams on rings.

use std::f64::consts::{PI, TAU};

use supercoil::math::Vec3;

use super::Random;
use super::draft::{Draft, Mesh, list, short};
use super::material::Material;

fn quoted(name: &str) -> String {
    format!("\"{name}\"")
}

/// A chain of two to four rings, each across the one before it: supercoiled, or pulled apart.
pub fn linked_rings(draft: &mut Draft, random: &mut Random) {
    let count = 2 + random.below(3) as usize;
    let bend = 0.5 / PI; // radius of a ring of length 1
    let radius = 0.5 * random.log_between(0.008, 0.05);
    // every ring runs through the hole of the one before it, and past the one before that
    let apart = random.between(bend + 1.4 * radius, 1.5 * bend);
    let tilt = random.between(-0.4, 0.4);
    draft.mesh(Mesh::random(random));
    let names: Vec<String> = (0..count).map(|k| format!("ring{k}")).collect();
    let mut diameters = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let thinner = radius * random.between(0.7, 1.0);
        let material = Material::isotropic(random, thinner);
        let angle = if k % 2 == 0 { 0.0 } else { 0.5 * PI + tilt };
        let normal = Vec3::new(0.0, angle.sin(), angle.cos());
        let center = Vec3::x() * (apart * k as f64);
        let shape = format!("kind = \"circle\", length = 1.0, center = {}, normal = {}", list(&center), list(&normal));
        draft.rod(name, (&shape, 1.0), &material, &["closed = true"]);
        diameters.push(material.diameter());
    }
    let steps = 4 + random.below(16) as usize;
    let supercoiled = random.chance(0.5);
    if supercoiled {
        let ramp = |(name, diameter): (&String, &f64)| {
            let to = random.between(-0.6, 0.6) * 0.14 / diameter;
            format!("{{ rod = \"{name}\", to = {:?} }}", short(to))
        };
        let ramps: Vec<String> = names.iter().zip(&diameters).map(ramp).collect();
        draft.stage(&format!("excess_link = [{}]", ramps.join(", ")), steps);
        return;
    }
    // a circle starts on the side of +x: its far side is half the length away
    draft.clamp("\"ring0\"", "{ arc = 0.5 }");
    let last = quoted(&names[count - 1]);
    draft.clamp(&last, "\"start\"");
    // pulled flat, a ring of length 1 is half as long, less what it takes to go round its neighbours
    let flat = 0.5 - 3.2 * diameters.iter().fold(0.0, |a: f64, b| a.max(*b));
    let (now, most) = (2.0 * bend + apart * (count - 1) as f64, flat * count as f64);
    let by = (most - now) * random.between(0.3, 0.85);
    draft.stage(&format!("displacement = {{ rod = {last}, at = \"start\", to = {} }}", list(&(Vec3::x() * by))), steps);
}

/// Cables of two to seven wires, pulled and laid by turning their far ends round the axis; seven are six about a core.
pub fn cables(draft: &mut Draft, random: &mut Random) {
    let count = 2 + random.below(6) as usize;
    let around = if count == 7 { 6 } else { count };
    let slenderness = random.log_between(20.0, 60.0);
    let poisson = short(random.between(0.0, 0.45));
    let (diameter, length) = (2.0, short(2.0 * slenderness));
    let lay_radius = 0.5 * diameter / (PI / around as f64).sin() * 1.002;
    let wires = (0..around).map(|k| {
        let angle = TAU * k as f64 / around as f64;
        Vec3::new(angle.cos(), angle.sin(), 0.0) * (lay_radius * 1.01)
    });
    let core = (count == 7).then(Vec3::zeros);
    let starts: Vec<Vec3> = core.into_iter().chain(wires).collect();
    let elements = (slenderness / random.between(1.5, 3.0)).ceil().max(8.0);
    let names: Vec<String> = (0..count).map(|k| format!("wire{k}")).collect();
    for (name, start) in names.iter().zip(&starts) {
        draft.line(&format!(
            "[[rods]]\nname = \"{name}\"\nshape = {{ kind = \"line\", start = {}, direction = [0, 0, 1], length = \
             {length:?} }}",
            list(start)
        ));
        draft.line(&format!(
            "section = {{ young = 100.0, poisson = {poisson:?}, circle = 1.0 }}\nelements = {elements}"
        ));
    }
    let all = format!("{names:?}");
    draft.clamp(&all, "\"start\"");
    draft.support(&all, "\"end\"", "[\"x\", \"y\"]", "true");
    // of the force that stretches a wire to twice its length
    let pull = 100.0 * PI * random.log_between(1e-3, 3e-2);
    names.iter().for_each(|name| draft.load(&quoted(name), "\"end\"", &(Vec3::z() * pull)));
    draft.stage("load = 1.0", 1 + random.below(2) as usize);
    let lay = random.between(5.0, 22.0f64).to_radians();
    let turns = random.sign() * length * lay.tan() / (TAU * lay_radius);
    let steps = (turns.abs() * random.log_between(6.0, 24.0)).ceil().max(4.0);
    draft.stage(
        &format!(
            "rotation = {{ rod = {all}, at = \"end\", axis = [0, 0, 1], through = [0, 0, 0], turns = {:?} }}",
            short(turns)
        ),
        steps as usize,
    );
}

/// A clamped ring, and one or two beams laid across it anywhere, beside the clamp too, that are pushed onto it. A beam
/// whose two ends are clamped is pushed so far only that it need not stretch much if the ring does not give way.
pub fn beams(draft: &mut Draft, random: &mut Random) {
    let bend = 0.5 / PI;
    let ring = round(random);
    draft.mesh(Mesh::random(random));
    let normal = if random.chance(0.5) { Vec3::z() } else { Vec3::new(random.between(-0.1, 0.1), 0.0, 1.0) };
    let shape = format!("kind = \"circle\", length = 1.0, normal = {}", list(&normal));
    draft.rod("ring", (&shape, 1.0), &ring, &["closed = true"]);
    let count = 1 + random.below(2) as usize;
    let azimuth = random.between(0.0, TAU);
    let (along, across) = (Vec3::new(azimuth.cos(), azimuth.sin(), 0.0), Vec3::new(-azimuth.sin(), azimuth.cos(), 0.0));
    let (half, mut ramps, mut names) = (0.35, Vec::new(), Vec::new());
    for k in 0..count {
        let beam = Material { bending: [random.log_between(0.3, 3.0); 2], ..round(random) };
        // the second beam on the other side of the ring, and not above the first
        let side = if k == 0 { 1.0 } else { -1.0 };
        let offset = if count == 1 { random.between(-0.9, 0.9) } else { side * random.between(0.2, 0.9) } * bend;
        let lean = Vec3::z().dot(&normal.normalize()).acos().tan() * bend;
        let height = lean + (ring.radius + beam.radius) * random.between(1.05, 1.5);
        let start = along * -half + across * offset + Vec3::z() * (side * height);
        let name = format!("beam{k}");
        let shape = format!(
            "kind = \"line\", start = {}, direction = {}, length = {:?}",
            list(&start),
            list(&along),
            2.0 * half
        );
        draft.rod(&name, (&shape, 2.0 * half), &beam, &[]);
        let beam = quoted(&name);
        // where the beam crosses the ring, and how far that is from the ring's clamp at +x
        let reach = (bend * bend - offset * offset).sqrt();
        let clamp = Vec3::x() * bend;
        let nearest = [-1.0, 1.0].map(|s| (across * offset + along * (s * reach) - clamp).norm());
        let near = nearest[0].min(nearest[1]);
        let sideways = across * random.between(-0.03, 0.03);
        // drawn in, its ends nearer to each other, it need not stretch
        let drawn_in = random.chance(0.5);
        let far = if drawn_in {
            random.between(0.08, 0.2)
        } else {
            random.between(0.3, 1.0) * (0.04 + 0.8 * (near - 0.03).max(0.0)).min(0.18)
        };
        let down = Vec3::z() * (-side * (height - ring.radius + far));
        let tilt = random.between(0.6, 1.0);
        let inwards = along * if drawn_in { 0.25 * far } else { 0.0 };
        ramps.push(format!("{{ rod = {beam}, at = \"start\", to = {} }}", list(&(down * tilt + sideways + inwards))));
        ramps.push(format!("{{ rod = {beam}, at = \"end\", to = {} }}", list(&(down + sideways - inwards))));
        names.push(beam);
    }
    draft.clamp("\"ring\"", "\"start\"");
    for beam in &names {
        draft.clamp(beam, "\"start\"");
        draft.clamp(beam, "\"end\"");
    }
    let steps = 4 + random.below(20) as usize;
    draft.stage(&format!("displacement = [{}]", ramps.join(", ")), steps);
}

/// The section of a ring or beam.
fn round(random: &mut Random) -> Material {
    let radius = random.log_between(0.003, 0.012);
    Material::isotropic(random, radius)
}
