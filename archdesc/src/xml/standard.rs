//! The standard arrays of the field, as machine files.
//!
//! Mappers are compared on homogeneous arrays of one-cycle operations: a mesh, with diagonals, with
//! its edges joined, or with links of one hop more, beside them perhaps switches or buses; a few registers in
//! each unit; memory operations everywhere or in the first columns only.

use std::fmt::Write;

use super::limits;
use super::values::list;
use super::wires;
use crate::isa::Class;

/// The links of a standard array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArrayTopology {
    /// To the four neighbours.
    Mesh,
    /// To the eight neighbours.
    Diagonal,
    /// To the four neighbours, the edges joined.
    Torus,
    /// To the four neighbours, and those two steps away in the row and the column.
    OneHop,
}

impl ArrayTopology {
    /// The word of the attribute `topology`.
    fn word(self) -> &'static str {
        match self {
            ArrayTopology::Mesh => "mesh",
            ArrayTopology::Diagonal => "mesh-diagonal",
            ArrayTopology::Torus => "torus",
            ArrayTopology::OneHop => "one-hop",
        }
    }
}

/// A standard array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StandardArray {
    /// Rows, from 1 to 64.
    pub rows: u32,
    /// Columns, from 1 to 64.
    pub cols: u32,
    /// Its links.
    pub topology: ArrayTopology,
    /// Its switches and buses, as the attribute `wires` has them; empty for none.
    pub wires: String,
    /// Wires that a value passes in one cycle at most, from 1 to 16.
    pub hops: u32,
    /// Registers that each unit has for itself, up to 1024; not rotating.
    pub registers: u32,
    /// Columns whose units run memory operations, from the left; `None` for all.
    pub memory_columns: Option<u32>,
    /// Classes that every unit runs (those of memory only where memory operations are).
    pub classes: Vec<Class>,
    /// Cycles that every operation takes, from 1 to 64.
    pub latency: u32,
    /// Depth of the configuration memory, from 1 to 4096.
    pub contexts: u32,
}

impl StandardArray {
    /// A mesh of one-cycle units that run all scalar operations, with 8 registers each.
    pub fn mesh(rows: u32, cols: u32) -> StandardArray {
        StandardArray {
            rows,
            cols,
            topology: ArrayTopology::Mesh,
            wires: String::new(),
            hops: wires::HOPS,
            registers: 8,
            memory_columns: None,
            classes: scalar_classes(),
            latency: 1,
            contexts: 128,
        }
    }
}

/// The classes of words and predicates that an array can run: all but those of vectors and those of
/// control code.
pub fn scalar_classes() -> Vec<Class> {
    let classes = Class::ALL.iter().copied();
    classes
        .filter(|&class| {
            !is_vector(class)
                && !matches!(class, Class::Io | Class::Branch | Class::Fast | Class::Pair)
        })
        .collect()
}

fn is_vector(class: Class) -> bool {
    use Class::*;
    matches!(
        class,
        Lane | Valu | Vmul | Vfadd | Vfmul | Vfma | Vdot | Vpair | Tex
    )
}

fn is_memory(class: Class) -> bool {
    use Class::*;
    matches!(class, Load | Store | Cload | Cstore)
}

/// The machine file of a standard array: units without slots or central files, whose one output
/// their neighbours and they themselves read.
///
/// # Errors
///
/// Which number is out of its range, and what the range is.
pub fn standard(array: &StandardArray) -> Result<String, String> {
    check(array)?;
    let StandardArray {
        rows,
        cols,
        topology,
        registers,
        latency,
        contexts,
        ..
    } = array;
    let name = name(array);
    let mut out = String::new();
    let mut line = |text: std::fmt::Arguments<'_>| {
        writeln!(out, "{text}").expect("writing to a string does not fail");
    };
    line(format_args!("<machine name=\"{name}\">"));
    for class in &array.classes {
        line(format_args!(
            "  <op class=\"{class}\" latency=\"{latency}\" interval=\"1\"/>"
        ));
    }
    let memory = array.memory_columns.unwrap_or(*cols);
    let plain: Vec<Class> = (array.classes.iter().copied())
        .filter(|&class| !is_memory(class))
        .collect();
    let kinds = [
        ("mem", memory > 0, &array.classes),
        ("pe", memory < *cols, &plain),
    ];
    let wide = array.classes.iter().any(|&class| is_vector(class));
    let width = if wide { 128 } else { 32 };
    for (kind, _, classes) in kinds.iter().filter(|(_, there, _)| *there) {
        let classes: Vec<&str> = classes.iter().map(|class| class.name()).collect();
        let tag = format!(
            "  <fu-type name=\"{kind}\" width=\"{width}\" pred-out=\"false\" constants=\"4\" \
             classes=\"{}\"",
            classes.join(" ")
        );
        if *registers == 0 {
            line(format_args!("{tag}/>"));
            continue;
        }
        let ports = (*registers).min(256);
        line(format_args!("{tag}>"));
        line(format_args!(
            "    <file name=\"r\" kind=\"static\" size=\"{registers}\" read-ports=\"{ports}\" \
             write-ports=\"{ports}\"/>"
        ));
        line(format_args!("  </fu-type>"));
    }
    let wires = match array.wires.as_str() {
        "" => String::new(),
        words if has_switches(words) => format!(" wires=\"{words}\" hops=\"{}\"", array.hops),
        words => format!(" wires=\"{words}\""),
    };
    line(format_args!(
        "  <array rows=\"{rows}\" cols=\"{cols}\" topology=\"{}\"{wires} contexts=\"{contexts}\">",
        topology.word()
    ));
    let units: Vec<&str> = (0..*cols)
        .map(|col| if col < memory { "mem" } else { "pe" })
        .collect();
    line(format_args!("    <row units=\"{}\"/>", units.join(" ")));
    line(format_args!("  </array>"));
    line(format_args!("  <vliw slots=\"0\"/>"));
    line(format_args!("</machine>"));
    Ok(out)
}

