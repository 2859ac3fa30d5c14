//! A scene file for a set of features, with random sizes: the same for the same features and index.
//!
//! Loads bend rods by some tens of degrees and stay below what buckles them, so that most scenes have one state only.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use supercoil::InputError;
use supercoil::dna::sequence::{Sequence, Steps};
use supercoil::math::Vec3;
use supercoil::scene::Scene;

use super::super::random::Random;
use super::axes::{Features, has, words};

/// Letters of the sequences: 2 turns of the double helix open, 4 closed.
const LETTERS: &str = "GATTACAGGCTTAACCGATCGTATGCCAAGTTCGATACGGCT";

/// How finely a scene is meshed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mesh {
    /// By so many times the elements of the scene.
    Times(usize),
    /// By a preset.
    Fidelity(&'static str),
}

/// A scene of the relations.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// Three digits.
    pub name: String,
    pub features: Features,
    index: u64,
}

impl Draft {
    pub fn new(index: usize, features: Features) -> Self {
        Self { name: format!("{index:03}"), features, index: index as u64 }
    }

    pub fn has(&self, word: &str) -> bool {
        has(&self.features, word)
    }

    /// Whether nothing holds the first rod in its place, in the end at least.
    pub fn floats(&self) -> bool {
        self.has("unsupported") || (self.has("clamp") && self.has("release"))
    }

    /// Name and features on a line.
    pub fn title(&self) -> String {
        format!("{}: {}", self.name, words(&self.features).join(", "))
    }

    /// Writes the scene file, and the tables that it names, to a folder of its own below `dir`.
    pub fn write(&self, dir: &Path, mesh: Mesh) -> Result<PathBuf, InputError> {
        let folder = dir.join(&self.name);
        let refuse = |error: std::io::Error| InputError::File { path: folder.clone(), reason: error.to_string() };
        std::fs::create_dir_all(&folder).map_err(refuse)?;
        let begun = |mesh: Mesh| {
            let mut writer = Writer::new(self, mesh);
            if self.has("shaped") {
                writer.measure(&folder)?;
            }
            writer.first_rod();
            let scene = writer.read(&folder)?;
            Ok::<_, InputError>((writer, scene))
        };
        // where other rods and the floor begin follows from one mesh, so that scenes on any mesh are the same
        let (_, plain) = begun(Mesh::Times(1))?;
        let (mut writer, own) = begun(mesh)?;
        writer.place(&plain);
        writer.nodes.clone_from(&own.model.rods[0].positions);
        writer.other_rods();
        writer.supports();
        writer.loads();
        writer.stages();
        let path = folder.join("scene.toml");
        writer.save(&path).map_err(refuse)?;
        Ok(path)
    }

    /// The scene, read from its file.
    pub fn scene(&self, dir: &Path, mesh: Mesh) -> Result<Scene, InputError> {
        Scene::read(&self.write(dir, mesh)?)
    }
}

/// Sizes and text of a scene.
struct Writer<'a> {
    draft: &'a Draft,
    mesh: Mesh,
    random: Random,
    text: String,
    tables: Vec<(&'static str, String)>,
    /// Size of the shape of the first rod, its length unless that follows from points.
    size: f64,
    /// Length, bending stiffness, contact radius of the first rod.
    length: f64,
    bending: f64,
    radius: f64,
    letters: &'static str,
    /// Unit of forces: a load of it bends the rod by about half a radian.
    force: f64,
    down: Vec3,
    /// Nodes of the first rod.
    nodes: Vec<Vec3>,
    lowest: f64,
    /// Point of the first rod that the crossing rod passes, the tangent there, and the direction from it to the other.
    crossing: [Vec3; 3],
}

fn list(v: &Vec3) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x + 0.0, v.y + 0.0, v.z + 0.0)
}

