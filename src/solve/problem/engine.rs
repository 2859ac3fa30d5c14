//! The assembled problem: elements, contact, supports and state. Built once from a model.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;

use crate::contact::law::Law;
use crate::error::InputError;
use crate::math::parallel::{Pool, in_pool};
use crate::math::quaternion::{spin, to_array};
use crate::math::shape_functions::ShapeTable;
use crate::math::{Quat, Vec3};
use crate::rod::element::{ElementNodes, ElementProperties, Material, RodPlane, Strain, raw_strains, stiffness};
use crate::rod::{Along, Natural, NaturalStrains, Rod};
use crate::scene::{ContactLaw, Joint, JointKind, Model, NodeRef, Obstacle};
use crate::solve::measures::{LAST_PLACES, NOTHING};
use crate::solve::problem::contact_side::{self, ContactSide};
use crate::solve::problem::contact_tangents::MaterialTangents;
use crate::solve::problem::follower::Sharing;
use crate::solve::problem::state::State;
use crate::solve::problem::swivel::{Bases, Swivel};

/// Largest rounding of the start, over the node spacing, because meshes do not tell shapes as near apart.
const MAX_RESOLUTION: f64 = 1e-3;

/// One element: where its nodes are and which rod it belongs to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Element {
    /// Rod index.
    pub(crate) rod: usize,
    /// Global node indices; order + 1 of them are used.
    pub(crate) nodes: [usize; 4],
    /// The last node is the first node of the rod seen through the seam.
    pub(crate) closes: bool,
}

/// The problem in the form the solver works on.
#[derive(Debug)]
pub struct Engine {
    pub(crate) model: Model,
    /// First global node of each rod; one more entry than rods.
    pub(crate) first_node: Vec<usize>,
    pub(crate) elements: Vec<Element>,
    pub(crate) tables: [ShapeTable; 3],
    /// Per rod: the material matrix, of all points or per point.
    pub(crate) material: Vec<Stiffnesses>,
    /// Per rod: reference strain common to all points, or per element of rods that are stress-free as shaped.
    pub(crate) reference: Vec<Reference>,
    /// Per rod: the plane in which its elements are computed, if any.
    pub(crate) planes: Vec<Option<RodPlane>>,
    /// Per node: components of position and rotation that no support holds. Where one holds rotation about one axis
    /// ([`Swivel`]) these are all.
    pub(crate) free: Vec<[bool; 6]>,
    /// Per node: unknowns; at swivels in the basis of these.
    pub(crate) equations: Vec<[bool; 6]>,
    /// Supports that hold rotation about one axis.
    pub(crate) swivels: Vec<Swivel>,
    /// What joined nodes share. Unknowns of another node are not free, carry no mass, and their share of the gradient
    /// is the owner's.
    pub(crate) sharing: Sharing,
    pub(in crate::solve::problem) state: State,
    pub(crate) contact: ContactSide,
    /// The contact law as it was requested: by the mesh, its stiffness follows the numbers of the rods.
    pub(crate) law_asked: ContactLaw,
    pub(crate) scales: Scales,
    /// Masses that shifts multiply, six per node: (B/L⁴)·h for positions, times the square of a length for rotations.
    pub(crate) metric: Vec<f64>,
    pub(crate) pool: Option<Pool>,
}

/// Reference strains of a rod: stored per element only where the rod is curved by nature in its own way.
#[derive(Debug)]
pub(crate) enum Reference {
    Uniform(Strain),
    PerElement(usize, Vec<[Strain; 3]>),
}

impl Reference {
    /// Strains of six numbers held.
    pub(crate) fn num_stored(&self) -> usize {
        match self {
            Self::Uniform(_) => 0,
            Self::PerElement(_, list) => 3 * list.len(),
        }
    }

    /// Of a rod that is evenly curved by nature.
    pub(crate) fn curved([k1, k2, k3]: [f64; 3]) -> Self {
        Self::Uniform([0.0, 0.0, 1.0, k1, k2, k3])
    }

