//! The comparison as a picture: one panel per method with the model, its lattice, pins, folded cells and metrics.
//!
//! In: entries in 2D, those of one basis after each other. Out: a [`Preview`]. Entries of several bases have a row for each. The first
//! panel, of each row if there are several bases, shows the model at rest and the targets of its pins.

use super::{Entry, Metrics};
use crate::image::{Canvas, Preview, Rgba8};
use crate::lattice::{Grid, Lattice};
use crate::solve::Problem;
use crate::space::ImagePoint;
use crate::spelling::pluralised;
use glam::DVec2;
use std::collections::HashMap;

/// Panels per row.
const COLUMNS: usize = 3;
/// Size of a panel's picture, and height of the caption below it.
const WIDTH: u32 = 600;
const HEIGHT: u32 = 600;
const WORDS: u32 = 100;
/// Dark lines between panels.
const GAP: u32 = 4;

const PAPER: Rgba8 = Rgba8([246, 244, 239, 255]);
const FOOT: Rgba8 = Rgba8([34, 38, 46, 255]);
const NET: Rgba8 = Rgba8([96, 132, 178, 130]);
const HANDLE: Rgba8 = Rgba8([66, 104, 158, 255]);
const FOLDED: Rgba8 = Rgba8([235, 40, 40, 130]);
const EDGE: Rgba8 = Rgba8([40, 30, 30, 62]);
const BOUNDARY: Rgba8 = Rgba8([44, 34, 34, 255]);
const PIN: Rgba8 = Rgba8([255, 214, 10, 255]);
const PIN_RIM: Rgba8 = Rgba8([40, 30, 0, 255]);
const MISS: Rgba8 = Rgba8([214, 60, 20, 255]);
const NAME: Rgba8 = Rgba8([255, 255, 255, 255]);
const TEXT: Rgba8 = Rgba8([206, 214, 226, 255]);
const BEST: Rgba8 = Rgba8([255, 214, 10, 255]);
/// Colour of models without colours.
const PLAIN: [u8; 3] = [134, 178, 214];

/// Number of consecutive triangles, and their colour; triangles after the last run have the default colour.
pub(crate) type ColorRun = (usize, [u8; 3]);

/// The model that all methods deform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SheetModel<'a> {
    /// Shape, pins, and the rest grid.
    pub(crate) problem: &'a Problem<'a, 2>,
    /// Colours of its triangles.
    pub(crate) color_runs: &'a [ColorRun],
    /// Title of the first panel.
    pub(crate) title: &'a str,
}

/// Draws the sheet.
#[must_use]
pub(crate) fn comparison_sheet(figure: &SheetModel, entries: &[Entry<2>]) -> Preview {
    let groups: Vec<&[Entry<2>]> = entries.chunk_by(|one, next| one.basis == next.basis).collect();
    let longest = groups.iter().map(|group| group.len() + 1).max().unwrap_or(1);
    let columns = if groups.len() > 1 { longest } else { COLUMNS.min(longest) };
    let rows: usize = groups.iter().map(|group| (group.len() + 1).div_ceil(columns)).sum::<usize>().max(1);
    let [across, down] =
        [(columns, WIDTH), (rows, HEIGHT + WORDS)].map(|(count, size)| count as u32 * (size + GAP) - GAP);
    let mut picture = Preview::transparent(across, down);
    fill(&mut picture, FOOT);
    let panels = Panels { figure, entries, view: PanelTransform::of(figure, entries), columns };
    let mut row = 0;
    for group in groups {
        panels.draw_group(&mut picture, group, row);
        row += (group.len() + 1).div_ceil(columns);
    }
    picture
}

/// The panels, with what all of them share.
struct Panels<'a> {
    figure: &'a SheetModel<'a>,
    entries: &'a [Entry<2>],
    view: PanelTransform,
    /// Panels per row.
    columns: usize,
}

