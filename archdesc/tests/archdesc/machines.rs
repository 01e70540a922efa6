//! The shipped machines: what they are, that they grow, and that their expanded form is the same
//! machine. Golden texts stand in `tests/golden/`; `BLESS=1 cargo test` writes them anew.

use std::fmt::Write;
use std::path::Path;

use srp_archdesc::arch::{Approx, Carrier, FileKind, Fu, Refine, Subnormals};
use srp_archdesc::diagnostic::render_all;
use srp_archdesc::machines::{ALL, Machine, SGRT, TINY, WIDE};
use srp_archdesc::ops::semantics::elementary::SEPARATE;
use srp_archdesc::structure::Structure;
use srp_archdesc::system::GivenLatencies;
use srp_archdesc::system::NodeFormat;
use srp_archdesc::{Arch, Opcode, ResourceGraph, parse, show, xml};

#[track_caller]
fn read(name: &str, text: &str) -> Arch {
    match parse(name, text) {
        Ok(arch) => arch,
        Err(errors) => panic!("{}", render_all(&errors, text, false)),
    }
}

fn machine(machine: Machine) -> Arch {
    read(machine.name, machine.xml)
}

/// `text` with `from`, which it must have, replaced by `to`.
#[track_caller]
fn edit(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "no {from}");
    text.replace(from, to)
}

#[track_caller]
fn golden(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden")
        .join(name);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, text).expect("a writable golden file");
    }
    let expected = std::fs::read_to_string(&path).expect("a golden file");
    assert_eq!(text, expected, "{name}");
}

fn unit(arch: &Arch, name: &str) -> Fu {
    let named = arch.srp.fus.iter().find(|(_, unit)| unit.name == name);
    named.expect("a unit of that name").0
}

/// The machine with every kind of deviation from the layout.
fn changed() -> String {
    let cell = r#"<fu row="3" col="3" name="divider" type="special" constants="2">
      <op class="idiv" latency="20"/>
      <op class="fadd" uses="cache_port sram_port"/>
      <file name="x" kind="static" width="1" size="4" from-links="true"/>
    </fu>
    <fu row="2" col="0" width="32" pred-out="false" classes="alu load"/>
    <link from="fu_0_0" to="divider" delay="2" width="32"/>
    <file name="shared" kind="rotating" width="128" size="8" readers="all" writers="divider fu_1_1"/>
    <file name="pred""#;
    let special = r#"<special function="rcp" bits="12" steps="1"/>
  <special function="rsqrt" bits="10" steps="2" fused="false" refine="code"/>
  <special function="sqrt" bits="10" steps="2" fused="false" refine="code"/>
  <special function="div" bits="9" steps="1" fused="false"/>
  <special function="sincos" bits="20"/>
  <float subnormals="flush"/>
  <array"#;
    let xml = edit(SGRT.xml, "<file name=\"pred\"", cell);
    let xml = edit(&xml, "<array", special);
    let xml = edit(&xml, "node-bytes=\"32\"", "node-format=\"q8\"");
    edit(
        &xml,
        "link-delay=\"0\"",
        "link-delay=\"1\" link-width=\"32\"",
    )
}

#[test]
fn expanded_form_is_the_same_machine() {
    let files = ALL.map(|m| m.xml.to_owned());
    for text in files.into_iter().chain([changed()]) {
        let arch = read("compact", &text);
        let expanded = xml::write(&arch);
        let again = read("expanded", &expanded);
        assert_eq!(again, arch);
        assert_eq!(xml::write(&again), expanded);
    }
}

#[test]
fn default_machine_is_the_papers() {
    let arch = machine(SGRT);
    let gflops = arch.srp.peak_flops_per_cycle() * f64::from(arch.system.srp_mhz) / 1000.0;
    assert_eq!(gflops, 72.5);
    let system = &arch.system;
    assert_eq!((arch.srp.rows, arch.srp.cols, system.cores), (4, 4, 4));
    assert_eq!(system.sram_bytes, 240 * 1024);
    assert_eq!(system.data_cache.bytes, 4 * 1024);
    assert_eq!(system.texture_cache.bytes, 32 * 1024);
    let (buffers, tni) = (&system.buffers, &system.tni);
    assert_eq!(
        (buffers.rays, buffers.ray_buffers, buffers.hit_buffers),
        (64, 3, 2)
    );
    assert_eq!((tni.trvs, tni.ists, tni.stacks), (4, 1, 16));
    // A visit without and with a stack operation; the second box takes a cycle more.
    let visit = tni.pre_latency + tni.trv_l1.latency + tni.aabb_latency;
    assert_eq!((visit, visit + tni.post_latency), (25, 39));
    assert!(SGRT.xml.lines().count() <= 150);
}

