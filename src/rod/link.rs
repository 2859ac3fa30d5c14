//! Link of closed rods: measured when a rod is built, prescribed by rotating its frames. Twist of open rods.

use std::f64::consts::TAU;
use std::ops::Range;

use super::{MAX_TURN, Natural, Rod};
use crate::error::InputError;
use crate::math::link::link_numbers;
use crate::math::quaternion::spin;
use crate::math::{Quat, Vec3, parallel};

/// Most points per segment of the polygon for the link.
const MAX_POINTS: f64 = 8.0;

impl Rod {
    /// The same rod with the excess link `turns`: its frames are rotated about d3 by an angle that grows linearly along
    /// the rod. The centreline is unchanged.
    ///
    /// The excess link of a closed rod is the link of its centreline with its material line d1, Tw + Wr, seam included,
    /// beyond [`Rod::natural_link`]. A rod from [`Rod::new`] has its natural twist, so its excess link is the writhe of
    /// its shape; this function adds the missing twist. The result is exact to rounding for any number of nodes. The
    /// natural state is unchanged, also with [`Natural::AsShaped`](super::Natural).
    ///
    /// ```
    /// use supercoil::math::Vec3;
    /// use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
    /// let circle = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    /// let section = Section::isotropic(1.0, 1.5, 1e5, 1e5, 0.01);
    /// let ring = Rod::new("ring", &circle, RodMesh::closed(12, 3), section, Natural::Straight)?;
    /// let ring = ring.with_excess_link(1.5)?;
    /// assert!((ring.start_excess_link - 1.5).abs() < 1e-12);
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    ///
    /// # Errors
    /// An open rod; a number that is not finite; more than 0.4 turns of twist between neighbouring nodes.
    pub fn with_excess_link(mut self, turns: f64) -> Result<Self, InputError> {
        let field = format!("rods.{}.excess_link", self.name);
        InputError::check(&field, turns, true, "a finite number of turns")?;
        if !self.closed {
            let reason = "the rod is open: only a closed rod has an excess link".to_owned();
            return Err(InputError::Inconsistent { field, reason });
        }
        let nodes = self.num_nodes() as f64;
        let missing = turns - self.start_excess_link;
        if (missing / nodes).abs() > MAX_TURN {
            let reason = format!(
                "{turns} turns, of which {missing:.6} are twist, are more than {MAX_TURN} turns between neighbouring \
                 nodes ({nodes} nodes): use more elements"
            );
            return Err(InputError::Inconsistent { field, reason });
        }
        if missing != 0.0 {
            self.put_twist_in(missing);
            self.start_excess_link = turns;
        }
        Ok(self)
    }

    /// The same open rod with a uniform twist of `turns` beyond its natural twist: the frame at s = 0 stays, that at s
    /// = L is rotated about d3. The natural state is unchanged.
    ///
    /// # Errors
    /// A closed rod; a number that is not finite; more than 0.4 turns of twist between neighbouring nodes.
    pub fn with_twist(mut self, turns: f64) -> Result<Self, InputError> {
        let field = format!("rods.{}.twist", self.name);
        InputError::check(&field, turns, true, "a finite number of turns")?;
        if self.closed {
            let reason = "the rod is closed: give its excess_link".to_owned();
            return Err(InputError::Inconsistent { field, reason });
        }
        let segments = self.num_segments() as f64;
        if (turns / segments).abs() > MAX_TURN {
            let reason = format!(
                "{turns} turns are more than {MAX_TURN} turns between neighbouring nodes ({} nodes): use more elements",
                self.num_nodes()
            );
            return Err(InputError::Inconsistent { field, reason });
        }
        self.put_twist_in(turns);
        self.check().map(|()| self)
    }

    /// Rotates the frames about d3 by an angle linear in s: 0 at s = 0, `turns` at s = L.
    fn put_twist_in(&mut self, turns: f64) {
        let segments = self.num_segments() as f64;
        parallel::each(&mut self.frames, parallel::CHEAP, &|i, frame| {
            *frame = Quat::new_normalize((*frame * spin(TAU * turns * (i as f64 / segments))).into_inner());
        });
        self.twist_put_in += turns;
    }

    /// Link Lk₀ of the relaxed closed rod, turns: ∫K3 ds/2π for a natural twist K3; the link of the start shape if that
    /// is stress-free; else 0.
    pub fn natural_link(&self) -> f64 {
        match &self.natural {
            Natural::AsShaped => self.shape_link,
            natural => natural.mean_twist(self.length) * self.length / TAU,
        }
    }

