//! A rod: section, elements, nodes and the natural (stress-free) state.

use crate::error::InputError;
use crate::math::quadrature::gauss;
use crate::math::quaternion::spin;
use crate::math::{Quat, Vec3};
use crate::rod::along::{Along, Averaged};
use crate::rod::natural::Natural;
use crate::rod::number::Binding;
use crate::rod::stiffness::Stiffness;
use crate::rod::{Placement, Section, Shape};

/// Largest rotation between the frames of neighbouring nodes, turns, because elements interpolate the shorter rotation
/// and half a turn has none.
pub const MAX_TURN: f64 = 0.4;

/// A rod of a model.
///
/// Nodes lie at equal reference arc lengths; an element of order p spans p + 1 of them.
#[derive(Debug, Clone)]
pub struct Rod {
    /// Name, for reports.
    pub name: String,
    /// Stiffnesses and contact radius.
    pub section: Section,
    /// Full stiffness along the rod, instead of that of `section`: see [`Rod::with_stiffness`].
    pub stiffness: Option<Along<Stiffness>>,
    /// Contact radius along the rod, instead of that of `section`: see [`Rod::with_contact_radii`].
    pub contact_radii: Option<Along<f64>>,
    /// Order p of the elements (1, 2 or 3).
    pub order: usize,
    /// Number of elements.
    pub num_elements: usize,
    /// Whether its end is joined to its start.
    pub closed: bool,
    /// Reference length \[L\].
    pub length: f64,
    /// Start positions of the nodes \[L\].
    pub positions: Vec<Vec3>,
    /// Start frames of the nodes.
    pub frames: Vec<Quat>,
    /// Stress-free state.
    pub natural: Natural,
    /// The bound state of which `natural` is a part, if stages may ramp that part.
    pub binding: Option<Binding>,
    /// Closed rods: excess link of the start state, turns: the link Tw + Wr of the centreline with the material line d1
    /// beyond that of the relaxed rod, Lk − Lk₀, see [`Rod::natural_link`]. Open rods: 0.
    ///
    /// Its whole turns are exact. Its fraction depends on the frames at s = 0 and s = L. It is exact if prescribed
    /// ([`Rod::with_excess_link`]). Otherwise the closing segment has the mean twist of the others; on a shape with
    /// twist-free frames the excess link is then the writhe of the shape, up to the fourth power of the spacing.
    pub start_excess_link: f64,
    /// Turns by which [`Rod::with_excess_link`] has twisted the frames, uniformly along the rod; not part of the
    /// natural state with [`Natural::AsShaped`].
    pub twist_put_in: f64,
    /// Closed rods: link Tw + Wr of the original frames, turns; the natural link with [`Natural::AsShaped`].
    pub shape_link: f64,
    /// Turns of the double helix that the frames leave out: whole turns of a rod that models DNA in blocks, see
    /// [`Helix::in_blocks`](crate::dna::sequence::Helix::in_blocks). 0 for others.
    pub turns_left_out: f64,
}

/// Elements of a rod.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RodMesh {
    /// Whether the end is joined to the start.
    pub closed: bool,
    /// Number of elements.
    pub num_elements: usize,
    /// Order of the elements: 1, 2 or 3.
    pub order: usize,
}

impl RodMesh {
    /// Of a rod with two ends.
    pub fn open(num_elements: usize, order: usize) -> Self {
        Self { closed: false, num_elements, order }
    }

    /// Of a ring, a knot or another rod without ends.
    pub fn closed(num_elements: usize, order: usize) -> Self {
        Self { closed: true, num_elements, order }
    }
}

