//! The potential where a slave passes centres of curvature and kinks of its master, against its definition and finite
//! differences.

use super::*;
use crate::contact::curves::curve::{Cubic, CurveInput};
use crate::contact::zones::FootKind;
use crate::math::Mat3;
use crate::math::random::Random;

const STIFFNESS: f64 = 3.0;
const RADIUS: f64 = 0.25;
const REACH: f64 = 2.0 * RADIUS;
/// Strands nearer than this overlap by more than the quadrature is for.
const DEEP: f64 = 0.5 * REACH;

/// Cubics through random points with common tangents where they meet, or kinks; on average curved about as much as 1
/// over the reach.
fn master(random: &mut Random, smooth: bool) -> Vec<Cubic> {
    let mut points = vec![Vec3::new(-0.7, 0.0, 0.0)];
    let mut tangents = vec![Vec3::new(0.5, 0.0, 0.0) + random.vector() * 0.5];
    for x in [-0.2, 0.3, 0.8] {
        points.push(Vec3::new(x, 0.0, 0.0) + random.vector() * 0.3);
        tangents.push(Vec3::new(0.5, 0.0, 0.0) + random.vector() * 0.5);
    }
    let kink = |random: &mut Random| random.vector() * if smooth { 0.0 } else { 0.4 };
    (0..3).map(|k| Cubic::from_hermite(points[k], tangents[k] + kink(random), points[k + 1], tangents[k + 1])).collect()
}

fn slave(random: &mut Random) -> Vec<Cubic> {
    let away = random.vector() * 0.5;
    let along = random.vector() * 0.8;
    let bend = random.vector() * 0.2;
    vec![Cubic { b: [away - along, away - along * 0.4 + bend, away + along * 0.3 - bend, away + along] }]
}

fn input(segments: &[Cubic], closed: bool) -> CurveInput {
    CurveInput { segments: segments.to_vec(), lengths: vec![1.0; segments.len()], closed, radius: RADIUS }
}

/// Terms whose slave is the last curve, or all.
fn terms(master: &[Cubic], slave: &[Cubic], closed: bool, want: Want) -> Vec<PairTerm> {
    let set = CurveSet::new(vec![input(master, closed), input(slave, false)]).unwrap();
    let count = master.len() as u32;
    let pairs: Vec<[u32; 2]> = (0..count).map(|k| [k, count]).collect();
    evaluate(&set, &pairs, Law::Linear { stiffness: STIFFNESS }, &|_, _| [0.0; 2], want)
}

/// ½∫φ ds over one slave by counting strands: φ of all nearest points of a densely sampled master less φ of all
/// farthest.
fn energy_by_counting(master: &[Cubic], slave: &Cubic, closed: bool) -> f64 {
    const SLAVE: usize = 1000;
    const MASTER: usize = 400;
    let fine: Vec<Vec3> = master
        .iter()
        .flat_map(|cubic| (0..MASTER).map(|k| cubic.point(k as f64 / MASTER as f64)))
        .chain((!closed).then_some(master[master.len() - 1].b[3]))
        .collect();
    let phi = |d: f64| 0.5 * STIFFNESS * (REACH - d).max(0.0).powi(2);
    let n = fine.len();
    let at = |k: usize| {
        let x = slave.point((k as f64 + 0.5) / SLAVE as f64);
        let d: Vec<f64> = fine.iter().map(|p| (p - x).norm()).collect();
        let mut sum = 0.0;
        for m in 0..n {
            let end = !closed && (m == 0 || m == n - 1);
            let before = if end && m == 0 { f64::INFINITY } else { d[(m + n - 1) % n] };
            let after = if end && m == n - 1 { f64::INFINITY } else { d[(m + 1) % n] };
            if d[m] >= REACH {
                continue;
            }
            // A parabola through three points, so that the sampling's error is of higher order.
            let vertex =
                if end { d[m] } else { d[m] - (after - before).powi(2) / (8.0 * (after + before - 2.0 * d[m])) };
            let vertex = if vertex.is_finite() && (vertex - d[m]).abs() < 1e-4 { vertex } else { d[m] };
            if d[m] < before && d[m] <= after {
                sum += phi(vertex);
            } else if d[m] > before && d[m] >= after {
                sum -= phi(vertex);
            }
        }
        // A ring within reach as a whole is one strand.
        sum + if closed { phi(d.iter().copied().fold(0.0, f64::max)) } else { 0.0 }
    };
    0.5 * (0..SLAVE).map(at).sum::<f64>() / SLAVE as f64
}

