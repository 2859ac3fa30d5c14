//! What is told of an accepted state: plain data, serialisable, with units. Filled by the solver's observer.

use serde::Serialize;

/// Energies by kind \[F·L\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Energies {
    /// ½∫EA Γ3².
    pub stretch: f64,
    /// ½∫GA1 Γ1² + GA2 Γ2².
    pub shear: f64,
    /// ½∫EI1 K1² + EI2 K2².
    pub bend: f64,
    /// ½∫GJ K3².
    pub twist: f64,
    /// Energy stored in the contact law.
    pub contact: f64,
    /// Sum of the above (work of loads not included).
    pub total: f64,
}

/// A contact site: a zone of arc length on strand a pressing on its partner zone on strand b.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SiteReport {
    /// Rod of strand a.
    pub rod_a: usize,
    /// Arc length interval on strand a \[L\].
    pub arc_a: [f64; 2],
    /// Rod of strand b.
    pub rod_b: usize,
    /// Arc length interval on strand b \[L\].
    pub arc_b: [f64; 2],
    /// "point" or "line".
    pub kind: &'static str,
    /// Smallest gap inside the zone \[L\]; negative = penetration.
    pub gap: f64,
    /// Contact force: integral of the pressure over the zone \[F\].
    pub force: f64,
    /// Crossing angle of the tangents where the gap is smallest, degrees in 0..=90.
    pub angle: f64,
}

/// Force and moment a support exerts on the rod.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reaction {
    /// Rod index.
    pub rod: usize,
    /// Node index.
    pub node: usize,
    /// Force \[F\], zero in free components.
    pub force: [f64; 3],
    /// Moment \[F·L\], zero in free components.
    pub moment: [f64; 3],
}

/// Link numbers of one closed rod, in turns.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RodLink {
    /// Rod index.
    pub rod: usize,
    /// Prescribed excess link.
    pub excess_link: f64,
    /// Measured Tw + Wr.
    pub link: f64,
    /// Twist Tw.
    pub twist: f64,
    /// Writhe Wr.
    pub writhe: f64,
    /// Twisting moment at the seam \[F·L\].
    pub seam_moment: f64,
}

/// Smallest certified clearance of the state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GapReport {
    /// Lower bound of the smallest gap \[L\].
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

/// Everything reported about one accepted state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Observation {
    /// Stage index, 0-based.
    pub stage: usize,
    /// Accepted step within the run, 0-based (0 = start).
    pub step: usize,
    /// Fraction of the stage done, 0..=1.
    pub fraction: f64,
    /// "converged" or why not.
    pub status: String,
    /// Link numbers of closed rods.
    pub links: Vec<RodLink>,
    /// Energies by kind.
    pub energies: Energies,
    /// Smallest gap; `None` when nothing is within two diameters or contact is off.
    pub min_gap: Option<GapReport>,
    /// Contact sites.
    pub sites: Vec<SiteReport>,
    /// Sum of the sites' forces \[F\].
    pub total_contact_force: f64,
    /// Reactions at supports.
    pub reactions: Vec<Reaction>,
    /// Number of unstable directions of the accepted state.
    pub num_unstable: usize,
    /// Newton iterations spent on this step (all outer loops).
    pub iterations: usize,
    /// Wall time spent on this step \[s\].
    pub seconds: f64,
}