impl Panels<'_> {
    /// Draws the model at rest and the entries of one basis, from a row of the sheet on.
    fn draw_group(&self, picture: &mut Preview, group: &[Entry<2>], row: usize) {
        let Self { figure, entries, ref view, columns } = *self;
        let basis = group.first().map_or(figure.problem.grid.basis, |entry| entry.basis);
        let rest = Grid { basis, ..figure.problem.grid.clone() }.at_rest();
        let first =
            panel(figure, view, PanelContent { lattice: &rest, points: &figure.problem.shape.points, is_rest: true });
        let others = group.iter().map(|entry| {
            panel(figure, view, PanelContent { lattice: &entry.lattice, points: &entry.points, is_rest: false })
        });
        for (k, drawn) in std::iter::once(first).chain(others).enumerate() {
            let corner = [k % columns, row + k / columns].map(|place| place as u32);
            let (x, y) = (corner[0] * (WIDTH + GAP), corner[1] * (HEIGHT + WORDS + GAP));
            paste(picture, &drawn, [x, y]);
            let mut canvas = Canvas::new(picture);
            let at = DVec2::new(f64::from(x) + 16.0, f64::from(y + HEIGHT) + 12.0);
            match k.checked_sub(1).map(|k| &group[k]) {
                None => rest_words(&mut canvas, at, (figure, &rest.grid)),
                Some(entry) => words(&mut canvas, at, entry, entries),
            }
        }
    }
}

/// The content of a panel.
struct PanelContent<'a> {
    lattice: &'a Lattice<2>,
    points: &'a [[f64; 2]],
    is_rest: bool,
}

/// Transforms model coordinates to pixels of a panel.
struct PanelTransform {
    middle: DVec2,
    scale: f64,
}

impl PanelTransform {
    /// Fits the rest box, all targets, and the last entry completely.
    fn of(figure: &SheetModel, entries: &[Entry<2>]) -> Self {
        let grid = &figure.problem.grid;
        let corners = [grid.lo, grid.hi].into_iter();
        let targets = figure.problem.pins.iter().map(|pin| pin.target);
        let moved = entries.last().into_iter().flat_map(|entry| entry.points.iter().copied());
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for at in corners.chain(targets).chain(moved).map(DVec2::from) {
            (low, high) = (low.min(at), high.max(at));
        }
        let room = DVec2::new(f64::from(WIDTH), f64::from(HEIGHT)) * 0.93;
        Self { middle: 0.5 * (low + high), scale: (room / (high - low)).min_element() }
    }

    fn px(&self, at: [f64; 2]) -> ImagePoint {
        let away = (DVec2::from(at) - self.middle) * self.scale;
        ImagePoint::new(0.5 * f64::from(WIDTH) + away.x, 0.5 * f64::from(HEIGHT) - away.y)
    }
}

fn panel(figure: &SheetModel, view: &PanelTransform, shown: PanelContent) -> Preview {
    let mut picture = Preview::transparent(WIDTH, HEIGHT);
    fill(&mut picture, PAPER);
    let mut canvas = Canvas::new(&mut picture);
    draw_cells(&mut canvas, view, shown.lattice);
    draw_mesh(&mut canvas, view, figure, shown.points);
    draw_net(&mut canvas, view, shown.lattice);
    draw_pins(&mut canvas, view, figure, &shown);
    picture
}

/// Draws the inverted cells.
fn draw_cells(canvas: &mut Canvas, view: &PanelTransform, lattice: &Lattice<2>) {
    let grid = &lattice.grid;
    let margin = grid.basis.margin();
    for cell in lattice.folded_cells() {
        let corner = |shift: [usize; 2]| {
            let at = |d: usize| grid.lo[d] + (cell[d] + shift[d] - margin) as f64 * grid.spacing(d);
            view.px(lattice.evaluate([at(0), at(1)]))
        };
        canvas.fill_polygon(&[[0, 0], [1, 0], [1, 1], [0, 1]].map(corner), FOLDED);
    }
}

/// Draws the handles and the lines between them.
fn draw_net(canvas: &mut Canvas, view: &PanelTransform, lattice: &Lattice<2>) {
    let [nx, ny] = lattice.grid.dims;
    let at = |i: usize, j: usize| view.px(lattice.handles[i + nx * j]);
    for j in 0..ny {
        for i in 0..nx {
            if i + 1 < nx {
                canvas.line(at(i, j), at(i + 1, j), 1.4, NET);
            }
            if j + 1 < ny {
                canvas.line(at(i, j), at(i, j + 1), 1.4, NET);
            }
            canvas.disc(at(i, j), 2.2, HANDLE);
        }
    }
}

/// Draws the parts in order, thin edges, and a dark outline around each mesh.
fn draw_mesh(canvas: &mut Canvas, view: &PanelTransform, figure: &SheetModel, points: &[[f64; 2]]) {
    let triangles = &figure.problem.shape.triangles;
    let edge_counts = edge_counts(triangles);
    let mut first = 0_usize;
    let runs = figure.color_runs.iter().copied().chain([(usize::MAX, PLAIN)]);
    for (count, color) in runs {
        let end = triangles.len().min(first.saturating_add(count));
        let part = &triangles[first..end];
        let [red, green, blue] = color;
        for corners in part {
            canvas.fill_polygon(&corners.map(|k| view.px(points[k as usize])), Rgba8([red, green, blue, 255]));
        }
        for [a, b] in part.iter().flat_map(edges) {
            let ends = [a, b].map(|k| view.px(points[k as usize]));
            let is_boundary = edge_counts.get(&[a.min(b), a.max(b)]) == Some(&1);
            let (width, ink) = if is_boundary { (2.6, BOUNDARY) } else { (1.0, EDGE) };
            canvas.line(ends[0], ends[1], width, ink);
        }
        first = end;
    }
}

