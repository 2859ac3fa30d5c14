//! Relations: what may be changed of a scene without changing its state, and how near the states must be.

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::math::{Mat3, Quat, Vec3};
use supercoil::scene::{Fidelity, Model, Ramp, Stage, Support};
use supercoil::solve::{Restart, run_from};

use super::super::random::Random;
use super::draft::{Draft, Mesh};
use super::file;
use super::measure::{Quantity, Run, Scales, State, differences, options, play, play_with, shown};
use super::motion::{Problem, Variant, cut, in_units, moved, reordered, with_idle_rod};
use super::work;

/// A relation of a scene to itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Relation {
    /// The scene comes to rest.
    Converges,
    /// Turned at random and shifted.
    Turned,
    /// Laid along each axis.
    Laid,
    /// Mirrored.
    Mirrored,
    /// Rods and lists in the opposite order, other names.
    Reordered,
    /// With an idle rod far away.
    Idle,
    /// Its rod cut in two and joined.
    Cut,
    /// In units 64 times as small.
    Units,
    /// In 2 and in 5 steps a stage.
    Steps,
    /// The last stage there and back.
    Back,
    /// Taken up after its first stage from what was written.
    Resumed,
    /// Written to a file and read back.
    File,
    /// Energy gained is work done.
    Work,
    /// On twice as many elements, quadratic or cubic.
    Finer,
    /// On twice as many linear elements.
    FinerLinear,
    /// The presets, against `reference`.
    Presets,
}

impl Relation {
    pub const ALL: [Self; 16] = [
        Self::Converges,
        Self::Turned,
        Self::Laid,
        Self::Mirrored,
        Self::Reordered,
        Self::Idle,
        Self::Cut,
        Self::Units,
        Self::Steps,
        Self::Back,
        Self::Resumed,
        Self::File,
        Self::Work,
        Self::Finer,
        Self::FinerLinear,
        Self::Presets,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Converges => "converges",
            Self::Turned => "turned at random",
            Self::Laid => "laid along each axis",
            Self::Mirrored => "mirrored",
            Self::Reordered => "rods reordered",
            Self::Idle => "idle rod far away",
            Self::Cut => "cut and joined",
            Self::Units => "units × 64",
            Self::Steps => "2 and 5 steps",
            Self::Back => "there and back",
            Self::Resumed => "after a restart",
            Self::File => "from a file",
            Self::Work => "energy and work",
            Self::Finer => "twice the elements",
            Self::FinerLinear => "twice the linear elements",
            Self::Presets => "presets",
        }
    }

    /// Largest difference of a quantity for which two states agree, without and with contact that bears a force.
    pub fn tolerance(self, quantity: Quantity, bears: bool) -> f64 {
        // of a state that is exact but for Newton's last increment, 1e-8 of the spacing of nodes: what is quadratic in
        // it is far below; a force that stretches a rod is not, EA times as large, 4e3 B/L² here. With contact searches
        // end when forces are in balance to 1e-4 of the largest contact force, each of the two
        let increment = if bears { [2e-4, 1e-5, 2e-4, 2e-4, 1e-5] } else { [1e-7, 1e-7, 1e-5, 1e-5, 1e-7] };
        let [energy, position, reaction, contact, link] = match self {
            Self::Converges => [0.0; 5],
            // the error of the trapezoidal rule with 12 steps a stage, extrapolated but for the step in which contact
            // begins
            Self::Work if bears => [1e-2; 5],
            Self::Work => [1e-3; 5],
            // the error of the coarser mesh, on which neighbouring nodes turn by a tenth of a radian and contact moves
            // by a part of a segment; linear elements have an error of second order
            Self::Finer => [1e-2, 1e-2, 2e-2, 2e-2, 1e-2],
            Self::FinerLinear => [5e-2, 2e-2, 1e-1, 1e-1, 5e-2],
            // parts of what both presets state
            Self::Presets => [1.0; 5],
            _ => increment,
        };
        match quantity {
            Quantity::Energy => energy,
            Quantity::Position => position,
            Quantity::Reaction => reaction,
            Quantity::Contact => contact,
            Quantity::Link => link,
            Quantity::Ending => 0.0,
        }
    }
}

