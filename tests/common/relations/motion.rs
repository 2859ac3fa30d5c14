//! Models changed in ways that leave the physics alone: turned, mirrored, shifted, in other units, in another order,
//! with an idle rod, cut and joined. Each comes with the way back from its numbers to those of the first model.

use supercoil::math::{Mat3, Quat, Vec3};
use supercoil::rod::{Natural, NaturalStrains, Rod, RodMesh, RodNumber, Section, Shape};
use supercoil::scene::{
    Joint, JointKind, LineLoad, Model, NodeLoad, NodeRef, Obstacle, ObstacleNumber, Pose, Ramp, Skeleton, Stage,
    Support, SupportChange,
};

/// A model with its stages.
#[derive(Debug, Clone)]
pub struct Problem {
    pub model: Model,
    pub stages: Vec<Stage>,
}

/// A changed problem and the way back.
#[derive(Debug, Clone)]
pub struct Variant {
    pub problem: Problem,
    /// Its matrix: a vector of the first problem times it is that of the changed one.
    pub matrix: Mat3,
    pub shift: Vec3,
    /// Units of length and force of the first problem in those of the changed one.
    pub length: f64,
    pub force: f64,
    /// For each rod and node of the first problem its node.
    pub nodes: Vec<Vec<NodeRef>>,
}

impl Variant {
    /// The same problem.
    pub fn same(problem: &Problem) -> Self {
        let nodes = problem.model.rods.iter().enumerate();
        let nodes = nodes.map(|(rod, it)| (0..it.num_nodes()).map(|node| NodeRef { rod, node }).collect()).collect();
        let (matrix, shift) = (Mat3::identity(), Vec3::zeros());
        Self { problem: problem.clone(), matrix, shift, length: 1.0, force: 1.0, nodes }
    }

    /// A position of the changed problem in the first one.
    pub fn position_back(&self, p: &Vec3) -> Vec3 {
        self.matrix.transpose() * (p - self.shift) / self.length
    }

    pub fn force_back(&self, f: &Vec3) -> Vec3 {
        self.matrix.transpose() * f / self.force
    }

    /// Moments are axial: a mirror reverses them.
    pub fn moment_back(&self, m: &Vec3) -> Vec3 {
        self.matrix.transpose() * m * (self.matrix.determinant().signum() / (self.force * self.length))
    }

    /// −1 for mirrors, which reverse link, twist and writhe.
    pub fn handedness(&self) -> f64 {
        self.matrix.determinant().signum()
    }
}

/// A rotation, or one with a mirror, and then a shift.
pub fn moved(problem: &Problem, matrix: Mat3, shift: Vec3) -> Variant {
    let motion = Motion { matrix, shift, hand: matrix.determinant().signum() };
    let Problem { model, stages } = problem;
    let mut out = Variant { matrix, shift, ..Variant::same(problem) };
    out.problem.model = Model {
        rods: model.rods.iter().map(|rod| motion.rod(rod)).collect(),
        supports: model.supports.iter().map(|support| motion.support(support)).collect(),
        joints: model.joints.iter().map(|it| Joint { kind: motion.joint(it.kind), ..*it }).collect(),
        loads: model
            .loads
            .iter()
            .map(|it| NodeLoad { force: matrix * it.force, moment: motion.axial(&it.moment), ..*it })
            .collect(),
        line_loads: model
            .line_loads
            .iter()
            .map(|it| LineLoad { force: matrix * it.force, moment: motion.axial(&it.moment), ..*it })
            .collect(),
        obstacles: model
            .obstacles
            .iter()
            .map(|it| mapped(it, |point| motion.point(point), |axis| matrix * axis))
            .collect(),
        ..model.clone()
    };
    out.problem.stages = change_stages(stages, |ramp| motion.ramp(ramp), |support| motion.support(support));
    out
}

/// All ramps changed, and all supports that stages set or take away.
fn change_stages(stages: &[Stage], of: impl Fn(&Ramp) -> Ramp, at: impl Fn(&Support) -> Support) -> Vec<Stage> {
    let change = |it: &SupportChange| match it {
        SupportChange::Hold(support) => SupportChange::Hold(at(support)),
        SupportChange::Release(support) => SupportChange::Release(at(support)),
    };
    let changed = |stage: &Stage| Stage {
        supports: stage.supports.iter().map(change).collect(),
        ramps: stage.ramps.iter().map(&of).collect(),
        steps: stage.steps,
    };
    stages.iter().map(changed).collect()
}

