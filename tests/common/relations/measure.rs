//! What a run comes to, and by how much two runs differ.

use std::ops::ControlFlow;

use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::{Observation, Reaction};
use supercoil::scene::NodeRef;
use supercoil::solve::{Options, Status, run};

use super::motion::{Problem, Variant};

/// A state at the end of a stage.
#[derive(Debug, Clone)]
pub struct State {
    pub seen: Observation,
    pub positions: Vec<Vec<Vec3>>,
}

/// A run: its states at the start and at the end of each stage, and how it ended.
#[derive(Debug, Clone)]
pub struct Run {
    pub states: Vec<State>,
    pub ending: String,
    pub converged: bool,
    /// Energy set free by snaps \[F·L\].
    pub released: f64,
}

impl Run {
    /// The last accepted state.
    pub fn last(&self) -> &State {
        &self.states[self.states.len() - 1]
    }

    fn failed(ending: String) -> Self {
        Self { states: Vec::new(), ending, converged: false, released: 0.0 }
    }
}

/// Smallest step, so that a scene that does not converge does not take all the time.
const MIN_STEP: f64 = 0.25;

/// Options of all runs.
pub fn options() -> Options {
    Options { threads: Some(1), min_step: MIN_STEP, ..Options::default() }
}

pub fn play(problem: &Problem) -> Run {
    play_with(problem, &options())
}

pub fn play_with(problem: &Problem, options: &Options) -> Run {
    let (mut states, mut released) = (Vec::new(), 0.0);
    let mut watch = |progress: &supercoil::solve::Progress| {
        if progress.step == 0 || progress.fraction == 1.0 {
            let rods = 0..progress.engine.model().rods.len();
            let positions = rods.map(|rod| progress.engine.positions(rod).to_vec()).collect();
            states.push(State { seen: observe(progress), positions });
        }
        released += progress.report.energy_released;
        ControlFlow::Continue(())
    };
    match run(problem.model.clone(), &problem.stages, options, &mut watch) {
        Err(error) => Run::failed(error.to_string()),
        Ok(solution) => {
            let failing = states.iter().find(|state: &&State| state.seen.status != "converged");
            let certified =
                failing.map_or_else(|| solution.status.to_string(), |state| state.seen.certificate.to_string());
            let ending = solution.failure.as_ref().map_or(certified, ToString::to_string);
            let all = states.len() == problem.stages.len() + 1;
            let converged = solution.status == Status::Converged && failing.is_none() && all;
            Run { states, ending, converged, released }
        }
    }
}

/// Quantities that are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Energies by kind, over the total.
    Energy,
    /// Positions of nodes, over the length.
    Position,
    /// Reactions, over the largest: forces, and moments times curvature.
    Reaction,
    /// Contact forces, those of planes included, over the largest force.
    Contact,
    /// Link, twist, writhe, turns.
    Link,
    /// How the run ends, unstable directions: 1 where they differ.
    Ending,
}

impl Quantity {
    pub const ALL: [Self; 6] = [Self::Energy, Self::Position, Self::Reaction, Self::Contact, Self::Link, Self::Ending];

    pub fn name(self) -> &'static str {
        match self {
            Self::Energy => "energies",
            Self::Position => "positions",
            Self::Reaction => "reactions",
            Self::Contact => "contact forces",
            Self::Link => "link",
            Self::Ending => "ending",
        }
    }
}

/// Scales that differences are measured in.
#[derive(Debug, Clone, Copy)]
pub struct Scales {
    pub length: f64,
    pub force: f64,
    pub energy: f64,
}

/// Part of the stiffness B/L² (B/L) below which forces (energies) count as nothing.
const LEAST: f64 = 0.05;

impl Scales {
    /// Of a problem in its state.
    pub fn of(problem: &Problem, state: &State) -> Self {
        let rod = &problem.model.rods[0];
        let (length, [a, b]) = (rod.length, rod.section.bending);
        let seen = &state.seen;
        let size = |it: &Reaction| Vec3::from(it.force).norm().max(Vec3::from(it.moment).norm() / length);
        let forces = seen.reactions.iter().map(size);
        let force = forces.fold(seen.total_contact_force, f64::max);
        let least = LEAST * a.min(b) / length;
        Self { length, force: force.max(least / length), energy: seen.energies.total.abs().max(least) }
    }
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    // a NaN is a difference
    values.into_iter().fold(0.0, |most, it| if it.is_nan() { f64::INFINITY } else { most.max(it.abs()) })
}

