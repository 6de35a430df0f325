//! STMaps of large triangles that bend: edges are split alike in the pictures before and after the warp, or the map
//! would have holes along them.

use super::tiny::{Tiny, grid};
use pinwarp::image::read_exr;
use pinwarp::pipeline::{PreparedShot, RenderOptions, SurfaceMaps, render};
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::Shot;
use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

/// A square of two triangles whose middle is pulled far, its corners are held; beside it something still.
fn shot(folder: &Path) -> Shot {
    let parts = vec![grid("Sheet", [-0.7, -0.35, 0.1, 0.35], 1), grid("Still", [0.5, -0.2, 0.8, 0.2], 1)];
    let scene = folder.join("sheet.gltf");
    std::fs::write(&scene, Tiny::of(parts).json().to_string()).expect("written");
    let mut text = format!(
        "version = 1\nscene = '{}'\nframes = {{ first = 1, last = 1, rate = 24 }}\nsize = [480, 270]\nsamples = 1\n\
         [output]\npath = '{}'\nchannels = ['beauty', 'id']\n\
         [[layer]]\nname = 'sheet'\nnodes = ['Sheet']\nlattice = {{ dims = [9, 9] }}\n",
        scene.display(),
        folder.join("f.####.exr").display()
    );
    let corners = [[0.22, 0.18], [0.96, 0.18], [0.22, 0.82], [0.96, 0.82]].map(|at| (at, [0.0, 0.0]));
    for ([x, y], by) in corners.into_iter().chain([([0.59, 0.5], [0.1, 0.17])]) {
        write!(
            text,
            "[[layer.pin]]\nanchor = {{ screen = [{x}, {y}], frame = 1 }}\nkeys = [{{ frame = 1, offset = {by:?} }}]\n"
        )
        .expect("a string takes all");
    }
    Shot::parse(&text, Path::new("/sheet.toml")).expect("a right shot")
}

#[test]
fn maps_of_large_bent_triangles_have_no_holes() {
    let folder = TempDir::new().expect("a folder");
    let prepared = PreparedShot::new(shot(folder.path())).expect("the scene fits the shot");
    let options = RenderOptions { device: DeviceChoice::Cpu, ..RenderOptions::default() };
    let summary = render(&prepared, &options, &AtomicBool::new(false), &|_| {}).expect("rendered");
    assert_eq!((summary.rendered, summary.failed), (1, 0));
    let drawn = read_exr(&folder.path().join("f.0001.exr")).expect("a frame");
    let size = prepared.shot.size;
    let map = SurfaceMaps::new(&prepared, size.whole()).and_then(|mut maps| maps.backward(1)).expect("a map");
    let ids = &drawn.channel("id.object").expect("ids").samples;
    let covered: Vec<[i32; 2]> =
        (0..ids.len()).filter(|&index| ids[index] > 0.0).map(|index| drawn.data_window.pixel_at(index)).collect();
    let holes = covered.iter().filter(|[x, y]| map.source(*x, *y).is_none()).count();
    let farthest = map.offsets.iter().map(|[x, y]| x.hypot(*y)).filter(|length| length.is_finite()).fold(0.0, f32::max);
    println!("{} pixels, {holes} holes, moved by up to {farthest} pixels", covered.len());
    assert!(covered.len() > 40_000 && farthest > 30.0, "the sheet is large and bent: {}, {farthest}", covered.len());
    assert_eq!(holes, 0, "of {}", covered.len());
}
