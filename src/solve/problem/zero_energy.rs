//! Motions that cost nothing: rigid motions of rods nobody holds; the spin of an isotropic closed rod about its own
//! centreline; the sliding of a uniform closed rod along itself. Users need not specify them.
//!
//! The tangent is singular along them. Springs added to it at a few unknowns make it regular; the residual has no
//! component along a neutral motion, so the springs stay unstretched, the increment is one of the exact solutions and
//! the inertia is that of the tangent on the rest. Then the increment's neutral part is taken out, which leaves the
//! shortest solution.
//!
//! Sliding is neutral for the continuous rod only: the discrete energy has a ripple of the size of the discretisation
//! error, and following it would move the whole rod by up to half an element for nothing. So sliding is held by a
//! constraint on the increment, and the ripple's force, the residual along the sliding motion, is no part of the
//! residual. Contact does no work on any of these motions. Where rods are sheared it seems to, because the tangents of
//! the contact centrelines are held in the nodes' frames (`contact_tangents`), so a spin turns them: that force is no
//! part of the residual either.
//!
//! Supports leave combinations of these motions where they hold less than there are: see [`Supports`]. Several rods:
//! see [`Several`].

use std::cmp::Ordering;
use std::collections::BTreeMap;

use nalgebra::{DMatrix, Dyn, SymmetricEigen};

use crate::contact::potential::surface::SurfaceContact;
use crate::math::signed_distance::{Skeleton, Surface};
use crate::math::{Mat3, Vec3};
use crate::scene::NodeRef;
use crate::solve::measures::{NOTHING, ROUNDING};
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;
use crate::solve::problem::swivel::Bases;
use crate::sparse::Pattern;
use hinged::PartRotation;
use orthonormal::{add, least_size, subtract, subtract_force, weighted};
use several::Several;

/// Relative deviation up to which directions and motions are the same, because meshes do not tell them apart.
pub(super) const TOLERANCE: f64 = 1e-3;

mod hinged;
mod orthonormal;
mod several;

/// Square of a motion where a rod is held, over the largest, below which supports let it pass: ends that are coaxial
/// but for the last digits of a file would leave a motion that costs a ten millionth of the energy, and searches end
/// neither in its valley nor on its ridge.
const PASSES: f64 = 1e-12;

/// Whether no support holds a component of a rod's nodes, and no joint.
fn is_free(engine: &Engine, rod: usize) -> bool {
    let wanted = if engine.model.planar { 3 } else { 6 };
    let swivels = || engine.swivels.iter().flat_map(|swivel| &swivel.nodes);
    !engine.is_joined(rod)
        && !swivels().any(|&node| engine.rod_of(node) == rod)
        && engine.free[engine.nodes(rod)].iter().all(|f| f.iter().filter(|x| **x).count() == wanted)
}

/// Whether nothing but contact holds a rod against loads.
pub(crate) fn is_falling(engine: &Engine, rod: usize) -> bool {
    engine.bears_loads(rod) && is_free(engine, rod)
}

/// Whether a rod's supports, or those of nodes that are joined to its own, let none of its motions pass, on the face of
/// it.
fn holds_all(engine: &Engine, rod: usize) -> bool {
    let is_clamped = |node: usize| (0..6).all(|k| engine.is_held(node, k));
    !engine.model.rods[rod].closed && engine.nodes(rod).any(is_clamped)
}

/// Closed with the same section and nature all along, and the same again after a turn of the seam: sliding costs
/// nothing.
fn slides(engine: &Engine, state: &State, rod: usize) -> bool {
    let uniform = engine.reference[rod].is_uniform() && engine.material[rod].is_uniform();
    let turns = state.seams[rod] / std::f64::consts::TAU;
    let is_whole = (turns - turns.round()).abs() <= NOTHING;
    engine.model.rods[rod].closed && uniform && (is_whole || spins(engine, rod))
}

/// Closed, isotropic, naturally straight: spinning about the centreline costs nothing.
fn spins(engine: &Engine, rod: usize) -> bool {
    engine.model.rods[rod].closed && is_round(engine, rod)
}

/// Isotropic, naturally straight, in space, joined by pins at most: strains turned about the tangent cost the same.
fn is_round(engine: &Engine, rod: usize) -> bool {
    let straight = engine.reference[rod].is_straight(engine.element_length(rod));
    let alone = !engine.is_turned_by_joints(rod) && !engine.model.planar;
    straight && alone && engine.material[rod].is_isotropic()
}

fn tangent_of(state: &State, node: usize) -> Vec3 {
    state.frames[node] * Vec3::z()
}

