//! The constraint that holds the neutral sliding of a uniform closed rod along itself: a row and column that border the
//! tangent.

/// The constraint c with its response K⁻¹c.
#[derive(Debug)]
pub(in crate::solve) struct SlidingConstraint {
    constraint: Vec<f64>,
    response: Vec<f64>,
    compliance: f64,
}

impl SlidingConstraint {
    pub(in crate::solve) fn new(constraint: Vec<f64>, response: Vec<f64>) -> Self {
        let compliance = dot(&constraint, &response);
        Self { constraint, response, compliance }
    }

    /// c·K⁻¹c.
    pub(in crate::solve) fn compliance(&self) -> f64 {
        self.compliance
    }

    /// Negative eigenvalues of the tangent on the motions that do not slide (Haynsworth), from those on all.
    pub(in crate::solve) fn num_negative(&self, of_all: usize) -> usize {
        of_all - usize::from(of_all > 0 && self.compliance < 0.0)
    }

    /// Takes sliding out of a response K⁻¹f.
    pub(in crate::solve) fn apply(&self, x: &mut [f64]) {
        let part = dot(&self.constraint, x) / self.compliance;
        x.iter_mut().zip(&self.response).for_each(|(x, w)| *x -= part * w);
    }

    /// Adds the forces against a motion of a spring of unit stiffness along the constraint.
    pub(in crate::solve) fn add_spring(&self, motion: &[f64], forces: &mut [f64]) {
        let part = dot(&self.constraint, motion);
        forces.iter_mut().zip(&self.constraint).for_each(|(f, c)| *f += part * c);
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
