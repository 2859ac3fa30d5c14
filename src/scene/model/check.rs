//! Conditions for a model and its stages to be a well-posed problem.

use crate::error::InputError;
use crate::math::Vec3;
use crate::rod::{Rod, RodNumber};

use super::{
    ContactLaw, Electrostatics, Joint, JointKind, Model, NodeRef, ObstacleNumber, Pose, Ramp, Stage, SupportChange,
    unit,
};

/// Out-of-plane parts of directions and frames below this (of 1) count as rounding.
const TOL_PLANE: f64 = 1e-9;
/// Largest number of steps of a stage, because smaller fractions would be lost in rounding.
const MOST_STEPS: usize = 1_000_000_000;
/// Largest rotation about an axis through a point, turns; each takes a dozen steps.
const MOST_ROUND: f64 = 1e5;
/// Range of Debye lengths over contact radii. Below it strands touch before they repel each other and quadrature points
/// are many; above it all pairs are within range.
const LEAST_DEBYE: f64 = 0.01;
const MOST_DEBYE: f64 = 100.0;
/// Most pieces of a segment of charged rods, because a pair of segments sums over nine times the square of them: 6 ms a
/// pair at this number.
const MOST_PIECES: f64 = 256.0;
/// Largest distance of joined nodes, over the length of the longer rod.
const TOL_JOINT: f64 = 1e-9;
/// Largest sine of the angle between axes that are one, because axes are given with ten digits.
const TOL_AXIS: f64 = 1e-9;

impl Model {
    /// Refuses a model that is not a well-posed problem; the error names the field, its value and the legal range.
    ///
    /// # Errors
    /// No rods; a rod that fails [`Rod::check`]; references to rods or nodes that do not exist; numbers that are not
    /// finite; an illegal contact choice; joints of nodes that do not coincide, of a node with itself or another of its
    /// element, or of two charged rods; dead loads that do unbounded work on a rod, with those it is
    /// joined to: forces whose sum has a component along an axis in which no support holds it, if no planes carry it,
    /// moments about an axis that its supports leave free; a plane whose normal is not of length 1; an axis that is
    /// zero; a radius that is not positive, or too small for the rods inside; an obstacle which a rod starts beyond; a
    /// planar model that is not planar: rods not in one plane z = const, anisotropic sections not aligned with it,
    /// natural curvature or loads out of it.
    pub fn check(&self) -> Result<(), InputError> {
        if self.rods.is_empty() {
            return Err(InputError::Count { field: "rods".into(), value: 0, allowed: "at least 1" });
        }
        self.rods.iter().try_for_each(Rod::check)?;
        for (i, support) in self.supports.iter().enumerate() {
            self.check_node(&format!("supports[{i}]"), support.node)?;
        }
        for (i, load) in self.loads.iter().enumerate() {
            let field = format!("loads[{i}]");
            self.check_node(&field, load.node)?;
            finite(&format!("{field}.force"), &load.force)?;
            finite(&format!("{field}.moment"), &load.moment)?;
        }
        for (i, load) in self.line_loads.iter().enumerate() {
            let field = format!("line_loads[{i}]");
            self.check_rod(&field, load.rod)?;
            finite(&format!("{field}.force"), &load.force)?;
            finite(&format!("{field}.moment"), &load.moment)?;
        }
        self.check_contact()?;
        self.check_electrostatics()?;
        self.check_obstacles()?;
        self.joints.iter().enumerate().try_for_each(|(i, joint)| self.check_joint(&format!("joints[{i}]"), joint))?;
        self.check_hinges()?;
        if self.planar {
            self.check_planar()?;
        }
        InputError::check("load", self.load, true, "a finite number")?;
        let factors = [Some(1.0), (self.load < 0.0).then_some(self.load)];
        let mut all =
            factors.into_iter().flatten().flat_map(|factor| (0..self.rods.len()).map(move |rod| (rod, factor)));
        all.try_for_each(|(rod, factor)| self.check_carried("", rod, factor))
    }