/// True if one of these words means switches, by which a value goes from wire to wire.
fn has_switches(words: &str) -> bool {
    let mut kinds = words
        .split([' ', '\t', '\n'])
        .map(|word| word.split(':').next());
    let is_switch = |kind: Option<&str>| {
        let known = wires::KINDS.iter().find(|(name, _)| Some(*name) == kind);
        matches!(known, Some((_, wires::Kind::Switches(_))))
    };
    kinds.any(is_switch)
}

/// A name that says what it is.
fn name(array: &StandardArray) -> String {
    let topology = array.topology.word().replace('-', "_");
    let memory = match array.memory_columns {
        Some(columns) if columns < array.cols => format!("_mem{columns}"),
        _ => String::new(),
    };
    let mut wires: String = (array.wires.split_ascii_whitespace())
        .map(|word| format!("_{}", word.replace('-', "_").replace(':', "")))
        .collect();
    if !wires.is_empty() && array.hops != wires::HOPS {
        wires += &format!("_h{}", array.hops);
    }
    format!(
        "{topology}_{}x{}_r{}{memory}{wires}",
        array.rows, array.cols, array.registers
    )
}

fn check(array: &StandardArray) -> Result<(), String> {
    let ranges = [
        ("rows", array.rows, limits::ROWS.min, limits::ROWS.max),
        ("columns", array.cols, limits::COLS.min, limits::COLS.max),
        ("registers", array.registers, 0, limits::FILE_SIZE.max),
        (
            "latency",
            array.latency,
            limits::LATENCY.min,
            limits::LATENCY.max,
        ),
        (
            "contexts",
            array.contexts,
            limits::CONTEXTS.min,
            limits::CONTEXTS.max,
        ),
        ("hops", array.hops, limits::HOPS.min, limits::HOPS.max),
        (
            "memory columns",
            array.memory_columns.unwrap_or(0),
            0,
            array.cols,
        ),
    ];
    for (what, value, min, max) in ranges {
        if !(min..=max).contains(&value) {
            return Err(format!("{what}: {value} is not from {min} to {max}"));
        }
    }
    for word in array.wires.split_ascii_whitespace() {
        let (kind, count) = word.split_once(':').unwrap_or((word, "1"));
        let known = wires::KINDS.iter().map(|&(kind, _)| kind);
        if !known.clone().any(|other| other == kind) {
            return Err(format!("wires: `{kind}` is not one of {}", list(known)));
        }
        let (min, max) = (limits::WIRES.min, limits::WIRES.max);
        if !count.parse().is_ok_and(|n: u32| (min..=max).contains(&n)) {
            return Err(format!("wires: `{count}` is not from {min} to {max}"));
        }
    }
    if array.classes.is_empty() {
        return Err("the units need an operation class".to_owned());
    }
    if array.memory_columns.is_some_and(|k| k < array.cols)
        && array.classes.iter().all(|&class| is_memory(class))
    {
        return Err("the units that do not load and store have no class".to_owned());
    }
    match array
        .classes
        .iter()
        .find(|c| matches!(c, Class::Io | Class::Branch))
    {
        Some(class) => Err(format!("class `{class}` is for VLIW slots only")),
        None => Ok(()),
    }
}
