//! Balance of forces and moments.
//!
//! ```text
//! node       Σ_elements ∫ N_a′ n ds = f_a + s_a          Σ ∫ A_a′ᵀ m − A_aᵀ (r′ × n) ds = l_a + t_a
//! contact    the same, summed over the nodes that a contact acts on, with the force and the moment reported for it
//! body       Σ f + Σ s + Σ c = 0                          Σ x × f + l + x × s + t + x × c + d = 0
//! joint      Σ j = 0                                      Σ k = 0 over nodes that share rotation; e·k = 0 of a hinge
//! energies   ½ ∫ σ·(ε − ε₀) ds by kind, the sum of which has the forces of nodes as its derivative
//! ```
//!
//! n and m are the stress resultants in space, φ = Σ A_a θ_a the rotation of the interpolated frame, f and l loads, s
//! and t reactions of supports and joints, c and d contact forces with their moments, as reported; j and k are those of
//! joints alone, e the axis of a hinge. A body is a rod; its balance needs no elements.
//!
//! Forces are compared with the largest sum of the sizes of all forces on a node, moments with that times the node
//! spacing, or the extent of a contact or body. The sums are those of the weak form, node by node, by the rule that
//! integrates the energy: no mesh leaves a rest in them. What is left is what the solver's search leaves: rounding
//! without contact, up to 1e-4 with it.

use super::strains::{MaterialMatrix, PlacedRod, element_length, rule};
use super::{Check, ContactForce, Counterpart, Subject, SupportForce, Worst, first_nodes, node_name};
use crate::math::quadrature::gauss;
use crate::math::{Vec3, parallel};
use crate::rod::{Deformation, ElasticEnergies, Rod};
use crate::scene::{Model, NodeRef};

/// Force out of balance over the largest one, without contact: Newton's method squares increments, and searches that
/// end along neutral directions balance forces to 1e-8; ten times that. All scenes of the relations have 1e-13.
const FREE: f64 = 1e-7;
/// The same where contact bears a force: contact is so stiff that an increment below the tolerance changes it, so
/// searches end when forces are in balance to 1e-4 of the largest contact force, the fifth part of what the most exact
/// preset states.
const IN_CONTACT: f64 = 1e-4;
/// Where contact bears a force, over the tolerance of increments: searches end when an increment changes contact forces
/// by ten times that, of which an iteration that contracts leaves less; ten times that.
const OF_INCREMENTS: f64 = 100.0;
/// Rotation, rad, that contact forces cause which searches leave out of balance: those of strands that touch without
/// load.
const BENDS_NOTHING: f64 = 1e-6;
/// Units in the last place by which forces on nodes are rounded: ten of each strain, a sum of that many products, times
/// the sum of |N_a′| over the elements at a node, up to eight.
const LAST_PLACES: f64 = 80.0;

/// Rounding of a sum over elements, over the sum.
const TOL_SUM: f64 = 1e-12;

/// Force and moment on each node, and the sum of the sizes of what is summed \[F\].
struct NodalForces {
    force: Vec<Vec3>,
    /// About the node.
    moment: Vec<Vec3>,
    size: Vec<f64>,
}

impl NodalForces {
    fn none(num_nodes: usize) -> Self {
        let zeros = vec![Vec3::zeros(); num_nodes];
        Self { force: zeros.clone(), moment: zeros, size: vec![0.0; num_nodes] }
    }

    fn add(&mut self, node: usize, force: Vec3, moment: Vec3, spacing: f64) {
        self.force[node] += force;
        self.moment[node] += moment;
        self.size[node] += force.norm() + moment.norm() / spacing;
    }
}

pub(super) fn checks(subject: &Subject) -> Vec<Check> {
    let Some(contact) = subject.contact else { return Vec::new() };
    let first = first_nodes(subject.model);
    let mut outer = NodalForces::none(subject.state.positions().len());
    add_loads(subject, &first, &mut outer);
    add_reactions(subject, &first, &mut outer);
    let charged = subject.model.electrostatics.is_some();
    let mut all = NodalForces { force: outer.force.clone(), moment: outer.moment.clone(), size: outer.size.clone() };
    let stored = subtract_inner(subject, &first, &mut all);
    let scale = Scale::of(subject, &all, contact);
    let of_nodes = (!charged).then(|| nodes(subject, (&first, contact), all, &scale));
    let of_bodies = bodies(subject, (&first, contact), &outer, &scale);
    let of_joints = joints(subject, &first, &scale);
    of_nodes.into_iter().chain([of_bodies]).chain(of_joints).chain([energies(subject, &stored)]).collect()
}