    /// [`Rod::natural_link`] with the turns that the frames leave out: Lk₀ of the molecule that the rod models.
    pub(crate) fn relaxed_link(&self) -> f64 {
        self.natural_link() + self.turns_left_out
    }

    /// Closed rods: link Tw + Wr of the start state, turns. The frame at s = L is the frame at 0 turned by it about d3,
    /// so its fraction is the turn of the seam.
    pub(crate) fn start_link(&self) -> f64 {
        self.start_excess_link + self.natural_link()
    }

    /// Tw + Wr of the nodes' frames when the closing segment has the mean twist of the others; exactly 0 for plane
    /// curves whose frames do not turn.
    ///
    /// The frames determine the fraction of a turn: the seam takes what the closing segment lacks. The whole turns are
    /// the linking number of the ribbon, exact on a polygon along the rod's contact centreline.
    pub(super) fn link_of_nodes(&self) -> f64 {
        let last = self.num_nodes() - 1;
        let twists: f64 = (0..last).map(|i| self.segment_twist(i, i + 1)).sum();
        let mean = twists / last as f64;
        let seam = (mean - self.segment_twist(last, 0)) / TAU;
        let (points, d1) = self.ribbon(TAU * seam);
        let link = link_numbers(&points, &d1, seam).link;
        let excess = seam + (link - seam).round();
        if excess.abs() < 1e-13 * self.num_nodes() as f64 { 0.0 } else { excess }
    }

    /// Points along the contact centreline (cubic between neighbouring nodes with their d3) and d1 there, so dense that
    /// consecutive frames differ by less than ½ rad and chords stay within a fraction of the contact radius (at most 8
    /// a segment).
    fn ribbon(&self, seam: f64) -> (Vec<Vec3>, Vec<Vec3>) {
        let (nodes, spacing) = (self.num_nodes(), self.spacing());
        let closing = self.frames[0] * spin(seam);
        let next = |i: usize| if i + 1 == nodes { closing } else { self.frames[i + 1] };
        let turning = |i: usize| self.frames[i].angle_to(&next(i));
        let largest = |range: Range<usize>| range.map(turning).fold(0.0, f64::max);
        let most = parallel::map_ranges(nodes, parallel::CHEAP, &largest).into_iter().fold(0.0, f64::max);
        // sagitta of a chord: angle × length / 8, at most a quarter of the radius
        let sagitta = (most * spacing / (2.0 * self.section.contact_radius.max(spacing / MAX_POINTS))).sqrt();
        let count = (2.0 * most).max(sagitta).ceil().clamp(1.0, MAX_POINTS) as usize;
        let along = |i: usize| {
            let (a, b) = (self.positions[i], self.positions[(i + 1) % nodes]);
            let (before, after) = (self.frames[i], next(i));
            let after =
                if before.coords.dot(&after.coords) < 0.0 { Quat::new_unchecked(-after.into_inner()) } else { after };
            let (d3_a, d3_b) = (before * Vec3::z(), after * Vec3::z());
            (0..count).map(move |k| {
                let u = k as f64 / count as f64;
                let v = 1.0 - u;
                let point = a * (v * v * (1.0 + 2.0 * u))
                    + b * (u * u * (1.0 + 2.0 * v))
                    + (d3_a * v - d3_b * u) * (u * v * spacing);
                (point, before.nlerp(&after, u) * Vec3::x())
            })
        };
        let parts = parallel::map_ranges(nodes, parallel::CHEAP, &|range| range.flat_map(along).collect::<Vec<_>>());
        parts.into_iter().flatten().unzip()
    }

    /// Twist, rad in −π..π: the rotation about d3 from the frame of node a, transported to node b, to the frame of node
    /// b.
    ///
    /// Transport by double reflection (Wang, Jüttler, Zheng & Liu 2008), of fourth order in the spacing over a whole
    /// curve.
    fn segment_twist(&self, a: usize, b: usize) -> f64 {
        let reflect = |v: Vec3, n: &Vec3| v - n * (2.0 * n.dot(&v) / n.norm_squared());
        let chord = self.positions[b] - self.positions[a];
        let (d1, d3) = (reflect(self.frames[a] * Vec3::x(), &chord), reflect(self.frames[a] * Vec3::z(), &chord));
        let second = self.frames[b] * Vec3::z() - d3;
        let carried = if second.norm() < 1e-14 { d1 } else { reflect(d1, &second) };
        let [b1, b2] = [Vec3::x(), Vec3::y()].map(|axis| self.frames[b] * axis);
        let (cos, sin) = (b1.dot(&carried), -b2.dot(&carried));
        sin.atan2(cos)
    }
}
