//! Where do the strands in a file touch? Any polylines, no rods.
//!
//! `cargo run --example contact_of_polylines -- strands.csv 1.0` reads lines `x,y,z` (blank line between strands, `#`
//! comments) and takes the second number as the strands' radius, in the file's unit. Without arguments it reads the
//! small file beside it (nm).

#![allow(clippy::print_stdout)]

use std::error::Error;

use supercoil::contact::{Contacts, Curve, DetectorOptions, detect};
use supercoil::math::Vec3;

fn read(text: &str) -> Result<Vec<Vec<Vec3>>, Box<dyn Error>> {
    let mut strands = vec![Vec::new()];
    for line in text.lines().map(str::trim).filter(|line| !line.starts_with('#')) {
        if line.is_empty() {
            strands.push(Vec::new());
            continue;
        }
        let numbers = line.split(',').map(|x| x.trim().parse()).collect::<Result<Vec<f64>, _>>()?;
        let [x, y, z] = numbers[..] else { return Err(format!("expected x,y,z: {line}").into()) };
        if let Some(strand) = strands.last_mut() {
            strand.push(Vec3::new(x, y, z));
        }
    }
    strands.retain(|s| !s.is_empty());
    Ok(strands)
}

/// Contacts of the strands in `path` with gaps of at most a radius.
pub fn run(path: &str, radius: f64) -> Result<Contacts, Box<dyn Error>> {
    let strands = read(&std::fs::read_to_string(path)?)?;
    let curves: Vec<Curve> = strands.iter().map(|points| Curve::polyline(points, radius)).collect();
    Ok(detect(&curves, DetectorOptions { range: radius, ..DetectorOptions::default() })?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path =
        arguments.next().unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/examples/polylines.csv").to_owned());
    let radius = arguments.next().map_or(Ok(1.0), |text| text.parse())?;
    let contacts = run(&path, radius)?;
    for s in &contacts.sites {
        let (degrees, kind) = (s.angle.to_degrees(), s.kind);
        println!(
            "strand {} at {:8.3}   strand {} at {:8.3}   gap {:7.3}   angle {degrees:4.1}°   {kind:?}",
            s.curve_a, s.arc_a, s.curve_b, s.arc_b, s.gap
        );
    }
    for z in &contacts.zones {
        println!(
            "strand {} from {:.3} to {:.3} within reach of strand {} from {:.3} to {:.3}",
            z.curve, z.arc[0], z.arc[1], z.partner, z.partner_arc[0], z.partner_arc[1]
        );
    }
    Ok(())
}
