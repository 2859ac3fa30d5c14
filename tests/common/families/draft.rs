//! Scene files put together line by line.

use std::fmt::Write;

use supercoil::math::Vec3;

use super::Random;
use super::material::Material;

/// A number rounded to six digits, as a person would write it.
pub fn short(x: f64) -> f64 {
    format!("{x:.5e}").parse().expect("a number was written")
}

/// A vector as TOML.
pub fn list(v: &Vec3) -> String {
    format!("{:?}", [short(v.x), short(v.y), short(v.z)])
}

/// How the mesh of a scene is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mesh {
    /// By a preset.
    Fidelity(&'static str),
    /// By the distance of nodes over the diameter of the rod.
    Spacing(f64),
}

impl Mesh {
    /// Half of the scenes by a preset, half by numbers of elements.
    pub fn random(random: &mut Random) -> Self {
        match random.below(6) {
            0 => Self::Fidelity("draft"),
            1 | 2 => Self::Fidelity("balanced"),
            _ => Self::Spacing(random.between(0.3, 0.7)),
        }
    }
}

/// Fewest and most cubic elements of a rod whose mesh is given by the distance of nodes.
const ELEMENTS: [f64; 2] = [32.0, 200.0];

/// A scene file being written.
pub struct Draft {
    name: String,
    mesh: Mesh,
    text: String,
    points: Vec<(String, String)>,
}

impl Draft {
    pub fn new(name: &str) -> Self {
        let text = format!("title = \"{name}\"\n");
        Self { name: name.to_owned(), mesh: Mesh::Spacing(0.5), text, points: Vec::new() }
    }

    /// Sets the mesh of all rods. To be called before any of them.
    pub fn mesh(&mut self, mesh: Mesh) {
        self.mesh = mesh;
        if let Mesh::Fidelity(preset) = mesh {
            self.line(&format!("fidelity = \"{preset}\""));
        }
    }

    pub fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    /// A rod of a shape and its length; `more` are further lines of its table.
    pub fn rod(&mut self, name: &str, (shape, length): (&str, f64), material: &Material, more: &[&str]) {
        self.line("[[rods]]");
        self.line(&format!("name = \"{name}\""));
        self.line(&format!("shape = {{ {shape} }}"));
        self.line(&format!("section = {}", material.text()));
        let has_elements = more.iter().any(|line| line.starts_with("elements"));
        if let (Mesh::Spacing(spacing), false) = (self.mesh, has_elements) {
            let elements = (length / (6.0 * spacing * material.radius)).ceil().clamp(ELEMENTS[0], ELEMENTS[1]);
            self.line(&format!("elements = {elements}"));
        }
        more.iter().for_each(|line| self.line(line));
    }

    /// A shape through points, which go to a file of their own.
    pub fn shape_through(&mut self, points: &[Vec3]) -> String {
        let file = format!("{}.csv", self.name);
        let mut text = String::from("x,y,z\n");
        for p in points {
            writeln!(text, "{:.9},{:.9},{:.9}", p.x, p.y, p.z).expect("text takes what it is given");
        }
        let shape = format!("kind = \"points\", file = \"{file}\"");
        self.points.push((file, text));
        shape
    }

    /// A support; `rods` as TOML.
    pub fn support(&mut self, rods: &str, at: &str, position: &str, rotation: &str) {
        self.line("[[supports]]");
        self.line(&format!("rod = {rods}\nat = {at}"));
        if position != "false" {
            self.line(&format!("position = {position}"));
        }
        if rotation != "false" {
            self.line(&format!("rotation = {rotation}"));
        }
    }

    pub fn clamp(&mut self, rods: &str, at: &str) {
        self.support(rods, at, "true", "true");
    }

    pub fn load(&mut self, rod: &str, at: &str, force: &Vec3) {
        self.line(&format!("[[loads]]\nrod = {rod}\nat = {at}\nforce = {}", list(force)));
    }

    pub fn stage(&mut self, ramp: &str, steps: usize) {
        self.line(&format!("[[stages]]\nramp = {{ {ramp} }}\nsteps = {steps}"));
    }

    /// Text of the scene file, and its files of points.
    pub fn finish(mut self) -> (String, Vec<(String, String)>) {
        self.line("[output]\nvtk = false\npicture = false");
        (self.text, self.points)
    }
}
