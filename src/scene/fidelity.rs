//! Accuracy presets: mesh, contact law and tolerances that belong together.

use super::{Contact, ContactLaw};

/// Accuracy of a scene: one setting for mesh, contact law and tolerances. Presets lie near the Pareto front of error
/// and work of `cargo bench --bench work_precision`; `docs/notes/accuracy.md` gives the distance, case by case. Costs
/// and errors are stated there and in [`Fidelity::accuracy`]; `tests/solver/fidelity.rs` holds them on cases that did
/// not select the presets.
///
/// | | `Draft` | `Balanced` | `Reference` |
/// |---|---|---|---|
/// | cubic elements per turn of bending or twist | 3 | 8 | 16 |
/// | spacing of nodes over the contact distance, at most | 2 | 0.7 | 0.25 |
/// | contact stiffness κε⁴/B, by the mesh, at least | 10 | 10 | 1000 |
/// | penetration left, over ε | 1e-2 | 1e-4 | 1e-8 |
/// | last Newton increment | 1e-4 | 1e-6 | 1e-8 |
/// | energy, relative error stated (worst measured) | 1e-2 (7e-3) | 1e-3 (6e-4) | 1e-4 (5e-5) |
/// | writhe | 1e-2 (6e-3) | 2e-3 (6e-4) | 5e-4 (3e-4) |
/// | twisting moment | 5e-2 (3e-2) | 5e-3 (1.5e-3) | 1e-3 (5e-4) |
/// | contact force | 2e-2 (8e-3) | 2e-3 (1.4e-3) | 5e-4 (2e-4) |
/// | positions without contact, over the length | 1e-3 (2e-5) | 1e-5 (5e-8) | 1e-7 (8e-10) |
/// | work (Newton iterations × nodes) and time, relative | 1 | 2.2 to 3.6 | 6 to 14 |
///
/// Worst measured: over all cases of the benchmark, each on three meshes a few percent apart, because a single mesh may
/// have a small error by chance.
///
/// A mesh must resolve two lengths. First, bending and twist vary with the turns of the rod, so elements are counted
/// per turn. Second, strands that wind around each other or lie along each other vary over lengths of the order of the
/// distance of their centrelines, for any length of the rod, so the spacing of nodes is limited to a multiple of it.
/// The contact law follows the mesh ([`ContactLaw::ByMesh`]). A long rod that touches at isolated points only does not
/// need the second limit; its `elements` may be given.
///
/// In a scene file, `fidelity = "draft"`; without one:
///
/// ```
/// use supercoil::math::Vec3;
/// use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
/// use supercoil::scene::{Fidelity, Model, Ramp, Stage};
/// use supercoil::solve::{Options, Status, run};
///
/// let fidelity = Fidelity::Draft;
/// let (length, radius, excess_link) = (1.0, 0.02, 1.4);
/// let circle = Shape::Circle { length, center: Vec3::zeros(), normal: Vec3::z() };
/// let section = Section::isotropic(1.0, 1.5, 1e5, 1e5, radius);
/// let elements = fidelity.elements(length, 1.0 + excess_link, radius);
/// let rod = Rod::new("ring", &circle, RodMesh::closed(elements, Fidelity::ORDER), section, Natural::Straight)?;
/// let model = Model { rods: vec![rod], contact: fidelity.contact(), ..Model::default() };
/// let twist = Stage::new(vec![Ramp::ExcessLink { rod: 0, to: excess_link }], 5);
/// let solution = run(model, &[twist], &Options::from(fidelity), &mut |_| std::ops::ControlFlow::Continue(()))?;
/// assert_eq!(solution.status, Status::Converged);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[cfg_attr(feature = "scenes", derive(schemars::JsonSchema))]
pub enum Fidelity {
    /// Exploration: shapes, order of events, forces to some percent.
    Draft,
    /// Default accuracy: a part in a thousand.
    Balanced,
    /// Reference solutions.
    Reference,
}

/// Bounds of the relative errors of a preset; see [`Fidelity::accuracy`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Elastic energy.
    pub energy: f64,
    /// Writhe of a closed rod.
    pub writhe: f64,
    /// Twisting moment of a closed rod.
    pub twisting_moment: f64,
    /// Sum of the forces of all contact sites.
    pub contact_force: f64,
    /// Positions of ends of elements of a rod without contact, over its length.
    pub position: f64,
    /// Penetration over the smallest contact radius.
    pub penetration: f64,
}