    /// Of the same elements, by natural strains that vary along their rod.
    pub(crate) fn varying(&self, rod: &Rod, along: &Along<NaturalStrains>) -> Self {
        let first = if let Self::PerElement(first, _) = self { *first } else { 0 };
        Self::PerElement(first, (0..rod.num_elements).map(|e| rod.natural_on_element(along, e)).collect())
    }

    pub(crate) fn of(&self, element: usize) -> [Strain; 3] {
        match self {
            Self::Uniform(six) => [*six; 3],
            Self::PerElement(first, list) => list[element - first],
        }
    }

    fn all(&self) -> &[Strain] {
        match self {
            Self::Uniform(six) => std::slice::from_ref(six),
            Self::PerElement(_, list) => list.as_flattened(),
        }
    }

    /// Whether all of the rod is curved and twisted alike.
    pub(in crate::solve::problem) fn is_uniform(&self) -> bool {
        are_alike(self.all().iter().map(|six| &six[..]))
    }

    /// Whether the rod, of elements of this length \[L\], is straight by nature: neither curved nor sheared.
    pub(in crate::solve::problem) fn is_straight(&self, length: f64) -> bool {
        let bends = |six: &Strain| six[0].abs().max(six[1].abs()).max(length * six[3].abs().max(six[4].abs()));
        self.all().iter().all(|six| bends(six) <= NOTHING)
    }
}

/// Whether lists of numbers are the same but for rounding.
fn are_alike<'a>(mut lists: impl Iterator<Item = &'a [f64]>) -> bool {
    let Some(first) = lists.next() else { return true };
    let size = first.iter().fold(0.0f64, |size, x| size.max(x.abs()));
    lists.all(|list| list.iter().zip(first).all(|(a, b)| (a - b).abs() <= NOTHING * size))
}

/// Material matrices of a rod: a diagonal unless it has a full stiffness.
#[derive(Debug)]
pub(crate) enum Stiffnesses {
    Diagonal(Strain),
    Constant(Box<[[Strain; 6]; 3]>),
    PerElement(usize, Vec<[[Strain; 6]; 3]>),
}

impl Stiffnesses {
    /// Of a rod whose first element is `first`.
    fn new(rod: &Rod, first: usize) -> Self {
        let Some(along) = &rod.stiffness else { return Self::Diagonal(stiffness(&rod.section)) };
        let of = |e: usize| rod.on_element(along, e).map(|c| ((c + c.transpose()) * 0.5).into());
        match along.is_constant() {
            true => Self::Constant(Box::new(of(0))),
            false => Self::PerElement(first, (0..rod.num_elements).map(of).collect()),
        }
    }

    fn full(&self) -> &[[Strain; 6]] {
        match self {
            Self::Diagonal(_) => &[],
            Self::Constant(points) => &points[..],
            Self::PerElement(_, list) => list.as_flattened(),
        }
    }

    /// Whether it is the same all along the rod.
    pub(in crate::solve::problem) fn is_uniform(&self) -> bool {
        are_alike(self.full().iter().map(|matrix| matrix.as_flattened()))
    }

    /// Whether it is the same about the tangent in all directions, without a coupling of bending or shear with other
    /// strains.
    pub(in crate::solve::problem) fn is_isotropic(&self) -> bool {
        let is_same = |a: f64, b: f64| (a - b).abs() <= NOTHING * a.abs();
        let of_matrix = |c: &[Strain; 6]| {
            let is_coupled = |i: usize, j: usize| c[i][j].powi(2) > NOTHING * NOTHING * c[i][i] * c[j][j];
            let across = [0, 1, 3, 4];
            let coupled = across.iter().any(|&i| (0..6).any(|j| j != i && is_coupled(i, j)));
            !coupled && is_same(c[0][0], c[1][1]) && is_same(c[3][3], c[4][4])
        };
        match self {
            Self::Diagonal(six) => is_same(six[0], six[1]) && is_same(six[3], six[4]),
            _ => self.full().iter().all(of_matrix),
        }
    }

    pub(crate) fn of(&self, element: usize) -> Material<'_> {
        match self {
            Self::Diagonal(six) => Material::Diagonal(six),
            Self::Constant(points) => Material::Full(points),
            Self::PerElement(first, list) => Material::Full(&list[element - first]),
        }
    }
}