/// Settings that a file leaves out are those of the default machine.
#[test]
fn defaults_are_those_of_the_default_machine() {
    let start = SGRT.xml.find("  <system").expect("a system");
    let end = SGRT.xml.find("</machine>").expect("an end");
    let mut short = SGRT.xml.to_owned();
    short.replace_range(start..end, "");
    let short: Vec<&str> = short
        .lines()
        .filter(|line| !line.contains("<op ") || line.contains("uses"))
        .collect();
    let short = edit(&short.join("\n"), " link-delay=\"0\" contexts=\"128\"", "");
    let vliw = " branch-delay=\"1\" mode-switch=\"2\" preload-width=\"4\"";
    let short = edit(&short, vliw, "");
    assert!(!short.contains("latency") && !short.contains("interval"));
    // Latencies of the T&I unit follow from its operators where none is given.
    let mut expected = machine(SGRT);
    expected.system.tni.given = GivenLatencies::default();
    expected.derive_cycles();
    assert_eq!(read("short", &short), expected);
}

#[test]
fn two_attributes_make_the_array_larger() {
    let small = machine(SGRT);
    let large = edit(SGRT.xml, "rows=\"4\" cols=\"4\"", "rows=\"8\" cols=\"8\"");
    let large = read("large", &large);
    assert_eq!(large.srp.fus.len(), 64);
    assert_eq!(large.srp.slots().len(), 4);
    assert_eq!(large.srp.peak_flops_per_cycle(), 290.0);
    for unit in large.srp.fus.values() {
        let model = small
            .srp
            .fus
            .values()
            .find(|u| (u.row, u.col) == (unit.row % 4, unit.col % 4))
            .expect("a cell of the tile");
        assert_eq!(unit.ops, model.ops);
        assert_eq!(unit.name, format!("fu_{}_{}", unit.row, unit.col));
    }
    // Horizontal, vertical and the two diagonals, each both ways.
    assert_eq!(large.srp.links.len(), 2 * (8 * 7 + 8 * 7 + 7 * 7 + 7 * 7));
    let largest = edit(WIDE.xml, "rows=\"8\" cols=\"8\"", "rows=\"64\" cols=\"64\"");
    assert_eq!(read("largest", &largest).srp.fus.len(), 4096);
}

#[test]
fn cells_and_links_can_deviate() {
    let arch = read("changed", &changed());
    let divider = &arch.srp.fus[unit(&arch, "divider")];
    assert_eq!((divider.row, divider.col, divider.constants), (3, 3, 2));
    let idiv = divider.runs(Opcode::Div).expect("its type's class");
    assert_eq!((idiv.latency, idiv.interval), (20, 4));
    let fadd = divider.runs(Opcode::Fadd).expect("an added class");
    let uses: Vec<&str> = fadd
        .uses
        .iter()
        .map(|&r| arch.srp.resources[r].name.as_str())
        .collect();
    assert_eq!(uses, ["cache_port", "sram_port"]);
    let narrow = &arch.srp.fus[unit(&arch, "fu_2_0")];
    assert!(narrow.runs(Opcode::Lw).is_some() && narrow.runs(Opcode::Lv).is_none());
    assert!(narrow.runs(Opcode::Pand).is_none() && !narrow.pred_out);
    let added = arch.srp.links.values().last().expect("links");
    assert_eq!((added.delay, added.width), (2, 32));
    assert!(
        arch.srp
            .links
            .values()
            .all(|l| l.delay > 0 && l.width == 32)
    );
    let own: Vec<&str> = arch
        .srp
        .files
        .values()
        .filter(|f| f.kind != FileKind::Central && f.readers == [unit(&arch, "divider")])
        .map(|f| f.name.as_str())
        .collect();
    assert_eq!(own, ["divider_x"]);
    assert_eq!(arch.precision.rcp, Approx::table(12, 1));
    assert_eq!(arch.precision.sincos, Approx::table(20, 0));
    let in_code = Approx::Table {
        structure: Structure::Table,
        bits: 10,
        steps: 2,
        fused: false,
        refine: Refine::Code,
    };
    assert_eq!([arch.precision.rsqrt, arch.precision.sqrt], [in_code; 2]);
    assert_eq!(in_code.arguments(), (10, 0));
    assert_eq!(arch.precision.div.arguments(), (9, 1 | SEPARATE));
    assert_eq!(arch.precision.exp2, Approx::Exact);
    assert_eq!(arch.precision.subnormals, Subnormals::Flush);
    let tni = &arch.system.tni;
    assert_eq!((tni.node_format, tni.node_bytes), (NodeFormat::Q8, 24));
}

