//! Rods at cylinders and spheres: over pulleys and posts, in tubes, in cavities that shrink, about balloons, in bowls.

use supercoil::math::Vec3;

use super::Random;
use super::draft::{Draft, Mesh, list, short};
use super::material::Material;

fn line(start: &Vec3, direction: &Vec3, length: f64) -> String {
    format!("kind = \"line\", start = {}, direction = {}, length = {length:?}", list(start), list(direction))
}

fn circle(radius: f64, normal: &Vec3) -> String {
    format!("kind = \"circle\", radius = {radius:?}, normal = {}", list(normal))
}

/// A rigid body: `shape` is `sphere`, or `cylinder` with its axis.
fn body(draft: &mut Draft, name: &str, (shape, axis): (&str, Option<Vec3>), point: &Vec3, (radius, side): (f64, &str)) {
    draft.line(&format!("[[obstacles]]\nname = \"{name}\"\nshape = \"{shape}\"\npoint = {}", list(point)));
    if let Some(axis) = axis {
        draft.line(&format!("axis = {}", list(&axis)));
    }
    draft.line(&format!("radius = {:?}\nside = \"{side}\"", short(radius)));
}

/// A ball, or a post or tube along a direction.
fn ball_or(random: &mut Random, axis: Vec3) -> (&'static str, Option<Vec3>) {
    if random.chance(0.5) { ("sphere", None) } else { ("cylinder", Some(axis)) }
}

/// One scene in seven each.
pub fn obstacles(draft: &mut Draft, random: &mut Random) {
    let radius = random.log_between(0.004, 0.02);
    let material =
        if random.chance(0.3) { Material::anisotropic(random, radius) } else { Material::isotropic(random, radius) };
    draft.mesh(Mesh::random(random));
    let steps = 1 + random.below(8) as usize;
    match random.below(7) {
        0 => pulley(draft, random, &material, steps),
        1 => tube(draft, random, &material, steps),
        2 => cavity(draft, random, &material, steps),
        3 => balloon(draft, random, &material, steps),
        4 => posts(draft, random, &material, steps),
        5 => bowl(draft, random, &material, steps),
        _ => pushed(draft, random, &material, steps),
    }
}

/// A rope over a cylinder, its middle above the axle, both ends pulled down.
fn pulley(draft: &mut Draft, random: &mut Random, material: &Material, steps: usize) {
    let size = random.between(0.05, 0.25);
    let height = size + material.radius + random.between(0.0, 0.02);
    let slant = Vec3::new(random.between(-0.1, 0.1), 1.0, 0.0);
    draft.rod("rope", (&line(&Vec3::new(-0.5, 0.0, height), &Vec3::x(), 1.0), 1.0), material, &[]);
    body(draft, "pulley", ("cylinder", Some(slant)), &Vec3::zeros(), (size, "outside"));
    draft.support("\"rope\"", "{ arc = 0.5 }", "[\"x\", \"y\"]", "false");
    let force = random.log_between(1.0, 300.0);
    for (at, share) in [("start", 1.0), ("end", random.between(0.8, 1.2))] {
        let down = -short(force * share);
        draft.line(&format!("[[loads]]\nrod = \"rope\"\nat = \"{at}\"\nforce = [0.0, 0.0, {down:?}]"));
    }
    draft.stage("load = 1.0", steps);
}

/// A rod clamped on the axis of a tube is turned and pushed in.
fn tube(draft: &mut Draft, random: &mut Random, material: &Material, steps: usize) {
    let way = random.direction();
    draft.rod("rod", (&line(&Vec3::zeros(), &way, 1.0), 1.0), material, &[]);
    let size = material.radius + random.log_between(0.01, 0.08);
    body(draft, "tube", ("cylinder", Some(way)), &Vec3::zeros(), (size, "inside"));
    draft.clamp("\"rod\"", "\"start\"");
    draft.clamp("\"rod\"", "\"end\"");
    if random.chance(0.6) {
        let turns = short(random.between(-1.5, 1.5));
        let turn = format!("rotation = {{ at = \"end\", axis = {}, turns = {turns:?} }}", list(&way));
        draft.stage(&turn, 1 + random.below(3) as usize);
    }
    let to = way * -random.between(0.005, 0.1);
    draft.stage(&format!("displacement = {{ at = \"end\", to = {} }}", list(&to)), steps);
}

/// A ring in a sphere or a tube that becomes smaller than it; a tube is slanted or along the ring's plane.
fn cavity(draft: &mut Draft, random: &mut Random, material: &Material, steps: usize) {
    let normal = random.direction();
    draft.rod("ring", (&circle(0.16, &normal), 1.0), material, &["closed = true"]);
    let size = 0.16 + 1.5 * material.radius;
    let across = normal.cross(&random.direction());
    body(draft, "cavity", ball_or(random, across), &Vec3::zeros(), (size, "inside"));
    let to = short(random.between(0.6, 0.95) * size);
    draft.stage(&format!("obstacle = {{ radius = {to:?} }}"), steps);
}

