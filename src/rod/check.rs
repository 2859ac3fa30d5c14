//! Checks of rods.

use crate::error::InputError;
use crate::math::quadrature::gauss;
use crate::math::{LARGEST, Vec3};
use crate::rod::natural::{Natural, STRAINS};
use crate::rod::rod::{MAX_TURN, Rod, check_order};
use crate::rod::stiffness::check_stiffness;

const ALLOWED_STRAINS: &str = "a finite number, gamma3 greater than 0";

impl Rod {
    /// Refuses a rod that cannot be computed; the constructors call it.
    ///
    /// # Errors
    /// An order other than 1, 2, 3; a number of nodes that does not fit order and elements; a closed rod of fewer than
    /// 3 nodes; frames not as many as positions; numbers that are not finite; stiffnesses or a length not positive;
    /// neighbouring nodes that coincide, or whose frames are more than [`MAX_TURN`] apart; a natural curvature or twist
    /// that turns by more than that from node to node; a rod thicker than its own curvature allows (ε·curvature ≥ 1,
    /// curvature = turning of d3 from node to node over the arc length between them).
    pub fn check(&self) -> Result<(), InputError> {
        let path = format!("rods.{}", self.name);
        self.section.check(&format!("{path}.section"))?;
        InputError::positive(&format!("{path}.length"), self.length)?;
        let link = self.start_excess_link;
        InputError::check(&format!("{path}.start_excess_link"), link, true, "a finite number of turns")?;
        InputError::check(&format!("{path}.twist_put_in"), self.twist_put_in, true, "a finite number of turns")?;
        if let Natural::Uniform { kappa } = self.natural {
            for (i, value) in kappa.into_iter().enumerate() {
                InputError::check(&format!("{path}.natural.kappa[{i}]"), value, true, "a finite number")?;
            }
        }
        self.check_counts(&path)?;
        for (i, position) in self.positions.iter().enumerate() {
            if !position.iter().all(|x| x.abs() <= LARGEST) {
                let (field, allowed) = (format!("{path}.positions[{i}]"), "three finite numbers of at most 1e100");
                return Err(InputError::Vector { field, value: (*position).into(), allowed });
            }
            let norm = self.frames[i].norm();
            let ok = (norm - 1.0).abs() < 1e-6;
            InputError::check(&format!("{path}.frames[{i}].norm"), norm, ok, "1 (a unit quaternion)")?;
        }
        self.check_length(&path)?;
        self.check_natural(&path)?;
        self.check_stiffness(&path)?;
        self.check_contact_radii(&path)?;
        (0..self.num_segments()).try_for_each(|segment| self.check_segment(&path, segment))
    }

    /// Refuses a length that differs from that of the polygon of nodes by a factor of a million: an input error.
    fn check_length(&self, path: &str) -> Result<(), InputError> {
        let ends = |k: usize| (self.positions[(k + 1) % self.num_nodes()] - self.positions[k]).norm();
        let way: f64 = (0..self.num_segments()).map(ends).sum();
        if (1e-6..=1e6).contains(&(way / self.length)) {
            return Ok(());
        }
        let reason = format!(
            "length = {:e}, but the way along its positions is {way:e}: they are to agree within a factor of 1e6",
            self.length
        );
        Err(InputError::Inconsistent { field: path.to_owned(), reason })
    }

