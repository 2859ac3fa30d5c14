//! From the text of a shape to the shape.

use std::f64::consts::TAU;
use std::path::Path;

use crate::error::InputError;
use crate::math::Vec3;
use crate::math::link::knot::closed_braid::{closed_braid, overhand};
use crate::math::link::knot::{pd_code, table};
use crate::rod::within;
use crate::rod::{Axis, Plectoneme, Section, Shape, TorusKnot};
use crate::scene::file::syntax::ShapeText;
use crate::scene::file::syntax::values::List;
use crate::scene::{Import, read_points_with, smooth_points};

/// Largest distance of a repeated first point at the end, over the mean distance of points.
const TOL_CLOSING: f64 = 1e-3;

/// Data for plectonemes beyond their own keys.
pub(super) struct Wound<'a> {
    pub section: &'a Section,
    pub excess_link: Option<f64>,
    pub closed: bool,
    /// Length of shapes that do not give one \[L\].
    pub length: Option<f64>,
}

impl Wound<'_> {
    fn length(&self, given: Option<f64>) -> Result<f64, InputError> {
        let missing =
            || InputError::inconsistent("shape.length", "missing: the length of the rod, unless dna has base_pairs");
        given.or(self.length).ok_or_else(missing)
    }
}

pub(super) fn shape(text: &ShapeText, base_dir: &Path, wound: &Wound) -> Result<Shape, InputError> {
    Ok(match *text {
        ShapeText::Line { start, direction, length } => {
            Shape::Line { start: start.into(), direction: direction.into(), length: wound.length(length)? }
        }
        ShapeText::Circle { length, radius, center, normal } => Shape::Circle {
            length: circumference(length, radius, wound)?,
            center: center.into(),
            normal: normal.into(),
        },
        ShapeText::Arc { start, tangent, towards, radius, turns } => {
            let ok = turns > 0.0 && turns <= 1.0;
            InputError::check("shape.turns", turns, ok, "greater than 0 and at most 1 (turns)")?;
            let (start, tangent, towards) = (start.into(), tangent.into(), towards.into());
            Shape::Arc { start, tangent, towards, radius, angle: TAU * turns }
        }
        ShapeText::Helix { center, axis, radius, pitch, turns } => {
            Shape::Helix { center: center.into(), axis: axis.into(), radius, pitch, turns }
        }
        ShapeText::Points { .. } => Shape::Points(points(text, base_dir, wound.closed)?),
        ShapeText::State { .. } | ShapeText::Frames { .. } => {
            return Err(InputError::inconsistent("shape", "a state is nodes with frames, no curve"));
        }
        ShapeText::Knot { .. } => Shape::Points(knot(text, wound)?),
        ShapeText::Overhand { length, radius, half_turns, start } => {
            if wound.closed {
                return Err(InputError::inconsistent("shape", "an overhand knot is tied in an open rod"));
            }
            InputError::positive("shape.radius", radius)?;
            let length = wound.length(length)?;
            InputError::positive("shape.length", length)?;
            let start: Vec3 = start.into();
            let tied = overhand(length / radius, half_turns)?;
            // the curve through the points is longer than their chords, by some parts in ten thousand
            let scale = length / Shape::Points(tied.clone()).place(false, 2 * tied.len())?.length;
            Shape::Points(tied.into_iter().map(|point| start + point * scale).collect())
        }
        ShapeText::Plectoneme { .. } => plectoneme(text, base_dir, wound)?,
        ShapeText::TorusKnot { length, windings: List(windings), aspect, phase, center, normal } => {
            let (length, phase) = (wound.length(length)?, TAU * phase);
            let (center, normal) = (center.into(), normal.into());
            TorusKnot { length, windings, aspect, phase, center, normal }.into()
        }
    })
}

/// Points of a knot, scaled so that the curve through them has the length, or strands the distance, that is requested.
fn knot(text: &ShapeText, wound: &Wound) -> Result<Vec<Vec3>, InputError> {
    let ShapeText::Knot { name, braid, pd, component, length, distance, center } = text else {
        return Err(InputError::inconsistent("shape", "is no knot"));
    };
    if !wound.closed {
        return Err(InputError::inconsistent("shape", "a knot is closed: set closed = true"));
    }
    let word = match (name, braid, pd) {
        (Some(name), None, None) => table::named(name)?,
        (None, Some(word), None) => word.clone(),
        (None, None, Some(code)) => pd_code::braid_of(&code.iter().map(|List(edges)| *edges).collect::<Vec<_>>())?,
        _ => {
            let reason = "a knot is given by its name, by a braid or by a PD code (pd), one of them";
            return Err(InputError::inconsistent("shape", reason));
        }
    };
    let points = closed_braid(&word, *component)?;
    let scale = match (length, distance) {
        (Some(_), Some(_)) => {
            return Err(InputError::inconsistent("shape.distance", "follows from the length: give one of them"));
        }
        (None, Some(distance)) => InputError::positive("shape.distance", *distance).map(|()| *distance)?,
        _ => {
            let length = wound.length(*length)?;
            InputError::positive("shape.length", length)?;
            length / Shape::Points(points.clone()).place(true, 2 * points.len())?.length
        }
    };
    let center: Vec3 = (*center).into();
    Ok(points.into_iter().map(|point| center + point * scale).collect())
}