    /// Refuses stages that this model cannot follow.
    ///
    /// # Errors
    /// All that [`Model::check`] refuses; a stage of no steps, of more than 10⁹, or of neither ramps nor changes of
    /// supports; two ramps of one quantity in a stage; targets that are not finite; the excess link of an open rod or
    /// in a planar model; a rotation of a node whose rotation no support fixes, a displacement, or a way round an axis,
    /// along a component no support fixes; a pose of a node that is not clamped; turns of hinged nodes; an obstacle
    /// that there is not, or a radius that no rod fits in; a load factor without loads, or one that lifts a rod off the
    /// planes that carry it; pressure on anything but a closed rod of a planar model.
    pub fn check_stages(&self, stages: &[Stage]) -> Result<(), InputError> {
        // the checks of ramps assume a sound model
        self.check()?;
        let mut model = std::borrow::Cow::Borrowed(self);
        for (i, stage) in stages.iter().enumerate() {
            if stage.steps == 0 {
                return Err(InputError::Count { field: format!("stages[{i}].steps"), value: 0, allowed: "at least 1" });
            }
            if stage.steps > MOST_STEPS {
                let (field, allowed) = (format!("stages[{i}].steps"), "at most 1000000000");
                return Err(InputError::Count { field, value: stage.steps, allowed });
            }
            if stage.ramps.is_empty() && stage.supports.is_empty() {
                let reason = "nothing to do: ramp at least one of excess_link, link, sigma, rotation, displacement, \
                    pose, load, pressure, plane, obstacle, section, length, natural, or hold or release something";
                return Err(InputError::inconsistent(format!("stages[{i}].ramp"), reason));
            }
            if !stage.supports.is_empty() {
                model.to_mut().check_supports_changed(&format!("stages[{i}]"), &stage.supports)?;
            }
            for (k, ramp) in stage.ramps.iter().enumerate() {
                model.check_ramp(&format!("stages[{i}].ramp"), ramp, &stage.ramps)?;
                if stage.ramps[..k].iter().any(|other| self.is_same_quantity(other, ramp)) {
                    return Err(InputError::inconsistent(
                        format!("stages[{i}].ramp"),
                        "the same quantity is ramped twice",
                    ));
                }
            }
        }
        Ok(())
    }

    /// Changes the supports as a stage does, and refuses rods that it leaves free to move.
    fn check_supports_changed(&mut self, stage: &str, changes: &[SupportChange]) -> Result<(), InputError> {
        for change in changes {
            let (support, word) = match change {
                SupportChange::Hold(support) => (support, "hold"),
                SupportChange::Release(support) => (support, "release"),
            };
            let field = format!("{stage}.{word}");
            self.check_node(&field, support.node)?;
            let before = self.fixed(support.node);
            self.change_supports(std::slice::from_ref(change));
            let after = self.fixed(support.node);
            if after == before {
                let reason = "changes nothing: what is to be held is held already, or what is to be let go is free";
                return Err(InputError::inconsistent(&field, reason));
            }
            let held = |rotation: [bool; 3]| rotation.iter().filter(|held| **held).count();
            if !self.planar && held(after.1) == 1 && after.1 != before.1 {
                let reason = "leaves rotation about one axis held, a joint of constant velocity, which is only for \
                    whole runs: hold all rotations or none, or two";
                return Err(InputError::inconsistent(&field, reason));
            }
            self.check_supports_at_hinges(&field, support.node)?;
        }
        (0..self.rods.len()).try_for_each(|rod| self.check_carried(&format!("{stage}: "), rod, 1.0))
    }

    fn check_ramp(&self, stage: &str, ramp: &Ramp, ramps: &[Ramp]) -> Result<(), InputError> {
        let field = |key: &str| format!("{stage}.{key}");
        match *ramp {
            Ramp::ExcessLink { rod, to } => self.check_wound(&field("excess_link"), rod, to),
            Ramp::Rotation { node, axis, to } => self.check_turned(&field("rotation"), node, &axis, to),
            Ramp::RotationAbout { node, axis, through, to } => {
                self.check_turned(&field("rotation"), node, &axis, to)?;
                self.check_carried_round(&field("rotation"), node, [&axis, &through], to)
            }
            Ramp::Displacement { node, to } => self.check_displaced(&field("displacement"), node, &to),
            Ramp::Pose { node, ref pose } => self.check_pose(&field("pose"), node, pose),
            Ramp::Obstacle { obstacle, which, to } => self.check_moved(&field, obstacle, (which, to)),
            Ramp::Number { rod, which, to } => self.check_number_ramp(&field(which.name()), (rod, which, to), ramps),
            Ramp::Load { to } => self.check_load_factor(&field("load"), to),
            Ramp::Pressure { rod, to } => self.check_inflated(&field("pressure"), rod, to),
        }
    }

