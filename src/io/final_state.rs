//! The final state of a run, from its folder: for commands that ask more of it without another run.

use std::path::Path;

use super::checkpoint::{Checkpoint, FILE_NAME};
use super::record::FINAL_STATE_BITS;
use super::run::{options, scene_of};
use crate::error::InputError;
use crate::scene::Scene;
use crate::solve::{RunError, Solver, solver_at};

/// A scene, and a solver in the last state that its run reached.
#[derive(Debug)]
pub struct FinalState {
    /// The scene.
    pub scene: Scene,
    /// The solver; nothing was searched for.
    pub solver: Solver,
}

impl FinalState {
    /// Of the run in the folder `dir`: its end, or of a run that was stopped its last checkpoint. The scene is read
    /// from its own file, or from `scene` where that has moved.
    ///
    /// # Errors
    /// A folder without a final state; a scene that is not that of the run; as [`Solver::new`].
    pub fn read(dir: &Path, scene: Option<&Path>) -> Result<Self, RunError> {
        let files = [FINAL_STATE_BITS, FILE_NAME].map(|name| dir.join(name));
        let found = files.iter().find(|file| file.exists());
        let reason = || {
            format!(
                "has no final state: there is neither {FINAL_STATE_BITS} nor {FILE_NAME} in it. Give the folder of a \
                 run"
            )
        };
        let file = found.ok_or_else(|| InputError::File { path: dir.to_owned(), reason: reason() })?;
        let checkpoint = Checkpoint::read(file)?;
        let scene = match scene {
            Some(file) => Scene::read_with(file, &checkpoint.set)?,
            None => scene_of(&checkpoint)?,
        };
        checkpoint.check_scene(&scene)?;
        let solver = solver_at(scene.model.clone(), &scene.stages, &options(&scene), checkpoint.restart)?;
        Ok(Self { scene, solver })
    }

    /// kT at the scene's temperature, or the one given \[F·L\].
    ///
    /// # Errors
    /// None given where units are not nm and pN; one that is not positive.
    pub fn thermal_energy(&self, given: Option<f64>) -> Result<f64, InputError> {
        let known = given.or_else(|| self.scene.thermal().map(|(_, thermal_energy)| thermal_energy));
        let unknown = || InputError::inconsistent("kT", "is not known, because units are not nm and pN: give it");
        let thermal_energy = known.ok_or_else(unknown)?;
        InputError::positive("kT", thermal_energy)?;
        Ok(thermal_energy)
    }
}