/// The largest force on a node \[F\], and the part of it that may be out of balance. Rounding of forces, and what bends
/// no rod, count as so large a force that they are this part of it.
struct Scale {
    force: f64,
    tolerance: f64,
}

impl Scale {
    fn of(subject: &Subject, all: &NodalForces, contact: &[ContactForce]) -> Self {
        let of_nodes = all.size.iter().copied().fold(0.0, f64::max);
        let force = contact.iter().map(|at| at.force.norm()).fold(of_nodes, f64::max);
        let stiffest = subject.model.rods.iter().map(|rod| {
            let (s, h) = (&rod.section, rod.spacing());
            let stiffest = s.shearing.iter().chain([&s.stretching]).copied().fold(0.0, f64::max);
            let bending = s.bending.iter().chain([&s.twisting]).copied().fold(0.0, f64::max);
            stiffest + bending / (h * h)
        });
        // force of a strain of 1, or of a radian between nodes
        let stiffest = stiffest.fold(0.0, f64::max);
        let rounding = LAST_PLACES * f64::EPSILON * (stiffest + Self::of_gaps(subject.model, contact));
        let tol_increment = subject.given.map_or(0.0, |(given, ..)| given.tol_increment);
        let touches = contact.iter().any(|at| at.force != Vec3::zeros());
        let tolerance = if touches { IN_CONTACT.max(OF_INCREMENTS * tol_increment) } else { FREE };
        let softest = subject.model.rods.iter().map(|rod| rod.section.smaller_bending() / rod.length.powi(2));
        let unfelt = if touches { BENDS_NOTHING * softest.fold(f64::INFINITY, f64::min) } else { 0.0 };
        // forces that are all rounding balance to rounding; strains of increments are squared
        let nothing = rounding + unfelt + tol_increment * tol_increment * stiffest;
        Self { force: force + nothing / tolerance, tolerance }
    }

    /// Force of contact with obstacles, on a node, of overlaps as large as the coordinate along the normal \[F\]: what
    /// the rounding of overlaps is a part of. (Between strands overlaps are those of coordinates near by.)
    fn of_gaps(model: &Model, contact: &[ContactForce]) -> f64 {
        let at_obstacles = contact.iter().filter(|at| matches!(at.partner, Counterpart::Obstacle(_)));
        let along_normal =
            |at: &ContactForce| at.force.try_normalize(0.0).map_or(0.0, |normal| at.at.dot(&normal).abs());
        let reach = at_obstacles.map(along_normal).fold(0.0, f64::max);
        let touching = || model.rods.iter().filter(|rod| rod.section.contact_radius > 0.0);
        let smallest = |of: fn(&Rod) -> f64| touching().map(of).fold(f64::INFINITY, f64::min);
        let radius = smallest(Rod::least_contact_radius);
        let bending = smallest(|rod| rod.section.smaller_bending()) / radius.powi(2);
        let spacing = touching().map(Rod::spacing).fold(0.0, f64::max);
        let stiffness = model.contact.law.stiffness().unwrap_or(0.0);
        if reach > 0.0 { stiffness * bending * (spacing / radius) * (reach / radius) } else { 0.0 }
    }
}

/// Dead forces and moments, line loads ∫ N_a f ds and pressure ±∫ N_a p ẑ × r′ ds, minus for shapes given clockwise.
fn add_loads(subject: &Subject, first: &[usize], out: &mut NodalForces) {
    let (model, state) = (subject.model, subject.state);
    let factor = state.load_factor();
    for load in &model.loads {
        let spacing = model.rods[load.node.rod].spacing();
        out.add(first[load.node.rod] + load.node.node, load.force * factor, load.moment * factor, spacing);
    }
    let exact = gauss(3);
    for (k, rod) in model.rods.iter().enumerate() {
        let along: Vec<_> = model.line_loads.iter().filter(|load| load.rod == k).collect();
        let pressure = state.pressures()[k] * sense(&rod.positions);
        if along.is_empty() && pressure == 0.0 {
            continue;
        }
        let (force, moment) = along.iter().fold((Vec3::zeros(), Vec3::zeros()), |sum, load| {
            (sum.0 + load.force * factor, sum.1 + load.moment * factor)
        });
        let shape = PlacedRod::of(state, (k, rod), first[k]);
        for element in 0..rod.num_elements {
            let nodes = shape.nodes(element);
            for (&xi, &w) in exact.points.iter().zip(exact.weights) {
                let point = nodes.at(rod.order, element_length(rod), xi, w);
                for a in 0..=rod.order {
                    let share = point.n[a] * point.weight;
                    let here = force + Vec3::z().cross(&point.slope) * pressure;
                    out.add(first[k] + nodes.index[a], here * share, moment * share, rod.spacing());
                }
            }
        }
    }
}

