//! Plectonemes: closed rods whose two halves wind about each other.

mod axis;
mod energy;
mod strand;

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use crate::error::InputError;
use crate::math::Vec3;

use super::sampler::{Measured, Parametrised};
use super::{Placement, Shape};
use axis::AxisCurve;
use strand::{HalfLoop, LOOP_HEIGHT, LOOP_WIDTH, StrandPoint, integrals};

pub use energy::superhelix_angle;

/// Smallest size of end loops over the distance between the strands, because smaller loops would be bent more tightly
/// than the thickness of the rod allows.
const MIN_LOOP: f64 = 2.0;

/// Panels per turn of a superhelix with a curved axis.
const PANELS_PER_TURN: f64 = 4.0;

/// Relative tolerance of the length when a helix is fitted to a curved axis.
const TOL_LENGTH: f64 = 1e-12;

/// A closed rod wound about itself: a double helix of two antiparallel strands, closed by a loop at both ends.
///
/// With R = `distance`/2 the strands are helices of radius R at the angle α to the axis, opposite to each other, so
/// their distance is 2R everywhere (|α| ≤ 45°; steeper strands would come closer than 2R obliquely). The loops are
/// teardrops in a plane that turns about the axis, at the helix's rate first and at no rate at the apex. Position,
/// tangent and curvature are continuous everywhere.
///
/// A straight-axis plectoneme with the helix length H along the axis has
///
/// ```text
/// turns n = H tanα/(2πR)        length L = 2H/cosα + 4λ
/// curvature sin²α/R             writhe Wr = −2 n cosα − 4 τ/2π = −(L − 4λ) sin2α/(4πR) − 4τ/2π
/// ```
///
/// λ the length of half a loop and τ the twist in it of the direction about the axis, both by quadrature. (Writhe: the
/// ribbon that points around the axis is unlinked, as turning the strands back about the axis shows, so Wr = −Tw of
/// that ribbon.) A right-handed superhelix, α > 0, has negative writhe: it is that of negative excess link.
///
/// The rod starts at one apex, so that nodes i and N − i lie opposite to each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Plectoneme {
    /// Length of the rod \[L\].
    pub length: f64,
    /// Distance between the centrelines of the strands \[L\]; 2ε where they just touch.
    pub distance: f64,
    /// Angle α of the strands to the axis, rad; positive right-handed. 0 < |α| ≤ π/4.
    pub angle: f64,
    /// Size S of the end loops \[L\]: they are about S long, half as wide; their half length is about 1.34 S. At least
    /// twice the distance.
    pub loop_size: f64,
    /// The axis of the superhelix.
    pub axis: Axis,
}

/// Axis of a plectoneme.
#[derive(Debug, Clone, PartialEq)]
pub enum Axis {
    /// A straight line; the middle of the plectoneme lies at `center`.
    Straight {
        /// Middle \[L\].
        center: Vec3,
        /// Direction (need not be unit).
        direction: Vec3,
    },
    /// The middle part of an open curve, for long plectonemes that are coiled. The superhelix winds relative to
    /// twist-free frames of that curve, which hardly changes its writhe. The distance of the strands is that of the
    /// straight plectoneme, and the length of the helix is fitted to that of the rod.
    ///
    /// [`Shape::place`] refuses axes that are too short, bend too tightly, or come too close to themselves (two
    /// plectonemes side by side need 2.13 `distance` between their axes, more at the loops).
    Along(Box<Shape>),
}

impl Default for Axis {
    /// A straight axis along x, centred at the origin.
    fn default() -> Self {
        Self::Straight { center: Vec3::zeros(), direction: Vec3::x() }
    }
}

impl Plectoneme {
    /// A plectoneme at a given angle α (rad, positive right-handed), with loops of the size of those of a long
    /// plectoneme in equilibrium at that angle, but together no longer than half the rod (or the smallest loops
    /// possible).
    ///
    /// # Errors
    /// Sizes that are not positive, an angle that is 0 or beyond ±π/4, a rod too short for two loops.
    pub fn of_angle(length: f64, distance: f64, angle: f64) -> Result<Self, InputError> {
        check_sizes(length, distance)?;
        check_angle(angle)?;
        energy::of_angle(length, distance, angle)
    }

    /// A plectoneme with a given number of turns of the helix (positive right-handed), with the loops of least total
    /// bending energy.
    ///
    /// ```
    /// use supercoil::rod::Plectoneme;
    /// let plectoneme = Plectoneme::of_turns(1.0, 0.02, 4.0)?;
    /// assert!((plectoneme.turns() - 4.0).abs() < 1e-6);
    /// assert!(plectoneme.writhe() < 0.0); // right-handed
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    ///
    /// # Errors
    /// Sizes that are not positive, a number of turns that is 0 or more than the rod is long enough for.
    pub fn of_turns(length: f64, distance: f64, turns: f64) -> Result<Self, InputError> {
        check_sizes(length, distance)?;
        InputError::check("shape.turns", turns, turns != 0.0, "a finite number other than 0")?;
        energy::of_turns(length, distance, turns)
    }

