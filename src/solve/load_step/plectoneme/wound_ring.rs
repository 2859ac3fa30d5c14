//! Snap of a ring into a plectoneme by several turns at once.
//!
//! A ring with more than √3 B/C turns buckles out of its plane (Michell 1889, Zajac 1962), and with several turns more
//! it ends as a double helix between two loops. Its shape is known: the plectoneme of least energy at that link
//! ([`Plectoneme::of_link`]). The way there from the ring leads through other equilibria and costs hundreds of
//! iterations, the more the longer the ring.

use std::f64::consts::TAU;

use crate::math::Vec3;
use crate::rod::{Axis, Natural, Plectoneme, Rod, RodMesh, Shape};
use crate::solve::load_step::core_law::TURNS_AT_ONCE;
use crate::solve::load_step::plectoneme::periodic_extension::centre;
use crate::solve::load_step::solver::Solver;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::state::{PrescribedValue, State};

/// Total curvature below which a ring is no knot (Fáry 1949, Milnor 1950), rad.
const UNKNOTTED: f64 = 2.0 * TAU;

impl Solver {
    /// The plectoneme with the link to which a drive turns the only rod; `None` unless that is by more than a turn, and
    /// the rod a free uniform ring that may be no knot and is long enough. It lies with its ends where node 0 and the
    /// one opposite to it are, as far as that goes.
    pub(super) fn wound_ring(&self, drive: &PrescribedMotion) -> Option<State> {
        if drive.parts(TURNS_AT_ONCE).len() < 2 {
            return None;
        }
        let (rod, state) = (self.free_uniform_ring()?, self.engine.state());
        if total_curvature(state.positions()) >= UNKNOTTED {
            return None;
        }
        let seam = state.seams()[0] + drive.seams[0];
        let (link, section) = (seam / TAU, rod.section);
        let distance = 2.0 * self.engine.contact.min_radius;
        let [bending, _] = section.bending;
        let plectoneme = Plectoneme::of_link(rod.length, distance, bending, section.twisting, link).ok()?;
        let direction = state.positions()[state.positions().len() / 2] - state.positions()[0];
        let shape = Shape::Plectoneme(plectoneme.about(Axis::Straight { center: centre(state), direction }));
        let mesh = RodMesh::closed(rod.num_elements, rod.order);
        let wound = Rod::new(&rod.name, &shape, mesh, section, Natural::Straight).ok()?.with_excess_link(link).ok()?;
        let mut made = state.with_nodes(wound.positions, wound.frames);
        made.prescribe([PrescribedValue::Seam(0, seam)]);
        Some(made)
    }
}

/// Sum of the angles between the sides of a closed polygon, rad.
fn total_curvature(points: &[Vec3]) -> f64 {
    let side = |k: usize| points[(k + 1) % points.len()] - points[k];
    (0..points.len()).map(|k| side(k).angle(&side((k + 1) % points.len()))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Section, TorusKnot};
    use crate::scene::{Model, NodeRef, Support};
    use crate::solve::load_step::guess::Ahead;
    use crate::solve::load_step::nested_iteration::tests::{energy, turns};
    use crate::solve::load_step::step_report::{Origin, Status};
    use crate::solve::options::Options;

    const ELEMENTS: usize = 120;

    fn solver(shape: &Shape, radius: f64, supports: Vec<Support>) -> Solver {
        let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, radius);
        let rod = Rod::new("ring", shape, RodMesh::closed(ELEMENTS, 3), section, Natural::Straight).unwrap();
        Solver::new(Model { rods: vec![rod], supports, ..Model::default() }, Options::default()).unwrap()
    }

    fn ring() -> Solver {
        let normal = Vec3::new(0.3, -0.2, 1.0);
        solver(&Shape::Circle { length: 1.0, center: Vec3::new(0.1, 0.2, 0.3), normal }, 0.004, vec![])
    }

    /// Either way round, the plectoneme has the prescribed link, no more energy than the state that the long way leads
    /// to, and lies where the ring was, for a small part of the iterations.
    #[test]
    fn rings_snap_into_plectonemes() {
        let mut slow = ring();
        let long = slow.load_step_from(&[Origin::CoreLaw], &turns(-6.0), &Ahead::Unknown);
        assert_eq!((long.status, long.num_unstable), (Status::Converged, 0));
        for by in [-6.0, 6.0] {
            let mut quick = ring();
            let before = quick.engine.state().clone();
            let report = quick.load_step_from(&[Origin::ClosedPlectoneme], &turns(by), &Ahead::Unknown);
            assert_eq!((report.status, report.start), (Status::Converged, Some(Origin::ClosedPlectoneme)));
            assert!(report.num_unstable == 0 && report.escapes > 0 && report.branch_ends && report.penetration <= 1e-8);
            assert!(3 * report.iterations < long.iterations, "{} {}", report.iterations, long.iterations);
            // the loops lie elsewhere on the mesh
            assert!(energy(&quick) < energy(&slow) * (1.0 + 1e-5), "{} {}", energy(&quick), energy(&slow));
            let state = quick.engine.state();
            assert_eq!(state.seams()[0], before.seams()[0] + by * TAU);
            assert!((centre(state) - centre(&before)).norm() < 0.05);
            let along = |state: &State| (state.positions()[0] - state.positions()[3 * ELEMENTS / 2]).normalize();
            let turned = along(state).angle(&along(&before));
            assert!(turned < 0.1, "{turned}");
        }
    }

    /// What follows a branch, is held, thick or may be a knot is left alone.
    #[test]
    fn other_rings_are_left_alone() {
        let wound = |solver: &Solver, by: f64| solver.wound_ring(&turns(by)).is_some();
        assert!(wound(&ring(), 6.0) && wound(&ring(), -3.0));
        assert!(!wound(&ring(), 1.0), "a single turn");
        assert!(!wound(&ring(), -1.5), "no plectoneme has less energy");
        let circle = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
        let held = Support { node: NodeRef { rod: 0, node: 3 }, position: [true; 3], rotation: [false; 3] };
        assert!(!wound(&solver(&circle, 0.004, vec![held]), 6.0), "held");
        assert!(!wound(&solver(&circle, 0.05, vec![]), 6.0), "thick");
        let trefoil = Shape::TorusKnot(TorusKnot::new(1.0, [2, 3]));
        assert!(!wound(&solver(&trefoil, 0.004, vec![]), 6.0), "a knot");
        // a ring that stays flat: nothing to snap
        let mut stiff = ring();
        assert!(stiff.closed_plectoneme(&PrescribedMotion::default(), false, &mut 0).unwrap().is_none());
    }
}
