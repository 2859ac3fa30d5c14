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
use supercoil::solve::{Engine, NodalFields};

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
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub observation: Observation,
    rods: Vec<Rod>,
}

impl State {
    pub fn of(engine: &Engine, observation: Observation) -> Self {
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
        Self { observation, rods }
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