#[test]
fn machines_are_shown() {
    golden("sgrt.show", &show(&machine(SGRT)));
    golden("changed.show", &show(&read("changed", &changed())));
}

#[test]
fn peaks_have_no_more_digits_than_a_clock() {
    for mhz in 400..800 {
        let clock = format!("srp-mhz=\"{mhz}\"");
        let arch = read("clock.xml", &edit(SGRT.xml, "srp-mhz=\"1000\"", &clock));
        let text = show(&arch);
        let line = text.lines().find(|line| line.starts_with("peak "));
        let peak = line.and_then(|line| line.split(' ').nth(1));
        let peak = peak.expect("a peak is shown");
        let digits = peak.split_once('.').map_or(0, |(_, digits)| digits.len());
        assert!(digits <= 3, "{mhz} MHz: {peak}");
    }
}

#[test]
fn resource_graph_of_the_tiny_machine() {
    let arch = machine(TINY);
    let graph = ResourceGraph::of(&arch.srp);
    golden("tiny.graph", &graph_text(&graph, &arch).expect("a string"));
}

fn graph_text(graph: &ResourceGraph, arch: &Arch) -> Result<String, std::fmt::Error> {
    let name = |place| graph.name(&arch.srp, place);
    let mut out = String::new();
    for (place, spec) in graph.places.iter() {
        let rotates = if graph.rotates(&arch.srp, place) {
            ", rotating"
        } else {
            ""
        };
        writeln!(
            out,
            "{place} {}: {} × {} bits{rotates}",
            name(place),
            spec.capacity,
            spec.width
        )?;
    }
    for (fu, unit) in arch.srp.fus.iter() {
        writeln!(out, "\n{fu} {}", unit.name)?;
        for read in &graph.reads[fu] {
            write!(out, "  reads {}, {} bits", name(read.from), read.width)?;
            match read.over {
                Some(over) => writeln!(out, ", {}, delay {}", carrier(over), read.delay)?,
                None => writeln!(out)?,
            }
        }
        for &place in &graph.writes[fu] {
            writeln!(out, "  writes {}", name(place))?;
        }
    }
    writeln!(out)?;
    for transfer in graph.transfers.values().flatten() {
        writeln!(
            out,
            "{} to {} over {}, delay {}, {} bits",
            name(transfer.from),
            name(transfer.to),
            carrier(transfer.over),
            transfer.delay,
            transfer.width
        )?;
    }
    for hop in graph.hops.values().flatten() {
        writeln!(
            out,
            "{} on to {} {}, delay {}, {} bits",
            name(hop.from),
            hop.to,
            name(hop.to),
            hop.delay,
            hop.width
        )?;
    }
    Ok(out)
}

fn carrier(carrier: Carrier) -> String {
    match carrier {
        Carrier::Link(link) => link.to_string(),
        Carrier::Wire(wire) => wire.to_string(),
    }
}

/// A machine with every kind of wire: switches in three cells, a bus, wires one by one.
fn wired() -> String {
    let wires = r#"topology="none" wires="mesh row" hops="2">
    <wire name="late" from="far row_0" to="fu_0_0" delay="2" width="32"/>
    <wire name="far" from="fu_0_2 mesh_0_1_0_2" width="128"/>
    <wire name="predicates" from="all" to="slots" width="1"/>"#;
    let xml = edit(TINY.xml, "rows=\"2\" cols=\"2\"", "rows=\"1\" cols=\"3\"");
    let start = xml.find("topology=").expect("an attribute");
    let end = start + xml[start..].find('>').expect("the end of a tag") + 1;
    format!("{}{wires}{}", &xml[..start], &xml[end..])
}

