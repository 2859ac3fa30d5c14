//! Only what a scene requires: sizes of reduced problems against the full one.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use supercoil::internals::broad_phase::BroadPhase;
use supercoil::internals::curve::CurveSet;
use supercoil::internals::exclusion::Exclusion;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model};
use supercoil::solve::{Engine, ProblemSize};

fn sizes(planar: bool, contact: Contact, radius: f64, natural: Natural) -> ProblemSize {
    let section = Section::isotropic(1.0, 1.5, 1e4, 1e4, radius);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(40, 3), section, natural).unwrap();
    Engine::new(Model { rods: vec![rod], planar, contact, ..Model::default() }, None).unwrap().problem_size().unwrap()
}

#[test]
fn planar_scenes_carry_three_unknowns_a_node_and_a_quarter_of_the_matrix() {
    let full = sizes(false, Contact::NONE, 0.01, Natural::Straight);
    let planar = sizes(true, Contact::NONE, 0.01, Natural::Straight);
    assert_eq!((full.nodes, full.unknowns), (120, 720));
    assert_eq!((planar.nodes, planar.unknowns), (120, 360));
    assert!(planar.tangent_entries as f64 <= full.tangent_entries as f64 / 3.5, "{planar:?} {full:?}");
    // supernodes are padded, small ones more
    assert!(planar.factor_entries as f64 <= full.factor_entries as f64 / 2.8, "{planar:?} {full:?}");
}

/// No tree, no candidate, no site: contact off, or on where no rod has a radius, leaves nothing of contact in the
/// engine.
#[test]
fn contact_off_is_nothing() {
    let on = sizes(false, Contact::default(), 0.01, Natural::Straight);
    assert_eq!(on.contact_segments, 120);
    for off in
        [sizes(false, Contact::NONE, 0.01, Natural::Straight), sizes(false, Contact::default(), 0.0, Natural::Straight)]
    {
        assert_eq!((off.contact_segments, off.candidates), (0, 0));
        assert_eq!(off.tangent_entries, on.tangent_entries, "far strands take no part in the matrix either");
    }
}

#[test]
fn natural_strains_are_kept_only_where_they_vary() {
    let uniform = Natural::Uniform { kappa: [1.0, 0.0, 0.0] };
    assert_eq!(sizes(false, Contact::NONE, 0.0, Natural::Straight).natural_strains, 0);
    assert_eq!(sizes(false, Contact::NONE, 0.0, uniform).natural_strains, 0);
    // a circle has the same curvature everywhere
    assert_eq!(sizes(false, Contact::NONE, 0.0, Natural::AsShaped).natural_strains, 0);
    let section = Section::isotropic(1.0, 1.5, 1e4, 1e4, 0.0);
    let points =
        (0..60).map(|k| std::f64::consts::TAU * f64::from(k) / 60.0).map(|t| Vec3::new(2.0 * t.cos(), t.sin(), 0.0));
    let oval =
        Rod::new("oval", &Shape::Points(points.collect()), RodMesh::closed(40, 3), section, Natural::AsShaped).unwrap();
    let mut engine = Engine::new(Model { rods: vec![oval], contact: Contact::NONE, ..Model::default() }, None).unwrap();
    assert_eq!(engine.problem_size().unwrap().natural_strains, 120);
}

/// Strands that move but stay apart keep their (empty) list of candidates, and with it the pattern of the matrix and
/// its symbolic analysis; strands that come near change it.
#[test]
fn strands_apart_keep_their_list() {
    let line = |z: f64| -> Vec<Vec3> { (0..40).map(|i| Vec3::new(f64::from(i), 0.0, z)).collect() };
    let mut set = CurveSet::from_polylines(&[(&line(0.0), 0.1, false), (&line(20.5), 0.1, false)]).unwrap();
    let mut exclusion = Exclusion::new();
    let mut broad = BroadPhase::new();
    for height in (0..=20).rev() {
        exclusion.update(&set).unwrap();
        broad.candidates(&set, &exclusion, 0.1, 0.5).unwrap();
        let near = height == 0;
        assert_eq!((broad.pairs().is_empty(), broad.generation()), (!near, if near { 2 } else { 1 }), "{height}.5");
        for segment in &mut set.segments_mut()[39..] {
            segment.b = segment.b.map(|p| p - Vec3::z());
        }
    }
}

/// A margin trades candidates for changes of the list (and of the pattern of the matrix with it): two strands wound
/// around each other, one sliding by a fiftieth of a radius a step.
#[test]
fn a_margin_saves_changes_and_costs_candidates() {
    let (radius, count) = (0.5, 1500);
    let strand = |phase: f64| -> Vec<Vec3> {
        let at = |k: i32| 0.25 * f64::from(k);
        (0..count)
            .map(|k| Vec3::new((at(k) + phase).cos(), (at(k) + phase).sin(), 0.8 * at(k)) * (1.05 * radius))
            .collect()
    };
    let (a, b) = (strand(0.0), strand(std::f64::consts::PI));
    let mut seen = Vec::new();
    for margin in [0.0, 0.1, 0.5, 2.0] {
        let mut set = CurveSet::from_polylines(&[(&a, radius, false), (&b, radius, false)]).unwrap();
        let (mut exclusion, mut broad) = (Exclusion::new(), BroadPhase::new());
        let mut candidates = 0;
        for _ in 0..100 {
            exclusion.update(&set).unwrap();
            candidates += broad.candidates(&set, &exclusion, 0.02 * radius, margin * radius).unwrap().len();
            let first = set.curves[1].first;
            for segment in &mut set.segments_mut()[first..] {
                segment.b = segment.b.map(|p| p + Vec3::z() * (0.02 * radius));
            }
        }
        println!(
            "margin {margin} radii: {} changes of the list in 100 steps, {:.1} candidates a segment",
            broad.generation(),
            candidates as f64 / 3e5
        );
        seen.push((broad.generation(), candidates));
    }
    assert!(seen.windows(2).all(|w| w[0].0 > w[1].0 && w[0].1 < w[1].1), "{seen:?}");
}