/// A ring about a ball or a cylinder that is blown up, and may be moved.
fn balloon(draft: &mut Draft, random: &mut Random, material: &Material, steps: usize) {
    let normal = random.direction();
    draft.rod("ring", (&circle(0.16, &normal), 1.0), material, &["closed = true"]);
    let most = 0.16 - material.radius;
    let slant = normal + random.direction() * 0.3;
    body(draft, "balloon", ("cylinder", Some(slant)), &Vec3::zeros(), (random.between(0.3, 0.9) * most, "outside"));
    let to = short(random.between(0.9, 1.05) * most);
    let aside = normal.cross(&random.direction()) * 0.2;
    draft.stage(&format!("obstacle = {{ radius = {to:?}, displacement = {} }}", list(&aside)), steps);
}

/// A heavy rod held at one end, or at both, above posts and balls.
fn posts(draft: &mut Draft, random: &mut Random, material: &Material, steps: usize) {
    draft.rod("rod", (&line(&Vec3::zeros(), &Vec3::x(), 1.0), 1.0), material, &[]);
    for k in 0..1 + random.below(3) {
        let size = random.between(0.03, 0.12);
        let depth = size + material.radius + random.between(0.0, 0.1);
        let point = Vec3::new(0.25 + 0.28 * k as f64, random.between(-0.5, 0.5) * size, -depth);
        let axis = Vec3::new(random.between(-0.3, 0.3), 1.0, random.between(-0.1, 0.1));
        let shape = ball_or(random, axis);
        body(draft, &format!("post{k}"), shape, &point, (size, "outside"));
    }
    draft.clamp("\"rod\"", "\"start\"");
    if random.chance(0.5) {
        draft.support("\"rod\"", "\"end\"", "[\"y\", \"z\"]", "false");
    }
    let weight = -short(random.log_between(1.0, 100.0));
    draft.line(&format!("[[line_loads]]\nrod = \"rod\"\nforce = [0.0, 0.0, {weight:?}]"));
    draft.stage("load = 1.0", steps);
}

/// One or two rods that nothing holds fall into a bowl or a pipe.
fn bowl(draft: &mut Draft, random: &mut Random, material: &Material, steps: usize) {
    let size = random.between(0.7, 1.2);
    for k in 0..1 + random.below(2) {
        let name = format!("rod{k}");
        let up = Vec3::z() * (0.1 - 0.3 * k as f64);
        let slant = Vec3::new(1.0, random.between(-0.3, 0.3), random.between(-0.2, 0.2)).normalize();
        if random.chance(0.5) {
            let ring = format!("{}, center = {}", circle(0.12, &(Vec3::z() + slant * 0.3)), list(&up));
            draft.rod(&name, (&ring, 0.75), material, &["closed = true"]);
        } else {
            draft.rod(&name, (&line(&(up - slant * 0.3), &slant, 0.6), 0.6), material, &[]);
        }
        let weight = -short(random.log_between(1.0, 100.0));
        draft.line(&format!("[[line_loads]]\nrod = \"{name}\"\nforce = [0.0, 0.0, {weight:?}]"));
    }
    let along = Vec3::new(1.0, random.between(-1.0, 1.0), 0.0);
    body(draft, "bowl", ball_or(random, along), &Vec3::zeros(), (size, "inside"));
    draft.stage("load = 1.0", steps);
}

/// A clamped rod that a post or a ball pushes aside, straight or about a hinge.
fn pushed(draft: &mut Draft, random: &mut Random, material: &Material, steps: usize) {
    draft.rod("rod", (&line(&Vec3::zeros(), &Vec3::x(), 1.0), 1.0), material, &[]);
    draft.clamp("\"rod\"", "\"start\"");
    if random.chance(0.4) {
        draft.support("\"rod\"", "\"end\"", "true", "false");
    }
    let size = random.between(0.03, 0.12);
    let gap = random.between(0.0, 0.05);
    let point = Vec3::new(random.between(0.3, 0.8), -(size + material.radius + gap), 0.0);
    let axis = Vec3::new(random.between(-0.3, 0.3), random.between(-0.1, 0.1), 1.0);
    let shape = ball_or(random, axis);
    body(draft, "post", shape, &point, (size, "outside"));
    if random.chance(0.4) {
        draft.line(&format!("hinge = {{ through = {}, axis = [0.0, 0.0, 1.0] }}", list(&(point - Vec3::x()))));
        let turns = short(random.between(0.005, 0.03));
        draft.stage(&format!("obstacle = {{ turns = {turns:?} }}"), steps);
    } else {
        let up = random.between(0.05, 0.15);
        let to = Vec3::new(random.between(-0.1, 0.1), gap + up, random.between(-0.02, 0.02));
        draft.stage(&format!("obstacle = {{ displacement = {} }}", list(&to)), steps);
    }
}
