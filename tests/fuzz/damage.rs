//! Damages: bytes flipped, numbers set to their limits, stretches cut, doubled and moved, words put where they do not belong.

/// Numbers from a seed (xorshift by G. Marsaglia, 2003): a case can be repeated.
pub(crate) struct Rng(u64);

impl Rng {
    /// `seed` and `case` select the generator of one case.
    pub(crate) fn new(seed: u64, case: u64) -> Self {
        let mut rng = Self((seed ^ case.wrapping_mul(0x9E37_79B9_7F4A_7C15)).max(1));
        (0..8).for_each(|_| _ = rng.next());
        rng
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }

    pub(crate) fn pick<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}

/// Where heads of binary files say what follows, most damage is done.
const HEAD: usize = 1024;

/// A sound file with one damage, or, in one case of four, up to four.
pub(crate) fn damaged(sound: &[u8], words: &[&str], rng: &mut Rng) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    let more = if rng.below(4) == 0 { rng.below(4) } else { 0 };
    for _ in 0..=more {
        if words.is_empty() { damage_bytes(&mut bytes, rng) } else { damage_text(&mut bytes, words, rng) }
    }
    bytes
}

fn place(bytes: &[u8], rng: &mut Rng) -> usize {
    let reach = if rng.below(2) == 0 { HEAD.min(bytes.len()) } else { bytes.len() };
    rng.below(reach)
}

fn damage_bytes(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let at = place(bytes, rng);
    match rng.below(8) {
        0..=2 => overwrite(bytes, at, &[rng.below(256) as u8]),
        3 => {
            let value = *rng.pick(&[0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x0001_0000, 0x00ff_ffff_u32]);
            overwrite(bytes, at, &if rng.below(2) == 0 { value.to_le_bytes() } else { value.to_be_bytes() });
        }
        4 => overwrite(bytes, at, &[0xff; 8]),
        _ => damage_stretch(bytes, at, rng),
    }
}

fn overwrite(bytes: &mut [u8], at: usize, with: &[u8]) {
    bytes.iter_mut().skip(at).zip(with).for_each(|(byte, with)| *byte = *with);
}

/// Cuts, doubles or moves a stretch.
fn damage_stretch(bytes: &mut Vec<u8>, at: usize, rng: &mut Rng) {
    let end = (at + rng.below(64)).min(bytes.len());
    match rng.below(4) {
        0 => bytes.truncate(at),
        1 => _ = bytes.drain(at..end),
        2 => {
            let stretch = bytes[at..end].to_vec();
            let to = place(bytes, rng);
            _ = bytes.splice(to..to, stretch);
        }
        _ => {
            let stretch = bytes[at..end].to_vec();
            let to = place(bytes, rng);
            overwrite(bytes, to, &stretch);
        }
    }
}

/// Mostly replaces a number by a word; files stay text.
fn damage_text(bytes: &mut Vec<u8>, words: &[&str], rng: &mut Rng) {
    let at = rng.below(bytes.len());
    match rng.below(8) {
        0 => damage_bytes(bytes, rng),
        1 => damage_stretch(bytes, at, rng),
        2 => _ = bytes.splice(at..at, rng.pick(words).bytes()),
        _ => {
            let is_number = |byte: &u8| byte.is_ascii_digit() || b".-+e".contains(byte);
            let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|from| at + from) else { return };
            let start = start - bytes[..start].iter().rev().take_while(|byte| is_number(byte)).count();
            let end = start + bytes[start..].iter().take_while(|byte| is_number(byte)).count();
            _ = bytes.splice(start..end, rng.pick(words).bytes());
        }
    }
}
