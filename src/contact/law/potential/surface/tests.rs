use super::*;
use crate::contact::law::Law;

const RADIUS: f64 = 0.1;

/// A strand of four straight segments of length 1 along x, at a height above the plane z = 0; closed ones have no other
/// strand's worth of shape, only a seam.
fn strand(height: f64, closed: bool) -> CurveSet {
    let points: Vec<Vec3> = if closed {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, height)).to_vec()
    } else {
        (0..=4).map(|k| Vec3::new(f64::from(k), 0.0, height)).collect()
    };
    let mut set = CurveSet::from_polylines(&[(&points, RADIUS, closed)]).unwrap();
    set.set_lengths(&[1.0; 4]);
    set
}

const FLOOR: Surface = Surface {
    skeleton: Skeleton::Plane { point: Vec3::new(5.0, -3.0, -1.0), normal: Vec3::new(0.0, 0.0, 1.0) },
    level: 1.0,
    lost: Vec3::new(0.0, 0.0, 0.0),
    sign: 1.0,
    carried: false,
};
const LAW: Law = Law::Linear { stiffness: 7.0 };
/// The segments of a [`strand`], each with the only surface.
const ALL_FOUR: [[u32; 2]; 4] = [[0, 0], [1, 0], [2, 0], [3, 0]];
const ALL: Request = Request { zones: true, tangent: true };

/// A strand that lies along a plane, δ deep under an offset c, has the energy ½κ(c + δ)² and the pressure κ(c + δ) per
/// length, whatever the way round; one that only just is above has none.
#[test]
fn a_strand_along_a_plane_has_the_law_per_length() {
    for (depth, offset) in [(0.02, 0.0), (-0.01, 0.03), (0.0, 0.05)] {
        let set = strand(RADIUS - depth, false);
        let offsets = |_: usize, _: usize| [offset; 2];
        let pressures = Pressures::of(LAW, &offsets);
        let terms = evaluate(&set, (&[FLOOR], &ALL_FOUR), &pressures, ALL);
        assert_eq!(terms.len(), 4);
        let overlap = offset + depth;
        let energy: f64 = terms.iter().map(|term| term.energy).sum();
        assert!((energy - 4.0 * 0.5 * 7.0 * overlap * overlap).abs() < 1e-15, "{energy}");
        for term in &terms {
            let [zone] = term.contact.zones[..] else { panic!() };
            assert_eq!(zone.u, [0.0, 1.0]);
            assert!((zone.min_gap + depth).abs() < 1e-15 && (zone.moments[0] - 7.0 * overlap).abs() < 1e-14);
            assert!((zone.moments[1] / zone.moments[0] - 0.5).abs() < 1e-14);
            let push = term.gradient[2] + term.gradient[8];
            assert!((push + 7.0 * overlap).abs() < 1e-14, "{push}");
        }
        assert_eq!(surface_runs(&set, &terms.into_iter().map(|term| term.contact).collect::<Vec<_>>()).len(), 1);
    }
    let offsets = |_: usize, _: usize| [0.0; 2];
    let pressures = Pressures::of(LAW, &offsets);
    assert!(evaluate(&strand(RADIUS * 1.0001, false), (&[FLOOR], &ALL_FOUR), &pressures, ALL).is_empty());
}

/// Between offsets of different size at its ends the reach is linear: the zone ends where it meets the gap.
#[test]
fn zones_end_where_the_offset_meets_the_gap() {
    let set = strand(RADIUS + 0.03, false);
    let offsets = |segment: usize, _: usize| if segment == 1 { [0.1, 0.0] } else { [0.0; 2] };
    let pressures = Pressures::of(LAW, &offsets);
    let terms = evaluate(&set, (&[FLOOR], &ALL_FOUR), &pressures, ALL);
    assert_eq!(terms.len(), 1);
    let zone = terms[0].contact.zones[0];
    assert!(zone.u[0] == 0.0 && (zone.u[1] - 0.7).abs() < 1e-12, "{zone:?}");
    // ∫ ½κ(.07 − .1u)² du
    assert!((terms[0].energy - 0.5 * 7.0 * 0.07f64.powi(3) / 0.3).abs() < 1e-15, "{}", terms[0].energy);
}

