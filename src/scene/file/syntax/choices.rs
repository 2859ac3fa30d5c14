//! Settings of a scene that are no part of the problem: solver, outputs, pictures, the path that is followed.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::scene::model::unit;

/// Solver settings of a scene. `None` leaves the solver's default.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverChoice {
    /// Tolerance of convergence: a full Newton step moves no node by more than this × node spacing and turns none by
    /// more (rad). Legal: between 0 and 1.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1, "x-default" = "1e-8, or by `fidelity`"))]
    pub tol_increment: Option<f64>,
    /// Largest number of Newton iterations in a row that lead nowhere: no node goes farther than the node spacing, nor
    /// turns by more than 1 rad, while the energy falls. With moments in space, of all iterations. Legal: ≥ 1.
    #[schemars(extend("minimum" = 1, "x-default" = "500"))]
    pub max_iterations: Option<usize>,
    /// Number of threads; results do not depend on it. Legal: 1 to [`MOST_THREADS`].
    #[schemars(extend("minimum" = 1, "maximum" = MOST_THREADS, "x-default" = "all"))]
    pub threads: Option<usize>,
}

/// Largest number of threads of a run, more than machines have cores.
pub const MOST_THREADS: usize = 1024;

/// Outputs of a run.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputChoice {
    /// Number of accepted steps from one VTK file to the next (the first and the last step always have one). Legal: ≥
    /// 1.
    #[schemars(extend("minimum" = 1))]
    pub every: usize,
    /// Whether VTK files for ParaView are written.
    pub vtk: bool,
    /// VTK: number of nodes from one written node to the next (the last is always written); with `node_tolerance` the
    /// largest such number. Legal: ≥ 1.
    #[schemars(extend("minimum" = 1))]
    pub node_every: usize,
    /// VTK: distance from the drawn line within which nodes are left out, L. Legal: ≥ 0.
    #[schemars(extend("x-unit" = "L", "minimum" = 0))]
    pub node_tolerance: Option<f64>,
    /// Whether pictures are drawn.
    pub picture: bool,
    /// Whether `view.html` is written: the steps that have a VTK file, to turn and to step through in a browser.
    #[schemars(extend("x-allowed" = "needs `vtk`"))]
    pub view: bool,
    /// Number of accepted steps from one checkpoint to the next. Legal: ≥ 1.
    #[schemars(extend("minimum" = 1, "x-default" = "by time only"))]
    pub checkpoint_steps: Option<usize>,
    /// Time from one checkpoint to the next, s; 0: after every step. Legal: ≥ 0, infinite: never.
    #[schemars(extend("x-unit" = "s", "minimum" = 0))]
    pub checkpoint_seconds: f64,
    /// Whether the error of the final state is estimated, see `observe::estimate_error` in the library.
    pub error_estimate: bool,
    /// Number of softest modes of the final state, see `tangent::EquilibriumTangent::modes` in the library: `modes.vtp`
    /// and `modes.html` have their shapes, `summary.json` their eigenvalues, or frequencies if all rods have a mass.
    pub modes: usize,
    /// Whether `summary.json` has the parts of the harmonic free energy of the final state.
    pub free_energy: bool,
    /// Observables of the final state that are differentiated: `energy`, `contact_force`, `twist`, `writhe`,
    /// `extension`, `seam_moment`, of the first rod or (`writhe:NAME`) of another; `position_x:NAME:NODE`,
    /// `force_z:NAME:end` …; see `tangent::Observable` in the library.
    pub sensitivity_of: Vec<String>,
    /// What they are differentiated with respect to: `load`, `link`, `pressure`, `bending`, `twisting`, `stretching`,
    /// `shearing`, `contact_radius`, `length`, `natural_twist`, `natural_strains` (rows of a table or a sequence) …, of
    /// the first rod or (`bending:NAME`) of another; `displacement_x:NAME:end`, `obstacle_level` …; see
    /// `tangent::PrescribedNumber` in the library.
    pub sensitivity_to: Vec<String>,
    /// Folder of the files, relative to where the program runs; the command line's `--out` takes precedence.
    #[schemars(extend("x-default" = "out/NAME"))]
    pub dir: Option<PathBuf>,
}

/// Following of a path through limit points, where load steps would jump, see `solve::FollowOptions` in the library.
/// Arc lengths count relative changes: 1 is about the way of the ramp.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FollowChoice {
    /// Initial direction: towards the ramp's target or away from it; at a branch point onto the branch, along the
    /// critical direction or against it.
    pub start: FollowStart,
    /// First step, arc length. Legal: > 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step: f64,
    /// Longest step, arc length. Legal: ≥ `step`.
    #[schemars(extend("x-allowed" = "at least `step`"))]
    pub max_step: f64,
    /// Largest number of points of the path. Legal: ≥ 1.
    #[schemars(extend("minimum" = 1))]
    pub max_points: usize,
}

/// Initial direction of a path.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FollowStart {
    /// Towards the ramp's target.
    #[default]
    Towards,
    /// Away from it.
    Away,
    /// At a branch point: onto the branch, along the critical direction.
    Branch,
    /// At a branch point: onto the branch, against the critical direction.
    OtherBranch,
}

impl Default for FollowChoice {
    fn default() -> Self {
        Self { start: FollowStart::Towards, step: 0.05, max_step: 0.2, max_points: 500 }
    }
}

impl FollowChoice {
    pub(in crate::scene::file) fn check(&self) -> Result<(), InputError> {
        InputError::positive("follow.step", self.step)?;
        InputError::check("follow.max_step", self.max_step, self.max_step >= self.step, "at least step")?;
        if self.max_points == 0 {
            return Err(InputError::Count { field: "follow.max_points".into(), value: 0, allowed: "at least 1" });
        }
        Ok(())
    }
}

