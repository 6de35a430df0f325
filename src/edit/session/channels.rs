//! Rotation or scale of a pin with keys of their own: keyed separately, and joined again.
//!
//! In: user commands. Out: one document change each, which leaves the motion as it is.

use super::Session;
use crate::edit::channel_keys::{rotation_apart, rotation_joined, scale_apart, scale_joined};
use crate::edit::curve::Channel;
use crate::edit::track_keys::{Track, TrackKeys};
use crate::shot::Pin;

impl Session {
    /// Gives the rotation or scale of a pin keys of its own, in the frames and with the eases of the pin's keys.
    pub(crate) fn key_separately(&mut self, at: [usize; 2], channel: Channel) {
        let Some(pin) = Track::Pin(at).own_pin(self.document.shot()) else { return };
        let apart = if channel == Channel::Scale {
            scale_apart(pin).map(|(rest, own)| (rest, (Track::Scale(at), TrackKeys::Scale(own))))
        } else {
            rotation_apart(pin).map(|(rest, own)| (rest, (Track::Rotation(at), TrackKeys::Rotation(own))))
        };
        let name = name_of(channel);
        let Some((rest, own)) = apart else {
            return self.say(format!("The {name} of '{}' has no keys among those of the pin.", pin.name));
        };
        let label = format!("Key {name} separately");
        self.write_keys(&label, &[(at.into(), TrackKeys::Pin(rest)), own], None);
    }

    /// Puts rotation or scale back among the keys of a pin, if that does not change the motion.
    pub(crate) fn join_channel(&mut self, at: [usize; 2], channel: Channel) {
        let Some(pin) = Track::Pin(at).own_pin(self.document.shot()).filter(|pin| is_apart(pin, channel)) else {
            return;
        };
        let (joined, emptied) = match channel {
            Channel::Scale => (scale_joined(pin), (Track::Scale(at), TrackKeys::Scale(Vec::new()))),
            _ => (rotation_joined(pin), (Track::Rotation(at), TrackKeys::Rotation(Vec::new()))),
        };
        let name = name_of(channel);
        match joined {
            Ok(keys) => {
                _ = self.write_keys(&format!("Join {name}"), &[emptied, (at.into(), TrackKeys::Pin(keys))], None)
            }
            Err(why) => self.say(format!("The {name} of '{}' cannot be joined as it is: {why}.", pin.name)),
        }
    }

    /// Returns whether rotation or scale of a pin has keys of its own.
    #[must_use]
    pub(crate) fn is_keyed_separately(&self, at: [usize; 2], channel: Channel) -> bool {
        Track::Pin(at).own_pin(self.shot()).is_some_and(|pin| is_apart(pin, channel))
    }
}

const fn is_apart(pin: &Pin, channel: Channel) -> bool {
    match channel {
        Channel::Scale => !pin.scale_keys.is_empty(),
        _ => !pin.rotate_keys.is_empty(),
    }
}

