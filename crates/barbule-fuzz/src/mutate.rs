//! Inputs from seeds: small damages, pieces of other seeds, words of the format, numbers at their edges.

use barbule::math::rng::Stream;

/// The longest input that is made, where no seed is longer.
const MOST_BYTES: usize = 64 << 10;

/// Inputs that were accepted and are mutated further, at most.
const KEPT: usize = 24;

/// Numbers in texts, where readers err.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "-2147483649",
    "4294967295",
    "4294967296",
    "9007199254740993",
    "18446744073709551615",
    "18446744073709551616",
    "99999999999999999999",
    "1e308",
    "1e309",
    "-1e308",
    "1e-308",
    "5e-324",
    "1e-400",
    "0.1",
    "0.30000000000000004",
    "1.7976931348623157e308",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "Infinity",
    "0x10",
    "1_000",
    "1,5",
    "1e",
    ".",
    "+",
    "1e-7",
    "360",
    "90",
    "89.999999999",
    "180",
];

/// Whole numbers in binary, where readers err.
const WHOLE: &[u64] = &[
    0,
    1,
    2,
    3,
    4,
    7,
    8,
    16,
    31,
    32,
    63,
    64,
    127,
    128,
    255,
    256,
    0x7fff,
    0x8000,
    0xffff,
    0x1_0000,
    0x00ff_ffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
    0x1_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0xffff_ffff_ffff_ffff,
];

/// Fractions in binary, where readers err.
const FRACTIONS: &[f64] = &[
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN_POSITIVE,
    5e-324,
    1e300,
    -1e300,
    3.4e38,
    1e39,
];

/// Makes the inputs of one target: the same for the same seed.
pub struct Mutator<'a> {
    stream: Stream,
    seeds: &'a [Vec<u8>],
    tokens: &'a [&'a str],
    kept: Vec<Vec<u8>>,
    most_bytes: usize,
}