struct Motion {
    matrix: Mat3,
    shift: Vec3,
    hand: f64,
}

/// Signs of Γ1 Γ2 Γ3 K1 K2 K3 in a mirror. Frames stay right-handed because d1 is reversed.
const MIRRORED: [f64; 6] = [-1.0, 1.0, 1.0, 1.0, -1.0, -1.0];

impl Motion {
    fn point(&self, p: &Vec3) -> Vec3 {
        self.matrix * p + self.shift
    }

    fn axial(&self, m: &Vec3) -> Vec3 {
        self.hand * (self.matrix * m)
    }

    fn frame(&self, frame: &Quat) -> Quat {
        let d1 = Mat3::from_diagonal(&Vec3::new(self.hand, 1.0, 1.0));
        let axes = self.matrix * frame.to_rotation_matrix().matrix() * d1;
        Quat::from_rotation_matrix(&supercoil::nalgebra::Rotation3::from_matrix_unchecked(axes))
    }

    fn signs(&self) -> [f64; 6] {
        if self.hand < 0.0 { MIRRORED } else { [1.0; 6] }
    }

    fn rod(&self, rod: &Rod) -> Rod {
        let (signs, hand) = (self.signs(), self.hand);
        let mut out = rod.clone();
        out.positions = rod.positions.iter().map(|p| self.point(p)).collect();
        out.frames = rod.frames.iter().map(|frame| self.frame(frame)).collect();
        out.natural = match &rod.natural {
            Natural::Uniform { kappa: [k1, k2, k3] } => Natural::Uniform { kappa: [*k1, k2 * signs[4], k3 * signs[5]] },
            Natural::Varying(along) => Natural::Varying(
                along.map(1.0, move |_, strains| NaturalStrains::from_fn(|k, _| signs[k] * strains[k])),
            ),
            other => other.clone(),
        };
        let sign = move |i: usize, j: usize, it: f64| signs[i] * signs[j] * it;
        out.stiffness = rod.stiffness.as_ref().map(|along| along.map(1.0, move |_, c| c.map_with_location(sign)));
        out.start_excess_link *= hand;
        out.twist_put_in *= hand;
        out.shape_link *= hand;
        out.turns_left_out *= hand;
        out
    }

    /// Axes of the support in the turned scene: those onto which the matrix takes the old ones.
    fn support(&self, support: &Support) -> Support {
        let axes = |held: [bool; 3]| {
            let of = |k: usize| (0..3).any(|j| held[j] && self.matrix[(k, j)].abs() > 0.5);
            if held == [true; 3] || held == [false; 3] { held } else { [of(0), of(1), of(2)] }
        };
        Support { node: support.node, position: axes(support.position), rotation: axes(support.rotation) }
    }

    fn joint(&self, kind: JointKind) -> JointKind {
        match kind {
            JointKind::Hinge { axis } => JointKind::Hinge { axis: self.matrix * axis },
            other => other,
        }
    }

    fn ramp(&self, ramp: &Ramp) -> Ramp {
        let hand = self.hand;
        match ramp {
            Ramp::ExcessLink { rod, to } => Ramp::ExcessLink { rod: *rod, to: hand * to },
            Ramp::Rotation { node, axis, to } => Ramp::Rotation { node: *node, axis: self.axial(axis), to: *to },
            Ramp::RotationAbout { node, axis, through, to } => {
                Ramp::RotationAbout { node: *node, axis: self.axial(axis), through: self.point(through), to: *to }
            }
            Ramp::Displacement { node, to } => Ramp::Displacement { node: *node, to: self.matrix * to },
            Ramp::Pose { node, pose } => {
                let position = pose.position.map(|p| self.point(&p));
                let frame = pose.frame.map(|frame| self.frame(&frame));
                let (turns, half_turn) = (pose.turns.map(|turns| hand * turns), self.axial(&pose.half_turn));
                Ramp::Pose { node: *node, pose: Pose { position, frame, turns, half_turn, path: pose.path } }
            }
            Ramp::Number { rod, which: which @ (RodNumber::Curvature2 | RodNumber::Twist), to } => {
                Ramp::Number { rod: *rod, which: *which, to: hand * to }
            }
            other => other.clone(),
        }
    }
}