#[test]
fn wires_are_places_by_their_hops() {
    let arch = read("wired", &wired());
    let expanded = xml::write(&arch);
    assert_eq!(read("expanded", &expanded), arch);
    let written: Vec<&str> = (expanded.lines())
        .filter(|line| line.contains("<wire "))
        .collect();
    let grid = show(&arch);
    let shown = grid.split("\n\n").filter(|part| part.contains("wires"));
    let shown = shown.collect::<Vec<_>>().join("\n\n");
    let by_hops = graph_text(&ResourceGraph::by_hops(&arch.srp), &arch).expect("a string");
    let written = written.join("\n");
    golden("wired.graph", &format!("{shown}\n\n{written}\n\n{by_hops}"));
    let once = ResourceGraph::of(&arch.srp);
    assert!(once.wire.values().all(|places| places.len() == 1));
    let ways: usize = once.hops.values().map(Vec::len).sum();
    assert_eq!(
        ways,
        arch.srp.wires.values().map(|w| w.from.len()).sum::<usize>() + 8
    );
}

/// The example of the reference is a machine.
#[test]
fn example_of_the_reference_is_a_machine() {
    let reference = include_str!("../../FORMAT.md");
    let start = reference.find("```xml\n").expect("an example") + "```xml\n".len();
    let length = reference[start..].find("```").expect("its end");
    let arch = read("FORMAT.md", &reference[start..start + length]);
    assert_eq!(arch.srp.fus.len(), 4);
}

#[test]
fn standard_arrays_are_machines() {
    use srp_archdesc::xml::{ArrayTopology, StandardArray, standard};
    let plain = StandardArray::mesh(4, 4);
    let text = standard(&plain).expect("a mesh there is");
    let mesh = read("mesh", &text);
    assert_eq!(xml::parse("again", &xml::write(&mesh)), Ok(mesh.clone()));
    assert_eq!((mesh.srp.fus.len(), mesh.srp.links.len()), (16, 48));
    assert!(mesh.srp.slots().is_empty());
    // One output, its own registers, every scalar operation in one cycle.
    let graph = ResourceGraph::of(&mesh.srp);
    assert_eq!(graph.places.len(), 32);
    for unit in mesh.srp.fus.values() {
        assert!(
            unit.ops
                .iter()
                .all(|op| (op.latency, op.interval) == (1, 1))
        );
        assert!(unit.runs(Opcode::Fma).is_some() && unit.runs(Opcode::Gsw).is_some());
    }
    let links = |topology| {
        let text = standard(&StandardArray {
            topology,
            ..plain.clone()
        });
        read("mesh", &text.expect("it is one")).srp.links.len()
    };
    assert_eq!(links(ArrayTopology::Diagonal), 48 + 2 * 2 * 9);
    assert_eq!(links(ArrayTopology::Torus), 64);
    assert_eq!(links(ArrayTopology::OneHop), 48 + 2 * 2 * 8);
    let wires = |wires: &str| {
        let text = standard(&StandardArray {
            wires: wires.to_owned(),
            ..plain.clone()
        });
        let arch = read("mesh", &text.expect("it is one"));
        (arch.name.clone(), arch.srp.wires.len())
    };
    assert_eq!(wires("mesh"), ("mesh_4x4_r8_mesh".to_owned(), 48));
    let buses = "mesh_4x4_r8_row_column2_array4".to_owned();
    assert_eq!(wires("row column:2 array:4"), (buses, 4 + 8 + 4));
    let memory = standard(&StandardArray {
        memory_columns: Some(1),
        registers: 0,
        latency: 2,
        ..plain.clone()
    });
    let memory = read("mesh", &memory.expect("it is one"));
    assert!(memory.srp.files.is_empty());
    for unit in memory.srp.fus.values() {
        assert_eq!(unit.runs(Opcode::Lw).is_some(), unit.col == 0);
        assert_eq!(unit.runs(Opcode::Add).map(|op| op.latency), Some(2));
    }
    let refused = [
        StandardArray {
            rows: 0,
            ..plain.clone()
        },
        StandardArray {
            cols: 65,
            ..plain.clone()
        },
        StandardArray {
            memory_columns: Some(5),
            ..plain.clone()
        },
        StandardArray {
            classes: Vec::new(),
            ..plain.clone()
        },
        StandardArray {
            wires: "rows".to_owned(),
            ..plain.clone()
        },
        StandardArray {
            wires: "row:65".to_owned(),
            ..plain.clone()
        },
        StandardArray {
            classes: vec![srp_archdesc::Class::Branch],
            ..plain
        },
    ];
    assert!(refused.iter().all(|array| standard(array).is_err()));
}