/// The differences of two states, those of the second in the terms of the first.
pub fn differences(first: &State, second: &State, variant: &Variant, scales: &Scales) -> Vec<(Quantity, f64)> {
    let mut found = vec![
        (Quantity::Energy, energies(first, second, variant) / scales.energy),
        (Quantity::Position, positions(first, second, variant) / scales.length),
        (Quantity::Reaction, reactions(first, second, variant, scales)),
        (Quantity::Contact, contact(&first.seen, &second.seen, variant) / scales.force),
        (Quantity::Ending, f64::from(u8::from(first.seen.num_unstable != second.seen.num_unstable))),
    ];
    found.extend(links(&first.seen, &second.seen, variant).map(|it| (Quantity::Link, it)));
    found
}

fn energies(first: &State, second: &State, variant: &Variant) -> f64 {
    let unit = variant.length * variant.force;
    let all = |it: &State| {
        let e = &it.seen.energies;
        [e.stretching, e.shearing, e.bending, e.twisting, e.contact, e.electrostatic, e.total]
    };
    largest(all(first).iter().zip(all(second)).map(|(a, b)| a - b / unit))
}

/// A quantity of two states that differ, each in its own terms.
pub fn shown(quantity: Quantity, first: &State, second: &State) -> String {
    let of = |state: &State| {
        let seen = &state.seen;
        match quantity {
            Quantity::Energy => format!("{:?}", seen.energies),
            Quantity::Reaction => {
                let all =
                    seen.reactions.iter().map(|it| format!("{} {}: {:?}", it.rod, it.node, (it.force, it.moment)));
                all.collect::<Vec<_>>().join("; ")
            }
            Quantity::Contact => format!("{} and {}", seen.total_contact_force, seen.contact_resultants),
            Quantity::Link => format!("{:?}", seen.links),
            Quantity::Position | Quantity::Ending => format!("{} unstable, {:?}", seen.num_unstable, seen.notes),
        }
    };
    format!("{}\n        {}\n        {}", quantity.name(), of(first), of(second))
}

fn positions(first: &State, second: &State, variant: &Variant) -> f64 {
    let rods = first.positions.iter().zip(&variant.nodes);
    let nodes = rods.flat_map(|(positions, nodes)| positions.iter().zip(nodes));
    largest(nodes.map(|(p, node)| (variant.position_back(&second.positions[node.rod][node.node]) - p).norm()))
}

fn reactions(first: &State, second: &State, variant: &Variant, scales: &Scales) -> f64 {
    let differences = first.seen.reactions.iter().map(|it| {
        let node = variant.nodes[it.rod][it.node];
        let other = second.seen.reactions.iter().find(|other| NodeRef { rod: other.rod, node: other.node } == node);
        let Some(other) = other else { return f64::INFINITY };
        let force = variant.force_back(&other.force.into()) - Vec3::from(it.force);
        let moment = variant.moment_back(&other.moment.into()) - Vec3::from(it.moment);
        (force.norm() / scales.force).max(moment.norm() / (scales.force * scales.length))
    });
    largest(differences)
}

fn contact(first: &Observation, second: &Observation, variant: &Variant) -> f64 {
    let all = |it: &Observation| {
        let planes = it.obstacle_reactions.iter().map(|plane| plane.force);
        [it.total_contact_force, it.contact_resultants].into_iter().chain(planes).collect::<Vec<f64>>()
    };
    largest(all(first).iter().zip(all(second)).map(|(a, b)| a - b / variant.force))
}

fn links(first: &Observation, second: &Observation, variant: &Variant) -> Option<f64> {
    let hand = variant.handedness();
    let of = |it: &supercoil::observe::report::RodLink| [it.link, it.twist, it.writhe, it.excess_link];
    let pairs = first.links.iter().filter_map(|link| {
        let rod = variant.nodes[link.rod][0].rod;
        let other = second.links.iter().find(|other| other.rod == rod)?;
        Some(largest(of(link).iter().zip(of(other)).map(|(a, b)| a - hand * b)))
    });
    pairs.reduce(f64::max)
}
