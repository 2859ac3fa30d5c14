//! Rods joined rigidly, by pins and by hinges, in contact: chains, mobiles, frames, nets, and scissors.

use supercoil::math::Vec3;

use super::Random;
use super::draft::{Draft, list, short};
use super::material::Material;

/// A node of a rod.
type End<'a> = (&'a str, u64);

fn line(start: &Vec3, way: &Vec3) -> (String, f64) {
    let length = short(way.norm());
    let (start, way) = (list(start), list(way));
    (format!("kind = \"line\", start = {start}, direction = {way}, length = {length:?}"), length)
}

fn joint(draft: &mut Draft, a: End, b: End, kind: &str) {
    let [a, b] = [a, b].map(|(rod, at)| format!("{{ rod = \"{rod}\", at = {at} }}"));
    draft.line(&format!("[[joints]]\na = {a}\nb = {b}\n{kind}"));
}

/// Rigid, a pin, or a hinge about an axis.
fn kind(random: &mut Random) -> String {
    match random.below(4) {
        0 => "kind = \"rigid\"".to_owned(),
        1 => format!("kind = \"hinge\"\naxis = {}", list(&axis(random))),
        _ => "kind = \"pin\"".to_owned(),
    }
}

fn axis(random: &mut Random) -> Vec3 {
    if random.chance(0.6) { Vec3::ith(random.below(3) as usize, 1.0) } else { random.direction() }
}

/// Nodes of a rod of four cubic elements.
const LAST: u64 = 12;

/// One scene in five each.
pub fn joined(draft: &mut Draft, random: &mut Random) {
    let radius = random.log_between(0.004, 0.015);
    let material =
        if random.chance(0.3) { Material::anisotropic(random, radius) } else { Material::isotropic(random, radius) };
    draft.line("gravity = [0.0, 0.0, -9.81]");
    let weight = format!("weight = {:?}", short(random.log_between(0.3, 30.0)));
    let more = [weight.as_str(), "elements = 4"];
    match random.below(5) {
        0 => chain(draft, random, (&material, &more)),
        1 => mobile(draft, random, (&material, &more)),
        2 => frame(draft, random, (&material, &more)),
        3 => net(draft, random, (&material, &weight)),
        _ => scissors(draft, random, (&material, &more)),
    }
    if random.chance(0.5) {
        draft.stage("load = 1.0", 1 + random.below(4) as usize);
    }
}

/// Three to six links along x, between two hooks or from one; all joints alike in half of them. Places of links are
/// multiples of a half, so that their ends meet exactly.
fn chain(draft: &mut Draft, random: &mut Random, (material, more): (&Material, &[&str])) {
    let count = 3 + random.below(4);
    let (alike, one) = (random.chance(0.5), kind(random));
    for k in 0..count {
        let (shape, length) = line(&(Vec3::x() * (0.5 * k as f64)), &(Vec3::x() * 0.5));
        draft.rod(&format!("link{k}"), (&shape, length), material, more);
    }
    for k in 1..count {
        let kind = if alike { one.clone() } else { kind(random) };
        joint(draft, (&format!("link{}", k - 1), LAST), (&format!("link{k}"), 0), &kind);
    }
    draft.support("\"link0\"", "\"start\"", "true", "false");
    if random.chance(0.5) {
        draft.support(&format!("\"link{}\"", count - 1), "\"end\"", "true", "false");
    }
}

/// Bars that hang by strings from each other, two levels of them, with unequal arms.
fn mobile(draft: &mut Draft, random: &mut Random, (material, more): (&Material, &[&str])) {
    let string = |draft: &mut Draft, name: &str, top: &Vec3| {
        let (shape, length) = line(top, &(Vec3::z() * -0.25));
        draft.rod(name, (&shape, length), material, more);
    };
    let bar = |draft: &mut Draft, name: &str, left: &Vec3, length: f64| {
        let (shape, length) = line(left, &(Vec3::x() * length));
        draft.rod(name, (&shape, length), material, more);
    };
    let top = Vec3::zeros();
    string(draft, "string", &top);
    draft.support("\"string\"", "\"start\"", "true", "false");
    // bar of length 1.5 hung at its node 4, 6 or 8
    let held = 4 + 2 * random.below(3);
    let left = Vec3::new(-0.125 * held as f64, 0.0, -0.25);
    bar(draft, "bar", &left, 1.5);
    joint(draft, ("string", LAST), ("bar", held), &kind(random));
    for (k, at) in [0, LAST].into_iter().enumerate() {
        let (name, lower) = (format!("string{k}"), format!("bar{k}"));
        let place = left + Vec3::x() * (0.125 * at as f64);
        string(draft, &name, &place);
        joint(draft, ("bar", at), (&name, 0), &kind(random));
        if random.chance(0.7) {
            let held = 4 + 2 * random.below(3);
            let start = place + Vec3::new(-0.0625 * held as f64, 0.0, -0.25);
            bar(draft, &lower, &start, 0.75);
            joint(draft, (&name, LAST), (&lower, held), &kind(random));
        }
    }
}

