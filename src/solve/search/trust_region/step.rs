//! The step of the trust-region search: that of the smallest shift which makes the model convex and keeps the step
//! within the radius.

use crate::error::SolveError;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::carried_bodies::BodyMotion;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::zero_energy::is_falling;
use crate::solve::search::step_bound::{displacement, largest_turn};
use crate::solve::search::workspace::{NEUTRAL_SHIFT, Workspace};

use super::RAISING;

/// Times that the shift of a step is refined, because the first guess measures, the second corrects, the third
/// confirms.
const REFINEMENTS: usize = 3;

/// Smallest shift, in units of B/L⁴, because that is the eigenvalue of a rod's softest bending.
const FIRST_SHIFT: f64 = 10.0;
/// Factor on a shift that leaves a negative eigenvalue, because a shift that is raised too far is lowered again by an
/// estimate, and each try is a factorisation.
const CLIMBING: f64 = 8.0;
/// Margin of estimates: on the shift that the lowest eigenvalue asks for, and on the radius, because to meet either
/// exactly takes more factorisations than a step saves.
const MARGIN: f64 = 1.5;
/// Factor by which a shift is raised or lowered at least, because each try is a factorisation. With 1.5 for lowering, a
/// penalty of κ' = 10⁸ without augmentation does not converge.
const LEAST_CHANGE: f64 = 2.0;

/// A step and the quadratic model along it.
pub(super) struct ModelStep {
    pub(super) increment: Vec<f64>,
    /// The solution of the linear system, neutral motions included.
    raw: Vec<f64>,
    /// See [`extent`].
    pub(super) extent: f64,
    /// g·Δ.
    pub(super) slope: f64,
    /// ΔᵀKΔ.
    pub(super) curvature: f64,
    /// ΔᵀMΔ.
    pub(super) inertia: f64,
}

impl Workspace {
    /// Factorises with the present shift, raised until no eigenvalue is negative; a raised shift is then lowered to
    /// half again as much as the lowest eigenvalue asks for, so that an unstable direction is followed at the stride of
    /// a Newton step. From a shift far above it that eigenvalue is guessed too small, so the shift is sought in decades
    /// between the guess and what is convex: stiff rods that swing have eigenvalues of their loads, a thousandth of
    /// those of bending, and under a shift of bending they would swing in thousands of steps.
    fn convexify(&mut self, engine: &Engine, iteration: usize) -> Result<(), SolveError> {
        if self.factorise(engine, self.shift) == Some(0) {
            return Ok(());
        }
        let lower = self.shift;
        let start = (RAISING * self.shift).max(-MARGIN * self.softest_quotient(engine)).max(FIRST_SHIFT);
        self.shift = self.convex_shift(engine, start, CLIMBING, iteration)?;
        let estimate = MARGIN * (self.shift - self.lowest_above(engine, 4)).max(lower);
        if LEAST_CHANGE * estimate < self.shift {
            self.lower_shift(engine, estimate.max(NEUTRAL_SHIFT));
        }
        Ok(())
    }

    /// Lowers a convex shift to `lowest`, or else to within a factor [`CLIMBING`] of one that is not convex.
    fn lower_shift(&mut self, engine: &Engine, lowest: f64) {
        if self.factorise(engine, lowest) == Some(0) {
            self.shift = lowest;
            return;
        }
        let mut concave = lowest;
        while self.shift > CLIMBING * concave {
            let between = (self.shift * concave).sqrt();
            match self.factorise(engine, between) {
                Some(0) => self.shift = between,
                _ => concave = between,
            }
        }
        if self.factorised != self.shift {
            self.factorise(engine, self.shift);
        }
    }

    /// Rayleigh quotient of the last estimate of the softest direction; 0 without one.
    fn softest_quotient(&self, engine: &Engine) -> f64 {
        if self.softest.is_empty() {
            return 0.0;
        }
        self.energy_norm_sq(engine, &self.softest, 0.0) / self.inertia(engine, &self.softest)
    }

    /// xᵀ(K + τM)x of the assembled (unshifted) tangent and the shift τ.
    pub(super) fn energy_norm_sq(&self, engine: &Engine, x: &[f64], shift: f64) -> f64 {
        let product = self.multiply(&self.tangent.values, x);
        self.free_dot(engine, x, |i| product[i] + shift * engine.metric[i] * x[i])
    }

