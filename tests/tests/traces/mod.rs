//! Traces are read back by other people's readers, and hold what the interpreter has in every cycle.

mod frame;
mod history;
mod konata;
mod steps;
mod timeline;
mod waves;

use srp_archdesc::arch::Arch;
use srp_archdesc::{Unwatched, machines};
use srp_csimgen::{Interpreter, SimSpec, link};
use srp_ir::check::Checked;
use srp_runtime::solo::{self, Finish, Solo};
use srp_tests::{compiled, machine};
use srp_toolchain::{Effort, schedule};
use srp_traces::{Format, TraceError, Tracer, Window};
use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};
use steps::Steps;
use waves::{Operation, Waves};

/// Loops on the array with long and short operations, vectors, a rotating file where the machine has one; calls, a
/// walk along a list, and a loop that is launched again and again.
const PROGRAM: &str = "\
float a[64], b[64];
int next[64];
int hops(int from) {
    int n = 0;
    while (next[from]) { from = next[from]; n++; }
    return n;
}
int main(void) {
    for (int i = 0; i < 64; i++) next[i] = i < 40 ? i + 1 : 0;
    for (int i = 0; i < 64; i++) a[i] = (float)(i + 1);
    float sum = 0;
    for (int times = 0; times < 5; times++) {
#pragma srp kernel
        for (int i = 0; i < 64; i++)
            b[i] += a[i] * 2.0f + (i > 7 ? 1.0f / a[i] : 0.0f);
        sum += b[times];
    }
    return hops(1) + hops(2) + (int)sum;
}
";