fn edges(corners: &[u32; 3]) -> [[u32; 2]; 3] {
    let [a, b, c] = *corners;
    [[a, b], [b, c], [c, a]]
}

/// Counts the triangles of each edge.
fn edge_counts(triangles: &[[u32; 3]]) -> HashMap<[u32; 2], usize> {
    let mut counts = HashMap::new();
    for [a, b] in triangles.iter().flat_map(edges) {
        *counts.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
    }
    counts
}

/// Draws the pins at their solved positions, with lines to their targets.
fn draw_pins(canvas: &mut Canvas, view: &PanelTransform, figure: &SheetModel, shown: &PanelContent) {
    for pin in figure.problem.pins {
        let (now, target) = (view.px(shown.lattice.deform(pin.at)), view.px(pin.target));
        let ink = if shown.is_rest { PIN_RIM } else { MISS };
        if (now.0 - target.0).length() > 2.0 {
            canvas.line(now, target, 2.4, ink);
            canvas.ring(target, 7.0, 2.4, ink);
        }
        canvas.disc(now, 7.5, PIN_RIM);
        canvas.disc(now, 5.5, PIN);
    }
}

fn rest_words(canvas: &mut Canvas, at: DVec2, (figure, grid): (&SheetModel, &Grid<2>)) {
    let Problem { shape, pins, .. } = figure.problem;
    canvas.text(ImagePoint(at), figure.title, 2, NAME);
    let vertices = pluralised(shape.points.len(), "vertex", "vertices");
    let pins = pluralised(pins.len(), "pin", "pins");
    let counts = format!("{vertices}, {} x {} {} handles, {pins}", grid.dims[0], grid.dims[1], grid.basis.label());
    canvas.text(ImagePoint(at + DVec2::new(0.0, 30.0)), &counts, 2, TEXT);
    canvas.text(ImagePoint(at + DVec2::new(0.0, 56.0)), "at rest; rings: where the pins have to go", 2, TEXT);
}

/// Writes name and metrics; the smallest distortion of each kind in yellow.
fn words(canvas: &mut Canvas, at: DVec2, entry: &Entry<2>, entries: &[Entry<2>]) {
    let Metrics { angle, area, pin_error, flips, folded_cells, iterations, ms, .. } = entry.metrics;
    let ink = |value: f64, pick: fn(&Metrics) -> f64| {
        let least = entries.iter().map(|entry| pick(&entry.metrics)).fold(f64::INFINITY, f64::min);
        if value <= least { BEST } else { TEXT }
    };
    canvas.text(ImagePoint(at), entry.method, 2, NAME);
    let mut put = |x: f64, y: f64, text: &str, ink: Rgba8| {
        canvas.text(ImagePoint(at + DVec2::new(x, y)), text, 2, ink);
    };
    put(0.0, 30.0, &format!("angle {angle:.3}"), ink(angle, |metrics| metrics.angle));
    put(156.0, 30.0, &format!("area {area:.3}"), ink(area, |metrics| metrics.area));
    put(312.0, 30.0, &format!("pins off {:.2} %", 100.0 * pin_error), TEXT);
    let (folded, flips) = (pluralised(folded_cells, "cell", "cells"), pluralised(flips, "flip", "flips"));
    let turned = format!("{folded} folded, {flips}, {iterations} it, {ms:.1} ms");
    put(0.0, 56.0, &turned, TEXT);
}

fn fill(picture: &mut Preview, color: Rgba8) {
    picture.rgba.chunks_exact_mut(4).for_each(|pixel| pixel.copy_from_slice(&color.0));
}

/// Copies a panel into the sheet.
fn paste(picture: &mut Preview, panel: &Preview, [x, y]: [u32; 2]) {
    let line = 4 * panel.width as usize;
    for (row, pixels) in panel.rgba.chunks_exact(line).enumerate() {
        let start = 4 * ((y as usize + row) * picture.width as usize + x as usize);
        picture.rgba[start..start + line].copy_from_slice(pixels);
    }
}
