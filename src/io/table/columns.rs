//! The columns of `table.csv`: name, unit, meaning and value of each, in one place.

use std::fmt;
use std::path::Path;

use crate::error::InputError;
use crate::io::csv::{Cell, ExplainedColumn, write_explained};
use crate::observe::report::{Observation, Reaction, RodEnds, RodLink};
#[cfg(feature = "scenes")]
use crate::scene::Scene;
use crate::scene::ramped::{axis_of, place_name, prescribed, ramped_name};
use crate::scene::{Model, NodeRef, Ramp, Stage, Support, SupportChange, Units};

/// Meaning of columns that stages prescribe.
pub(in crate::io) const PRESCRIBED: &str = "prescribed by the stages";

type CellOfStep = Box<dyn Fn(&Observation) -> Cell + Send + Sync>;

struct RunColumn {
    column: ExplainedColumn,
    value: CellOfStep,
}

/// The columns of a run's table; those that a scene does not have are left out.
pub struct Columns {
    all: Vec<RunColumn>,
    units: Units,
    /// Index of the first quantity that stages ramp; none where that is no number of the table.
    ramped: Option<usize>,
}

impl fmt::Debug for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.all.iter().map(|of| &of.column.name)).finish()
    }
}

impl Columns {
    /// Of a scene.
    #[cfg(feature = "scenes")]
    pub fn of_scene(scene: &Scene) -> Self {
        let thermal = scene.thermal().map(|(_, unit)| unit);
        Self::new(&scene.model, &scene.stages, &scene.units, &scene.relaxed_links, thermal)
    }

    /// Of a model, its stages and units; `relaxed_links` is the link of relaxed DNA by rod, turns, `thermal` kT in the
    /// scene's unit of energy where it has one.
    pub fn new(
        model: &Model,
        stages: &[Stage],
        units: &Units,
        relaxed_links: &[Option<f64>],
        thermal: Option<f64>,
    ) -> Self {
        let mut all = Self { all: Vec::new(), units: units.clone(), ramped: None };
        all.add("step", "", "accepted step, 0 the start", |step| step.step.into());
        all.add("stage", "", "stage, from 0", |step| step.stage.into());
        all.add("fraction", "", "part of the stage done", |step| requested(step.fraction));
        all.prescribed(model, stages);
        all.links(model, relaxed_links);
        all.ends(model);
        all.energies(model.electrostatics.is_some(), thermal);
        all.contact();
        all.reactions(model, stages);
        for (index, obstacle) in model.obstacles.iter().enumerate() {
            let meaning = "of the obstacle on the rods, along its normals: the integral of the pressure";
            all.add(&format!("{}_force", obstacle.name), "F", meaning, move |step| {
                step.obstacle_reactions.get(index).map_or(Cell::Missing, |reaction| number(reaction.force))
            });
        }
        all.knots(model);
        all.add(
            "num_unstable",
            "",
            "unstable directions of the state; under moments of fixed direction in space they decide nothing",
            |step| step.num_unstable.into(),
        );
        all.add("energy_released", "F L", "set free by a snap in this step; 0: none", |step| {
            step.energy_released.into()
        });
        all.add("iterations", "", "Newton iterations of the step, failed tries included", |step| {
            step.iterations.into()
        });
        all.add("iterations_on_other_meshes", "", "those on a shorter rod or coarser mesh", |step| {
            step.iterations_on_other_meshes.into()
        });
        all.add("seconds", "s", "wall time of the step", |step| step.seconds.into());
        all.add("status", "", "converged; overlap, fails … (a check of the certificate), or why not", |step| {
            step.status.as_str().into()
        });
        all.add("certificate", "", "what holds of the state, or which checks fail", |step| {
            step.certificate.to_string().as_str().into()
        });
        all.add("notes", "", "to be known before the numbers are believed", |step| step.notes.join("; ").into());
        let first = stages.iter().flat_map(|stage| &stage.ramps).find_map(|ramp| match ramp {
            Ramp::ExcessLink { rod, .. } => Some(of_rod(model, *rod, "excess_link")),
            other => ramped_name(model, other),
        });
        all.ramped = first.and_then(|name| all.all.iter().position(|of| of.column.name == name));
        all
    }