/// The machine `tiny` with a bus for each row and column instead of links.
fn wired() -> Arch {
    let tiny = machines::ALL.into_iter().find(|m| m.name == "tiny");
    let tiny = tiny.expect("a shipped machine").xml;
    let text = tiny.replace(
        "topology=\"mesh\"",
        "topology=\"none\" wires=\"row column\"",
    );
    srp_archdesc::parse("wired.xml", &text).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// A program, compiled and scheduled for one of the machines, or for [`wired`].
pub(crate) struct Case {
    pub(crate) program: Checked,
    pub(crate) spec: SimSpec,
}

impl Case {
    fn on(name: &str) -> Case {
        let folder = std::env::temp_dir().join(format!("srp-traces-{}-{name}", std::process::id()));
        fs::create_dir_all(&folder).expect("a temporary folder");
        let file = folder.join("program.c");
        fs::write(&file, PROGRAM).expect("a temporary file");
        let arch = match name {
            "wired" => wired(),
            _ => machine(name),
        };
        let program = compiled(&[file], &arch).expect("it compiles");
        let session = srp_tests::session();
        let scheduled = schedule(program, &arch, Effort::default(), &session);
        let program = scheduled.expect("it is scheduled").schedule.program;
        let _ = fs::remove_dir_all(folder);
        let spec = link(&program).expect("it links");
        Case { program, spec }
    }

    fn bus(&self) -> Solo {
        Solo::new(&self.program.image, self.spec.sram_bytes)
    }

    /// The file of a window, and the cycles that are in it.
    fn traced(&self, window: &str, format: Format) -> (Vec<u8>, std::ops::Range<u64>) {
        let window = Window::parse(window).expect("it is one");
        let mut tracer = Tracer::new(&self.program, window).expect("it links");
        let mut core = tracer.core(Box::new(Interpreter::new(&self.spec)));
        let (mut bus, mut finish) = (self.bus(), Finish::default());
        let ended = solo::run_until(core.as_mut(), &mut bus, 1 << 30, &Unwatched, &mut finish);
        ended.expect("it ends");
        let mut plain = Interpreter::new(&self.spec);
        let untraced = solo::run(&mut plain, &mut self.bus(), 1 << 30).expect("it ends");
        assert_eq!(finish, untraced, "a trace changes nothing");
        let trace = tracer.trace().expect("the window was reached");
        assert!(!trace.is_cut);
        let bytes = format.write(&trace).expect("it can be written");
        let length = trace.cycles.end - trace.cycles.start;
        let largest = tracer.largest(format, length, 1);
        assert!(bytes.len() as u64 <= largest, "{} > {largest}", bytes.len());
        (bytes, trace.cycles)
    }
}

/// Every register in every cycle, by the waves and by the interpreter's saved state; and what units were given gives
/// the results that stand in their outputs when they are due.
#[test]
fn waves_have_the_registers_of_every_cycle() {
    for name in ["sgrt", "tiny", "wired"] {
        let case = Case::on(name);
        let steps = Steps::of(&case);
        let all = format!("0..{}", steps.len());
        let launch = format!("kernel:{}#3", case.spec.kernels.last().expect("one").name);
        for window in [all.as_str(), "1..2", "450..700", &launch] {
            let (bytes, cycles) = case.traced(window, Format::Fst);
            let mut waves = Waves::of(bytes);
            let compared = waves.check_registers(&case, &steps, cycles.clone());
            assert!(compared as u64 >= cycles.end - cycles.start);
            let results = waves.check_results(&case, &steps, cycles.clone());
            assert!(window == "1..2" || results > 50, "{window}: {results}");
        }
    }
}

/// A launch's window is its cycles on the array.
#[test]
fn a_launch_is_its_cycles_on_the_array() {
    let case = Case::on("sgrt");
    let steps = Steps::of(&case);
    let number = case.spec.kernels.len() - 1;
    let name = &case.spec.kernels[number].name;
    let launches = steps.launches(number as u32);
    assert_eq!(launches.len(), 5);
    for (i, launch) in launches.iter().enumerate() {
        let window = format!("kernel:{name}#{}", i + 1);
        assert_eq!(case.traced(&window, Format::Konata).1, *launch);
    }
    let window = Window::parse(&format!("kernel:{name}#6")).expect("it is one");
    let mut tracer = Tracer::new(&case.program, window).expect("it links");
    let mut core = tracer.core(Box::new(Interpreter::new(&case.spec)));
    solo::run(core.as_mut(), &mut case.bus(), 1 << 30).expect("it ends");
    let error = tracer.trace().expect_err("there is no sixth launch");
    assert!(matches!(error, TraceError::NotReached { .. }));
    assert!(error.to_string().contains("launched it 5 times"), "{error}");
}

/// Every line of the pipeline is an operation of the waves, in its cycle, on its unit, with its values; and it takes
/// its latency.
#[test]
fn the_pipeline_has_the_operations_of_the_waves() {
    for name in ["sgrt", "tiny", "wired"] {
        let case = Case::on(name);
        let (text, cycles) = case.traced("300..900", Format::Konata);
        let log = konata::read(std::str::from_utf8(&text).expect("it is text"));
        let (bytes, _) = case.traced("300..900", Format::Fst);
        let of_waves = Waves::of(bytes).operations(&case, cycles);
        assert!(of_waves.len() > 500);
        assert_eq!(log.operations(), of_waves);
        log.check_latencies(&case);
        let over_wires =
            |(_, who, what, _): &Operation| what == "transfer" && !who.contains("_to_");
        assert_eq!(of_waves.iter().any(over_wires), name == "wired");
    }
}

/// Slices of units are the operations of the waves with their places; those of the core are its cycles.
#[test]
fn the_timeline_has_the_operations_of_the_waves() {
    let case = Case::on("sgrt");
    let (bytes, cycles) = case.traced("300..900", Format::Perfetto);
    let timeline = timeline::read(&bytes);
    read_by_perfetto(&bytes, timeline.packets);
    let (waves, _) = case.traced("300..900", Format::Fst);
    let all = Waves::of(waves).operations(&case, cycles.clone());
    let of_waves = all.into_iter().filter(|(_, _, what, _)| what != "transfer");
    let of_waves: Vec<_> = of_waves
        .map(|(cycle, unit, op, _)| (cycle, unit, op))
        .collect();
    let above = "core 0/units/";
    let units = timeline.slices.iter();
    let units = units.filter_map(|(path, slices)| Some((path.strip_prefix(above)?, slices)));
    let mut found = Vec::new();
    for (unit, slices) in units.filter(|(unit, _)| *unit != "branches") {
        for slice in slices {
            assert_eq!(slice.end, slice.begin + 1);
            let place = slice.place.as_ref();
            assert!(
                place.is_none_or(|p| p.contains(".c:") || p.contains(".h:")),
                "{place:?}"
            );
            found.push((slice.begin, unit.to_owned(), slice.name.clone()));
        }
    }
    found.sort();
    assert_eq!(found, of_waves);
    let activity = timeline.cycles("core 0/activity");
    assert_eq!(activity.values().sum::<u64>(), cycles.end - cycles.start);
}

/// Perfetto's own bindings for Python read as many packets, where they are installed.
pub(crate) fn read_by_perfetto(bytes: &[u8], packets: usize) {
    let script = "\
from perfetto.protos.perfetto.trace import perfetto_trace_pb2 as p
import sys
trace = p.Trace()
trace.ParseFromString(sys.stdin.buffer.read())
assert all(e.HasField('track_event') or e.HasField('track_descriptor') for e in trace.packet)
print(len(trace.packet))
";
    let run = |script: &str| {
        let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
        let mut child = Command::new(python)
            .args(["-c", script])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut to = child.stdin.take()?;
        let bytes = bytes.to_vec();
        let writing = std::thread::spawn(move || to.write_all(&bytes));
        let output = child.wait_with_output().ok()?;
        let _ = writing.join();
        Some(output)
    };
    let import = "from perfetto.protos.perfetto.trace import perfetto_trace_pb2";
    if !run(import).is_some_and(|output| output.status.success()) {
        println!("skipped: there is no module perfetto for Python");
        return;
    }
    let output = run(script).expect("it runs");
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(said.trim(), packets.to_string());
}

/// GTKWave's converter reads the waves, where it is installed.
#[test]
fn gtkwave_reads_the_waves() {
    let case = Case::on("tiny");
    let (bytes, cycles) = case.traced("10..60", Format::Fst);
    let file = std::env::temp_dir().join(format!("srp-traces-{}.fst", std::process::id()));
    fs::write(&file, bytes).expect("a temporary file");
    let output = Command::new("fst2vcd").arg("-f").arg(&file).output();
    let _ = fs::remove_file(&file);
    let Ok(output) = output else {
        println!("skipped: there is no fst2vcd");
        return;
    };
    let text = String::from_utf8(output.stdout).expect("a VCD file is text");
    assert!(text.contains("core0") && text.contains("$var"), "{text}");
    assert!(text.contains(&format!("\n#{}\n", cycles.start)));
    // What viewers add to times.
    let offset = text.split_once("$timezero").map(|(_, rest)| rest.trim());
    assert!(offset.is_none_or(|rest| rest.starts_with("0\n")), "{text}");
}
