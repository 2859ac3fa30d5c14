//! Contact as the solver keeps it: the curves that rods make, candidates, the law in force and its offsets.

use crate::contact::broad_phase::BroadPhase;
use crate::contact::curve::{Cubic, CurveInput, CurveSet};
use crate::contact::exclusion::Exclusion;
use crate::contact::law::Law;
use crate::contact::potential::ContactPair;
use crate::contact::screened::{Repulsion, Screened};
use crate::error::InputError;
use crate::math::Vec3;
use crate::math::signed_distance::Surface;
use crate::scene::{Electrostatics, Model, Obstacle};
use crate::solve::measures::NOTHING;
use crate::solve::problem::carrier::{Carrier, can_touch};
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::contact_tangents::MaterialTangents;
use crate::solve::problem::near_surfaces::NearSurfaces;
use crate::solve::problem::state::State;

/// Contact side of the engine; without curves if no rod takes part.
#[derive(Debug)]
pub(crate) struct ContactSide {
    /// Contact curves of all rods with a contact radius.
    pub(crate) set: CurveSet,
    /// Per segment: the two global nodes it joins.
    pub(crate) nodes: Vec<[usize; 2]>,
    /// Per curve: the rod.
    pub(crate) rods: Vec<usize>,
    /// Tangents of the contact centrelines at the nodes, see `contact_tangents`.
    pub(crate) tangents: MaterialTangents,
    /// Turning bounds.
    pub(crate) exclusion: Exclusion,
    /// Candidate pairs.
    pub(crate) broad_phase: BroadPhase,
    /// Obstacles.
    pub(crate) obstacles: Vec<Obstacle>,
    /// Their surfaces, where the state has them.
    pub(crate) surfaces: Vec<Surface>,
    /// The nodes that carry them.
    pub(crate) carriers: Vec<Option<Carrier>>,
    /// Which segments they may touch.
    pub(crate) near_surfaces: NearSurfaces,
    /// Screened repulsion of the strands, if it is requested.
    pub(crate) repulsion: Option<Repulsion>,
    /// Generations of the sides that this one has replaced.
    generations_before: u64,
    /// Pressure against overlap.
    pub(crate) law: Law,
    /// Offsets c \[L\] (zero for a plain penalty).
    pub(crate) offsets: ContactField,
    /// Law and offsets before they were last changed, until a step has been taken under the new ones: see
    /// [`Pressures`](crate::contact::potential::Pressures).
    pub(crate) before: Option<(Law, ContactField)>,
    /// Smallest contact radius \[L\].
    pub(crate) min_radius: f64,
    /// The last update of geometry, turning bounds and candidates went through. When it did not (a curve too coarse for
    /// contact), there is nothing to be said about gaps.
    pub(crate) is_current: bool,
}

/// Pairs i < j of segments of rods that take part in contact, between which joints leave it out. Segments are numbered
/// rod by rod, in the order of `touching`.
fn at_joints(model: &Model, touching: &[usize]) -> Vec<[u32; 2]> {
    let before = |rod: usize| touching.iter().take_while(move |other| **other != rod);
    let first = |rod: usize| before(rod).map(|&rod| model.rods[rod].num_segments()).sum::<usize>();
    let mut pairs = Vec::new();
    for piece in model.joint_surroundings() {
        let [a, b] = piece.map(|piece| {
            let first = first(piece.rod());
            piece.segments(&model.rods[piece.rod()]).map(|k| (first + k) as u32).collect::<Vec<_>>()
        });
        a.iter().for_each(|&i| pairs.extend(b.iter().map(|&j| [i.min(j), i.max(j)])));
    }
    pairs
}

impl ContactSide {
    /// No contact: no curves, so no places for offsets.
    pub(crate) fn none() -> Self {
        Self {
            set: CurveSet::default(),
            nodes: Vec::new(),
            rods: Vec::new(),
            tangents: MaterialTangents::directors(0),
            exclusion: Exclusion::new(),
            broad_phase: BroadPhase::new(),
            offsets: ContactField::default(),
            obstacles: Vec::new(),
            surfaces: Vec::new(),
            carriers: Vec::new(),
            near_surfaces: NearSurfaces::default(),
            repulsion: None,
            generations_before: 0,
            law: Law::Linear { stiffness: 0.0 },
            before: None,
            min_radius: f64::INFINITY,
            is_current: true,
        }
    }

    /// Whether no rod takes part in contact.
    pub(crate) fn is_empty(&self) -> bool {
        self.set.is_empty()
    }

