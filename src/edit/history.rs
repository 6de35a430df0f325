//! Undo and redo history of a text: unlimited, and kept across saves.
//!
//! In: [`Command`]s as they are executed. Out: the texts before and after them.

use super::command::Command;

/// Executed and undone commands.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    done: Vec<Command>,
    undone: Vec<Command>,
    /// The series that the last command belongs to, if it may be extended: nudges or typed digits of one kind.
    open: Option<String>,
}

impl History {
    /// Records an executed change. Consecutive changes with the same `series` are merged. Returns what a journal has to
    /// record: the command, and whether it replaces the last one.
    pub(crate) fn record(&mut self, command: Command, series: Option<&str>, before: &str) -> Recorded {
        let goes_on = series.is_some() && series == self.open.as_deref() && self.undone.is_empty();
        self.undone.clear();
        self.open = series.map(str::to_owned);
        let joined = (goes_on)
            .then(|| {
                let last = self.done.last()?;
                let (start, end) = (last.undo(before)?, command.apply(before)?);
                Some(Command::between(&command.label, &start, &end))
            })
            .flatten();
        match joined {
            None => {
                self.done.push(command.clone());
                Recorded::Added(command)
            }
            Some(joined) => {
                if joined.is_none() {
                    // The command before belongs to another series.
                    self.open = None;
                }
                self.done.pop();
                self.done.extend(joined.clone());
                Recorded::Joined(joined)
            }
        }
    }

    /// Repeats a recorded change; returns the text after it. `None`, and no effect, if it does not fit the text.
    pub(super) fn repeat(&mut self, recorded: Recorded, text: &str) -> Option<String> {
        let (after, last) = match recorded {
            Recorded::Added(command) => (command.apply(text)?, Some(command)),
            Recorded::Joined(command) => {
                let before = self.done.last()?.undo(text)?;
                let after = match &command {
                    Some(command) => command.apply(&before)?,
                    None => before,
                };
                self.done.pop();
                (after, command)
            }
        };
        self.done.extend(last);
        self.undone.clear();
        self.open = None;
        Some(after)
    }

    /// Ends the series: the next change is undone separately.
    pub(crate) fn end_series(&mut self) {
        self.open = None;
    }

    /// Undoes the last command: returns the text before it, and the command.
    pub(crate) fn undo(&mut self, text: &str) -> Option<(String, Command)> {
        let before = self.done.last()?.undo(text)?;
        let command = self.done.pop()?;
        self.undone.push(command.clone());
        self.open = None;
        Some((before, command))
    }

    /// Redoes the command undone last: returns the text after it, and the command.
    pub(crate) fn redo(&mut self, text: &str) -> Option<(String, Command)> {
        let after = self.undone.last()?.apply(text)?;
        let command = self.undone.pop()?;
        self.done.push(command.clone());
        self.open = None;
        Some((after, command))
    }

    /// Returns the labels of all executed commands, oldest first.
    pub(crate) fn labels(&self) -> impl Iterator<Item = &str> {
        self.done.iter().map(|command| command.label.as_str())
    }
}

/// How a change was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Recorded {
    /// As a separate command.
    Added(Command),
    /// Merged with the last command; `None` if the two cancel out.
    Joined(Option<Command>),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(history: &mut History, text: &mut String, to: &str, series: Option<&str>) {
        let command = Command::between(to, text, to).expect("they differ");
        history.record(command, series, text);
        *text = to.to_owned();
    }

    #[test]
    fn everything_is_undone_and_done_again_in_order() {
        let (mut history, mut text) = (History::default(), "zero".to_owned());
        for number in 0..500 {
            change(&mut history, &mut text, &format!("number {number}"), None);
        }
        for number in (0..499).rev() {
            (text, _) = history.undo(&text).expect("there is more");
            assert_eq!(text, format!("number {number}"));
        }
        (text, _) = history.undo(&text).expect("the first");
        assert_eq!((text.as_str(), history.undo(&text)), ("zero", None));
        for _ in 0..500 {
            (text, _) = history.redo(&text).expect("there is more");
        }
        assert_eq!((text.as_str(), history.redo(&text)), ("number 499", None));
    }

    #[test]
    fn a_series_is_undone_at_once_and_a_new_change_forgets_what_was_undone() {
        let (mut history, mut text) = (History::default(), "a".to_owned());
        change(&mut history, &mut text, "b", None);
        change(&mut history, &mut text, "c", Some("nudge"));
        change(&mut history, &mut text, "d", Some("nudge"));
        change(&mut history, &mut text, "e", Some("type"));
        (text, _) = history.undo(&text).expect("typing");
        assert_eq!(text, "d");
        (text, _) = history.undo(&text).expect("both nudges");
        assert_eq!(text, "b");
        change(&mut history, &mut text, "f", Some("nudge"));
        assert_eq!((history.redo(&text), history.labels().count()), (None, 2));
    }

    #[test]
    fn a_series_that_cancels_out_leaves_the_command_before_it_alone() {
        let (mut history, mut text) = (History::default(), "a".to_owned());
        change(&mut history, &mut text, "b", None);
        for to in ["c", "b", "d"] {
            change(&mut history, &mut text, to, Some("nudge"));
        }
        assert_eq!(history.labels().count(), 2);
        (text, _) = history.undo(&text).expect("the last nudge");
        assert_eq!(text, "b");
        (text, _) = history.undo(&text).expect("the first change");
        assert_eq!(text, "a");
    }

    #[test]
    fn a_repeated_history_is_the_same() {
        let (mut history, mut again, mut text) = (History::default(), History::default(), "a".to_owned());
        for (to, series) in [("b", None), ("c", Some("n")), ("b", Some("n")), ("d", Some("n")), ("e", Some("n"))] {
            let command = Command::between(to, &text, to).expect("they differ");
            let recorded = history.record(command, series, &text);
            text = again.repeat(recorded, &text).expect("it fits");
            assert_eq!(text, to);
        }
        assert_eq!((&history.done, &history.undone), (&again.done, &again.undone));
        let command = Command::between("edit", "other", "others").expect("they differ");
        assert_eq!(again.repeat(Recorded::Joined(Some(command)), &text), None);
        assert_eq!(again.done, history.done, "what does not fit has no effect");
    }
}
