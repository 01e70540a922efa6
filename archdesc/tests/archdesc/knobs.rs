//! Whatever a machine file changes of a unit, a file, a link or a memory shows in cycles, area or energy.

use srp_archdesc::Arch;
use srp_archdesc::chip;
use srp_archdesc::isa::Opcode;
use srp_archdesc::machines::SGRT;
use srp_archdesc::parse;
use srp_archdesc::structure::Special;

/// The machine that comes along, with lines put in and words replaced.
fn machine(special: &str, edits: &[(&str, &str)]) -> Arch {
    let mut xml = SGRT
        .xml
        .replace("<array rows", &format!("{special}<array rows"));
    for (from, to) in edits {
        assert!(xml.contains(from), "{from}");
        xml = xml.replace(from, to);
    }
    parse("knobs.xml", &xml).unwrap_or_else(|errors| panic!("{special} {edits:?}: {errors:?}"))
}

fn with(special: &str) -> Arch {
    machine(special, &[])
}

/// Latency and interval of an operation.
fn cycles(arch: &Arch, op: Opcode) -> (u32, u32) {
    let mut how = arch.srp.fus.values().filter_map(|fu| fu.runs(op));
    how.next().map_or((0, 0), |how| (how.latency, how.interval))
}

fn area(arch: &Arch) -> f64 {
    chip::srp(arch).total_mm2
}

fn energy(arch: &Arch, op: Opcode) -> f64 {
    chip::operation_energy(op, arch)
}

#[test]
fn cycles_follow_from_the_structure() {
    let rcp = |attributes: &str| {
        let arch = with(&format!("<special function=\"rcp\" {attributes}/>"));
        cycles(&arch, Opcode::Rcp)
    };
    // Of the class while nothing is said of how.
    assert_eq!(rcp("bits=\"exact\""), (8, 2));
    assert_eq!(rcp("bits=\"8\""), (2, 1));
    assert_eq!(rcp("bits=\"8\" steps=\"1\""), (8, 2));
    assert_eq!(rcp("bits=\"8\" steps=\"2\""), (14, 4));
    assert_eq!(rcp("bits=\"8\" steps=\"2\" refine=\"code\""), (2, 1));
    assert_eq!(rcp("structure=\"newton\" bits=\"8\""), (8, 2));
    // A large table is slow, and two small ones are not.
    assert_eq!(rcp("bits=\"16\""), (4, 1));
    assert_eq!(rcp("structure=\"bipartite\" bits=\"16\"").1, 1);
    assert!(rcp("structure=\"bipartite\" bits=\"16\"").0 < 4);
    assert!(rcp("structure=\"polynomial\" bits=\"23\"").0 <= 4);
    let radix = |r| rcp(&format!("structure=\"srt\" radix=\"{r}\""));
    assert_eq!(
        [radix(2), radix(4), radix(16)],
        [(27, 27), (14, 14), (8, 8)]
    );
    assert_eq!(rcp("structure=\"srt\" unrolled=\"true\" radix=\"2\"").1, 1);
    let cordic = rcp("structure=\"cordic\" bits=\"20\"");
    assert!(cordic.0 > 20 && cordic.1 > 20);
    // What the file gives counts.
    assert_eq!(rcp("bits=\"8\" latency=\"5\""), (5, 1));
    assert_eq!(rcp("bits=\"8\" interval=\"3\""), (2, 3));
    let of_class = [("<op class=\"sfu\"/>", "<op class=\"sfu\" latency=\"9\"/>")];
    let given = |special: &str| cycles(&machine(special, &of_class), Opcode::Rcp);
    assert_eq!(given("<special function=\"rcp\" bits=\"8\"/>"), (9, 1));
    assert_eq!(
        given("<special function=\"rcp\" bits=\"8\" latency=\"4\"/>"),
        (4, 1)
    );
    // Others of the class are as they were, and so is the divider.
    let arch = with("<special function=\"rcp\" bits=\"8\"/>");
    assert_eq!(cycles(&arch, Opcode::Rsqrt), (8, 2));
    assert_eq!(cycles(&arch, Opcode::Fdiv), (12, 4));
    let div = with("<special function=\"div\" structure=\"srt\" radix=\"4\"/>");
    assert_eq!(cycles(&div, Opcode::Fdiv), (14, 14));
}