/// Scales that make tolerances and shifts dimensionless.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scales {
    /// Largest rod length \[L\].
    pub(crate) length: f64,
    /// Smallest bending stiffness \[F·L²\].
    pub(crate) bending: f64,
    /// Length that turns rotations into displacements in norms: a node distance \[L\].
    pub(crate) lever: f64,
    /// Force that is nothing: below the rounding of strains times the largest stiffness, and it bends no rod \[F\].
    pub(crate) nothing: f64,
}

impl Engine {
    /// Checks the model and builds elements, contact curves and the start state.
    ///
    /// # Errors
    /// All that [`Model::check`] refuses; threads that cannot be started.
    pub fn new(mut model: Model, threads: Option<usize>) -> Result<Self, InputError> {
        model.check()?;
        let law_asked = model.contact.law;
        model.contact.law = law_asked.on_mesh(&model.rods);
        let mut first_node = vec![0];
        for rod in &model.rods {
            first_node.push(first_node[first_node.len() - 1] + rod.num_nodes());
        }
        let num_nodes = first_node[model.rods.len()];
        let sharing = Sharing::of(&model, &first_node);
        let mut state = State {
            remainders: vec![Vec3::zeros(); num_nodes],
            positions: model.rods.iter().flat_map(|r| r.positions.iter().copied()).collect(),
            frames: model.rods.iter().flat_map(|r| r.frames.iter().copied()).collect(),
            seams: model.rods.iter().map(|r| TAU * r.start_link()).collect(),
            load_factor: model.load,
            pressures: vec![0.0; model.rods.len()],
            placements: model.obstacles.iter().map(Obstacle::start).collect(),
            numbers: BTreeMap::new(),
        };
        sharing.follow(&mut state);
        let elements = build_elements(&model, &first_node);
        let scales = scales(&model);
        let pool = threads.map(Pool::new).transpose()?;
        let mut engine = Self {
            tables: [ShapeTable::new(1), ShapeTable::new(2), ShapeTable::new(3)],
            material: materials(&model),
            metric: metric(&model, &scales, &sharing),
            reference: Vec::new(),
            planes: planes(&model),
            contact: ContactSide::none(),
            law_asked,
            model,
            first_node,
            elements,
            free: Vec::new(),
            equations: Vec::new(),
            swivels: Vec::new(),
            sharing,
            state,
            scales,
            pool,
        };
        engine.find_unknowns();
        engine.reference = engine.build_reference();
        if let Some(stiffness) = engine.model.contact.law.stiffness() {
            let law = (stiffness, engine.scales.bending);
            let start = (&engine.state, MaterialTangents::directors(num_nodes));
            engine.contact = ContactSide::new(&engine.model, &engine.first_node, start, law)?;
        }
        Ok(engine)
    }

    /// Refuses rods so far from the origin that rounding of the start positions alone exceeds [`MAX_RESOLUTION`] × node
    /// spacing.
    pub(crate) fn check_resolution(&self) -> Result<(), InputError> {
        for (index, rod) in self.model.rods.iter().enumerate() {
            let farthest = self.positions(index).iter().map(|r| r.amax()).fold(0.0, f64::max);
            let resolution = f64::EPSILON * farthest / rod.spacing();
            if resolution > MAX_RESOLUTION {
                let reason = format!(
                    "lies up to {farthest:e} from the origin, where its start is known to {resolution:.1e} of its \
                     node spacing only, not to {MAX_RESOLUTION:e}: move the model to the origin"
                );
                return Err(InputError::Inconsistent { field: format!("rods.{}.positions", rod.name), reason });
            }
        }
        Ok(())
    }

    /// Stiffness of the contact law requested \[F/L²\]; 0 without contact.
    pub(crate) fn contact_stiffness(&self) -> f64 {
        let radius = self.contact.min_radius;
        contact_side::stiffness(self.model.contact.law.stiffness().unwrap_or(0.0), self.scales.bending, radius)
    }

    /// How many times softer than requested the contact law in force is; 1 without contact, and under a core law,
    /// which is only on the way.
    pub(crate) fn stiffness_reduction(&self) -> f64 {
        match self.contact.law {
            Law::Linear { stiffness } if stiffness > 0.0 => (self.contact_stiffness() / stiffness).max(1.0),
            _ => 1.0,
        }
    }

