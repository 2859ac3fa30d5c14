//! Plectonemes of least elastic energy.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use crate::error::InputError;
use crate::math::minimise::minimum;

use super::{Axis, MIN_LOOP, Plectoneme, too_short};

/// Relative accuracy of angles and loop sizes.
const TOL: f64 = 1e-10;

/// Largest fraction of the rod's length in the loops, for a given angle and for a given link.
const MAX_SHARE: f64 = 0.5;
const ALL_BUT_SOME: f64 = 0.999;

/// Smallest angle considered, rad.
const MIN_ANGLE: f64 = 1e-4;

/// Angle α (rad, 0 to π/4) of the strands of a long free plectoneme at an excess link per length of `link_density`
/// turns (its sign does not matter), strands `distance` = 2R apart, twisting over bending stiffness C/B = `ratio`.
///
/// Per length the double helix has writhe sin2α/(4πR) turns and bending energy ½B sin⁴α/R². The energy at given link,
/// ½B sin⁴α/R² + 2π²C (ΔLk/L − sin2α/(4πR))², is stationary where the twisting moment is M = 2B sin³α cosα/(R cos2α),
/// the moment of a plectoneme under end moment and force (van der Heijden et al. 2003; Clauvelin, Audoly & Neukirch
/// 2009, without repulsion). With M = 2πC Tw/L the angle is the only root of
///
/// ```text
/// sin2α/(4πR) + (B/C) sin³α cosα/(πR cos2α) = |ΔLk|/L ,
/// ```
///
/// whose left side rises from 0 to ∞ between 0 and π/4; bisection to rounding.
///
/// ```
/// use supercoil::rod::superhelix_angle;
/// // DNA: strands 5 nm apart, B/C = 2/3, 15 turns taken out of 913 nm
/// let angle = superhelix_angle(5.0, 2.0 / 3.0, -15.0 / 913.0)?;
/// assert!((0.2..0.4).contains(&angle)); // rad, to the axis
/// # Ok::<(), supercoil::InputError>(())
/// ```
///
/// # Errors
/// A distance or ratio that is not positive; a density that is 0 or not finite.
pub fn superhelix_angle(distance: f64, ratio: f64, link_density: f64) -> Result<f64, InputError> {
    InputError::positive("distance", distance)?;
    InputError::positive("ratio", ratio)?;
    InputError::check("link_density", link_density, link_density != 0.0, "a finite number other than 0")?;
    let radius = 0.5 * distance;
    let wanted = link_density.abs() * PI * radius;
    let density = |a: f64| {
        let (sin, cos) = a.sin_cos();
        0.5 * sin * cos + sin.powi(3) * cos / (ratio * (2.0 * a).cos())
    };
    let (mut low, mut high) = (0.0, FRAC_PI_4);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        *(if density(middle) < wanted { &mut low } else { &mut high }) = middle;
    }
    Ok(0.5 * (low + high))
}

/// Minimum over the size of the loops of `cost`, the loops together no longer than `share` of the rod; `None` if it is
/// too short for the smallest.
fn best_loops(
    [length, distance, angle]: [f64; 3],
    share: f64,
    cost: impl Fn(&Plectoneme) -> f64,
) -> Option<(Plectoneme, f64)> {
    let of_size = |loop_size: f64| Plectoneme { length, distance, angle, loop_size, axis: Axis::default() };
    let fits = |size: f64| 4.0 * of_size(size).loop_integrals()[0] <= share * length;
    let low = MIN_LOOP * distance;
    if !fits(low) {
        return None;
    }
    let (mut high, mut above) = (low, length);
    for _ in 0..40 {
        let middle = 0.5 * (high + above);
        *(if fits(middle) { &mut high } else { &mut above }) = middle;
    }
    // In the logarithm of the size, because loops may be as small as the strands' distance in a rod a million times as
    // long.
    let (size, least) = minimum(|log| cost(&of_size(log.exp().clamp(low, high))), low.ln(), high.ln(), TOL);
    Some((of_size(size.exp().clamp(low, high)), least))
}

