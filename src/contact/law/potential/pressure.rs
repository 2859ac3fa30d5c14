//! Pressures: the law, the offsets, and the former law after a change of law.

use crate::contact::law::{Law, Response};

/// Offsets c at both ends of a segment (the first, the slave), towards another one \[L\].
pub type Offsets<'a> = dyn Fn(usize, usize) -> [f64; 2] + Sync + 'a;

/// Law and offsets.
#[derive(Clone, Copy)]
pub(crate) struct Pressures<'a> {
    pub(crate) law: Law,
    pub(crate) offset: &'a Offsets<'a>,
    /// The former law and its offsets, right after a change of law. Its pressures are kept: the new law is linearised
    /// about the overlap at which it has the same pressure. The next Newton step moves the strands to that overlap.
    pub(crate) before: Option<(Law, &'a Offsets<'a>)>,
    /// No offset is larger \[L\]. A list of candidates reaches farther than contact, and offsets of each pair are
    /// expensive to look up.
    pub(crate) largest_offset: f64,
}

impl<'a> Pressures<'a> {
    /// Those of a law with offsets of any size.
    pub(crate) fn of(law: Law, offset: &'a Offsets<'a>) -> Self {
        Self { law, offset, before: None, largest_offset: f64::INFINITY }
    }

    /// Those of a plain penalty.
    pub(crate) fn without_offsets(law: Law) -> Self {
        Self { largest_offset: 0.0, ..Self::of(law, &|_, _| [0.0; 2]) }
    }

    /// Distance from the master's centreline at which the pressure ends, at both ends of the slave \[L\].
    pub(super) fn reach(&self, slave: usize, master: usize, contact_distance: f64) -> [f64; 2] {
        let offset = self.before.map_or(self.offset, |(_, offset)| offset);
        offset(slave, master).map(|c| contact_distance + c)
    }
}

/// The law along the slave of an ordered pair.
pub(super) struct PairLaw<'a> {
    pub(super) pressures: &'a Pressures<'a>,
    pub(super) contact_distance: f64,
    /// Share of the pair's contact that is integrated along the slave, between 0 and 1.
    pub(super) share: f64,
    /// Reference length of the slave \[L\].
    pub(super) length: f64,
    /// Distance at which the pressure ends, at both ends of the slave: contact distance + offset \[L\].
    pub(super) reach: [f64; 2],
    pub(super) offset: [f64; 2],
    /// Whether both segments are straight.
    pub(super) straight: bool,
    /// Present length of a straight slave \[L\].
    pub(super) span: f64,
}

impl PairLaw<'_> {
    /// The response at a slave parameter and distance \[L\], and the pressure of the geometric stiffness.
    pub(super) fn response(&self, u: f64, distance: f64) -> (Response, f64) {
        let between = |ends: [f64; 2]| ends[0] + (ends[1] - ends[0]) * u;
        let law = &self.pressures.law;
        let Some((before, _)) = self.pressures.before else {
            let response = law.response(between(self.reach) - distance, self.contact_distance);
            return (response, response.pressure);
        };
        let pressure = before.response(between(self.reach) - distance, self.contact_distance).pressure;
        let overlap = law.overlap(pressure, self.contact_distance);
        let there = law.response(overlap, self.contact_distance);
        let way = self.contact_distance + between(self.offset) - distance - overlap;
        let response = Response {
            energy: there.energy + (pressure + 0.5 * there.stiffness * way) * way,
            pressure: pressure + there.stiffness * way,
            stiffness: there.stiffness,
        };
        (response, pressure)
    }
}

/// Whether an infinite response is to be subtracted. It is skipped, because it is infinite already at the nearest
/// points on both sides.
pub(super) fn without_limit(law: &Response, weight: f64) -> bool {
    weight < 0.0 && law.energy == f64::INFINITY
}