/// A comparison that was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    pub relation: Relation,
    pub quantity: Quantity,
    /// Whether contact bears a force in one of the states.
    pub bears: bool,
    pub size: f64,
}

impl Difference {
    pub fn agrees(&self) -> bool {
        self.size <= self.relation.tolerance(self.quantity, self.bears)
    }
}

/// All that a scene was found to be.
#[derive(Debug, Clone)]
pub struct Findings {
    pub name: String,
    /// The largest difference of each quantity under each relation.
    pub differences: Vec<Difference>,
    /// Why runs did not come to rest.
    pub notes: Vec<String>,
    /// Largest value of each check of the certificate, without and with contact that bears a force.
    pub checks: Vec<(String, [f64; 2])>,
}

impl Findings {
    /// Relations that do not hold.
    pub fn broken(&self) -> Vec<Relation> {
        let mut found: Vec<Relation> =
            self.differences.iter().filter(|it| !it.agrees()).map(|it| it.relation).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    fn look_at(&mut self, state: &State) {
        let bears = usize::from(state.seen.total_contact_force > 0.0);
        for check in &state.seen.certificate.checks {
            let at = self.checks.iter().position(|(name, _)| *name == check.name).unwrap_or_else(|| {
                self.checks.push((check.name.clone(), [0.0; 2]));
                self.checks.len() - 1
            });
            self.checks[at].1[bears] = self.checks[at].1[bears].max(check.value);
        }
    }

    fn add(&mut self, relation: Relation, quantity: Quantity, size: f64) {
        self.add_with(relation, quantity, (size, false));
    }

    fn add_with(&mut self, relation: Relation, quantity: Quantity, (size, bears): (f64, bool)) {
        let same = |it: &&mut Difference| (it.relation, it.quantity, it.bears) == (relation, quantity, bears);
        match self.differences.iter_mut().find(same) {
            Some(known) => known.size = known.size.max(size),
            None => self.differences.push(Difference { relation, quantity, bears, size }),
        }
    }
}

/// Compares the runs of one scene.
struct Judge<'a> {
    draft: &'a Draft,
    problem: Problem,
    base: Run,
    found: Findings,
}

/// The relations of a scene; `dir` is for its files.
pub fn examine(draft: &Draft, dir: &Path, wanted: &[Relation]) -> Findings {
    let name = draft.name.clone();
    let mut found = Findings { name, differences: Vec::new(), notes: Vec::new(), checks: Vec::new() };
    let scene = match draft.scene(dir, Mesh::Times(1)) {
        Ok(scene) => scene,
        Err(error) => {
            found.add(Relation::Converges, Quantity::Ending, 1.0);
            found.notes.push(error.to_string());
            return found;
        }
    };
    let problem = Problem { model: scene.model, stages: scene.stages };
    let base = play(&problem);
    found.add(Relation::Converges, Quantity::Ending, f64::from(u8::from(!base.converged)));
    if !base.converged {
        found.notes.push(format!("{}: {}", Relation::Converges.name(), base.ending));
        return found;
    }
    base.states.iter().for_each(|state| found.look_at(state));
    let mut judge = Judge { draft, problem, base, found };
    wanted.iter().for_each(|relation| judge.examine(*relation, dir));
    judge.found
}