    fn add(
        &mut self,
        name: &str,
        dimension: &str,
        meaning: &'static str,
        value: impl Fn(&Observation) -> Cell + Send + Sync + 'static,
    ) {
        let column = ExplainedColumn { name: name.to_owned(), unit: self.units.of(dimension), meaning };
        self.all.push(RunColumn { column, value: Box::new(value) });
    }

    fn prescribed(&mut self, model: &Model, stages: &[Stage]) {
        for quantity in prescribed(model, stages) {
            let name = quantity.name.clone();
            self.add(&name, quantity.unit, PRESCRIBED, move |step| requested(quantity.at(step.stage, step.fraction)));
        }
    }

    fn links(&mut self, model: &Model, relaxed_links: &[Option<f64>]) {
        for rod in (0..model.rods.len()).filter(|&rod| model.rods[rod].closed) {
            let mut add = |name: &str, unit: &str, meaning: &'static str, of: fn(&RodLink) -> f64| {
                self.add(&of_rod(model, rod, name), unit, meaning, move |step| {
                    step.links.iter().find(|link| link.rod == rod).map_or(Cell::Missing, |link| number(of(link)))
                });
            };
            add("excess_link", "turns", "link beyond that of the relaxed rod", |link| rounded(link.excess_link));
            add("link", "turns", "the whole link, natural twist included: twist + writhe", |link| link.link);
            add("twist", "turns", "of the material line about the centreline", |link| link.twist);
            add("excess_twist", "turns", "twist beyond the natural one", |link| link.excess_twist);
            add("writhe", "turns", "of the centreline", |link| link.writhe);
            add("seam_moment", "F L", "twisting moment at s = 0, positive if overtwisted", |l| l.seam_moment);
            if let Some(relaxed) = relaxed_links.get(rod).copied().flatten() {
                let sigma = move |step: &Observation| {
                    let link = step.links.iter().find(|link| link.rod == rod);
                    link.map_or(Cell::Missing, |link| requested(link.excess_link / relaxed))
                };
                self.add(&of_rod(model, rod, "sigma"), "", "supercoiling density", sigma);
            }
        }
    }

    fn ends(&mut self, model: &Model) {
        for rod in (0..model.rods.len()).filter(|&rod| !model.rods[rod].closed) {
            let mut add = |name: &str, unit: &str, meaning: &'static str, of: fn(&RodEnds) -> Option<f64>| {
                self.add(&of_rod(model, rod, name), unit, meaning, move |step| {
                    step.ends.iter().find(|ends| ends.rod == rod).and_then(of).map_or(Cell::Missing, number)
                });
            };
            let length = "L";
            add("start_x", length, "position of the start", |ends| Some(ends.start[0]));
            add("start_y", length, "position of the start", |ends| Some(ends.start[1]));
            add("start_z", length, "position of the start", |ends| Some(ends.start[2]));
            add("end_x", length, "position of the end", |ends| Some(ends.end[0]));
            add("end_y", length, "position of the end", |ends| Some(ends.end[1]));
            add("end_z", length, "position of the end", |ends| Some(ends.end[2]));
            add("extension", length, "distance from start to end", |ends| {
                Some((0..3).map(|k| (ends.end[k] - ends.start[k]).powi(2)).sum::<f64>().sqrt())
            });
            add("twist", "turns", "of the material line about the centreline", |ends| Some(ends.twist));
            add("excess_twist", "turns", "twist beyond the natural one", |ends| Some(ends.excess_twist));
            add("link", "turns", "turns of the end against the start, continued straight on; parallel ends", |e| {
                e.link
            });
            add("writhe", "turns", "of the rod continued straight on; parallel ends", |ends| ends.writhe);
        }
    }

    fn energies(&mut self, charged: bool, thermal: Option<f64>) {
        let unit = "F L";
        self.add("stretching_energy", unit, "½∫EA (Γ3 − 1)²", |step| number(step.energies.stretching));
        self.add("shearing_energy", unit, "½∫GA Γ²", |step| number(step.energies.shearing));
        self.add("bending_energy", unit, "½∫EI K²", |step| number(step.energies.bending));
        self.add("twisting_energy", unit, "½∫GJ K3²", |step| number(step.energies.twisting));
        self.add("contact_energy", unit, "stored in the contact law", |step| number(step.energies.contact));
        if charged {
            self.add("electrostatic_energy", unit, "of charges along strands", |step| {
                number(step.energies.electrostatic)
            });
        }
        self.add("total_energy", unit, "sum of these; work of loads not included", |step| number(step.energies.total));
        if let Some(thermal) = thermal {
            self.add("total_energy_kT", "kT", "the same at the scene's temperature", move |step| {
                number(step.energies.total / thermal)
            });
        }
    }

    fn contact(&mut self) {
        self.add("min_gap", "L", "smallest gap of the elements' centrelines; blank beyond two diameters", |step| {
            step.min_gap.map_or(Cell::Missing, |gap| number(gap.lower))
        });
        self.add("penetration", "L", "worst penetration", |step| {
            let between = step.min_gap.map_or(0.0, |gap| (-gap.lower).max(0.0));
            number(step.obstacle_sites.iter().fold(between, |worst, site| worst.max(-site.gap)))
        });
        self.add("num_sites", "", "contact sites", |step| step.num_sites.into());
        self.add("contact_force", "F", "∫p ds over all sites", |step| number(step.total_contact_force));
        self.add("contact_resultants", "F", "Σ|∫p n ds|, a vector a site: more exact at points", |step| {
            number(step.contact_resultants)
        });
    }

    fn reactions(&mut self, model: &Model, stages: &[Stage]) {
        for node in supported(model, stages) {
            let (position, rotation) = held(model, stages, node);
            let place = place_name(model, node);
            let mut add =
                |name: String, unit: &str, meaning: &'static str, of: Box<dyn Fn(&Reaction) -> f64 + Send + Sync>| {
                    self.add(&name, unit, meaning, move |step| {
                        let found = step.reactions.iter().find(|r| (r.rod, r.node) == (node.rod, node.node));
                        found.map_or(Cell::Missing, |reaction| number(of(reaction)))
                    });
                };
            for k in 0..3 {
                let axis = ["x", "y", "z"][k];
                if position[k] {
                    let of = Box::new(move |r: &Reaction| r.force[k]);
                    add(format!("{place}_force_{axis}"), "F", "of the support on the rod", of);
                }
            }
            for k in 0..3 {
                let axis = ["x", "y", "z"][k];
                if rotation[k] {
                    let of = Box::new(move |r: &Reaction| r.moment[k]);
                    add(format!("{place}_moment_{axis}"), "F L", "of the support on the rod", of);
                }
            }
            if let Some(axis) = axis_of(stages, node) {
                let of = Box::new(move |r: &Reaction| (0..3).map(|k| r.moment[k] * axis[k]).sum());
                let meaning = "moment of the support on the rod about the axis it turns it about";
                add(format!("{place}_torque"), "F L", meaning, of);
            }
        }
    }

    fn knots(&mut self, model: &Model) {
        if model.planar {
            return;
        }
        let closed = || (0..model.rods.len()).filter(|&rod| model.rods[rod].closed);
        for rod in (0..model.rods.len()).filter(|&rod| model.rods[rod].section.contact_radius > 0.0) {
            let knot = move |step: &Observation| step.knots.iter().find(|knot| knot.rod == rod).cloned();
            self.add(
                &of_rod(model, rod, "knot"),
                "",
                "simplest knot with its polynomials (Alexander, Jones), to eight crossings; 0_1: none; a star: mirror \
                 image",
                move |step| knot(step).map_or_else(String::new, |knot| knot.name).into(),
            );
            if model.rods.len() == 1 && model.rods[rod].closed {
                let meaning = "length over the diameter of the thickest tube; blank where nothing is near";
                self.add("ropelength", "", meaning, move |step| {
                    knot(step).and_then(|knot| knot.ropelength).map_or(Cell::Missing, number)
                });
            }
        }
        for a in closed() {
            for b in closed().filter(|&b| b > a) {
                let name = format!("linking_{}_{}", model.rods[a].name, model.rods[b].name);
                self.add(&name, "", "linking number of two rods", move |step| {
                    let found = step.linking.iter().find(|pair| (pair.rod_a, pair.rod_b) == (a, b));
                    found.map_or(Cell::Missing, |pair| number(pair.link))
                });
            }
        }
    }

    /// Names of the columns.
    pub fn names(&self) -> Vec<&str> {
        self.all.iter().map(|of| of.column.name.as_str()).collect()
    }

    /// Names, units and meanings of the columns.
    pub fn explained(&self) -> impl Iterator<Item = &ExplainedColumn> {
        self.all.iter().map(|of| &of.column)
    }

    /// Cells of one step.
    pub fn cells(&self, step: &Observation) -> Vec<Cell> {
        self.all.iter().map(|of| (of.value)(step)).collect()
    }

    /// Numbers of one step by name, with their units; NaN where a cell is blank.
    pub fn numbers<'a>(&'a self, step: &'a Observation) -> impl Iterator<Item = (&'a str, &'a str, f64)> {
        self.all.iter().zip(self.cells(step)).filter_map(|(RunColumn { column, .. }, cell)| {
            let value = match cell {
                Cell::Number(value) => value,
                Cell::Count(value) => value as f64,
                Cell::Missing => f64::NAN,
                Cell::Text(_) => return None,
            };
            Some((column.name.as_str(), column.unit.as_str(), value))
        })
    }

    /// How far a run is: the value of the first quantity that stages ramp, and the name of its column. `stage +
    /// fraction` where that is no number: poses, supports, nothing.
    pub fn progress(&self, step: &Observation) -> (&str, f64) {
        let ramped = self.ramped.map(|index| &self.all[index]);
        match ramped.map(|of| (&of.column, (of.value)(step))) {
            Some((column, Cell::Number(value))) => (&column.name, value),
            _ => ("stage + fraction", step.stage as f64 + step.fraction),
        }
    }

    /// Writes the steps as CSV, one a line; name, unit and meaning of the columns in a file beside it.
    ///
    /// # Errors
    /// [`InputError::Write`] if a file cannot be written.
    pub fn write(&self, path: &Path, steps: &[Observation]) -> Result<(), InputError> {
        let columns: Vec<ExplainedColumn> = self.all.iter().map(|of| of.column.clone()).collect();
        write_explained(path, &columns, steps.iter().map(|step| self.cells(step)))
    }
}

