//! The minicircle whose link the page turns, its numbers and its picture. Units: nm, pN.

use supercoil::contact::{Curve, Detector, DetectorOptions};
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Progress, Solver, Status, StepReport};
use supercoil::{InputError, dna};

/// Elements of the ring: the error of its writhe at an excess link of −3 is then below 1e-3.
const ELEMENTS: usize = 48;
/// Largest step of the excess link, turns: small enough to be seen as motion.
const STEP: f64 = 0.1;
/// How often a step that does not converge is halved.
const MAX_HALVINGS: u32 = 5;
/// Salt, mol/l of sodium chloride: strands keep 5 nm apart.
const SALT: f64 = 0.15;

/// Name and unit of each number of [`Ring::row`].
pub const COLUMNS: [(&str, &str); 11] = [
    ("step", ""),
    ("excess_link", "turns"),
    ("writhe", "turns"),
    ("twist", "turns"),
    ("bending_energy", "pN nm"),
    ("twisting_energy", "pN nm"),
    ("min_gap", "nm"),
    ("num_sites", ""),
    ("contact_force", "pN"),
    ("num_unstable", ""),
    ("iterations", ""),
];

/// A DNA minicircle of 336 base pairs whose link may be turned.
#[derive(Debug)]
pub struct Ring {
    solver: Solver,
    excess_link: f64,
    num_steps: usize,
    seen: Observation,
}

/// A state as it is drawn.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Nodes \[nm\].
    pub points: Vec<Vec3>,
    /// Material direction d1 of each.
    pub directions: Vec<Vec3>,
    /// Contact force per length of each \[pN/nm\].
    pub pressure: Vec<f64>,
    /// Curvature of each \[1/nm\].
    pub curvature: Vec<f64>,
    /// Twist a length of each \[rad/nm\].
    pub twist_rate: Vec<f64>,
    /// Contact forces \[pN\] and the points they act on \[nm\].
    pub forces: Vec<[Vec3; 2]>,
}

impl Ring {
    /// The relaxed circle.
    ///
    /// # Errors
    /// None with the constants of this file.
    pub fn new() -> Result<Self, InputError> {
        let (bending, twisting, stretching) = (dna::BENDING_STIFFNESS, dna::TWIST_STIFFNESS, dna::STRETCH_MODULUS);
        let radius = 0.5 * dna::contact_diameter_nm(SALT)?;
        let section = Section::isotropic(bending, twisting, stretching, stretching, radius);
        let length = dna::MINICIRCLE.contour_length();
        let circle = Shape::Circle { length, center: Vec3::zeros(), normal: Vec3::z() };
        let rod = Rod::new("dna", &circle, RodMesh::closed(ELEMENTS, 3), section, Natural::Straight)?;
        let mut solver = Solver::new(Model { rods: vec![rod], ..Model::default() }, Options::default())?;
        let report = solver.step_to(&[])?;
        let seen = look(&solver, 0, &report);
        Ok(Self { solver, excess_link: 0.0, num_steps: 0, seen })
    }

