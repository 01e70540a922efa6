//! Two accounts of frames.

use super::{Change, Comparison, Document, FRAME, Figures, Section, add, changes};
use crate::Error;
use serde_json::Value;

/// Figures of the whole frame.
const WHOLE: [(&str, &str); 4] = [
    ("milliseconds", "/milliseconds"),
    ("million rays a second", "/mrays_per_second"),
    ("rays", "/rays"),
    ("energy, mJ", "/energy/total_mj"),
];

/// Pipelines of a T&I unit.
const PIPELINES: [(&str, &str); 4] = [
    ("ray setup and fetch", "/tni/pre"),
    ("box tests", "/tni/aabb"),
    ("stack and next node", "/tni/post"),
    ("triangle tests", "/tni/ist"),
];

/// What a T&I unit did.
const WORK: [(&str, &str); 8] = [
    ("rays", "/tni/unit/rays"),
    ("inner nodes visited", "/tni/trv/inner_visits"),
    ("leaves visited", "/tni/trv/leaf_visits"),
    ("box tests", "/tni/box_tests"),
    ("triangle tests", "/tni/triangle_tests"),
    ("stack pushes", "/tni/stacks/pushes"),
    ("stack overflows", "/tni/stacks/overflows"),
    ("restarts from the root", "/tni/stacks/restarts"),
];

/// Caches of a core and its T&I unit.
const CACHES: [(&str, &str); 5] = [
    ("data cache", "/data_cache"),
    ("texture cache", "/texture_cache"),
    ("T&I nodes, first level", "/tni/trv_l1"),
    ("T&I nodes, second level", "/tni/trv_l2"),
    ("T&I triangles", "/tni/ist_l1"),
];

/// Compares two frames.
pub(super) fn compare(old: &Document<'_>, new: &Document<'_>) -> Result<Comparison, Error> {
    for (what, pointer) in [("wide", "/width"), ("high", "/height")] {
        let [a, b] = [old.number(pointer)?, new.number(pointer)?];
        if a != b {
            return Err(Error::invalid(format_args!(
                "the frames are {a} and {b} pixels {what}: render both at one size"
            )));
        }
    }
    let [a, b] = [old.scene()?, new.scene()?];
    if a.name != b.name {
        return Err(Error::invalid(format_args!(
            "the frames are of two scenes, {} and {}: their cycles say nothing about each other",
            a.name, b.name
        )));
    }
    let mut notes = Vec::new();
    if a.hash != b.hash {
        notes.push(
            "the scenes are not the same: geometry, camera, lights or options differ".to_owned(),
        );
    }
    for frame in [old, new] {
        if frame.value.pointer("/complete") != Some(&Value::Bool(true)) {
            notes.push(format!("{} is of a part of a frame", frame.file));
        }
    }
    let both = |pointer: &str| -> Result<[f64; 2], Error> {
        Ok([old.number(pointer)?, new.number(pointer)?])
    };
    let mut figures = Vec::new();
    for (what, pointer) in WHOLE {
        let [a, b] = both(pointer)?;
        figures.push(Change::new(what, Some(a), Some(b)));
    }
    let [a, b] = both("/cycles")?;
    let section = |name, unit, of: &Part| -> Result<Section, Error> {
        Ok(Section::of(name, unit, changes(&of(old)?, &of(new)?)))
    };
    Ok(Comparison {
        of: FRAME.format,
        machines: [old.machine()?, new.machine()?],
        notes,
        cycles: Change::new("the frame", Some(a), Some(b)),
        figures,
        sections: vec![
            section("cycles of all cores", "cycles", &core_cycles)?,
            section("cycles of the T&I pipelines", "cycles", &pipelines)?,
            section("work of the T&I units", "", &work)?,
            section("misses", "lines", &misses)?,
            section("memory", "", &memory)?,
            section("energy", "mJ", &energy)?,
        ],
    })
}