#[test]
fn fast_units_stand_beside_the_ordinary_ones() {
    let class = ("fdiv sfu cvt", "fdiv sfu fast cvt");
    let of = |bits: u32| {
        let special = format!(
            "<special function=\"rcp_fast\" bits=\"{bits}\"/>\
             <special function=\"div_fast\" structure=\"bipartite\" bits=\"{bits}\"/>"
        );
        machine(&special, &[class])
    };
    let (coarse, fine) = (of(8), of(18));
    assert_eq!(cycles(&coarse, Opcode::RcpFast), (2, 1));
    assert_eq!(cycles(&coarse, Opcode::Rcp), (8, 2));
    assert!(cycles(&fine, Opcode::RcpFast).0 > 2);
    // Functions of the class that the machine does not describe run nowhere.
    assert_eq!(cycles(&coarse, Opcode::SqrtFast), (0, 0));
    assert!(area(&with("")) < area(&coarse) && area(&coarse) < area(&fine));
    assert!(energy(&coarse, Opcode::RcpFast) < energy(&fine, Opcode::RcpFast));
    assert!(energy(&coarse, Opcode::FdivFast) < energy(&coarse, Opcode::Fdiv));
    assert_eq!(energy(&coarse, Opcode::Rcp), energy(&fine, Opcode::Rcp));
    let again = srp_archdesc::xml::write(&coarse);
    assert_eq!(parse("again.xml", &again), Ok(coarse));
    // Without a function the class is a mistake, and so is a function without the class.
    let mistaken = |special: &str, classes: &str| {
        let xml = (SGRT.xml)
            .replace("<array rows", &format!("{special}<array rows"))
            .replace("fdiv sfu cvt", classes);
        let errors = parse("knobs.xml", &xml).expect_err("it is a mistake");
        errors.iter().map(|e| e.code).collect::<Vec<_>>()
    };
    assert_eq!(mistaken("", class.1), ["A0507"]);
    let rcp = "<special function=\"rcp_fast\" bits=\"8\"/>";
    assert_eq!(mistaken(rcp, class.0), ["A0503"]);
    let in_code = "<special function=\"rcp_fast\" bits=\"8\" steps=\"1\" refine=\"code\"/>";
    assert_eq!(mistaken(in_code, class.1), ["A0305"]);
}

#[test]
fn cycles_follow_from_the_clock() {
    let at = |mhz: &str| {
        let edit = format!("srp-mhz=\"{mhz}\"");
        let special = "<special function=\"rsqrt\" structure=\"polynomial\" bits=\"22\"/>";
        cycles(
            &machine(special, &[("srp-mhz=\"1000\"", &edit)]),
            Opcode::Rsqrt,
        )
        .0
    };
    assert!(at("500") < at("1000") && at("1000") < at("2000"));
    // The T&I unit has its own: 16 cycles of 37 are the reciprocal's.
    let ist = |rcp: &str| {
        let exact = "<special function=\"rcp\" bits=\"exact\"/>\n    </tni>";
        let edit = format!("<special function=\"rcp\" {rcp}/></tni>");
        machine("", &[(exact, &edit)]).system.tni.ist_latency
    };
    assert_eq!(ist("bits=\"exact\""), 37);
    assert!(ist("bits=\"8\"") < ist("bits=\"8\" steps=\"1\""));
    assert!(ist("bits=\"8\" steps=\"1\"") < ist("structure=\"srt\" radix=\"2\""));
    assert_eq!(ist("bits=\"8\" latency=\"20\""), 41);
}