/// Settings of pictures.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PictureChoice {
    /// Width and height of `picture.png`, pixels. Legal: 16 to 8000. `None`: 1600 wide and as high as the rods need,
    /// 320 to 1200.
    #[schemars(extend("x-value" = "[width, height]", "x-unit" = "pixels", "x-allowed" = "16 to 8000",
        "x-default" = "1600 wide, as high as the rods need, up to 1200"))]
    pub size: Option<[usize; 2]>,
    /// Direction from the rods to the eye, one for all states of a film strip. Legal: not zero. `None`: from where no
    /// state drawn is seen edge-on, with planes a little above the first.
    #[schemars(extend("x-allowed" = "not zero",
        "x-default" = "from where no state drawn is seen edge-on; with planes a little above the first"))]
    pub camera: Option<[f64; 3]>,
    /// Direction that appears upwards. Legal: not along `camera`. `None`: the one with the widest final state; with a
    /// `camera`, z or else y.
    #[schemars(extend("x-allowed" = "with `camera`; not along it", "x-default" = "z, or y"))]
    pub up: Option<[f64; 3]>,
    /// Quantity that colours the rods; all but `strand` have a colour bar. Pressure is contact force per length,
    /// smoothed over the width of the contact law or half an element.
    pub color_by: ColorBy,
    /// Whether `picture.png` has no background.
    pub transparent: bool,
    /// Whether a bar that shows a length is drawn.
    pub scale_bar: bool,
}

/// Quantity that colours the rods.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ColorBy {
    /// One colour for each rod.
    #[default]
    Strand,
    /// Contact force per length.
    Pressure,
    /// Curvature.
    Curvature,
    /// Twist a length.
    #[serde(rename = "twist_rate")]
    TwistRate,
}

impl PictureChoice {
    pub(in crate::scene::file) fn check(&self) -> Result<(), InputError> {
        let fits = |pixels: &usize| (16..=8000).contains(pixels);
        if let Some(&value) = self.size.iter().flatten().find(|pixels| !fits(pixels)) {
            return Err(InputError::Count {
                field: "picture.size".into(),
                value,
                allowed: "between 16 and 8000 pixels",
            });
        }
        for (field, vector) in [("picture.camera", self.camera), ("picture.up", self.up)] {
            let ok = |v: [f64; 3]| v.iter().all(|x| x.is_finite()) && v != [0.0; 3];
            if let Some(value) = vector.filter(|v| !ok(*v)) {
                return Err(InputError::Vector { field: field.to_owned(), value, allowed: "finite and not zero" });
            }
        }
        match (self.camera, self.up) {
            (None, Some(value)) => {
                Err(InputError::Vector { field: "picture.up".into(), value, allowed: "with a camera only" })
            }
            (Some(camera), Some(up)) if aligned(camera, up) => {
                Err(InputError::Vector { field: "picture.up".into(), value: up, allowed: "not along camera" })
            }
            _ => Ok(()),
        }
    }
}

/// Whether two directions are parallel or antiparallel.
fn aligned(a: [f64; 3], b: [f64; 3]) -> bool {
    let [a, b] = [a, b].map(|v| unit(&v.into()));
    a.cross(&b).norm() < 1e-6
}

impl Default for OutputChoice {
    fn default() -> Self {
        Self {
            every: 1,
            vtk: true,
            node_every: 1,
            node_tolerance: None,
            picture: true,
            view: true,
            checkpoint_steps: None,
            checkpoint_seconds: 60.0,
            error_estimate: false,
            modes: 0,
            free_energy: false,
            sensitivity_of: Vec::new(),
            sensitivity_to: Vec::new(),
            dir: None,
        }
    }
}

/// Refuses settings of solver and outputs that are out of their range.
pub(super) fn check_choices(solver: &SolverChoice, output: &OutputChoice) -> Result<(), InputError> {
    if let Some(tol) = solver.tol_increment {
        InputError::check("solver.tol_increment", tol, tol > 0.0 && tol < 1.0, "between 0 and 1")?;
    }
    if let Some(tolerance) = output.node_tolerance {
        InputError::check("output.node_tolerance", tolerance, tolerance >= 0.0, "finite and at least 0")?;
    }
    if output.dir.as_ref().is_some_and(|dir| dir.as_os_str().is_empty()) {
        let (field, allowed) = ("output.dir".to_owned(), "the name of a folder (\".\" is this one)".to_owned());
        return Err(InputError::Name { field, name: String::new(), allowed });
    }
    let seconds = output.checkpoint_seconds;
    if seconds.is_nan() || seconds < 0.0 {
        let field = "output.checkpoint_seconds".to_owned();
        return Err(InputError::Value { field, value: seconds, allowed: "at least 0 s, or inf" });
    }
    if let Some(value) = solver.threads.filter(|&threads| threads > MOST_THREADS) {
        let field = "solver.threads".to_owned();
        return Err(InputError::Count { field, value, allowed: "between 1 and 1024" });
    }
    let counts = [
        ("solver.max_iterations", solver.max_iterations),
        ("solver.threads", solver.threads),
        ("output.every", Some(output.every)),
        ("output.node_every", Some(output.node_every)),
        ("output.checkpoint_steps", output.checkpoint_steps),
    ];
    match counts.into_iter().find(|(_, count)| *count == Some(0)) {
        Some((field, _)) => Err(InputError::Count { field: field.into(), value: 0, allowed: "at least 1" }),
        None => Ok(()),
    }
}
