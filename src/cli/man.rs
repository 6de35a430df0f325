//! `pinwarp man`: the manual pages of the program and of all its commands.
//!
//! In: the argument definitions. Out: troff text on standard output, or one file per command in a folder.

use super::args::{Args, ManArgs};
use super::outcome::Outcome;
use super::outputs;
use crate::image::{Inputs, replace_bytes};
use anyhow::Context;
use clap::CommandFactory;
use clap_mangen::Man;
use std::io::{self, Write};

pub(super) fn run(args: &ManArgs) -> anyhow::Result<Outcome> {
    let pages = pages()?;
    let Some(folder) = &args.output else {
        // Buffered into a single write, which a reader may cut off.
        let all: Vec<u8> = pages.into_iter().flat_map(|page| page.troff).collect();
        io::stdout().write_all(&all)?;
        return Ok(Outcome::Complete);
    };
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let paths: Vec<_> = pages.iter().map(|page| folder.join(&page.file)).collect();
    paths.iter().try_for_each(|path| outputs::allow(&Inputs::default(), path, args.overwrite))?;
    for (page, path) in pages.iter().zip(&paths) {
        replace_bytes(path, &page.troff)?;
    }
    writeln!(io::stdout(), "wrote {} pages into {}", pages.len(), folder.display())?;
    Ok(Outcome::Complete)
}

struct Page {
    /// File name of the page, such as `pinwarp-render.1`.
    file: String,
    troff: Vec<u8>,
}

/// Returns the page of the program, then those of its commands.
fn pages() -> anyhow::Result<Vec<Page>> {
    let mut program = Args::command();
    program.build();
    let page = |command: &clap::Command| {
        let (man, mut troff) = (Man::new(command.clone()), Vec::new());
        man.render(&mut troff)?;
        Ok(Page { file: man.get_filename(), troff })
    };
    let commands = program.get_subcommands().filter(|command| command.get_name() != "help");
    std::iter::once(&program).chain(commands).map(page).collect()
}