fn circumference(length: Option<f64>, radius: Option<f64>, wound: &Wound) -> Result<f64, InputError> {
    match (length, radius) {
        (Some(length), None) => Ok(length),
        (None, Some(radius)) => InputError::positive("shape.radius", radius).map(|()| TAU * radius),
        (None, None) if wound.length.is_some() => wound.length(None),
        _ => Err(InputError::inconsistent("shape", "a circle is given by its length or by its radius")),
    }
}

/// Points of a file, smoothed if requested.
fn points(text: &ShapeText, base_dir: &Path, closed: bool) -> Result<Vec<Vec3>, InputError> {
    let ShapeText::Points { file, columns, frame, chain, every, scale, smooth, .. } = text else {
        return Err(InputError::inconsistent("shape", "is no list of points"));
    };
    let refuse = |_| InputError::inconsistent("shape.columns", "takes three names: of the columns of x, y and z");
    let three = |names: Vec<String>| <[String; 3]>::try_from(names).map_err(refuse);
    let columns = columns.clone().map(three).transpose()?;
    let import = Import { columns, frame: *frame, chain: chain.clone(), every: *every, scale: *scale };
    let path = base_dir.join(file);
    let mut points = read_points_with(&path, &import).map_err(|error| within("shape", error))?;
    if closed {
        drop_closing_point(&mut points);
    }
    if points.is_empty() {
        return Err(InputError::Parse { file: path.display().to_string(), reason: "holds no points".to_owned() });
    }
    match smooth {
        Some(length) => smooth_points(&points, closed, *length).map_err(|error| within("shape", error)),
        None => Ok(points),
    }
}

/// Removes a last point that repeats the first, because a closed spline continues from the last to the first.
fn drop_closing_point(points: &mut Vec<Vec3>) {
    let way: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    if let [first, .., last] = points[..]
        && way.is_finite()
        && (last - first).norm() <= TOL_CLOSING * way / points.len() as f64
    {
        points.pop();
    }
}

fn plectoneme(text: &ShapeText, base_dir: &Path, wound: &Wound) -> Result<Shape, InputError> {
    let ShapeText::Plectoneme { length, distance, turns, angle, center, direction, ref axis } = *text else {
        return Err(InputError::inconsistent("shape", "is no plectoneme"));
    };
    let length = wound.length(length)?;
    let distance = match distance {
        Some(distance) => distance,
        None if wound.section.contact_radius > 0.0 => 2.0 * wound.section.contact_radius,
        None => {
            let reason =
                "missing: the distance between the strands (by default twice the contact radius, which is 0 here)";
            return Err(InputError::inconsistent("shape.distance", reason));
        }
    };
    let plectoneme = match (turns, angle, wound.excess_link) {
        (Some(turns), None, _) => Plectoneme::of_turns(length, distance, turns)?,
        (None, Some(angle), _) => Plectoneme::of_angle(length, distance, TAU * angle)?,
        (None, None, Some(excess_link)) => {
            // A twisted anisotropic section bends about both axes alike: the harmonic mean.
            let [b1, b2] = wound.section.bending;
            let (bending, twisting) = (2.0 / (1.0 / b1 + 1.0 / b2), wound.section.twisting);
            Plectoneme::of_link(length, distance, bending, twisting, excess_link)?
        }
        _ => {
            let reason =
                "how tightly is it wound? Give excess_link of the rod, or turns or angle of the shape (one of them)";
            return Err(InputError::inconsistent("shape", reason));
        }
    };
    let axis = match (axis, center, direction) {
        (Some(axis), None, None) => {
            Axis::Along(Box::new(shape(axis, base_dir, &Wound { length: None, closed: false, ..*wound })?))
        }
        (Some(_), _, _) => {
            return Err(InputError::inconsistent("shape.axis", "has its own place: remove center and direction"));
        }
        (None, center, direction) => Axis::Straight {
            center: center.unwrap_or_default().into(),
            direction: direction.map_or(Vec3::x(), Vec3::from),
        },
    };
    Ok(Shape::Plectoneme(plectoneme.about(axis)))
}