impl Fidelity {
    /// All presets, least work first.
    pub const ALL: [Self; 3] = [Self::Draft, Self::Balanced, Self::Reference];
    /// Order of the elements of presets.
    pub const ORDER: usize = 3;

    /// Bounds of the errors in stable states of rods whose turns were estimated well (see [`Fidelity::elements`]), with
    /// small stretch and shear. Near a change of branch or of the contact pattern the errors of moment and force are
    /// larger.
    pub const fn accuracy(self) -> Accuracy {
        let [energy, writhe, twisting_moment, contact_force, position, penetration] = match self {
            Self::Draft => [1e-2, 1e-2, 5e-2, 2e-2, 1e-3, 1e-2],
            Self::Balanced => [1e-3, 2e-3, 5e-3, 2e-3, 1e-5, 1e-4],
            Self::Reference => [1e-4, 5e-4, 1e-3, 5e-4, 1e-7, 1e-8],
        };
        Accuracy { energy, writhe, twisting_moment, contact_force, position, penetration }
    }

    /// The contact law: augmented Lagrangian, as stiff as the mesh carries, to the penetration of
    /// [`Fidelity::accuracy`].
    pub const fn contact(self) -> Contact {
        let (least, tol_penetration) = (self.least_stiffness(), self.accuracy().penetration);
        Contact { law: ContactLaw::ByMesh { least, tol_penetration } }
    }

    /// Smallest contact stiffness κε⁴/B of the preset, on coarse meshes.
    pub const fn least_stiffness(self) -> f64 {
        match self {
            Self::Draft | Self::Balanced => 10.0,
            Self::Reference => 1000.0,
        }
    }

    /// Newton's tolerance, see `solve::NewtonOptions::tol_increment`.
    pub const fn tol_increment(self) -> f64 {
        match self {
            Self::Draft => 1e-4,
            Self::Balanced => 1e-6,
            Self::Reference => 1e-8,
        }
    }

    /// Number of cubic elements for a rod of a length \[L\] with a total of `turns` of bending and twist, and a contact
    /// radius \[L\] (0: no contact).
    ///
    /// `turns` is an estimate: 1 for a circle, 1 + |excess link| for a supercoiled ring, the turns of a helix. A force
    /// F bends a rod within a length (B/F)^½, which makes L/2π·(F/B)^½ turns; a moment M makes L/2π·M/B. Less than one
    /// counts as one.
    pub fn elements(self, length: f64, turns: f64, contact_radius: f64) -> usize {
        let (per_turn, spacing) = match self {
            Self::Draft => (3.0, 2.0),
            Self::Balanced => (8.0, 0.7),
            Self::Reference => (16.0, 0.25),
        };
        let by_turns = per_turn * turns.max(1.0);
        let by_contact =
            if contact_radius > 0.0 { length / (Self::ORDER as f64 * spacing * 2.0 * contact_radius) } else { 0.0 };
        // a value that exceeds a whole number by rounding counts as that number
        (by_turns.max(by_contact) * (1.0 - 1e-12)).ceil() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_follow_turns_or_contact_distance() {
        for (fidelity, straight, five_turns, tight) in
            [(Fidelity::Draft, 3, 15, 167), (Fidelity::Balanced, 8, 40, 477), (Fidelity::Reference, 16, 80, 1334)]
        {
            assert_eq!(fidelity.elements(1.0, 0.0, 0.0), straight);
            assert_eq!(fidelity.elements(7.0, 5.0, 0.0), five_turns);
            assert_eq!(fidelity.elements(7.0, 5.0, 3.5e-3), tight);
        }
    }

    #[test]
    fn accuracy_grows() {
        for pair in Fidelity::ALL.windows(2) {
            let [a, b] = [pair[0].accuracy(), pair[1].accuracy()];
            let all = |x: Accuracy| [x.energy, x.writhe, x.twisting_moment, x.contact_force, x.position, x.penetration];
            assert!(all(a).iter().zip(all(b)).all(|(x, y)| *x > y));
            assert!(pair[0].tol_increment() > pair[1].tol_increment());
        }
    }
}
