//! Random changes of valid files, over and over: those of a usual fuzzer (bits, bytes, runs, numbers at their limits,
//! words of the format, pieces of other inputs), without its measure of coverage, which `./rig fuzz --coverage` has. An
//! input that gets a target further than the rest, by its own account of what it read, joins the corpus.

use std::{
    collections::HashSet,
    time::{Duration, Instant},
};

use super::{MAX_BYTES, Target, feed, kept};

/// What a run found.
#[derive(Debug, Default)]
pub struct Found {
    /// Inputs that were fed.
    pub inputs: u64,
    /// Inputs that got further than others before.
    pub corpus: Vec<Vec<u8>>,
    /// Inputs that made the target panic or took too long, with what happened.
    pub failures: Vec<(Vec<u8>, String)>,
}

/// Feeds mutated inputs for some time.
///
/// # Errors
/// No temporary folder.
pub fn run(target: Target, time: Duration, seed: u64) -> anyhow::Result<Found> {
    let dir = tempfile::tempdir()?;
    let mut random = Random(seed | 1);
    let mut pool = target.seeds();
    pool.extend(kept(target, "corpus").into_iter().map(|(_, input)| input));
    let (mut seen, mut found) = (HashSet::new(), Found::default());
    for input in &pool {
        seen.extend(feed(target, input, dir.path()));
    }
    let begun = Instant::now();
    while begun.elapsed() < time {
        let input = mutated(&pool, &mut random);
        found.inputs += 1;
        match feed(target, &input, dir.path()) {
            Ok(far) if seen.len() < 4096 && seen.insert(far) => {
                pool.push(input.clone());
                found.corpus.push(input);
            }
            Ok(_) => {}
            Err(what) => found.failures.push((input, what)),
        }
    }
    Ok(found)
}

/// Pieces that mean something in one of the formats, or stand at a limit.
const WORDS: [&[u8]; 24] = [
    b"-1",
    b"0",
    b"1e308",
    b"1e400",
    b"NaN",
    b"18446744073709551616",
    b"4294967295",
    b"9007199254740993",
    b"60000",
    b"1000000000",
    b"null",
    b"true",
    b"{}",
    b"[]",
    b"\"\"",
    b"\"#ffffff\"",
    b"../../etc/passwd",
    b"\xff\xfe",
    b"\\ud800",
    b"\n",
    b"[[a]]\n",
    b"=",
    b",,,",
    b"\x00\x00\x00\x00",
];

fn mutated(pool: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut input = pool[random.below(pool.len())].clone();
    for _ in 0..=random.below(6) {
        let at = random.below(input.len() + 1);
        let end = (at + 1 + random.below(16)).min(input.len());
        match random.below(8) {
            0 if at < input.len() => input[at] ^= 1 << random.below(8),
            1 if at < input.len() => input[at] = random.below(256) as u8,
            2 if at < end => drop(input.drain(at..end)),
            3 => insert(&mut input, at, WORDS[random.below(WORDS.len())]),
            4 if at < end => {
                let word = WORDS[random.below(WORDS.len())];
                input.splice(at..end, word.iter().copied());
            }
            5 if at < end => {
                let run = input[at..end].repeat(1 + random.below(64));
                insert(&mut input, at, &run);
            }
            6 => {
                let other = &pool[random.below(pool.len())];
                let from = random.below(other.len() + 1);
                let to = (from + random.below(256)).min(other.len());
                insert(&mut input, at, &other[from..to]);
            }
            _ => input.truncate(at.max(1)),
        }
    }
    input.truncate(MAX_BYTES);
    input
}

fn insert(input: &mut Vec<u8>, at: usize, piece: &[u8]) {
    input.splice(at..at, piece.iter().copied());
}

/// xorshift (Marsaglia 2003): the same seed gives the same inputs.
struct Random(u64);

impl Random {
    /// 0 to `limit` - 1.
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) % limit.max(1) as u64) as usize
    }
}