    /// Refuses a natural rotation from node to node that elements cannot interpolate.
    fn check_natural(&self, path: &str) -> Result<(), InputError> {
        let turn = |at: &str, kappa: Vec3| {
            let turns = kappa.amax() * self.spacing() / std::f64::consts::TAU;
            if turns <= MAX_TURN {
                return Ok(());
            }
            let reason = format!(
                "turns by {turns:.3e} turns from node to node{at}, more than {MAX_TURN}: use more elements, or less \
                 natural curvature and twist"
            );
            Err(InputError::Inconsistent { field: format!("{path}.natural.kappa"), reason })
        };
        match &self.natural {
            Natural::Straight | Natural::AsShaped => Ok(()),
            Natural::Uniform { kappa } => turn("", Vec3::from(*kappa)),
            Natural::Varying(along) => {
                let field = format!("{path}.natural");
                along.check(&field, self.length, (self.num_elements, &gauss(self.order)), |s, strains| {
                    for (name, value) in STRAINS.iter().zip(strains.iter()) {
                        let ok = value.abs() <= LARGEST && (*name != "gamma3" || *value > 0.0);
                        InputError::check(&format!("{field}.{name} at s = {s}"), *value, ok, ALLOWED_STRAINS)?;
                    }
                    turn(&format!(" at s = {s}"), strains.fixed_rows::<3>(3).into())
                })
            }
        }
    }

    pub(super) fn check_stiffness(&self, path: &str) -> Result<(), InputError> {
        let Some(along) = &self.stiffness else { return Ok(()) };
        let field = format!("{path}.stiffness");
        along.check(&field, self.length, (self.num_elements, &gauss(self.order)), |s, matrix| {
            check_stiffness(&format!("{field} at s = {s}"), matrix)
        })
    }

    pub(super) fn check_contact_radii(&self, path: &str) -> Result<(), InputError> {
        let Some(along) = &self.contact_radii else { return Ok(()) };
        let field = format!("{path}.contact_radii");
        along.check(&field, self.length, (self.num_elements, &gauss(self.order)), |s, radius| {
            InputError::positive(&format!("{field} at s = {s}"), *radius)
        })
    }

    fn check_counts(&self, path: &str) -> Result<(), InputError> {
        check_order(path, self.order)?;
        if self.num_elements == 0 {
            return Err(InputError::Count { field: format!("{path}.elements"), value: 0, allowed: "at least 1" });
        }
        let nodes = self.num_nodes();
        if nodes != self.num_segments() + usize::from(!self.closed) {
            let allowed = if self.closed { "a multiple of the order" } else { "a multiple of the order, plus 1" };
            return Err(InputError::Count { field: format!("{path}.positions"), value: nodes, allowed });
        }
        if self.closed && nodes < 3 {
            let allowed = "at least 3 nodes (elements × order) for a closed rod";
            return Err(InputError::Count { field: format!("{path}.elements"), value: self.num_elements, allowed });
        }
        if self.frames.len() != nodes {
            let allowed = "as many frames as positions";
            return Err(InputError::Count { field: format!("{path}.frames"), value: self.frames.len(), allowed });
        }
        Ok(())
    }

    fn check_segment(&self, path: &str, segment: usize) -> Result<(), InputError> {
        let [a, b] = [segment, (segment + 1) % self.num_nodes()];
        let refuse = |reason: String| Err(InputError::Inconsistent { field: path.to_owned(), reason });
        let spacing = self.spacing();
        if (self.positions[b] - self.positions[a]).norm() <= 1e-12 * spacing {
            return refuse(format!("nodes {a} and {b} coincide"));
        }
        let turns = self.frames[a].angle_to(&self.frames[b]) / std::f64::consts::TAU;
        let seam = self.closed && b == 0;
        if !seam && turns > MAX_TURN {
            return refuse(format!(
                "the frames of nodes {a} and {b} are nearly half a turn apart ({turns:.3} turns; at most {MAX_TURN}): \
                 use more elements"
            ));
        }
        let (d3_a, d3_b) = (self.frames[a] * Vec3::z(), self.frames[b] * Vec3::z());
        let curvature = d3_a.cross(&d3_b).norm().atan2(d3_a.dot(&d3_b)) / spacing;
        let radius = self.contact_radius_of(segment);
        if radius * curvature >= 1.0 {
            return refuse(format!(
                "a rod thicker than its own curvature allows: contact_radius = {radius}, curvature = {curvature:.6} \
                 (radius of curvature {:.6}) between nodes {a} and {b}; contact_radius × curvature must be less than 1",
                1.0 / curvature
            ));
        }
        Ok(())
    }
}
