//! A problem file as a figure: a mesh with coloured parts and one or more poses, for comparisons and pictures.
//!
//! In: a JSON file. Out: [`Figures`]. A file without `poses` has one pose, which consists of its `pins`.

use super::error::ProblemError;
use super::file::{ProblemFile, RawPart};
use super::job;
use crate::lattice::Grid;
use crate::solve::problem::{HandlePin, PointPin, Problem, Shape};
use crate::solve::settings::Settings;
use crate::spelling::pluralised;
use std::path::Path;

/// A figure in 2D or 3D.
#[derive(Clone, Debug)]
pub enum Figures {
    /// A figure in 2D.
    Plane(Figure<2>),
    /// A figure in 3D.
    Space(Figure<3>),
}

/// A mesh, its lattice and its poses.
#[derive(Clone, Debug)]
pub struct Figure<const D: usize> {
    /// Value of `name` in the file; empty if there is none.
    pub name: String,
    /// The rest grid.
    pub grid: Grid<D>,
    /// The mesh.
    pub shape: Shape<D>,
    /// Settings, as `pinwarp solve` reads them from the file.
    pub settings: Settings,
    /// Moved handles, the same in all poses.
    pub handles: Vec<HandlePin<D>>,
    /// Parts with the colours of all triangles, in the order of the triangles; empty if the file has none.
    pub parts: Vec<FigurePart>,
    /// Poses, at least one.
    pub poses: Vec<FigurePose<D>>,
}

/// Consecutive triangles of one colour.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FigurePart {
    /// Name of the part.
    pub name: String,
    /// Colour in sRGB.
    pub color: [u8; 3],
    /// Number of triangles.
    pub triangles: usize,
}

/// A set of pins.
#[derive(Clone, Debug, PartialEq)]
pub struct FigurePose<const D: usize> {
    /// Name of the pose; empty if the file gives none.
    pub name: String,
    /// Pins with their targets.
    pub pins: Vec<PointPin<D>>,
}

impl<const D: usize> Figure<D> {
    /// Returns the problem of a pose.
    #[must_use]
    pub fn problem<'a>(&'a self, pose: &'a FigurePose<D>) -> Problem<'a, D> {
        Problem {
            grid: &self.grid,
            shape: &self.shape,
            pins: &pose.pins,
            handles: &self.handles,
            settings: &self.settings,
        }
    }
}

/// Reads a figure from a problem file.
///
/// # Errors
/// [`ProblemError`], which names the file and the key.
pub fn read_figure(path: &Path) -> Result<Figures, ProblemError> {
    let text = crate::files::read_text(path, crate::files::LATTICE_BYTES);
    let text = text.map_err(|source| ProblemError::Read { path: path.to_owned(), source })?;
    parse(&text).map_err(|source| ProblemError::In { path: path.to_owned(), source: Box::new(source) })
}

fn parse(text: &str) -> Result<Figures, ProblemError> {
    let file = ProblemFile::parse(text)?;
    Ok(match file.axes()? {
        3 => Figures::Space(figure(&file)?),
        _ => Figures::Plane(figure(&file)?),
    })
}

fn figure<const D: usize>(file: &ProblemFile) -> Result<Figure<D>, ProblemError> {
    let shape = job::shape(file)?;
    let grid = job::grid(file, &shape)?;
    let pose = |name: &str, raw| Ok(FigurePose { name: name.to_owned(), pins: job::point_pins(raw, &shape)? });
    let poses = match file.poses.as_slice() {
        [] => vec![pose("", &file.pins)?],
        poses => poses.iter().map(|raw| pose(&raw.name, &raw.pins)).collect::<Result<_, ProblemError>>()?,
    };
    let parts = file.parts.iter().enumerate().map(|(k, raw)| part(k, raw)).collect::<Result<Vec<_>, _>>()?;
    let colored: usize = parts.iter().map(|part| part.triangles).sum();
    if !parts.is_empty() && colored != shape.triangles.len() {
        let colored = pluralised(colored, "triangle", "triangles");
        let what = format!("count {colored}, the shape has {}", shape.triangles.len());
        return Err(ProblemError::key("parts", what, "let their `triangles` add up to all"));
    }
    let (handles, settings) = (job::moved_handles(file)?, file.settings()?);
    Ok(Figure { name: file.name.clone().unwrap_or_default(), grid, shape, settings, handles, parts, poses })
}

fn part(k: usize, raw: &RawPart) -> Result<FigurePart, ProblemError> {
    let digits = raw.color.strip_prefix('#').filter(|digits| digits.len() == 6);
    let number = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
    let Some(number) = number else {
        let what = format!("\"{}\" is not a colour", raw.color);
        return Err(ProblemError::key(format!("parts[{k}].color"), what, "write it as #rrggbb"));
    };
    let [_, red, green, blue] = number.to_be_bytes();
    Ok(FigurePart { name: raw.name.clone(), color: [red, green, blue], triangles: raw.triangles })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = r##""vertices": [[0,0],[1,0],[1,1]], "triangles": [[0,1,2]],
        "parts": [{"name": "all", "color": "#0a80ff", "triangles": 1}]"##;

    #[test]
    fn poses_and_colours_are_read() {
        let text = format!(r#"{{{SQUARE}, "poses": [{{"name": "up", "pins": [{{"vertex": 2, "target": [1, 2]}}]}}]}}"#);
        let Ok(Figures::Plane(figure)) = parse(&text) else { unreachable!("two coordinates") };
        assert_eq!(figure.parts[0].color, [10, 128, 255]);
        assert_eq!((figure.poses.len(), figure.poses[0].pins[0].target), (1, [1.0, 2.0]));
    }

    #[test]
    fn parts_that_do_not_add_up_are_refused() {
        let text = format!("{{{}}}", SQUARE.replace("\"triangles\": 1", "\"triangles\": 7"));
        let error = parse(&text).map(|_| ()).expect_err("seven of one");
        assert!(error.to_string().contains("count 7 triangles, the shape has 1"), "{error}");
    }
}
