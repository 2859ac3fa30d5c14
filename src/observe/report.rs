//! The report of an accepted state: plain data, serialisable, with units. [`observe`](super::observe) fills it.

use crate::certificate::Certificate;
use crate::scene::ObstaclePose;

/// Energies by kind \[F·L\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Energies {
    /// ½∫EA Γ3².
    pub stretching: f64,
    /// ½∫GA1 Γ1² + GA2 Γ2².
    pub shearing: f64,
    /// ½∫EI1 K1² + EI2 K2².
    pub bending: f64,
    /// ½∫GJ K3².
    pub twisting: f64,
    /// Energy stored in the contact law.
    pub contact: f64,
    /// Energy of screened charges, of points of one rod beyond that of the straight rod.
    #[cfg_attr(feature = "serde", serde(default))]
    pub electrostatic: f64,
    /// Sum of the above (work of loads not included).
    pub total: f64,
}

impl Energies {
    /// All energies divided by a unit of energy \[F·L\].
    #[must_use]
    pub fn over(&self, unit: f64) -> Self {
        Self {
            stretching: self.stretching / unit,
            shearing: self.shearing / unit,
            bending: self.bending / unit,
            twisting: self.twisting / unit,
            contact: self.contact / unit,
            electrostatic: self.electrostatic / unit,
            total: self.total / unit,
        }
    }
}

/// Kind of a contact site; comparable with its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum SiteKind {
    /// An isolated contact: short, between two strands that bend away from each other.
    Point,
    /// Longer: the strands lie along each other.
    Line,
}

impl SiteKind {
    /// "point" or "line".
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Line => "line",
        }
    }
}

impl PartialEq<&str> for SiteKind {
    fn eq(&self, name: &&str) -> bool {
        self.as_str() == *name
    }
}

/// A contact site: a zone of arc length on strand a pressing on its partner zone on strand b.
///
/// Arc lengths are reference ones from the start of the rod; on a closed rod an interval that ends below its start runs
/// over the seam. Strand a is the one on the lower rod, on one rod the one whose interval starts first.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SiteReport {
    /// Rod of strand a.
    pub rod_a: usize,
    /// Arc length interval on strand a \[L\].
    pub arc_a: [f64; 2],
    /// Rod of strand b.
    pub rod_b: usize,
    /// Arc length interval on strand b \[L\].
    pub arc_b: [f64; 2],
    /// "line" where the mean of both intervals is longer than 3.9 (B/κ)^¼ for rods of equal bending stiffness B (the
    /// smaller of the two of a section) under a law of stiffness κ, "point" otherwise. That is 1.5 times the zone of a
    /// point contact at the load at which it opens into a line or into two points. Stiffer laws shorten the zone of a
    /// point (as κ^(−1/3)), but not a line. Contacts nearer to each other on both strands than two layers (B/κ)^¼ are
    /// one site, because the pressure of a line may vanish between nodes; so are three or more in a row, each within an
    /// element of the next, because light pressure gathers once an element. Only contacts that press about as hard as
    /// each other are joined, and what is joined is a line only if it is longer than an element.
    pub kind: SiteKind,
    /// Smallest gap inside the zone \[L\]; negative = penetration.
    pub gap: f64,
    /// Contact force: integral of the pressure over the zone \[F\].
    pub force: f64,
    /// Centre of the force on strands a and b: mean arc length weighted with the pressure \[L\].
    pub center: [f64; 2],
    /// Standard deviation of the pressure's distribution about `center` on strands a and b \[L\]: half the distance of
    /// two equal forces, length/√12 of a uniform line, below the width of the contact law's layer for a point.
    pub spread: [f64; 2],
    /// Crossing angle of the tangents where the gap is smallest, degrees in 0..=90.
    pub angle: f64,
    /// Force on strand a \[F\], in the global axes; strand b bears the opposite. Shorter than `force` if the direction
    /// of the pressure varies along the zone.
    pub force_on_a: [f64; 3],
    /// Moment of the force on strand a about the first of the `feet` \[F·L\]; strand b bears the opposite about that
    /// point.
    #[cfg_attr(feature = "serde", serde(default))]
    pub moment_on_a: [f64; 3],
    /// Points of the centrelines of strands a and b where the gap is smallest \[L\].
    pub feet: [[f64; 3]; 2],
}