    fn check_wound(&self, field: &str, rod: usize, turns: f64) -> Result<(), InputError> {
        self.check_rod(field, rod)?;
        InputError::check(&format!("{field}.to"), turns, true, "a finite number of turns")?;
        self.require(self.rods[rod].closed, field, rod, "is open: only a closed rod has an excess link")?;
        self.require(!self.planar, field, rod, "is in a planar scene: excess link needs space (planar = false)")
    }

    /// Beyond [`Self::check_turned`]: of a node that goes round a line `[axis, through]`.
    fn check_carried_round(
        &self,
        field: &str,
        node: NodeRef,
        [axis, through]: [&Vec3; 2],
        turns: f64,
    ) -> Result<(), InputError> {
        let allowed = "at most 100000 turns about an axis through a point";
        InputError::check(&format!("{field}.turns"), turns, turns.abs() <= MOST_ROUND, allowed)?;
        finite(&format!("{field}.through"), through)?;
        let stands = |k: usize| (0..3).all(|j| j == k || axis[j] == 0.0);
        self.check_position_held(field, node, "is carried round", [0, 1, 2].map(|k| !stands(k)))
    }

    fn check_displaced(&self, field: &str, node: NodeRef, to: &Vec3) -> Result<(), InputError> {
        self.check_node(field, node)?;
        finite(&format!("{field}.to"), to)?;
        self.check_position_held(field, node, "is displaced", [0, 1, 2].map(|k| to[k] != 0.0))
    }

    fn check_moved(
        &self,
        field: &dyn Fn(&str) -> String,
        obstacle: usize,
        (which, to): (ObstacleNumber, f64),
    ) -> Result<(), InputError> {
        let Some(moved) = self.obstacles.get(obstacle) else {
            let allowed = "the index of an obstacle of the model";
            return Err(InputError::Count { field: field("obstacle"), value: obstacle, allowed });
        };
        let [of_plane, of_others] = ["plane", "obstacle"].map(field);
        if moved.carrier.is_some() && which != ObstacleNumber::Level {
            let reason = format!("a node carries \"{}\", and moves it: only its radius is ramped", moved.name);
            return Err(InputError::inconsistent(of_others, reason));
        }
        match which {
            ObstacleNumber::Level if moved.is_plane() => self.check_level(&format!("{of_plane}.to"), moved, to),
            ObstacleNumber::Level => self.check_level(&format!("{of_others}.radius"), moved, to),
            ObstacleNumber::Displacement(k) => {
                let field = format!("{of_others}.displacement");
                InputError::check(&field, to, true, "a finite displacement")?;
                InputError::check(&field, to, !(self.planar && k == 2 && to != 0.0), "0 along z in a planar scene")
            }
            ObstacleNumber::Turns => {
                let field = format!("{of_others}.turns");
                InputError::check(&field, to, true, "a finite number of turns")?;
                let reason = format!("\"{}\" has no hinge to turn about: give it one", moved.name);
                if moved.hinge.is_some() { Ok(()) } else { Err(InputError::inconsistent(field, reason)) }
            }
        }
    }

    fn check_number_ramp(
        &self,
        field: &str,
        (rod, which, to): (usize, RodNumber, f64),
        ramps: &[Ramp],
    ) -> Result<(), InputError> {
        self.check_rod(field, rod)?;
        self.rods[rod].check_number(field, which, to)?;
        let moves_nature = matches!(which, RodNumber::Length | RodNumber::Twist | RodNumber::Binding);
        let winds = ramps.iter().any(|other| matches!(other, Ramp::ExcessLink { rod: it, .. } if *it == rod));
        let reason =
            "has its excess link ramped in the same stage, which length, natural twist and binding change, too";
        self.require(!(moves_nature && winds), field, rod, reason)?;
        let rod = &self.rods[rod];
        let radii = self.rods.iter().map(Rod::least_contact_radius).filter(|radius| *radius > 0.0);
        let least = radii.fold(f64::INFINITY, f64::min);
        match which {
            RodNumber::Length => self.check_pieces(field, rod, rod.spacing() * to / rod.length, least),
            RodNumber::ContactRadius => self.check_pieces(field, rod, rod.spacing(), least.min(to)),
            _ => Ok(()),
        }
    }

