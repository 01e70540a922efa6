//! Wires of the array: those of its switches and buses, and those the file adds.

use std::collections::{BTreeMap, BTreeSet};

use super::array::{ALL, SLOTS, Units, unit_list};
use super::de::Spanned;
use super::findings::Findings;
use super::limits;
use super::links::Topology;
use super::raw::{self, Text};
use super::units;
use super::values;
use crate::arch::{Fu, FuSpec, Input, Wire, WireSpec};
use crate::diagnostic::Span;
use crate::entity::{Entity, EntityMap};

/// Wires that an array has by a word.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A switch in each cell: a wire for each link of a topology.
    Switches(Topology),
    /// A bus for each row, for each column, for the whole array.
    Row,
    Column,
    Array,
}

pub(super) const KINDS: &[(&str, Kind)] = &[
    ("mesh", Kind::Switches(Topology::Mesh)),
    ("mesh-diagonal", Kind::Switches(Topology::MeshDiagonal)),
    ("torus", Kind::Switches(Topology::Torus)),
    ("one-hop", Kind::Switches(Topology::OneHop)),
    ("row", Kind::Row),
    ("column", Kind::Column),
    ("array", Kind::Array),
];

/// Wires that a value passes in one cycle where the file does not say how many: those of the 4×4 array of HyCUBE
/// (Karunaratne et al., DAC 2017).
pub(super) const HOPS: u32 = 4;

/// All wires of the array, those of its switches and buses first, and how many a value passes in one cycle.
pub(super) fn wires(
    found: &Findings,
    raw: &raw::Array,
    units: &Units,
) -> (EntityMap<Wire, WireSpec>, u32) {
    let hops = values::number(found, &raw.hops, limits::HOPS, HOPS);
    let delay = values::number(found, &raw.wire_delay, limits::WIRE_DELAY, 0);
    let widest = values::width(found, &raw.wire_width, "wire-width", &[1, 32, 128]);
    let mut network = Network {
        found,
        units,
        delay,
        width: widest.unwrap_or(128).min(widest_unit(units)),
        wires: EntityMap::new(),
        names: BTreeMap::new(),
        users: 0,
    };
    for (fu, unit) in units.fus.iter() {
        let span = units.origins[fu].span;
        network.names.insert(unit.name.clone(), (None, span));
    }
    let generated = raw.wires.as_ref().is_none_or(|text| network.generate(text));
    if generated {
        network.add_written(&raw.wire);
    }
    (network.wires, hops)
}

fn widest_unit(units: &Units) -> u32 {
    let widths = units.fus.values().map(|unit| unit.width);
    widths.max().unwrap_or(128)
}

/// The wires as they are gathered.
struct Network<'a> {
    found: &'a Findings,
    units: &'a Units,
    /// Delay and width of wires that have no element of their own.
    delay: u32,
    width: u32,
    wires: EntityMap<Wire, WireSpec>,
    /// What wires can take values from, by name; units have no wire.
    names: BTreeMap<String, (Option<Wire>, Span)>,
    /// Inputs and readers so far.
    users: usize,
}

/// The list of an array without switches and buses.
const NO_WIRES: &str = "none";