/// An obstacle whose points and axes are others.
fn mapped(it: &Obstacle, point: impl Fn(&Vec3) -> Vec3, axis: impl Fn(&Vec3) -> Vec3) -> Obstacle {
    let skeleton = match &it.skeleton {
        Skeleton::Plane { point: p, normal } => Skeleton::Plane { point: point(p), normal: axis(normal) },
        Skeleton::Point { point: p } => Skeleton::Point { point: point(p) },
        Skeleton::Line { point: p, axis: a } => Skeleton::Line { point: point(p), axis: axis(a) },
        Skeleton::Piece { .. } => it.skeleton,
    };
    assert!(it.hinge.is_none() && it.carrier.is_none(), "no relation has hinges, nor bodies that nodes carry");
    Obstacle { skeleton, ..it.clone() }
}

/// Rods and nodes renumbered in all that names them. Other lists are in the opposite order.
fn renumbered(problem: &Problem, rods: Vec<Rod>, nodes: Vec<Vec<NodeRef>>) -> Variant {
    let Problem { model, stages } = problem;
    let node = |it: NodeRef| nodes[it.rod][it.node];
    // of whole rods
    let rod = |it: usize| nodes[it][0].rod;
    let support = |it: &Support| Support { node: node(it.node), ..*it };
    let ramp = |it: &Ramp| match it.clone() {
        Ramp::ExcessLink { rod: it, to } => Ramp::ExcessLink { rod: rod(it), to },
        Ramp::Pressure { rod: it, to } => Ramp::Pressure { rod: rod(it), to },
        Ramp::Number { rod: it, which, to } => Ramp::Number { rod: rod(it), which, to },
        Ramp::Rotation { node: it, axis, to } => Ramp::Rotation { node: node(it), axis, to },
        Ramp::RotationAbout { node: it, axis, through, to } => {
            Ramp::RotationAbout { node: node(it), axis, through, to }
        }
        Ramp::Displacement { node: it, to } => Ramp::Displacement { node: node(it), to },
        Ramp::Pose { node: it, pose } => Ramp::Pose { node: node(it), pose },
        other => other,
    };
    let mut out = Variant::same(problem);
    out.problem.model = Model {
        rods,
        supports: model.supports.iter().rev().map(support).collect(),
        joints: model.joints.iter().rev().map(|it| Joint { a: node(it.a), b: node(it.b), ..*it }).collect(),
        loads: model.loads.iter().rev().map(|it| NodeLoad { node: node(it.node), ..*it }).collect(),
        line_loads: model.line_loads.iter().rev().map(|it| LineLoad { rod: rod(it.rod), ..*it }).collect(),
        ..model.clone()
    };
    out.problem.stages = change_stages(stages, ramp, support);
    out.nodes = nodes;
    out
}

/// Rods in the opposite order under other names.
pub fn reordered(problem: &Problem) -> Variant {
    let rods = &problem.model.rods;
    let last = rods.len() - 1;
    let renamed = |(index, rod): (usize, &Rod)| Rod { name: format!("another {index}"), ..rod.clone() };
    let nodes = rods.iter().enumerate();
    let nodes = nodes.map(|(rod, it)| (0..it.num_nodes()).map(|node| NodeRef { rod: last - rod, node }).collect());
    renumbered(problem, rods.iter().rev().enumerate().map(renamed).collect(), nodes.collect())
}

/// Distance of the idle rod in lengths of the first.
const FAR: f64 = 40.0;

/// Thickness of the idle rod over that of the thickest, so that it stays thicker where a radius is ramped.
const THICKER: f64 = 1.5;

/// Bending stiffness of the idle rod over that of the stiffest, so that it stays stiffer where stiffness is ramped.
const STIFFER: f64 = 2.0;