/// The node whose tangent is farthest from the first one's: there spin and sliding differ most from rigid motions.
fn opposite(engine: &Engine, state: &State, rod: usize) -> usize {
    let nodes = engine.nodes(rod);
    let axis = tangent_of(state, nodes.start);
    let along = |n: usize| tangent_of(state, n).dot(&axis);
    nodes.clone().min_by(|&a, &b| along(a).total_cmp(&along(b))).unwrap_or(nodes.start)
}

/// Neutral motions at one state, orthonormal in a weighted product.
#[derive(Debug, Default)]
pub(crate) struct ZeroEnergyModes {
    motions: Vec<Vec<f64>>,
    /// Index in `motions` of the sliding motion, if there is one.
    sliding: Option<usize>,
    weights: [f64; 2],
    /// The rod is held, and its supports permit these motions.
    held: bool,
    /// The rod touches obstacles, which resist some of its rigid motions.
    on_obstacles: bool,
    /// Contact seems to do work on them, because its tangents are held in the frames of sheared rods.
    is_sheared: bool,
    /// Of models of several rods.
    several: Several,
}

/// A motion of some nodes: displacement and rotation vector of each, six numbers.
fn motion(nodes: impl Iterator<Item = usize>, of_node: impl Fn(usize) -> (Vec3, Vec3)) -> Vec<f64> {
    let six = |n: usize| {
        let (d, r) = of_node(n);
        [d.x, d.y, d.z, r.x, r.y, r.z]
    };
    nodes.flat_map(six).collect()
}

/// Rigid motions of some nodes, in the plane those that stay in it; of these those that keep gaps to surfaces as they
/// are.
fn rigid_motions(engine: &Engine, state: &State, nodes: &[usize], surfaces: &[Surface]) -> Vec<Vec<f64>> {
    let centre = nodes.iter().map(|n| state.positions[*n]).sum::<Vec3>() / nodes.len() as f64;
    let planar = engine.model.planar;
    let rigid = if surfaces.is_empty() {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let (along, about) = if planar { (&axes[..2], &axes[2..]) } else { (&axes[..], &axes[..]) };
        let displacements = along.iter().map(|axis| [*axis, Vec3::zeros()]);
        displacements.chain(about.iter().map(|axis| [Vec3::zeros(), *axis])).collect()
    } else {
        left_by_surfaces(surfaces, (&centre, engine.scales.length), planar)
    };
    let of_all = |[along, about]: &[Vec3; 2]| {
        motion(nodes.iter().copied(), |n| (along + about.cross(&(state.positions[n] - centre)), *about))
    };
    rigid.iter().map(of_all).collect()
}

/// Rigid motions, by the velocity of a centre and a rotation vector, that move surfaces along themselves only. A
/// velocity v and a rotation vector, times a length, count alike.
///
/// A plane is moved along itself if v·n = 0 and ω ∥ n, a sphere if its centre stays, a cylinder if its axis stays on
/// its line, a capsule if it does and its ends stay: each is some combinations of v and ω that must vanish, and the
/// motions left are a null space.
fn left_by_surfaces(surfaces: &[Surface], (centre, length): (&Vec3, f64), planar: bool) -> Vec<[Vec3; 2]> {
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let mut normal = nalgebra::Matrix6::<f64>::zeros();
    let mut vanishes = |v: Vec3, spin: Vec3| {
        let row = nalgebra::Vector6::new(v.x, v.y, v.z, spin.x, spin.y, spin.z);
        normal += row * row.transpose();
    };
    for surface in surfaces {
        // u·(v + ω × arm) = 0
        let arm = (surface.point() - centre) / length;
        let mut stays = |u: Vec3| vanishes(u, arm.cross(&u));
        match surface.skeleton {
            Skeleton::Plane { normal, .. } => vanishes(normal, Vec3::zeros()),
            Skeleton::Point { .. } | Skeleton::Piece { .. } => axes.iter().for_each(|axis| stays(*axis)),
            Skeleton::Line { axis, .. } => axes.iter().for_each(|e| stays(e - axis * axis.dot(e))),
        }
        if let Skeleton::Plane { normal: axis, .. } | Skeleton::Line { axis, .. } | Skeleton::Piece { axis, .. } =
            surface.skeleton
        {
            axes.iter().for_each(|e| vanishes(Vec3::zeros(), e - axis * axis.dot(e)));
        }
    }
    if planar {
        vanishes(axes[2], Vec3::zeros());
        axes[..2].iter().for_each(|axis| vanishes(Vec3::zeros(), *axis));
    }
    let eigen = normal.symmetric_eigen();
    let is_free = |k: &usize| eigen.eigenvalues[*k] <= TOLERANCE * TOLERANCE;
    let of_null_space = |k: usize| {
        let [along, about] = [0, 3].map(|first| eigen.eigenvectors.fixed_view::<3, 1>(first, k).into_owned());
        [along, about / length]
    };
    (0..6).filter(is_free).map(of_null_space).collect()
}

