//! Rods under their weight that nothing holds: they fall onto a table or into a groove, and onto each other.

use std::f64::consts::TAU;

use supercoil::math::Vec3;

use super::Random;
use super::draft::{Draft, Mesh, list, short};
use super::material::Material;

/// Height of the table, below all rods.
const TABLE: f64 = -0.05;
/// Depth of the groove, whose sides rise by 3 in 4.
const GROOVE: f64 = -0.8;

/// One to three rings, arcs or straight rods above each other.
pub fn falling(draft: &mut Draft, random: &mut Random) {
    let radius = random.log_between(0.004, 0.03);
    let material =
        if random.chance(0.3) { Material::anisotropic(random, radius) } else { Material::isotropic(random, radius) };
    let weight = random.log_between(1.0, 500.0);
    draft.mesh(Mesh::random(random));
    for index in 0..1 + random.below(3) {
        let name = format!("rod{index}");
        let height = 0.3 + 0.5 * index as f64;
        let aside = Vec3::new(random.between(-0.1, 0.1), random.between(-0.1, 0.1), height);
        let slant = random.between(-0.2, 0.2);
        let (shape, length, more) = match random.below(3) {
            0 => {
                let flat = Vec3::new(slant, random.between(-0.2, 0.2), 1.0);
                let normal = if random.chance(0.3) { random.direction() } else { flat };
                (
                    format!("kind = \"circle\", length = 1.0, center = {}, normal = {}", list(&aside), list(&normal)),
                    1.0,
                    vec!["closed = true"],
                )
            }
            1 => {
                let (start, direction) = (aside - Vec3::x() * 0.4, Vec3::new(1.0, random.between(-0.3, 0.3), slant));
                let line = format!(
                    "kind = \"line\", start = {}, direction = {}, length = 0.8",
                    list(&start),
                    list(&direction)
                );
                (line, 0.8, Vec::new())
            }
            _ => {
                let turns = short(random.between(0.2, 0.8));
                let tangent = Vec3::new(1.0, 0.1, slant);
                let arc = format!(
                    "kind = \"arc\", radius = 0.25, turns = {turns:?}, start = {}, tangent = {}, towards = [0.0, 1.0, \
                     0.1]",
                    list(&aside),
                    list(&tangent)
                );
                (arc, TAU * turns * 0.25, if random.chance(0.7) { vec!["natural = \"as-shaped\""] } else { Vec::new() })
            }
        };
        draft.rod(&name, (&shape, length), &material, &more);
        draft.line(&format!("[[line_loads]]\nrod = \"{name}\"\nforce = [0.0, 0.0, {:?}]", -short(weight)));
    }
    let mut plane = |name: &str, height: f64, normal: [f64; 3]| {
        draft.line(&format!("[[planes]]\nname = \"{name}\"\npoint = [0.0, 0.0, {height:?}]\nnormal = {normal:?}"));
    };
    if random.chance(0.2) {
        plane("left", GROOVE, [0.6, 0.0, 0.8]);
        plane("right", GROOVE, [-0.6, 0.0, 0.8]);
    } else {
        plane("table", TABLE, [0.0, 0.0, 1.0]);
    }
    draft.stage("load = 1.0", 1 + random.below(4) as usize);
}
