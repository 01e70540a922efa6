//! Initiation intervals of the loops of `kernels/micro` and of the frame, which do not get worse than
//! those of `tests/micro.txt`; and what runs at them is what was meant.
//!
//! A run schedules an eighth of the programs, and the next run most likely others; `SRP_INTERVALS=all` schedules all of them,
//! `SRP_INTERVALS=N` those of a run that printed N. `BLESS=1` writes the table anew.

use srp_archdesc::arch::Arch;
use srp_archdesc::machines::SGRT;
use srp_scheduler::{Schedule, modulo};
use srp_tests::{
    Part, Suite, compiled, equal, failures, machine, meaning, root, session, simulated,
};
use srp_toolchain::{divide, schedule_divided};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The arrays that the table is about.
const MACHINES: [&str; 2] = ["sgrt", "wide"];

/// The II that a loop reaches on a machine, and its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Reached {
    ii: u32,
    bound: u32,
}

/// By loop, then in the order of [`MACHINES`].
type Table = BTreeMap<String, Vec<Reached>>;

const HEADER: &str = "\
# Initiation intervals of the loops of kernels/micro and of the frame, and their lower bounds.
# BLESS=1 cargo test -p srp-tests intervals:: writes this anew.
";

fn show(table: &Table) -> String {
    let mut text = HEADER.to_owned();
    let width = table.keys().map(String::len).max().unwrap_or(0);
    let mut line = format!("{:width$}", "# loop");
    MACHINES
        .iter()
        .for_each(|name| line += &format!("  {name:>4} bound"));
    text += &format!("{line}\n");
    for (name, all) in table {
        let mut line = format!("{name:width$}");
        for Reached { ii, bound } in all {
            line += &format!("  {ii:4} {bound:5}");
        }
        text += &format!("{line}\n");
    }
    text
}

fn read(text: &str) -> Table {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let entry = |line: &str| {
        let mut words = line.split_whitespace();
        let name = words.next().expect("no line is empty").to_owned();
        let numbers = words.map(|word| word.parse().expect("a number"));
        let numbers: Vec<u32> = numbers.collect();
        let reached = numbers.chunks(2).map(|pair| Reached {
            ii: pair[0],
            bound: pair[1],
        });
        (name, reached.collect())
    };
    lines.map(entry).collect()
}

fn scheduled(suite: &Suite, arch: &Arch) -> Result<Schedule, String> {
    let divided = divide(&mut compiled(&suite.sources, arch)?, arch).map_err(|e| e.to_string())?;
    // The II alone is recorded.
    let options = modulo::Options {
        compaction: 0,
        ..modulo::Options::default()
    };
    schedule_divided(&divided.dre, arch, &options, &session()).map_err(|e| e.to_string())
}

/// A loop with three roots and so many sums, each of earlier ones.
fn roots_and_sums(sums: usize) -> String {
    let mut body = String::new();
    for k in 0..3 {
        body += &format!("float r{k} = srp_sqrt(x * {k}.5f + y);\n");
    }
    for k in 0..sums {
        let far = k
            .checked_sub(3)
            .map_or(format!("r{k}"), |j| format!("v{j}"));
        let near = match k * 3 / 5 {
            j if j < k => format!("v{j}"),
            _ => format!("r{}", k % 3),
        };
        body += &format!("float v{k} = {far} * {}.5f + {near};\n", k % 5);
    }
    let (a, b, c) = (sums - 1, sums - 2, sums - 3);
    format!(
        "#include \"srp.h\"
        void f(const float *restrict p, const float *restrict q, float *restrict o, int n) {{
        #pragma srp kernel
            for (int i = 0; i < n; i++) {{
                float x = p[i], y = q[i];
                {body}
                o[i] = v{a} + v{b} + v{c};
            }}
        }}"
    )
}

/// Three units keep a root for five cycles each, and two of them at a time share a port. All three have an operation in eight cycles
/// if they take turns, which they cannot if they all begin alike.
#[test]
fn units_that_wait_for_a_port_take_turns() {
    let xml = SGRT
        .xml
        .replace(
            "<op class=\"sfu\"/>",
            "<op class=\"sfu\" interval=\"5\" uses=\"root_port\"/>",
        )
        .replace("\"mem vec mem vec\"", "\"mem special mem special\"")
        .replace(
            "<resource name=\"sram_port\"",
            "<resource name=\"root_port\" count=\"2\"/><resource name=\"sram_port\"",
        );
    let arch = srp_archdesc::parse("m.xml", &xml).unwrap_or_else(|errors| panic!("{errors:?}"));
    let path = std::env::temp_dir().join(format!("srp-roots-{}.c", std::process::id()));
    std::fs::write(&path, roots_and_sums(36)).expect("the program can be written");
    let suite = Suite {
        name: "roots".to_owned(),
        sources: vec![path.clone()],
        runs_alone: false,
    };
    let schedule = scheduled(&suite, &arch);
    std::fs::remove_file(&path).expect("it is there");
    let schedule = schedule.unwrap_or_else(|message| panic!("{message}"));
    let facts = schedule.loops.values().next().expect("a loop on the array");
    let kernel = schedule
        .program
        .kernels
        .values()
        .next()
        .expect("its schedule");
    assert_eq!((kernel.ii, facts.bounds.min_ii()), (8, 8));
}

#[test]
fn intervals_do_not_get_worse() {
    let part = Part::of_this_run("SRP_INTERVALS", 8);
    let mut table = Table::new();
    let mut wrong = String::new();
    for name in MACHINES {
        let arch = machine(name);
        wrong += &failures(|suite| {
            if !part.has(&suite.name) {
                return Ok(());
            }
            let schedule = scheduled(suite, &arch)?;
            let kernels = schedule.program.kernels.values();
            for (kernel, facts) in kernels.zip(schedule.loops.values()) {
                let row = table.entry(kernel.dfg.name.clone()).or_default();
                row.push(Reached {
                    ii: kernel.ii,
                    bound: facts.bounds.min_ii(),
                });
            }
            if !suite.runs_alone {
                return Ok(());
            }
            let expected = meaning(suite, &arch)?;
            equal(name, &simulated(&schedule.program)?, &expected)
        });
    }
    assert!(wrong.is_empty(), "{wrong}");
    let path = root().join("tests/micro.txt");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, show(&table)).expect("the table can be written");
        return;
    }
    let golden = read(&std::fs::read_to_string(&path).expect("the table is there"));
    let names = |table: &Table| table.keys().cloned().collect::<Vec<_>>();
    match part.is_all() {
        true => assert_eq!(
            names(&table),
            names(&golden),
            "BLESS=1 takes up other loops"
        ),
        false => {
            let unknown = table.keys().find(|name| !golden.contains_key(*name));
            assert_eq!(unknown, None, "BLESS=1 takes up other loops");
            assert!(!table.is_empty(), "no eighth is empty");
        }
    }
    let mut worse = String::new();
    for (name, all) in &table {
        for ((machine, found), known) in MACHINES.iter().zip(all).zip(&golden[name]) {
            if found.ii > known.ii {
                let (ii, before) = (found.ii, known.ii);
                writeln!(worse, "{name} on {machine}: II {ii}, was {before}")
                    .expect("a string takes everything");
            } else if found != known {
                println!("{name} on {machine}: {found:?}, was {known:?}; BLESS=1 keeps that");
            }
        }
    }
    assert!(worse.is_empty(), "{worse}");
}