    /// Contact radius \[nm\].
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.solver.engine().model().rods[0].section.contact_radius
    }

    /// Where the link stands: turns beyond the relaxed ring's.
    #[must_use]
    pub fn excess_link(&self) -> f64 {
        self.excess_link
    }

    /// Goes one step towards an excess link. A step that does not converge is tried again at half its length, five
    /// times. Says whether one converged; the ring is as it was otherwise.
    ///
    /// # Errors
    /// An excess link that is not finite.
    pub fn step_towards(&mut self, excess_link: f64) -> Result<bool, InputError> {
        let way = excess_link - self.excess_link;
        let full = if way.abs() <= STEP + 1e-9 { way } else { STEP.copysign(way) };
        for halvings in 0..=MAX_HALVINGS {
            let to = self.excess_link + full / f64::from(1_u32 << halvings);
            let before = self.solver.engine().state().clone();
            let report = self.solver.step_to(&[Ramp::ExcessLink { rod: 0, to }])?;
            if report.status == Status::Converged {
                (self.excess_link, self.num_steps) = (to, self.num_steps + 1);
                self.seen = look(&self.solver, self.num_steps, &report);
                return Ok(true);
            }
            self.solver.set_state(before)?;
        }
        Ok(false)
    }

    /// The numbers of the state, see [`COLUMNS`]; NaN where there is none.
    #[must_use]
    pub fn row(&self) -> [f64; COLUMNS.len()] {
        let (seen, link) = (&self.seen, self.seen.links.first());
        let [writhe, twist] = [link.map(|l| l.writhe), link.map(|l| l.twist)].map(|x| x.unwrap_or(f64::NAN));
        let gap = seen.min_gap.map_or(f64::NAN, |gap| gap.lower);
        let counts = [seen.num_sites, seen.num_unstable, seen.iterations].map(|count| count as f64);
        let [sites, unstable, iterations] = counts;
        let (step, force) = (self.num_steps as f64, seen.total_contact_force);
        let [bend, turn] = [seen.energies.bending, seen.energies.twisting];
        [step, self.excess_link, writhe, twist, bend, turn, gap, sites, force, unstable, iterations]
    }

    /// The state as it is drawn.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let engine = self.solver.engine();
        let fields = engine.nodal_fields(0);
        let forces = self.seen.sites.iter().flat_map(|site| {
            let (force, feet) = (Vec3::from(site.force_on_a), site.feet.map(Vec3::from));
            [[feet[0], force], [feet[1], -force]]
        });
        Picture {
            points: engine.positions(0).to_vec(),
            directions: engine.frames(0).iter().map(|frame| frame * Vec3::x()).collect(),
            pressure: fields.contact_force.iter().map(Vec3::norm).collect(),
            curvature: fields.curvature,
            twist_rate: fields.twist_rate,
            forces: forces.collect(),
        }
    }
}

fn look(solver: &Solver, step: usize, report: &StepReport) -> Observation {
    observe(&Progress { given: None, engine: solver.engine(), stage: 0, step, fraction: 1.0, report, seconds: 0.0 })
}

/// Arc lengths and gaps of the contacts of two cubics, see the function of the same name for the page.
///
/// # Errors
/// None with these curves.
pub fn contacts_of_cubics() -> Result<Vec<f64>, InputError> {
    let cubic = |sign: f64| -> Vec<Vec3> {
        let point = |t: f64| Vec3::new(t, sign * (t * t - 0.7), sign * (t * t * t - 0.5 * t));
        (-60..=60).map(|k| point(f64::from(k) / 50.0)).collect()
    };
    let (a, b) = (cubic(1.0), cubic(-1.0));
    let mut detector = Detector::new(DetectorOptions { range: 0.5, ..DetectorOptions::default() });
    let contacts = detector.detect(&[Curve::polyline(&a, 0.05), Curve::polyline(&b, 0.05)])?;
    Ok(contacts.sites.iter().flat_map(|site| [site.arc_a, site.arc_b, site.gap]).collect())
}

/// Coordinates of the nodes of a clamped rod that is pulled at its end: the solver where nothing turns.
///
/// # Errors
/// None with this rod.
pub fn pulled_rod() -> Result<Vec<f64>, InputError> {
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::z(), length: 1.0 };
    let rod = Rod::new(
        "rod",
        &line,
        RodMesh::open(8, 3),
        Section::isotropic(1.0, 1.5, 100.0, 100.0, 0.01),
        Natural::Straight,
    )?;
    let end = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    let loads = vec![NodeLoad { node: end, force: Vec3::z() * 10.0, moment: Vec3::zeros() }];
    let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 })];
    let mut solver = Solver::new(Model { rods: vec![rod], supports, loads, ..Model::default() }, Options::default())?;
    let _ = solver.step_to(&[Ramp::Load { to: 1.0 }])?;
    Ok(solver.engine().positions(0).iter().flatten().copied().collect())
}