/// Whether contact pushes a segment by more than rounding, as a force that turns a node spacing by 1e-11 rad. A rod
/// that lies at a gap of 0 is held by rounding otherwise, or let go.
fn is_pushed(engine: &Engine, residual: &Residual, segment: usize) -> bool {
    engine.contact.nodes[segment].iter().any(|&node| {
        let rod = &engine.model.rods[engine.rod_of(node)];
        let force = Vec3::from_column_slice(&residual.contact_gradient[6 * node..6 * node + 3]);
        force.norm() * rod.spacing().powi(2) > ROUNDING * rod.section.smaller_bending()
    })
}

/// Surfaces of the obstacles that some rods touch, those that nodes carry left out: they move with their rods. Those
/// that push a single rod with rounding do not touch it; in a stack of rods that do not press yet it is rounding which
/// of them push, and what they leave free is neutral in searches anyway.
fn touched_by(engine: &Engine, residual: &Residual, rods: &[usize]) -> Vec<Surface> {
    let side = &engine.contact;
    let is_alone = engine.model.rods.len() == 1;
    let pushes = |contact: &SurfaceContact| !is_alone || is_pushed(engine, residual, contact.segment);
    let is_touched = |surface: &usize| {
        let of_rods = |contact: &&SurfaceContact| rods.contains(&engine.rod_of(side.nodes[contact.segment][0]));
        let contacts = residual.surface_contacts.iter().filter(|contact| contact.surface == *surface);
        contacts.filter(of_rods).any(pushes)
    };
    let fixed = (0..side.surfaces.len()).filter(|surface| !side.surfaces[*surface].carried);
    fixed.filter(is_touched).map(|surface| side.surfaces[surface]).collect()
}

/// Spin of a rod about its centreline, as a motion of nodes that its own are among.
fn spin_of(engine: &Engine, state: &State, rod: usize, nodes: impl Iterator<Item = usize>) -> Vec<f64> {
    let own = engine.nodes(rod);
    motion(nodes, |n| (Vec3::zeros(), if own.contains(&n) { tangent_of(state, n) } else { Vec3::zeros() }))
}

/// Rotation of some nodes as a whole in a motion whose displacements are those of a rigid body.
fn rigid_rotation(state: &State, nodes: &[usize], motion: &[f64]) -> Vec3 {
    let count = nodes.len() as f64;
    let moved = |k: usize| Vec3::new(motion[6 * k], motion[6 * k + 1], motion[6 * k + 2]);
    let centre = nodes.iter().map(|n| state.positions[*n]).sum::<Vec3>() / count;
    let mean = (0..nodes.len()).map(moved).sum::<Vec3>() / count;
    let (mut inertia, mut moment) = (Mat3::zeros(), Vec3::zeros());
    for (k, n) in nodes.iter().enumerate() {
        let arm = state.positions[*n] - centre;
        inertia += Mat3::identity() * arm.norm_squared() - arm * arm.transpose();
        moment += arm.cross(&(moved(k) - mean));
    }
    // positions do not determine the rotation of a straight rod about itself
    let least = TOLERANCE * TOLERANCE * inertia.trace();
    inertia.pseudo_inverse(least).map_or(Vec3::zeros(), |inverse| inverse * moment)
}

/// Dead forces \[F\] and moments \[F·L\] at some nodes, each with the place of its node among them; line loads count
/// at each node of their rods, by the share of the length that it has.
fn loads_at(engine: &Engine, nodes: &[usize]) -> Vec<(usize, Vec3, Vec3)> {
    let places: BTreeMap<usize, usize> = nodes.iter().enumerate().map(|(place, node)| (*node, place)).collect();
    let model = &engine.model;
    let is_here = |rod: usize| places.contains_key(&engine.first_node[rod]);
    let at_nodes = model.loads.iter().map(|l| (engine.first_node[l.node.rod] + l.node.node, l.force, l.moment));
    let along =
        model.line_loads.iter().filter(|load| is_here(load.rod)).flat_map(|load| {
            engine.shares(load.rod).map(|(node, share)| (node, load.force * share, load.moment * share))
        });
    at_nodes.chain(along).filter_map(|(node, f, m)| places.get(&node).map(|place| (*place, f, m))).collect()
}

