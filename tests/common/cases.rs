//! Models that several tests are about.

use std::f64::consts::{FRAC_PI_4, TAU};

use super::cantilever;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model};

/// The 45° bend of Bathe & Bolourchi (1979): an arc of radius 100, clamped at the origin along +x, a dead force along z
/// at its tip; section 1 × 1, E = 1e7, ν = 0. `shearing` is kGA. No contact.
pub fn bathe_bend(elements: usize, order: usize, force: f64, shearing: f64) -> Model {
    let section = Section::isotropic(1e7 / 12.0, 5e6 / 6.0, 1e7, shearing, 0.0);
    let shape =
        Shape::Arc { start: Vec3::zeros(), tangent: Vec3::x(), towards: Vec3::y(), radius: 100.0, angle: FRAC_PI_4 };
    let rod = Rod::new("bend", &shape, RodMesh::open(elements, order), section, Natural::AsShaped).unwrap();
    cantilever(rod, Vec3::z() * force, Vec3::zeros())
}

/// Tip of the continuous rod under a force of 600, kGA = 5/6·5e6.
pub const BATHE_TIP_AT_600: [f64; 3] = [47.150_096_240_3, 15.684_689_479_0, 53.475_477_998_2];

/// A planar closed rod of length 2π, B = 1, that starts as a slight oval, so that pressure folds it about an element
/// boundary.
pub fn oval_ring(elements: usize, diameter: f64, stiff: f64, law: ContactLaw) -> Model {
    let section = Section::isotropic(1.0, 1.0, stiff, stiff, 0.5 * diameter);
    let oval = |k: i32| TAU * f64::from(k) / 48.0;
    let points = (0..48).map(|k| Vec3::new(1.02 * oval(k).cos(), 0.98 * oval(k).sin(), 0.0)).collect();
    let mut rod =
        Rod::new("ring", &Shape::Points(points), RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
    let scale = TAU / rod.length;
    rod.length = TAU;
    rod.positions.iter_mut().for_each(|r| *r *= scale);
    Model { rods: vec![rod], planar: true, contact: Contact { law }, ..Model::default() }
}