/// Smallest distance of the slave, to leave out overlaps that are deeper than the quadrature is for.
fn nearest(master: &[Cubic], slave: &Cubic) -> f64 {
    let fine = |c: &Cubic| (0..=60).map(|k| c.point(f64::from(k) / 60.0)).collect::<Vec<_>>();
    let own = fine(slave);
    let apart = |q: Vec3| own.iter().map(|p| (p - q).norm()).fold(f64::INFINITY, f64::min);
    master.iter().flat_map(fine).map(apart).fold(f64::INFINITY, f64::min)
}

#[test]
fn energy_counts_strands_through_folds_and_kinks() {
    let mut random = Random(31);
    let (mut off, mut folds) = (0, 0);
    for case in 0..400 {
        let smooth = case % 2 == 0;
        let (master, slave) = (master(&mut random, smooth), slave(&mut random));
        let terms = terms(&master, &slave, false, Want::Gradient);
        let ours: f64 = terms.iter().filter(|t| t.slave == master.len()).map(|t| t.energy).sum();
        let pieces = || terms.iter().filter(|t| t.slave == master.len()).flat_map(|t| &t.zones).map(|z| z.piece);
        if pieces().count() == 0 || nearest(&master, &slave[0]) < DEEP {
            continue;
        }
        let counted = energy_by_counting(&master, &slave[0], false);
        off += usize::from(pieces().any(|p| p.branch.sign < 0.0));
        folds += usize::from(pieces().any(|p| p.branch.kind == FootKind::Fold));
        assert!((ours - counted).abs() < 2e-3 * counted + 1e-5, "case {case}: {ours} {counted}");
    }
    assert!(off > 20 && folds > 20, "{off} {folds}");
}

/// A ring of radius `size` about the z axis, out of round by `uneven`.
fn ring(size: f64, uneven: f64) -> Vec<Cubic> {
    const COUNT: usize = 8;
    let h = std::f64::consts::TAU / COUNT as f64;
    let at = |k: usize| {
        let (s, c) = (h * k as f64).sin_cos();
        let point = Vec3::new(c, s * (1.0 + uneven), uneven * (2.0 * s * s - 1.0));
        (point * size, Vec3::new(-s, c * (1.0 + uneven), 4.0 * uneven * s * c) * (size * h))
    };
    (0..COUNT).map(|k| Cubic::from_hermite(at(k).0, at(k).1, at(k + 1).0, at(k + 1).1)).collect()
}

/// A strand through a ring that is narrower than the contact distance: near the axis every point of the ring is about
/// as far.
#[test]
fn a_ring_about_a_strand_is_one_strand() {
    for (size, uneven) in [(0.4, 0.0), (0.4, 1e-3), (0.35, 0.05), (0.45, 0.2)] {
        let master = ring(size, uneven);
        for off in [0.0, 1e-6, 1e-3, 0.02, 0.1] {
            let slave = Cubic::straight(Vec3::new(off, 0.6 * off, -0.4), Vec3::new(off, -off, 0.6));
            let terms = terms(&master, &[slave], true, Want::Gradient);
            let ours: f64 = terms.iter().filter(|t| t.slave == master.len()).map(|t| t.energy).sum();
            let counted = energy_by_counting(&master, &slave, true);
            assert!((ours - counted).abs() < 2e-3 * counted, "{size} {uneven} {off}: {ours} {counted}");
        }
    }
}

