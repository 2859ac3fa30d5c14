//! A state: what is known of an accepted equilibrium, as data.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::{Deserialize, Serialize};
use supercoil::io::picture::{Spot, Stripe, Tube, TubePicture};
use supercoil::io::record::RodSnapshot;
use supercoil::math::{Quat, Vec3};
use supercoil::observe::report::Observation;
use supercoil::observe::{RodStrains, smoothed_contact_forces, strains};
use supercoil::scene;
use supercoil::solve::{Engine, Equilibrium, NodalFields, Options, RunError};
use supercoil::tangent::{ContactResponse, EquilibriumTangent, Mode, Observable, PrescribedNumber};

use crate::refuse;

/// One rod's part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Rod {
    name: String,
    closed: bool,
    contact_radius: f64,
    seam_turns: f64,
    arc_lengths: Vec<f64>,
    positions: Vec<[f64; 3]>,
    /// Scalar part first.
    quaternions: Vec<[f64; 4]>,
    /// d1 at the nodes.
    directions: Vec<[f64; 3]>,
    contact_force: Vec<[f64; 3]>,
    strains: RodStrains,
    fields: NodalFields,
}

/// A state. Arrays are copies.
#[pyclass(frozen, module = "supercoil._supercoil")]
#[derive(Debug, Serialize, Deserialize)]
pub struct State {
    pub observation: Observation,
    rods: Vec<Rod>,
    /// For the tangent; bytes do not have it.
    #[serde(skip)]
    problem: Option<TangentProblem>,
}

/// What the tangent at a state needs.
#[derive(Debug)]
struct TangentProblem {
    equilibrium: Equilibrium,
    /// Masses per length, if all rods have one.
    masses: Option<Vec<f64>>,
    /// kT where units are nm and pN.
    thermal_energy: Option<f64>,
}

impl State {
    pub fn of(engine: &Engine, observation: Observation, scene: &scene::Scene) -> Self {
        let fields = engine.all_nodal_fields();
        let forces = smoothed_contact_forces(engine, &fields);
        let rods = forces.iter().zip(fields).enumerate().map(|(index, (forces, fields))| {
            let (rod, frames) = (&engine.model().rods[index], engine.frames(index));
            let seam_turns = observation.links.iter().find(|link| link.rod == index).map_or(0.0, |l| l.link);
            Rod {
                name: rod.name.clone(),
                closed: rod.closed,
                contact_radius: rod.section.contact_radius,
                seam_turns,
                arc_lengths: (0..rod.num_nodes()).map(|node| rod.spacing() * node as f64).collect(),
                positions: engine.positions(index).iter().map(|&r| r.into()).collect(),
                quaternions: frames.iter().map(|q| [q.w, q.i, q.j, q.k]).collect(),
                directions: frames.iter().map(|q| (q * Vec3::x()).into()).collect(),
                contact_force: forces.iter().map(|&f| f.into()).collect(),
                strains: strains(engine, index),
                fields,
            }
        });
        let rods = rods.collect();
        let thermal_energy = scene.thermal().map(|(_, thermal_energy)| thermal_energy);
        let problem = TangentProblem { equilibrium: Equilibrium::of(engine), masses: scene.masses(), thermal_energy };
        Self { observation, rods, problem: Some(problem) }
    }

    fn problem(&self) -> PyResult<&TangentProblem> {
        let reason = "comes from bytes (it was pickled), and its tangent is not in them: ask where it was computed";
        self.problem.as_ref().ok_or_else(|| refuse::damaged("state", reason))
    }

    fn thermal_energy(&self, given: Option<f64>) -> PyResult<f64> {
        let known = given.or(self.problem()?.thermal_energy);
        let known =
            known.ok_or_else(|| refuse::damaged("kT", "is not known, because units are not nm and pN: give it"))?;
        match known > 0.0 && known.is_finite() {
            true => Ok(known),
            false => Err(refuse::damaged(&format!("kT = {known}"), "must be a finite number greater than 0")),
        }
    }

    /// What the tangent says; contact by default as a derivative under the law in force takes it.
    fn with_tangent<R: Send>(
        &self,
        py: Python,
        contacts: Option<&str>,
        work: impl FnOnce(&mut EquilibriumTangent) -> Result<R, RunError> + Send,
    ) -> PyResult<R> {
        let equilibrium = &self.problem()?.equilibrium;
        let contacts = match contacts {
            None => ContactResponse::of_law(equilibrium.model().contact.law),
            Some("law") => ContactResponse::ByLaw,
            Some("locked") => ContactResponse::Locked,
            Some("free") => ContactResponse::Free,
            Some(other) => {
                return Err(refuse::damaged(
                    &format!("contacts = '{other}'"),
                    "must be one of 'law', 'locked', 'free'",
                ));
            }
        };
        let ask = || {
            let mut solver = equilibrium.solver(Options::default())?;
            work(&mut EquilibriumTangent::at(&mut solver, contacts)?)
        };
        py.detach(ask).map_err(refuse::run)
    }

