//! The certificate of a state: what holds of it, by the model and the state alone.
//!
//! A solver that tests its own work repeats its own errors. The checks here share no assembly, no contact law and no
//! prediction with it: they have their own strains, forces and searches, and see of the rest only what is reported of
//! it (contact forces, reactions). Each is a few lines with its formula.
//!
//! | | |
//! |---|---|
//! | `supports` | supports hold what is prescribed, joined nodes coincide, frames are unit and turn by less than half a turn |
//! | `balance` | forces and moments sum to zero, node by node, contact by contact, body by body; energies are those of the strains |
//! | `normals` | contact forces push along the normals of the sites |
//! | `gaps` | the elements' own centrelines do not overlap |

mod arcs;
mod balance;
mod gaps;
mod normals;
mod obstacles;
mod strains;
mod supports;

use std::fmt;

pub(crate) use gaps::OwnGap;

use arcs::Arcs;

use crate::math::Vec3;
use crate::rod::ElasticEnergies;
use crate::scene::{Model, NodeRef};
use crate::solve::{Given, State};

/// A check of a state.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Check {
    /// Name: "supports", "joints", "frames", "turning", "balance of nodes", "balance of bodies", "energies", …
    pub name: String,
    /// Deviation, in the unit that `detail` says.
    pub value: f64,
    /// Largest deviation that rounding, the solver's convergence and the mesh explain.
    pub tolerance: f64,
    /// Whether the deviation is no larger.
    pub holds: bool,
    /// Unit and place of the largest deviation.
    pub detail: String,
}

/// What holds of a state: all checks that apply to it.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Certificate {
    /// The checks.
    pub checks: Vec<Check>,
}

/// What the certificate looks at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Subject<'a> {
    /// The model: numbers and supports as they are now, shapes as they were given.
    pub(crate) model: &'a Model,
    pub(crate) state: &'a State,
    /// What was given, with stage and fraction; `None` for states that no stages led to.
    pub(crate) given: Option<(&'a Given, usize, f64)>,
    /// Contact forces on strands, as reported; `None` where they are not all known.
    pub(crate) contact: Option<&'a [ContactForce]>,
    /// Reactions, as reported.
    pub(crate) reactions: &'a [SupportForce],
    /// Forces of joints on each of their nodes, as reported.
    pub(crate) joints: &'a [SupportForce],
    /// Elastic energies, as reported \[F·L\].
    pub(crate) energies: ElasticEnergies,
    /// Penetration over the smallest contact radius, as reported: a penalty leaves it.
    pub(crate) penetration: f64,
}

/// A contact force on a strand, as reported.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactForce {
    pub(crate) rod: usize,
    /// Arc lengths between which it acts \[L\]; the second is the lower one where it acts across the seam.
    pub(crate) arc: [f64; 2],
    /// \[F\]
    pub(crate) force: Vec3,
    /// Moment about `at` \[F·L\].
    pub(crate) moment: Vec3,
    /// \[L\]
    pub(crate) at: Vec3,
    pub(crate) partner: Counterpart,
    /// ∫p ds \[F\].
    pub(crate) carried: f64,
}

/// What a strand presses on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Counterpart {
    /// A strand: rod and arc lengths.
    Strand { rod: usize, arc: [f64; 2] },
    /// The strand of the entry before.
    Opposite,
    /// An obstacle: its index.
    Obstacle(usize),
}

/// Force and moment of a support or joint on a node, as reported.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SupportForce {
    pub(crate) node: NodeRef,
    /// \[F\]
    pub(crate) force: Vec3,
    /// \[F·L\]
    pub(crate) moment: Vec3,
}

impl Check {
    /// A check whose deviation is not to exceed its tolerance; a deviation that is no number fails.
    pub(crate) fn new(name: &str, value: f64, tolerance: f64, detail: String) -> Self {
        Self { name: name.to_owned(), value, tolerance, holds: value <= tolerance, detail }
    }
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let relation = if self.holds { "≤" } else { ">" };
        write!(f, "{} {:.1e} {relation} {:.1e} ({})", self.name, self.value, self.tolerance, self.detail)
    }
}

impl Certificate {
    /// All checks of a state, and the smallest gap between strands.
    pub(crate) fn of(subject: &Subject) -> (Self, Option<OwnGap>) {
        let mut checks = supports::checks(subject);
        checks.extend(balance::checks(subject));
        if !subject.model.contact.law.is_on() {
            return (Self { checks }, None);
        }
        let arcs = Arcs::of(subject.model, subject.state);
        checks.extend(normals::check(subject, &arcs));
        let (gap, check) = gaps::gaps(subject, &arcs);
        checks.extend(check);
        (Self { checks }, gap)
    }

    /// The check of a name, if it applies.
    pub fn check(&self, name: &str) -> Option<&Check> {
        self.checks.iter().find(|check| check.name == name)
    }

    /// Whether all checks hold.
    pub fn holds(&self) -> bool {
        self.checks.iter().all(|check| check.holds)
    }

    /// The checks that fail.
    pub fn failures(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|check| !check.holds)
    }
}

/// One line: the number of checks that hold, or those that fail.
impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.holds() {
            return write!(f, "all {} checks of the certificate hold", self.checks.len());
        }
        write!(f, "the certificate fails: ")?;
        for (k, check) in self.failures().enumerate() {
            write!(f, "{}{check}", if k > 0 { "; " } else { "" })?;
        }
        Ok(())
    }
}

/// The largest of some deviations, and where it is; a deviation that is no number is larger than any.
#[derive(Debug, Clone)]
struct Worst {
    value: f64,
    place: String,
}

impl Worst {
    fn none() -> Self {
        Self { value: 0.0, place: String::new() }
    }

    fn add(&mut self, value: f64, place: impl FnOnce() -> String) {
        if value > self.value || value.is_nan() {
            *self = Self { value, place: place() };
        }
    }

    /// "unit, place".
    fn detail(&self, unit: &str) -> String {
        if self.place.is_empty() { unit.to_owned() } else { format!("{unit}, {}", self.place) }
    }
}

/// A node in words.
fn node_name(model: &Model, node: NodeRef) -> String {
    format!("rod \"{}\" node {}", model.rods[node.rod].name, node.node)
}

/// Global index of the first node of each rod, one entry more than rods.
fn first_nodes(model: &Model) -> Vec<usize> {
    let mut first = vec![0];
    for rod in &model.rods {
        first.push(first[first.len() - 1] + rod.num_nodes());
    }
    first
}