#[test]
fn area_and_energy_follow_from_the_structure() {
    let exact = with("");
    let table = |bits: u32| with(&format!("<special function=\"exp2\" bits=\"{bits}\"/>"));
    let (small, large) = (table(8), table(16));
    assert!(area(&small) < area(&exact) && area(&small) < area(&large));
    assert!(energy(&small, Opcode::Exp2) < energy(&large, Opcode::Exp2));
    assert!(energy(&small, Opcode::Exp2) < energy(&exact, Opcode::Exp2));
    assert_eq!(energy(&small, Opcode::Fadd), energy(&exact, Opcode::Fadd));
    // A table of its own costs more than a common datapath's.
    let both = |datapath: &str| {
        let unit = format!("structure=\"polynomial\" bits=\"20\" {datapath}");
        let line = |f: &str| format!("<special function=\"{f}\" {unit}/>");
        area(&with(&(line("exp2") + &line("log2") + &line("sincos"))))
    };
    assert!(both("datapath=\"1\"") < both(""));
    // What the file gives counts.
    let given =
        with("<special function=\"exp2\" bits=\"8\" area-um2=\"1000000\" energy-fj=\"5000\"/>");
    assert_eq!(energy(&given, Opcode::Exp2), 5.0);
    assert!(area(&given) > area(&small) + 1.0);
    assert_eq!(given.special_unit(Special::Exp2).area_um2, 1e6);
}

/// Cycles of every class follow from the clock and the technology, and area and energy from the cycles that the machine has.
#[test]
fn pipelines_follow_from_the_clock() {
    let base = with("");
    let clock = |mhz: &str| {
        let edit = format!("srp-mhz=\"{mhz}\"");
        machine("", &[("srp-mhz=\"1000\"", &edit)])
    };
    let (slow, quick) = (clock("500"), clock("2000"));
    for op in [
        Opcode::Fadd,
        Opcode::Fma,
        Opcode::Mul,
        Opcode::Lw,
        Opcode::Rcp,
        Opcode::Div,
    ] {
        let all = [&slow, &base, &quick].map(|arch| cycles(arch, op).0);
        assert!(all[0] < all[1] && all[1] < all[2], "{op}: {all:?}");
    }
    assert_eq!(cycles(&quick, Opcode::Add).0, 2);
    assert!(area(&slow) < area(&base) && area(&base) < area(&quick));
    // As many rows, each passed as often, at any clock.
    for arch in [&slow, &base, &quick] {
        let intervals = [Opcode::Rcp, Opcode::Div, Opcode::Fdiv].map(|op| cycles(arch, op).1);
        assert_eq!(intervals, [2, 4, 4]);
    }
    // Gates that are twice as quick at twice the clock are the same.
    let shrunk = machine(
        "",
        &[
            ("srp-mhz=\"1000\"", "srp-mhz=\"1000\" fo4-ps=\"50\""),
            ("srp-mhz=\"1000\"", "srp-mhz=\"500\""),
            ("tni-mhz=\"500\"", "tni-mhz=\"250\""),
        ],
    );
    assert_eq!(shrunk.srp, base.srp);
    let of = |class: &str, cycles: &str| {
        let line = format!("<op class=\"{class}\"/>");
        let edit = format!("<op class=\"{class}\" {cycles}/>");
        machine("", &[(&line, &edit)])
    };
    // What is given stays, and costs: registers of a deeper pipeline, haste of a shallower one.
    let deep = of("fadd", "latency=\"9\"");
    assert!(area(&deep) > area(&base));
    assert!(energy(&deep, Opcode::Fadd) > energy(&base, Opcode::Fadd));
    assert_eq!(energy(&deep, Opcode::Vfadd), energy(&base, Opcode::Vfadd));
    let hasty = of("fma", "latency=\"1\"");
    assert!(area(&hasty) > area(&base));
    assert!(energy(&hasty, Opcode::Fma) > energy(&base, Opcode::Fma));
    // The cycle of unpacking is none of the adder's, and the address of a load is a sum.
    assert!(area(&of("fadd", "latency=\"2\"")) > area(&base));
    let load = "<op class=\"load\" uses=\"sram_port\"/>";
    let quick_load = "<op class=\"load\" latency=\"2\" uses=\"sram_port\"/>";
    assert!(area(&machine("", &[(load, quick_load)])) > area(&base));
    // A branch costs its delay and nothing else.
    assert_eq!(area(&of("branch", "latency=\"4\"")), area(&base));
    // An interval makes smaller what is used again.
    for class in ["imul", "sfu", "fdiv", "idiv"] {
        let [often, seldom] = ["interval=\"1\"", "interval=\"6\""].map(|i| area(&of(class, i)));
        assert!(seldom < often, "{class}: {seldom} {often}");
    }
}