    /// The plectoneme of least elastic energy at a given excess link, for a naturally straight rod of bending stiffness
    /// B = `bending` and twisting stiffness C = `twisting` \[F·L²\]; `excess_link` in turns, negative for a
    /// right-handed superhelix.
    ///
    /// Minimises ½B∫κ² ds + 2π²C (ΔLk − Wr)²/L over the angle and the size of the loops at fixed length and distance.
    /// Without its loops (a long plectoneme) the minimum is given by [`superhelix_angle`].
    ///
    /// # Errors
    /// Sizes and stiffnesses that are not positive; a rod too short for two loops; an excess link so small that the
    /// flat circle has less energy than any plectoneme (start from a circle then).
    pub fn of_link(
        length: f64,
        distance: f64,
        bending: f64,
        twisting: f64,
        excess_link: f64,
    ) -> Result<Self, InputError> {
        check_sizes(length, distance)?;
        InputError::positive("section.bending", bending)?;
        InputError::positive("section.twisting", twisting)?;
        InputError::check("excess_link", excess_link, excess_link != 0.0, "a finite number of turns other than 0")?;
        energy::of_link(length, distance, twisting / bending, excess_link)
    }

    /// The same plectoneme about another axis.
    #[must_use]
    pub fn about(self, axis: Axis) -> Self {
        Self { axis, ..self }
    }

    /// Number of turns of the helix, without the loops; signed like the angle.
    pub fn turns(&self) -> f64 {
        self.helix_height() * self.angle.tan() / (PI * self.distance)
    }

    /// Writhe, turns (about a straight axis).
    pub fn writhe(&self) -> f64 {
        let [half_loop, _, twist] = self.loop_integrals();
        let helix = (self.length - 4.0 * half_loop) * (2.0 * self.angle).sin() / (TAU * self.distance);
        -helix - 4.0 * twist / TAU
    }

    /// ½∫κ² ds \[1/L\] (about a straight axis): bending energy over the bending stiffness.
    pub fn bending(&self) -> f64 {
        let [half_loop, bend, _] = self.loop_integrals();
        let curvature = 2.0 * self.angle.sin().powi(2) / self.distance;
        0.5 * ((self.length - 4.0 * half_loop) * curvature * curvature + 4.0 * bend)
    }

    /// Length of the helix along a straight axis \[L\]; negative if the loops alone are too long for the rod.
    fn helix_height(&self) -> f64 {
        0.5 * (self.length - 4.0 * self.loop_integrals()[0]) * self.angle.cos()
    }

    fn loop_integrals(&self) -> [f64; 3] {
        integrals(&self.half_loop())
    }

    fn half_loop(&self) -> HalfLoop {
        let radius = 0.5 * self.distance;
        HalfLoop { radius, size: self.loop_size, rate: self.angle.tan() / radius }
    }

    fn check(&self) -> Result<(), InputError> {
        check_sizes(self.length, self.distance)?;
        check_angle(self.angle)?;
        let fits = self.loop_size >= MIN_LOOP * self.distance * (1.0 - 1e-9);
        InputError::check("shape.loop_size", self.loop_size, fits, "at least twice the distance of the strands")?;
        if self.helix_height() < 1e-6 * self.length {
            return Err(too_short(self.length, self.distance));
        }
        Ok(())
    }

    pub(super) fn place(&self, num_segments: usize) -> Result<Placement, InputError> {
        self.check()?;
        let axis = AxisCurve::new(&self.axis, self.distance)?;
        let mut curve = WoundStrands { half_loop: self.half_loop(), height: self.helix_height(), axis: &axis };
        if matches!(axis, AxisCurve::Straight { .. }) {
            let breaks = curve.breaks(1);
            return Ok(Measured::new(&curve, &breaks).place(true, num_segments, self.length));
        }
        let panels = ((PANELS_PER_TURN * self.turns().abs()).ceil() as usize).max(8);
        for _ in 0..20 {
            self.check_axis_length(&curve)?;
            let breaks = curve.breaks(panels);
            let measured = Measured::new(&curve, &breaks);
            let missing = self.length - measured.length();
            if missing.abs() <= TOL_LENGTH * self.length {
                self.check_axis_clear(&curve)?;
                return Ok(measured.place(true, num_segments, self.length));
            }
            curve.height += 0.5 * missing * self.angle.cos();
            if curve.height <= 0.0 {
                return Err(too_short(self.length, self.distance));
            }
        }
        let reason =
            "the length of the helix could not be fitted to the rod's: choose an axis of less curvature".into();
        Err(InputError::Inconsistent { field: "shape.axis".into(), reason })
    }