    /// Runs in the engine's own pool, if it has one.
    pub(crate) fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        in_pool(self.pool.as_ref(), work)
    }

    /// The rod of a node.
    pub(crate) fn rod_of(&self, node: usize) -> usize {
        self.first_node.partition_point(|&first| first <= node) - 1
    }

    /// Index of a node among all.
    pub(crate) fn index(&self, node: NodeRef) -> usize {
        self.first_node[node.rod] + node.node
    }

    /// Nodes of a rod among all.
    pub(crate) fn nodes(&self, rod: usize) -> Range<usize> {
        self.first_node[rod]..self.first_node[rod + 1]
    }

    /// Whether some node of a rod is held altogether, by supports or by being joined to one before.
    pub(crate) fn is_clamped(&self, rod: usize) -> bool {
        self.free[self.nodes(rod)].iter().any(|node| !node.contains(&true))
    }

    /// Whether supports hold an unknown of a node, its own or that which it shares; of hinged nodes the third rotation
    /// is that about the axis.
    pub(crate) fn is_held(&self, node: usize, k: usize) -> bool {
        !self.equations[self.sharing.owner[node][k]][k]
    }

    /// Whether a support holds rotations of a node, some or all, or another rod that is joined to it does.
    pub(crate) fn is_turning_held(&self, node: usize) -> bool {
        self.free[node][3..] != [true; 3] || self.is_swivel(node) || self.is_turning_joined(node)
    }

    /// Whether a rod is joined to another one, or to itself.
    pub(crate) fn is_joined(&self, rod: usize) -> bool {
        self.model.joints.iter().any(|joint| joint.a.rod == rod || joint.b.rod == rod)
    }

    /// Whether rigid joints or hinges turn a rod with another one, or with itself.
    pub(crate) fn is_turned_by_joints(&self, rod: usize) -> bool {
        let turns = |joint: &&Joint| joint.kind != JointKind::Pin;
        self.model.joints.iter().filter(turns).any(|joint| joint.a.rod == rod || joint.b.rod == rod)
    }

    /// Bases of the rotations of nodes in a state.
    pub(crate) fn bases(&self, state: &State) -> Bases {
        Bases::at((&self.swivels, &self.sharing.hinged), state)
    }

    /// Whether a support holds the rotation of a node about one axis.
    pub(crate) fn is_swivel(&self, node: usize) -> bool {
        self.swivels.iter().any(|swivel| swivel.nodes.contains(&node))
    }

    /// Whether a rod bears loads, at nodes or along itself.
    pub(crate) fn bears_loads(&self, rod: usize) -> bool {
        let model = &self.model;
        model.loads.iter().any(|load| load.node.rod == rod) || model.line_loads.iter().any(|load| load.rod == rod)
    }

    /// Half of B/ε³ \[F/L\], the pressure of strands wound tightly around each other.
    pub(crate) fn pressure_scale(&self) -> f64 {
        let radius = self.contact.min_radius;
        0.5 * self.scales.bending / radius.powi(3)
    }

    /// Whether moments act, at nodes or along rods.
    pub(crate) fn bears_moments(&self) -> bool {
        let mut moments =
            self.model.loads.iter().map(|l| l.moment).chain(self.model.line_loads.iter().map(|l| l.moment));
        self.state.load_factor != 0.0 && moments.any(|moment| moment != Vec3::zeros())
    }

    /// Whether the loads have a potential: fixed-axis moments have none in three dimensions.
    pub fn is_conservative(&self) -> bool {
        self.model.planar || !self.bears_moments()
    }

    /// The model this engine was built from.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The present configuration.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The present configuration, to be put where no solver would.
    #[cfg(test)]
    pub(crate) fn state_mut(&mut self) -> &mut State {
        &mut self.state
    }

    /// Scales, materials and masses of rods whose numbers have changed.
    pub(crate) fn measure_again(&mut self) {
        self.scales = scales(&self.model);
        self.material = materials(&self.model);
        self.metric = metric(&self.model, &self.scales, &self.sharing);
        self.planes = planes(&self.model);
    }

    /// Finds by the supports which components of the nodes are unknown.
    pub(crate) fn find_unknowns(&mut self) {
        self.sharing = Sharing::of(&self.model, &self.first_node);
        self.equations = free_unknowns(&self.model, &self.first_node, &self.sharing.owner);
        self.swivels = Swivel::all(&self.model, &self.equations, &self.sharing.owner);
        self.free.clone_from(&self.equations);
        self.swivels.iter().for_each(|swivel| self.free[swivel.nodes[0]][3 + swivel.axis] = true);
        // a rotation about a hinge's axis has components about x, y and z
        for (node, owner) in
            self.sharing.owner.iter().enumerate().filter(|(node, owner)| owner[5] == *node && owner[3] != *node)
        {
            debug_assert!(owner[4] == owner[3]);
            self.free[node][3..].fill(self.equations[node][5]);
        }
    }

    /// Node positions of a rod \[L\].
    pub fn positions(&self, rod: usize) -> &[Vec3] {
        &self.state.positions[self.nodes(rod)]
    }

    /// Node frames of a rod.
    pub fn frames(&self, rod: usize) -> &[Quat] {
        &self.state.frames[self.nodes(rod)]
    }

    /// Number of nodes of all rods.
    pub fn num_nodes(&self) -> usize {
        self.state.positions.len()
    }

    /// Nodes of an element in a state, positions from its first node on, signs aligned.
    pub(crate) fn element_nodes(&self, state: &State, element: &Element) -> ElementNodes {
        let count = self.model.rods[element.rod].order + 1;
        let mut nodes = ElementNodes::default();
        for a in 0..count {
            let node = element.nodes[a];
            nodes.r[a] = state.chord(element.nodes[0], node).into();
            let frame =
                if element.closes && a + 1 == count { state.seam_frame(element.rod, node) } else { state.frames[node] };
            nodes.q[a] = to_array(&frame);
        }
        nodes.align_signs(count);
        nodes
    }

    pub(crate) fn table(&self, rod: usize) -> &ShapeTable {
        &self.tables[self.model.rods[rod].order - 1]
    }

    /// Shape functions, length and material of an element.
    pub(crate) fn body(&self, e: usize) -> ElementProperties<'_> {
        let rod = self.elements[e].rod;
        ElementProperties {
            table: self.table(rod),
            length: self.element_length(rod),
            material: self.material[rod].of(e),
            plane: self.planes[rod].as_ref(),
        }
    }

    /// Reference length of the elements of a rod \[L\].
    pub(crate) fn element_length(&self, rod: usize) -> f64 {
        self.model.rods[rod].length / self.model.rods[rod].num_elements as f64
    }

    /// The state in which rods that are as shaped are free of stress: the start, without the twist that was put in.
    fn natural_state(&self) -> Cow<'_, State> {
        let mut state = Cow::Borrowed(&self.state);
        let twisted = |rod: &Rod| rod.twist_put_in != 0.0 && rod.natural == Natural::AsShaped;
        for (index, rod) in self.model.rods.iter().enumerate().filter(|(_, rod)| twisted(rod)) {
            let angle = TAU * rod.twist_put_in;
            let share = angle / rod.num_segments() as f64;
            let state = state.to_mut();
            for (k, frame) in state.frames[self.nodes(index)].iter_mut().enumerate() {
                *frame *= spin(-share * k as f64);
            }
            state.seams[index] -= angle;
        }
        state
    }

    fn build_reference(&self) -> Vec<Reference> {
        let start = self.natural_state();
        let mut first = 0;
        let mut all = Vec::new();
        for (index, rod) in self.model.rods.iter().enumerate() {
            all.push(match &rod.natural {
                Natural::Straight => Reference::curved([0.0; 3]),
                Natural::Uniform { kappa } => Reference::curved(*kappa),
                Natural::Varying(along) => Reference::PerElement(first, Vec::new()).varying(rod, along),
                Natural::AsShaped => {
                    let own = &self.elements[first..first + rod.num_elements];
                    let strains = own.iter().map(|element| {
                        let nodes = self.element_nodes(&start, element);
                        raw_strains(self.table(index), &nodes, self.element_length(index))
                    });
                    Reference::PerElement(first, strains.collect())
                }
            });
            first += rod.num_elements;
        }
        all
    }
}

