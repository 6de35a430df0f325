//! Readers of every kind of file: each reads a file, uses what it holds, and returns whether the file was accepted.

use pinwarp::export::{Landmarks, LatticeFile, Track, lattice_at};
use pinwarp::image::{is_complete, picture_size, read_any, read_any_head, read_metadata};
use pinwarp::plate::map_of_stmap;
use pinwarp::pose::{ClipChoice, pose};
use pinwarp::shot::Shot;
use pinwarp::solve::problem_file::{read_figure, run_file};
use std::path::Path;

pub(crate) fn read_shot(path: &Path) -> bool {
    let Ok(shot) = Shot::read(path) else { return false };
    for (layer, frame) in (0..shot.layers.len()).flat_map(|layer| [-1e6, 0.5, 12.0].map(|frame| (layer, frame))) {
        let _ = shot.pin_targets(layer, frame);
    }
    true
}

pub(crate) fn read_lattice(path: &Path) -> bool {
    let Ok(file) = LatticeFile::read(path) else { return false };
    for layer in &file.layers {
        match &layer.track {
            Track::Screen(lattices) => _ = lattice_at(lattices, 2.5).deform([0.3, 9.0]),
            Track::World(lattices) => _ = lattice_at(lattices, 2.5).deform([0.3, 9.0, -4.0]),
        }
    }
    true
}

pub(crate) fn read_pairs(path: &Path) -> bool {
    Landmarks::read(path).is_ok_and(|landmarks| {
        let numbers = landmarks.pairs.iter().flat_map(|pair| pair.a.into_iter().chain(pair.b));
        assert!(numbers.into_iter().all(f64::is_finite));
        true
    })
}

/// Solves the problem, too.
pub(crate) fn read_problem(path: &Path) -> bool {
    let Ok(result) = run_file(path) else { return false };
    assert!(
        result.handles.iter().chain(&result.vertices).flatten().all(|x| x.is_finite()),
        "the lattice is not finite"
    );
    true
}

pub(crate) fn read_figures(path: &Path) -> bool {
    read_figure(path).is_ok()
}

/// Does all that is done with a picture before it is warped.
pub(crate) fn read_image(path: &Path) -> bool {
    let _ = (picture_size(path), read_any_head(path), read_metadata(path), is_complete(path));
    let Ok(plate) = read_any(path) else { return false };
    let _ = map_of_stmap(&plate);
    true
}

pub(crate) fn read_scene(path: &Path) -> bool {
    let Ok(scene) = pinwarp::scene::load(path) else { return false };
    for clip in [None, Some(0)] {
        let _ = pose(&scene, ClipChoice { clip, is_looped: true }, 0.3);
    }
    true
}