/// Sign of the area that a shape encloses: pressure pushes inwards whichever way a ring runs.
fn sense(shape: &[Vec3]) -> f64 {
    let next = shape.iter().cycle().skip(1);
    shape.iter().zip(next).map(|(a, b)| (a - shape[0]).cross(&(b - a)).z).sum::<f64>().signum()
}

/// Reactions and forces of joints.
fn add_reactions(subject: &Subject, first: &[usize], out: &mut NodalForces) {
    for at in subject.reactions.iter().chain(subject.joints) {
        let spacing = subject.model.rods[at.node.rod].spacing();
        out.add(first[at.node.rod] + at.node.node, at.force, at.moment, spacing);
    }
}

/// Energy of elements by kind, and the rounding of it \[F·L\].
#[derive(Debug, Clone, Copy, Default)]
struct Stored {
    kinds: ElasticEnergies,
    rounding: f64,
}

impl Stored {
    /// Adds ½ σ·ε of a point; strains are rounded by some units in the last place, curvatures by that over the node
    /// spacing.
    fn add(&mut self, stress: &[f64; 6], elastic: &[f64; 6], (weight, spacing): (f64, f64)) {
        for (k, kind) in Deformation::OF_STRAINS.into_iter().enumerate() {
            self.kinds.add(kind, 0.5 * weight * stress[k] * elastic[k]);
            let unit = if k < 3 { 1.0 } else { spacing };
            self.rounding += weight * stress[k].abs() * LAST_PLACES * f64::EPSILON / unit;
        }
    }

    fn add_all(&mut self, other: &Self) {
        self.kinds += other.kinds;
        self.rounding += other.rounding;
    }
}

/// Energies as reported against the elements' own.
fn energies(subject: &Subject, own: &Stored) -> Check {
    let total = own.kinds.total();
    let softest = |rod: &Rod| {
        let strain = LAST_PLACES * f64::EPSILON;
        rod.section.stretching * rod.length * strain * strain
    };
    let rounding = own.rounding + subject.model.rods.iter().map(softest).sum::<f64>();
    let mut worst = Worst::none();
    for kind in Deformation::ALL {
        let (own, reported) = (own.kinds.of(kind), subject.energies.of(kind));
        worst.add((own - reported).abs() / (total + rounding), || kind.name().to_owned());
    }
    let tolerance = (TOL_SUM * total + rounding) / (total + rounding);
    Check::new("energies", worst.value, tolerance, worst.detail("of the elastic energy"))
}

/// Forces of the elements on their nodes: minus the derivative of their energy, which is returned.
fn subtract_inner(subject: &Subject, first: &[usize], out: &mut NodalForces) -> Stored {
    let mut stored = Stored::default();
    for (k, rod) in subject.model.rods.iter().enumerate() {
        let (shape, law) = (PlacedRod::of(subject.state, (k, rod), first[k]), MaterialMatrix::of(rod));
        let rule = rule(rod);
        let of_element = |element: usize| {
            let nodes = shape.nodes(element);
            let mut forces = [(Vec3::zeros(), Vec3::zeros()); 4];
            let (mut sizes, mut stored) = ([0.0; 4], Stored::default());
            for (g, (&xi, &w)) in rule.points.iter().zip(rule.weights).enumerate() {
                let point = nodes.at(rod.order, element_length(rod), xi, w);
                let (s, elastic) = law.stress(element, g, &point.strain());
                stored.add(&s, &elastic, (point.weight, rod.spacing()));
                let frame = point.frame();
                let (n, m) = (frame * Vec3::new(s[0], s[1], s[2]), frame * Vec3::new(s[3], s[4], s[5]));
                for a in 0..=rod.order {
                    let (force, moment) = point.node_force(a, &nodes.q[a], &n, &m);
                    forces[a] = (forces[a].0 + force, forces[a].1 + moment);
                    sizes[a] += force.norm() + moment.norm() / rod.spacing();
                }
            }
            (nodes.index, forces, sizes, stored)
        };
        for (index, forces, sizes, of_element) in parallel::map(rod.num_elements, parallel::CHEAP, &of_element) {
            stored.add_all(&of_element);
            for a in 0..=rod.order {
                let node = first[k] + index[a];
                out.force[node] -= forces[a].0;
                out.moment[node] -= forces[a].1;
                out.size[node] += sizes[a];
            }
        }
    }
    stored
}

