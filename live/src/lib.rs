//! The solver in a page: the functions that its script calls.

pub mod ring;

use ring::Ring;
use wasm_bindgen::prelude::*;

/// A DNA minicircle of 336 base pairs whose link may be turned.
#[wasm_bindgen]
pub struct Minicircle(Ring);

#[wasm_bindgen]
impl Minicircle {
    /// The relaxed circle.
    ///
    /// # Errors
    /// None in practice, see [`Ring::new`].
    #[wasm_bindgen(constructor)]
    pub fn new() -> Result<Self, JsError> {
        Ok(Self(Ring::new()?))
    }

    /// Where the link stands: turns beyond the relaxed ring's.
    #[wasm_bindgen(getter = excessLink)]
    pub fn excess_link(&self) -> f64 {
        self.0.excess_link()
    }

    /// Goes one step towards an excess link; whether it converged.
    ///
    /// # Errors
    /// An excess link that is not finite.
    #[wasm_bindgen(js_name = stepTowards)]
    pub fn step_towards(&mut self, excess_link: f64) -> Result<bool, JsError> {
        Ok(self.0.step_towards(excess_link)?)
    }

    /// The numbers of the state, in the order of [`ring::COLUMNS`].
    pub fn row(&self) -> Vec<f64> {
        self.0.row().to_vec()
    }

    /// Nine numbers a node, as the page's films have them: point, direction, pressure, curvature, twist.
    pub fn nodes(&self) -> Vec<f32> {
        let picture = self.0.picture();
        let node = |i: usize| {
            let (p, d) = (picture.points[i], picture.directions[i]);
            [p.x, p.y, p.z, d.x, d.y, d.z, picture.pressure[i], picture.curvature[i], picture.twist_rate[i]]
        };
        (0..picture.points.len()).flat_map(node).map(|x| x as f32).collect()
    }

    /// Six numbers a contact force: the point it acts on, the force.
    pub fn forces(&self) -> Vec<f32> {
        let of = |[at, force]: [supercoil::math::Vec3; 2]| [at.x, at.y, at.z, force.x, force.y, force.z];
        self.0.picture().forces.into_iter().flat_map(of).map(|x| x as f32).collect()
    }
}

/// Arc lengths and gaps of the contacts of two cubics, without a solver: sums, products and roots alone, which are the
/// same bits on every machine.
///
/// # Errors
/// None in practice: the curves are given.
#[wasm_bindgen(js_name = contactsOfCubics)]
pub fn contacts_of_cubics() -> Result<Vec<f64>, JsError> {
    Ok(ring::contacts_of_cubics()?)
}

/// Coordinates of the nodes of a pulled rod: the solver without sines and cosines. The same bits on every machine that
/// does not fuse products and sums.
///
/// # Errors
/// None in practice: the rod is given.
#[wasm_bindgen(js_name = pulledRod)]
pub fn pulled_rod() -> Result<Vec<f64>, JsError> {
    Ok(ring::pulled_rod()?)
}