    fn check_load_factor(&self, field: &str, factor: f64) -> Result<(), InputError> {
        InputError::check(field, factor, true, "a finite number")?;
        if self.loads.is_empty() && self.line_loads.is_empty() {
            return Err(InputError::inconsistent(field, "there are no loads to ramp: add loads or line_loads"));
        }
        (0..self.rods.len()).try_for_each(|rod| self.check_carried(&format!("{field} = {factor}: "), rod, factor))
    }

    fn check_inflated(&self, field: &str, rod: usize, pressure: f64) -> Result<(), InputError> {
        self.check_rod(field, rod)?;
        InputError::check(&format!("{field}.to"), pressure, true, "a finite number")?;
        let ok = self.planar && self.rods[rod].closed;
        self.require(ok, field, rod, "is not a closed rod of a planar scene, the only kind that takes pressure")
    }

    fn check_turned(&self, field: &str, node: NodeRef, axis: &Vec3, turns: f64) -> Result<(), InputError> {
        self.check_node(field, node)?;
        InputError::check(&format!("{field}.turns"), turns, true, "a finite number of turns")?;
        self.check_axis(field, axis)?;
        self.check_not_hinged(field, node)?;
        let reason = "has no support that fixes its rotation at this node: add one with rotation = true";
        self.require(self.fixed(node).1 == [true; 3], field, node.rod, reason)
    }

    fn check_pose(&self, field: &str, node: NodeRef, pose: &Pose) -> Result<(), InputError> {
        self.check_node(field, node)?;
        let rod = &self.rods[node.rod];
        if (pose.position, pose.frame, pose.turns) == (None, None, None) {
            return Err(InputError::inconsistent(field, "goes nowhere: give a position, a rotation, or both"));
        }
        if let Some(position) = pose.position {
            finite(&format!("{field}.position"), &position)?;
        }
        if let Some(frame) = pose.frame.filter(|frame| !frame.coords.iter().all(|x| x.is_finite())) {
            let (field, value) = (format!("{field}.frame"), frame.imag().into());
            return Err(InputError::Vector { field, value, allowed: "a rotation" });
        }
        if let Some(turns) = pose.turns {
            let field = format!("{field}.extra_turns");
            let whole = turns.fract() == 0.0 && turns.abs() <= MOST_ROUND;
            InputError::check(&field, turns, whole, "a whole number of turns, at most 100000")?;
            let reason = "is closed: put turns into it by excess_link";
            self.require(!rod.closed, &field, node.rod, reason)?;
            let reason =
                "is joined to another rod at this node, which has another tangent: turn it by a stage of its own";
            self.require(self.turning_nodes(node).len() == 1, &field, node.rod, reason)?;
        }
        self.check_not_hinged(field, node)?;
        let reason = "is not clamped at this node: add a support with position = true and rotation = true";
        self.require(self.fixed(node) == ([true; 3], [true; 3]), field, node.rod, reason)?;
        self.check_pose_in_plane(field, node, pose)
    }

    fn check_pose_in_plane(&self, field: &str, node: NodeRef, pose: &Pose) -> Result<(), InputError> {
        let rod = &self.rods[node.rod];
        let stays = pose.position.is_none_or(|to| to.z == rod.positions[node.node].z);
        let turn = pose.frame.map_or(Vec3::zeros(), |to| (to * rod.frames[node.node].inverse()).imag());
        let ok = !self.planar || (stays && turn.xy().norm() <= TOL_PLANE && pose.turns.is_none());
        let reason = "is in a planar scene: it stays in its plane, turns about z and has no extra_turns";
        self.require(ok, field, node.rod, reason)
    }