/// Contact at one point of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LineSample {
    /// Index of the site.
    pub site: usize,
    /// Rod of strand a.
    pub rod_a: usize,
    /// Arc length on strand a \[L\].
    pub arc_a: f64,
    /// Rod of strand b.
    pub rod_b: usize,
    /// Arc length on strand b \[L\].
    pub arc_b: f64,
    /// Force per arc length of strand a \[F/L\], smoothed over the width of the contact law or half an element; its
    /// integral is the site's force.
    pub pressure: f64,
    /// Gap \[L\].
    pub gap: f64,
}

/// A contact site of a rod with an obstacle.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ObstacleSite {
    /// Obstacle index.
    pub obstacle: usize,
    /// Rod index.
    pub rod: usize,
    /// Arc length interval on the rod \[L\]; on a closed rod one that ends below its start runs over the seam.
    pub arc: [f64; 2],
    /// As between rods ([`SiteReport::kind`]), for an obstacle that does not bend: "line" from 4.6 (B/κ)^¼ on.
    pub kind: SiteKind,
    /// Smallest gap in it \[L\].
    pub gap: f64,
    /// ∫p ds \[F\].
    pub force: f64,
    /// Arc length of the centre of pressure \[L\].
    pub center: f64,
    /// Force of the obstacle on the rod \[F\].
    pub force_on_rod: [f64; 3],
    /// Its moment about `nearest` \[F·L\].
    #[cfg_attr(feature = "serde", serde(default))]
    pub moment_on_rod: [f64; 3],
    /// Point of the centreline where the gap is smallest \[L\].
    pub nearest: [f64; 3],
}

/// Force of an obstacle on all rods together.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ObstacleReaction {
    /// Obstacle index.
    pub obstacle: usize,
    /// Where it is.
    pub placement: ObstaclePose,
    /// ∫p ds \[F\], never negative; of a plane the force along its normal.
    pub force: f64,
    /// Its force on the rods \[F\].
    pub force_on_rods: [f64; 3],
}

/// Force and moment a support exerts on the rod, in the global axes: a stretched rod is pulled outwards at its end.
/// They sum to what all supports bear, also where joined nodes have one each.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reaction {
    /// Rod index.
    pub rod: usize,
    /// Node index.
    pub node: usize,
    /// Force \[F\], zero in free components.
    pub force: [f64; 3],
    /// Moment \[F·L\], zero in free components; of a support that holds the rotation about one axis, the whole vector.
    pub moment: [f64; 3],
}

/// Force and moment that a joint exerts on a rod at one of its nodes, in the global axes. Those on all nodes of a joint
/// add up to zero: what a support there exerts is a [`Reaction`].
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointForce {
    /// Index of the point where nodes are joined: the same for all nodes that joints connect.
    pub point: usize,
    /// Rod index.
    pub rod: usize,
    /// Node index.
    pub node: usize,
    /// Force \[F\].
    pub force: [f64; 3],
    /// Moment about the node \[F·L\]; of a pin zero, of a hinge zero about its axis.
    pub moment: [f64; 3],
}

/// Link numbers of one closed rod, in turns; `link = twist + writhe`.
///
/// `link` is measured on a fine polygon, where Tw + Wr is exact: it must equal `excess_link`, and the natural link of
/// the rod ([`natural_link`](crate::rod::Rod::natural_link)) on top, to rounding for as long as no strand has passed
/// through another (and shear has not turned d1 into the tangent, where the material line has no link). On the polygon
/// each of the two parts is only of second order in its edges. So `twist` is the elements' quadrature
/// ([`Engine::twist`](crate::solve::Engine::twist)) and `writhe` the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RodLink {
    /// Rod index.
    pub rod: usize,
    /// Prescribed: link beyond that of the relaxed rod, see [`crate::rod::Rod::natural_link`].
    pub excess_link: f64,
    /// Measured Tw + Wr.
    pub link: f64,
    /// Twist Tw of the material direction d1 about the centreline.
    pub twist: f64,
    /// (1/2π)∫K3 ds beyond the rod's natural twist: the part with elastic energy.
    pub excess_twist: f64,
    /// Writhe Wr.
    pub writhe: f64,
    /// Twisting moment M3 that the rod transmits at its seam \[F·L\]; positive if overtwisted.
    pub seam_moment: f64,
}

