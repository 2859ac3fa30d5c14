//! Merges the fragments of a line into one site.
//!
//! Under a law with a contact layer of half the node spacing the pressure may vanish between nodes, and a line breaks
//! up into one fragment per node. Contacts of two strands that are closer to each other on both than such a mesh
//! resolves are one site.
//!
//! Strands that press each other less than their elements ripple touch once an element: wires of steel laid as a cable
//! have ripples of 1e-9 m, and their layer is pressed in by 1e-11 m. Such fragments lie up to an element apart. Two
//! points may, too, but not three in a row: a row is one site.
//!
//! A strong point force bends its element as the element cannot, and the strands touch once more beside it. Such a
//! ripple is part of the stronger contact.

use crate::contact::arc::{self, ascending};
use crate::contact::curve::CurveSet;

use super::{Layer, SiteZone};

/// Largest distance of two fragments of one contact on either strand, in layers (B/κ)^¼: the node spacing if the mesh
/// sets the stiffness of the law.
const NEAR: f64 = 2.0;

/// Largest ratio of the mean pressures of two fragments of one line. On a mesh there are fragments between the line of
/// a twisted ring and the point at its end, where exact strands do not touch; their pressure is a tenth of that of the
/// point.
const ALIKE: f64 = 4.0;

/// Indices of zones, true for those that see the contact from the other strand than the first.
type Members = Vec<(usize, bool)>;

/// A contact seen from one of its strands.
struct ContactView {
    group: usize,
    flipped: bool,
    curves: [usize; 2],
    /// Ascending, on both strands.
    arcs: [[f64; 2]; 2],
    /// \[F\].
    force: f64,
    /// Mean length on both strands \[L\].
    length: f64,
}

/// Whether two contacts have similar mean pressures, over their own lengths or over this one \[L\] where they are
/// shorter: pressure that gathers within a length is known over that length only.
fn is_alike(x: &ContactView, y: &ContactView, length: f64) -> bool {
    [0.0, length].into_iter().any(|least| {
        let [x, y] = [x, y].map(|view| view.force / view.length.max(least).max(f64::MIN_POSITIVE));
        x.max(y) <= ALIKE * x.min(y)
    })
}

/// Whether the weaker of two contacts is a ripple beside the stronger one: shorter than half an element, and far
/// weaker. A point force within an element bends it in a way that the element does not have; it touches once more
/// beside the point.
fn is_ripple(x: &ContactView, y: &ContactView, element: f64) -> bool {
    let (weak, strong) = if x.force < y.force { (x, y) } else { (y, x) };
    weak.length < 0.5 * element && ALIKE * weak.force < strong.force
}

/// Fewest contacts, each within an element of the next, that are fragments of a line.
const ROW: usize = 3;

/// Groups of zones with the fragments of each line merged.
pub(super) fn joined(set: &CurveSet, zones: &[SiteZone], groups: Vec<Members>, layer: &Layer) -> Vec<Members> {
    let near = |[a, b]: [usize; 2]| [NEAR * layer.width(a, b); 2];
    let within_an_element = |curves: [usize; 2]| {
        let near = near(curves);
        [0, 1].map(|k| near[k].max(layer.elements[curves[k]]))
    };
    let next = neighbours(set, zones, &groups, near, is_alike);
    let groups = merged(&groups, &next, 1);
    let next = neighbours(set, zones, &groups, within_an_element, is_alike);
    let groups = merged(&groups, &next, ROW);
    let next = neighbours(set, zones, &groups, within_an_element, is_ripple);
    merged(&groups, &with_the_strongest(zones, &groups, &next), 1)
}

/// Of the neighbours of each group only the strongest, if it is stronger: a ripple between a point and a line does not
/// join them.
fn with_the_strongest(zones: &[SiteZone], groups: &[Members], next: &[Members]) -> Vec<Members> {
    let force = |group: usize| groups[group].iter().map(|&(zone, _)| zones[zone].load.force).sum::<f64>();
    let mut chosen: Vec<Members> = vec![Vec::new(); groups.len()];
    for (group, others) in next.iter().enumerate() {
        let strongest = others.iter().max_by(|x, y| force(x.0).total_cmp(&force(y.0)));
        if let Some(&(other, turned)) = strongest.filter(|other| force(other.0) > force(group)) {
            chosen[group].push((other, turned));
            chosen[other].push((group, turned));
        }
    }
    chosen
}