/// Rotation of those of some nodes that it moves about a centre.
fn motion_of(state: &State, (nodes, moves): (&[usize], &[bool]), center: Vec3, turn: Vec3) -> Vec<f64> {
    let moved = nodes.iter().zip(moves);
    let of = |(&node, moves): (&usize, &bool)| {
        let both = if *moves { (turn.cross(&(state.positions[node] - center)), turn) } else { Default::default() };
        [both.0.x, both.0.y, both.0.z, both.1.x, both.1.y, both.1.z]
    };
    moved.flat_map(of).collect()
}

/// Whether a hinge is among joined nodes.
fn is_turned_by(engine: &Engine, nodes: &[NodeRef]) -> bool {
    let joints = engine.model.joints.iter().filter(|joint| nodes.contains(&joint.a));
    joints.filter_map(|joint| engine.model.hinge_axis(joint)).next().is_some()
}

fn displacement_at(motion: &[f64], place: usize) -> Vec3 {
    Vec3::new(motion[6 * place], motion[6 * place + 1], motion[6 * place + 2])
}

/// Whether loads do work on a motion of some nodes that is no rigid one, or would as it goes on.
fn is_loaded(engine: &Engine, state: &State, nodes: &[usize], motion: &[f64]) -> bool {
    if state.load_factor == 0.0 {
        return false;
    }
    let whole = rigid_rotation(state, nodes, motion);
    let largest = motion.chunks(6).map(|m| Vec3::new(m[0], m[1], m[2]).norm()).fold(0.0, f64::max);
    loads_at(engine, nodes).iter().any(|(place, force, moment)| {
        let (moved, least) = (displacement_at(motion, *place), NOTHING * force.norm() * largest);
        force.dot(&moved).abs() > least
            || force.dot(&whole.cross(&moved)).abs() > least * whole.norm()
            || *moment != Vec3::zeros() && rotation_at(motion, 6 * place + 3) != Vec3::zeros()
    })
}

/// A basis of those combinations of motions, whose displacements are those of rigid bodies, that dead loads leave
/// alone: forces F do no work on them at once, Σ F·v = 0, nor as they go on together with any other, Σ F·½(ω × v' + ω'
/// × v) = 0, and no node that bears a moment turns. Along the others potential and search descend. Where a part turns
/// within what moves as a whole, it goes on by Σ F·(ω × v'), v' that of the part.
fn left_alone(
    engine: &Engine,
    state: &State,
    nodes: &[usize],
    (mut motions, parts): (Vec<Vec<f64>>, Vec<PartRotation>),
) -> Vec<Vec<f64>> {
    let num_whole = motions.len();
    let mut turns: Vec<Vec3> = motions.iter().map(|motion| rigid_rotation(state, nodes, motion)).collect();
    turns.extend(parts.iter().map(|part| part.turn));
    let size = |i: usize| if i < num_whole { nodes.len() } else { parts[i - num_whole].count };
    let moves = |i: usize, place: usize| i < num_whole || parts[i - num_whole].moves[place];
    motions.extend(parts.iter().map(|part| part.motion.clone()));
    let loads = if state.load_factor == 0.0 { Vec::new() } else { loads_at(engine, nodes) };
    let acts = |(_, force, moment): &&(usize, Vec3, Vec3)| *force != Vec3::zeros() || *moment != Vec3::zeros();
    let (loads, count): (Vec<_>, usize) = (loads.iter().filter(acts).collect(), motions.len());
    if loads.is_empty() || count == 0 {
        return motions;
    }
    let scale = 1.0 / engine.scales.length;
    let forces: f64 = loads.iter().map(|(_, force, _)| force.norm()).sum::<f64>().max(f64::MIN_POSITIVE);
    let mut rows = vec![vec![0.0; count]; count + 1];
    for (place, force, moment) in loads {
        let (force, moved) = (force * (scale / forces), |i: usize| displacement_at(&motions[i], *place));
        for i in 0..count {
            rows[count][i] += force.dot(&moved(i));
            for j in 0..count {
                if moves(i, *place) && moves(j, *place) {
                    let goes_on = match size(i).cmp(&size(j)) {
                        Ordering::Greater => turns[i].cross(&moved(j)),
                        Ordering::Less => turns[j].cross(&moved(i)),
                        Ordering::Equal => 0.5 * (turns[i].cross(&moved(j)) + turns[j].cross(&moved(i))),
                    };
                    rows[j][i] += force.dot(&goes_on);
                }
            }
        }
        if *moment != Vec3::zeros() {
            rows.extend((0..3).map(|k| motions.iter().map(|motion| motion[6 * place + 3 + k]).collect()));
        }
    }
    let work = DMatrix::from_fn(rows.len(), count, |i, j| rows[i][j]);
    let Some(parts) = work.clone().svd(false, true).v_t else { return Vec::new() };
    let is_free = |k: &usize| (&work * parts.row(*k).transpose()).norm() <= NOTHING;
    let combined = |k: usize| {
        let mut sum = vec![0.0; motions[0].len()];
        motions.iter().enumerate().for_each(|(i, motion)| subtract(&mut sum, motion, -parts[(k, i)]));
        sum
    };
    (0..count).filter(is_free).map(combined).collect()
}

