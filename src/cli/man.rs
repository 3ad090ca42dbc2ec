//! `man`: the manual, made of the same descriptions as `--help`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{Exit, Failure, description, terminal};

/// Arguments of `man`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for the pages, tabletopgen.1 and one for each command [default: print the first page]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Writes the pages.
pub fn run(arguments: &Arguments) -> Result<Exit, Failure> {
    match &arguments.out {
        Some(folder) => {
            let failed = |error: std::io::Error| {
                let message = format!(
                    "cannot write the manual to {}: {error}; give --out another folder",
                    folder.display()
                );
                Failure::new(Exit::Error, message)
            };
            std::fs::create_dir_all(folder).and_then(|()| write(folder)).map_err(failed)?;
        }
        None => {
            let mut page = Vec::new();
            // Memory takes everything.
            let _ = clap_mangen::Man::new(description()).render(&mut page);
            terminal::print(&String::from_utf8_lossy(&page));
        }
    }
    Ok(Exit::Success)
}

fn write(folder: &Path) -> std::io::Result<()> {
    clap_mangen::generate_to(description(), folder)
}