    /// Refuses a motion of a node along axes in which no support fixes it, or out of the plane.
    fn check_position_held(&self, field: &str, node: NodeRef, what: &str, moved: [bool; 3]) -> Result<(), InputError> {
        let fixed = self.fixed(node).0;
        let held = (0..3).all(|k| !moved[k] || fixed[k]) && !(self.planar && moved[2]);
        let reason = format!("{what} in a direction that no support fixes at this node: add one with position = true");
        self.require(held, field, node.rod, &reason)
    }

    /// Refuses to turn a node with a hinge: what turns about its axis is not said.
    fn check_not_hinged(&self, field: &str, node: NodeRef) -> Result<(), InputError> {
        let turns_as_one = self.hinged_nodes(node).len() == self.turning_nodes(node).len();
        self.require(turns_as_one, field, node.rod, "is hinged to another rod at this node: hinges cannot be turned")
    }

    /// Whether two ramps move the same quantity; joined nodes are one.
    fn is_same_quantity(&self, a: &Ramp, b: &Ramp) -> bool {
        match (a, b) {
            (Ramp::ExcessLink { rod: a, .. }, Ramp::ExcessLink { rod: b, .. })
            | (Ramp::Pressure { rod: a, .. }, Ramp::Pressure { rod: b, .. }) => a == b,
            (
                Ramp::Displacement { node: a, .. } | Ramp::Pose { node: a, .. },
                Ramp::Displacement { node: b, .. } | Ramp::Pose { node: b, .. },
            )
            | (
                Ramp::RotationAbout { node: a, .. } | Ramp::Pose { node: a, .. },
                Ramp::RotationAbout { node: b, .. } | Ramp::Pose { node: b, .. },
            ) => self.joined_nodes(*a).contains(b),
            (
                Ramp::Rotation { node: a, .. } | Ramp::RotationAbout { node: a, .. } | Ramp::Pose { node: a, .. },
                Ramp::Rotation { node: b, .. } | Ramp::RotationAbout { node: b, .. } | Ramp::Pose { node: b, .. },
            ) => self.turning_nodes(*a).contains(b),
            (Ramp::Load { .. }, Ramp::Load { .. }) => true,
            (Ramp::Obstacle { obstacle: a, which: x, .. }, Ramp::Obstacle { obstacle: b, which: y, .. }) => {
                (a, x) == (b, y)
            }
            (Ramp::Number { rod: a, which: x, .. }, Ramp::Number { rod: b, which: y, .. }) => (a, x) == (b, y),
            _ => false,
        }
    }

    fn check_axis(&self, field: &str, axis: &Vec3) -> Result<(), InputError> {
        let (size, in_plane) = (axis.amax(), axis.xy().amax());
        let allowed = if self.planar { "along z in a planar scene" } else { "finite and not zero" };
        if axis.iter().all(|x| x.is_finite()) && size > 0.0 && !(self.planar && in_plane > 0.0) {
            return Ok(());
        }
        Err(InputError::Vector { field: format!("{field}.axis"), value: (*axis).into(), allowed })
    }

    fn require(&self, ok: bool, field: &str, rod: usize, reason: &str) -> Result<(), InputError> {
        if ok {
            Ok(())
        } else {
            Err(InputError::inconsistent(field, format!("rod \"{}\" {reason}", self.rods[rod].name)))
        }
    }

    fn check_rod(&self, field: &str, rod: usize) -> Result<(), InputError> {
        if rod < self.rods.len() {
            return Ok(());
        }
        Err(InputError::Count { field: format!("{field}.rod"), value: rod, allowed: "the index of a rod of the model" })
    }

    fn check_node(&self, field: &str, node: NodeRef) -> Result<(), InputError> {
        self.check_rod(field, node.rod)?;
        if node.node < self.rods[node.rod].num_nodes() {
            return Ok(());
        }
        let allowed = "the index of a node of the rod (elements × order of them, one more if open)";
        Err(InputError::Count { field: format!("{field}.node"), value: node.node, allowed })
    }