impl Judge<'_> {
    fn examine(&mut self, relation: Relation, dir: &Path) {
        let problem = self.problem.clone();
        let mut random = Random::of(78, self.draft.name.parse().unwrap_or(0));
        let mut variants = Vec::new();
        match relation {
            Relation::Converges => {}
            Relation::Turned => {
                let shift = random.vector() * (5.0 * problem.model.rods[0].length);
                variants.extend(turn(&problem, &mut random).map(|turn| moved(&problem, turn, shift)));
            }
            Relation::Laid => {
                variants.extend(lays(&problem, &mut random).into_iter().map(|lay| moved(&problem, lay, Vec3::zeros())));
            }
            Relation::Mirrored => variants.push(moved(&problem, mirror(&problem, &mut random), Vec3::zeros())),
            Relation::Reordered => variants.push(reordered(&problem)),
            // an open rod that nothing holds is refused as soon as there is another rod
            Relation::Idle if self.draft.floats() && self.draft.has("open") => {}
            Relation::Idle => variants.push(with_idle_rod(&problem)),
            Relation::Cut => variants.extend(cut(&problem)),
            Relation::Units => variants.push(in_units(&problem, 64.0)),
            Relation::Steps => variants.extend([2, 5].map(|steps| in_steps(&problem, steps))),
            Relation::Back => self.back(),
            Relation::Resumed => self.resumed(),
            Relation::File => match file::write(&problem, &dir.join(&self.draft.name).join("copy.toml")) {
                Ok(problem) => variants.push(Variant { problem, ..Variant::same(&self.problem) }),
                Err(error) => self.failed(relation, error.to_string()),
            },
            Relation::Work => {
                let bears = self.base.states.iter().any(|state| state.seen.total_contact_force > 0.0);
                // what falls sets energy free
                let falls = self.draft.has("unsupported") && self.draft.has("floor");
                let least = Scales::of(&problem, self.base.last()).energy;
                if let Some(size) = work::missing(&problem, least).filter(|_| !falls) {
                    self.found.add_with(relation, Quantity::Energy, (size, bears));
                }
            }
            Relation::Finer | Relation::FinerLinear => {
                // elements of closed sequences are longer than steps, and smear their natural strains otherwise on each
                // mesh
                let is_smeared = self.draft.has("sequence") && self.draft.has("closed");
                if !is_smeared && (relation == Relation::FinerLinear) == self.draft.has("linear") {
                    self.finer(relation, dir);
                }
            }
            Relation::Presets => self.presets(dir),
        }
        for variant in variants {
            let run = play(&variant.problem);
            self.compare(relation, &variant, run);
        }
    }

    fn failed(&mut self, relation: Relation, why: String) {
        self.found.add(relation, Quantity::Ending, 1.0);
        self.found.notes.push(format!("{}: {why}", relation.name()));
    }

    fn compare(&mut self, relation: Relation, variant: &Variant, run: Run) {
        if !run.converged {
            return self.failed(relation, run.ending);
        }
        let first = self.base.last().clone();
        self.compare_states(relation, variant, &first, run.last());
    }

    fn compare_states(&mut self, relation: Relation, variant: &Variant, first: &State, second: &State) {
        let scales = Scales::of(&self.problem, first);
        let bears = [first, second].iter().any(|state| state.seen.total_contact_force > 0.0);
        for (quantity, size) in differences(first, second, variant, &scales) {
            // nothing holds an unsupported scene in its place, nor says where a rod is that is held later
            let held_later = self.draft.has("hold") && quantity != Quantity::Ending;
            let placed = !self.draft.floats() || (quantity != Quantity::Position && !held_later);
            let is_there = match quantity {
                Quantity::Contact => self.draft.has("crossing") || self.draft.has("floor"),
                Quantity::Reaction => !self.draft.has("unsupported") || self.draft.has("crossing"),
                _ => true,
            };
            if placed && is_there {
                self.found.add_with(relation, quantity, (size, bears));
                if size > relation.tolerance(quantity, bears) {
                    self.found.notes.push(format!("{}: {}", relation.name(), shown(quantity, first, second)));
                }
            }
        }
    }

    /// The last stage and back again. A stage that changes supports has no way back.
    fn back(&mut self) {
        let mut problem = self.problem.clone();
        let Some(last) = problem.stages.last().filter(|last| last.supports.is_empty()) else { return };
        let before = &problem.stages[..problem.stages.len() - 1];
        let ramps: Vec<Ramp> = last.ramps.iter().map(|ramp| undone(ramp, &problem.model, before)).collect();
        problem.stages.push(Stage::new(ramps, 1));
        let run = play(&problem);
        if !run.converged {
            return self.failed(Relation::Back, run.ending);
        }
        let first = self.base.states[self.base.states.len() - 2].clone();
        self.compare_states(Relation::Back, &Variant::same(&self.problem), &first, run.last());
    }

    /// As far as the end of the first stage, and from what is then written to the end.
    fn resumed(&mut self) {
        let Problem { model, stages } = self.problem.clone();
        if stages.len() < 2 {
            return;
        }
        let mut written: Option<Vec<u8>> = None;
        let first = run_from(model.clone(), &stages, &options(), None, &mut |progress, waypoint| {
            if progress.stage == 0 && progress.fraction == 1.0 {
                written = waypoint.restart().and_then(|restart| postcard::to_stdvec(&restart).ok());
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        let restart: Option<Restart> = written.and_then(|bytes| postcard::from_bytes(&bytes).ok());
        let (Ok(_), Some(restart)) = (first, restart) else {
            return self.failed(Relation::Resumed, "there is no restart".to_owned());
        };
        let mut last = None;
        let second = run_from(model, &stages, &options(), Some(restart), &mut |progress, _| {
            let rods = 0..progress.engine.model().rods.len();
            let positions = rods.map(|rod| progress.engine.positions(rod).to_vec()).collect();
            last = Some(State { seen: supercoil::observe::observe(progress), positions });
            ControlFlow::Continue(())
        });
        match (second, last) {
            (Ok(_), Some(last)) => {
                let first = self.base.last().clone();
                self.compare_states(Relation::Resumed, &Variant::same(&self.problem), &first, &last);
            }
            (Err(error), _) => self.failed(Relation::Resumed, error.to_string()),
            (Ok(_), None) => self.failed(Relation::Resumed, "no step was made".to_owned()),
        }
    }

    fn finer(&mut self, relation: Relation, dir: &Path) {
        let scene = match self.draft.scene(dir, Mesh::Times(2)) {
            Ok(scene) => scene,
            Err(error) => return self.failed(relation, error.to_string()),
        };
        let variant = Variant { nodes: every_other(&self.problem.model), ..Variant::same(&self.problem) };
        let run = play(&Problem { model: scene.model, stages: scene.stages });
        self.compare(relation, &variant, run);
    }

    /// Draft and balanced against reference, where rods are uniform and nodes are named by the ends of rods alone.
    fn presets(&mut self, dir: &Path) {
        let excluded = ["closed", "sequence", "tapered", "hold", "linear", "quadratic", "unsupported"];
        if excluded.iter().any(|word| self.draft.has(word)) {
            return;
        }
        let mut runs = Vec::new();
        for fidelity in [Fidelity::Reference, Fidelity::Balanced, Fidelity::Draft] {
            let word = ["reference", "balanced", "draft"][runs.len()];
            let scene = match self.draft.scene(dir, Mesh::Fidelity(word)) {
                Ok(scene) => scene,
                Err(error) => return self.failed(Relation::Presets, error.to_string()),
            };
            let options = supercoil::solve::Options { threads: Some(1), ..supercoil::solve::Options::from(fidelity) };
            let problem = Problem { model: scene.model, stages: scene.stages };
            let run = play_with(&problem, &options);
            if !run.converged {
                return self.failed(Relation::Presets, format!("{word}: {}", run.ending));
            }
            runs.push((fidelity, problem, run));
        }
        let (_, problem, reference) = &runs[0];
        for (fidelity, _, run) in &runs[1..] {
            self.compare_presets(*fidelity, problem, reference.last(), run.last());
        }
    }

    /// Differences in parts of what both presets together state.
    fn compare_presets(&mut self, fidelity: Fidelity, problem: &Problem, reference: &State, state: &State) {
        let scales = Scales::of(problem, reference);
        let [own, best] = [fidelity.accuracy(), Fidelity::Reference.accuracy()];
        let energy = (state.seen.energies.total - reference.seen.energies.total).abs() / scales.energy;
        self.found.add(Relation::Presets, Quantity::Energy, energy / (own.energy + best.energy));
        let contact = (state.seen.contact_resultants - reference.seen.contact_resultants).abs();
        if reference.seen.contact_resultants > 0.0 {
            let relative = contact / reference.seen.contact_resultants;
            self.found.add(Relation::Presets, Quantity::Contact, relative / (own.contact_force + best.contact_force));
        } else {
            let ends = state.seen.ends.iter().zip(&reference.seen.ends);
            let away = ends.map(|(a, b)| (Vec3::from(a.end) - Vec3::from(b.end)).norm()).fold(0.0, f64::max);
            let stated = own.position + best.position;
            self.found.add(Relation::Presets, Quantity::Position, away / scales.length / stated);
        }
    }
}

/// Nodes of a mesh of twice as many elements.
fn every_other(model: &Model) -> Vec<Vec<supercoil::scene::NodeRef>> {
    let node = |rod: usize, node: usize| supercoil::scene::NodeRef { rod, node: 2 * node };
    model.rods.iter().enumerate().map(|(rod, it)| (0..it.num_nodes()).map(|k| node(rod, k)).collect()).collect()
}

/// Whether all supports hold all components or none, at all times, so that any turn leaves them what they are.
fn turns_freely(problem: &Problem) -> bool {
    let whole = |held: [bool; 3]| held == [true; 3] || held == [false; 3];
    let all = |support: &Support| whole(support.position) && whole(support.rotation);
    let mut changes = problem.stages.iter().flat_map(|stage| &stage.supports);
    changes.all(|change| all(change.support())) && problem.model.supports.iter().all(all)
}

/// A turn at random, in the plane of planar scenes; none where supports hold single axes.
fn turn(problem: &Problem, random: &mut Random) -> Option<Mat3> {
    if !turns_freely(problem) {
        return None;
    }
    let axis = if problem.model.planar { Vec3::z() } else { random.direction() };
    let turn = Quat::from_scaled_axis(axis * random.between(0.5, 3.0));
    Some(*turn.to_rotation_matrix().matrix())
}

/// Axes with signs as the columns of a rotation.
fn columns(x: Vec3, y: Vec3) -> Mat3 {
    Mat3::from_columns(&[x, y, x.cross(&y)])
}

/// Turns that take x to y, z, −x, −y and −z, each rolled by some right angles.
fn lays(problem: &Problem, random: &mut Random) -> Vec<Mat3> {
    let (x, y, z) = (Vec3::x(), Vec3::y(), Vec3::z());
    if problem.model.planar {
        return vec![columns(y, -x), columns(-x, y), columns(-x, -y), columns(-y, x), columns(-y, -x)];
    }
    let mut one = |x: Vec3, sides: [Vec3; 2]| columns(x, sides[random.below(2) as usize] * random.sign());
    vec![one(y, [x, z]), one(z, [x, y]), one(-x, [y, z]), one(-y, [x, z]), one(-z, [x, y])]
}

/// A mirror: any where supports turn freely, else one of z; planar scenes: of y.
fn mirror(problem: &Problem, random: &mut Random) -> Mat3 {
    let normal = match problem.model.planar {
        true => Vec3::y(),
        false if turns_freely(problem) => random.direction(),
        false => Vec3::z(),
    };
    Mat3::identity() - 2.0 * normal * normal.transpose()
}

fn in_steps(problem: &Problem, steps: usize) -> Variant {
    let mut out = Variant::same(problem);
    out.problem.stages.iter_mut().for_each(|stage| stage.steps = steps);
    out
}

/// The ramp back to the value that the quantity had after the stages `before`.
fn undone(ramp: &Ramp, model: &Model, before: &[Stage]) -> Ramp {
    let same = |other: &&Ramp| match (ramp, other) {
        (Ramp::Load { .. }, Ramp::Load { .. }) => true,
        (Ramp::Displacement { node: a, .. }, Ramp::Displacement { node: b, .. }) => a == b,
        _ => false,
    };
    if let Some(earlier) = before.iter().rev().flat_map(|stage| &stage.ramps).find(same) {
        return earlier.clone();
    }
    let mut back = ramp.clone();
    match &mut back {
        Ramp::ExcessLink { rod, to } => *to = model.rods[*rod].start_excess_link,
        Ramp::Rotation { to, .. } | Ramp::RotationAbout { to, .. } | Ramp::Load { to } => *to = 0.0,
        Ramp::Obstacle { obstacle, which, to } => *to = model.obstacles[*obstacle].start().get(*which),
        Ramp::Pressure { to, .. } => *to = 0.0,
        Ramp::Displacement { to, .. } => *to = Vec3::zeros(),
        Ramp::Pose { node, pose } => {
            let rod = &model.rods[node.rod];
            (pose.position, pose.frame) = (Some(rod.positions[node.node]), Some(rod.frames[node.node]));
        }
        Ramp::Number { rod, which, to } => *to = model.rods[*rod].number(*which),
    }
    back
}