fn rotation_at(motion: &[f64], at: usize) -> Vec3 {
    Vec3::new(motion[at], motion[at + 1], motion[at + 2])
}

/// Motions of a rod that its supports permit.
struct Supports {
    /// Indices of the unknowns that are held.
    held: Vec<usize>,
    /// Indices of the first rotation component of nodes that cannot turn about one direction, and that direction.
    axes: Vec<(usize, Vec3)>,
    /// Factor that makes displacements comparable with rotations \[1/L\].
    scale: f64,
}

impl Supports {
    /// Of some nodes, as motions of these list them.
    fn of(engine: &Engine, state: &State, nodes: &[usize]) -> Self {
        let bases = engine.bases(state);
        let is_hinged = |node: usize| bases.of(node).is_some() && !engine.is_swivel(node);
        // a hinge holds what another node of it has held
        let is_held = |node: usize, i: usize| match i >= 3 && is_hinged(node) {
            true => (3..6).all(|i| engine.is_held(node, i)),
            false => !engine.free[engine.sharing.owner[node][i]][i],
        };
        let held = |(k, &node): (usize, &usize)| (0..6).filter(move |i| is_held(node, *i)).map(move |i| 6 * k + i);
        let across = |node: usize| (0..3).filter(move |k| engine.is_held(node, 3 + k));
        let of_hinge = |&node: &usize| {
            let basis = bases.of(node).filter(|_| is_hinged(node) && !is_held(node, 3));
            basis.into_iter().flat_map(move |basis| across(node).map(move |k| (node, basis.column(k).into_owned())))
        };
        let axes = bases.held().chain(nodes.iter().flat_map(of_hinge)).collect::<Vec<_>>();
        let axis = |(node, axis): &(usize, Vec3)| nodes.iter().position(|n| n == node).map(|k| (6 * k + 3, *axis));
        Self {
            held: nodes.iter().enumerate().flat_map(held).collect(),
            axes: axes.iter().filter_map(axis).collect(),
            scale: 1.0 / engine.scales.length,
        }
    }

