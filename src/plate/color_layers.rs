//! The layers of a plate that are pictures, told from passes and from data by their semantics.
//!
//! In: a plate, the shot's patterns. Out: [`ColorLayer`]s of one view in the file's order; words about all others.

use super::Semantic;
use super::SemanticReason;
use super::channel_table::{BEAUTY, ChannelEntry, ChannelTable};
use crate::image::{Channel, Plate, PlatePart};

/// A layer that shows colour.
#[derive(Clone, Debug)]
pub struct ColorLayer<'a> {
    /// Where it is stored.
    pub part: &'a PlatePart,
    /// Its name without its view: `hair` of `hair.left.R`; empty where the channels stand in no layer.
    pub name: String,
    /// Red, green, blue and alpha, those that it has; grey is all three colours. Each #pixels of the part.
    pub channels: [Option<&'a Channel>; 4],
}

/// What a layer is to a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// Colour, as the shot says.
    Chosen,
    /// The whole picture.
    Beauty,
    /// A part of its light, by its name.
    Pass,
    /// Colour of a name that renderers do not use: `hair`.
    Drawn,
    /// No colour.
    Data,
}

/// Channels of one layer and view.
struct Layer<'c> {
    entries: Vec<&'c ChannelEntry>,
}

/// The layers of the first view that has colour: those that the shot calls colour, and the picture itself. Drawn layers
/// too, unless the file is a render: one with a beauty, and passes or data beside it. Without a beauty passes are layers.
///
/// The second result names what is left out, and why: `albedo (a pass of the picture; ...)`.
#[must_use]
pub fn color_layers<'a>(plate: &'a Plate, patterns: &[(String, Semantic)]) -> (Vec<ColorLayer<'a>>, Vec<String>) {
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
            "the picture holds them; call them color in [[warp.channels]] to paint them too",
        ),
        words(data, "no colour"),
        words(others.iter().filter_map(|layer| layer.view().map(str::to_owned)), "other views than the first"),
    ];
    let layers = painted.into_iter().map(|layer| layer.colors(&table)).collect();
    (layers, left_out.into_iter().flatten().collect())
}

/// Each name once, and why; `None` where there are none.
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

    /// Red, green and blue, those that hold colour; grey for all three.
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

    /// Its name; the names of channels that stand in no layer.
    fn names(&self) -> Vec<String> {
        let name = &self.first().name;
        match (name.segments.as_slice(), &name.part) {
            ([], Some(part)) => vec![part.clone()],
            ([], None) => self.entries.iter().map(|entry| entry.name.full.clone()).collect(),
            (segments, _) => vec![segments.join(".")],
        }
    }

    /// Channels that stand beside the colour and are none: `Z` beside `R`.
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