/// With a clamped, straight, unloaded rod far away and above all planes, before all others. It is thicker and stiffer
/// than the thickest and stiffest, and meshed as finely, so that the contact law is the same.
pub fn with_idle_rod(problem: &Problem) -> Variant {
    let rods = &problem.model.rods;
    let most = |of: &dyn Fn(&Rod) -> f64| rods.iter().map(of).fold(0.0, f64::max);
    let bending = most(&|rod| rod.section.bending[0].max(rod.section.bending[1]));
    let stretching = most(&|rod| rod.section.stretching);
    let radius = THICKER * most(&|rod| rod.section.contact_radius);
    let bending = STIFFER * bending;
    let section = Section::isotropic(bending, bending, stretching, stretching, radius);
    let spacing = rods.iter().map(Rod::spacing).fold(f64::INFINITY, f64::min);
    let length = rods[0].length;
    let normal = |obstacle: &Obstacle| match obstacle.skeleton {
        Skeleton::Plane { normal, .. } => Some(normal),
        _ => None,
    };
    let up: Vec3 = problem.model.obstacles.iter().filter_map(normal).sum();
    let start = rods[0].positions[0] + (Vec3::x() * FAR + up) * length;
    let line = Shape::Line { start, direction: Vec3::x(), length };
    let elements = (length / spacing / 3.0).ceil() as usize + 1;
    let idle = Rod::new("idle", &line, RodMesh::open(elements, 3), section, Natural::Straight);
    let idle = idle.unwrap_or_else(|error| panic!("{error}"));
    let nodes = rods.iter().enumerate();
    let nodes = nodes.map(|(rod, it)| (0..it.num_nodes()).map(|node| NodeRef { rod: rod + 1, node }).collect());
    let all = std::iter::once(idle).chain(rods.iter().cloned()).collect();
    let mut out = renumbered(problem, all, nodes.collect());
    out.problem.model.supports.push(Support::clamp(NodeRef { rod: 0, node: 0 }));
    out
}

/// The first rod, uniform and without contact, cut in two at an element and joined; a ring cut at its seam. `None`
/// where that does not make the same problem.
pub fn cut(problem: &Problem) -> Option<Variant> {
    let (model, rod) = (&problem.model, &problem.model.rods[0]);
    let uniform = rod.stiffness.is_none() && rod.contact_radii.is_none();
    let natural = matches!(rod.natural, Natural::Straight | Natural::Uniform { .. });
    let contact = model.contact.law.is_on() && rod.section.contact_radius > 0.0;
    let of_whole = |ramp: &Ramp| matches!(ramp, Ramp::ExcessLink { .. } | Ramp::Pressure { .. } | Ramp::Number { .. });
    let wound = problem.stages.iter().flat_map(|stage| &stage.ramps).any(of_whole);
    if !uniform || !natural || contact || wound {
        return None;
    }
    if rod.closed { cut_ring(problem) } else { Some(cut_open(problem)) }
}

/// Nodes of the first rod from `from` to `to`, both included.
fn part(rod: &Rod, name: &str, [from, to]: [usize; 2]) -> Rod {
    let count = rod.num_nodes();
    let take = |k: usize| k % count;
    let mut out = rod.clone();
    name.clone_into(&mut out.name);
    out.closed = false;
    out.positions = (from..=to).map(|k| rod.positions[take(k)]).collect();
    out.frames = (from..=to).map(|k| rod.frames[take(k)]).collect();
    out.num_elements = (to - from) / rod.order;
    out.length = rod.spacing() * (to - from) as f64;
    (out.start_excess_link, out.twist_put_in, out.shape_link) = (0.0, 0.0, 0.0);
    out
}

fn cut_open(problem: &Problem) -> Variant {
    let rods = &problem.model.rods;
    let (rod, last) = (&rods[0], rods.len());
    let (at, end) = (rod.order * (rod.num_elements * 2 / 3), rod.num_nodes() - 1);
    let mut all = rods.clone();
    all[0] = part(rod, "front", [0, at]);
    all.push(part(rod, "back", [at, end]));
    let mut nodes = Variant::same(problem).nodes;
    (at + 1..=end).for_each(|node| nodes[0][node] = NodeRef { rod: last, node: node - at });
    let mut out = renumbered(problem, all, nodes);
    out.problem.model.joints.push(Joint::rigid(NodeRef { rod: 0, node: at }, NodeRef { rod: last, node: 0 }));
    let more: Vec<LineLoad> = problem
        .model
        .line_loads
        .iter()
        .filter(|load| load.rod == 0)
        .map(|load| LineLoad { rod: last, ..*load })
        .collect();
    out.problem.model.line_loads.extend(more);
    out
}