/// Two columns with a beam between them, a force at a corner: feet clamped or pinned about an axis, corners joined by
/// any kind.
fn frame(draft: &mut Draft, random: &mut Random, (material, more): (&Material, &[&str])) {
    let (left, right) = (Vec3::zeros(), Vec3::x() * 0.75);
    for (name, foot) in [("left", left), ("right", right)] {
        let (shape, length) = line(&foot, &Vec3::z());
        draft.rod(name, (&shape, length), material, more);
        draft.clamp(&format!("\"{name}\""), "\"start\"");
    }
    let (shape, length) = line(&Vec3::z(), &right);
    draft.rod("beam", (&shape, length), material, more);
    joint(draft, ("left", LAST), ("beam", 0), &kind(random));
    joint(draft, ("right", LAST), ("beam", LAST), &kind(random));
    if random.chance(0.5) {
        let (shape, length) = line(&Vec3::z(), &(right - Vec3::z()));
        draft.rod("brace", (&shape, length), material, more);
        joint(draft, ("left", LAST), ("brace", 0), "kind = \"pin\"");
        joint(draft, ("right", 0), ("brace", LAST), "kind = \"pin\"");
    }
    let force = random.direction() * random.between(0.1, 2.0);
    draft.load("[\"left\", \"beam\"]", "\"end\"", &force);
}

/// A net of three or four cords each way, hung by two to four of its corners.
fn net(draft: &mut Draft, random: &mut Random, (material, weight): (&Material, &str)) {
    let count = 3 + random.below(2);
    let last = 6 * (count - 1);
    let elements = format!("elements = {}", 2 * (count - 1));
    for (name, way, aside) in [("x", Vec3::x(), Vec3::y()), ("y", Vec3::y(), Vec3::x())] {
        for k in 0..count {
            let (shape, length) = line(&(aside * (0.25 * k as f64)), &(way * (0.25 * (count - 1) as f64)));
            draft.rod(&format!("{name}{k}"), (&shape, length), material, &[weight, &elements]);
        }
    }
    for j in 0..count {
        for k in 0..count {
            joint(draft, (&format!("x{j}"), 6 * k), (&format!("y{k}"), 6 * j), "kind = \"pin\"");
        }
    }
    let far = format!("\"x{}\"", count - 1);
    let corners = [("\"x0\"", 0), (far.as_str(), last), ("\"x0\"", last), (far.as_str(), 0)];
    for (rod, at) in corners.into_iter().take(2 + random.below(3) as usize) {
        draft.support(rod, &at.to_string(), "true", "false");
    }
}

/// Two bars hinged or pinned in their middles, one clamped at an end, the other pushed round until they touch.
fn scissors(draft: &mut Draft, random: &mut Random, (material, more): (&Material, &[&str])) {
    let other =
        [Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.6, 0.8, 0.0), Vec3::new(-0.6, 0.8, 0.0)][random.below(3) as usize];
    for (name, way) in [("fixed", Vec3::x()), ("free", other)] {
        let (shape, length) = line(&(way * -0.5), &way);
        draft.rod(name, (&shape, length), material, more);
    }
    draft.clamp("\"fixed\"", "\"start\"");
    let kind = if random.chance(0.5) { "kind = \"hinge\"\naxis = [0.0, 0.0, 1.0]" } else { "kind = \"pin\"" };
    joint(draft, ("fixed", LAST / 2), ("free", LAST / 2), kind);
    let force = Vec3::new(random.between(-3.0, 3.0), random.between(-3.0, 3.0), random.between(-1.0, 1.0));
    draft.load("\"free\"", "\"end\"", &force);
}