    fn observables(&self, names: &[String]) -> PyResult<Vec<Observable>> {
        let model = self.problem()?.equilibrium.model();
        names.iter().map(|name| Observable::parse(model, name)).collect::<Result<_, _>>().map_err(refuse::input)
    }

    /// All rods as files have them.
    pub fn snapshots(&self) -> Vec<RodSnapshot> {
        let snapshot = |rod: &Rod| RodSnapshot {
            positions: rod.positions.iter().map(|&r| r.into()).collect(),
            frames: rod.quaternions.iter().map(|&q| frame(q)).collect(),
            fields: rod.fields.clone(),
            smoothed_contact_force: rod.contact_force.iter().map(|&f| f.into()).collect(),
        };
        self.rods.iter().map(snapshot).collect()
    }

    /// Positions and frames of the nodes of a rod, and its link, turns, if it is closed.
    pub fn nodes(&self, rod: usize) -> (Vec<Vec3>, Vec<Quat>, f64) {
        let rod = &self.rods[rod];
        let (positions, frames) = (rod.positions.iter(), rod.quaternions.iter());
        (positions.map(|&r| r.into()).collect(), frames.map(|&q| frame(q)).collect(), rod.seam_turns)
    }

    fn flat<const N: usize>(&self, of: impl Fn(&Rod) -> &Vec<[f64; N]>) -> Vec<f64> {
        self.rods.iter().flat_map(|rod| of(rod).iter().flatten().copied()).collect()
    }
}

/// A frame from its quaternion, scalar part first; its bits are kept.
fn frame([w, i, j, k]: [f64; 4]) -> Quat {
    Quat::new_unchecked(supercoil::nalgebra::Quaternion::new(w, i, j, k))
}

fn rows<const N: usize>(py: Python<'_>, flat: Vec<f64>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let count = flat.len() / N;
    PyArray1::from_vec(py, flat).reshape([count, N])
}

