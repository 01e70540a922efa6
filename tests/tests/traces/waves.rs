//! Waves, read by the crate `wellen`.

use super::Case;
use super::steps::{Cells, Steps};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::ResourceGraph;
use srp_csimgen::SimSpec;
use srp_csimgen::spec::Role;
use srp_ir::check::Checked;
use srp_runtime::core::Activity;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::ops::Range;
use wellen::simple::Waveform;

/// An operation: its cycle, its unit or link, its name, its operands and result as bits of lanes.
pub(crate) type Operation = (u64, String, String, Vec<[u32; 4]>);

pub(crate) struct Waves {
    wave: Waveform,
    /// The changes of each signal that was asked for: time and bits.
    read: BTreeMap<String, Vec<(u64, String)>>,
}

impl Waves {
    pub(crate) fn of(bytes: Vec<u8>) -> Waves {
        let wave = wellen::simple::read_from_reader(Cursor::new(bytes)).expect("wellen reads it");
        Waves {
            wave,
            read: BTreeMap::new(),
        }
    }

    /// The bits of a signal at a time.
    fn at(&mut self, path: &[&str], time: u64) -> Option<String> {
        let name = path.join(".");
        if !self.read.contains_key(&name) {
            let (variable, scopes) = path.split_last().expect("a path has a name");
            let hierarchy = self.wave.hierarchy();
            let variable = hierarchy.lookup_var(scopes, *variable)?;
            let signal = hierarchy[variable].signal_ref();
            self.wave.load_signals(&[signal]);
            let times = self.wave.time_table().to_vec();
            let signal = self.wave.get_signal(signal).expect("it was loaded");
            let changes = signal.iter_changes().map(|(at, value)| {
                (
                    times[at as usize],
                    value.to_bit_string().expect("they are bits"),
                )
            });
            let changes = changes.collect();
            self.read.insert(name.clone(), changes);
        }
        let changes = &self.read[&name];
        let at = changes.partition_point(|(t, _)| *t <= time);
        Some(changes[at.checked_sub(1)?].1.clone())
    }

    fn lanes(&mut self, path: &[&str], time: u64) -> Option<[u32; 4]> {
        lanes(&self.at(path, time)?)
    }

    fn text(&mut self, path: &[&str], time: u64) -> Option<String> {
        let bits = self.at(path, time)?;
        let letters = bits.as_bytes().chunks(8).map(|letter| {
            let letter = std::str::from_utf8(letter).ok()?;
            u8::from_str_radix(letter, 2).ok()
        });
        let letters: Option<Vec<u8>> = letters.collect();
        let text = String::from_utf8(letters?).expect("texts are ASCII");
        Some(text.trim_matches('\0').to_owned())
    }

    /// Compares every register at every time; how many values.
    pub(crate) fn check_registers(
        &mut self,
        case: &Case,
        steps: &Steps,
        cycles: Range<u64>,
    ) -> usize {
        let mut compared = 0;
        for cycle in cycles.start..=cycles.end {
            // The registers that a launch sets are as they are in its first cycle; state is saved before.
            if !steps.enters(cycle) {
                let cells = steps.cells(&case.spec, cycle);
                compared += self.check(&case.program, &case.spec, 0, cycle, &cells);
            }
        }
        compared
    }