const fn name_of(channel: Channel) -> &'static str {
    if matches!(channel, Channel::Scale) { "scale" } else { "rotation" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::EasePreset;
    use crate::shot::{Ease, PinKey, Rotation};

    const TEXT: &str = "# mine
scene = 'a.glb'
frames = { first = 1, last = 24 }

[[layer]]
name = 'a'

  [[layer.pin]]
  name   = 'p'
  anchor = { screen = [0.5, 0.5], frame = 1 }
  keys   = [ { frame = 1, offset = [0.0, 0.0], rotate = 0, scale = 2 }, # first
             { frame = 9, offset = [0.3, 0.1], rotate = 80, scale = 1, ease = 'smooth' } ]

  [[layer.pin]]
  name   = 'q'
  anchor = { screen = [0.2, 0.5], frame = 1 }
  keys   = [ { frame = 1, offset = [0.0, 0.0], rotate = 5 } ]

  [[layer.pin]]
  name   = 'r'
  mirror = 'p'
";

    const AT: [usize; 2] = [0, 0];

    fn pin(session: &Session) -> &Pin {
        &session.document().shot().layers[0].pins[0]
    }

    fn turned(session: &Session) -> Vec<(f64, Rotation, Ease)> {
        pin(session).rotate_keys.iter().map(|key| (key.frame, key.value, key.ease)).collect()
    }

    fn apart() -> Session {
        let mut session = Session::of_text(TEXT);
        session.key_separately(AT, Channel::Rotation);
        session
    }

    #[test]
    fn a_channel_is_keyed_separately_and_joined_in_one_step_each() {
        let mut session = apart();
        let linear = Ease::Linear;
        let keys = [(1.0, Rotation::InView(0.0), linear), (9.0, Rotation::InView(80.0), Ease::Smooth)];
        assert_eq!(turned(&session), keys);
        assert!(pin(&session).keys.iter().all(|key| key.rotate_degrees.is_none() && key.scale.is_some()));
        let text = session.document().text().to_owned();
        assert!(text.contains("# first") && text.contains("\n  rotate_keys = [ { frame = 1, value = 0.0 },"), "{text}");
        let labels: Vec<&str> = session.document().history().labels().collect();
        assert_eq!(labels, ["Key rotation separately"]);
        assert!(session.is_keyed_separately(AT, Channel::Rotation) && !session.is_keyed_separately(AT, Channel::Scale));
        // The mirrored pin follows, and has no keys to be parted.
        assert_eq!(session.document().shot().layers[0].pins[2].rotate_keys, pin(&session).rotate_keys);
        session.key_separately([0, 2], Channel::Scale);
        assert!(session.message().is_some_and(|text| text.contains("follows 'p'")), "{:?}", session.message());
        session.join_channel(AT, Channel::Rotation);
        assert_eq!(*pin(&session), *pin(&Session::of_text(TEXT)));
        session.undo();
        assert_eq!(session.document().text(), text);
        session.undo();
        assert_eq!(session.document().text(), TEXT);
        // A free channel has nothing to key.
        session.key_separately([0, 1], Channel::Scale);
        assert!(session.message().is_some_and(|text| text.contains("no keys")), "{:?}", session.message());
        assert_eq!(session.document().text(), TEXT);
    }

    #[test]
    fn selected_keys_of_a_channel_are_edited_alone() {
        let mut session = apart();
        let (text, before) = (session.document().text().to_owned(), pin(&session).clone());
        let row = Track::Rotation(AT);
        let names: Vec<String> = session.tracks().iter().map(|track| track.name(session.shot())).collect();
        assert_eq!(names, ["p", "p rotation", "q", "r", "r rotation"]);
        session.choose_key(row, 9.0, false);
        session.shift_keys(3);
        session.ease_keys(EasePreset::Hold);
        assert_eq!(turned(&session)[1], (12.0, Rotation::InView(80.0), Ease::Hold));
        session.raise_keys(Channel::Rotation, 5.0);
        assert_eq!(turned(&session)[1].1, Rotation::InView(85.0));
        assert_eq!(session.curve_keys(row, Channel::Rotation), [[1.0, 0.0], [12.0, 85.0]]);
        assert!(session.curve_keys(row, Channel::X).is_empty() && session.curve_keys(AT, Channel::Rotation).is_empty());
        assert_eq!(session.curve(row, Channel::Rotation, &[1.0, 12.0]), [[1.0, 0.0], [12.0, 85.0]]);
        session.move_curve_key((row, 12.0), Channel::Rotation, [6.0, 30.0]);
        assert_eq!((turned(&session)[1].0, turned(&session)[1].1), (6.0, Rotation::InView(30.0)));
        session.delete_keys();
        assert_eq!(turned(&session).len(), 1);
        assert_eq!((&pin(&session).keys, &pin(&session).scale_keys), (&before.keys, &before.scale_keys));
        for _ in 0..5 {
            session.undo();
        }
        assert_eq!(session.document().text(), text);
    }

    #[test]
    fn typed_and_inserted_keys_go_to_their_channel() {
        let mut session = apart();
        let before = pin(&session).clone();
        session.go(5);
        let key = session.key_here(AT).expect("a pin");
        assert!(key.rotate_degrees.is_some() && key.scale.is_some(), "all channels are shown: {key:?}");
        session.put_key(AT, PinKey { rotate_degrees: Some(Rotation::InView(10.0)), ..key });
        assert_eq!(pin(&session).keys, before.keys);
        assert_eq!(turned(&session)[1], (5.0, Rotation::InView(10.0), Ease::Linear));
        assert!(session.has_key_here(AT));
        let own = pin(&session).rotate_keys.clone();
        let key = session.key_here(AT).expect("a pin");
        session.put_key(AT, PinKey { scale: Some(3.0), ..key });
        assert_eq!((pin(&session).keys.len(), pin(&session).keys[1].scale), (3, Some(3.0)));
        assert_eq!(pin(&session).rotate_keys, own);
        session.go(7);
        session.selection.only_pin(AT);
        session.insert_keys();
        assert_eq!((pin(&session).keys.len(), pin(&session).rotate_keys.len()), (4, 4));
        session.free_channel(AT, Channel::Rotation);
        assert!(pin(&session).rotate_keys.is_empty() && !session.document().text().contains("rotate_keys"));
    }

    #[test]
    fn pasted_keys_find_their_channel_or_are_refused() {
        let mut session = apart();
        // Of a pin that holds all channels in its keys, onto one whose rotation is apart.
        session.choose_key([0, 1], 1.0, false);
        session.copy_keys();
        session.selection.only_pin(AT);
        session.go(5);
        session.paste_keys();
        assert_eq!(turned(&session)[1], (5.0, Rotation::InView(5.0), Ease::Linear));
        assert_eq!(pin(&session).keys.iter().map(|key| key.frame).collect::<Vec<_>>(), [1.0, 5.0, 9.0]);
        assert!(pin(&session).keys.iter().all(|key| key.rotate_degrees.is_none()));
        // Keys of the rotation alone need such keys.
        let text = session.document().text().to_owned();
        session.selection.clear();
        session.choose_key(Track::Rotation(AT), 9.0, false);
        session.copy_keys();
        session.selection.only_pin([0, 1]);
        session.paste_keys();
        assert!(session.message().is_some_and(|text| text.contains("separately first")), "{:?}", session.message());
        assert_eq!(session.document().text(), text);
        session.selection.only_pin(AT);
        session.go(12);
        session.paste_keys();
        assert_eq!(turned(&session).last(), Some(&(12.0, Rotation::InView(80.0), Ease::Smooth)));
        assert_eq!(pin(&session).keys.len(), 3);
    }
}
