//! The files of strangers: seeds of every kind, which cargo-fuzz has found to lead to different code, as they are and changed
//! at random. `SRP_FUZZ_SECONDS` of each kind, from a fresh seed, which is printed; `SRP_FUZZ_SEED` takes another.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_tests::fuzz::{self, TARGETS, Target};
use srp_tests::root;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Largest input that is made, in bytes.
const MOST: usize = 1 << 16;

/// The seeds of a kind.
fn seeds(name: &str) -> Vec<Vec<u8>> {
    if name == "checkpoint" {
        // Those of another build would be of another form.
        return [1, 100, 1000].map(fuzz::checkpoint::seed).into();
    }
    let folder = root().join("tests/fuzz/seeds").join(name);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{folder:?}: {e}"));
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("an entry can be read").path())
        .collect();
    paths.sort();
    let read = |path| std::fs::read(path).expect("a seed can be read");
    paths.iter().map(read).collect()
}

fn below(random: &mut Pcg64, n: usize) -> usize {
    random.next_u64() as usize % n.max(1)
}

/// Changes a few places: bits, bytes, parts that are left out, repeated, or taken from another seed.
fn changed(seeds: &[Vec<u8>], random: &mut Pcg64) -> Vec<u8> {
    let mut bytes = seeds[below(random, seeds.len())].clone();
    for _ in 0..=below(random, 4) {
        let at = below(random, bytes.len());
        let end = (at + 1 + below(random, 40)).min(bytes.len());
        match below(random, 6) {
            0 if at < bytes.len() => bytes[at] ^= 1 << below(random, 8),
            1 if at < bytes.len() => bytes[at] = random.next_u32() as u8,
            2 => drop(bytes.drain(at.min(end)..end)),
            3 => {
                let part = bytes[at.min(end)..end].to_vec();
                let to = below(random, bytes.len() + 1);
                bytes.splice(to..to, part);
            }
            4 => {
                let numbers = [
                    "0",
                    "-1",
                    "4294967296",
                    "1e39",
                    "NaN",
                    "99999999999999999999",
                ];
                let number = numbers[below(random, numbers.len())];
                bytes.splice(at.min(end)..end, number.bytes());
            }
            _ => {
                let other = &seeds[below(random, seeds.len())];
                let from = below(random, other.len());
                let until = (from + 1 + below(random, 60)).min(other.len());
                let to = below(random, bytes.len() + 1);
                bytes.splice(to..to, other[from.min(until)..until].iter().copied());
            }
        }
    }
    bytes.truncate(MOST);
    bytes
}

fn holds((_, any): Target, bytes: &[u8]) -> bool {
    catch_unwind(AssertUnwindSafe(|| any(bytes))).is_ok()
}

/// The same fault with fewer bytes: parts are left out as long as it stays.
fn shrunk(target: Target, mut bytes: Vec<u8>) -> Vec<u8> {
    let mut part = bytes.len() / 2;
    while part > 0 {
        let mut at = 0;
        while at < bytes.len() {
            let mut less = bytes.clone();
            less.drain(at..(at + part).min(bytes.len()));
            match holds(target, &less) {
                true => at += part,
                false => bytes = less,
            }
        }
        part /= 2;
    }
    bytes
}

#[test]
fn whatever_strangers_bring_ends_well() {
    let number = |name: &str| -> Option<u64> { std::env::var(name).ok()?.parse().ok() };
    let seconds = number("SRP_FUZZ_SECONDS");
    let time = seconds.map_or(Duration::from_millis(300), Duration::from_secs);
    let first = number("SRP_FUZZ_SEED").unwrap_or_else(|| {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        since.map_or(0, |since| since.as_secs())
    });
    println!("SRP_FUZZ_SEED={first}");
    let mut faults = Vec::new();
    for target in TARGETS {
        let seeds = seeds(target.0);
        assert!(!seeds.is_empty(), "{} has no seeds", target.0);
        let mut random = Pcg64::seed_from_u64(first);
        let end = Instant::now() + time;
        let (mut runs, mut found) = (0, 0);
        let whole = seeds.iter().cloned();
        let drawn =
            std::iter::from_fn(|| (Instant::now() < end).then(|| changed(&seeds, &mut random)));
        for bytes in whole.chain(drawn) {
            runs += 1;
            if !holds(target, &bytes) {
                let bytes = shrunk(target, bytes);
                faults.push(format!("{}: {}", target.0, bytes.escape_ascii()));
                found += 1;
                if found == 3 {
                    break;
                }
            }
        }
        println!("{}: {runs} runs, {found} faults", target.0);
    }
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
}