    /// xᵀMx.
    pub(super) fn inertia(&self, engine: &Engine, x: &[f64]) -> f64 {
        self.free_dot(engine, x, |i| engine.metric[i] * x[i])
    }

    /// The Newton step of the present factorisation, with slope and curvature of the model.
    fn model_step(
        &mut self,
        engine: &Engine,
        residual: &Residual,
        drive: &PrescribedMotion,
        iteration: usize,
    ) -> Result<ModelStep, SolveError> {
        let raw = self.raw_step(engine, residual);
        let slope = self.free_dot(engine, &raw, |i| residual.gradient[i]);
        let work = -slope - self.free_dot(engine, &raw, |i| self.tangent.drive[i]);
        let inertia = self.inertia(engine, &raw);
        let increment = self.finished_step(raw.clone(), drive, iteration)?;
        let extent = extent(engine, residual, &increment);
        Ok(ModelStep { increment, raw, extent, slope, curvature: work - self.shift * inertia, inertia })
    }

    /// The step of the smallest shift that makes the model convex and keeps the step within 1.5 radii, extended to the
    /// minimum of the model along it.
    pub(super) fn step_within(
        &mut self,
        engine: &Engine,
        (residual, drive): (&Residual, &PrescribedMotion),
        radius: f64,
        at: usize,
    ) -> Result<ModelStep, SolveError> {
        self.convexify(engine, at)?;
        let mut step = self.model_step(engine, residual, drive, at)?;
        for _ in 0..REFINEMENTS {
            if step.extent <= MARGIN * radius {
                break;
            }
            self.shift = self.shift_for(&step, step.extent / radius).max(LEAST_CHANGE * self.shift);
            self.factorise(engine, self.shift);
            step = self.model_step(engine, residual, drive, at)?;
        }
        if radius.is_finite() && self.shift > 0.0 {
            self.lengthen(engine, residual, &mut step, radius);
        }
        Ok(step)
    }

    /// Extends a shifted step Δ by w = (K + τM)⁻¹MΔ to the minimum of the model along it, within the radius. A shift
    /// that one direction asks for shortens all others, in a flat valley a hundredfold. Along w what is stiff hardly
    /// moves: along Δ itself, stretch and contact that the step has put right would be put wrong again by as much.
    fn lengthen(&mut self, engine: &Engine, residual: &Residual, step: &mut ModelStep, radius: f64) {
        let pull: Vec<f64> = step.raw.iter().zip(&engine.metric).map(|(x, m)| x * m).collect();
        let raw = self.solve_last(&pull);
        let mut way = raw.clone();
        self.zero_energy.remove(&mut way);
        let drag = self.shift * self.free_dot(engine, &raw, |i| pull[i]);
        let curvature = self.energy_norm_sq(engine, &raw, 0.0);
        let most = (radius - step.extent).max(0.0) / extent(engine, residual, &way);
        let longer = if curvature > 0.0 { most.min(drag / curvature) } else { most };
        let decrease = longer * (drag - 0.5 * longer * curvature);
        if !(longer.is_finite() && decrease > residual.rounding) {
            return;
        }
        let slope = self.free_dot(engine, &raw, |i| residual.gradient[i]);
        step.increment.iter_mut().zip(&way).for_each(|(x, w)| *x += longer * w);
        step.extent = extent(engine, residual, &step.increment);
        step.slope += longer * slope;
        step.curvature += longer * (longer * curvature - 2.0 * (slope + drag));
        step.inertia += longer * (2.0 * drag / self.shift + longer * self.inertia(engine, &raw));
    }

    /// The shift that shortens a step by a factor, if the step is a single mode with its Rayleigh quotient for
    /// eigenvalue, however soft: a shift that were too large for a slide would leave steps of steepest descent.
    pub(super) fn shift_for(&self, step: &ModelStep, shorter: f64) -> f64 {
        let ratio = step.curvature / step.inertia;
        if ratio.is_finite() { (ratio + self.shift) * shorter - ratio } else { FIRST_SHIFT }
    }
}

