//! Contact along lines: the pressure of each line site as a function of arc length.
//!
//! The contact law spreads pressure over a width (B/κ)^¼; faster variations along a line, and those from element to
//! element, are due to the mesh. So the force of each piece of a zone is distributed over the samples within that width
//! or half an element, with weights of sum 1: the curve is smooth, and its integral is the force of the site to
//! rounding. The forces on nodes are spread in the same way where they are shown ([`spread`]).

use crate::contact::arc::near;
use crate::contact::curve::CurveSet;
use crate::contact::potential::ContactPair;
use crate::observe::report::{LineSample, SiteKind};

use super::{Composed, ContactZones, Layer, SiteZone, composed, contacts, site};

/// Samples per width of the smoothing.
const A_WIDTH: f64 = 2.0;
/// Most samples of a line.
const MOST_SAMPLES: usize = 2000;
/// Cut-off distance of a piece, in widths.
const REACH: f64 = 4.0;

/// A piece of a zone: arc lengths on strands a and b, half a force, the smallest gap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source {
    pub(super) arcs: [f64; 2],
    pub(super) force: f64,
    pub(super) gap: f64,
}

/// Samples of all lines; `site` counts as in [`sites`](super::sites).
pub(in crate::observe) fn lines(
    set: &CurveSet,
    terms: &[ContactPair],
    rods: &[usize],
    layer: &Layer,
) -> Vec<LineSample> {
    let Composed { zones, pieces, folds } = composed(set, terms);
    let mut found: Vec<_> = contacts(set, &zones, &folds, layer)
        .into_iter()
        .map(|members| (site(ContactZones { set, zones: &zones, members: &members }, rods, layer), members))
        .collect();
    let strongest = super::strongest(found.iter().map(|((report, _), _)| report));
    found.retain(|((report, _), _)| super::touches(report, strongest));
    found.sort_by(|(x, _), (y, _)| super::by_arcs(&x.0, &y.0));
    let mut samples = Vec::new();
    for (index, ((report, swapped), members)) in found.iter().enumerate() {
        if report.kind != SiteKind::Line {
            continue;
        }
        let first = &zones[members[0].0];
        let curves = if *swapped { [first.curve_b, first.curve_a] } else { [first.curve_a, first.curve_b] };
        let starts = [report.arc_a[0], report.arc_b[0]];
        let source = |zone: SiteZone, flipped: bool| {
            let [own, other] = [zone.arc_a, zone.arc_b];
            let share = if own[1] > own[0] { (zone.load.center - own[0]) / (own[1] - own[0]) } else { 0.5 };
            let places = [zone.load.center, other[0] + share * (other[1] - other[0])];
            let places = if flipped != *swapped { [places[1], places[0]] } else { places };
            // measured from the start of the line, over the seam
            let arcs = [0, 1].map(|k| along(places[k], starts[k], set.period(curves[k])));
            Source { arcs, force: zone.load.force, gap: zone.gap }
        };
        let sources = members
            .iter()
            .flat_map(|&(member, flipped)| pieces[member].iter().map(move |piece| source(*piece, flipped)));
        let length = |arc: [f64; 2], period: Option<f64>| {
            if arc[1] >= arc[0] { arc[1] - arc[0] } else { arc[1] - arc[0] + period.unwrap_or(0.0) }
        };
        let width = layer.resolution(curves[0], curves[1]);
        for (arcs, pressure, gap) in smoothed(sources.collect(), length(report.arc_a, set.period(curves[0])), width) {
            let at =
                |k: usize| set.period(curves[k]).map_or(arcs[k] + starts[k], |p| (arcs[k] + starts[k]).rem_euclid(p));
            let (rod_a, rod_b) = (report.rod_a, report.rod_b);
            samples.push(LineSample { site: index, rod_a, arc_a: at(0), rod_b, arc_b: at(1), pressure, gap });
        }
    }
    samples
}

/// Arc length of a point from the start of an interval that it lies in or near.
fn along(place: f64, start: f64, period: Option<f64>) -> f64 {
    let ahead = near(place, start, period) - start;
    match period {
        // a point well before the start lies near the end
        Some(period) if ahead < -0.01 * period => ahead + period,
        _ => ahead,
    }
}