    /// Compares every register of a core at a time; how many values.
    pub(crate) fn check(
        &mut self,
        program: &Checked,
        spec: &SimSpec,
        core: u32,
        time: u64,
        cells: &Cells,
    ) -> usize {
        let srp = &program.arch().srp;
        let graph = ResourceGraph::of(srp);
        let places = graph.places.keys();
        let places: Vec<_> = places.filter(|&p| graph.as_wire(p).is_none()).collect();
        let core = format!("core{core}");
        let mut compared = 0;
        for (number, cells) in cells {
            let store = &spec.stores[*number];
            let name = match places.get(*number) {
                Some(&place) => graph.name(srp, place),
                None => store.name.clone(),
            };
            let group = match store.role {
                Role::Output => "outputs".to_owned(),
                Role::File | Role::Rotating => "files".to_owned(),
                Role::Flight(k) => format!("on_the_way_{}", spec.kernels[k as usize].name),
            };
            let is_file = matches!(store.role, Role::File | Role::Rotating);
            for (i, expected) in cells.iter().enumerate() {
                let register = format!("r{i}");
                let path = match store.size == 1 && !is_file {
                    true => vec![core.as_str(), &group, &name],
                    false => vec![core.as_str(), &group, &name, &register],
                };
                let found = self.lanes(&path, time);
                let found = found.unwrap_or_else(|| panic!("{path:?} at {time}"));
                assert_eq!(&found[..expected.len()], expected, "{path:?} at {time}");
                compared += 1;
            }
        }
        compared
    }

    /// The operations and transfers of some cycles.
    pub(crate) fn operations(&mut self, case: &Case, cycles: Range<u64>) -> Vec<Operation> {
        let srp = &case.program.arch().srp;
        let mut all = Vec::new();
        for cycle in cycles {
            for unit in srp.fus.values() {
                let path = |signal| ["core0", "units", unit.name.as_str(), signal];
                let Some(op) = self.text(&path("op"), cycle) else {
                    continue;
                };
                let values = ["a", "b", "c", "result"].map(|s| self.lanes(&path(s), cycle));
                let values = values.into_iter().flatten().collect();
                all.push((cycle, unit.name.clone(), op, values));
            }
            let unit = |fu| &srp.fus[fu].name;
            let links = (srp.links.values())
                .map(|link| ("links", format!("{}_to_{}", unit(link.from), unit(link.to))));
            let wires = srp.wires.values().map(|wire| ("wires", wire.name.clone()));
            for (group, name) in links.chain(wires) {
                if let Some(value) = self.lanes(&["core0", group, &name], cycle) {
                    all.push((cycle, name, "transfer".to_owned(), vec![value, value]));
                }
            }
        }
        all.sort();
        all
    }

    /// Compares the results that units say with what stands in their outputs when it is due, on the array; how many.
    pub(crate) fn check_results(
        &mut self,
        case: &Case,
        steps: &Steps,
        cycles: Range<u64>,
    ) -> usize {
        let srp = &case.program.arch().srp;
        let mut compared = 0;
        for cycle in cycles.clone() {
            if !matches!(steps.activity(cycle), Activity::Array(_)) {
                continue;
            }
            for (fu, unit) in srp.fus.iter() {
                let path = |signal| ["core0", "units", unit.name.as_str(), signal];
                let Some(op) = self.text(&path("op"), cycle) else {
                    continue;
                };
                let op = srp_archdesc::isa::Opcode::parse(&op).expect("an operation");
                let Some(ty) = op.result() else { continue };
                let due = cycle + u64::from(unit.timing(op).expect("it runs it").latency);
                if due > cycles.end {
                    continue;
                }
                let graph = ResourceGraph::of(srp);
                let place = match ty {
                    Ty::Pred => graph.pred_out[fu],
                    Ty::Word | Ty::Vec => graph.out[fu],
                };
                let output = case.spec.stores[place.index()].ty;
                let name = graph.name(srp, place);
                let result = self.lanes(&path("result"), cycle).expect("it has one");
                let stands = self
                    .lanes(&["core0", "outputs", &name], due)
                    .expect("it stands");
                let count = if ty == Ty::Vec { 4 } else { 1 };
                assert_eq!(
                    result[..count],
                    stands[..count],
                    "{name} {output:?} at {due}"
                );
                compared += 1;
            }
        }
        compared
    }
}

/// A value from its bits, `None` where it is undefined.
fn lanes(bits: &str) -> Option<[u32; 4]> {
    let mut lanes = [0; 4];
    for (i, bit) in bits.bytes().rev().enumerate() {
        match bit {
            b'0' => {}
            b'1' => lanes[i / 32] |= 1 << (i % 32),
            _ => return None,
        }
    }
    Some(lanes)
}
