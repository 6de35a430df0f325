//! A figure that moves before a wall and behind a box: the scene, its plates, and what a warped plate shows wrongly.

use super::agreement::{FRAMES, at, frames, prepared, rendered, still, warped};
use super::tiny::{Lens, Part, Tiny, grid};
use pinwarp::image::{Frame, read_plate, write_plate};
use pinwarp::plate::Holes;
use pinwarp::shot::Shot;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A sheet with slanted edges, so that many of its edge pixels are covered in part.
fn slanted(name: &'static str, sides: [f32; 4], (z, slant): (f32, f32), color: [f32; 3]) -> Part {
    let mut part = grid(name, sides, 6);
    part.positions.iter_mut().for_each(|point| point[0] += slant * point[1]);
    Part { place: [0.0, 0.0, z], color, ..part }
}

/// The parts of the scene by their names.
fn parts(names: &[&str]) -> Vec<Part> {
    let all = [
        slanted("Wall", [-1.2, -0.6, 1.2, 0.6], (-1.0, 0.0), [0.2, 0.7, 0.3]),
        slanted("Figure", [-0.35, -0.35, 0.05, 0.35], (0.0, 0.3), [0.9, 0.2, 0.1]),
        slanted("Box", [-0.05, -0.3, 0.25, 0.1], (1.0, -0.4), [0.1, 0.3, 0.9]),
    ];
    all.into_iter().filter(|part| names.contains(&part.name)).collect()
}

/// A stage with some of the parts; the figure moves to the right, its foot more than its head.
pub(super) struct Stage {
    folder: TempDir,
    parts: Vec<&'static str>,
}

impl Stage {
    pub(super) fn with(parts: &[&'static str]) -> Self {
        Self { folder: TempDir::new().expect("a folder"), parts: parts.to_vec() }
    }

    /// The shot of the scene with all parts but some.
    fn shot(&self, without: &[&str], layer: &str) -> Shot {
        let names: Vec<&str> = self.parts.iter().copied().filter(|name| !without.contains(name)).collect();
        let scene = self.folder.path().join(format!("{}.gltf", names.join("-")));
        let tiny = Tiny { lens: Lens::Perspective(0.2), ..Tiny::of(parts(&names)) };
        std::fs::write(&scene, tiny.json().to_string()).expect("written");
        let text = format!(
            "version = 1\nscene = '{}'\nframes = {{ first = 8, last = 12, rate = 24 }}\nsize = [480, 270]\nsamples = 16\n\
             shutter = {{ angle = 0 }}\n[output]\nchannels = ['beauty', 'depth', 'id']\n{layer}",
            scene.display()
        );
        Shot::parse(&text, Path::new("/stage.toml")).expect("a right shot")
    }

    /// The shot that moves the figure.
    pub(super) fn moving(&self) -> Shot {
        let pin = |[x, y]: [f64; 2], offset: [f64; 2]| {
            format!(
                "[[layer.pin]]\nanchor = {{ screen = [{x}, {y}], frame = 8 }}\n\
                 keys = [{{ frame = 8, offset = {offset:?} }}, {{ frame = 12, offset = [{}, {}] }}]\n",
                0.4 * offset[0],
                0.4 * offset[1]
            )
        };
        let pins = [pin([0.65, 0.2], [0.33, 0.02]), pin([0.85, 0.8], [0.21, -0.03])].concat();
        self.shot(
            &[],
            &format!("[[layer]]\nname = 'figure'\nnodes = ['Figure']\nlattice = {{ dims = [5, 5] }}\n{pins}"),
        )
    }

    /// Renders the plates of the resting figure into a folder, and the moved figure for comparison.
    fn plates(&self) -> (PathBuf, Vec<Frame>) {
        let [plates, real] = ["plates", "real"].map(|name| self.folder.path().join(name));
        if plates.exists() {
            return (plates, frames(&real, "f"));
        }
        [&plates, &real].iter().for_each(|folder| std::fs::create_dir_all(folder).expect("a folder"));
        rendered(still(&self.moving()), &plates);
        let real = rendered(self.moving(), &real);
        (plates, real)
    }

    /// Renders the clean plates, which show all but the figure.
    pub(super) fn clean(&self) -> Holes {
        let folder = self.folder.path().join("clean");
        std::fs::create_dir_all(&folder).expect("a folder");
        if self.parts == ["Figure"] {
            // Nothing is left that could be rendered.
            for frame in FRAMES {
                let [from, to] = [&self.plates().0, &folder].map(|folder| folder.join(format!("f.{frame:04}.exr")));
                let mut plate = read_plate(&from).expect("a plate");
                let channels = plate.parts.iter_mut().flat_map(|part| &mut part.channels);
                channels.for_each(|channel| channel.samples.fill(0.0));
                write_plate(&to, &plate).expect("written");
            }
        } else {
            rendered(self.shot(&["Figure"], ""), &folder);
        }
        Holes::Plate(folder.join("f.####.exr"))
    }

    /// Warps the plates and counts what differs from the renders.
    pub(super) fn compared(&self, holes: Holes, name: &str) -> Vec<Wrong> {
        let (plates, real) = self.plates();
        let made = warped(&prepared(self.moving()), holes, &plates);
        let rest = frames(&plates, "f");
        let compare = |((made, real), rest): ((&Frame, &Frame), &Frame)| Wrong::of(made, real, rest);
        let found: Vec<Wrong> = made.iter().zip(&real).zip(&rest).map(compare).collect();
        FRAMES.iter().zip(&found).for_each(|(frame, wrong)| println!("{name}, frame {frame}: {wrong:?}"));
        found
    }
}

/// Pixels of a warped plate that differ from the render.
#[derive(Debug, PartialEq)]
pub(super) struct Wrong {
    /// By more than 0.1 in alpha.
    pub(super) alpha: usize,
    /// By more than 0.1 in some colour.
    pub(super) color: usize,
    /// By more than 0.5 in some colour or alpha: whole pixels.
    pub(super) whole: usize,
    /// With an alpha above 0.1 where the render is empty and the resting figure has an edge: traces of what was there.
    pub(super) traces: usize,
    /// Empty although the render shows the figure: what the plate does not know. They do not count as wrong.
    pub(super) missing: usize,
}

impl Wrong {
    fn of(made: &Frame, real: &Frame, rest: &Frame) -> Self {
        let mut found = Self { alpha: 0, color: 0, whole: 0, traces: 0, missing: 0 };
        let (width, height) = (real.display.width as i32, real.display.height as i32);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let sample = |frame: &Frame, channel: &str| at(frame, channel, x, y).unwrap_or(0.0);
            let gap = |channel: &str| (sample(made, channel) - sample(real, channel)).abs();
            let has_edge = (0.01..0.99).contains(&sample(rest, "A"));
            found.traces += usize::from(has_edge && sample(real, "A") == 0.0 && sample(made, "A") > 0.1);
            if sample(made, "A") < 0.01 && sample(real, "id.layer") == 1.0 {
                found.missing += 1;
                continue;
            }
            let color = ["R", "G", "B"].map(gap).into_iter().fold(0.0, f32::max);
            found.alpha += usize::from(gap("A") > 0.1);
            found.color += usize::from(color > 0.1);
            found.whole += usize::from(color.max(gap("A")) > 0.5);
        }
        found
    }
}