/// Energy, gradient and Hessian by control point of all cubics, at fixed reference lengths.
fn whole(cubics: &[Cubic], want: Want) -> (f64, Vec<Vec3>, Vec<Vec<Mat3>>) {
    let count = cubics.len() - 1;
    let size = if want == Want::Hessian { 4 * cubics.len() } else { 0 };
    let (mut energy, mut gradient) = (0.0, vec![Vec3::zeros(); 4 * cubics.len()]);
    let mut hessian = vec![vec![Mat3::zeros(); size]; size];
    for term in terms(&cubics[..count], &cubics[count..], false, want) {
        energy += term.energy;
        let place = |m: usize| 4 * if m < 4 { term.slave } else { term.master } + m % 4;
        for m in 0..8 {
            gradient[place(m)] += term.gradient[m];
            let Some(blocks) = &term.hessian else { continue };
            for n in m..8 {
                hessian[place(m)][place(n)] += blocks[m][n];
                if n > m {
                    hessian[place(n)][place(m)] += blocks[m][n].transpose();
                }
            }
        }
    }
    (energy, gradient, hessian)
}

/// Slopes by finite differences while the slave is moved through folds and kinks: along a random direction in which all
/// control points of the slave and, continuously, those of the master move.
#[test]
fn derivatives_hold_through_folds_and_kinks() {
    let mut random = Random(47);
    let mut tried = [0; 2];
    let mut worst = [0.0_f64; 2];
    for case in 0..600 {
        let mut cubics = master(&mut random, case % 2 == 0);
        cubics.extend(slave(&mut random));
        let count = cubics.len() - 1;
        let found = terms(&cubics[..count], &cubics[count..], false, Want::Gradient);
        let mut pieces = found.iter().flat_map(|t| &t.zones).map(|z| z.piece.branch);
        if !pieces.any(|b| b.sign < 0.0 || b.kind == FootKind::Fold) || nearest(&cubics[..count], &cubics[count]) < DEEP
        {
            continue;
        }
        // Joints stay as smooth as they are: the same affine map for the master, another for the slave.
        let maps = [(); 2].map(|()| (Mat3::from_fn(|_, _| 0.3 * random.unit()), random.vector() * 0.5));
        let velocity: Vec<Vec3> = (0..4 * cubics.len())
            .map(|k| {
                let (turn, shift) = &maps[usize::from(k / 4 == count)];
                turn * cubics[k / 4].b[k % 4] + shift
            })
            .collect();
        let moved = |h: f64, want: Want| {
            let b = |k: usize, m: usize| cubics[k].b[m] + velocity[4 * k + m] * h;
            let moved: Vec<Cubic> = (0..=count).map(|k| Cubic { b: std::array::from_fn(|m| b(k, m)) }).collect();
            whole(&moved, want)
        };
        let along = |v: &[Vec3]| v.iter().zip(&velocity).map(|(g, w)| g.dot(w)).sum::<f64>();
        let (_, gradient, hessian) = moved(0.0, Want::Hessian);
        let h = 1e-5;
        let (plus, minus) = (moved(h, Want::Gradient), moved(-h, Want::Gradient));
        let slope = (plus.0 - minus.0) / (2.0 * h);
        let size = gradient.iter().zip(&velocity).map(|(g, w)| g.norm() * w.norm()).sum::<f64>();
        let curvature = (along(&plus.1) - along(&minus.1)) / (2.0 * h);
        let ours: f64 = hessian
            .iter()
            .zip(&velocity)
            .map(|(row, w)| row.iter().zip(&velocity).map(|(block, z)| w.dot(&(block * z))).sum::<f64>())
            .sum();
        let errors = [(slope - along(&gradient)).abs() / (size + 1e-3), (curvature - ours).abs() / (size + 1e-2)];

        for k in 0..2 {
            worst[k] = worst[k].max(errors[k]);
        }
        tried[case % 2] += 1;
    }
    assert!(tried.iter().all(|&n| n > 20), "{tried:?}");
    assert!(worst[0] < 3e-4 && worst[1] < 3e-3, "{worst:?}");
}