/// Nodes that contacts act on, one mark for each stretch of them.
struct Stretches {
    /// By node; 0 where there is no contact.
    mark: Vec<usize>,
    count: usize,
}

impl Stretches {
    /// The curves of contact between two nodes depend on the elements of these: an element more on both sides.
    fn of(model: &Model, first: &[usize], contact: &[ContactForce]) -> Self {
        let mut touched = vec![false; first[model.rods.len()]];
        for at in contact {
            let rod = &model.rods[at.rod];
            let (count, spacing) = (rod.num_nodes(), rod.spacing());
            let [start, end] = at.arc;
            let end = if end < start { end + rod.length } else { end };
            let pad = rod.order as f64 + 1.0;
            let (low, high) = ((start / spacing - pad).floor() as isize, (end / spacing + pad).ceil() as isize);
            let count = count as isize;
            let (low, high) =
                if rod.closed { (low, high.min(low + count - 1)) } else { (low.max(0), high.min(count - 1)) };
            for k in low..=high {
                touched[first[at.rod] + k.rem_euclid(count) as usize] = true;
            }
        }
        let mut mark = vec![0; touched.len()];
        let mut count = 0;
        for (k, rod) in model.rods.iter().enumerate() {
            let nodes = first[k]..first[k + 1];
            for node in nodes.clone().filter(|&node| touched[node]) {
                if node == nodes.start || !touched[node - 1] {
                    count += 1;
                }
                mark[node] = count;
            }
            let (start, end) = (mark[nodes.start], mark[nodes.end - 1]);
            if rod.closed && start > 0 && end > 0 && start != end {
                mark[nodes].iter_mut().filter(|mark| **mark == end).for_each(|mark| *mark = start);
            }
        }
        Self { mark, count }
    }
}

/// Forces about a point.
#[derive(Debug, Clone, Copy)]
struct Wrench {
    at: Vec3,
    force: Vec3,
    moment: Vec3,
    /// Largest distance of a force from the point \[L\].
    extent: f64,
    place: NodeRef,
}

impl Wrench {
    fn about(at: Vec3, extent: f64, place: NodeRef) -> Self {
        Self { at, force: Vec3::zeros(), moment: Vec3::zeros(), extent, place }
    }

    fn add(&mut self, at: &Vec3, force: &Vec3, moment: &Vec3) {
        let arm = at - self.at;
        self.force += force;
        self.moment += moment + arm.cross(force);
        self.extent = self.extent.max(arm.norm());
    }

    /// The larger of force and moment over the extent, over a force.
    fn over(&self, force: f64) -> f64 {
        let sizes = [self.force.norm(), self.moment.norm() / self.extent].map(|size| size / force);
        if sizes[0] > sizes[1] { sizes[0] } else { sizes[1] }
    }
}

/// Balance of nodes, or of the stretches of nodes that contacts act on.
fn nodes(subject: &Subject, (first, contact): (&[usize], &[ContactForce]), all: NodalForces, scale: &Scale) -> Check {
    let (model, state) = (subject.model, subject.state);
    let stretches = Stretches::of(model, first, contact);
    let mut of_stretches: Vec<Option<Wrench>> = vec![None; stretches.count + 1];
    let mut worst = Worst::none();
    let mut index = 0;
    for (k, rod) in model.rods.iter().enumerate() {
        for node in 0..rod.num_nodes() {
            let place = NodeRef { rod: k, node };
            let (mut force, mut moment) = (all.force[index], all.moment[index]);
            leave_out_held(model, (&mut force, &mut moment));
            let at = &state.positions()[index];
            let start = || Wrench::about(*at, rod.spacing(), place);
            match stretches.mark[index] {
                0 => {
                    let mut one = start();
                    one.add(at, &force, &moment);
                    worst.add(one.over(scale.force), || node_name(model, place));
                }
                mark => of_stretches[mark].get_or_insert_with(start).add(at, &force, &moment),
            }
            index += 1;
        }
    }
    for at in contact {
        let rod = &model.rods[at.rod];
        let node = (at.arc[0] / rod.spacing()).floor().max(0.0) as usize;
        let mark = stretches.mark[first[at.rod] + node.min(rod.num_nodes() - 1)];
        of_stretches[mark].iter_mut().for_each(|sum| sum.add(&at.at, &at.force, &at.moment));
    }
    for sum in of_stretches.into_iter().flatten() {
        worst.add(sum.over(scale.force), || format!("contacts of {}", node_name(model, sum.place)));
    }
    Check::new("balance of nodes", worst.value, scale.tolerance, worst.detail("of the largest force"))
}

