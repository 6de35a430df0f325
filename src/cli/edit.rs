//! `pinwarp edit`: opens the editor's window, or renders a picture of it.
//!
//! In: a file to open. Out: the files saved in the window; with `--screenshot` a PNG file.

use super::args::EditArgs;
use super::outcome::Outcome;
use super::outputs;
use crate::edit::ui::{EditorOptions, Screenshot, Theme, run as run_window, screenshot};
use std::io::Write;

pub(super) fn run(args: &EditArgs) -> anyhow::Result<Outcome> {
    let options = EditorOptions::new(args.device.clone(), args.outside.access());
    if let (Some(file), Some(output)) = (&args.file, &args.screenshot) {
        outputs::allow(&outputs::inputs_of([file]), output, args.overwrite)?;
        let theme = if args.light { Theme::Light } else { Theme::Dark };
        let pins = args.select.clone();
        let shown = Screenshot { frame: args.frame, pins, has_curves: args.curves, size: args.size, theme };
        screenshot(file, &shown, output, options)?;
        writeln!(std::io::stdout(), "wrote {}", output.display())?;
        return Ok(Outcome::Complete);
    }
    run_window(args.file.as_deref(), options)?;
    Ok(Outcome::Complete)
}
