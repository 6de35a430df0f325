//! Finds files that a shot names but that do not exist, and reports them with the line in the shot and a likely correction.
//!
//! In: a shot. Out: [`PipelineError::Mismatch`] for the first missing file.

use crate::image::FileKind;
use crate::pipeline::PipelineError;
use crate::shot::{Shot, Source};
use crate::spelling;
use std::path::Path;

/// Checks the scene, the pictures, the masks, the pictures that cut, and the lattice files.
pub(in crate::pipeline) fn check(shot: &Shot) -> Result<(), PipelineError> {
    match &shot.source {
        Source::Scene(scene) => check_file(shot, "scene", scene)?,
        Source::Images(images) => images.iter().try_for_each(|image| check_file(shot, "image", image))?,
        Source::Frame => {}
    }
    for (index, layer) in shot.layers.iter().enumerate() {
        if let Some(mask) = &layer.selection.mask {
            check_file(shot, &format!("layer[{index}].select.mask.file"), &mask.file)?;
        }
        for (number, cut) in layer.connectivity.cuts.iter().enumerate() {
            if let Some((key, file)) = cut.file() {
                check_file(shot, &format!("layer[{index}].lattice.cuts[{number}].{key}"), file)?;
            }
        }
    }
    for (index, transfer) in shot.layers.iter().enumerate().filter_map(|(k, layer)| Some((k, layer.transfer.as_ref()?)))
    {
        check_file(shot, &format!("layer[{index}].transfer.lattice"), &transfer.file)?;
    }
    Ok(())
}

fn check_file(shot: &Shot, key: &str, path: &Path) -> Result<(), PipelineError> {
    let is_missing = path.metadata().is_err_and(|error| error.kind() == std::io::ErrorKind::NotFound);
    if !is_missing {
        return Ok(());
    }
    let what = format!("there is no file {}", path.display());
    Err(PipelineError::mismatch(shot, key, what, hint(path)))
}

/// Suggests the most similar name among files of the same type in the same folder, or reports that the folder is missing.
fn hint(path: &Path) -> String {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = std::fs::read_dir(folder) else {
        return format!("the folder {} is not there either; paths are relative to the shot file", folder.display());
    };
    let paths = entries.flatten().map(|entry| entry.path());
    let alike =
        paths.filter(|other| other.extension() == path.extension() || FileKind::of(other) == FileKind::of(path));
    let names: Vec<String> = alike.filter_map(|other| Some(other.file_name()?.to_str()?.to_owned())).collect();
    let wanted = path.file_name().unwrap_or_default().to_string_lossy();
    match spelling::nearest(&wanted, names.iter().map(String::as_str)) {
        Some(name) => format!("did you mean \"{name}\"?"),
        None => "check the path, which is relative to the shot file".to_owned(),
    }
}