/// A number of four digits.
fn short(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

impl<'a> Writer<'a> {
    fn new(draft: &'a Draft, mesh: Mesh) -> Self {
        let mut random = Random::of(77, draft.index);
        let closed = draft.has("closed");
        let mut length = short(if closed { random.between(1.8, 2.4) } else { random.between(0.8, 1.2) });
        let mut bending = short(random.between(0.7, 1.5));
        let letters = if closed { LETTERS } else { &LETTERS[..21] };
        if draft.has("sequence") {
            length = helix_length(letters, closed);
            bending = 200.0;
        }
        let radius = short(length * if closed { 0.012 } else { 0.025 } * random.between(0.8, 1.2));
        // a ring is stiffer than a rod of its length
        let stiff = if closed { 8.0 } else { 1.6 };
        let force = stiff * bending / length.powi(2) * random.between(0.8, 1.2);
        let down = if draft.has("planar") { -Vec3::y() } else { -Vec3::z() };
        let text = format!("title = \"{}\"\n", draft.title());
        let (lowest, nodes, crossing) = (0.0, Vec::new(), [Vec3::zeros(); 3]);
        let tables = Vec::new();
        let size = length;
        Self {
            draft,
            mesh,
            random,
            text,
            tables,
            size,
            length,
            bending,
            radius,
            letters,
            force,
            down,
            nodes,
            lowest,
            crossing,
        }
    }

    fn has(&self, word: &str) -> bool {
        self.draft.has(word)
    }

    fn line(&mut self, text: &str) {
        let _ = writeln!(self.text, "{text}");
    }

    fn save(&self, path: &Path) -> std::io::Result<()> {
        for (file, table) in &self.tables {
            std::fs::write(path.with_file_name(file), table)?;
        }
        std::fs::write(path, &self.text)
    }

    /// The scene as far as it is written.
    fn read(&self, folder: &Path) -> Result<Scene, InputError> {
        let path = folder.join("first_rod.toml");
        self.save(&path).map_err(|error| InputError::File { path: path.clone(), reason: error.to_string() })?;
        Scene::read(&path)
    }

    /// Takes the length of a rod through points from the curve through them.
    fn measure(&mut self, folder: &Path) -> Result<(), InputError> {
        let head = self.text.clone();
        let shape = self.shape();
        let section = "section = { bending = 1, twisting = 1, stretching = 1, shearing = 1, contact_radius = 0 }";
        let closed = self.has("closed");
        self.line(&format!("[[rods]]\n{shape}\n{section}\nclosed = {closed}\nelements = 16"));
        self.length = self.read(folder)?.model.rods[0].length;
        self.text = head;
        self.tables.clear();
        Ok(())
    }

    /// An element for each step of the sequence of an open rod, because natural strains jump from step to step.
    fn element_each(&self) -> String {
        let Mesh::Times(times) = self.mesh else { return String::new() };
        format!("elements = {}\norder = {}", times * (self.letters.len() - 1), self.order())
    }

    fn order(&self) -> usize {
        ["linear", "quadratic", "cubic"].iter().position(|order| self.has(order)).unwrap_or(2) + 1
    }

    /// Elements for so many of them in a cubic mesh.
    fn elements(&self, cubic: usize) -> String {
        let Mesh::Times(times) = self.mesh else { return String::new() };
        let order = self.order();
        // as many nodes for any order
        let elements = times * 3 * cubic / order;
        format!("elements = {elements}\norder = {order}")
    }

    fn first_rod(&mut self) {
        if let Mesh::Fidelity(preset) = self.mesh {
            self.line(&format!("fidelity = \"{preset}\""));
        }
        if self.has("planar") {
            self.line("planar = true");
        }
        self.contact();
        self.line("[[rods]]\nname = \"a\"");
        if self.has("closed") {
            self.line("closed = true");
        }
        let shape = self.shape();
        self.line(&shape);
        let section = self.section();
        self.line(&section);
        let natural = self.natural();
        self.line(&natural);
        let each = self.has("sequence") && !self.has("closed");
        let elements = if each { self.element_each() } else { self.elements(8) };
        self.line(&elements);
    }

    fn contact(&mut self) {
        let law = match () {
            () if self.has("no_contact") => "law = \"none\"",
            () if self.has("penalty") => "law = \"penalty\"\nstiffness = 100.0",
            () if self.has("augmented") => "stiffness = 100.0",
            () => "",
        };
        self.line(&format!("[contact]\n{law}"));
        if self.has("charged") {
            let (strength, debye) = (0.2 * self.bending / self.length.powi(2), short(0.015 * self.length));
            self.line(&format!("electrostatics = {{ strength = {}, debye_length = {debye} }}", short(strength)));
        }
    }

    fn shape(&mut self) -> String {
        let length = self.size;
        if self.has("shaped") {
            let closed = self.has("closed");
            let point = |k: usize| {
                let t = k as f64 / 60.0;
                let lift = if self.has("planar") { 0.0 } else { 1.0 };
                if closed {
                    let (radius, angle) = (length / TAU, TAU * t);
                    let wave = lift * 0.15 * (2.0 * angle + 0.4).sin();
                    radius * Vec3::new(1.1 * angle.cos(), 0.85 * angle.sin() + 0.1 * (2.0 * angle).cos(), wave)
                } else {
                    length * Vec3::new(t, 0.1 * (3.0 * t).sin(), lift * 0.07 * (4.0 * t).sin())
                }
            };
            let rows = (0..if closed { 60 } else { 61 }).map(|k| {
                let p = point(k);
                format!("{:?},{:?},{:?}\n", p.x, p.y, p.z)
            });
            self.tables.push(("points.csv", "x,y,z\n".to_owned() + &rows.collect::<String>()));
            return "shape = { kind = \"points\", file = \"points.csv\" }".to_owned();
        }
        if self.has("closed") {
            format!("shape = {{ kind = \"circle\", length = {length:?} }}")
        } else {
            format!("shape = {{ kind = \"line\", length = {length:?} }}")
        }
    }

    fn stretching(&self) -> f64 {
        short(self.bending / self.radius.powi(2))
    }

    fn section(&mut self) -> String {
        let (b, ea, radius) = (self.bending, self.stretching(), self.radius);
        let ga = short(0.4 * ea);
        let round = |b: f64, radius: f64| {
            format!(
                "section = {{ bending = {b}, twisting = {}, stretching = {ea}, shearing = {ga}, contact_radius = \
                 {radius} }}",
                short(0.8 * b)
            )
        };
        match () {
            () if self.has("anisotropic") => format!(
                "section = {{ bending = [{b}, {}], twisting = {}, stretching = {ea}, shearing = [{ga}, {}], \
                 contact_radius = {radius} }}",
                short(1.8 * b),
                short(0.9 * b),
                short(0.6 * ea)
            ),
            () if self.has("full") => {
                let mut matrix = [[0.0; 6]; 6];
                for (k, value) in [ga, 1.2 * ga, ea, b, 1.5 * b, 0.8 * b].into_iter().enumerate() {
                    matrix[k][k] = short(value);
                }
                let couplings =
                    [(3, 4, 0.1 * b), (4, 5, 0.25 * b), (2, 5, 0.1 * (ea * b).sqrt()), (0, 3, 0.08 * (ga * b).sqrt())];
                for (i, j, value) in couplings {
                    (matrix[i][j], matrix[j][i]) = (short(value), short(value));
                }
                format!("section = {{ stiffness = {matrix:?}, contact_radius = {radius} }}")
            }
            () if self.has("tapered") => {
                let ends = if self.has("closed") { [1.2, 0.8, 1.2] } else { [1.2, 1.0, 0.8] };
                let rows = ends.iter().enumerate().map(|(k, size)| {
                    let (s, b) = (0.5 * k as f64 * self.length, b * size);
                    format!("{s:?},{ga},{ea},{b},{},{},{}\n", 1.3 * b, 0.8 * b, radius * size)
                });
                let head = "s,shearing,stretching,bending1,bending2,twisting,contact_radius\n";
                self.tables.push(("section.csv", head.to_owned() + &rows.collect::<String>()));
                "section = { table = \"section.csv\" }".to_owned()
            }
            () if self.has("sequence") => format!(
                "section = {{ contact_radius = {radius} }}\n\
                 sequence = {{ letters = \"{}\", steps = \"protein-dna-1998\" }}",
                self.letters
            ),
            () => round(b, radius),
        }
    }

    fn natural(&mut self) -> String {
        let (planar, k) = (self.has("planar"), 1.0 / self.length);
        let round = if self.has("closed") { TAU } else { 1.0 };
        match () {
            () if self.has("curved") && planar => {
                format!("natural = {{ curvature = [{}, 0.0] }}", short(0.7 * round * k))
            }
            () if self.has("curved") => format!(
                "natural = {{ curvature = [{}, {}], twist = {} }}",
                short(0.7 * round * k),
                short(0.3 * k),
                short(0.5 * k)
            ),
            () if self.has("table") => {
                let side = if planar { 0.0 } else { k };
                let row = |s: f64, a: f64, b: f64, c: f64| {
                    format!("{:?},{},{},{}\n", s * self.length, a * round * k, b * side, c * side)
                };
                let rows = [row(0.0, 0.5, 0.3, 0.2), row(0.4, 0.9, 0.0, 0.4), row(1.0, 0.5, 0.3, 0.2)].concat();
                self.tables.push(("natural.csv", "s,kappa1,kappa2,kappa3\n".to_owned() + &rows));
                "natural = { table = \"natural.csv\" }".to_owned()
            }
            () if self.has("shaped") => "natural = \"as-shaped\"".to_owned(),
            () => String::new(),
        }
    }

    /// Takes from the first rod what others are placed by.
    fn place(&mut self, scene: &Scene) {
        let nodes = &scene.model.rods[0].positions;
        let count = nodes.len();
        let middle = if self.has("closed") { 3 * count / 4 } else { count / 2 };
        let tangent = (nodes[(middle + 1) % count] - nodes[middle - 1]).normalize();
        let away = if self.has("planar") { tangent.cross(&Vec3::z()) } else { -Vec3::z() };
        self.crossing = [nodes[middle], tangent, away];
        let height = |p: &Vec3| -p.dot(&self.down);
        self.lowest = nodes.iter().map(height).fold(f64::INFINITY, f64::min) - 1.3 * self.radius;
    }

    fn other_rods(&mut self) {
        let (b, ea, length) = (self.bending, self.stretching(), self.length);
        let section = |radius: f64| {
            format!(
                "section = {{ bending = {b}, twisting = {}, stretching = {ea}, shearing = {}, contact_radius = \
                 {radius} }}",
                short(0.7 * b),
                short(0.5 * ea)
            )
        };
        if self.has("joined") {
            let at = if self.has("closed") { self.nodes.len() / 2 } else { self.nodes.len() - 1 };
            let direction = if self.has("closed") { -Vec3::x() } else { Vec3::new(0.6, 0.8, 0.0) };
            let (start, section, elements) = (self.nodes[at], section(0.0), self.elements(2));
            self.line(&format!(
                "[[rods]]\nname = \"b\"\nshape = {{ kind = \"line\", start = {}, direction = {}, length = {} \
                 }}\n{section}\n{elements}",
                list(&start),
                list(&direction),
                short(0.4 * length)
            ));
            self.line(&format!("[[joints]]\na = {{ rod = \"a\", at = {at} }}\nb = {{ rod = \"b\", at = \"start\" }}"));
        }
        if self.has("crossing") {
            let ([at, tangent, away], gap) = (self.crossing, self.gap());
            let radius = self.radius;
            let nearest = at + away * (2.3 * radius + gap);
            let (span, elements) = (short(0.7 * length), self.elements(4));
            let (shape, ends) = if self.has("planar") {
                let (bow, half) = (0.5 * length, 0.5f64);
                let center = nearest + away * bow;
                let ends = [half, -half].map(|angle| center - (away * angle.cos() + tangent * angle.sin()) * bow);
                let along = tangent * half.cos() - away * half.sin();
                let towards = away * half.cos() + tangent * half.sin();
                let shape = format!(
                    "shape = {{ kind = \"arc\", start = {}, tangent = {}, towards = {}, radius = {bow}, turns = {} }}",
                    list(&ends[0]),
                    list(&along),
                    list(&towards),
                    2.0 * half / TAU
                );
                (shape, ends)
            } else {
                let across = (tangent.cross(&Vec3::z()) + 0.2 * tangent).normalize();
                let ends = [-0.45, 0.55].map(|part| nearest + across * (part * span));
                let (start, direction) = (list(&ends[0]), list(&across));
                let shape =
                    format!("shape = {{ kind = \"line\", start = {start}, direction = {direction}, length = {span} }}");
                (shape, ends)
            };
            let section = section(radius);
            self.line(&format!("[[rods]]\nname = \"c\"\n{shape}\nnatural = \"as-shaped\"\n{section}\n{elements}"));
            for end in ["start", "end"] {
                self.line(&format!("[[supports]]\nrod = \"c\"\nat = \"{end}\"\nposition = true\nrotation = true"));
            }
            let height = |p: &Vec3| -p.dot(&self.down);
            let low = ends.iter().map(height).fold(height(&nearest), f64::min) - 1.3 * radius;
            self.lowest = self.lowest.min(low);
        }
        if self.has("floor") {
            let height = self.lowest - self.gap();
            self.line(&format!(
                "[[planes]]\nname = \"floor\"\npoint = {}\nnormal = {}",
                list(&(-self.down * height)),
                list(&-self.down)
            ));
        }
    }

    /// Clearance that rods start with.
    fn gap(&self) -> f64 {
        short(0.01 * self.length)
    }

    /// The far end of the scene: rod and place.
    fn end(&self) -> (&'static str, String) {
        match () {
            () if self.has("joined") => ("b", "\"end\"".to_owned()),
            () if self.has("closed") => ("a", self.arc(0.5)),
            () => ("a", "\"end\"".to_owned()),
        }
    }

    fn arc(&self, part: f64) -> String {
        format!("{{ arc = {:?} }}", part * self.length)
    }

    /// Components held at the far end.
    fn held(&self) -> Option<[&'static str; 2]> {
        let planar = self.has("planar");
        Some(match () {
            () if self.has("clamps") => ["true", "true"],
            () if self.has("pin") => ["true", "false"],
            () if self.has("slide") => [if planar { "[\"y\"]" } else { "[\"y\", \"z\"]" }, "false"],
            () if self.has("spin") => ["false", if planar { "[\"z\"]" } else { "[\"x\"]" }],
            () => return None,
        })
    }

    fn supports(&mut self) {
        if !self.has("unsupported") {
            self.line("[[supports]]\nrod = \"a\"\nat = \"start\"\nposition = true\nrotation = true");
        }
        if let Some([position, rotation]) = self.held() {
            let (rod, at) = self.end();
            self.line(&format!(
                "[[supports]]\nrod = \"{rod}\"\nat = {at}\nposition = {position}\nrotation = {rotation}"
            ));
        }
    }

    fn loads(&mut self) {
        let (planar, free, size) = (self.has("planar"), self.has("unsupported"), self.force);
        let side = match () {
            () if free => Vec3::zeros(),
            () if planar => Vec3::new(0.3, 0.0, 0.0),
            () => Vec3::new(0.3, 0.4, 0.0),
        };
        let force = (self.down + side) * size;
        let moment = if planar { Vec3::z() } else { Vec3::new(0.3, 0.5, 0.6) }
            * (0.3 * size * self.length * if self.has("closed") { 0.4 } else { 1.0 });
        let (rod, at) = self.end();
        let digits = |v: Vec3| list(&v.map(short));
        match () {
            () if self.has("force") && free => {
                let last = if self.has("closed") { self.arc(0.75) } else { "\"end\"".to_owned() };
                let middle = self.arc(if self.has("closed") { 0.375 } else { 0.5 });
                for at in ["\"start\"".to_owned(), middle, last] {
                    self.line(&format!("[[loads]]\nrod = \"a\"\nat = {at}\nforce = {}", digits(force / 3.0)));
                }
            }
            () if self.has("force") => {
                self.line(&format!("[[loads]]\nrod = \"{rod}\"\nat = {at}\nforce = {}", digits(force)));
            }
            () if self.has("moment") => {
                self.line(&format!("[[loads]]\nrod = \"{rod}\"\nat = {at}\nmoment = {}", digits(moment)));
            }
            () if self.has("line_force") => {
                self.line(&format!("[[line_loads]]\nrod = \"a\"\nforce = {}", digits(force * (2.0 / self.length))));
            }
            () if self.has("line_moment") => {
                self.line(&format!("[[line_loads]]\nrod = \"a\"\nmoment = {}", digits(moment * (2.0 / self.length))));
            }
            () => {}
        }
    }

    /// Loads and the crossing rod first, then the ramp, then a change of supports.
    fn stages(&mut self) {
        let mut first = Vec::new();
        if !self.has("unloaded") {
            first.push("load = 1.0".to_owned());
        }
        if self.has("crossing") {
            let to = list(&(-self.crossing[2] * (self.gap() + 0.03 * self.length)));
            let move_of = |end: &str| format!("{{ rod = \"c\", at = \"{end}\", to = {to} }}");
            first.push(format!("displacement = [{}, {}]", move_of("start"), move_of("end")));
        }
        if !first.is_empty() {
            self.line(&format!("[[stages]]\nramp = {{ {} }}", first.join(", ")));
        }
        let numbers = self.random.vector();
        let ramp = self.ramp(1.0, &numbers);
        self.line(&format!("[[stages]]\nramp = {{ {ramp} }}"));
        if self.has("hold") {
            let at = self.arc(0.25);
            let back = self.ramp(0.5, &numbers);
            self.line(&format!(
                "[[stages]]\nramp = {{ {back} }}\n\
                hold = [{{ rod = \"a\", at = {at}, position = true, rotation = true }}]"
            ));
        }
        if self.has("release") {
            let ((rod, at), [position, rotation]) = match self.held() {
                Some(held) => (self.end(), held),
                None => (("a", "\"start\"".to_owned()), ["true", "true"]),
            };
            self.line(&format!(
                "[[stages]]\nrelease = [{{ rod = \"{rod}\", at = {at}, position = {position}, rotation = {rotation} }}]"
            ));
        }
    }

    /// The scene's ramp to a part of its way; `numbers` choose directions.
    fn ramp(&self, part: f64, numbers: &Vec3) -> String {
        let (planar, length) = (self.has("planar"), self.length);
        let axis = if planar { Vec3::z() } else { (Vec3::new(1.0, 0.2, 0.3) + 0.2 * numbers).map(short) };
        let mut way = (Vec3::new(-0.06, 0.05, 0.07) + 0.02 * numbers) * length * part;
        if planar {
            way.z = 0.0;
        }
        let way = list(&way.map(short));
        let axis_text = list(&axis);
        let at = "rod = \"a\", at = \"start\"";
        match () {
            () if self.has("load_factor") => format!("load = {}", 1.0 + 0.3 * part),
            () if self.has("link") => format!("excess_link = {{ rod = \"a\", to = {} }}", 0.4 * part),
            () if self.has("rotation") => format!("rotation = {{ {at}, axis = {axis_text}, turns = {} }}", 0.08 * part),
            () if self.has("round") => {
                let through = list(&(Vec3::new(-0.1, -0.2, 0.0) * length).map(short));
                format!("rotation = {{ {at}, axis = {axis_text}, through = {through}, turns = {} }}", 0.06 * part)
            }
            () if self.has("displacement") => format!("displacement = {{ {at}, to = {way} }}"),
            () if self.has("pose") => {
                let unit = axis.normalize();
                format!(
                    "pose = {{ {at}, position = {way}, axis_angle = [{:?}, {:?}, {:?}, {}], relative = true }}",
                    unit.x,
                    unit.y,
                    unit.z,
                    0.05 * part
                )
            }
            () if self.has("lift") => format!("plane = {{ name = \"floor\", to = {} }}", short(0.01 * part * length)),
            () if self.has("radius") => {
                format!("section = {{ rod = \"a\", contact_radius = {} }}", short(self.radius * (1.0 + 0.2 * part)))
            }
            () if self.has("stiffness") => format!(
                "section = {{ rod = \"a\", bending = {}, twisting = {}, stretching = {} }}",
                short(self.bending * (1.0 + 0.5 * part)),
                short(self.bending * (0.8 + 0.4 * part)),
                short(self.stretching() * (1.0 - 0.3 * part))
            ),
            () if self.has("length") => {
                format!("length = {{ rod = \"a\", to = {} }}", short(length * (1.0 - 0.04 * part)))
            }
            () if self.has("nature") => {
                let k = part / length * if self.has("closed") { 3.0 } else { 1.0 };
                let [side, twist] = if planar { [0.0, 0.0] } else { [0.3 * k, 0.6 * k] };
                if planar {
                    format!("natural = {{ rod = \"a\", curvature = [{}, 0.0] }}", short(1.2 * k))
                } else {
                    format!(
                        "natural = {{ rod = \"a\", curvature = [{}, {}], twist = {} }}",
                        short(1.2 * k),
                        short(side),
                        short(twist)
                    )
                }
            }
            () => format!(
                "pressure = {{ rod = \"a\", to = {} }}",
                short(0.8 * part * self.bending / (length / TAU).powi(3))
            ),
        }
    }
}

/// Length of the rod of a sequence.
fn helix_length(letters: &str, closed: bool) -> f64 {
    let helix = Sequence::parse(letters).and_then(|it| it.helix(&Steps::protein_dna_1998()?, closed));
    helix.map(|helix| helix.length).unwrap_or_else(|error| panic!("{error}"))
}