impl Rod {
    /// Places `shape` and checks everything. [`Natural::AsShaped`] becomes [`Natural::Uniform`] on arcs and circles.
    /// Frames rotate about d3 by the natural twist: a rod starts without twisting moment.
    ///
    /// # Errors
    /// See [`Section::check`], [`Shape::place`] and [`Rod::check`].
    pub fn new(
        name: &str,
        shape: &Shape,
        mesh: RodMesh,
        section: Section,
        natural: Natural,
    ) -> Result<Self, InputError> {
        let RodMesh { closed, num_elements, order } = mesh;
        let path = format!("rods.{name}");
        check_order(&path, order)?;
        section.check(&format!("{path}.section"))?;
        let mut placement =
            shape.place(closed, num_elements.saturating_mul(order)).map_err(|error| within(&path, error))?;
        let natural = match (natural, shape.uniform_curvature()) {
            (Natural::AsShaped, Some(kappa)) => Natural::Uniform { kappa },
            (natural, _) => natural,
        };
        let twist = natural.mean_twist(placement.length);
        if twist != 0.0 {
            let each = twist * placement.length / (num_elements * order) as f64;
            placement.frames.iter_mut().enumerate().for_each(|(i, frame)| *frame *= spin(each * i as f64));
        }
        Self::from_nodes(name, placement, section, order, natural)
    }

    /// A rod from given nodes and frames at equal reference arc lengths. Their number must be a multiple of the order
    /// (closed) or one more (open).
    ///
    /// The closing segment of a closed rod has the mean twist of the other segments, so uniformly twisted frames may
    /// have any number of turns, fractions included; see [`Rod::start_excess_link`] and [`Rod::with_excess_link`].
    ///
    /// # Errors
    /// See [`Rod::check`].
    pub fn from_nodes(
        name: &str,
        nodes: Placement,
        section: Section,
        order: usize,
        natural: Natural,
    ) -> Result<Self, InputError> {
        let Placement { length, positions, frames, closed } = nodes;
        let num_segments = if closed { positions.len() } else { positions.len().saturating_sub(1) };
        let mut rod = Self {
            name: name.to_owned(),
            section,
            stiffness: None,
            contact_radii: None,
            order,
            num_elements: num_segments / order.max(1),
            closed,
            length,
            positions,
            frames,
            natural,
            binding: None,
            start_excess_link: 0.0,
            twist_put_in: 0.0,
            shape_link: 0.0,
            turns_left_out: 0.0,
        };
        rod.check()?;
        if closed {
            rod.shape_link = rod.link_of_nodes();
            rod.start_excess_link = rod.shape_link - rod.natural_link();
        }
        Ok(rod)
    }

    /// The same rod with a full stiffness, constant or varying along it. Elements evaluate it at their integration
    /// points, see [`Along`]. `section` then only provides scales: its six stiffnesses become the mean of the diagonal,
    /// its contact radius stays.
    ///
    /// ```
    /// use supercoil::math::Vec3;
    /// use supercoil::rod::{Along, Natural, Rod, RodMesh, Section, Shape};
    /// let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 };
    /// let section = Section::isotropic(1.0, 1.5, 100.0, 100.0, 0.0);
    /// let mut stiffness = section.stiffness();
    /// (stiffness[(4, 5)], stiffness[(5, 4)]) = (0.6, 0.6); // bending about d2 and twist
    /// let rod = Rod::new("rod", &line, RodMesh::open(4, 3), section, Natural::Straight)?
    ///     .with_stiffness(Along::constant(stiffness))?;
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    ///
    /// # Errors
    /// A matrix that is not finite, symmetric and positive definite, with its arc length; a table that does not end at
    /// the length of the rod.
    pub fn with_stiffness(self, stiffness: Along<Stiffness>) -> Result<Self, InputError> {
        let rod = Self { stiffness: Some(stiffness), ..self };
        rod.check_stiffness(&format!("rods.{}", rod.name))?;
        let mean = rod.stiffness.as_ref().map_or(rod.section.stiffness(), |along| along.mean(rod.length));
        Ok(Self { section: Section::of_diagonal(&mean, rod.section.contact_radius), ..rod })
    }

