//! A reader of Konata's logs, written from the description of the format: every command must be known, and name an
//! operation that is there, in a stage that it is in.

use super::Case;
use super::waves::Operation;
use srp_archdesc::isa::Opcode;
use std::collections::BTreeMap;

/// A line of the pipeline.
#[derive(Default)]
struct Line {
    label: String,
    detail: String,
    /// Stages with the cycles in which they begin and end.
    stages: Vec<(String, u64, Option<u64>)>,
    /// The cycle in which it is retired, and whether it is flushed.
    retired: Option<(u64, bool)>,
    producers: Vec<u64>,
}

pub(crate) struct Log {
    lines: BTreeMap<u64, Line>,
}

/// Reads a log.
pub(crate) fn read(text: &str) -> Log {
    let mut rows = text.lines();
    assert_eq!(rows.next(), Some("Kanata\t0004"));
    let mut cycle = None;
    let mut lines: BTreeMap<u64, Line> = BTreeMap::new();
    for row in rows {
        let fields: Vec<&str> = row.splitn(4, '\t').collect();
        let number = |i: usize| fields[i].parse::<u64>().expect(row);
        match (fields[0], cycle) {
            ("C=", None) => cycle = Some(number(1)),
            ("C", Some(now)) => {
                assert!(number(1) > 0, "{row}");
                cycle = Some(now + number(1));
            }
            ("I", Some(_)) => {
                assert_eq!((fields.len(), number(1)), (4, lines.len() as u64), "{row}");
                lines.insert(number(1), Line::default());
            }
            (command, Some(now)) => {
                assert!(command != "W" || lines.contains_key(&number(2)), "{row}");
                let line = lines.get_mut(&number(1)).expect(row);
                line.take(command, &fields, now);
            }
            _ => panic!("{row}"),
        }
    }
    assert!(lines.values().all(|line| line.retired.is_some()));
    Log { lines }
}

impl Line {
    fn take(&mut self, command: &str, fields: &[&str], now: u64) {
        let number = |i: usize| fields[i].parse::<u64>().expect("a number");
        assert!(
            self.retired.is_none() || command == "W",
            "it is over: {fields:?}"
        );
        match command {
            "L" if fields[2] == "0" => self.label.push_str(fields[3]),
            "L" if fields[2] == "1" => self.detail.push_str(fields[3]),
            "S" => {
                assert!(self.stages.iter().all(|s| s.2.is_some()), "{fields:?}");
                self.stages.push((fields[3].to_owned(), now, None));
            }
            "E" => {
                let stage = self.stages.last_mut().expect("it is in a stage");
                assert_eq!((stage.0.as_str(), stage.2), (fields[3], None));
                stage.2 = Some(now);
            }
            "R" => {
                assert!(self.stages.iter().all(|s| s.2.is_some()), "{fields:?}");
                self.retired = Some((now, fields[3] == "1"));
            }
            "W" => self.producers.push(number(2)),
            _ => panic!("{fields:?}"),
        }
    }

    /// Who does it, and which operation; `None` for a branch.
    fn names(&self) -> Option<(&str, &str)> {
        let mut words = self.label.split_whitespace();
        let mut who = words.next()?;
        if who.ends_with(':') {
            who = words.next()?;
        }
        (who != "vliw").then_some((who, words.next()?))
    }

    fn begins(&self) -> u64 {
        self.stages[0].1
    }

    fn values(&self) -> Vec<[u32; 4]> {
        let text = self.detail.split(" at ").next().unwrap_or_default();
        let (operands, result) = match text.split_once(" = ") {
            Some((operands, result)) => (operands, Some(result)),
            None => (text, None),
        };
        let all = operands.split(", ").filter(|o| !o.is_empty()).chain(result);
        all.map(|value| {
            let mut lanes = [0; 4];
            let words = value.trim_matches(['(', ')']).split(' ');
            for (lane, word) in lanes.iter_mut().zip(words) {
                let digits = word.strip_prefix("0x");
                *lane = u32::from_str_radix(digits.unwrap_or(word), 16).expect("a number");
            }
            lanes
        })
        .collect()
    }
}

impl Log {
    /// The operations and transfers, as the waves have them.
    pub(crate) fn operations(&self) -> Vec<Operation> {
        let all = self.lines.values().filter_map(|line| {
            let (who, what) = line.names()?;
            Some((
                line.begins(),
                who.to_owned(),
                what.to_owned(),
                line.values(),
            ))
        });
        let mut all: Vec<Operation> = all.collect();
        all.sort();
        all
    }

    /// Lines take as long as their units do, and read what others have made before.
    pub(crate) fn check_latencies(&self, case: &Case) {
        let srp = &case.program.arch().srp;
        let mut with_producers = 0;
        for line in self.lines.values() {
            let (end, is_flushed) = line.retired.expect("all are");
            let Some((who, what)) = line.names() else {
                continue;
            };
            let unit = srp.fus.values().find(|fu| fu.name == who);
            let op = Opcode::parse(what).filter(|op| op.result().is_some());
            if let (Some(unit), Some(op), false) = (unit, op, is_flushed) {
                let latency = unit.timing(op).expect("it runs it").latency;
                assert_eq!(end - line.begins(), u64::from(latency), "{}", line.label);
                let names: Vec<&str> = line.stages.iter().map(|s| s.0.as_str()).collect();
                let expected: &[&str] = match latency {
                    1 => &["Is"],
                    2 => &["Is", "Wb"],
                    _ => &["Is", "Ex", "Wb"],
                };
                assert_eq!(names, expected, "{}", line.label);
            }
            for producer in &line.producers {
                let (made, _) = self.lines[producer].retired.expect("all are");
                assert!(made <= line.begins(), "{} reads too early", line.label);
                with_producers += 1;
            }
        }
        assert!(with_producers * 2 > self.lines.len(), "{with_producers}");
    }
}