/// Groups merged where at least `least` of them hang together.
fn merged(groups: &[Members], next: &[Members], least: usize) -> Vec<Members> {
    let mut used = vec![false; groups.len()];
    let mut all = Vec::new();
    for start in 0..groups.len() {
        let row = row_of(start, next, &mut used);
        if row.is_empty() {
            continue;
        }
        let members = |&(group, turned): &(usize, bool)| {
            groups[group].iter().map(move |&(zone, flipped)| (zone, flipped != turned)).collect::<Vec<_>>()
        };
        if row.len() >= least {
            all.push(row.iter().flat_map(members).collect());
        } else {
            all.extend(row.iter().map(members));
        }
    }
    all
}

/// For each group those that are one with it, no further apart than `reach` of their curves \[L\], and whether they see
/// the two strands the other way round.
fn neighbours(
    set: &CurveSet,
    zones: &[SiteZone],
    groups: &[Members],
    reach: impl Fn([usize; 2]) -> [f64; 2],
    is_one: fn(&ContactView, &ContactView, f64) -> bool,
) -> Vec<Members> {
    let mut sides: Vec<ContactView> =
        groups.iter().enumerate().flat_map(|(k, members)| both(set, zones, k, members)).collect();
    sides.sort_by(|x, y| x.curves.cmp(&y.curves).then(x.arcs[0][0].total_cmp(&y.arcs[0][0])));
    let mut next: Vec<Members> = vec![Vec::new(); groups.len()];
    for class in sides.chunk_by(|x, y| x.curves == y.curves) {
        let curves = class[0].curves;
        let reach = reach(curves);
        let is_near = |x: &ContactView, y: &ContactView, k: usize| {
            arc::apart(x.arcs[k], y.arcs[k], set.period(curves[k])) <= reach[k]
        };
        for (i, side) in class.iter().enumerate() {
            let after = (1..class.len()).map(|offset| &class[(i + offset) % class.len()]);
            for other in after
                .take_while(|other| is_near(side, other, 0))
                .filter(|other| is_near(side, other, 1) && is_one(side, other, reach[0].max(reach[1])))
            {
                if side.group != other.group {
                    let turned = side.flipped != other.flipped;
                    next[side.group].push((other.group, turned));
                    next[other.group].push((side.group, turned));
                }
            }
        }
    }
    next
}

/// The groups that hang together with a first one, each with its sense; none if the first one is used already.
fn row_of(first: usize, next: &[Members], used: &mut [bool]) -> Members {
    if std::mem::replace(&mut used[first], true) {
        return Vec::new();
    }
    let (mut found, mut visited) = (vec![(first, false)], 0);
    while let Some(&(group, turned)) = found.get(visited) {
        for &(other, turn) in &next[group] {
            if !std::mem::replace(&mut used[other], true) {
                found.push((other, turned != turn));
            }
        }
        visited += 1;
    }
    found
}

/// A group from its first strand and, where both are of one curve, from its second.
fn both(set: &CurveSet, zones: &[SiteZone], group: usize, members: &Members) -> Vec<ContactView> {
    let first = &zones[members[0].0];
    let curves = [first.curve_a, first.curve_b];
    let hull = |k: usize| {
        let arcs = members.iter().map(|&(zone, flipped)| {
            let zone = &zones[zone];
            ascending(if (k == 0) != flipped { zone.arc_a } else { zone.arc_b })
        });
        arcs.reduce(|all, arc| arc::joined(all, arc, set.period(curves[k]))).unwrap_or_default()
    };
    let arcs = [hull(0), hull(1)];
    let force: f64 = members.iter().map(|&(zone, _)| zones[zone].load.force).sum();
    let length = 0.5 * (arcs[0][1] - arcs[0][0] + arcs[1][1] - arcs[1][0]);
    let mut sides = vec![ContactView { group, flipped: false, curves, arcs, force, length }];
    if curves[0] == curves[1] {
        sides.push(ContactView { group, flipped: true, curves, arcs: [arcs[1], arcs[0]], force, length });
    }
    sides
}
