//! A-posteriori error estimates of states, from further equilibria on a finer mesh and with a stiffer contact law.

use crate::error::InputError;
use crate::scene::Units;
use crate::solve::{Progress, Solver, Status, StepReport};

use super::report::Observation;
use super::state::observe;

/// Factor on the contact stiffness in the comparison of laws.
const HARDER: f64 = 10.0;

/// Factor within which the estimate of a state in contact covers its error, because contact points lie anywhere in an
/// element, and two meshes of which one happens to suit them tell less than both are off. Measured on twisted rings
/// (`cargo test --test solver estimates_of_twisted_rings -- --ignored`).
pub const COVERS: f64 = 2.5;

/// Differences of two states: the largest absolute differences over all rods, sites or supports.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Differences {
    /// Elastic and contact energy \[F·L\].
    pub energy: f64,
    /// Positions of the ends of elements \[L\]; `None` if a rod has no support, since it may then lie anywhere.
    pub position: Option<f64>,
    /// Writhe of closed rods, turns.
    pub writhe: Option<f64>,
    /// Twisting moment at the seams of closed rods \[F·L\].
    pub twisting_moment: Option<f64>,
    /// Sum of the contact forces of all sites \[F\]; `None` without contact.
    pub contact_force: Option<f64>,
    /// Components of forces at supports \[F\].
    pub reaction_force: Option<f64>,
    /// Components of moments at supports \[F·L\].
    pub reaction_moment: Option<f64>,
}

impl Differences {
    fn scaled(self, factor: f64) -> Self {
        let scale = |x: Option<f64>| x.map(|x| x * factor);
        Self {
            energy: self.energy * factor,
            position: scale(self.position),
            writhe: scale(self.writhe),
            twisting_moment: scale(self.twisting_moment),
            contact_force: scale(self.contact_force),
            reaction_force: scale(self.reaction_force),
            reaction_moment: scale(self.reaction_moment),
        }
    }
}

/// One comparison.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Comparison {
    /// "converged", or why the reference state was not found.
    pub status: String,
    /// Newton iterations spent.
    pub iterations: usize,
    /// Unstable directions of the reference state. If there are any, it may belong to another branch.
    pub num_unstable: usize,
    /// The estimate; `None` if the reference state did not converge.
    pub error: Option<Differences>,
}

/// An a-posteriori estimate of a state's error, in two parts. It is no bound: in contact the error may be [`COVERS`]
/// times the sum of both.
///
/// **Mesh**: difference to the state on twice the elements. With elements of order p smooth quantities converge as
/// h^2p, so that the difference is the error up to a part in 4^p. Contact points lower the order to h²; then the
/// difference is three quarters of the error. **Contact law**: difference between the present law and one ten times as
/// stiff (on the finer mesh), times 1/(1 − 10^(−2/3)), because the width κ^(−1/3) of a point contact causes an error
/// κ^(−2/3) in its force. The remaining penetration is included.
///
/// It does not detect a contact that both meshes miss, nor another stable branch.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ErrorEstimate {
    /// Comparison of meshes.
    pub mesh: Comparison,
    /// Comparison of contact laws; `None` without contact.
    pub contact_law: Option<Comparison>,
    /// Certified penetration of the state itself over the smallest contact radius.
    pub penetration: Option<f64>,
    /// Largest residual of the state itself over the size of its contributions.
    pub residual: f64,
    /// Size of the last Newton increment of the finer state, over the node spacing and in rad.
    pub increment: f64,
}

/// One of the compared quantities.
type DifferenceOf = fn(&Differences) -> Option<f64>;

/// What is compared: name, dimension, value.
const QUANTITIES: [(&str, &str, DifferenceOf); 7] = [
    ("energy", "F L", |d| Some(d.energy)),
    ("positions", "L", |d| d.position),
    ("writhe", "turns", |d| d.writhe),
    ("twisting moment", "F L", |d| d.twisting_moment),
    ("contact force", "F", |d| d.contact_force),
    ("reaction forces", "F", |d| d.reaction_force),
    ("reaction moments", "F L", |d| d.reaction_moment),
];

impl ErrorEstimate {
    /// Both parts of one quantity together; `None` if a part is missing or the model has no such quantity.
    pub fn total(&self, of: impl Fn(&Differences) -> Option<f64>) -> Option<f64> {
        let mesh = of(self.mesh.error.as_ref()?)?;
        match &self.contact_law {
            None => Some(mesh),
            Some(law) => Some(mesh + of(law.error.as_ref()?)?),
        }
    }
}

impl std::fmt::Display for ErrorEstimate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.in_units(&Units::default()))
    }
}

impl ErrorEstimate {
    /// The estimate as a table for reading, each line with its unit.
    pub fn in_units(&self, units: &Units) -> String {
        let (law, mut lines) =
            (self.contact_law.as_ref(), vec!["error estimate            mesh  contact law".to_owned()]);
        let part = |comparison: Option<&Comparison>, of: DifferenceOf| {
            let value = comparison.and_then(|c| c.error.as_ref()).and_then(of);
            value.map_or_else(|| "-".to_owned(), |x| format!("{x:.1e}"))
        };
        for (name, dimension, of) in QUANTITIES {
            let [mesh, law] = [Some(&self.mesh), law].map(|comparison| part(comparison, of));
            if mesh != "-" || law != "-" {
                lines.push(format!("  {name:<18}{mesh:>10}{law:>13}  {}", units.of(dimension)));
            }
        }
        for (name, comparison) in [("finer mesh", Some(&self.mesh)), ("harder law", law)] {
            if let Some(Comparison { status, error: None, .. }) = comparison {
                lines.push(format!("  no state on the {name}: {status}"));
            }
        }
        lines.extend(self.penetration.map(|depth| format!("  penetration over the contact radius {depth:.1e}")));
        lines.extend(
            law.map(|_| format!("  in contact: an estimate; the error may be up to {COVERS} times the sum of both")),
        );
        lines.push(format!("  relative residual {:.1e}", self.residual));
        lines.join("\n")
    }
}

