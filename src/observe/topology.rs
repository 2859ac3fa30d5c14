//! Links and knots, compared with what was prescribed and with the shapes as given.
//!
//! Strands that contact keeps apart cannot change the link of a closed rod, its knot, or the linking number of two:
//! that is a check. Without contact they may, and a knot may slip off an open rod: that is noted.

use super::braids;
use super::knots;
use super::report::{Knot, Linking, RodLink};
use crate::certificate::Check;
use crate::rod::RodNumber;
use crate::scene::Ramp;
use crate::solve::{Given, GivenTopology, Progress};

/// Largest deviation of a link from what is prescribed, turns, because it is measured on polygons, where it is exact
/// but for rounding, and changes by whole turns.
const TOL_TURNS: f64 = 1e-3;

/// Checks of what contact keeps, and notes of what has changed where nothing was in the way.
pub(super) fn kept(
    progress: &Progress,
    links: &[RodLink],
    linking: &[Linking],
    knots: &[Knot],
) -> (Vec<Check>, Vec<String>) {
    let (mut off, mut notes) = ((0.0, String::new()), Vec::new());
    for change in changes(progress, links, linking, knots) {
        if change.is_barred && change.size > off.0 {
            off = (change.size, if change.size > TOL_TURNS { change.text.clone() } else { String::new() });
        }
        if !change.is_barred && change.size > TOL_TURNS {
            notes.push(change.text);
        }
    }
    if let Some(given) = progress.given {
        notes.extend(braids::notes(progress, given, &start(given).turns));
    }
    let barred = links.iter().any(|of| touches(progress, of.rod)) || !linking.is_empty() || !knots.is_empty();
    let check = Check::new("topology", off.0, TOL_TURNS, if off.1.is_empty() { "turns".to_owned() } else { off.1 });
    (barred.then_some(check).into_iter().collect(), notes)
}

/// A deviation from what was prescribed or given.
struct TopologyChange {
    /// Turns; 1 for another knot.
    size: f64,
    /// Whether contact is in its way.
    is_barred: bool,
    text: String,
}

/// Whether a rod takes part in contact.
fn touches(progress: &Progress, rod: usize) -> bool {
    let model = progress.engine.model();
    model.contact.law.is_on() && model.rods[rod].section.contact_radius > 0.0
}

fn changes(progress: &Progress, links: &[RodLink], linking: &[Linking], knots: &[Knot]) -> Vec<TopologyChange> {
    let rods = &progress.engine.model().rods;
    let through = "strands have passed through each other";
    let mut all = Vec::new();
    for of in links {
        let due = progress.given.and_then(|given| excess_link_due(given, of.rod, progress.stage, progress.fraction));
        let due = due.unwrap_or(of.excess_link) + rods[of.rod].relaxed_link();
        let off = of.link - due;
        let than = if off < 0.0 { "less" } else { "more" };
        let text = format!(
            "the link of rod \"{}\" is {:.4} turns {than} than prescribed: {through}",
            rods[of.rod].name,
            off.abs()
        );
        let is_barred = touches(progress, of.rod);
        all.push(TopologyChange { size: off.abs(), is_barred, text });
    }
    let Some(given) = progress.given else { return all };
    let start = start(given);
    for of in linking {
        let pair = [of.rod_a, of.rod_b];
        let before = start.linking.iter().find(|(rods, _)| *rods == pair).map_or(of.link, |(_, link)| *link);
        let [a, b] = pair.map(|rod| &rods[rod].name);
        let text =
            format!("the linking number of \"{a}\" and \"{b}\" is {}, not {before} as given: {through}", of.link);
        let is_barred = pair.iter().all(|&rod| touches(progress, rod));
        all.push(TopologyChange { size: (of.link - before).abs(), is_barred, text });
    }
    for of in knots {
        let Some((_, determinant, at_third, name)) = start.knots.iter().find(|(rod, ..)| *rod == of.rod) else {
            continue;
        };
        let same = mirrors_alike(name) == mirrors_alike(&of.name)
            && *determinant == of.determinant
            && *at_third == of.at_third;
        let (rod, open) = (&rods[of.rod].name, !rods[of.rod].closed);
        let how = if open { "a strand has passed over an end" } else { through };
        let text = format!("the knot of rod \"{rod}\" is {}, not {name} as given: {how}", of.name);
        let is_barred = !open && touches(progress, of.rod);
        all.push(TopologyChange { size: f64::from(u8::from(!same)), is_barred, text });
    }
    all
}

/// The name without the stars of mirror images: of a projection too wide for the Jones polynomial they are not known.
fn mirrors_alike(knot: &str) -> String {
    knot.replace('*', "")
}

/// Knots and links of the shapes as given, measured once.
fn start(given: &Given) -> &GivenTopology {
    given.topology.get_or_init(|| GivenTopology {
        knots: knots::given_knots(&given.model),
        linking: knots::given_linking(&given.model),
        turns: braids::given_turns(&given.model),
    })
}

/// Excess link that stages prescribe; `None` where they change the natural twist or the length of the rod, with which
/// the excess link changes.
fn excess_link_due(given: &Given, rod: usize, stage: usize, fraction: f64) -> Option<f64> {
    let mut due = given.model.rods[rod].start_excess_link;
    for (k, of) in given.stages.iter().enumerate().take(stage + 1) {
        let part = if k < stage { 1.0 } else { fraction };
        for ramp in &of.ramps {
            match ramp {
                Ramp::ExcessLink { rod: at, to } if *at == rod => due += (to - due) * part,
                Ramp::Number { rod: at, which: RodNumber::Twist | RodNumber::Length, .. } if *at == rod => return None,
                _ => {}
            }
        }
    }
    Some(due)
}