    /// Curves of the rods that have a contact radius, under a penalty of the given dimensionless stiffness κ ε⁴/B, ε
    /// the smallest radius, B `bending`, with the model's obstacles and charges; [`ContactSide::none`] if no rod has
    /// one.
    ///
    /// # Errors
    /// Curves that [`CurveSet::new`] refuses.
    pub(crate) fn new(
        model: &Model,
        first_node: &[usize],
        (state, tangents): (&State, MaterialTangents),
        (dimensionless, bending): (f64, f64),
    ) -> Result<Self, InputError> {
        let touching: Vec<usize> =
            (0..model.rods.len()).filter(|&rod| model.rods[rod].section.contact_radius > 0.0).collect();
        if touching.is_empty() {
            return Ok(Self::none());
        }
        let (set, nodes) = curves(model, first_node, (state, &tangents), &touching)?;
        let min_radius = (0..set.len()).map(|segment| set.radius_of(segment)).fold(f64::INFINITY, f64::min);
        let mut exclusion = Exclusion::new();
        exclusion.leave_out(at_joints(model, &touching));
        let carriers = Carrier::all(model, first_node, &touching);
        let screened = |Electrostatics { strength, debye_length }| Screened { strength, debye_length };
        let repulsion = model.electrostatics.map(|charges| {
            let least = set.curves.iter().map(|curve| curve.radius).fold(f64::INFINITY, f64::min);
            Repulsion::new(screened(charges), &set, charges.piece(least))
        });
        let num_surfaces = model.obstacles.len();
        let mut side = Self {
            set,
            nodes,
            rods: touching,
            tangents,
            exclusion,
            broad_phase: BroadPhase::new(),
            offsets: ContactField::uniform(state.positions.len(), num_surfaces, 0.0),
            obstacles: model.obstacles.clone(),
            surfaces: Vec::new(),
            carriers,
            near_surfaces: NearSurfaces::default(),
            repulsion,
            generations_before: 0,
            law: Law::Linear { stiffness: stiffness(dimensionless, bending, min_radius) },
            before: None,
            min_radius,
            is_current: false,
        };
        side.place_surfaces(state);
        Ok(side)
    }

    /// Moves the surfaces of obstacles to where they are in a state.
    pub(crate) fn place_surfaces(&mut self, state: &State) {
        let placed: Vec<Surface> = (0..self.obstacles.len()).map(|index| self.surface_in(state, index)).collect();
        self.is_current &= placed == self.surfaces;
        self.surfaces = placed;
    }

    /// Takes the place of another one that rods with other numbers had: its generations are not counted again.
    pub(crate) fn replaces(&mut self, other: &Self) {
        self.generations_before = other.generation();
    }

    /// Whether strands may be pushed at all.
    pub(crate) fn may_push(&self) -> bool {
        self.repulsion.is_some() || self.is_near()
    }

    /// Whether strands are near each other or an obstacle.
    pub(crate) fn is_near(&self) -> bool {
        !self.broad_phase.pairs().is_empty() || !self.near_surfaces.pairs().is_empty()
    }

    /// Gap up to which pairs are candidates, and how much farther they are looked for \[L\].
    pub(crate) fn candidate_range(&self) -> (f64, f64) {
        // in steps, so that a slowly growing offset does not rebuild the list every time
        let range = self.min_radius * (2.0 * self.largest_offset() / self.min_radius).max(0.02).log2().ceil().exp2();
        (range, 0.5 * self.min_radius)
    }

    /// Largest offset, those of the law before included \[L\]; 0 if all are negative.
    pub(crate) fn largest_offset(&self) -> f64 {
        let earlier = self.before.iter().flat_map(|(_, offsets)| &offsets.values);
        earlier.copied().fold(self.largest_offset_in_force(), f64::max)
    }

    /// Largest offset of the law in force \[L\]; 0 if none is positive.
    pub(crate) fn largest_offset_in_force(&self) -> f64 {
        self.offsets.values.iter().copied().fold(0.0, f64::max)
    }

    /// Offsets of none at all.
    pub(crate) fn no_offsets(&self) -> ContactField {
        let [num_nodes, num_surfaces] = self.size();
        ContactField::uniform(num_nodes, num_surfaces, 0.0)
    }