fn cut_ring(problem: &Problem) -> Option<Variant> {
    let rod = &problem.model.rods[0];
    // the seam of a flat ring with frames that close is like any other node
    if rod.start_excess_link != 0.0 {
        return None;
    }
    let count = rod.num_nodes();
    let mut rods = problem.model.rods.clone();
    rods[0] = part(rod, "cut", [0, count]);
    let mut out = renumbered(problem, rods, Variant::same(problem).nodes);
    out.problem.model.joints.push(Joint::rigid(NodeRef { rod: 0, node: 0 }, NodeRef { rod: 0, node: count }));
    Some(out)
}

/// Lengths and forces in other units, `factor` times as many.
pub fn in_units(problem: &Problem, factor: f64) -> Variant {
    let Problem { model, stages } = problem;
    let (f, square, cube) = (factor, factor * factor, factor.powi(3));
    let rod = |rod: &Rod| {
        let mut out = rod.clone();
        out.section = Section {
            shearing: rod.section.shearing.map(|it| f * it),
            stretching: f * rod.section.stretching,
            bending: rod.section.bending.map(|it| cube * it),
            twisting: cube * rod.section.twisting,
            contact_radius: f * rod.section.contact_radius,
        };
        // F for strains 1 to 3, F L between the two kinds, F L² for curvatures
        let unit = move |k: usize| if k < 3 { 1.0 } else { f };
        out.stiffness = rod
            .stiffness
            .as_ref()
            .map(|along| along.map(f, move |_, c| c.map_with_location(|i, j, it| f * unit(i) * unit(j) * it)));
        out.contact_radii = rod.contact_radii.as_ref().map(|along| along.map(f, move |_, radius| f * radius));
        out.natural = match &rod.natural {
            Natural::Uniform { kappa } => Natural::Uniform { kappa: kappa.map(|k| k / f) },
            Natural::Varying(along) => {
                Natural::Varying(along.map(f, move |_, strains| NaturalStrains::from_fn(|k, _| strains[k] / unit(k))))
            }
            other => other.clone(),
        };
        out.length *= f;
        out.positions.iter_mut().for_each(|p| *p *= f);
        out
    };
    let ramp = |ramp: &Ramp| match ramp.clone() {
        Ramp::RotationAbout { node, axis, through, to } => Ramp::RotationAbout { node, axis, through: f * through, to },
        Ramp::Displacement { node, to } => Ramp::Displacement { node, to: f * to },
        Ramp::Pose { node, pose } => Ramp::Pose { node, pose: Pose { position: pose.position.map(|p| f * p), ..pose } },
        Ramp::Obstacle { obstacle, which, to } if which != ObstacleNumber::Turns => {
            Ramp::Obstacle { obstacle, which, to: f * to }
        }
        // F/L is the same
        Ramp::Number { rod, which, to } => Ramp::Number { rod, which, to: to * unit_of(which, f) },
        other => other,
    };
    let mut out = Variant { length: f, force: f, ..Variant::same(problem) };
    out.problem.model = Model {
        rods: model.rods.iter().map(rod).collect(),
        loads: model
            .loads
            .iter()
            .map(|it| NodeLoad { force: f * it.force, moment: square * it.moment, ..*it })
            .collect(),
        line_loads: model.line_loads.iter().map(|it| LineLoad { moment: f * it.moment, ..*it }).collect(),
        obstacles: model
            .obstacles
            .iter()
            .map(|it| Obstacle { radius: f * it.radius, ..mapped(it, |point| f * point, |axis| *axis) })
            .collect(),
        electrostatics: model.electrostatics.map(|mut it| {
            it.strength *= f;
            it.debye_length *= f;
            it
        }),
        ..model.clone()
    };
    out.problem.stages = change_stages(stages, ramp, |support| *support);
    out
}

/// Unit of a number of a rod where those of length and force are multiplied by `f`.
fn unit_of(which: RodNumber, f: f64) -> f64 {
    match which {
        RodNumber::ContactRadius
        | RodNumber::Length
        | RodNumber::Stretching
        | RodNumber::Shearing1
        | RodNumber::Shearing2 => f,
        RodNumber::Bending1 | RodNumber::Bending2 | RodNumber::Twisting => f.powi(3),
        RodNumber::Curvature1 | RodNumber::Curvature2 | RodNumber::Twist => f.recip(),
        RodNumber::Binding => 1.0,
    }
}
