//! `supercoil plot DIR`.

use std::path::PathBuf;

use clap::Args;
use supercoil::InputError;
use supercoil::io::plot_run::{PLOTTED, RunTable};

use super::CONVERGED;
use super::print::say;

#[derive(Args)]
pub struct PlotArguments {
    /// Folder of the run.
    dir: PathBuf,
    /// Table: of the steps (table), or of the final state: resultants (tension, shear, moments along the rods), lines,
    /// sites.
    #[arg(long, value_name = "TABLE", default_value = PLOTTED[0], value_parser = PLOTTED)]
    of: String,
    /// Only the rows of this rod.
    #[arg(long, value_name = "NAME")]
    rod: Option<String>,
    /// Column along the horizontal axis.
    #[arg(long, value_name = "COLUMN")]
    x: String,
    /// Columns along the vertical axis, of one unit.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', required = true)]
    y: Vec<String>,
    /// File to write, *.svg or *.pdf [default: DIR/Y.svg].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl PlotArguments {
    pub fn go(self) -> Result<u8, InputError> {
        let whole = RunTable::read_named(&self.dir, &self.of)?;
        let table = match &self.rod {
            Some(rod) => whole.of_rod(rod)?,
            None => whole,
        };
        let file = self.out.clone().unwrap_or_else(|| self.dir.join(format!("{}.svg", self.y.join("_"))));
        table.plot(&self.x, &self.y, &file)?;
        say(format_args!("{}", file.display()));
        Ok(CONVERGED)
    }
}