/// Extent of a step: the largest rotation of a node, rad, or the largest relative displacement of strands in contact
/// over their contact distance (at obstacles along the normal only, because sliding changes nothing there), or the
/// largest displacement of a rod that falls over the model's length.
fn extent(engine: &Engine, residual: &Residual, step: &[f64]) -> f64 {
    let falling = (0..engine.model.rods.len()).filter(|rod| is_falling(engine, *rod));
    let ways = falling.flat_map(|rod| engine.nodes(rod)).map(|node| displacement(step, node).norm());
    let turn = ways.map(|way| way / engine.scales.length).fold(largest_turn(step), f64::max);
    let side = &engine.contact;
    let sliding = |term: &crate::contact::potential::ContactPair| {
        let [a, _, b, _] = side.nodes_of(term);
        (displacement(step, a) - displacement(step, b)).norm()
            / (side.set.radius_of(term.slave) + side.set.radius_of(term.master))
    };
    let lifting = |contact: &crate::contact::potential::surface::SurfaceContact| {
        let surface = &side.surfaces[contact.surface];
        let normal = surface.normal(&(side.set.segments[contact.segment].b[0] - surface.point()));
        let body = BodyMotion::of(side, contact.surface, step).displacement;
        (displacement(step, side.nodes[contact.segment][0]) - body).dot(&normal).abs()
            / (2.0 * side.set.radius_of(contact.segment))
    };
    let turn = residual.surface_contacts.iter().map(lifting).fold(turn, f64::max);
    residual.contact_pairs.iter().map(sliding).fold(turn, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::{Contact, Joint, Model, NodeLoad, NodeRef, Support};

    /// Two columns along z, one on the other by a pin, clamped at both ends but for the height of the upper one, under
    /// a load beyond the critical one and a small one aside.
    fn columns() -> Engine {
        let rod = |height: f64| {
            let shape = Shape::Line { start: Vec3::z() * height, direction: Vec3::z(), length: 1.0 };
            let section = Section::isotropic(1.0, 1.0, 1e6, 1e6, 0.0);
            Rod::new("column", &shape, RodMesh::open(4, 3), section, Natural::Straight).unwrap()
        };
        let rods = vec![rod(0.0), rod(1.0)];
        let [foot, middle, upper, top] = [(0, 0), (0, 12), (1, 0), (1, 12)].map(|(rod, node)| NodeRef { rod, node });
        let guide = Support { position: [true, true, false], ..Support::clamp(top) };
        let loads = vec![
            NodeLoad { node: top, force: Vec3::z() * -15.0, moment: Vec3::zeros() },
            NodeLoad { node: middle, force: Vec3::x() * 0.1, moment: Vec3::zeros() },
        ];
        let model = Model {
            rods,
            supports: vec![Support::clamp(foot), guide],
            joints: vec![Joint::pin(middle, upper)],
            loads,
            load: 1.0,
            contact: Contact::NONE,
            ..Model::default()
        };
        Engine::new(model, None).unwrap()
    }

    /// The numbers of a lengthened step are those of the model along it; it falls farther than the shifted one, and
    /// compresses the columns by no more.
    #[test]
    fn a_shifted_step_goes_on_along_what_is_soft() {
        let mut engine = columns();
        let state = engine.state().clone();
        let mut workspace = Workspace::default();
        workspace.refresh(&mut engine, &state).unwrap();
        let (stress, drive) = (engine.stress_with(&state, &[[[0.0, 0.0, -15.0]; 3]; 8]), PrescribedMotion::default());
        let residual = workspace.linearise(&engine, &state, &stress, &drive);
        let step = workspace.step_within(&engine, (&residual, &drive), 0.5, 0).unwrap();
        assert!(workspace.shift > 0.0);
        assert!(step.extent <= MARGIN * 0.5, "{}", step.extent);
        let slope = workspace.free_dot(&engine, &step.increment, |i| residual.gradient[i]);
        let curvature = workspace.energy_norm_sq(&engine, &step.increment, 0.0);
        let inertia = workspace.inertia(&engine, &step.increment);
        for (found, exact) in [(step.slope, slope), (step.curvature, curvature), (step.inertia, inertia)] {
            assert!((found - exact).abs() <= 1e-6 * exact.abs(), "{found} is not {exact}");
        }
        let plain = workspace.model_step(&engine, &residual, &drive, 0).unwrap();
        let falls = |step: &ModelStep| -step.slope - 0.5 * step.curvature;
        assert!(falls(&step) > 1.05 * falls(&plain), "{} {}", falls(&step), falls(&plain));
        let top = 6 * (engine.num_nodes() - 1) + 2;
        let [longer, shorter] = [&step, &plain].map(|step| step.increment[top]);
        assert!((longer / shorter - 1.0).abs() < 1e-3, "{longer} {shorter}");
    }
}
