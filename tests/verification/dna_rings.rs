//! Rings of DNA of the isotropic step model "IdealDNA" against emDNA, which minimises over rigid base pairs.
//!
//! Set-up: closed rings of 68 (Lk 6 and 7) and 104 base pairs (Lk 10), no contact; 256 cubic elements. References: the
//! logs that emDNA ships (github.com/nicocvn/emDNA), all digits. The start, a flat circle with even twist, costs n/2 ·
//! (.0427 (360/n)² + .0597 (360 Lk/n − 34.2857)²) kT in either model. At the minimum the twisted ring shears by M3
//! κ/GA, which lowers the energy by L (M3 κ)²/(2 GA) to first order. Of that, steps of 2π/n and a rod differ by about
//! (π/n)²/3: tolerance (π/n)²/2. Mean tilt and roll energies are equal in a ring whose helix turns many times: bending
//! energy is compared with their sum.
//!
//! Blocks of steps (`dna::blocks`) are compared with single steps on a mesh that resolves them.

use crate::common;

use common::{history, observed, verify};
use supercoil::dna::THERMAL_ENERGY;
use supercoil::dna::sequence::{Helix, Sequence, Steps};
use supercoil::internals::quadrature::gauss;
use supercoil::math::Vec3;
use supercoil::observe::{observe, strains};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeRef, Support};
use supercoil::solve::{self, Options, Solver, Status};

fn ring(base_pairs: usize, link: f64) -> Solver {
    let helix = Sequence::parse(&"A".repeat(base_pairs)).unwrap().helix(&Steps::ideal(), true).unwrap();
    ring_of(helix, link, 256)
}

fn ring_of(helix: Helix, link: f64, elements: usize) -> Solver {
    let circle = Shape::Circle { length: helix.length, center: Vec3::zeros(), normal: Vec3::z() };
    let section = Section::of_diagonal(&helix.stiffness.at(0.0), 0.0);
    let rod =
        Rod::new("ring", &circle, RodMesh::closed(elements, 3), section, Natural::Varying(helix.natural)).unwrap();
    let excess = link - helix.turns_left_out - rod.natural_link();
    let rod = rod.with_stiffness(helix.stiffness).unwrap().with_excess_link(excess).unwrap();
    let model = Model { rods: vec![rod], contact: Contact::NONE, ..Model::default() };
    Solver::new(model, Options::default()).unwrap()
}

/// Energies of translation, bending and twist, kT.
fn energies(solver: &Solver) -> [f64; 3] {
    let rod = &solver.engine().model().rods[0];
    let (Natural::Varying(natural), rule) = (&rod.natural, gauss(3)) else { panic!("varying") };
    let (fields, h) = (strains(solver.engine(), 0), rod.length / rod.num_elements as f64);
    let mut sums = [0.0; 3];
    for (k, (strain, stress)) in fields.strains.iter().zip(&fields.stresses).enumerate() {
        let rest = natural.at(fields.arc_lengths[k]);
        for i in 0..6 {
            let part = 0.5 * rule.weights[k % 3] * h * stress[i] * (strain[i] - rest[i]) / THERMAL_ENERGY;
            sums[[0, 0, 0, 1, 1, 2][i]] += part;
        }
    }
    sums
}

#[test]
fn rings_of_ideal_dna() {
    for (base_pairs, link, start, least) in [
        (68, 6.0, 53.590_802_175_7, 53.497_698_589_4),
        (68, 7.0, 56.300_184_834_5, 56.187_527_031_1),
        (104, 10.0, 26.942_807_891_4, 26.941_765_131_1),
    ] {
        let case = format!("IdealDNA, {base_pairs} bp, Lk {link}");
        let mut solver = ring(base_pairs, link);
        let found: f64 = energies(&solver).iter().sum();
        verify(&case, "energy of the flat circle, kT", found, start, 1e-6);
        let report = solver.find_equilibrium();
        assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(&report));
        let parts = energies(&solver);
        println!("{case}: {} iterations, translation, bending, twist {parts:?}", report.iterations);
        let steps = 0.5 * (std::f64::consts::PI / base_pairs as f64).powi(2) * (start - least);
        verify(&case, "least energy, kT", parts.iter().sum(), least, steps);
        if link == 6.0 {
            verify(&case, "energy of bending, kT", parts[1], 20.345_125 + 20.344_983, 1e-3);
            verify(&case, "energy of twist, kT", parts[2], 12.714_679, 1e-3);
        }
    }
}

/// A ring of 189 base pairs of a sequence with a bend of its own, taken in blocks: the axis on 24 elements, against a
/// constant piece a step on 1000. (A node a base pair is 5 % off: shift and slide lead to and fro.)
#[test]
fn blocks_of_steps() {
    let letters: String = "AAAAAACGGCGATTCAGCCTG".repeat(9);
    let helix = Sequence::parse(&letters).unwrap().helix(&Steps::protein_dna_1998().unwrap(), true).unwrap();
    let rest = |helix: Helix, elements: usize| {
        let mut solver = ring_of(helix, 18.0, elements);
        let report = solver.find_equilibrium();
        assert_eq!(report.status, Status::Converged, "{}", history(&report));
        let energy = observed(&solver, &report).energies.total / THERMAL_ENERGY;
        println!("{elements} elements: {energy} kT, {} iterations", report.iterations);
        energy
    };
    let fine = rest(helix.clone(), 1000);
    for (steps, tolerance) in [(7, 0.03), (11, 0.01), (21, 0.01), (42, 0.01)] {
        let found = rest(helix.in_blocks(steps).unwrap(), 24);
        let case = "ring of 189 bp, steps of 1998, Lk 18";
        verify(case, &format!("energy in blocks of {steps} over that of single steps"), found / fine, 1.0, tolerance);
    }
}

/// Half of a teardrop, from the middle of its loop, where the tangent stays, to where its ends meet: a point that
/// slides on the axis of symmetry, its rotation free. Twice its energy.
fn teardrop(length: f64, bending: f64, stretching: f64) -> f64 {
    let half = 0.5 * length;
    let shape = Shape::Arc {
        start: Vec3::zeros(),
        tangent: Vec3::x(),
        towards: Vec3::y(),
        radius: half / std::f64::consts::PI,
        angle: std::f64::consts::PI,
    };
    let section = Section::isotropic(bending, bending, stretching, stretching, 0.0);
    let rod = Rod::new("teardrop", &shape, RodMesh::open(60, 3), section, Natural::Straight).unwrap();
    let last = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    let slides = Support { node: last, position: [true, false, true], rotation: [false; 3] };
    let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 }), slides];
    let model = Model { rods: vec![rod], supports, contact: Contact::NONE, planar: true, ..Model::default() };
    let mut energy = 0.0;
    let solution = solve::run(model, &[], &Options::default(), &mut |progress| {
        energy = observe(progress).energies.total;
        std::ops::ControlFlow::Continue(())
    });
    assert_eq!(solution.unwrap().status, Status::Converged);
    2.0 * energy
}

/// Both ends at one point, free to turn: 14.0549512 B/L (elastica of modulus .9089085575). emDNA's 68 steps of IdealDNA
/// are softer by stretch, shear and their finite angles: (π/n)² of them, and .1 % by EA.
#[test]
fn teardrops() {
    verify("teardrop", "energy, B/L", teardrop(1.0, 1.0, 1e10), 14.054_951_2, 1e-6);
    let found = teardrop(68.0 * 0.34, 47.6598, 680.0);
    verify("teardrop of 68 bp of IdealDNA", "energy, kT", found, 28.921_921_333_8, 2e-3 * found);
}