/// Leaves out what is held without a reaction being reported: out of the plane of a planar model.
fn leave_out_held(model: &Model, (force, moment): (&mut Vec3, &mut Vec3)) {
    if model.planar {
        force.z = 0.0;
        (moment.x, moment.y) = (0.0, 0.0);
    }
}

/// Balance of the forces that each joint exerts. What it does not hold it exerts no moment on: rods that a pin joins
/// turn on their own, those that a hinge joins about its axis.
fn joints(subject: &Subject, first: &[usize], scale: &Scale) -> Option<Check> {
    let (model, state) = (subject.model, subject.state);
    let mut worst = Worst::none();
    let mut sum = |nodes: &[NodeRef], of: &dyn Fn(&SupportForce) -> f64, over: f64| {
        let total: f64 = subject.joints.iter().filter(|at| nodes.contains(&at.node)).map(of).sum();
        worst.add(total.abs() / (scale.force * over), || node_name(model, nodes[0]));
    };
    for joint in &model.joints {
        let lever = model.rods[joint.a.rod].spacing();
        // in a plane forces lie in it and moments are across it
        let (forces, moments) = if model.planar { (0..2, 2..3) } else { (0..3, 0..3) };
        let joined = model.joined_nodes(joint.a);
        forces.for_each(|k| sum(&joined, &|at| at.force[k], 1.0));
        for end in [joint.a, joint.b] {
            let hinged = model.hinged_nodes(end);
            moments.clone().for_each(|k| sum(&hinged, &|at| at.moment[k], lever));
            let rod = &model.rods[end.rod];
            let turn = state.frames()[first[end.rod] + end.node] * rod.frames[end.node].inverse();
            if let Some(axis) = model.hinge_axis(joint).map(|axis| turn * axis) {
                sum(&model.turning_nodes(end), &|at| at.moment.dot(&axis), lever);
            }
        }
    }
    (!model.joints.is_empty())
        .then(|| Check::new("balance of joints", worst.value, scale.tolerance, worst.detail("of the largest force")))
}

/// Balance of each rod; of all together where charges repel each other.
fn bodies(
    subject: &Subject,
    (first, contact): (&[usize], &[ContactForce]),
    outer: &NodalForces,
    scale: &Scale,
) -> Check {
    let (model, state) = (subject.model, subject.state);
    let body = |rod: usize| if model.electrostatics.is_some() { 0 } else { rod };
    let bodies: Vec<usize> = (0..model.rods.len()).map(body).collect();
    let mut sums: Vec<Option<Wrench>> = vec![None; model.rods.len()];
    for (k, rod) in model.rods.iter().enumerate() {
        for node in 0..rod.num_nodes() {
            let (index, place) = (first[k] + node, NodeRef { rod: k, node });
            let at = &state.positions()[index];
            let sum = sums[bodies[k]].get_or_insert_with(|| Wrench::about(*at, rod.spacing(), place));
            let (mut force, mut moment) = (outer.force[index], outer.moment[index]);
            leave_out_held(model, (&mut force, &mut moment));
            sum.add(at, &force, &moment);
        }
    }
    for at in contact {
        sums[bodies[at.rod]].iter_mut().for_each(|sum| sum.add(&at.at, &at.force, &at.moment));
    }
    let mut worst = Worst::none();
    for sum in sums.into_iter().flatten() {
        worst.add(sum.over(scale.force), || format!("rod \"{}\"", model.rods[sum.place.rod].name));
    }
    Check::new("balance of bodies", worst.value, scale.tolerance, worst.detail("of the largest force"))
}