fn materials(model: &Model) -> Vec<Stiffnesses> {
    let mut first = 0;
    let of_rod = |rod: &Rod| {
        first += rod.num_elements;
        Stiffnesses::new(rod, first - rod.num_elements)
    };
    model.rods.iter().map(of_rod).collect()
}

fn planes(model: &Model) -> Vec<Option<RodPlane>> {
    let plane = |rod: &Rod| (model.planar && rod.stiffness.is_none()).then(|| RodPlane::new(&to_array(&rod.frames[0])));
    model.rods.iter().map(plane).collect()
}

fn free_unknowns(model: &Model, first_node: &[usize], owner: &[[usize; 6]]) -> Vec<[bool; 6]> {
    let all = if model.planar { [true, true, false, false, false, true] } else { [true; 6] };
    let mut free = vec![all; owner.len()];
    for support in &model.supports {
        let owner = &owner[first_node[support.node.rod] + support.node.node];
        for k in 0..3 {
            free[owner[k]][k] &= !support.position[k];
            free[owner[k + 3]][k + 3] &= !support.rotation[k];
        }
    }
    for (node, flags) in free.iter_mut().enumerate() {
        (0..6).for_each(|k| flags[k] &= owner[node][k] == node);
    }
    free
}

fn build_elements(model: &Model, first_node: &[usize]) -> Vec<Element> {
    let mut elements = Vec::new();
    for (index, rod) in model.rods.iter().enumerate() {
        for e in 0..rod.num_elements {
            let nodes = std::array::from_fn(|a| {
                let local = (e * rod.order + a.min(rod.order)) % rod.num_nodes();
                first_node[index] + local
            });
            elements.push(Element { rod: index, nodes, closes: rod.closed && e + 1 == rod.num_elements });
        }
    }
    elements
}

