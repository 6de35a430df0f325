//! User-facing messages about a warp: pins that miss their targets, folded cells, pins off the model.
//!
//! In: a [`Warp`], and how its host names pins and formats positions. Out: [`Notice`]s.

use super::Warp;
use super::warp::{ActingPin, Warning};
use crate::solve::{PinResidual, ResidualReason, SolveReport};
use crate::space::ScreenPoint;
use crate::spelling::pluralised;

/// Pins closer to their targets than this, in pixels, count as exact.
const MIN_PX: f64 = 0.05;

/// Maximum number of pins named in one sentence.
const MAX_NAMES: usize = 8;

/// A message for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Notice {
    /// Its subject, without numbers that change from frame to frame.
    pub subject: String,
    /// The message.
    pub text: String,
}

/// How a host names pins and formats positions.
#[derive(Clone, Copy)]
pub(crate) struct Wording<'a> {
    /// Returns the name of a pin of the controls by its index: "3" or "nose".
    pub pin: &'a dyn Fn(usize) -> String,
    /// Formats a position with its unit.
    pub place: &'a dyn Fn(ScreenPoint) -> String,
    /// Pixels per frame height.
    pub pixels: f64,
}

impl Warp {
    /// Returns the messages for the user, most important first.
    #[must_use]
    pub(crate) fn notices(&self, wording: &Wording) -> Vec<Notice> {
        let mut notices: Vec<Notice> = self.report.iter().flat_map(|report| self.of_report(report, wording)).collect();
        notices.extend(self.warnings.iter().map(|warning| match warning {
            Warning::Text(text) => Notice { subject: text.clone(), text: text.clone() },
            Warning::BorderGivesWay { pin, by } => {
                let (name, by) = (self.name_of(*pin, wording), pixels(by * wording.pixels));
                let text = format!("pin {name} comes too close to the border for its path; the border moves by {by} there");
                Notice { subject: format!("border at pin {name}"), text }
            }
            Warning::OffModel { pin, at, frame } => {
                let (name, at) = ((wording.pin)(*pin), (wording.place)(*at));
                let text = format!(
                    "pin {name} is off the model, at {at} in frame {frame}, and stays fixed on the screen; move it onto the model"
                );
                Notice { subject: format!("pin {name} off the model"), text }
            }
        }));
        notices
    }

    fn of_report(&self, report: &SolveReport, wording: &Wording) -> Vec<Notice> {
        let mut notices = Vec::new();
        let misses = report.pin_residuals.iter();
        let mut misses: Vec<&PinResidual> = misses
            .filter(|miss| miss.reason != ResidualReason::Fading && miss.distance * wording.pixels > MIN_PX)
            .collect();
        misses.sort_by(|a, b| b.distance.total_cmp(&a.distance));
        if let Some(worst) = misses.first() {
            let mut pins: Vec<usize> = misses.iter().map(|miss| miss.pin).collect();
            pins.sort_unstable();
            let names: Vec<String> = pins.iter().map(|pin| self.name_of(*pin, wording)).collect();
            let by = pixels(worst.distance * wording.pixels);
            let who = self.name_of(worst.pin, wording);
            let reason = worst.reason.words(|pin| self.name_of(pin, wording));
            let text = match (worst.reason, names.len()) {
                (ResidualReason::Guard, _) => {
                    format!("pins stop before the picture folds: pin {who} stops {by} short of its target")
                }
                (_, 1) => format!("pin {who} misses its target by {by}: {reason}"),
                (_, _) => {
                    let all = listed(&names);
                    format!("pins {all} miss their targets, by up to {by} (pin {who}): {reason}")
                }
            };
            notices.push(Notice { subject: format!("misses of {}", names.join(" ")), text });
        }
        if report.folded_model_cells > 0 {
            let cells = pluralised(report.folded_model_cells, "cell of the lattice folds", "cells of the lattice fold");
            let text = format!(
                "{cells} over, so parts of the picture overlap; move pins apart, or enable \"Stop before folds\""
            );
            notices.push(Notice { subject: "folds".into(), text });
        }
        notices
    }

    fn name_of(&self, acting: usize, wording: &Wording) -> String {
        match self.acting.get(acting) {
            Some(ActingPin::OfShot(name)) => format!("'{name}' of the shot"),
            Some(ActingPin::OfControls(pin)) => (wording.pin)(*pin),
            None => (acting + 1).to_string(),
        }
    }
}

fn pixels(distance: f64) -> String {
    if distance < 9.95 { format!("{distance:.1} px") } else { format!("{distance:.0} px") }
}

/// Joins names: "1, 2 and 3"; long lists are cut with the number of the rest.
fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [only] => only.clone(),
        _ if names.len() > MAX_NAMES => {
            format!("{} and {} more", names[..MAX_NAMES].join(", "), names.len() - MAX_NAMES)
        }
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_listed_as_in_a_sentence() {
        let names = |count: usize| (1..=count).map(|name| name.to_string()).collect::<Vec<_>>();
        assert_eq!(listed(&names(1)), "1");
        assert_eq!(listed(&names(3)), "1, 2 and 3");
        assert_eq!(listed(&names(12)), "1, 2, 3, 4, 5, 6, 7, 8 and 4 more");
        assert_eq!([pixels(0.06), pixels(126.4)], ["0.1 px", "126 px"]);
    }
}