    /// Product of two motions where the rod is held.
    fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        let weight = |i: usize| if i % 6 < 3 { self.scale * self.scale } else { 1.0 };
        let about = |motion: &[f64], (at, axis): &(usize, Vec3)| rotation_at(motion, *at).dot(axis);
        let turned = |held: &(usize, Vec3)| about(a, held) * about(b, held);
        self.held.iter().map(|&i| weight(i) * a[i] * b[i]).sum::<f64>() + self.axes.iter().map(turned).sum::<f64>()
    }

    /// Eigenvectors of the products of motions, with their eigenvalues.
    fn modes(&self, motions: &[Vec<f64>]) -> SymmetricEigen<f64, Dyn> {
        let count = motions.len();
        DMatrix::from_fn(count, count, |i, j| self.dot(&motions[i], &motions[j])).symmetric_eigen()
    }

    fn combined(&self, motions: &[Vec<f64>], share: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut sum = vec![0.0; motions.first().map_or(0, Vec::len)];
        for (k, motion) in motions.iter().enumerate() {
            subtract(&mut sum, motion, -share(k));
        }
        sum
    }

    /// `motion` if it moves nothing that is held but for rounding, which is taken off.
    fn passing(&self, mut motion: Vec<f64>, largest: f64) -> Option<Vec<f64>> {
        if self.dot(&motion, &motion) > PASSES * largest {
            return None;
        }
        self.held.iter().for_each(|&i| motion[i] = 0.0);
        for (at, axis) in &self.axes {
            let rotation = rotation_at(&motion, *at);
            motion[*at..at + 3].copy_from_slice((rotation - axis * axis.dot(&rotation)).as_slice());
        }
        Some(motion)
    }

    /// Brings motions to a radian, or to the model's length, where they are largest: those by a unit of length would
    /// count for more or for less beside rotations in another unit.
    fn size(&self, motions: &mut [Vec<f64>]) {
        let weight = |i: usize| if i % 6 < 3 { self.scale } else { 1.0 };
        for motion in motions {
            let sizes = motion.iter().enumerate().map(|(i, x)| weight(i) * x.abs());
            let largest = sizes.fold(f64::MIN_POSITIVE, f64::max);
            motion.iter_mut().for_each(|x| *x /= largest);
        }
    }

    /// A basis of the combinations of motions, brought to one [size](Self::size), that move nothing that is held.
    fn all_that_pass(&self, motions: &[Vec<f64>]) -> Vec<Vec<f64>> {
        if motions.is_empty() {
            return Vec::new();
        }
        let modes = self.modes(motions);
        let largest = modes.eigenvalues.amax().max(1.0);
        let mode = |k: usize| self.combined(motions, |i| modes.eigenvectors[(i, k)]);
        let soft = (0..motions.len()).filter(|k| modes.eigenvalues[*k] <= PASSES * largest).map(mode);
        soft.filter_map(|motion| self.passing(motion, largest)).collect()
    }

    /// `motion` with as much of the others, of one [size](Self::size), as it takes to move nothing that is held; none
    /// if they cannot do that.
    fn let_pass(&self, mut motion: Vec<f64>, others: &[Vec<f64>]) -> Option<Vec<f64>> {
        if others.is_empty() {
            return self.passing(motion, 1.0);
        }
        let modes = self.modes(others);
        let largest = modes.eigenvalues.amax().max(1.0);
        for k in (0..others.len()).filter(|k| modes.eigenvalues[*k] > PASSES * largest) {
            let mode = self.combined(others, |i| modes.eigenvectors[(i, k)]);
            let part = self.dot(&motion, &mode) / modes.eigenvalues[k];
            subtract(&mut motion, &mode, part);
        }
        self.passing(motion, largest)
    }
}

impl ZeroEnergyModes {
    /// The neutral motions of a model whose strands touch as in a residual.
    pub(crate) fn at(engine: &Engine, state: &State, residual: &Residual) -> Self {
        let is_sheared = engine.contact.tangents.are_sheared();
        if engine.model.rods.len() == 1 {
            return Self { is_sheared, ..Self::of(engine, state, residual) };
        }
        let several = Several::of(engine, state, residual, weights(engine));
        Self { is_sheared, several, ..Self::default() }
    }

    /// The neutral motions of a model that is a single rod, which touches obstacles as given: all of them if it is
    /// free; if it is held somewhere, those that its supports let pass and loads do no work on (a closed rod clamped at
    /// one node travels along its own shape through the clamp, and swings about the tangent there; one twisted between
    /// coaxial clamps turns about their axis while it spins back). None otherwise.
    fn of(engine: &Engine, state: &State, residual: &Residual) -> Self {
        if engine.model.rods.len() != 1 {
            return Self::default();
        }
        let free = is_free(engine, 0);
        let passes_nothing = holds_all(engine, 0) && !is_round(engine, 0);
        if !free && passes_nothing {
            return Self::default();
        }
        let mut zero_energy = Self { weights: weights(engine), ..Self::default() };
        let nodes: Vec<usize> = engine.nodes(0).collect();
        let touched = touched_by(engine, residual, &[0]);
        let mut motions = rigid_motions(engine, state, &nodes, &touched);
        zero_energy.on_obstacles = !touched.is_empty();
        // springs of a falling rod, too, stop only what loads leave alone
        zero_energy.held = !free || is_falling(engine, 0);
        if spins(engine, 0) || zero_energy.held && is_round(engine, 0) {
            motions.push(spin_of(engine, state, 0, engine.nodes(0)));
        }
        let mut sliding = slides(engine, state, 0).then(|| motion(engine.nodes(0), |n| sliding_rate(engine, state, n)));
        let mut least = 0.0;
        if !free {
            let supports = Supports::of(engine, state, &nodes);
            supports.size(&mut motions);
            supports.size(sliding.as_mut_slice());
            least = least_size(zero_energy.weights, motions.iter());
            // sliding of a circle that is turned back is no motion but for the error of differences
            let error = (largest_turn(state, &nodes).powi(2) / TOLERANCE).max(1.0);
            let least_sliding = error * least_size(zero_energy.weights, sliding.iter());
            sliding = sliding.and_then(|motion| supports.let_pass(motion, &motions));
            sliding = sliding.filter(|motion| weighted(zero_energy.weights, motion, motion).sqrt() > least_sliding);
            motions = supports.all_that_pass(&motions);
        }
        for motion in left_alone(engine, state, &nodes, (motions, Vec::new())) {
            add(zero_energy.weights, &mut zero_energy.motions, motion, least);
        }
        sliding = sliding.filter(|motion| !is_loaded(engine, state, &nodes, motion));
        if sliding.is_some_and(|motion| add(zero_energy.weights, &mut zero_energy.motions, motion, 0.0)) {
            zero_energy.sliding = Some(zero_energy.motions.len() - 1);
        }
        zero_energy
    }