/// Numbers of a rod that stages may change and files need.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RodSize {
    /// Reference length \[L\].
    pub length: f64,
    /// Contact radius \[L\].
    pub contact_radius: f64,
    /// Smaller bending stiffness \[F·L²\].
    #[cfg_attr(feature = "serde", serde(default))]
    pub bending: f64,
}

/// Ends of an open rod.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RodEnds {
    /// Rod index.
    pub rod: usize,
    /// Position of the node at s = 0 \[L\].
    pub start: [f64; 3],
    /// Position of the last node \[L\].
    pub end: [f64; 3],
    /// Twist Tw of d1 about the centreline, turns.
    pub twist: f64,
    /// (1/2π)∫K3 ds beyond the rod's natural twist, turns: the part with elastic energy.
    pub excess_twist: f64,
    /// Link of the rod extended by straight lines at both ends: rotation of its end relative to its start, turns. For
    /// rods whose end tangents are parallel (to 1e-3 rad) and of the same direction.
    pub link: Option<f64>,
    /// Writhe of the extended rod, turns: `link` − `twist`.
    pub writhe: Option<f64>,
}

/// Linking number of two closed rods.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Linking {
    /// One rod.
    pub rod_a: usize,
    /// The other.
    pub rod_b: usize,
    /// Linking number; its sign depends on the rods' directions.
    pub link: f64,
}

/// Knot type and tightness of a rod. Open rods are closed by straight lines outwards from their ends.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Knot {
    /// Rod index.
    pub rod: usize,
    /// Name of the simplest knot with its Alexander and Jones polynomials, as "3_1": up to eight crossings, "other"
    /// beyond. A star marks the mirror image of the knot of that name.
    pub name: String,
    /// |Δ(−1)| of the Alexander polynomial Δ, the knot's determinant; 1 where it is not knotted.
    pub determinant: f64,
    /// |Δ(exp(2πi/3))|.
    pub at_third: f64,
    /// Length of the centreline over the diameter of the thickest tube about it that does not overlap: for closed rods
    /// that nearly touch.
    pub ropelength: Option<f64>,
}

/// Smallest gap of a state, enclosed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GapReport {
    /// Lower bound of the smallest gap \[L\]; of the elements' centrelines that found less the accuracy of the search.
    pub lower: f64,
    /// Upper bound \[L\].
    pub upper: f64,
    /// Where: rod and arc length on both strands.
    pub rod_a: usize,
    /// Arc length on strand a \[L\].
    pub arc_a: f64,
    /// Rod of strand b.
    pub rod_b: usize,
    /// Arc length on strand b \[L\].
    pub arc_b: f64,
}

