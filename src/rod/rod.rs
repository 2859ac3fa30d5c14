//! A rod: section, elements, nodes and the natural (stress-free) state.

use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::rod::{Section, Shape};

/// The stress-free state of a rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Natural {
    /// Straight and untwisted: nothing is stored.
    Straight,
    /// The start shape itself is free of stress.
    AsShaped,
    /// Uniform intrinsic curvature and twist \[1/L\], in the material frame: nothing is stored per element.
    Uniform {
        /// K1, K2, K3 at rest.
        kappa: [f64; 3],
    },
}

/// A rod ready to be put in a model.
///
/// Nodes lie at equal reference arc lengths; an element of order p spans p + 1 of them.
#[derive(Debug, Clone)]
pub struct Rod {
    /// Name, for reports.
    pub name: String,
    /// Stiffnesses and contact radius.
    pub section: Section,
    /// Order p of the elements (1, 2 or 3).
    pub order: usize,
    /// Number of elements.
    pub num_elements: usize,
    /// Closed on itself.
    pub closed: bool,
    /// Reference length \[L\].
    pub length: f64,
    /// Start positions of the nodes \[L\].
    pub positions: Vec<Vec3>,
    /// Start frames of the nodes.
    pub frames: Vec<Quat>,
    /// Stress-free state.
    pub natural: Natural,
    /// Closed rods: excess link Tw + Wr of the start state, turns; the frame at s = L is the frame at 0 turned by this
    /// about d3.
    pub start_excess_link: f64,
}

impl Rod {
    /// Places `shape` and checks everything.
    ///
    /// # Errors
    /// See [`Section::check`] and [`Shape::place`]; also an order other than 1, 2, 3, no elements, a closed rod of fewer
    /// than 3 nodes, a rod thicker than its own start curvature allows (ε·curvature ≥ 1).
    pub fn new(
        name: &str,
        shape: &Shape,
        closed: bool,
        section: Section,
        num_elements: usize,
        order: usize,
        natural: Natural,
    ) -> Result<Self, InputError> {
        section.check(&format!("rods.{name}.section"))?;
        let placement = shape.place(closed, num_elements * order)?;
        Self::from_nodes(name, placement.length, placement.positions, placement.frames, closed, section, order, natural)
    }

    /// A rod from nodes and frames of one's own; `positions.len()` must be a multiple of the order (closed) or one more
    /// (open).
    ///
    /// # Errors
    /// As [`Rod::new`]; also NaN positions.
    #[allow(clippy::too_many_arguments)]
    pub fn from_nodes(
        name: &str,
        length: f64,
        positions: Vec<Vec3>,
        frames: Vec<Quat>,
        closed: bool,
        section: Section,
        order: usize,
        natural: Natural,
    ) -> Result<Self, InputError> {
        let num_segments = if closed { positions.len() } else { positions.len().saturating_sub(1) };
        Ok(Self {
            name: name.to_owned(),
            section,
            order,
            num_elements: num_segments / order.max(1),
            closed,
            length,
            positions,
            frames,
            natural,
            start_excess_link: 0.0,
        })
    }

    /// Number of nodes.
    pub fn num_nodes(&self) -> usize {
        self.positions.len()
    }
}
