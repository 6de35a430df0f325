//! Selects the layers of a plate that are pictures, as opposed to passes and data, by their semantics.
//!
//! In: a plate, the shot's channel patterns. Out: the [`ColorLayer`]s of one view in file order, and notes on the layers left out.

use super::Semantic;
use super::SemanticReason;
use super::channel_table::{BEAUTY, ChannelEntry, ChannelTable};
use crate::image::{Channel, Plate, PlatePart};

/// A layer of colour channels.
#[derive(Clone, Debug)]
pub(crate) struct ColorLayer<'a> {
    /// The part that stores the layer.
    pub(crate) part: &'a PlatePart,
    /// Name without the view: `hair` for `hair.left.R`; empty if the channels belong to no layer.
    pub(crate) name: String,
    /// Red, green, blue and alpha, where present; a luminance channel stands for all three colours. Each: #pixels of the part.
    pub(crate) channels: [Option<&'a Channel>; 4],
}

/// How a layer relates to the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// Marked as colour by the shot.
    Chosen,
    /// The complete picture.
    Beauty,
    /// A lighting or shading pass, recognised by its name.
    Pass,
    /// Colour under a name that renderers do not use, for example `hair`.
    Drawn,
    /// Not colour.
    Data,
}

/// The channels of one layer and view.
struct Layer<'c> {
    entries: Vec<&'c ChannelEntry>,
}

/// Returns the layers that make up the picture, from the first view that has colour.
///
/// These are the layers that the shot marks as colour, and the beauty. Drawn layers are included unless the file is a
/// render, that is, has a beauty next to passes or data. Without a beauty, passes are included as layers.
///
/// The second result lists what is left out and why: `albedo (a pass of the picture; ...)`.
#[must_use]
pub(crate) fn color_layers<'a>(
    plate: &'a Plate,
    patterns: &[(String, Semantic)],
) -> (Vec<ColorLayer<'a>>, Vec<String>) {
    let table = ChannelTable::of(plate, patterns);
    let layers = Layer::all_of(&table);
    let view = layers.iter().find(|layer| layer.role() != Role::Data).and_then(Layer::view);
    let (shown, others): (Vec<_>, Vec<_>) =
        layers.into_iter().partition(|layer| layer.view().is_none_or(|own| Some(own) == view));
    let has = |role: Role| shown.iter().any(|layer| layer.role() == role);
    let has_beauty = has(Role::Beauty);
    let is_render = has_beauty && (has(Role::Pass) || has(Role::Data));
    let (painted, passed): (Vec<_>, Vec<_>) = shown.iter().partition(|layer| match layer.role() {
        Role::Chosen | Role::Beauty => true,
        Role::Pass => !has_beauty,
        Role::Drawn => !is_render,
        Role::Data => false,
    });
    let (data, passes): (Vec<&Layer>, Vec<_>) = passed.into_iter().partition(|layer| layer.role() == Role::Data);
    let data = data.into_iter().flat_map(Layer::names).chain(painted.iter().flat_map(|layer| layer.other_names()));
    let left_out = [
        words(
            passes.into_iter().flat_map(Layer::names),
            "already contained in the picture; mark them as color in [[warp.channels]] to include them",
        ),
        words(data, "no colour"),
        words(
            others.iter().filter_map(|layer| layer.view().map(str::to_owned)),
            "belong to views other than the first",
        ),
    ];
    let layers = painted.into_iter().map(|layer| layer.colors(&table)).collect();
    (layers, left_out.into_iter().flatten().collect())
}

/// Joins the distinct names and appends the reason; `None` if there are no names.
fn words(names: impl Iterator<Item = String>, why: &str) -> Option<String> {
    let mut told: Vec<String> = Vec::new();
    for name in names {
        if !told.contains(&name) {
            told.push(name);
        }
    }
    (!told.is_empty()).then(|| format!("{} ({why})", told.join(", ")))
}

impl<'c> Layer<'c> {
    fn all_of(table: &'c ChannelTable) -> Vec<Self> {
        let mut layers: Vec<Self> = Vec::new();
        for entry in &table.entries {
            match layers.iter_mut().find(|layer| layer.holds(entry)) {
                Some(layer) => layer.entries.push(entry),
                None => layers.push(Self { entries: vec![entry] }),
            }
        }
        layers
    }

    fn first(&self) -> &'c ChannelEntry {
        self.entries.first().expect("layers are made of a channel at least")
    }

    fn holds(&self, entry: &ChannelEntry) -> bool {
        let (own, other) = (&self.first().name, &entry.name);
        self.first().index.part == entry.index.part && own.segments == other.segments && own.view == other.view
    }

    fn view(&self) -> Option<&'c str> {
        self.first().name.view.as_deref()
    }

    fn component(&self, wanted: &str) -> Option<&'c ChannelEntry> {
        self.entries.iter().copied().find(|entry| entry.name.component.eq_ignore_ascii_case(wanted))
    }

    /// Returns the red, green and blue channels that hold colour; luminance stands for all three.
    fn color(&self) -> [Option<&'c ChannelEntry>; 3] {
        let is_color = |entry: &&ChannelEntry| entry.class.semantic == Semantic::Color;
        let grey = self.component("Y").filter(is_color);
        ["R", "G", "B"].map(|name| self.component(name).filter(is_color).or(grey))
    }

    fn role(&self) -> Role {
        let color = self.color();
        let Some(first) = color.into_iter().flatten().next() else { return Role::Data };
        let is_beauty = first.name.layer_word().is_none_or(|word| BEAUTY.contains(&word));
        match first.class.reason {
            SemanticReason::Shot => Role::Chosen,
            _ if is_beauty => Role::Beauty,
            SemanticReason::Name | SemanticReason::Metadata => Role::Pass,
            SemanticReason::Guess => Role::Drawn,
        }
    }

    /// Returns the layer's name, or the names of its channels if they belong to no layer.
    fn names(&self) -> Vec<String> {
        let name = &self.first().name;
        match (name.segments.as_slice(), &name.part) {
            ([], Some(part)) => vec![part.clone()],
            ([], None) => self.entries.iter().map(|entry| entry.name.full.clone()).collect(),
            (segments, _) => vec![segments.join(".")],
        }
    }

    /// Returns the names of channels in the same layer that are not colour: `Z` next to `R`.
    fn other_names(&self) -> Vec<String> {
        let is_other = |entry: &&&ChannelEntry| !matches!(entry.class.semantic, Semantic::Color | Semantic::Alpha);
        self.entries.iter().filter(is_other).map(|entry| entry.name.full.clone()).collect()
    }

    fn colors<'a>(&self, table: &ChannelTable<'a>) -> ColorLayer<'a> {
        let [red, green, blue] = self.color();
        let channel = |entry: Option<&ChannelEntry>| entry.map(|entry| table.channel(entry.index));
        ColorLayer {
            part: &table.plate.parts[self.first().index.part],
            name: self.first().name.segments.join("."),
            channels: [red, green, blue, self.component("A")].map(channel),
        }
    }
}
