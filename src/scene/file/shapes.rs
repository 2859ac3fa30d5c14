//! From the text of a shape to the shape.

use std::f64::consts::TAU;
use std::path::Path;

use crate::error::InputError;
use crate::math::Vec3;
use crate::rod::{Axis, Natural, Plectoneme, Section, Shape, TorusKnot};
use crate::scene::read_points;

use super::build::inconsistent;
use super::text::ShapeText;
use super::values::List;

/// What decides how a plectoneme is wound, besides its own keys.
pub(super) struct Wound<'a> {
    pub section: &'a Section,
    pub natural: &'a Natural,
    pub excess_link: Option<f64>,
}

pub(super) fn shape(text: &ShapeText, base_dir: &Path, wound: &Wound) -> Result<Shape, InputError> {
    Ok(match *text {
        ShapeText::Line { start, direction, length } => {
            Shape::Line { start: start.into(), direction: direction.into(), length }
        }
        ShapeText::Circle { length, radius, center, normal } => {
            let length = match (length, radius) {
                (Some(length), None) => length,
                (None, Some(radius)) => InputError::positive("shape.radius", radius).map(|()| TAU * radius)?,
                _ => return Err(inconsistent("shape".into(), "a circle is given by its length or by its radius")),
            };
            Shape::Circle { length, center: center.into(), normal: normal.into() }
        }
        ShapeText::Arc { start, tangent, towards, radius, turns } => {
            let ok = turns > 0.0 && turns <= 1.0;
            InputError::check("shape.turns", turns, ok, "greater than 0 and at most 1 (turns)")?;
            let (start, tangent, towards) = (start.into(), tangent.into(), towards.into());
            Shape::Arc { start, tangent, towards, radius, angle: TAU * turns }
        }
        ShapeText::Helix { center, axis, radius, pitch, turns } => {
            Shape::Helix { center: center.into(), axis: axis.into(), radius, pitch, turns }
        }
        ShapeText::Points { ref file } => {
            let path = base_dir.join(file);
            let points = read_points(&path)?;
            if points.is_empty() {
                return Err(InputError::Parse {
                    file: path.display().to_string(),
                    reason: "holds no points".to_owned(),
                });
            }
            Shape::Points(points)
        }
        ShapeText::Plectoneme { .. } => plectoneme(text, base_dir, wound)?,
        ShapeText::TorusKnot { length, windings: List(windings), aspect, phase, center, normal } => {
            let (phase, center, normal) = (TAU * phase, center.into(), normal.into());
            TorusKnot { length, windings, aspect, phase, center, normal }.into()
        }
    })
}

fn plectoneme(text: &ShapeText, base_dir: &Path, wound: &Wound) -> Result<Shape, InputError> {
    let ShapeText::Plectoneme { length, distance, turns, angle, center, direction, ref axis } = *text else {
        return Err(inconsistent("shape".into(), "is no plectoneme"));
    };
    let distance = match distance {
        Some(distance) => distance,
        None if wound.section.contact_radius > 0.0 => 2.0 * wound.section.contact_radius,
        None => {
            let reason =
                "missing: the distance between the strands (by default twice the contact radius, which is 0 here)";
            return Err(inconsistent("shape.distance".into(), reason));
        }
    };
    let plectoneme = match (turns, angle, wound.excess_link) {
        (Some(turns), None, _) => Plectoneme::of_turns(length, distance, turns)?,
        (None, Some(angle), _) => Plectoneme::of_angle(length, distance, TAU * angle)?,
        (None, None, Some(excess_link)) => {
            let natural_twist = match wound.natural {
                Natural::Uniform { kappa } => kappa[2] * length / TAU,
                Natural::Varying(along) => along.mean(length)[5] * length / TAU,
                Natural::Straight | Natural::AsShaped => 0.0,
            };
            // A section stiffer one way is bent both ways alike where it twists quickly: the harmonic mean.
            let [b1, b2] = wound.section.bending;
            let (bending, twisting) = (2.0 / (1.0 / b1 + 1.0 / b2), wound.section.twisting);
            Plectoneme::of_link(length, distance, bending, twisting, excess_link - natural_twist)?
        }
        _ => {
            let reason =
                "how tightly is it wound? Give excess_link of the rod, or turns or angle of the shape (one of them)";
            return Err(inconsistent("shape".into(), reason));
        }
    };
    let axis = match (axis, center, direction) {
        (Some(axis), None, None) => Axis::Along(Box::new(shape(axis, base_dir, wound)?)),
        (Some(_), _, _) => {
            return Err(inconsistent("shape.axis".into(), "has its own place: remove center and direction"));
        }
        (None, center, direction) => Axis::Straight {
            center: center.unwrap_or_default().into(),
            direction: direction.map_or(Vec3::x(), Vec3::from),
        },
    };
    Ok(Shape::Plectoneme(plectoneme.about(axis)))
}