    /// All motions, six numbers for each node of the model, sliding the last.
    pub(crate) fn all(&self, engine: &Engine) -> Vec<Vec<f64>> {
        self.motions.iter().cloned().chain(self.several.all(6 * engine.num_nodes())).collect()
    }

    /// Takes the neutral part out of an increment.
    pub(crate) fn remove(&self, step: &mut [f64]) {
        for motion in &self.motions {
            let part = weighted(self.weights, step, motion);
            subtract(step, motion, part);
        }
        self.several.remove(step);
    }

    /// The linear constraint c·Δ = 0 that keeps an increment from sliding: c = W v.
    pub(crate) fn sliding_constraint(&self) -> Option<Vec<f64>> {
        let motion = &self.motions[self.sliding?];
        Some(motion.iter().enumerate().map(|(i, v)| self.weights[usize::from(i % 6 >= 3)] * v).collect())
    }

    /// Takes out of a residual what does work on sliding, and on the other motions as far as it is of contact.
    pub(crate) fn remove_forces(&self, residual: &mut Residual) {
        for (index, motion) in self.motions.iter().enumerate() {
            let forces = match self.sliding == Some(index) {
                true => &residual.gradient,
                false if self.is_sheared => &residual.contact_gradient,
                false => continue,
            };
            let work: f64 = forces.iter().zip(motion).map(|(g, v)| g * v).sum();
            subtract_force(&mut residual.gradient, motion, work, self.weights);
        }
        if self.is_sheared {
            self.several.remove_forces(&residual.contact_gradient, &mut residual.gradient);
        }
    }

    /// Adds the springs of all free rods, and of held ones, to the tangent.
    pub(crate) fn add_pins(
        &self,
        engine: &Engine,
        state: &State,
        (pattern, bases): (&Pattern, &Bases),
        values: &mut [f64],
    ) {
        let is_single = engine.model.rods.len() == 1;
        if self.held {
            let pinned = &self.motions[..self.sliding.unwrap_or(self.motions.len())];
            pin_held(engine, &engine.nodes(0).collect::<Vec<_>>(), pinned.to_vec(), (pattern, bases), values);
        }
        for (nodes, motions) in &self.several.held {
            pin_held(engine, nodes, motions.clone(), (pattern, bases), values);
        }
        let falls = |index: &usize| is_single && self.held || self.several.falling.contains(index);
        let is_pinned = |index: &usize| is_free(engine, *index) && !falls(index);
        for (index, rod) in engine.model.rods.iter().enumerate().filter(|(index, _)| is_pinned(index)) {
            let alone = if is_single { !self.on_obstacles } else { self.several.anchors.binary_search(&index).is_ok() };
            // of several free rods that touch, all but one, and those that touch obstacles: contact may resist their
            // rigid motions, and weak springs shorten steps only a little
            let factor = if alone { 1.0 } else { NOTHING };
            let spacing = rod.spacing();
            let spring = rod.section.bending[0] / spacing.powi(3);
            let turning = rod.section.twisting / spacing;
            let first = engine.first_node[index];
            let held = |i: usize| factor * if i < 3 { spring } else { turning };
            pattern.add_block(values, first, first, |i, j| if i == j { held(i) } else { 0.0 });
            if !spins(engine, index) {
                continue;
            }
            let other = opposite(engine, state, index);
            let d = tangent_of(state, other);
            let axial = |i: usize, j: usize| if i >= 3 && j >= 3 { turning * d[i - 3] * d[j - 3] } else { 0.0 };
            pattern.add_block(values, other, other, axial);
        }
    }
}