impl Network<'_> {
    /// The wires that words mean; false where they are too many.
    fn generate(&mut self, text: &Text) -> bool {
        let mut seen = BTreeMap::new();
        if text.value == NO_WIRES {
            return true;
        }
        for word in values::words(text) {
            let (word, count) = match word.value.split_once(':') {
                None => (word, None),
                Some((kind, count)) => {
                    let at = |value: &str| Text {
                        value: value.to_owned(),
                        span: word.span,
                    };
                    (at(kind), Some(at(count)))
                }
            };
            let count = values::number(self.found, &count, limits::WIRES, 1);
            let Some(kind) = values::word(self.found, &Some(word.clone()), "wires", KINDS) else {
                continue;
            };
            if units::unique(self.found, &mut seen, &word, word.span, "kind of wires")
                && !self.add_kind(&word, kind, count)
            {
                return false;
            }
        }
        true
    }

    fn add_kind(&mut self, word: &Text, kind: Kind, count: u32) -> bool {
        let line = |at: fn(&FuSpec) -> u32, line: u32| {
            let units = self.units.fus.iter().filter(|(_, unit)| at(unit) == line);
            let units: Vec<Fu> = units.map(|(fu, _)| fu).collect();
            (format!("{}_{line}", word.value), units)
        };
        let (rows, cols) = (self.units.rows, self.units.cols);
        let buses: Vec<(String, Vec<Fu>)> = match kind {
            Kind::Switches(topology) => return self.add_switches(word, topology, count),
            Kind::Row => (0..rows).map(|row| line(|unit| unit.row, row)).collect(),
            Kind::Column => (0..cols).map(|col| line(|unit| unit.col, col)).collect(),
            Kind::Array => vec![(word.value.clone(), self.units.fus.keys().collect())],
        };
        buses.into_iter().all(|(name, to)| {
            (1..=count).all(|copy| {
                let from = to.iter().copied().map(Input::Unit).collect();
                self.add_plain(numbered(&name, copy), from, to.clone(), word.span)
            })
        })
    }

    /// The wires of a switch in each cell. One to a neighbour takes what the unit of its cell has, or what comes
    /// in on a wire from another neighbour.
    fn add_switches(&mut self, word: &Text, topology: Topology, count: u32) -> bool {
        let (rows, cols) = (self.units.rows as usize, self.units.cols as usize);
        // The wires that end in each cell, with the cells that they come from.
        let mut ending: EntityMap<Fu, Vec<(Fu, Wire)>> =
            EntityMap::filled(self.units.fus.len(), Vec::new());
        let first = self.wires.len();
        let mut ends = Vec::new();
        for from in self.units.fus.keys() {
            for to in topology.reached(rows, cols, from.index()) {
                let to = Fu::new(to);
                let (a, b) = (&self.units.fus[from], &self.units.fus[to]);
                let name = word.value.replace('-', "_");
                let name = format!("{name}_{}_{}_{}_{}", a.row, a.col, b.row, b.col);
                for copy in 1..=count {
                    let inputs = vec![Input::Unit(from)];
                    let next = Wire::new(self.wires.len());
                    if !self.add_plain(numbered(&name, copy), inputs, vec![to], word.span) {
                        return false;
                    }
                    ending[to].push((from, next));
                    ends.push((from, to));
                }
            }
        }
        for (i, (from, to)) in ends.into_iter().enumerate() {
            let coming = ending[from].iter().filter(|&&(other, _)| other != to);
            let coming = coming.map(|&(_, wire)| Input::Wire(wire));
            let inputs = &mut self.wires[Wire::new(first + i)].from;
            inputs.extend(coming);
            self.users += inputs.len() - 1;
            if self.users > limits::MAX_WIRE_USERS {
                self.too_many_users(word.span);
                return false;
            }
        }
        true
    }

    /// Adds a wire with the delay and the width of those without an element; false where it is one too many.
    fn add_plain(&mut self, name: String, from: Vec<Input>, to: Vec<Fu>, at: Span) -> bool {
        let (delay, width) = (self.delay, self.width);
        self.add(
            WireSpec {
                name,
                from,
                to,
                delay,
                width,
            },
            at,
        )
    }

    fn add(&mut self, wire: WireSpec, at: Span) -> bool {
        if self.wires.len() == limits::MAX_WIRES {
            if self.units.sized {
                let message = format!("the array has more than {} wires", limits::MAX_WIRES);
                let error = self.found.error("A0410", at, message, "too many");
                self.found.push(error);
            }
            return false;
        }
        self.users += wire.from.len() + wire.to.len();
        if self.users > limits::MAX_WIRE_USERS {
            self.too_many_users(at);
            return false;
        }
        let taken = self.names.get(&wire.name).map(|&(_, span)| span);
        let name = wire.name.clone();
        let number = self.wires.push(wire);
        match taken {
            // What has no name was reported.
            _ if name.is_empty() => {}
            None => drop(self.names.insert(name, (Some(number), at))),
            Some(first) => {
                let message = format!("wire `{name}` has the name of a unit or another wire");
                let error = self.found.error("A0405", at, message, "given again");
                self.found.push(error.also(first, "first given here"));
            }
        }
        true
    }

    fn too_many_users(&self, at: Span) {
        if self.units.sized {
            let most = limits::MAX_WIRE_USERS;
            let message = format!("wires have more than {most} inputs and readers in all");
            let error = self.found.error("A0410", at, message, "too many");
            self.found.push(error);
        }
    }

    /// The wires that the file adds. One may be among the inputs of another before it.
    fn add_written(&mut self, written: &[Spanned<raw::Wire>]) {
        let first = self.wires.len();
        for wire in written {
            let name = values::required_identifier(self.found, &wire.name, "wire", wire.span);
            let name = name.filter(|name| self.may_be_called(wire, name));
            if name.is_none() {
                self.found.suspect(wire.span, "wire");
            }
            let spec = WireSpec {
                name: name.unwrap_or_default(),
                from: Vec::new(),
                // A wire that only other wires take values from has no readers.
                to: (wire.to.as_ref()).map_or_else(Vec::new, |text| {
                    unit_list(self.found, text, self.units, &self.units.slots())
                }),
                delay: values::number(self.found, &wire.delay, limits::DELAY, 0),
                width: values::width(self.found, &wire.width, "width", &[1, 32, 128])
                    .unwrap_or(self.width),
            };
            if self.found.is_full() || !self.add(spec, wire.span) {
                return;
            }
        }
        for (i, wire) in written.iter().enumerate() {
            let number = Wire::new(first + i);
            let from = self.inputs(wire, number);
            self.users += from.len();
            if self.users > limits::MAX_WIRE_USERS {
                return self.too_many_users(wire.span);
            }
            self.wires[number].from = from;
        }
    }

    fn may_be_called(&self, wire: &raw::Wire, name: &str) -> bool {
        let refused = [ALL, SLOTS].contains(&name);
        if let Some(text) = wire.name.as_ref().filter(|_| refused) {
            let message = format!("a wire cannot be called `{name}`");
            let label = "this word stands for several units";
            let error = self.found.error("A0304", text.span, message, label);
            self.found.push(error);
        }
        !refused
    }

    fn inputs(&self, wire: &Spanned<raw::Wire>, number: Wire) -> Vec<Input> {
        let Some(text) = &wire.from else {
            values::missing(self.found, "from", "wire", wire.span);
            return Vec::new();
        };
        if text.trim().is_empty() {
            let message = "a wire needs something to take values from";
            let error = (self.found).error("A0411", text.span, message, "names nothing");
            self.found.push(error);
        }
        let mut inputs: Vec<Input> = Vec::new();
        let mut seen = BTreeSet::new();
        for word in values::words(text) {
            let named: Vec<Input> = match word.as_str() {
                ALL => self.units.fus.keys().map(Input::Unit).collect(),
                SLOTS => self.units.slots().into_iter().map(Input::Unit).collect(),
                _ => self.input(&word, number).into_iter().collect(),
            };
            inputs.extend(named.into_iter().filter(|&input| seen.insert(input)));
        }
        inputs
    }

    /// What a word names that a wire can take values from.
    fn input(&self, word: &Text, number: Wire) -> Option<Input> {
        match self.names.get(&word.value) {
            Some((Some(wire), _)) if *wire == number => {
                let message = format!("wire `{}` takes values from itself", word.value);
                let error = (self.found).error("A0408", word.span, message, "the wire itself");
                let help = "leave it out: a wire keeps nothing to the next cycle";
                self.found.push(error.help(help));
                None
            }
            Some((Some(wire), _)) => Some(Input::Wire(*wire)),
            Some((None, _)) => self.units.find(self.found, word).map(Input::Unit),
            None => {
                let known = self.names.keys().map(String::as_str);
                if !self.found.suspects_any(&["wire", "wires", "fu", "name"]) && self.units.sized {
                    values::unknown(self.found, "A0401", word, "unit or wire", known);
                }
                None
            }
        }
    }
}

/// The name of one of several alike.
fn numbered(name: &str, copy: u32) -> String {
    match copy {
        1 => name.to_owned(),
        _ => format!("{name}_{copy}"),
    }
}
