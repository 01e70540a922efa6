//! More hardware is never worse: the II of a graph does not rise when the array gets a row, a column,
//! a link, switches, buses, a register, or a unit another class of operations.
//!
//! A longer run: `SRP_MONOTONE_GRAPHS=100 cargo test --release -p srp-scheduler --test graphs`, from
//! the graph of number `SRP_MONOTONE_SEED` on.

use super::machine;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_ir::check::check_loop;
use srp_ir::graph::{Graph, Options, read_dot};
use srp_scheduler::modulo;
use std::collections::BTreeSet;
use std::fmt::Write;

fn below(random: &mut Pcg32, n: u32) -> u32 {
    random.next_u32() % n
}

/// A cell of the array.
#[derive(Clone)]
struct Cell {
    multiplies: bool,
    memory: bool,
    registers: u32,
}

/// An array that can grow.
#[derive(Clone)]
pub(super) struct Array {
    rows: u32,
    cols: u32,
    /// Row by row.
    cells: Vec<Cell>,
    /// From cell to cell, by row and column.
    links: BTreeSet<((u32, u32), (u32, u32))>,
    /// Its switches and buses.
    wires: &'static str,
}

impl Array {
    /// A small mesh in which some cells multiply and some load and store, at least one each.
    pub(super) fn random(random: &mut Pcg32) -> Array {
        let (rows, cols) = (2 + below(random, 2), 2 + below(random, 2));
        let registers = below(random, 3);
        let mut cells: Vec<Cell> = (0..rows * cols)
            .map(|_| Cell {
                multiplies: below(random, 2) == 0,
                memory: below(random, 2) == 0,
                registers,
            })
            .collect();
        (cells[0].multiplies, cells[1].memory) = (true, true);
        let mut array = Array {
            rows,
            cols,
            cells,
            links: BTreeSet::new(),
            wires: ["", "", "row", "mesh"][below(random, 4) as usize],
        };
        array.link_neighbours();
        array
    }

    fn link_neighbours(&mut self) {
        for row in 0..self.rows {
            for col in 0..self.cols {
                for (r, c) in [(row + 1, col), (row, col + 1)] {
                    if r < self.rows && c < self.cols {
                        self.links.insert(((row, col), (r, c)));
                        self.links.insert(((r, c), (row, col)));
                    }
                }
            }
        }
    }

    /// Every way to grow by one step, with its description.
    fn grown(&self, random: &mut Pcg32) -> Vec<(&'static str, Array)> {
        let plain = Cell {
            multiplies: false,
            memory: false,
            registers: self.cells[0].registers,
        };
        let mut row = self.clone();
        row.rows += 1;
        row.cells.extend(vec![plain.clone(); self.cols as usize]);
        row.link_neighbours();
        let mut col = self.clone();
        col.cols += 1;
        for r in (0..self.rows).rev() {
            col.cells
                .insert(((r + 1) * self.cols) as usize, plain.clone());
        }
        col.link_neighbours();
        let mut link = self.clone();
        let mut cell = || (below(random, self.rows), below(random, self.cols));
        let (from, to) = (cell(), cell());
        if from != to {
            link.links.insert((from, to));
        }
        let mut switches = self.clone();
        switches.wires = match self.wires {
            "row" => "mesh row",
            _ => "mesh",
        };
        let mut bus = self.clone();
        bus.wires = match self.wires {
            "mesh" => "mesh column",
            _ => "row column",
        };
        let mut class = self.clone();
        let count = self.cells.len() as u32;
        class.cells[below(random, count) as usize].multiplies = true;
        class.cells[below(random, count) as usize].memory = true;
        let mut register = self.clone();
        register.cells[below(random, count) as usize].registers += 1;
        vec![
            ("a row", row),
            ("a column", col),
            ("a link", link),
            ("switches", switches),
            ("buses", bus),
            ("a class", class),
            ("a register", register),
        ]
    }

