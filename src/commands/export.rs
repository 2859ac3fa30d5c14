//! `supercoil export DIR`.

use std::path::PathBuf;

use clap::Args;
use supercoil::InputError;
use supercoil::dna::sequence::Sequence;
use supercoil::io::export::{Formats, base_pairs};

use super::CONVERGED;
use super::print::say;

#[derive(Args)]
#[command(group(clap::ArgGroup::new("format").args(["oxdna", "xyz", "vect", "pdb", "par", "ref_frames",
    "npy"]).required(true).multiple(true)))]
pub struct ExportArguments {
    /// Folder of the run.
    dir: PathBuf,
    /// Rod, where there are several.
    #[arg(long)]
    rod: Option<String>,
    /// Sequence (FASTA): names the bases and their number [default: the sequence of the rod, if it has one].
    #[arg(long, value_name = "FASTA")]
    sequence: Option<PathBuf>,
    /// Number of base pairs, equally spaced [default: those of the sequence, or length / 0.34 nm].
    #[arg(long, value_name = "N", conflicts_with = "sequence")]
    base_pairs: Option<usize>,
    /// oxDNA: writes NAME.top and NAME.dat; needs a sequence.
    #[arg(long, value_name = "NAME")]
    oxdna: Option<PathBuf>,
    /// XYZ, one point a base pair, nm: a centreline for tacoxDNA.
    #[arg(long, value_name = "FILE")]
    xyz: Option<PathBuf>,
    /// Geomview's VECT, one point a base pair, nm.
    #[arg(long, value_name = "FILE")]
    vect: Option<PathBuf>,
    /// PDB, the atoms P of both strands, Å.
    #[arg(long, value_name = "FILE")]
    pdb: Option<PathBuf>,
    /// Step parameters as 3DNA's bp_step.par.
    #[arg(long, value_name = "FILE")]
    par: Option<PathBuf>,
    /// Frames as 3DNA's ref_frames.dat, Å.
    #[arg(long, value_name = "FILE")]
    ref_frames: Option<PathBuf>,
    /// NumPy array of base-pair frames, shape (pairs, 4, 3), nm, as mdna reads them.
    #[arg(long, value_name = "FILE")]
    npy: Option<PathBuf>,
}

impl ExportArguments {
    pub fn go(self) -> Result<u8, InputError> {
        let given = self.sequence.as_deref().map(Sequence::read).transpose()?;
        let of_rod = |count: Option<usize>| base_pairs(&self.dir, self.rod.as_deref(), count);
        let mut pairs = of_rod(self.base_pairs)?;
        if let Some(sequence) = given {
            // a rod with a sequence of its own has as many base pairs, whatever is given
            pairs = if pairs.sequence.is_none() { of_rod(Some(sequence.num_bases()))? } else { pairs };
            pairs = pairs.with_sequence(sequence)?;
        }
        let Self { oxdna, xyz, vect, pdb, par, ref_frames, npy, .. } = self;
        let written = Formats { oxdna, xyz, vect, pdb, par, ref_frames, npy }.write(&pairs)?;
        let written: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
        say(format_args!("{} base pairs to {}", pairs.positions.len(), written.join(", ")));
        Ok(CONVERGED)
    }
}
