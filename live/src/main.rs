//! Writes the page with the solver in it, or the numbers that the page must find.
//!
//! `supercoil-live page MODULE.wasm PAGE.html` writes one file that needs nothing else and no network;
//! `supercoil-live numbers EXCESS_LINK` prints the numbers of the ring at that link, and those of a contact search, as
//! JSON.
#![allow(clippy::print_stdout)] // a program talks to its reader

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use supercoil::io::view::{Film, FilmRod, FilmTable, Frame, FrameRod, Plot};
use supercoil::scene::Units;
use supercoil_live::ring::{COLUMNS, Ring, contacts_of_cubics, pulled_rod};
use wasm_bindgen_cli_support::Bindgen;

const SCRIPT: &str = include_str!("../page/live.js");
const STYLE: &str = include_str!("../page/live.css");
const NOTE: &str =
    "Computed in this page, step by step; a row of the table or a point of a plot shows that step again.";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["page", module, page] => Ok(std::fs::write(page, live_page(Path::new(module))?)?),
        ["numbers", excess_link] => {
            println!("{}", numbers(excess_link.parse()?)?);
            Ok(())
        }
        _ => Err("say: supercoil-live page MODULE.wasm PAGE.html, or: supercoil-live numbers EXCESS_LINK".into()),
    }
}

/// The page of a film whose only frame is the circle, with the module and the script that goes on from there.
fn live_page(module: &Path) -> Result<String, Box<dyn Error>> {
    let mut output = Bindgen::new()
        .input_path(module)
        .no_modules(true)?
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true)
        .generate_output()?;
    let module = STANDARD.encode(output.wasm_mut().emit_wasm());
    let mut added = format!("<style>\n{STYLE}</style>\n");
    let _ = writeln!(added, "<script type=\"text/plain\" id=\"module\">{module}</script>");
    let _ = writeln!(added, "<script>\n{}</script>", output.js());
    let _ = writeln!(added, "<script>\n\"use strict\";\n{SCRIPT}</script>");
    Ok(circle()?.page()?.replace("</body>", &(added + "</body>")))
}

/// The film that the page begins with.
fn circle() -> Result<Film, Box<dyn Error>> {
    let ring = Ring::new()?;
    let picture = ring.picture();
    let rod = FrameRod {
        points: picture.points,
        directions: picture.directions,
        pressure: picture.pressure,
        curvature: picture.curvature,
        twist_rate: picture.twist_rate,
        radii: vec![ring.radius()],
        seam_turns: ring.excess_link(),
    };
    let columns = COLUMNS.map(|(name, unit)| (name.to_owned(), unit.to_owned())).to_vec();
    let column = |name: &str| COLUMNS.iter().position(|(column, _)| *column == name).ok_or("no such column");
    let x = column("excess_link")?;
    let plots = [["writhe", "twist"], ["bending_energy", "twisting_energy"]]
        .into_iter()
        .map(|[a, b]| Ok(Plot { x, y: vec![column(a)?, column(b)?] }))
        .collect::<Result<_, &str>>()?;
    Ok(Film {
        title: "A DNA minicircle of 336 base pairs: turn its link".to_owned(),
        units: Units { length: "nm".to_owned(), force: "pN".to_owned() },
        rods: vec![FilmRod { name: "dna".to_owned(), closed: true }],
        frames: vec![Frame { rods: vec![rod], ..Frame::default() }],
        obstacles: Vec::new(),
        table: FilmTable { columns, rows: vec![ring.row().to_vec()] },
        plots,
        note: NOTE.to_owned(),
    })
}

/// As JSON: the numbers of the table after going to an excess link; the contacts of two cubics and the nodes of a
/// pulled rod as bits in hexadecimal; whether products and sums are fused here.
fn numbers(excess_link: f64) -> Result<String, Box<dyn Error>> {
    let mut ring = Ring::new()?;
    while ring.excess_link() != excess_link {
        if !ring.step_towards(excess_link)? {
            return Err("did not converge".into());
        }
    }
    let bits = |numbers: &[f64]| numbers.iter().map(|x| format!("{:016x}", x.to_bits())).collect::<Vec<_>>();
    let (row, contacts, rod) = (ring.row(), bits(&contacts_of_cubics()?), bits(&pulled_rod()?));
    Ok(format!("{{ \"row\": {row:?}, \"contacts\": {contacts:?}, \"rod\": {rod:?}, \"fused\": {} }}", is_fused()))
}

/// Whether faer takes kernels that fuse products and sums.
fn is_fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    true
}