    fn check_joint(&self, field: &str, joint: &super::Joint) -> Result<(), InputError> {
        let nodes = [joint.a, joint.b];
        nodes.iter().try_for_each(|&node| self.check_node(field, node))?;
        let [a, b] = nodes.map(|node| &self.rods[node.rod]);
        let apart = (a.positions[joint.a.node] - b.positions[joint.b.node]).norm();
        if apart > TOL_JOINT * a.length.max(b.length) {
            return Err(InputError::inconsistent(
                field,
                format!("joins nodes that are {apart} apart: they must coincide"),
            ));
        }
        if joint.a.rod == joint.b.rod {
            if joint.a == joint.b {
                return Err(InputError::inconsistent(field, "joins a node to itself"));
            }
            let between = joint.a.node.abs_diff(joint.b.node);
            let around = if a.closed { a.num_nodes() - between } else { between };
            if between.min(around) <= a.order {
                return Err(InputError::inconsistent(field, "joins nodes of one element"));
            }
        }
        if self.is_touchable(a) && self.is_touchable(b) && self.electrostatics.is_some() {
            let reason =
                "joins two charged rods, which would repel each other at the joint: give one a contact_radius of 0";
            return Err(InputError::inconsistent(field, reason));
        }
        Ok(())
    }

    /// Refuses axes that are none, hinges about several axes at one point, and supports there that hold some rotations
    /// only.
    fn check_hinges(&self) -> Result<(), InputError> {
        let axis = |joint: &Joint| if let JointKind::Hinge { axis } = joint.kind { Some(axis) } else { None };
        for (i, joint) in self.joints.iter().enumerate() {
            let Some(own) = axis(joint) else { continue };
            let field = format!("joints[{i}]");
            self.check_axis(&field, &own)?;
            let here = self.hinged_nodes(joint.a);
            let is_here = |other: &&Joint| here.contains(&other.a);
            let is_apart = |other: Vec3| unit(&other).cross(&unit(&own)).norm() > TOL_AXIS;
            if self.joints[..i].iter().filter(is_here).filter_map(axis).any(is_apart) {
                let reason = "is not parallel to that of another hinge at this point: hinges that meet at one point \
                    share one axis; put them at different nodes";
                return Err(InputError::inconsistent(format!("{field}.axis"), reason));
            }
            here.iter().try_for_each(|node| self.check_supports_at_hinges(&field, *node))?;
        }
        Ok(())
    }

    fn check_supports_at_hinges(&self, field: &str, node: NodeRef) -> Result<(), InputError> {
        let is_hinge = |other: &NodeRef| {
            self.joints.iter().any(|joint| self.hinge_axis(joint).is_some() && [joint.a, joint.b].contains(other))
        };
        let count = self.fixed(node).1.iter().filter(|held| **held).count();
        let whole = self.planar || count == 0 || count == 3 || !self.hinged_nodes(node).iter().any(is_hinge);
        let reason = format!(
            "is at a hinge, and its supports hold {count} of three rotations at node {}: hold all of them or none",
            node.node
        );
        self.require(whole, field, node.rod, &reason)
    }

    fn check_electrostatics(&self) -> Result<(), InputError> {
        let Some(Electrostatics { strength, debye_length }) = self.electrostatics else { return Ok(()) };
        InputError::positive("electrostatics.strength", strength)?;
        InputError::positive("electrostatics.debye_length", debye_length)?;
        let radii = self.rods.iter().map(Rod::least_contact_radius).filter(|radius| *radius > 0.0);
        let radius = radii.fold(f64::INFINITY, f64::min);
        if !self.contact.law.is_on() || radius.is_infinite() {
            let reason = "charged rods need contact: without it strands could pass through each other";
            return Err(InputError::inconsistent("electrostatics", reason));
        }
        let (least, most) = (LEAST_DEBYE * radius, MOST_DEBYE * radius);
        let allowed = "between .01 and 100 contact radii";
        let fits = (least..=most).contains(&debye_length);
        InputError::check("electrostatics.debye_length", debye_length, fits, allowed)?;
        self.rods
            .iter()
            .filter(|rod| self.is_touchable(rod))
            .try_for_each(|rod| self.check_pieces("electrostatics.debye_length", rod, rod.spacing(), radius))
    }