#[test]
fn area_follows_from_everything_else() {
    let base = area(&with(""));
    let larger = [
        ("size=\"240K\"", "size=\"480K\""),
        ("<data-cache size=\"4K\"", "<data-cache size=\"16K\""),
        ("<texture-cache size=\"32K\"", "<texture-cache size=\"64K\""),
        (
            "misses=\"4\" blocking=\"true\"",
            "misses=\"4\" blocking=\"false\"",
        ),
        (
            "misses=\"8\" blocking=\"true\"",
            "misses=\"8\" blocking=\"false\"",
        ),
        ("contexts=\"128\"", "contexts=\"256\""),
        (
            "<buffers ",
            "<instruction-cache size=\"4K\"/>\n    <buffers ",
        ),
        ("topology=\"mesh-diagonal\"", "topology=\"full\""),
        ("link-delay=\"0\"", "link-delay=\"1\""),
        (
            "kind=\"rotating\" size=\"16\"",
            "kind=\"rotating\" size=\"32\"",
        ),
        (
            "size=\"16\" read-ports=\"3\"",
            "size=\"16\" read-ports=\"6\"",
        ),
        (
            "kind=\"static\" size=\"8\" read-ports=\"2\" write-ports=\"1\"",
            "kind=\"static\" size=\"8\" read-ports=\"2\" write-ports=\"3\"",
        ),
        ("width=\"32\" size=\"64\"", "width=\"32\" size=\"128\""),
        (
            "classes=\"alu imul pred fadd fmul fma cvt\"",
            "classes=\"alu imul idiv pred fadd fmul fma cvt\"",
        ),
        (
            "<row units=\"vec scalar vec scalar\"/>",
            "<row units=\"vec vec vec scalar\"/>",
        ),
        ("<sram ", "<texture weight-bits=\"12\"/><sram "),
        (
            "kind=\"static\" size=\"8\"",
            "kind=\"static\" from-links=\"true\" size=\"8\"",
        ),
    ];
    for edit in larger {
        let changed = area(&machine("", &[edit]));
        assert!(changed > base, "{edit:?}: {changed} for {base}");
    }
}

/// A unit's result comes after as many cycles as the unit is busy with it, and an array of products saves no more area than
/// there are cycles to pass it.
#[test]
fn a_longer_interval_takes_the_latency_along() {
    let imul = |attributes: &str| {
        let op = format!("<op class=\"imul\" {attributes}/>");
        machine("", &[("<op class=\"imul\"/>", &op)])
    };
    let how = |attributes: &str| cycles(&imul(attributes), Opcode::Mul);
    assert_eq!(how(""), (2, 1));
    assert_eq!(how("interval=\"8\""), (8, 8));
    assert_eq!(how("interval=\"8\" latency=\"3\""), (3, 8));
    let [once, twice, often] = ["1", "2", "8"]
        .map(|interval| area(&imul(&format!("interval=\"{interval}\" latency=\"2\""))));
    assert!(once > twice && twice == often, "{once} {twice} {often}");
}

