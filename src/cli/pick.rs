//! `pinwarp pick`: casts a screen point onto the model.
//!
//! In: a shot, a frame and a point. Out: a pin, printed or inserted into the shot file.

use super::args::PickArgs;
use super::outcome::Outcome;
use crate::files::{SHOT_BYTES, read_text};
use crate::image::replace_text;
use crate::pipeline::{PickedPoint, PreparedShot};
use crate::shot::{Shot, edit};
use crate::space::{FrameSize, ImagePoint, ScreenPoint};
use anyhow::{Context, bail};
use std::io::Write;

pub(super) fn run(args: &PickArgs) -> anyhow::Result<Outcome> {
    let mut shot = args.outside.read(&args.shot)?;
    args.camera.choose(&mut shot);
    // Existing pins do not affect the result, and invalid ones may be the reason to pick again.
    shot.layers.iter_mut().for_each(|layer| layer.pins.clear());
    let frame = args.frame.unwrap_or(shot.frames.first);
    let at = point(args, &shot)?;
    let prepared = PreparedShot::new(shot)?;
    let Some(PickedPoint { anchor, node, layer: owner, .. }) = prepared.pick(frame, at) else {
        bail!(
            "there is no surface at {:.4},{:.4} in frame {frame}; render it with --preview and point at the model",
            at.0.x,
            at.0.y
        );
    };
    let owner = owner.map(|layer| prepared.shot.layers[layer].name.as_str());
    let layer = args.layer.as_deref().or(owner);
    let name = args.write.as_deref().unwrap_or("pin");
    match (&args.write, layer) {
        (None, _) => write!(std::io::stdout(), "{}", edit::pin_block(name, &anchor, prepared.shot.frames.first))?,
        (Some(_), None) => {
            bail!("no layer claims node '{node}'; add it to a layer's `nodes` or name a layer with --layer")
        }
        (Some(_), layer) => {
            let path = &args.shot;
            let text = read_text(path, SHOT_BYTES).with_context(|| format!("cannot read {}", path.display()))?;
            let edited = edit::add_pin(&text, layer, name, &anchor)?;
            replace_text(path, &edited)?;
            let layer = layer.unwrap_or_default();
            writeln!(std::io::stdout(), "wrote pin '{name}' of layer '{layer}' into {}", path.display())?;
        }
    }
    Ok(Outcome::Complete)
}

/// Returns the requested screen point.
fn point(args: &PickArgs, shot: &Shot) -> anyhow::Result<ScreenPoint> {
    match (args.at, args.at_px) {
        (Some([x, y]), _) if is_in_pixels([x, y], shot.size) => bail!(
            "--at {x},{y} is far outside the frame, which reaches from 0,0 to {:.3},1 frame heights; for pixels use --at-px {x},{y}",
            shot.size.aspect()
        ),
        (Some([x, y]), _) => Ok(ScreenPoint::new(x, y)),
        (None, Some([x, y])) => Ok(shot.size.screen_from_image(ImagePoint::new(x, y))),
        (None, None) => bail!("a point is needed: --at X,Y or --at-px X,Y"),
    }
}

/// Returns whether a point seems to be in pixels instead of frame heights: no visible point is that far outside.
fn is_in_pixels([x, y]: [f64; 2], size: FrameSize) -> bool {
    x.abs() > 3.0 * size.aspect() || y.abs() > 3.0
}
