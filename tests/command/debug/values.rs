//! Random small loops: what a session shows of counters, accumulators and other variables at every stop is what the
//! program has there by C, line by line and iteration by iteration, on the array.
//!
//! `SRP_RANDOM_SEED` says where to begin, `SRP_RANDOM_DEBUGGED` how many programs there are.

use super::{folder, told, write};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use std::collections::BTreeMap;

type Values = BTreeMap<&'static str, i32>;

/// A line of the loop, and what it does.
type Statement = (String, Box<dyn Fn(&mut Values)>);

/// A loop, and the values of its variables by C.
struct Random {
    text: String,
    /// The lines of its body.
    lines: std::ops::Range<usize>,
    /// By iteration and line, before the line.
    before: Vec<Vec<Values>>,
    /// By iteration, at its end.
    after: Vec<Values>,
}

/// A statement of a variable, which is a function of it and another, or of it and a constant.
fn sets(
    text: String,
    name: &'static str,
    value: impl Fn(&Values) -> Option<i32> + 'static,
) -> Statement {
    let step = move |values: &mut Values| {
        if let Some(value) = value(values) {
            values.insert(name, value);
        }
    };
    (text, Box::new(step))
}

/// The kinds of lines, each in one or two.
fn lines(kind: u32, by: i32, most: i32) -> Vec<Statement> {
    let above = move |v: &Values| v["x"] > most;
    match kind {
        0 => vec![sets("sum += x;".into(), "sum", |v| {
            Some(v["sum"].wrapping_add(v["x"]))
        })],
        1 => vec![
            sets("sum += x;".into(), "sum", |v| {
                Some(v["sum"].wrapping_add(v["x"]))
            }),
            sets("sum += i;".into(), "sum", |v| {
                Some(v["sum"].wrapping_add(v["i"]))
            }),
        ],
        2 => vec![sets(format!("if (x > {most}) odd++;"), "odd", move |v| {
            above(v).then(|| v["odd"] + 1)
        })],
        3 => vec![sets(
            format!("if (x > {most}) odd = odd + x;"),
            "odd",
            move |v| above(v).then(|| v["odd"].wrapping_add(v["x"])),
        )],
        4 => vec![sets(format!("odd += x > {most};"), "odd", move |v| {
            Some(v["odd"] + i32::from(above(v)))
        })],
        5 => vec![sets(format!("int w = i * {by} + 3;"), "w", move |v| {
            Some(v["i"] * by + 3)
        })],
        6 => vec![
            sets("y = n + 1;".into(), "y", |v| Some(v["n"] + 1)),
            sets("n = y;".into(), "n", |v| Some(v["y"])),
        ],
        7 => vec![sets(format!("last = x + {by};"), "last", move |v| {
            Some(v["x"] + by)
        })],
        8 => vec![sets(
            format!("if (x > {most}) last = x + {by};"),
            "last",
            move |v| above(v).then(|| v["x"] + by),
        )],
        9 => vec![
            sets(format!("int z = {by};"), "z", move |_| Some(by)),
            sets(format!("if (x > {most}) z = x * 2;"), "z", move |v| {
                above(v).then(|| v["x"] * 2)
            }),
        ],
        10 => vec![("out[i + 1] += x;".into(), Box::new(|_| {}))],
        11 => vec![sets("total += (float)x;".into(), "total", |v| {
            Some(v["total"] + v["x"])
        })],
        12 => vec![sets("best = x > best ? x : best;".into(), "best", |v| {
            Some(v["best"].max(v["x"]))
        })],
        13 => vec![sets("sum ^= x;".into(), "sum", |v| Some(v["sum"] ^ v["x"]))],
        14 => vec![sets(format!("n += {by};"), "n", move |v| {
            Some(v["n"].wrapping_add(by))
        })],
        _ => vec![sets(format!("sum = sum * {by} + x;"), "sum", move |v| {
            Some(v["sum"].wrapping_mul(by).wrapping_add(v["x"]))
        })],
    }
}