/// The report of one accepted state.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Observation {
    /// Stage index, 0-based.
    pub stage: usize,
    /// Accepted step within the run, 0-based (0 = start).
    pub step: usize,
    /// Fraction of the stage done, 0..=1.
    pub fraction: f64,
    /// "converged", or why not; "overlap": an equilibrium in which tubes overlap where contact does not resist it;
    /// "fails …": one of which a check of the certificate does not hold.
    pub status: String,
    /// Warnings about the state, as text: a snap before it; overlaps that contact does not resist (it acts between
    /// strands, not between neighbours along one, so a rod bent more tightly than its contact radius overlaps itself);
    /// a contact law softer than prescribed.
    #[cfg_attr(feature = "serde", serde(default))]
    pub notes: Vec<String>,
    /// Link numbers of closed rods.
    pub links: Vec<RodLink>,
    /// Energies by kind.
    pub energies: Energies,
    /// Smallest gap of the elements' own centrelines, which carry the energy; `None` when nothing is within two
    /// diameters of the thinnest rod, or contact is off.
    pub min_gap: Option<GapReport>,
    /// Smallest gap of the smooth curves through the nodes between which contact acts, certified: what the solver
    /// closes. `min_gap` differs from it by what the mesh does not resolve.
    #[cfg_attr(feature = "serde", serde(default))]
    pub contact_gap: Option<GapReport>,
    /// Number of contact sites, those with obstacles included.
    pub num_sites: usize,
    /// Length and contact radius of each rod.
    #[cfg_attr(feature = "serde", serde(default))]
    pub sizes: Vec<RodSize>,
    /// Ends of open rods.
    #[cfg_attr(feature = "serde", serde(default))]
    pub ends: Vec<RodEnds>,
    /// Linking numbers of closed rods, where there are several.
    #[cfg_attr(feature = "serde", serde(default))]
    pub linking: Vec<Linking>,
    /// Knots of rods with few enough nodes.
    #[cfg_attr(feature = "serde", serde(default))]
    pub knots: Vec<Knot>,
    /// Contact sites; a [record](crate::io::record::Record) keeps only the strongest of each step.
    pub sites: Vec<SiteReport>,
    /// Contact sites of rods with obstacles.
    #[cfg_attr(feature = "serde", serde(default))]
    pub obstacle_sites: Vec<ObstacleSite>,
    /// Forces of obstacles, one entry for each.
    #[cfg_attr(feature = "serde", serde(default))]
    pub obstacle_reactions: Vec<ObstacleReaction>,
    /// Integral of the contact pressure: sum of the forces of all sites, those with obstacles included \[F\].
    pub total_contact_force: f64,
    /// Sum over all sites of the length of the force vector on a strand \[F\]: less than the integral if the direction
    /// of the pressure varies along a site, as in a plectoneme; otherwise an order more accurate.
    #[cfg_attr(feature = "serde", serde(default))]
    pub contact_resultants: f64,
    /// Reactions at supports.
    pub reactions: Vec<Reaction>,
    /// Forces of joints on the rods, one entry for each joined node.
    #[cfg_attr(feature = "serde", serde(default))]
    pub joints: Vec<JointForce>,
    /// Bending and twisting energy that a finer mesh would change, over that of the state: an estimate, of the order of
    /// the relative error of the energy. A [`Fidelity`](crate::scene::Fidelity) states how much its mesh should leave.
    #[cfg_attr(feature = "serde", serde(default))]
    pub mesh_error: f64,
    /// What holds of the state, by checks that share nothing with the solver.
    #[cfg_attr(feature = "serde", serde(default))]
    pub certificate: Certificate,
    /// Number of unstable directions of the accepted state; of moments of fixed direction in space, which have no
    /// potential, negative eigenvalues of the tangent's symmetric part, which decide nothing.
    pub num_unstable: usize,
    /// Energy set free by a snap of this step \[F·L\], see
    /// [`StepReport::energy_released`](crate::solve::StepReport::energy_released); 0 where the rods followed a stable
    /// path.
    #[cfg_attr(feature = "serde", serde(default))]
    pub energy_released: f64,
    /// Newton iterations spent on this step (all outer loops).
    pub iterations: usize,
    /// Newton iterations on a shorter rod or a coarser mesh that prepared this step.
    pub iterations_on_other_meshes: usize,
    /// Wall time spent on this step \[s\].
    pub seconds: f64,
}

impl Observation {
    /// Whether tubes overlap in an equilibrium where contact does not resist it.
    pub fn overlaps(&self) -> bool {
        self.status == super::OVERLAP
    }

    /// Whether it is an equilibrium of which a check of the certificate does not hold.
    pub fn fails(&self) -> bool {
        self.status.starts_with(super::state::FAILING)
    }
}