fn scales(model: &Model) -> Scales {
    let fold =
        |f: &dyn Fn(&Rod) -> f64, start: f64, pick: fn(f64, f64) -> f64| model.rods.iter().map(f).fold(start, pick);
    // a radian between two nodes strains a rod by its inverse spacing
    let stiffest = |rod: &Rod| {
        let s = &rod.section;
        let [axial, bending] = [[s.shearing, [s.stretching; 2]], [s.bending, [s.twisting; 2]]]
            .map(|all| all.into_iter().flatten().fold(0.0, f64::max));
        axial + bending / rod.spacing().powi(2)
    };
    Scales {
        length: fold(&|r| r.length, 0.0, f64::max),
        bending: fold(&|r| r.section.smaller_bending(), f64::INFINITY, f64::min),
        lever: fold(&Rod::spacing, f64::INFINITY, f64::min),
        // a node's force is the sum of those of its elements, each times |N′|: up to eight times
        nothing: (8.0 * LAST_PLACES * f64::EPSILON * fold(&stiffest, 0.0, f64::max))
            .min(NOTHING * fold(&|r| r.section.smaller_bending() / r.length.powi(2), 0.0, f64::max)),
    }
}

/// Length that turns rotations into displacements in shifts, node spacings: about an element. It must not know of
/// contact radii, lest contact that nobody feels choose steps. Magnetic tweezers of 400 nm snap in 824 iterations with
/// it, in 882 with 1, in 671 with 8; a minicircle takes 442, 481 and 530 in all.
const LEVER: f64 = 3.0;

fn metric(model: &Model, scales: &Scales, sharing: &Sharing) -> Vec<f64> {
    let unit = scales.bending / scales.length.powi(4);
    let of_rod = |rod: &Rod| {
        let lever = LEVER * rod.spacing();
        let position = unit * rod.spacing();
        let rotation = position * lever * lever;
        [position, position, position, rotation, rotation, rotation].repeat(rod.num_nodes())
    };
    let mut all: Vec<f64> = model.rods.iter().flat_map(of_rod).collect();
    sharing.give_sizes(&mut all);
    all
}