    /// The same rod with a contact radius that varies along it \[L\]. Contact has one radius a segment, the mean over
    /// it (of points and functions, the value at its middle); the contact radius of `section` becomes the largest of
    /// these.
    ///
    /// ```
    /// use supercoil::math::Vec3;
    /// use supercoil::rod::{Along, Natural, Rod, RodMesh, Section, Shape};
    /// let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 };
    /// let section = Section::isotropic(1.0, 1.5, 100.0, 100.0, 0.1);
    /// let cone = Rod::new("cone", &line, RodMesh::open(10, 1), section, Natural::Straight)?
    ///     .with_contact_radii(Along::points(vec![0.0, 2.0], vec![0.1, 0.3])?)?;
    /// assert!((cone.contact_radius_of(0) - 0.11).abs() < 1e-15);
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    ///
    /// # Errors
    /// Radii that are not finite and positive, with their arc length; a table that does not end at the rod's end; a rod
    /// thicker than its curvature allows.
    pub fn with_contact_radii(self, radii: Along<f64>) -> Result<Self, InputError> {
        let mut rod = Self { contact_radii: Some(radii), ..self };
        rod.check_contact_radii(&format!("rods.{}", rod.name))?;
        let largest = (0..rod.num_segments()).map(|segment| rod.contact_radius_of(segment)).fold(0.0, f64::max);
        rod.section.contact_radius = largest;
        rod.check().map(|()| rod)
    }

    /// Contact radius of a segment between neighbouring nodes \[L\].
    pub fn contact_radius_of(&self, segment: usize) -> f64 {
        let length = self.spacing();
        let mean = |radii: &Along<f64>| radii.on_element(segment as f64 * length, length, &gauss(1))[0];
        self.contact_radii.as_ref().map_or(self.section.contact_radius, mean)
    }

    /// Largest contact radius \[L\].
    pub(crate) fn thickest(&self) -> f64 {
        match &self.contact_radii {
            None => self.section.contact_radius,
            Some(_) => (0..self.num_segments()).map(|k| self.contact_radius_of(k)).fold(0.0, f64::max),
        }
    }

    /// Contact radius at arc length `s` \[L\]: that of its segment.
    #[cfg(feature = "solver")]
    pub(crate) fn contact_radius_at(&self, s: f64) -> f64 {
        self.contact_radius_of(((s / self.spacing()) as usize).min(self.num_segments() - 1))
    }

    /// The smallest contact radius along the rod \[L\].
    pub(crate) fn least_contact_radius(&self) -> f64 {
        let all = || (0..self.num_segments()).map(|segment| self.contact_radius_of(segment));
        self.contact_radii.as_ref().map_or(self.section.contact_radius, |_| all().fold(f64::INFINITY, f64::min))
    }

    /// Number of nodes.
    pub fn num_nodes(&self) -> usize {
        self.positions.len()
    }

    /// Number of segments between neighbouring nodes.
    pub fn num_segments(&self) -> usize {
        self.num_elements * self.order
    }

    /// Reference arc length between neighbouring nodes \[L\].
    pub fn spacing(&self) -> f64 {
        self.length / self.num_segments() as f64
    }

    /// Values of a quantity that varies along the rod, at the integration points of one element.
    pub(crate) fn on_element<T: Averaged>(&self, along: &Along<T>, element: usize) -> [T; 3] {
        let length = self.length / self.num_elements as f64;
        along.on_element(element as f64 * length, length, &gauss(self.order))
    }

    /// Reference arc length of a node \[L\].
    pub(crate) fn arc_of_node(&self, node: usize) -> f64 {
        self.length * (node as f64 / self.num_segments() as f64)
    }
}

pub(super) fn check_order(path: &str, order: usize) -> Result<(), InputError> {
    if (1..=3).contains(&order) {
        return Ok(());
    }
    Err(InputError::Count { field: format!("{path}.order"), value: order, allowed: "1, 2 or 3" })
}