    pub(super) fn arch(&self) -> Arch {
        let mut xml = String::from("<machine name=\"small\">\n");
        let mut line = |text: std::fmt::Arguments<'_>| {
            writeln!(xml, "{text}").expect("strings can be written");
        };
        for class in ["alu", "imul", "load", "store"] {
            line(format_args!(
                "  <op class=\"{class}\" latency=\"1\" interval=\"1\"/>"
            ));
        }
        line(format_args!(
            "  <fu-type name=\"pe\" pred-out=\"false\" classes=\"alu\"/>"
        ));
        let (rows, cols) = (self.rows, self.cols);
        line(format_args!(
            "  <array rows=\"{rows}\" cols=\"{cols}\" topology=\"none\" wires=\"{}\" hops=\"3\">",
            self.wires
        ));
        line(format_args!("    <row units=\"pe\"/>"));
        for (i, cell) in self.cells.iter().enumerate() {
            let (row, col) = (i as u32 / cols, i as u32 % cols);
            let imul = if cell.multiplies { " imul" } else { "" };
            let memory = if cell.memory { " load store" } else { "" };
            line(format_args!(
                "    <fu row=\"{row}\" col=\"{col}\" classes=\"alu{imul}{memory}\">"
            ));
            if cell.registers > 0 {
                line(format_args!(
                    "      <file name=\"r\" kind=\"static\" size=\"{}\" read-ports=\"8\" \
                     write-ports=\"8\"/>",
                    cell.registers
                ));
            }
            line(format_args!("    </fu>"));
        }
        for ((a, b), (c, d)) in &self.links {
            line(format_args!(
                "    <link from=\"fu_{a}_{b}\" to=\"fu_{c}_{d}\"/>"
            ));
        }
        line(format_args!("  </array>"));
        line(format_args!("  <vliw slots=\"0\"/>"));
        line(format_args!("</machine>"));
        machine(&xml)
    }
}

/// A small graph: mostly a tree that grows, with some values of earlier iterations.
pub(super) fn graph(random: &mut Pcg32) -> Graph {
    let nodes = 4 + below(random, 10);
    let mut text = String::from("digraph random {\n");
    for n in 0..nodes {
        let op = ["add", "add", "add", "mul", "load"][below(random, 5) as usize];
        writeln!(text, "  n{n} [op={op}];").expect("strings can be written");
    }
    for n in 1..nodes {
        for _ in 0..1 + below(random, 2) {
            let from = n - 1 - below(random, n.min(4));
            writeln!(text, "  n{from} -> n{n};").expect("strings can be written");
        }
        if below(random, 6) == 0 {
            let (to, distance) = (below(random, n + 1), 1 + below(random, 2));
            writeln!(text, "  n{n} -> n{to} [distance={distance}];")
                .expect("strings can be written");
        }
    }
    text.push('}');
    read_dot(&Source::new("random.dot", text), &Options::default()).expect("a graph")
}

/// The II of a graph; the largest number where it has no schedule.
fn ii(graph: &Graph, array: &Array) -> u32 {
    let arch = array.arch();
    let options = modulo::Options {
        compaction: 0,
        ..modulo::Options::default()
    };
    match modulo::schedule(&graph.dfg, &arch.srp, &options, &Unwatched) {
        Ok(scheduled) => {
            let wrong = check_loop(&scheduled.schedule, &arch.srp);
            assert!(wrong.is_empty(), "{wrong:?}");
            scheduled.schedule.ii
        }
        Err(_) => u32::MAX,
    }
}

/// Returns the rises of the II in one trial, in words.
fn trial(seed: u64) -> Vec<String> {
    let mut random = Pcg32::seed_from_u64(seed);
    let (graph, array) = (graph(&mut random), Array::random(&mut random));
    let before = ii(&graph, &array);
    let grown = array.grown(&mut random);
    let rise = |(what, array): (&str, Array)| {
        let after = ii(&graph, &array);
        (after > before).then(|| format!("seed {seed}: II {before} rises to {after} with {what}"))
    };
    grown.into_iter().filter_map(rise).collect()
}

#[test]
fn more_hardware_is_never_worse() {
    let number = |name: &str| std::env::var(name).ok().and_then(|s| s.parse::<u64>().ok());
    let graphs = number("SRP_MONOTONE_GRAPHS").unwrap_or(3);
    let first = number("SRP_MONOTONE_SEED").unwrap_or(0);
    let rises: Vec<String> = (first..first + graphs).flat_map(trial).collect();
    assert!(
        rises.is_empty(),
        "{} of {graphs}:\n{}",
        rises.len(),
        rises.join("\n")
    );
}