    fn check_axis_length(&self, curve: &WoundStrands) -> Result<(), InputError> {
        let (needed, given) = (2.0 * curve.end(), curve.axis.length());
        if needed <= given {
            return Ok(());
        }
        let reason = format!("is {given} long, but the plectoneme needs {needed:.6} from end to end");
        Err(InputError::Inconsistent { field: "shape.axis".into(), reason })
    }

    fn check_axis_clear(&self, curve: &WoundStrands) -> Result<(), InputError> {
        let (radius, widest) = (0.5 * self.distance, 0.5 * self.distance + LOOP_WIDTH * self.loop_size);
        let reach = |z: f64| radius + if z.abs() < 0.5 * curve.height { radius } else { widest };
        curve.axis.check_clear(curve.end(), self.distance, reach)
    }
}

/// The closed curve, parameter 0..6: half a loop, helix, half a loop to the other apex, and back along the other
/// strand.
struct WoundStrands<'a> {
    half_loop: HalfLoop,
    /// Length of the helix along the axis.
    height: f64,
    axis: &'a AxisCurve,
}

impl WoundStrands<'_> {
    /// Axial distance of the apex from the middle.
    fn end(&self) -> f64 {
        0.5 * self.height + LOOP_HEIGHT * self.half_loop.size
    }

    /// Ends of the smooth panels, the helix cut into `num`.
    fn breaks(&self, num: usize) -> Vec<f64> {
        let helix = |start: f64| (0..num).map(move |i| start + i as f64 / num as f64);
        let mut breaks = vec![0.0];
        breaks.extend(helix(1.0).chain([2.0, 3.0]).chain(helix(4.0)).chain([5.0, 6.0]));
        breaks
    }

    /// The strand at u and its derivatives by u; x is negative on the returning strand.
    fn strand(&self, u: f64) -> StrandPoint {
        let section = (u.max(0.0) as usize).min(5);
        let (v, side) = (u - section as f64, if section < 3 { 1.0 } else { -1.0 });
        let flip =
            |p: [f64; 3], start: f64, sign: f64, turn: f64| [start + sign * p[0], sign * turn * p[1], sign * p[2]];
        let half = 0.5 * self.height;
        let middle = half * self.half_loop.rate;
        if section == 1 || section == 4 {
            let up = if section == 1 { 1.0 } else { -1.0 };
            let z = [up * (2.0 * v - 1.0) * half, up * self.height, 0.0];
            return StrandPoint {
                x: [side * self.half_loop.radius, 0.0, 0.0],
                z,
                phi: z.map(|z| z * self.half_loop.rate),
            };
        }
        // towards the apex or away from it, at the upper end or the lower
        let turn = if section == 2 || section == 5 { 1.0 } else { -1.0 };
        let end = if section == 2 || section == 3 { 1.0 } else { -1.0 };
        let place = self.half_loop.at(if turn > 0.0 { v } else { 1.0 - v });
        StrandPoint {
            x: flip(place.x, 0.0, side, turn),
            z: flip(place.z, end * half, end, turn),
            phi: flip(place.phi, end * middle, end, turn),
        }
    }
}

impl Parametrised for WoundStrands<'_> {
    fn at(&self, u: f64) -> [Vec3; 2] {
        let StrandPoint { x: [x, x1, _], z: [z, z1, _], phi: [phi, phi1, _] } = self.strand(u);
        let axis = self.axis.at(z);
        let (sin, cos) = phi.sin_cos();
        let (outward, around) = (Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0));
        let turned = outward * x1 + around * (x * phi1) + axis.rate.cross(&outward) * (x * z1);
        [axis.position + axis.frame * (outward * x), axis.slope * z1 + axis.frame * turned]
    }

    fn speed(&self, u: f64) -> f64 {
        if matches!(self.axis, AxisCurve::Straight { .. }) {
            let place = self.strand(u);
            return place.x[1].hypot(place.x[0] * place.phi[1]).hypot(place.z[1]);
        }
        self.at(u)[1].norm()
    }
}

fn check_sizes(length: f64, distance: f64) -> Result<(), InputError> {
    InputError::positive("shape.length", length)?;
    InputError::positive("shape.distance", distance)
}

fn check_angle(angle: f64) -> Result<(), InputError> {
    let ok = angle != 0.0 && angle.abs() <= FRAC_PI_4;
    InputError::check("shape.angle", angle, ok, "not 0 and within an eighth of a turn (45°) either way")
}

fn too_short(length: f64, distance: f64) -> InputError {
    let reason = format!(
        "the rod (length {length}) is too short for a plectoneme of strands {distance} apart: its two end loops alone \
         take all of it"
    );
    InputError::Inconsistent { field: "shape".into(), reason }
}

#[cfg(test)]
mod tests;