impl<'a> Mutator<'a> {
    /// From at least one seed; `tokens` are words of the format.
    #[must_use]
    pub fn new(seed: u64, seeds: &'a [Vec<u8>], tokens: &'a [&'a str]) -> Self {
        let most_bytes = seeds.iter().map(Vec::len).fold(MOST_BYTES, usize::max);
        Self { stream: Stream::new(seed, &[0xf022]), seeds, tokens, kept: Vec::new(), most_bytes }
    }

    /// Remembers an input that was accepted: later ones are made of it too.
    pub fn keep(&mut self, input: &[u8]) {
        if self.kept.len() < KEPT {
            self.kept.push(input.to_vec());
        } else if self.below(8) == 0 {
            let place = self.below(KEPT);
            self.kept[place] = input.to_vec();
        }
    }

    /// The next input.
    #[must_use]
    pub fn make(&mut self) -> Vec<u8> {
        let mut bytes = self.any();
        // Mostly few damages, at times many.
        let mut damages = 1 + self.below(3);
        if self.below(10) == 0 {
            damages *= 8;
        }
        for _ in 0..damages {
            self.damage(&mut bytes);
        }
        bytes.truncate(self.most_bytes);
        bytes
    }

    fn below(&mut self, count: usize) -> usize {
        (self.stream.bits() % count.max(1) as u64) as usize
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// A seed, or an input that was accepted.
    fn any(&mut self) -> Vec<u8> {
        let place = self.below(2 * self.seeds.len() + self.kept.len());
        match place.checked_sub(2 * self.seeds.len()) {
            Some(place) => self.kept[place].clone(),
            None => self.seeds[place / 2].clone(),
        }
    }

    /// A piece of bytes of a length: mostly short.
    fn piece(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length + 1);
        let rest = length - start;
        let most = if self.below(4) == 0 { rest } else { rest.min(16) };
        start..start + self.below(most + 1)
    }

    fn damage(&mut self, bytes: &mut Vec<u8>) {
        match self.below(16) {
            0 | 1 if !bytes.is_empty() => {
                let (place, bit) = (self.below(bytes.len()), self.below(8));
                bytes[place] ^= 1 << bit;
            }
            2 if !bytes.is_empty() => {
                let place = self.below(bytes.len());
                bytes[place] = self.stream.bits() as u8;
            }
            3 => {
                let piece = self.piece(bytes.len());
                bytes.drain(piece);
            }
            4 => {
                let piece = self.piece(bytes.len());
                let copied = bytes[piece.clone()].to_vec();
                let times = 1 + if self.below(8) == 0 { self.below(200) } else { self.below(3) };
                let copied = copied.repeat(times.min(MOST_BYTES / copied.len().max(1)));
                bytes.splice(piece.end..piece.end, copied);
            }
            5 => {
                let other = self.any();
                let (from, to) = (self.piece(other.len()), self.piece(bytes.len()));
                bytes.splice(to, other[from].iter().copied());
            }
            6 => {
                // The beginning of this one and the end of another.
                let other = self.any();
                let (at, from) = (self.below(bytes.len() + 1), self.below(other.len() + 1));
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..]);
            }
            7 => {
                let length = self.below(bytes.len() + 1);
                bytes.truncate(length);
            }
            8 | 9 if !self.tokens.is_empty() => {
                let token = self.one_of(self.tokens);
                let mut place = self.piece(bytes.len());
                if self.below(2) == 0 {
                    place.end = place.start;
                }
                bytes.splice(place, token.bytes());
            }
            10 | 11 => self.change_number(bytes),
            12 => self.change_line(bytes),
            13 => {
                let (width, is_big) = (1 << self.below(4), self.below(2) == 0);
                let value = self.one_of(WHOLE);
                put(bytes, self.below(bytes.len() + 1), &value.to_le_bytes()[..width], is_big);
            }
            14 => {
                let (value, is_big, at) =
                    (self.one_of(FRACTIONS), self.below(2) == 0, self.below(bytes.len() + 1));
                match self.below(2) {
                    0 => put(bytes, at, &value.to_le_bytes(), is_big),
                    _ => put(bytes, at, &(value as f32).to_le_bytes(), is_big),
                }
            }
            _ => {
                // A small step of a whole number where it stands.
                let (width, is_big) = (1 << self.below(4), self.below(2) == 0);
                let at = self.below(bytes.len() + 1);
                let Some(there) = bytes.get(at..at + width) else { return };
                let mut value = [0; 8];
                value[..width].copy_from_slice(there);
                if is_big {
                    value[..width].reverse();
                }
                let step = self.below(33) as u64;
                let value = u64::from_le_bytes(value).wrapping_add(step).wrapping_sub(16);
                put(bytes, at, &value.to_le_bytes()[..width], is_big);
            }
        }
    }

    /// Another number where a text has one.
    fn change_number(&mut self, bytes: &mut Vec<u8>) {
        let start = self.below(bytes.len() + 1);
        let is_part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e' | b'E');
        let Some(from) = bytes[start..].iter().position(u8::is_ascii_digit).map(|offset| start + offset)
        else {
            return;
        };
        let to = bytes[from..].iter().position(|byte| !is_part(byte)).map_or(bytes.len(), |end| from + end);
        let number = match self.below(3) {
            0 => {
                let old =
                    std::str::from_utf8(&bytes[from..to]).ok().and_then(|text| text.parse::<f64>().ok());
                let factor = self.one_of(&[0.1, 0.5, 0.9, 1.1, 2.0, 10.0, 1000.0, -1.0, 1.0 + 1e-12]);
                (old.unwrap_or(1.0) * factor).to_string()
            }
            _ => self.one_of(NUMBERS).to_owned(),
        };
        bytes.splice(from..to, number.bytes());
    }

    /// A line twice, away, or elsewhere.
    fn change_line(&mut self, bytes: &mut Vec<u8>) {
        let lines: Vec<&[u8]> = bytes.split_inclusive(|byte| *byte == b'\n').collect();
        if lines.len() < 2 {
            return;
        }
        let (one, other) = (self.below(lines.len()), self.below(lines.len()));
        let mut order: Vec<usize> = (0..lines.len()).collect();
        match self.below(3) {
            0 => order.insert(other, one),
            1 => drop(order.remove(one)),
            _ => order.swap(one, other),
        }
        *bytes = order.iter().flat_map(|line| lines[*line].iter().copied()).collect();
    }
}

/// Puts bytes over those that are there, or behind the end.
fn put(bytes: &mut Vec<u8>, at: usize, value: &[u8], is_big: bool) {
    let end = (at + value.len()).min(bytes.len());
    let ordered = value.iter().copied();
    if is_big {
        bytes.splice(at..end, ordered.rev());
    } else {
        bytes.splice(at..end, ordered);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_makes_the_same_inputs_and_another_others() {
        let seeds = [b"period = 0.25\nrows = 3\n".to_vec(), vec![7; 40]];
        let made = |seed: u64| {
            let mut mutator = Mutator::new(seed, &seeds, &["rod", "[lattice]"]);
            let mut all = Vec::new();
            for index in 0..2000 {
                let input = mutator.make();
                assert!(input.len() <= MOST_BYTES);
                if index % 7 == 0 {
                    mutator.keep(&input);
                }
                all.push(input);
            }
            all
        };
        assert_eq!(made(3), made(3));
        assert_ne!(made(3), made(4));
        let contains =
            |inputs: &[Vec<u8>], word: &[u8]| inputs.iter().any(|i| i.windows(word.len()).any(|w| w == word));
        let inputs = made(3);
        for word in [&b"[lattice]"[..], b"9007199254740993", b"\x7f\xff\xff\xff", &f64::NAN.to_le_bytes()] {
            assert!(contains(&inputs, word), "{word:?}");
        }
    }
}