fn random(seed: u64) -> Random {
    let mut random = Pcg32::seed_from_u64(seed);
    let mut below = |n: u32| (random.next_u32() % n) as i32;
    let (start, step, count) = (below(9), 1 + below(3), 5 + below(30));
    let (factor, initial) = (1 + below(5), below(100));
    let end = start + step * count - below(step as u32);
    let (from, to) = match below(2) {
        0 => (start.to_string(), end.to_string()),
        _ => ("from".to_owned(), "to".to_owned()),
    };
    let counts_down = below(3) == 0;
    let head = match counts_down {
        true => format!(
            "for (int i = {from} + {}; i >= {from}; i -= {step})",
            step * (count - 1)
        ),
        false => format!("for (int i = {from}; i < {to}; i += {step})"),
    };
    let mut body = vec![sets(format!("int x = a[i] * {factor};"), "x", move |v| {
        Some(v["i"] * 7 % 31 * factor)
    })];
    let mut kinds: Vec<u32> = Vec::new();
    for _ in 0..2 + below(4) {
        let kind = below(16) as u32;
        if !kinds.contains(&kind) {
            body.extend(lines(kind, 1 + below(9), below(40)));
            kinds.push(kind);
        }
    }
    body.push(("out[i] = x + sum;".into(), Box::new(|_| {})));
    let source: Vec<String> = body
        .iter()
        .map(|(text, _)| format!("        {text}\n"))
        .collect();
    let text = format!(
        "#include <stdio.h>\nint a[128], out[130], from = {start}, to = {end};\nint main(void) {{\n    \
         for (int k = 0; k < 128; k++) a[k] = k * 7 % 31;\n    \
         int sum = {initial}, odd = 0, n = from, y = 50, last = 60, best = 3;\n    float total = 0;\n    \
         {head} {{\n{}    }}\n    \
         printf(\"%d %d %d %d %d %d %d %d\\n\", sum, odd, n, y, last, best, (int)total, out[{start}]);\n    return 0;\n}}\n",
        source.concat()
    );
    let mut values = Values::from([
        ("sum", initial),
        ("odd", 0),
        ("n", start),
        ("y", 50),
        ("last", 60),
        ("best", 3),
        ("total", 0),
    ]);
    let (mut before, mut after) = (Vec::new(), Vec::new());
    for k in 0..count {
        let number = if counts_down { count - 1 - k } else { k };
        values.insert("i", start + step * number);
        let mut of_iteration = Vec::new();
        for name in ["x", "w", "z"] {
            values.remove(name);
        }
        for (_, statement) in &body {
            of_iteration.push(values.clone());
            statement(&mut values);
        }
        before.push(of_iteration);
        after.push(values.clone());
    }
    Random {
        text,
        lines: 8..8 + body.len(),
        before,
        after,
    }
}

/// The number at the beginning of a value, and what is said with it.
fn number(line: &str) -> Option<(&str, i32, &str)> {
    let (name, value) = line.split_once(" = ")?;
    let (value, note) = value.split_once(' ').unwrap_or((value, ""));
    let value = value.strip_suffix(".0").unwrap_or(value);
    Some((name, value.parse().ok()?, note))
}

/// The iteration at which a stop is, if it says so, and its number.
fn iteration(text: &str) -> Option<usize> {
    let (_, rest) = text.lines().next()?.split_once(" iteration ")?;
    rest.split(',').next()?.parse().ok()
}

/// Goes through all stops at a line, and counts the values that are shown. One that is not C's is told.
fn compare(
    of: &Random,
    line: usize,
    said: &str,
    shown: &mut BTreeMap<String, u32>,
) -> Result<(), String> {
    for text in said.split("breakpoint 1\n").skip(1) {
        let on_array = iteration(text);
        let values: Vec<_> = text.lines().filter_map(number).collect();
        let counter = values.iter().find(|(name, ..)| *name == "i");
        let by_counter = match counter {
            None => None,
            Some(&(_, i, _)) => {
                let at = of.after.iter().position(|after| after["i"] == i);
                Some(at.ok_or(format!("i = {i} is of no iteration"))?)
            }
        };
        let Some(now) = on_array.or(by_counter) else {
            continue;
        };
        if by_counter.is_some_and(|by_counter| by_counter != now) {
            return Err(format!(
                "iteration {now} shows the counter of {by_counter:?}"
            ));
        }
        let (of_line, after) = (&of.before[now][line - of.lines.start], &of.after[now]);
        for (name, value, note) in values {
            let before = match note.starts_with("(before ") {
                true => &of.before[now][0],
                false => of_line,
            };
            // What an iteration makes itself may be there before its line.
            let Some(&right) = before.get(name).or(after.get(name)) else {
                continue;
            };
            let kind = if on_array.is_some() { "array" } else { "VLIW" };
            *shown.entry(format!("{kind} {name}")).or_default() += 1;
            if value != right {
                return Err(format!(
                    "line {line}, iteration {now}: {name} = {value} {note}; C has {right}"
                ));
            }
        }
    }
    Ok(())
}

fn from_environment(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// Programs after which each kind of value has been shown.
const MOST: u64 = 30;

#[test]
fn values_are_those_of_c() {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let first = from_environment("SRP_RANDOM_SEED")
        .unwrap_or_else(|| now.map_or(0, |now| u64::from(now.subsec_nanos())));
    println!("SRP_RANDOM_SEED={first}");
    let mut shown: BTreeMap<String, u32> = BTreeMap::new();
    let count = from_environment("SRP_RANDOM_DEBUGGED").unwrap_or(3);
    let kinds = ["array i", "array x"];
    // Few programs may show none of a kind.
    for seed in first..first + count.max(MOST) {
        if seed >= first + count && kinds.iter().all(|&kind| shown.contains_key(kind)) {
            break;
        }
        let of = random(seed);
        let folder = folder("debug-values");
        write(&folder, "f.c", &of.text);
        for line in of.lines.clone().step_by(3) {
            let stops = "continue\ninfo locals\n".repeat(of.before.len());
            let commands = format!("break f.c:{line}\n{stops}");
            let said = told(&folder, &["f.c", "--terminal"], &commands);
            if let Err(why) = compare(&of, line, &said, &mut shown) {
                panic!("SRP_RANDOM_SEED={seed}: {why}\n{}\n{said}", of.text);
            }
        }
    }
    println!("{shown:?}");
    for kind in kinds {
        assert!(shown.contains_key(kind), "{kind} is never shown: {shown:?}");
    }
}