/// Ports and banks of memories take area, and no more than units that each choose a bank themselves.
#[test]
fn ports_of_memories_take_area() {
    let ports = |edits: &[(&str, &str)], name: &str| {
        let area = chip::srp(&machine("", edits));
        let item = area.items.into_iter().find(|item| item.name == name);
        item.map_or(0.0, |item| item.mm2)
    };
    let sram = |count: &str| {
        let edit = (
            "\"sram_port\" count=\"4\"",
            &*format!("\"sram_port\" count=\"{count}\""),
        );
        ports(&[edit], "ports of the SRAM")
    };
    let areas = ["1", "2", "4", "8", "16", "64"].map(sram);
    assert!(areas.is_sorted() && areas[0] > 0.0, "{areas:?}");
    assert!(areas[0] < areas[1] && areas[1] < areas[2] && areas[2] < areas[3]);
    assert_eq!(
        areas[4], areas[5],
        "units begin no more accesses than there are units"
    );
    let cache = |count: &str| {
        let edit = (
            "\"cache_port\" count=\"1\"",
            &*format!("\"cache_port\" count=\"{count}\""),
        );
        ports(&[edit], "ports of the data cache")
    };
    assert!(cache("1") > 0.0 && cache("1") < cache("2") && cache("2") < cache("4"));
}

/// Ways of caches, and ports of those of the SRP, take area.
#[test]
fn ways_and_ports_of_caches_take_area() {
    let chip = |edits: &[(&str, &str)]| chip::Chip::of(&machine("", edits)).total_mm2;
    let base = chip(&[]);
    for (element, usual) in [
        ("<data-cache size=\"4K\"", 4),
        ("<texture-cache size=\"32K\"", 4),
        ("<trv-l1 size=\"16K\"", 2),
        ("<trv-l2 size=\"128K\"", 2),
        ("<ist-l1 size=\"128K\"", 4),
    ] {
        let ways = |ways: u32| {
            let from = format!("{element} ways=\"{usual}\"");
            chip(&[(&from, &format!("{element} ways=\"{ways}\""))])
        };
        assert_eq!(ways(usual), base, "{element}");
        assert!(
            ways(1) < base && base < ways(8) && ways(8) < ways(32),
            "{element}"
        );
    }
    for port in ["cache_port", "texture_port"] {
        let from = format!("\"{port}\" count=\"1\"");
        let ports = |count: u32| chip(&[(&from, &format!("\"{port}\" count=\"{count}\""))]);
        assert!(base < ports(2) && ports(2) < ports(4), "{port}");
    }
}

/// Latencies of the T&I unit that are shorter than its operators' delays make these larger, and so does its clock.
#[test]
fn haste_of_the_unit_takes_area() {
    let unit = |edits: &[(&str, &str)]| chip::Chip::of(&machine("", edits)).tni_mm2;
    let base = unit(&[]);
    let latency = |attribute: &str| unit(&[("<tni ", &format!("<tni {attribute} "))]);
    assert!(latency("aabb-latency=\"1\"") > base && latency("ist-latency=\"8\"") > base);
    // What fits has fewer registers and no larger operators.
    assert!(latency("aabb-latency=\"6\"") < base && latency("ist-latency=\"26\"") < base);
    let clock = |mhz: &str, latencies: &str| {
        let mhz = format!("tni-mhz=\"{mhz}\"");
        let latencies = ("latencies=\"calibrated\"", latencies);
        unit(&[("tni-mhz=\"500\"", &mhz), latencies])
    };
    let calibrated = ["500", "1000", "2000"].map(|mhz| clock(mhz, "latencies=\"calibrated\""));
    assert!(calibrated[0] == base && calibrated[1] == base && calibrated[2] > base);
    let following = ["500", "1000", "2000"].map(|mhz| clock(mhz, ""));
    assert!(following.is_sorted(), "{following:?}");
    let operators = |fp: &str| {
        let fp = format!("<fp {fp}/>\n      <trv-l1 ");
        let clock = ("tni-mhz=\"500\"", "tni-mhz=\"1000\"");
        unit(&[clock, ("<trv-l1 ", &fp)])
    };
    let natural = operators("add=\"2\" mul=\"2\" cmp=\"1\" rcp=\"16\"");
    for hasty in [
        "add=\"1\" mul=\"2\" cmp=\"1\" rcp=\"16\"",
        "add=\"2\" mul=\"1\" cmp=\"1\" rcp=\"16\"",
        "add=\"2\" mul=\"2\" cmp=\"1\" rcp=\"8\"",
    ] {
        assert!(operators(hasty) > natural, "{hasty}");
    }
}