/// One spring for each motion of held rods (whose `nodes` these are) but sliding, along that motion at the node that it
/// moves most and across those before: together they stop all of them and nothing else.
fn pin_held(
    engine: &Engine,
    nodes: &[usize],
    mut rest: Vec<Vec<f64>>,
    (pattern, bases): (&Pattern, &Bases),
    values: &mut [f64],
) {
    let Some(&first) = nodes.first() else { return };
    let rod = &engine.model.rods[engine.rod_of(first)];
    let spacing = rod.spacing();
    let spring = rod.section.bending[0] / spacing.powi(3);
    let arm = |k: usize| if k < 3 { 1.0 } else { spacing };
    let at = |motion: &[f64], k: usize| -> [f64; 6] { std::array::from_fn(|i| arm(i) * motion[6 * k + i]) };
    let dot = |a: &[f64; 6], b: &[f64; 6]| -> f64 { a.iter().zip(b).map(|(x, y)| x * y).sum() };
    for index in 0..rest.len() {
        let size = |k: &usize| dot(&at(&rest[index], *k), &at(&rest[index], *k));
        let Some(most) = (0..nodes.len()).max_by(|a, b| size(a).total_cmp(&size(b))) else { return };
        let (along, node) = (at(&rest[index], most), nodes[most]);
        let square = dot(&along, &along);
        bases.add_block(pattern, values, (node, node), |i, j| spring * arm(i) * along[i] * arm(j) * along[j] / square);
        let (done, others) = rest.split_at_mut(index + 1);
        for other in others {
            let part = dot(&along, &at(other, most)) / square;
            subtract(other, &done[index], part);
        }
    }
}

/// Kind of motion that costs a single free rod nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Generator {
    /// Of the whole by a unit of length.
    Displacement,
    /// Of the whole by a radian.
    Rotation,
    /// Of all frames about their tangents by a radian.
    Spin,
    /// Along itself by a unit of length.
    Sliding,
}

/// Motions by name of a model that is a single free rod which bears no loads; none of others. Sliding may depend on
/// those before it.
pub(crate) fn generators(engine: &Engine, state: &State) -> Vec<(Generator, Vec<f64>)> {
    let is_alone = engine.model.rods.len() == 1 && engine.model.obstacles.is_empty();
    if !is_alone || !is_free(engine, 0) || is_falling(engine, 0) {
        return Vec::new();
    }
    let nodes: Vec<usize> = engine.nodes(0).collect();
    let num_displacements = if engine.model.planar { 2 } else { 3 };
    let rigid = rigid_motions(engine, state, &nodes, &[]).into_iter().enumerate();
    let kind = |k: usize| if k < num_displacements { Generator::Displacement } else { Generator::Rotation };
    let mut all: Vec<_> = rigid.map(|(k, motion)| (kind(k), motion)).collect();
    if spins(engine, 0) {
        all.push((Generator::Spin, spin_of(engine, state, 0, engine.nodes(0))));
    }
    if slides(engine, state, 0) {
        all.push((Generator::Sliding, motion(engine.nodes(0), |n| sliding_rate(engine, state, n))));
    }
    all
}

/// Rates of position and rotation of a node of a closed rod when the rod slides along itself by unit arc length:
/// centred differences between the neighbours, turned back through the seam where it lies between.
fn sliding_rate(engine: &Engine, state: &State, node: usize) -> (Vec3, Vec3) {
    let (first, count) = (engine.first_node[0], engine.first_node[1] - engine.first_node[0]);
    let local = node - first;
    let rod = &engine.model.rods[0];
    let reach = 2.0 * rod.length / count as f64;
    let (before, after) = ((local + count - 1) % count + first, (local + 1) % count + first);
    let seam = crate::math::quaternion::spin(state.seams[0]);
    let frame_after = if local + 1 == count { state.frames[after] * seam } else { state.frames[after] };
    let frame_before = if local == 0 { state.frames[before] * seam.inverse() } else { state.frames[before] };
    let turn = (frame_after * frame_before.inverse()).scaled_axis();
    ((state.positions[after] - state.positions[before]) / reach, turn / reach)
}

/// Largest angle between the tangents of neighbours among some nodes in a row, rad.
fn largest_turn(state: &State, nodes: &[usize]) -> f64 {
    nodes.windows(2).map(|pair| tangent_of(state, pair[0]).angle(&tangent_of(state, pair[1]))).fold(0.0, f64::max)
}

/// Weights of displacements and rotations in the product of motions. Displacements first: a rigid rotation taken out of
/// a pure twist would stretch the rod by second order.
fn weights(engine: &Engine) -> [f64; 2] {
    let lever = TOLERANCE * engine.scales.length;
    [1.0, lever * lever]
}
