//! Rods under their weight that hang from points: pendulums, ropes between hooks, rings on nails and on pegs, mobiles
//! of joined rods; and stacks of rods exactly along the axes, which lie on a table.

use supercoil::math::Vec3;

use super::Random;
use super::draft::{Draft, list, short};
use super::material::Material;

/// A direction, along an axis in a third of the cases.
fn direction(random: &mut Random) -> Vec3 {
    let axes = [Vec3::x(), Vec3::y(), Vec3::z(), -Vec3::z()];
    if random.chance(0.3) { axes[random.below(4) as usize] } else { random.direction() }
}

fn line(start: &Vec3, direction: &Vec3, length: f64) -> String {
    format!("kind = \"line\", start = {}, direction = {}, length = {length:?}", list(start), list(direction))
}

/// One scene in five each.
pub fn hanging(draft: &mut Draft, random: &mut Random) {
    let radius = random.log_between(0.003, 0.01);
    let material =
        if random.chance(0.3) { Material::anisotropic(random, radius) } else { Material::isotropic(random, radius) };
    draft.line("gravity = [0.0, 0.0, -9.81]");
    let weight = format!("weight = {:?}", short(random.log_between(0.3, 300.0)));
    let (weight, elements) = (weight.as_str(), format!("elements = {}", 12 + random.below(20)));
    let (way, zero) = (direction(random), Vec3::zeros());
    let more = [weight, elements.as_str()];
    let steps = 1 + random.below(4) as usize;
    let ring = |draft: &mut Draft, center: &Vec3, normal: &Vec3| {
        let circle = format!("kind = \"circle\", length = 1.0, center = {}, normal = {}", list(center), list(normal));
        draft.rod("a", (&circle, 1.0), &material, &["closed = true", weight, elements.as_str()]);
    };
    match random.below(5) {
        0 => {
            draft.rod("a", (&line(&zero, &way, 1.0), 1.0), &material, &more);
            draft.support("\"a\"", if random.chance(0.5) { "\"start\"" } else { "9" }, "true", "false");
        }
        1 => {
            draft.rod("a", (&line(&zero, &way, 1.0), 1.0), &material, &more);
            draft.support("\"a\"", "\"start\"", "true", "false");
            draft.support("\"a\"", "\"end\"", "true", "false");
            let to = way * -random.between(0.1, 0.8);
            draft.stage(&format!("displacement = {{ rod = \"a\", at = \"end\", to = {} }}", list(&to)), 2 + steps);
        }
        2 => {
            ring(draft, &zero, &way);
            draft.support("\"a\"", "0", "true", "false");
            if random.chance(0.4) {
                draft.support("\"a\"", &format!("{}", 9 + random.below(18)), "true", "false");
            }
        }
        3 => {
            let along = Vec3::new(1.0, random.between(-0.5, 0.5), 0.0).normalize();
            ring(draft, &Vec3::new(0.0, 0.0, -random.between(0.0, 0.1)), &(along + random.direction() * 0.3));
            draft.rod("peg", (&line(&(along * -0.5), &along, 1.0), 1.0), &material, &[]);
            draft.clamp("\"peg\"", "\"start\"");
            draft.clamp("\"peg\"", "\"end\"");
        }
        _ => {
            // joined where decimals are exact
            draft.rod("a", (&line(&zero, &Vec3::x(), 1.0), 1.0), &material, &[weight, "elements = 12"]);
            draft.support("\"a\"", "\"start\"", "true", "false");
            for k in 0..1 + random.below(3) {
                let node = [9, 18, 36][random.below(3) as usize];
                let (name, start) = (format!("b{k}"), Vec3::x() * (f64::from(node) / 36.0));
                let length = short(random.between(0.2, 0.8));
                draft.rod(&name, (&line(&start, &random.direction(), length), length), &material, &[weight]);
                draft.line(&format!(
                    "[[joints]]\na = {{ rod = \"a\", at = {node} }}\nb = {{ rod = \"{name}\", at = \"start\" }}"
                ));
            }
        }
    }
    if random.chance(0.5) {
        draft.stage("load = 1.0", steps);
    }
}

/// Two to five rods exactly along x or y, one above the other, some with gaps of 0, on a table.
pub fn along_axes(draft: &mut Draft, random: &mut Random) {
    let radius = 0.03;
    let material = Material::isotropic(random, radius);
    draft.line("gravity = [0.0, 0.0, -1.0]");
    let weight = format!("weight = {:?}", short(random.log_between(0.3, 30.0)));
    let gap = if random.chance(0.6) { 0.0 } else { 0.01 };
    for k in 0..2 + random.below(4) {
        let way = if random.chance(0.5) { Vec3::x() } else { Vec3::y() };
        let start = way * -0.5 + Vec3::z() * (radius + f64::from(k as u32) * (2.0 * radius + gap));
        let name = format!("rod{k}");
        draft.rod(&name, (&line(&start, &way, 1.0), 1.0), &material, &[&weight, "elements = 6"]);
    }
    draft.line("[[planes]]\nnormal = [0.0, 0.0, 1.0]");
    if random.chance(0.5) {
        draft.stage("load = 1.0", 1 + random.below(3) as usize);
    }
}