    /// Numbers of nodes and of obstacles.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.offsets.num_nodes(), self.surfaces.len()]
    }

    /// Changes with the pairs of segments that the tangent couples.
    pub(crate) fn generation(&self) -> u64 {
        self.generations_before
            + self.broad_phase.generation()
            + self.near_surfaces.generation()
            + self.repulsion.as_ref().map_or(0, Repulsion::generation)
    }

    /// Pairs of segments that the tangent couples; some may be there twice.
    pub(crate) fn coupled(&self) -> impl Iterator<Item = &[u32; 2]> {
        let repelled = self.repulsion.iter().flat_map(|repulsion| repulsion.pairs());
        self.broad_phase.pairs().iter().chain(repelled)
    }

    /// Nodes that the tangent couples because a body that one of them carries is near a segment of the others.
    pub(crate) fn coupled_by_bodies(&self) -> impl Iterator<Item = (usize, usize)> {
        self.near_surfaces.pairs().iter().flat_map(|&[segment, surface]| {
            let [a, b] = self.nodes[segment as usize];
            self.carriers[surface as usize].iter().flat_map(move |carrier| [(a, carrier.node), (b, carrier.node)])
        })
    }

    /// Renews the list of segments near surfaces.
    pub(crate) fn update_near_surfaces(&mut self, range: (f64, f64)) {
        let Self { set, surfaces, carriers, .. } = self;
        self.near_surfaces
            .update((set, surfaces), range, |segment, surface| can_touch(carriers, surfaces, [segment, surface]));
    }

    /// Offsets at both ends of a segment towards another one \[L\].
    pub(crate) fn offset(&self, slave: usize, master: usize) -> [f64; 2] {
        self.at_ends(&self.offsets, slave, master)
    }

    /// Numbers at both ends of a segment for its contact with another one.
    pub(crate) fn at_ends(&self, numbers: &ContactField, slave: usize, master: usize) -> [f64; 2] {
        self.nodes[slave].map(|node| numbers.at(&self.set, node, master))
    }

    /// Offsets at both ends of a segment towards an obstacle \[L\].
    pub(crate) fn offset_to_surface(&self, segment: usize, surface: usize) -> [f64; 2] {
        self.at_ends_for_surface(&self.offsets, segment, surface)
    }

    /// Numbers at both ends of a segment for its contact with an obstacle.
    pub(crate) fn at_ends_for_surface(&self, numbers: &ContactField, segment: usize, surface: usize) -> [f64; 2] {
        self.nodes[segment].map(|node| numbers.values[numbers.index_of_surface(node, surface)])
    }

    /// Replaces law and offsets; the pressures of the present state are carried over to the first linearisation. Where
    /// nothing takes part in contact no law is in force.
    pub(crate) fn change_law(&mut self, law: Law, offsets: ContactField) {
        if self.is_empty() {
            return;
        }
        let old = (std::mem::replace(&mut self.law, law), std::mem::replace(&mut self.offsets, offsets));
        // under a law that no step was taken under there are no pressures
        self.before.get_or_insert(old);
    }

    /// Visits the nodes of `segment` and of its followers (or predecessors) up to `distance` \[L\] further along the
    /// curve. A remainder of the distance by rounding reaches no segment: windows are often just an element long, and
    /// would be one segment longer in some units of length than in others.
    pub(crate) fn spread(&self, segment: usize, mut distance: f64, forward: bool, mut visit: impl FnMut(usize)) {
        let mut here = segment;
        loop {
            self.nodes[here].iter().for_each(|&node| visit(node));
            match if forward { self.set.next(here) } else { self.set.prev(here) } {
                Some(next) if distance > NOTHING * self.set.lengths[next] && next != segment => here = next,
                _ => break,
            }
            distance -= self.set.lengths[here];
        }
    }

    /// The contact centreline of a segment in a state.
    pub(in crate::solve) fn cubic(&self, state: &State, segment: usize) -> Cubic {
        self.tangents.cubic(state, self.nodes[segment]).0
    }

    /// Global nodes at the ends of two segments.
    pub(crate) fn ends_of(&self, pair: [u32; 2]) -> [usize; 4] {
        let [[a, b], [c, d]] = pair.map(|segment| self.nodes[segment as usize]);
        [a, b, c, d]
    }

    /// Global nodes: slave a, b, master a, b.
    pub(crate) fn nodes_of(&self, pair: &ContactPair) -> [usize; 4] {
        let (s, m) = (self.nodes[pair.slave], self.nodes[pair.master]);
        [s[0], s[1], m[0], m[1]]
    }
}

/// Contact curves of some rods, and the two global nodes that each segment joins.
fn curves(
    model: &Model,
    first_node: &[usize],
    (state, tangents): (&State, &MaterialTangents),
    touching: &[usize],
) -> Result<(CurveSet, Vec<[usize; 2]>), InputError> {
    let segments = |&rod: &usize| (0..model.rods[rod].num_segments()).map(move |k| (rod, k));
    let ends = |(rod, k): (usize, usize)| {
        let (first, count) = (first_node[rod], model.rods[rod].num_nodes());
        [first + k, first + (k + 1) % count]
    };
    let input = |index: &usize| {
        let (rod, length) = (&model.rods[*index], model.rods[*index].spacing());
        CurveInput {
            segments: segments(index).map(|segment| tangents.cubic(state, ends(segment)).0).collect(),
            lengths: vec![length; rod.num_segments()],
            closed: rod.closed,
            radius: rod.section.contact_radius,
        }
    };
    let mut set = CurveSet::new(touching.iter().map(input).collect())?;
    if touching.iter().any(|&rod| model.rods[rod].contact_radii.is_some()) {
        let radius = |(rod, k): (usize, usize)| model.rods[rod].contact_radius_of(k);
        set.set_radii(&touching.iter().flat_map(segments).map(radius).collect::<Vec<f64>>())?;
    }
    set.remainders = vec![[Vec3::zeros(); 4]; set.len()];
    set.bending = touching.iter().map(|&rod| model.rods[rod].section.smaller_bending()).collect();
    Ok((set, touching.iter().flat_map(segments).map(ends).collect()))
}

/// κ \[F/L²\] of a dimensionless stiffness κ ε⁴/B.
pub(crate) fn stiffness(dimensionless: f64, bending: f64, radius: f64) -> f64 {
    dimensionless * bending / radius.powi(4)
}
