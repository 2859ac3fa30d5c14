//! The braid of a loose elastic knot in the limit of no thickness (Audoly, Clauvelin & Neukirch 2007), by finite
//! differences: the difference of its two strands, w(s) ∈ ℝ² for |s| ≤ L, minimises ∫½|w″|² ds − w_x′(L) − w_x′(−L)
//! (the loop's curvature, 1, bends both ends outwards; half turns are odd) with |w| ≥ 1. Lengths in √(2hR) along the
//! strands and 2h across.
//!
//! Independent of the engine: its own unknowns, its own banded solver, damped Newton on a penalty ½k⟨1 − |w|⟩².

#![allow(dead_code)] // one test file uses it

use std::f64::consts::PI;

/// Entries on either side of the diagonal.
const WIDTH: usize = 5;

/// Contact force ∫p ds and distance of the outermost contacts.
#[derive(Debug, Clone, Copy)]
pub struct Braid {
    pub force: f64,
    pub extent: f64,
}

/// Two strands wound about each other by an odd number of `half_turns`, on `points` equally spaced points over |s| ≤
/// `reach`; the penalties are gone through in turn.
pub fn braid(half_turns: f64, reach: f64, points: usize, penalties: &[f64]) -> Braid {
    let spacing = 2.0 * reach / (points - 1) as f64;
    let place = |i: usize| spacing * i as f64 - reach;
    let wound = 0.8 * half_turns;
    let mut w: Vec<f64> = (0..points)
        .flat_map(|i| {
            let t = (0.5 + 0.5 * place(i) / wound).clamp(0.0, 1.0);
            let angle = half_turns * PI * t * t * (3.0 - 2.0 * t);
            let out = 1.02 + 0.5 * (place(i).abs() - wound).max(0.0).powi(2);
            [-out * angle.cos(), -out * angle.sin()]
        })
        .collect();
    for &penalty in penalties {
        settle(&mut w, spacing, penalty);
    }
    let penalty = penalties[penalties.len() - 1];
    // zones of contact: force and its first moment
    let mut zones: Vec<[f64; 2]> = Vec::new();
    let mut inside = false;
    for i in 0..points {
        let force = penalty * spacing * (1.0 - w[2 * i].hypot(w[2 * i + 1])).max(0.0);
        if force > 0.0 {
            if !inside {
                zones.push([0.0; 2]);
            }
            let last = zones.len() - 1;
            zones[last][0] += force;
            zones[last][1] += force * place(i);
        }
        inside = force > 0.0;
    }
    let center = |zone: &[f64; 2]| zone[1] / zone[0];
    Braid { force: zones.iter().map(|zone| zone[0]).sum(), extent: center(&zones[zones.len() - 1]) - center(&zones[0]) }
}

/// Damped Newton; steps of at most .2.
fn settle(w: &mut Vec<f64>, spacing: f64, penalty: f64) {
    let mut damping: f64 = 1e-2;
    for _ in 0..3000 {
        let (energy, gradient, tangent) = derivatives(w, spacing, penalty);
        let size = loop {
            let mut damped = tangent.clone();
            damped.iter_mut().for_each(|row| row[WIDTH] += damping * spacing);
            if let Some(step) = solve(damped, gradient.iter().map(|g| -g).collect()) {
                let size = step.iter().fold(0.0f64, |a, x| a.max(x.abs()));
                let share = (0.2 / size).min(1.0);
                let next: Vec<f64> = w.iter().zip(&step).map(|(x, s)| x + share * s).collect();
                if derivatives(&next, spacing, penalty).0 < energy + 1e-11 * energy.abs() {
                    *w = next;
                    break size;
                }
            }
            damping = (4.0 * damping).max(1e-8);
        };
        damping = if damping > 1e-9 { damping / 5.0 } else { 1e-10 };
        if size < 1e-8 {
            return;
        }
    }
    panic!("the braid did not come to rest");
}

type Band = Vec<[f64; 2 * WIDTH + 1]>;

/// Energy, gradient and tangent (row i holds columns i − 5 to i + 5).
fn derivatives(w: &[f64], spacing: f64, penalty: f64) -> (f64, Vec<f64>, Band) {
    let count = w.len();
    let mut energy = 0.0;
    let (mut gradient, mut tangent) = (vec![0.0; count], vec![[0.0; 2 * WIDTH + 1]; count]);
    let stiffness = spacing.powi(-3);
    for i in 2..count - 2 {
        let stencil = [(i - 2, 1.0), (i, -2.0), (i + 2, 1.0)];
        let bend: f64 = stencil.iter().map(|&(j, c)| c * w[j]).sum();
        energy += 0.5 * stiffness * bend * bend;
        for (j, c) in stencil {
            gradient[j] += stiffness * bend * c;
            for (k, d) in stencil {
                tangent[j][WIDTH + k - j] += stiffness * c * d;
            }
        }
    }
    for (before, after) in [(0, 2), (count - 4, count - 2)] {
        energy -= (w[after] - w[before]) / spacing;
        gradient[after] -= 1.0 / spacing;
        gradient[before] += 1.0 / spacing;
    }
    for i in (0..count).step_by(2) {
        let distance = w[i].hypot(w[i + 1]);
        let overlap = 1.0 - distance;
        if overlap <= 0.0 {
            continue;
        }
        energy += 0.5 * penalty * spacing * overlap * overlap;
        let normal = [w[i] / distance, w[i + 1] / distance];
        let (along, across) = (penalty * spacing, -penalty * spacing * overlap / distance);
        for a in 0..2 {
            gradient[i + a] -= along * overlap * normal[a];
            for b in 0..2 {
                let identity = if a == b { 1.0 } else { 0.0 };
                tangent[i + a][WIDTH + b - a] +=
                    along * normal[a] * normal[b] + across * (identity - normal[a] * normal[b]);
            }
        }
    }
    (energy, gradient, tangent)
}

/// Gaussian elimination without pivoting; `None` unless positive definite.
fn solve(mut band: Band, mut x: Vec<f64>) -> Option<Vec<f64>> {
    let count = x.len();
    for i in 0..count {
        let pivot = band[i];
        if pivot[WIDTH] <= 0.0 {
            return None;
        }
        for k in i + 1..count.min(i + WIDTH + 1) {
            let factor = band[k][WIDTH + i - k] / pivot[WIDTH];
            for j in i..count.min(i + WIDTH + 1) {
                band[k][WIDTH + j - k] -= factor * pivot[WIDTH + j - i];
            }
            x[k] -= factor * x[i];
        }
    }
    for i in (0..count).rev() {
        for j in i + 1..count.min(i + WIDTH + 1) {
            x[i] -= band[i][WIDTH + j - i] * x[j];
        }
        x[i] /= band[i][WIDTH];
    }
    Some(x)
}
