//! What the last pass of a window drew: pictures with their pixels, letters, lines, fills.

use super::window::Window;
use eframe::egui::{Color32, ColorImage, Context, Id, ImageData, Pos2, Rect, Shape, Stroke, TextureId, TexturesDelta};
use egui_kittest::TestRenderer;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// Keeps the pixels of a window's textures, in place of a graphics card.
#[derive(Clone, Default)]
pub(crate) struct Textures(Arc<Mutex<BTreeMap<TextureId, Arc<ColorImage>>>>);

impl TestRenderer for Textures {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let mut known = self.0.lock().expect("no test failed meanwhile");
        for (id, changes) in delta.set.drain() {
            for change in changes.into_iter().filter(|change| change.pos.is_none()) {
                let ImageData::Color(image) = change.image;
                known.insert(id, image);
            }
        }
        delta.free.drain().for_each(|id| _ = known.remove(&id));
    }
}

impl Textures {
    fn key() -> Id {
        Id::unique("textures of a test")
    }

    /// Makes them known to those who look at the window.
    pub(crate) fn install(&self, ctx: &Context) {
        ctx.data_mut(|data| data.insert_temp(Self::key(), self.clone()));
    }

    fn image(ctx: &Context, id: TextureId) -> Arc<ColorImage> {
        let own: Self = ctx.data(|data| data.get_temp(Self::key())).expect("they are installed");
        let known = own.0.lock().expect("no test failed meanwhile");
        Arc::clone(known.get(&id).expect("what is drawn was uploaded"))
    }
}

/// A picture, or a part of one, in the window.
pub(crate) struct Laid {
    pub(crate) rect: Rect,
    /// The part of the picture, each side from 0 to 1.
    pub(crate) part: Rect,
    pub(crate) tint: Color32,
    pub(crate) image: Arc<ColorImage>,
}

fn shapes(window: &Window) -> impl Iterator<Item = &Shape> {
    window.output().shapes.iter().map(|clipped| &clipped.shape)
}

/// The pictures in the order in which they are drawn.
pub(crate) fn pictures(window: &Window) -> Vec<Laid> {
    let laid = |shape: &Shape| {
        let Shape::Mesh(mesh) = shape else { return None };
        (mesh.texture_id != TextureId::default()).then(|| Laid {
            rect: mesh.calc_bounds(),
            part: Rect::from_min_max(mesh.vertices[0].uv, mesh.vertices[3].uv),
            tint: mesh.vertices[0].color,
            image: Textures::image(&window.ctx, mesh.texture_id),
        })
    };
    shapes(window).filter_map(laid).collect()
}

/// All texts.
pub(crate) fn texts(window: &Window) -> Vec<String> {
    let text = |shape: &Shape| if let Shape::Text(text) = shape { Some(text.galley.text().to_owned()) } else { None };
    shapes(window).filter_map(text).collect()
}

/// Whether a text holds these words.
pub(crate) fn says(window: &Window, words: &str) -> bool {
    texts(window).iter().any(|text| text.contains(words))
}

/// Filled rectangles.
pub(crate) fn fills(window: &Window) -> Vec<(Rect, Color32)> {
    let fill = |shape: &Shape| if let Shape::Rect(rect) = shape { Some((rect.rect, rect.fill)) } else { None };
    shapes(window).filter_map(fill).collect()
}

/// Straight lines of a width.
pub(crate) fn segments(window: &Window, width: f32) -> Vec<[Pos2; 2]> {
    let segment = |shape: &Shape| match shape {
        Shape::LineSegment { points, stroke: Stroke { width: own, .. } } if *own == width => Some(*points),
        _ => None,
    };
    shapes(window).filter_map(segment).collect()
}

/// The number of lines of many points.
pub(crate) fn curves(window: &Window) -> usize {
    shapes(window).filter(|shape| matches!(shape, Shape::Path(path) if path.points.len() > 8 && !path.closed)).count()
}

/// The number of meshes of one colour.
pub(crate) fn meshes(window: &Window, color: Color32) -> usize {
    let is_it = |shape: &&Shape| matches!(shape, Shape::Mesh(mesh) if mesh.texture_id == TextureId::default() && mesh.vertices.iter().all(|vertex| vertex.color == color));
    shapes(window).filter(is_it).count()
}

/// The number of pixels that something covers where the cards of the stage are not, at rest, in all frames.
pub(crate) fn beside_cards(image: &ColorImage) -> usize {
    let [width, height] = image.size;
    assert_eq!([width, height], [96, 54], "the size of the frame");
    let is_card = |x: usize, y: usize| (10..=43).contains(&y) && ((9..=43).contains(&x) || (52..=86).contains(&x));
    let opaque = |place: &usize| image.pixels[*place].a() > 128;
    (0..width * height).filter(opaque).filter(|place| !is_card(place % width, place / width)).count()
}