/// Density of a unit force at `middle` that is spread over samples with a Gaussian of this width, both counted in
/// samples; `shares` are the lengths \[L\] that samples stand for, and Σ density × share is 1. Past the ends of a
/// closed curve samples are counted on.
pub(in crate::observe) fn spread(middle: f64, width: f64, shares: &[f64], closed: bool) -> Vec<(usize, f64)> {
    let count = shares.len() as isize;
    let reach = if closed { (REACH * width).min(0.5 * (shares.len() - 1) as f64) } else { REACH * width };
    let (low, high) = ((middle - reach).ceil() as isize, (middle + reach).floor() as isize);
    let range = if closed { low..high + 1 } else { low.max(0)..(high + 1).min(count) };
    let weight = |k: isize| (-0.5 * ((k as f64 - middle) / width).powi(2)).exp();
    let place = |k: isize| k.rem_euclid(count) as usize;
    let sum: f64 = range.clone().map(|k| weight(k) * shares[place(k)]).sum();
    range.map(|k| (place(k), weight(k) / sum)).collect()
}

/// Arc lengths from the starts, pressure and gap at evenly spaced samples of a line; ∫pressure is the sum of the
/// forces.
pub(super) fn smoothed(mut sources: Vec<Source>, length: f64, width: f64) -> Vec<([f64; 2], f64, f64)> {
    sources.sort_by(|x, y| x.arcs[0].total_cmp(&y.arcs[0]));
    if sources.is_empty() || !(length > 0.0 && width > 0.0) {
        return Vec::new();
    }
    let count = ((A_WIDTH * length / width).ceil() as usize).clamp(2, MOST_SAMPLES);
    let spacing = length / count as f64;
    let place = |k: usize| (k as f64 + 0.5) * spacing;
    let mut pressure = vec![0.0; count];
    let shares = vec![spacing; count];
    for source in &sources {
        let middle = (source.arcs[0] / spacing - 0.5).clamp(0.0, (count - 1) as f64);
        let spread = spread(middle, (width / spacing).max(1.0), &shares, false);
        spread.into_iter().for_each(|(k, density)| pressure[k] += source.force * density);
    }
    let nearest = |s: f64| {
        let after = sources.partition_point(|source| source.arcs[0] < s);
        let candidates = [after.saturating_sub(1), after.min(sources.len() - 1)];
        let [before, after] = candidates.map(|k| sources[k]);
        let gap = after.arcs[0] - before.arcs[0];
        let share = if gap > 0.0 { ((s - before.arcs[0]) / gap).clamp(0.0, 1.0) } else { 0.0 };
        let mix = |a: f64, b: f64| a + share * (b - a);
        (mix(before.arcs[1], after.arcs[1]), mix(before.gap, after.gap))
    };
    let sample = |k: usize| {
        let (arc_b, gap) = nearest(place(k));
        ([place(k), arc_b], pressure[k], gap)
    };
    (0..count).map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smoothing removes a sawtooth of the mesh and keeps the resultant, also at the ends.
    #[test]
    fn pressure_is_smoothed_and_its_resultant_kept() {
        let source = |k: usize| Source {
            arcs: [0.05 + 0.1 * k as f64, 7.0 - 0.1 * k as f64],
            force: if k.is_multiple_of(2) { 1.2 } else { 0.8 },
            gap: -1e-9,
        };
        let found = smoothed((0..100).map(source).collect(), 10.0, 0.5);
        let total: f64 = found.iter().map(|(_, pressure, _)| pressure * 10.0 / found.len() as f64).sum();
        assert!((total - 100.0).abs() < 1e-9, "{total}");
        let inner = &found[found.len() / 4..found.len() * 3 / 4];
        assert!(inner.iter().all(|(_, pressure, _)| (pressure - 10.0).abs() < 0.02), "{inner:?}");
        assert!(found.iter().all(|(arcs, ..)| (arcs[0] + arcs[1] - 7.05).abs() < 0.1));
        assert!(smoothed(Vec::new(), 1.0, 1.0).is_empty());
    }
}