/// Prefixes the field of an error with `path`.
pub(crate) fn within(path: &str, mut error: InputError) -> InputError {
    match &mut error {
        InputError::Value { field, .. }
        | InputError::Count { field, .. }
        | InputError::Vector { field, .. }
        | InputError::Name { field, .. }
        | InputError::Inconsistent { field, .. } => *field = format!("{path}.{field}"),
        // the file's name stays in the reason
        InputError::Parse { .. } | InputError::File { .. } => return InputError::inconsistent(path, error.to_string()),
        InputError::Write { .. } => {}
    }
    error
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn section(contact_radius: f64) -> Section {
        Section::isotropic(1.0, 1.5, 100.0, 100.0, contact_radius)
    }

    fn circle(num_elements: usize, order: usize, contact_radius: f64) -> Result<Rod, InputError> {
        let shape = Shape::Circle { length: TAU, center: Vec3::zeros(), normal: Vec3::new(1.0, 2.0, 3.0) };
        Rod::new("ring", &shape, RodMesh::closed(num_elements, order), section(contact_radius), Natural::Straight)
    }

    fn message(rod: Result<Rod, InputError>) -> String {
        rod.unwrap_err().to_string()
    }

    #[test]
    fn flat_circle_has_no_excess_link() {
        let rod = circle(5, 3, 0.1).unwrap();
        assert_eq!((rod.num_nodes(), rod.num_segments(), rod.start_excess_link), (15, 15, 0.0));
    }

    /// Frames turn about d1 by the curvature: what "as shaped" takes from circle and arc is what their nodes measure.
    #[test]
    fn as_shaped_on_circle_and_arc_is_their_curvature() {
        let circle = Shape::Circle { length: 4.0, center: Vec3::zeros(), normal: Vec3::new(1.0, 2.0, 3.0) };
        let (start, tangent, towards) = (Vec3::zeros(), Vec3::x(), Vec3::new(0.3, -1.0, 2.0));
        let arc = Shape::Arc { start, tangent, towards, radius: 3.0, angle: 1.0 };
        for (shape, closed, curvature) in [(circle, true, TAU / 4.0), (arc, false, 1.0 / 3.0)] {
            let rod = Rod::new(
                "bend",
                &shape,
                RodMesh { closed, num_elements: 50, order: 3 },
                section(0.0),
                Natural::AsShaped,
            )
            .unwrap();
            assert_eq!(rod.natural, Natural::Uniform { kappa: [curvature, 0.0, 0.0] });
            let turn = (rod.frames[4].inverse() * rod.frames[5]).scaled_axis() * (150.0 / rod.length);
            assert!((turn - Vec3::x() * curvature).norm() < 1e-12, "{turn}");
        }
    }

    #[test]
    fn evenly_turned_frames_carry_their_turns() {
        let rod = circle(20, 2, 0.1).unwrap();
        let turned = |turns: f64| {
            let turn = |i: usize| Quat::from_axis_angle(&Vec3::z_axis(), TAU * turns * i as f64 / 40.0);
            let frames = rod.frames.iter().enumerate().map(|(i, q)| q * turn(i)).collect();
            let nodes = Placement { length: rod.length, positions: rod.positions.clone(), frames, closed: true };
            Rod::from_nodes(&rod.name, nodes, rod.section, 2, Natural::Straight).unwrap()
        };
        for turns in [-3.0, -0.3, 0.25, 1.0, 2.6] {
            let found = turned(turns).start_excess_link;
            assert!((found - turns).abs() < 1e-13, "{found} for {turns}");
        }
    }

    /// The link of twist-free frames is the writhe of the curve (Fuller 1971), here the Gauss integral, whole turns
    /// included.
    #[test]
    fn holonomy_is_the_writhe() {
        let ring = |elements: usize| {
            let point = |t: f64| {
                let (double, triple) = ((2.0 * t).sin_cos(), (3.0 * t).sin());
                Vec3::new(t.cos() + 0.4 * double.1, t.sin() - 0.4 * double.0, 0.5 * triple)
            };
            let points = (0..60).map(|i| point(TAU * f64::from(i) / 60.0)).collect();
            Rod::new("loop", &Shape::Points(points), RodMesh::closed(elements, 3), section(0.0), Natural::Straight)
                .unwrap()
        };
        let fine = ring(300);
        let (x, h) = (&fine.positions, fine.length / 900.0);
        let tangents: Vec<Vec3> = fine.frames.iter().map(|q| q * Vec3::z()).collect();
        let pair = |i: usize, j: usize| {
            let r = x[i] - x[j];
            r.dot(&tangents[i].cross(&tangents[j])) / r.norm().powi(3)
        };
        let pairs = (0..900).flat_map(|i| (0..i).map(move |j| (i, j)));
        let writhe = pairs.map(|(i, j)| pair(i, j)).sum::<f64>() * h * h / TAU;
        assert!(writhe.abs() > 0.01, "{writhe}");
        for elements in [20, 40, 300] {
            let excess = ring(elements).start_excess_link;
            assert!((excess - writhe).abs() < 1e-5, "{excess} {writhe}");
        }
    }

    #[test]
    fn bad_rods_are_refused() {
        assert_eq!(message(circle(4, 4, 0.1)), "rods.ring.order = 4: must be 1, 2 or 3");
        assert!(message(circle(0, 1, 0.1)).starts_with("rods.ring.elements = 0"));
        assert!(message(circle(2, 1, 0.1)).starts_with("rods.ring.elements = 2: must be at least 3 nodes"));
        assert!(message(circle(4, 3, f64::NAN)).starts_with("rods.ring.section.contact_radius = NaN"));
        let thick = message(circle(4, 3, 1.25));
        assert!(thick.contains("thicker than its own curvature") && thick.contains("contact_radius = 1.25"), "{thick}");
        assert!(thick.contains("curvature = 1.000000"), "{thick}");
        let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: -1.0 };
        let rod = Rod::new("beam", &shape, RodMesh::open(4, 2), section(0.0), Natural::Straight);
        assert!(message(rod).starts_with("rods.beam.shape.length = -1"));
        let kappa = Natural::Uniform { kappa: [0.0, f64::NAN, 0.0] };
        let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
        let rod = Rod::new("beam", &shape, RodMesh::open(4, 2), section(0.0), kappa);
        assert!(message(rod).starts_with("rods.beam.natural.kappa[1] = NaN"));
    }

    #[test]
    fn bad_nodes_are_refused() {
        let build = |positions: Vec<Vec3>, frames: Vec<Quat>, order: usize| {
            let nodes = Placement { length: 2.0, positions, frames, closed: false };
            Rod::from_nodes("rod", nodes, section(0.0), order, Natural::Straight)
        };
        let (x, q) = (|t: f64| Vec3::new(0.0, 0.0, t), Quat::identity());
        let about_z = |angle: f64| Quat::from_axis_angle(&Vec3::z_axis(), angle);
        assert!(build(vec![x(0.0), x(1.0), x(2.0)], vec![q; 3], 2).is_ok());
        assert!(message(build(vec![x(0.0), x(1.0)], vec![q; 2], 2)).contains("elements = 0"));
        assert!(message(build(vec![x(0.0), x(1.0), x(1.5), x(2.0)], vec![q; 4], 2)).contains("positions = 4"));
        assert!(message(build(vec![x(0.0), x(0.0), x(2.0)], vec![q; 3], 2)).contains("nodes 0 and 1 coincide"));
        assert!(message(build(vec![x(0.0), x(f64::NAN), x(2.0)], vec![q; 3], 2)).contains("rods.rod.positions[1]"));
        let half_turn = vec![q, about_z(std::f64::consts::PI), q];
        assert!(message(build(vec![x(0.0), x(1.0), x(2.0)], half_turn, 2)).contains("half a turn apart"));
    }
}