#[pymethods]
impl State {
    /// All reports of the state as JSON.
    fn observation_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.observation).map_err(|e| refuse::damaged("state", e))
    }

    /// Of every rod: name, closed, contact radius, number of nodes, number of integration points.
    fn rods(&self) -> Vec<(String, bool, f64, usize, usize)> {
        let head = |rod: &Rod| {
            let (nodes, points) = (rod.positions.len(), rod.strains.arc_lengths.len());
            (rod.name.clone(), rod.closed, rod.contact_radius, nodes, points)
        };
        self.rods.iter().map(head).collect()
    }

    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows::<3>(py, self.flat(|rod| &rod.positions))
    }

    fn quaternions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows::<4>(py, self.flat(|rod| &rod.quaternions))
    }

    fn contact_force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows::<3>(py, self.flat(|rod| &rod.contact_force))
    }

    fn strains<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows::<6>(py, self.flat(|rod| &rod.strains.strains))
    }

    fn stresses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows::<6>(py, self.flat(|rod| &rod.strains.stresses))
    }

    fn arc_lengths<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.rods.iter().flat_map(|rod| rod.arc_lengths.iter().copied()))
    }

    fn strain_arc_lengths<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.rods.iter().flat_map(|rod| rod.strains.arc_lengths.iter().copied()))
    }

    /// The softest modes: eigenvalues over B/L⁴, B/L⁴, frequencies of rods with masses, shares of stretch, shear, bend
    /// and twist, and the shapes, six numbers a node.
    #[allow(clippy::type_complexity)]
    fn modes<'py>(
        &self,
        py: Python<'py>,
        count: usize,
        contacts: &str,
    ) -> PyResult<(Vec<f64>, f64, Option<Vec<f64>>, Vec<[f64; 4]>, Bound<'py, PyArray1<f64>>)> {
        let masses = self.problem()?.masses.clone();
        let modes = self.with_tangent(py, Some(contacts), |tangent| match &masses {
            Some(masses) => tangent.vibrations(count, masses),
            None => Ok(tangent.modes(count)?),
        })?;
        let shares = modes.modes.iter().map(|mode| mode.participation).map(|p| [p.stretch, p.shear, p.bend, p.twist]);
        let nodes = |mode: &Mode| {
            let both = mode.displacements.iter().zip(&mode.rotations);
            both.flat_map(|(d, r)| [d.x, d.y, d.z, r.x, r.y, r.z]).collect::<Vec<_>>()
        };
        let shapes: Vec<f64> = modes.modes.iter().flat_map(nodes).collect();
        let shapes = PyArray1::from_vec(py, shapes);
        Ok((modes.eigenvalues().collect(), modes.unit, modes.frequencies(), shares.collect(), shapes))
    }

    /// Values of observables and their derivatives with respect to parameters, all by name, row by row.
    #[allow(clippy::type_complexity)]
    fn gradient(
        &self,
        py: Python,
        of: Vec<String>,
        to: Vec<String>,
        contacts: Option<&str>,
    ) -> PyResult<(Vec<f64>, Vec<Vec<f64>>)> {
        let model = self.problem()?.equilibrium.model();
        let of = self.observables(&of)?;
        let to: Result<Vec<_>, _> = to.iter().map(|name| PrescribedNumber::parse(model, name)).collect();
        let to = to.map_err(refuse::input)?;
        self.with_tangent(py, contacts, |tangent| {
            let values = of.iter().map(|of| Ok(tangent.value(of)?)).collect::<Result<_, RunError>>()?;
            let slopes = of.iter().map(|of| tangent.gradient(of, &to)).collect::<Result<_, _>>()?;
            Ok((values, slopes))
        })
    }

    /// Derivatives of an observable with respect to the rows of a table `natural_strains:ROD`; `None` if the name is
    /// that of another parameter.
    fn gradient_of_table<'py>(
        &self,
        py: Python<'py>,
        of: &str,
        to: &str,
        contacts: Option<&str>,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let table = PrescribedNumber::parse_table(self.problem()?.equilibrium.model(), to).map_err(refuse::input)?;
        let Some(rod) = table else { return Ok(None) };
        let of = self.observables(&[of.to_owned()])?;
        let found = self.with_tangent(py, contacts, |tangent| tangent.gradient_of_table(&of[0], rod))?;
        rows::<6>(py, found.into_iter().flatten().collect()).map(Some)
    }

    /// Why derivatives hold on one side only.
    fn one_sided(&self, py: Python) -> PyResult<Vec<String>> {
        self.with_tangent(py, None, |tangent| Ok(tangent.one_sided()))
    }

    /// The harmonic free energy, up to a number that states on one mesh share.
    fn free_energy(&self, py: Python, thermal_energy: Option<f64>, contacts: &str) -> PyResult<f64> {
        let thermal_energy = self.thermal_energy(thermal_energy)?;
        self.with_tangent(py, Some(contacts), |tangent| Ok(tangent.harmonic().free_energy(thermal_energy)?))
    }

    /// The J-factor, by the state of the same rod with a free end.
    fn j_factor(&self, py: Python, open: &Self, thermal_energy: Option<f64>, contacts: &str) -> PyResult<f64> {
        let thermal_energy = self.thermal_energy(thermal_energy)?;
        let harmonic = |state: &Self| state.with_tangent(py, Some(contacts), |tangent| Ok(tangent.harmonic()));
        harmonic(self)?.j_factor(&harmonic(open)?, thermal_energy).map_err(refuse::input)
    }

    /// Covariances of observables by name, row by row.
    fn covariance(
        &self,
        py: Python,
        of: Vec<String>,
        thermal_energy: Option<f64>,
        contacts: &str,
    ) -> PyResult<Vec<Vec<f64>>> {
        let thermal_energy = self.thermal_energy(thermal_energy)?;
        let of = self.observables(&of)?;
        let found = self.with_tangent(py, Some(contacts), |tangent| tangent.covariance(&of, thermal_energy))?;
        Ok(found.row_iter().map(|row| row.iter().copied().collect()).collect())
    }

    /// Deviation of the energy along the softest modes from the quadratic one, over kT/2.
    fn anharmonicity(&self, py: Python, count: usize, thermal_energy: Option<f64>) -> PyResult<Vec<f64>> {
        let thermal_energy = self.thermal_energy(thermal_energy)?;
        self.with_tangent(py, Some("law"), |tangent| tangent.anharmonicity(count, thermal_energy))
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = postcard::to_stdvec(self).map_err(|e| refuse::damaged("state", e))?;
        Ok(PyBytes::new(py, &bytes))
    }

    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        postcard::from_bytes(bytes).map_err(|e| refuse::damaged("state", e))
    }

    /// Draws the rods as tubes into a PNG file; rods without contact as thin ones.
    fn save_picture(&self, py: Python, path: PathBuf, width: usize, height: usize) -> PyResult<()> {
        let points = |list: &[[f64; 3]]| list.iter().map(|&p| Vec3::from(p)).collect::<Vec<_>>();
        let radius = |rod: &Rod| {
            let length = rod.arc_lengths.last().copied().unwrap_or(1.0);
            if rod.contact_radius > 0.0 { rod.contact_radius } else { length / 200.0 }
        };
        let tube = |rod: &Rod| Tube {
            points: points(&rod.positions),
            radii: vec![radius(rod)],
            closed: rod.closed,
            colors: vec![[60, 120, 180]],
            stripe: Some(Stripe { seam_turns: rod.seam_turns, ..Stripe::along(points(&rod.directions)) }),
        };
        let spots = self.observation.sites.iter().map(|site| Spot {
            center: (Vec3::from(site.feet[0]) + Vec3::from(site.feet[1])) / 2.0,
            radius: 0.8 * radius(&self.rods[site.rod_a]),
            color: [230, 80, 40],
        });
        let (tubes, spots) = (self.rods.iter().map(tube).collect(), spots.collect());
        let picture = TubePicture { tubes, spots, width, height, ..TubePicture::default() };
        py.detach(|| picture.render()?.save_png(&path)).map_err(refuse::input)
    }
}