/// Estimates the error of the solver's present state, which should be an equilibrium; see [`ErrorEstimate`].
///
/// Costs two more equilibrium searches on twice the elements (one without contact). The solver itself is not changed.
///
/// # Errors
/// A rod that cannot be refined. The estimate reports searches that do not converge.
pub fn estimate_error(solver: &Solver) -> Result<ErrorEstimate, InputError> {
    let coarse = seen(solver, None);
    let mut fine = solver.refined(2)?;
    let report = fine.resettle();
    let on_finer_mesh = seen(&fine, Some(&report));
    let stride = 2;
    let mesh = compare(&report, || differences((solver, &coarse), (&fine, &on_finer_mesh), stride));
    let increment = report.history.iter().flatten().last().map_or(0.0, |last| last.increment);
    let touches = coarse.num_sites > 0 || on_finer_mesh.num_sites > 0;
    let contact_law = (touches && report.status == Status::Converged).then(|| {
        let soft = on_finer_mesh;
        fine.harden_contact(HARDER);
        let before = fine.engine().state().clone();
        let report = fine.resettle();
        let hard = seen(&fine, Some(&report));
        let spread = 1.0 / (1.0 - HARDER.powf(-2.0 / 3.0));
        let mut comparison = compare(&report, || differences((&fine, &soft), (&fine, &hard), 1).scaled(spread));
        // positions of the two states: of one solver, before and after
        if let Some(error) = &mut comparison.error {
            let moved = |(a, b): (&crate::math::Vec3, &crate::math::Vec3)| (a - b).norm();
            let largest =
                before.positions().iter().zip(fine.engine().state().positions()).map(moved).fold(0.0, f64::max);
            error.position = error.position.map(|_| largest * spread);
        }
        comparison
    });
    let radii = solver.engine().model().rods.iter().map(crate::rod::Rod::least_contact_radius).filter(|r| *r > 0.0);
    let min_radius = radii.fold(f64::INFINITY, f64::min);
    Ok(ErrorEstimate {
        mesh,
        contact_law,
        penetration: coarse.min_gap.map(|gap| (-gap.lower / min_radius).max(0.0)),
        residual: solver.engine().relative_residual(),
        increment,
    })
}

fn compare(report: &StepReport, differences: impl FnOnce() -> Differences) -> Comparison {
    Comparison {
        status: report.error.as_ref().map_or_else(|| report.status.to_string(), ToString::to_string),
        iterations: report.iterations,
        num_unstable: report.num_unstable,
        error: (report.status == Status::Converged).then(differences),
    }
}

fn seen(solver: &Solver, report: Option<&StepReport>) -> Observation {
    let engine = solver.engine();
    let settled = StepReport::settled();
    let report = report.unwrap_or(&settled);
    observe(&Progress { given: None, engine, stage: 0, step: 0, fraction: 1.0, report, seconds: 0.0 })
}

/// Differences of two states; node k of the first is node `stride`·k of the second, rod by rod. Positions are compared
/// at the ends of elements, where they converge as h^2p like all other quantities; inside elements their order is that
/// of the polynomials.
fn differences((a, coarse): (&Solver, &Observation), (b, fine): (&Solver, &Observation), stride: usize) -> Differences {
    let largest = |pairs: &mut dyn Iterator<Item = f64>| pairs.map(f64::abs).reduce(f64::max);
    let model = a.engine().model();
    let held = |rod: usize| model.supports.iter().any(|support| support.node.rod == rod);
    let apart = |rod: usize| {
        let (old, new, order) = (a.engine().positions(rod), b.engine().positions(rod), model.rods[rod].order);
        old.iter()
            .step_by(order)
            .zip(new.iter().step_by(stride * order))
            .map(|(x, y)| (x - y).norm())
            .fold(0.0, f64::max)
    };
    let rods = 0..model.rods.len();
    let links = || coarse.links.iter().zip(&fine.links);
    let reactions = || coarse.reactions.iter().zip(&fine.reactions);
    let touches = coarse.num_sites + fine.num_sites > 0;
    Differences {
        energy: (coarse.energies.total - fine.energies.total).abs(),
        position: rods.clone().all(held).then(|| rods.map(apart).fold(0.0, f64::max)),
        writhe: largest(&mut links().map(|(x, y)| x.writhe - y.writhe)),
        twisting_moment: largest(&mut links().map(|(x, y)| x.seam_moment - y.seam_moment)),
        contact_force: touches.then(|| (coarse.total_contact_force - fine.total_contact_force).abs()),
        reaction_force: largest(&mut reactions().flat_map(|(x, y)| (0..3).map(|k| x.force[k] - y.force[k]))),
        reaction_moment: largest(&mut reactions().flat_map(|(x, y)| (0..3).map(|k| x.moment[k] - y.moment[k]))),
    }
}