fn of_rod(model: &Model, rod: usize, name: &str) -> String {
    let alike = model.rods.iter().filter(|other| other.closed == model.rods[rod].closed).count();
    if alike > 1 || (model.rods.len() > 1 && !model.rods[rod].closed) {
        format!("{}_{name}", model.rods[rod].name)
    } else {
        name.to_owned()
    }
}

/// A number without the rounding of the steps that led to it: the third step of 0.1 is at 0.3, not at
/// 0.30000000000000004.
fn rounded(value: f64) -> f64 {
    format!("{value:.12e}").parse().unwrap_or(value)
}

/// A value that stages ask for.
fn requested(value: f64) -> Cell {
    number(rounded(value))
}

fn number(x: f64) -> Cell {
    // + 0.0 turns −0 into 0
    Cell::Number(x + 0.0)
}

/// Nodes that supports fix at some time of the run.
fn supported(model: &Model, stages: &[Stage]) -> Vec<NodeRef> {
    let mut all: Vec<NodeRef> = model.supports.iter().chain(set_later(stages)).map(|support| support.node).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Components of position and rotation that are fixed at a node at some time.
fn held(model: &Model, stages: &[Stage], node: NodeRef) -> ([bool; 3], [bool; 3]) {
    let later = set_later(stages).filter(|support| support.node == node);
    later.fold(model.fixed(node), |(position, rotation), support| {
        let either = |a: [bool; 3], b: [bool; 3]| std::array::from_fn(|k| a[k] || b[k]);
        (either(position, support.position), either(rotation, support.rotation))
    })
}

/// Supports that stages add.
fn set_later(stages: &[Stage]) -> impl Iterator<Item = &Support> {
    stages.iter().flat_map(|stage| &stage.supports).filter_map(|change| match change {
        SupportChange::Hold(support) => Some(support),
        SupportChange::Release(_) => None,
    })
}