/// The figures of a section.
type Part = dyn Fn(&Document<'_>) -> Result<Figures, Error>;

/// The cycles of the cores. They sum to the cycles of the frame times the cores.
fn core_cycles(frame: &Document<'_>) -> Result<Figures, Error> {
    let mut figures = Figures::new();
    for core in frame.list("/cores")? {
        let number = |pointer: &str| frame.number_in(core, pointer);
        add(&mut figures, "VLIW", number("/vliw")?);
        add(&mut figures, "mode switch", number("/switch")?);
        add(&mut figures, "idle", number("/idle")?);
        for kernel in frame.list_in(core, "/array")? {
            let name = frame.text_in(kernel, "/kernel")?;
            let cycles = frame.number_in(kernel, "/cycles")?;
            add(&mut figures, format!("array: {name}"), cycles);
        }
        for (name, pointer) in [
            ("instruction stall", "/instruction_stall"),
            ("context stall", "/context_stall"),
            ("SRAM bank stall", "/sram_stall"),
        ] {
            add(&mut figures, name, frame.count_in(core, pointer)?);
        }
        let mut control = number("/memory_stall")? + number("/texture_stall")?;
        for kernel in frame.list_in(core, "/kernel_stalls")? {
            let name = frame.text_in(kernel, "/kernel")?;
            let cycles = frame.number_in(kernel, "/cycles")?;
            add(&mut figures, format!("cache stall: {name}"), cycles);
            control -= cycles;
        }
        add(&mut figures, "cache stall: control code", control);
        for port in frame.list_in(core, "/wait")? {
            let name = frame.text_in(port, "/port")?;
            let cycles = frame.number_in(port, "/cycles")?;
            add(&mut figures, format!("wait: {name}"), cycles);
        }
    }
    Ok(figures)
}

/// The cycles of the pipelines by what they were spent on, but for those without anything to do.
fn pipelines(frame: &Document<'_>) -> Result<Figures, Error> {
    let mut figures = Figures::new();
    for core in frame.list("/cores")? {
        for (name, pointer) in PIPELINES {
            let pointer = format!("{pointer}/account");
            let account = core.pointer(&pointer).and_then(Value::as_object);
            let account = account.ok_or_else(|| frame.lacks(&pointer, "account"))?;
            for (reason, cycles) in account.iter().filter(|(reason, _)| *reason != "idle") {
                let cycles = cycles.as_f64();
                let cycles = cycles.ok_or_else(|| frame.lacks(&pointer, "number"))?;
                add(&mut figures, format!("{name}: {reason}"), cycles);
            }
        }
    }
    Ok(figures)
}

fn work(frame: &Document<'_>) -> Result<Figures, Error> {
    let mut figures = Figures::new();
    for core in frame.list("/cores")? {
        for (name, pointer) in WORK {
            add(&mut figures, name, frame.number_in(core, pointer)?);
        }
    }
    Ok(figures)
}

fn misses(frame: &Document<'_>) -> Result<Figures, Error> {
    let mut figures = Figures::new();
    for core in frame.list("/cores")? {
        for (name, pointer) in CACHES {
            let misses = frame.number_in(core, &format!("{pointer}/misses"))?;
            add(&mut figures, name, misses);
        }
    }
    Ok(figures)
}

fn memory(frame: &Document<'_>) -> Result<Figures, Error> {
    let mut figures = Figures::new();
    add(
        &mut figures,
        "bytes read",
        frame.number("/dram/counters/bytes_read")?,
    );
    add(
        &mut figures,
        "bytes written",
        frame.number("/dram/counters/bytes_written")?,
    );
    for channel in frame.list("/dram/counters/channels")? {
        add(
            &mut figures,
            "rows opened",
            frame.number_in(channel, "/activates")?,
        );
    }
    add(
        &mut figures,
        "mean latency of a read, ns",
        frame.number("/dram/mean_read_ns")?,
    );
    Ok(figures)
}

fn energy(frame: &Document<'_>) -> Result<Figures, Error> {
    let mut figures = Figures::new();
    for part in frame.list("/energy/parts")? {
        let name = frame.text_in(part, "/part")?.replace('_', " ");
        add(&mut figures, name, frame.number_in(part, "/mj")?);
    }
    Ok(figures)
}
