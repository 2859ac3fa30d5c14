//! `summary.json`.

use serde::Serialize;

use crate::error::InputError;
use crate::io::asked::{Sensitivity, TableSensitivity};
use crate::io::fingerprint::Fingerprint;
use crate::observe::ErrorEstimate;
use crate::observe::report::{Energies, Observation};
use crate::scene::{Obstacle, Scene, Units};
use crate::tangent::{Harmonic, Modes, Participation};

use super::rods::RodHead;
use super::run::RecordedRun;
use super::{Writer, files};

/// The file's content.
#[derive(Debug, Clone, Serialize)]
struct SummaryFile<'a> {
    program: &'a str,
    /// See [`Fingerprint::model_hash`].
    model_hash: &'a str,
    /// Threads that the run was allowed.
    threads: usize,
    title: &'a str,
    units: &'a Units,
    rods: &'a [RodHead],
    #[serde(skip_serializing_if = "<[Obstacle]>::is_empty")]
    obstacles: &'a [Obstacle],
    converged: bool,
    status: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<&'a str>,
    seconds: f64,
    #[serde(rename = "final")]
    last: Option<&'a Observation>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_estimate: Option<&'a ErrorEstimate>,
    #[serde(skip_serializing_if = "Option::is_none")]
    modes: Option<ModesPart>,
    #[serde(skip_serializing_if = "Option::is_none")]
    harmonic: Option<&'a [Harmonic; 2]>,
    #[serde(skip_serializing_if = "<[Sensitivity]>::is_empty")]
    sensitivities: &'a [Sensitivity],
    #[serde(skip_serializing_if = "<[TableSensitivity]>::is_empty")]
    table_sensitivities: &'a [TableSensitivity],
    #[serde(skip_serializing_if = "Option::is_none")]
    thermal: Option<Thermal>,
    steps: &'a [Observation],
}

/// The softest modes.
#[derive(Debug, Clone, Serialize)]
struct ModesPart {
    /// Ascending, over B/L⁴ of the smallest bending stiffness and the longest rod.
    eigenvalues: Vec<f64>,
    /// \[1/T\], where rods have masses; NaN of an unstable mode.
    #[serde(skip_serializing_if = "Option::is_none")]
    frequencies: Option<Vec<f64>>,
    /// B/L⁴ \[F/L²\].
    unit: f64,
    num_unstable: usize,
    num_zero_energy: usize,
    participation: Vec<Participation>,
}

impl ModesPart {
    fn of(modes: &Modes) -> Self {
        Self {
            eigenvalues: modes.eigenvalues().collect(),
            frequencies: modes.frequencies(),
            unit: modes.unit,
            num_unstable: modes.num_unstable,
            num_zero_energy: modes.num_zero_energy,
            participation: modes.modes.iter().map(|mode| mode.participation).collect(),
        }
    }
}

/// Energies in units of kT, where units are nm and pN.
#[derive(Debug, Clone, Serialize)]
struct Thermal {
    /// K
    temperature: f64,
    /// pN·nm
    #[serde(rename = "kT")]
    thermal_energy: f64,
    /// Energies of every step, in kT.
    energies: Vec<Energies>,
}

#[derive(Debug)]
pub(super) struct SummaryWriter {
    model_hash: String,
    threads: usize,
    /// Temperature, K, and kT at it, pN·nm, where units are nm and pN.
    thermal: Option<(f64, f64)>,
}

impl SummaryWriter {
    pub fn new(scene: &Scene) -> Self {
        Self {
            model_hash: Fingerprint::of(scene).model_hash(),
            threads: scene.solver.threads.unwrap_or_else(all_threads),
            thermal: scene.thermal(),
        }
    }
}

impl Writer for SummaryWriter {
    fn end(&mut self, run: &RecordedRun) -> Result<(), InputError> {
        let path = run.dir.join(files::SUMMARY);
        let (ending, answers) = (&run.ending, &run.ending.answers);
        let thermal = self.thermal.map(|(temperature, thermal_energy)| {
            let energies = run.steps.iter().map(|step| step.energies.over(thermal_energy)).collect();
            Thermal { temperature, thermal_energy, energies }
        });
        let summary = SummaryFile {
            program: env!("CARGO_PKG_VERSION"),
            model_hash: &self.model_hash,
            threads: self.threads,
            title: &run.title,
            units: &run.units,
            rods: &run.rods,
            obstacles: &run.obstacles,
            converged: ending.converged,
            status: &ending.status,
            failure: ending.failure.as_deref(),
            seconds: ending.seconds,
            last: run.steps.last(),
            error_estimate: ending.error_estimate.as_ref(),
            modes: answers.modes.as_ref().map(ModesPart::of),
            harmonic: answers.harmonic.as_ref(),
            sensitivities: &answers.sensitivities,
            table_sensitivities: &answers.tables,
            thermal,
            steps: &run.steps,
        };
        let refuse = |reason: String| InputError::Write { path: path.clone(), reason };
        let text = serde_json::to_string_pretty(&summary).map_err(|e| refuse(e.to_string()))?;
        std::fs::write(&path, text).map_err(|e| refuse(e.to_string()))
    }
}

/// Threads of a run that says nothing about them.
fn all_threads() -> usize {
    if cfg!(feature = "parallel") { std::thread::available_parallelism().map_or(1, usize::from) } else { 1 }
}