    /// Refuses charged rods whose nodes are so far apart, against the Debye length and the smallest contact radius,
    /// that the sum over points of a pair of segments would not end.
    fn check_pieces(&self, field: &str, rod: &Rod, spacing: f64, least_radius: f64) -> Result<(), InputError> {
        let Some(charges) = self.electrostatics else { return Ok(()) };
        let (pieces, debye_length) = ((spacing / charges.piece(least_radius)).ceil(), charges.debye_length);
        if pieces <= MOST_PIECES {
            return Ok(());
        }
        let needed = (rod.num_elements as f64 * pieces / MOST_PIECES).ceil();
        let reason = format!(
            "rod \"{}\" has nodes {spacing:.4} apart, which a Debye length of {debye_length} and a contact radius of \
             {least_radius} divide into {pieces} pieces, at most {MOST_PIECES} are summed over: {needed} elements \
             would do",
            rod.name
        );
        Err(InputError::inconsistent(field, reason))
    }

    fn check_contact(&self) -> Result<(), InputError> {
        match self.contact.law {
            ContactLaw::None => Ok(()),
            ContactLaw::Penalty { stiffness } => InputError::positive("contact.stiffness", stiffness),
            ContactLaw::AugmentedLagrangian { stiffness, tol_penetration: tol } => {
                InputError::positive("contact.stiffness", stiffness)?;
                check_penetration(tol)
            }
            ContactLaw::ByMesh { least, tol_penetration } => {
                InputError::positive("contact.stiffness", least)?;
                check_penetration(tol_penetration)
            }
        }
    }

    fn check_planar(&self) -> Result<(), InputError> {
        let plane = self.rods[0].positions[0].z;
        for rod in &self.rods {
            let refuse = |node: usize, what: &str| {
                let reason = format!("planar = true, but {what} at node {node}");
                Err(InputError::inconsistent(format!("rods.{}", rod.name), reason))
            };
            if rod.stiffness.is_some() {
                return refuse(0, "the full stiffness may couple bending in the plane with that out of it: found");
            }
            for (i, (position, frame)) in rod.positions.iter().zip(&rod.frames).enumerate() {
                if (position.z - plane).abs() > TOL_PLANE * rod.length {
                    return refuse(i, &format!("z = {} is not {plane}", position.z));
                }
                if (frame * Vec3::z()).z.abs() > TOL_PLANE {
                    return refuse(i, "the tangent leaves the x-y plane");
                }
                let d1_z = (frame * Vec3::x()).z.abs();
                if !rod.section.is_isotropic() && d1_z.min(1.0 - d1_z) > TOL_PLANE {
                    return refuse(i, "neither d1 nor d2 of the anisotropic section is normal to the plane");
                }
                if let Some([g1, g2, g3, k1, k2, k3]) = rod.natural.at(rod.arc_of_node(i)) {
                    let (natural, along) = (frame * Vec3::new(k1, k2, k3), frame * Vec3::new(g1, g2, g3));
                    if natural.xy().norm() > TOL_PLANE * natural.norm() || along.z.abs() > TOL_PLANE {
                        return refuse(i, "the natural curvature, twist or shear turns out of the x-y plane");
                    }
                }
            }
        }
        let in_plane = |field: String, force: &Vec3, moment: &Vec3| {
            let ok = force.z == 0.0 && moment.xy() == Vec3::zeros().xy();
            let reason = "planar = true: forces act in the x-y plane, moments about z";
            if ok { Ok(()) } else { Err(InputError::inconsistent(&field, reason)) }
        };
        for (i, load) in self.loads.iter().enumerate() {
            in_plane(format!("loads[{i}]"), &load.force, &load.moment)?;
        }
        for (i, load) in self.line_loads.iter().enumerate() {
            in_plane(format!("line_loads[{i}]"), &load.force, &load.moment)?;
        }
        Ok(())
    }
}

fn finite(field: &str, value: &Vec3) -> Result<(), InputError> {
    if value.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(InputError::Vector { field: field.into(), value: (*value).into(), allowed: "three finite numbers" })
}

fn check_penetration(tol: f64) -> Result<(), InputError> {
    InputError::check("contact.tol_penetration", tol, tol > 0.0 && tol < 1.0, "between 0 and 1")
}

#[cfg(test)]
mod tests;
