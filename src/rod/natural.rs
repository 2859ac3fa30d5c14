//! The natural (stress-free) state of a rod.

use crate::rod::along::Along;
use crate::rod::element::Strain;

/// Names of the strains, in the order of [`Strain`].
pub(crate) const STRAINS: [&str; 6] = ["gamma1", "gamma2", "gamma3", "kappa1", "kappa2", "kappa3"];

/// The stress-free state of a rod.
#[derive(Debug, Clone, PartialEq)]
pub enum Natural {
    /// Straight and untwisted; nothing is stored.
    Straight,
    /// The start shape is stress-free, as it is before [`Rod::with_excess_link`](crate::rod::Rod::with_excess_link)
    /// twists it.
    ///
    /// Arcs and circles have a uniform curvature, which [`Rod::new`](crate::rod::Rod::new) takes exactly; nothing is
    /// stored. On other shapes, and for rods from nodes, natural strains are those of the interpolated start shape at
    /// the integration points. The start is then free of stress, but natural curvature is accurate to the order p + 1
    /// of the elements only, which limits the accuracy of results: the tip of a bent arc converges with orders 2, 4, 4
    /// for p = 1, 2, 3 (fitted 3.75 for p = 3 on 3 to 12 elements, where given curvature has 5.94;
    /// `tests/convergence/convergence_orders.rs`). Where frames can be laid so that curvature and twist are uniform (a
    /// helix with its Frenet frames), [`Rod::from_nodes`](crate::rod::Rod::from_nodes) with [`Natural::Uniform`] has
    /// the full order.
    AsShaped,
    /// Uniform intrinsic curvature and twist \[1/L\], in the material frame; nothing is stored per element.
    Uniform {
        /// K1, K2, K3 of the stress-free rod.
        kappa: [f64; 3],
    },
    /// Natural strains Γ1 Γ2 Γ3 (1: neither stretched nor sheared) and K1 K2 K3 \[1/L\] along the rod, in the material
    /// frame: six numbers per integration point are stored. Functions keep the full order of the elements, and so do
    /// constant pieces that elements do not cut. An element in which pieces meet has the strains of its interpolation
    /// with its nodes on the stress-free rod: a rod that nothing holds lies there, at its nodes, on any mesh.
    ///
    /// ```
    /// use supercoil::rod::{Along, Natural};
    /// // curved by 0.3 towards a direction that turns in the section, ten times in the unit of length
    /// let turning = |s: f64| std::f64::consts::TAU * 10.0 * s;
    /// let helical = Natural::Varying(Along::function(move |s| {
    ///     [0.0, 0.0, 1.0, 0.3 * turning(s).cos(), 0.3 * turning(s).sin(), 0.0].into()
    /// }));
    /// ```
    Varying(Along<NaturalStrains>),
}

/// Γ1 Γ2 Γ3 K1 K2 K3 of the stress-free rod.
pub type NaturalStrains = nalgebra::Vector6<f64>;

impl Natural {
    /// Natural strains at arc length `s`; `None` with [`Natural::AsShaped`].
    pub(crate) fn at(&self, s: f64) -> Option<Strain> {
        match self {
            Self::Straight => Some([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
            Self::Uniform { kappa: [k1, k2, k3] } => Some([0.0, 0.0, 1.0, *k1, *k2, *k3]),
            Self::Varying(along) => Some(along.at(s).into()),
            Self::AsShaped => None,
        }
    }

    /// Mean natural twist \[1/L\] along a rod of that length; 0 with [`Natural::AsShaped`].
    pub(crate) fn mean_twist(&self, length: f64) -> f64 {
        match self {
            Self::Straight | Self::AsShaped => 0.0,
            Self::Uniform { kappa } => kappa[2],
            Self::Varying(along) => along.mean(length)[5],
        }
    }

    /// Root mean square of natural curvature and twist \[1/L\] along a rod of that length; 0 with
    /// [`Natural::AsShaped`].
    #[cfg(feature = "scenes")]
    pub(crate) fn turning(&self, length: f64) -> f64 {
        let sample = |k: u32| {
            let kappa =
                self.at(length * (f64::from(k) + 0.5) / f64::from(SAMPLES)).map_or([0.0; 3], |s| [s[3], s[4], s[5]]);
            kappa.iter().map(|k| k * k).sum::<f64>()
        };
        let samples = if matches!(self, Self::Varying(_)) { SAMPLES } else { 1 };
        ((0..samples).map(sample).sum::<f64>() / f64::from(samples)).sqrt()
    }
}

/// Samples of a mean, because it only serves to choose a mesh.
#[cfg(feature = "scenes")]
const SAMPLES: u32 = 1000;
