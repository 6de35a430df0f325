//! Places the names of pins beside them, so that they cover neither each other nor other pins.
//!
//! In: the places of all pins, then the size of each name. Out: where the name is written, if there is room.

use eframe::egui::{Align2, Pos2, Rect, Vec2, vec2};

/// Usual distance between a pin and its name, in points.
pub(super) const GAP: f32 = 10.0;

/// Half the side of the square that a pin keeps free, in points.
const PIN: f32 = 5.0;

/// Margin around a name in points.
pub(super) const MARGIN: Vec2 = vec2(3.0, 1.0);

/// A name to be placed.
#[derive(Clone, Copy, Debug)]
pub(super) struct PinName {
    /// The pin.
    pub(super) at: Pos2,
    pub(super) size: Vec2,
    /// Distance between the pin and the name.
    pub(super) gap: f32,
    /// Whether the name is written in any case, as that of a selected pin is.
    pub(super) is_needed: bool,
}

/// What names must not cover.
#[derive(Debug)]
pub(super) struct NamePlaces(Vec<Rect>);

impl NamePlaces {
    /// Places no name yet.
    pub(super) fn among(pins: impl Iterator<Item = Pos2>) -> Self {
        Self(pins.map(|pin| Rect::from_center_size(pin, Vec2::splat(2.0 * PIN))).collect())
    }

    /// Returns where a name is written: on the first side of its pin that is free. Where none is, a name that is needed is
    /// written in the first free row below; others are left out.
    pub(super) fn place(&mut self, name: PinName) -> Option<Rect> {
        let gap = name.gap;
        let side = |align: Align2, away: Vec2| align.anchor_size(name.at + away, name.size);
        let right = side(Align2::LEFT_CENTER, vec2(gap, 0.0));
        let sides = [
            right,
            side(Align2::RIGHT_CENTER, vec2(-gap, 0.0)),
            side(Align2::CENTER_BOTTOM, vec2(0.0, -gap)),
            side(Align2::CENTER_TOP, vec2(0.0, gap)),
        ];
        let row = name.size.y + 2.0 * MARGIN.y;
        let rows =
            (1..).take_while(|_| name.is_needed).map(|rows: u16| right.translate(vec2(0.0, f32::from(rows) * row)));
        let place = sides.into_iter().chain(rows).find(|place| self.is_free(*place))?;
        self.0.push(place.expand2(MARGIN));
        Some(place)
    }

    fn is_free(&self, place: Rect) -> bool {
        let place = place.expand2(MARGIN).shrink(0.01);
        !self.0.iter().any(|other| other.intersects(place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::pos2;

    fn name([x, y]: [f32; 2], is_needed: bool) -> PinName {
        PinName { at: pos2(x, y), size: vec2(40.0, 14.0), gap: GAP, is_needed }
    }

    fn placed(names: &[PinName]) -> Vec<Option<Rect>> {
        let mut places = NamePlaces::among(names.iter().map(|name| name.at));
        names.iter().map(|name| places.place(*name)).collect()
    }

    /// Checks that names cover neither each other nor pins.
    fn assert_free(names: &[PinName], places: &[Option<Rect>]) {
        let seen: Vec<Rect> = places.iter().flatten().copied().collect();
        for (index, place) in seen.iter().enumerate() {
            assert!(seen[..index].iter().all(|other| !other.intersects(*place)), "{place:?} in {seen:?}");
            assert!(names.iter().all(|name| !place.contains(name.at)), "{place:?} covers a pin");
        }
    }

    #[test]
    fn names_go_to_each_side_and_then_are_left_out() {
        let names = [[100.0, 100.0]; 5].map(|at| name(at, false));
        let places = placed(&names);
        assert_free(&names, &places);
        let sides: Vec<Option<Vec2>> =
            places.iter().map(|place| Some(place.as_ref()?.center() - names[0].at)).collect();
        let [across, along] = [30.0, 17.0];
        let [right, left] = [vec2(across, 0.0), vec2(-across, 0.0)];
        assert_eq!(sides, [Some(right), Some(left), Some(vec2(0.0, -along)), Some(vec2(0.0, along)), None]);
    }

    #[test]
    fn needed_names_are_never_left_out_and_cover_nothing() {
        let names: Vec<PinName> =
            (0..60).map(|index| name([(37 * index % 101) as f32, (53 * index % 67) as f32], index < 20)).collect();
        let places = placed(&names);
        assert_free(&names, &places);
        assert!(places[..20].iter().all(Option::is_some) && places[20..].contains(&None), "{places:?}");
    }
}