/// Loops as under the twisting moment M = 2B sin³α cosα/(R cos2α) that holds the helix at its angle: least ½B∫κ² ds −
/// 2πM|Wr|.
pub(super) fn of_angle(length: f64, distance: f64, angle: f64) -> Result<Plectoneme, InputError> {
    let (sin, cos) = angle.abs().sin_cos();
    let moment = 4.0 * sin.powi(3) * cos / (distance * (2.0 * angle).cos());
    let cost = |p: &Plectoneme| p.bending() - TAU * moment * p.writhe().abs();
    let sizes = [length, distance, angle];
    let best = best_loops(sizes, MAX_SHARE, cost).or_else(|| {
        // even the smallest loops are longer than that
        let loop_size = MIN_LOOP * distance;
        best_loops(sizes, ALL_BUT_SOME, |p| (p.loop_size - loop_size).abs())
    });
    best.map(|(best, _)| best).ok_or_else(|| too_short(length, distance))
}

pub(super) fn of_turns(length: f64, distance: f64, turns: f64) -> Result<Plectoneme, InputError> {
    let with = |loop_size: f64, angle: f64| Plectoneme {
        length,
        distance,
        angle: angle.copysign(turns),
        loop_size,
        axis: Axis::default(),
    };
    // At a given size of the loops more turns require a larger angle.
    let falls_short = |loop_size: f64, angle: f64| {
        let plectoneme = with(loop_size, angle);
        plectoneme.helix_height() < 0.0 || plectoneme.turns().abs() < turns.abs()
    };
    let at = |loop_size: f64| {
        if falls_short(loop_size, FRAC_PI_4) {
            return None;
        }
        let (mut low, mut high) = (0.0, FRAC_PI_4);
        while 0.5 * (low + high) > low && 0.5 * (low + high) < high {
            let middle = 0.5 * (low + high);
            *(if falls_short(loop_size, middle) { &mut low } else { &mut high }) = middle;
        }
        Some(with(loop_size, high))
    };
    let smallest = MIN_LOOP * distance;
    if at(smallest).is_none() {
        let allowed = "no more than the rod is long enough for (strands at most at 45° to the axis)";
        return Err(InputError::Value { field: "shape.turns".into(), value: turns, allowed });
    }
    let cost = |log: f64| at(log.exp()).map_or(f64::NAN, |p| p.bending());
    let (size, _) = minimum(cost, smallest.ln(), (0.25 * length).max(smallest).ln(), TOL);
    at(size.exp()).or_else(|| at(smallest)).ok_or_else(|| too_short(length, distance))
}

/// `ratio` = C/B. Energies in B.
pub(super) fn of_link(length: f64, distance: f64, ratio: f64, excess_link: f64) -> Result<Plectoneme, InputError> {
    // Negative link winds a right-handed superhelix.
    let hand = -excess_link.signum();
    let best =
        |angle: f64| best_loops([length, distance, angle * hand], ALL_BUT_SOME, |p| energy(p, ratio, excess_link));
    let cost = |angle: f64| best(angle).map_or(f64::NAN, |(_, energy)| energy);
    let (angle, least) = minimum(cost, MIN_ANGLE, FRAC_PI_4, TOL);
    let Some((plectoneme, _)) = best(angle) else { return Err(too_short(length, distance)) };
    let circle = 2.0 * PI * PI * (1.0 + ratio * excess_link * excess_link) / length;
    if least >= circle {
        let reason = format!(
            "an excess link of {excess_link} turns is too small for a plectoneme: the flat circle has less energy \
             ({circle:.6} against {least:.6} B per length unit); start from a circle, or give turns or angle"
        );
        return Err(InputError::Inconsistent { field: "shape".into(), reason });
    }
    Ok(plectoneme)
}

/// Elastic energy over B: ½∫κ² ds + 2π²(C/B)(ΔLk − Wr)²/L.
pub(super) fn energy(plectoneme: &Plectoneme, ratio: f64, excess_link: f64) -> f64 {
    let twist = excess_link - plectoneme.writhe();
    plectoneme.bending() + 2.0 * PI * PI * ratio * twist * twist / plectoneme.length
}