/// Runs go on over the seam of a closed strand, and end where a zone does.
#[test]
fn runs_go_on_over_seams() {
    let set = strand(RADIUS, true);
    let zone = |u: [f64; 2]| SurfaceZone {
        u,
        min_gap: 0.0,
        nearest: u[0],
        moments: [1.0, 0.5, 0.3],
        force: Vec3::z(),
        torque: Vec3::zeros(),
    };
    let contact = |segment: usize, surface: usize, zones: &[[f64; 2]]| SurfaceContact {
        segment,
        surface,
        zones: zones.iter().map(|u| zone(*u)).collect(),
        points: Vec::new(),
    };
    let contacts = [
        contact(0, 0, &[[0.0, 0.2], [0.6, 1.0]]),
        contact(0, 1, &[[0.0, 1.0]]),
        contact(1, 0, &[[0.0, 0.5]]),
        contact(3, 0, &[[0.5, 1.0]]),
    ];
    let found: Vec<Vec<(usize, usize)>> = surface_runs(&set, &contacts)
        .iter()
        .map(|run| run.iter().map(|piece| (piece.segment, piece.surface)).collect())
        .collect();
    assert_eq!(found, [vec![(0, 0), (1, 0)], vec![(3, 0), (0, 0)], vec![(0, 1)]]);
}

/// A strand that dives through the plane and comes up again: zones end where it passes the limit, and the nearest place
/// is at its lowest point, or at the end of an interval without it.
#[test]
fn zones_and_nearest_places_of_cubics() {
    // z = (u − .25)(u − .5)(u − .75), and its deepest place between the last two
    let p = |u: f64| (u - 0.25) * (u - 0.5) * (u - 0.75);
    // Bernstein coefficients from values and slopes at both ends
    let slope = |u: f64| (p(u + 1e-6) - p(u - 1e-6)) / 2e-6;
    let coeffs = [p(0.0), p(0.0) + slope(0.0) / 3.0, p(1.0) - slope(1.0) / 3.0, p(1.0)];
    let r = coeffs.map(|z| Vec3::new(1.0, 2.0, z + 1.0));
    let parts = where_nearer(&FLOOR, &r, [0.0; 2]);
    assert_eq!(parts.len(), 2);
    for (part, expected) in parts.iter().zip([[0.0, 0.25], [0.5, 0.75]]) {
        assert!((0..2).all(|k| (part[k] - expected[k]).abs() < 1e-8), "{part:?}");
    }
    let (u, value) = nearest_in(&FLOOR, &r, [0.3, 1.0]);
    assert!((u - (0.5 + 0.25 / 3f64.sqrt())).abs() < 1e-6 && (value - p(u)).abs() < 1e-9);
    assert_eq!(nearest_in(&FLOOR, &r, [0.0, 1.0]).0, 0.0);
}

/// Zones of curved surfaces are those that many points of the curve tell, also where the limit is beyond the skeleton,
/// and the nearest place is the nearest of them.
#[test]
fn zones_at_curved_surfaces_are_those_of_many_points() {
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / (1_u64 << 31) as f64 * 2.0 - 1.0
    };
    let axis = Vec3::new(2.0, -1.0, 2.0) / 3.0;
    let mut found = 0;
    for k in 0..400 {
        let point = Vec3::zeros();
        let skeleton = match k % 4 {
            0 => Skeleton::Point { point },
            1 => Skeleton::Line { point, axis },
            2 => Skeleton::Piece { point, axis, length: None },
            _ => Skeleton::Piece { point, axis, length: Some(0.7) },
        };
        let sign = if k / 4 % 2 == 0 { 1.0 } else { -1.0 };
        let surface = Surface { skeleton, level: 0.6 + 0.4 * random(), lost: Vec3::zeros(), sign, carried: false };
        let r: [Vec3; 4] = std::array::from_fn(|_| Vec3::new(random(), random(), random()) * 1.4);
        let limit = [0.5 * random(), if k % 5 == 0 { 2.0 } else { 0.5 * random() }];
        let zones = where_nearer(&surface, &r, limit);
        found += zones.len();
        let (_, least) = nearest_in(&surface, &r, [0.0, 1.0]);
        for i in 0..=200 {
            let u = f64::from(i) / 200.0;
            let beyond = limit[0] + (limit[1] - limit[0]) * u - surface.distance(&point_of(&r, u));
            let inside = zones.iter().any(|zone| zone[0] <= u && u <= zone[1]);
            assert!(inside == (beyond > 0.0) || beyond.abs() < 1e-12, "{k} {u} {beyond} {zones:?}");
            assert!(surface.distance(&point_of(&r, u)) >= least - 1e-14);
        }
    }
    assert!(found > 200, "{found}");
}
