//! Random machine files.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;
use std::fmt::Write;

/// A number below `n`.
pub(crate) fn below(random: &mut Pcg64, n: u32) -> u32 {
    (random.next_u64() >> 32) as u32 % n
}

/// One of these.
pub(crate) fn one_of<T: Copy>(random: &mut Pcg64, choices: &[T]) -> T {
    choices[below(random, choices.len() as u32) as usize]
}

/// Random switches and buses: attributes of an array, and elements in it.
pub(crate) struct Wires {
    attributes: String,
    elements: &'static str,
    /// True if they lead everywhere without links.
    alone: bool,
}

impl Wires {
    /// None.
    pub(crate) fn none() -> Wires {
        Wires {
            attributes: String::new(),
            elements: "",
            alone: false,
        }
    }

    pub(crate) fn random(random: &mut Pcg64) -> Wires {
        let kinds = ["", "mesh", "torus:2", "row column", "array:2", "mesh row"];
        let kind = one_of(random, &kinds);
        let (hops, delay) = (1 + below(random, 4), u32::from(below(random, 6) == 0));
        let width = one_of(random, &[128, 128, 32]);
        let elements = match below(random, 3) {
            0 => {
                "    <wire name=\"late\" from=\"fu_0_0 on\" to=\"fu_0_1\" delay=\"2\"/>\n\
                 \u{20}   <wire name=\"on\" from=\"late all\" to=\"fu_1_0 fu_1_1\" width=\"32\"/>\n\
                 \u{20}   <wire name=\"predicates\" from=\"all\" to=\"all\" width=\"1\"/>\n"
            }
            _ => "",
        };
        Wires {
            attributes: format!(
                " wires=\"{kind}\" hops=\"{hops}\" wire-delay=\"{delay}\" wire-width=\"{width}\""
            ),
            elements,
            alone: !kind.is_empty() && width == 128 && below(random, 2) == 0,
        }
    }
}

/// A machine with random arrays, links, units, latencies and files, on which everything can run.
pub(crate) fn random(random: &mut Pcg64, wires: &Wires) -> String {
    let mut xml = String::from("<machine name=\"random\">\n");
    let ports = 1 + below(random, 4);
    let mut line = |text: std::fmt::Arguments<'_>| {
        writeln!(xml, "{text}").expect("writing to a string cannot fail");
    };
    line(format_args!(
        "  <resource name=\"sram_port\" count=\"{ports}\"/>"
    ));
    line(format_args!(
        "  <resource name=\"cache_port\" count=\"1\"/>"
    ));
    let classes = [
        "alu", "imul", "idiv", "pred", "fadd", "fmul", "fma", "fdiv", "sfu", "fast", "cvt", "lane",
        "valu", "vmul", "vfadd", "vfmul", "vfma", "vdot", "pair", "vpair", "load", "store",
        "cload", "cstore", "io", "branch",
    ];
    for class in classes {
        let latency = match class {
            "store" | "cstore" | "io" | "branch" => 1,
            "alu" | "pred" | "lane" => 1 + below(random, 2),
            _ => 1 + below(random, 7),
        };
        let interval = if below(random, 8) == 0 {
            latency.min(2)
        } else {
            1
        };
        let uses = match class {
            "load" | "store" => " uses=\"sram_port\"",
            "cload" | "cstore" => " uses=\"cache_port\"",
            _ => "",
        };
        line(format_args!(
            "  <op class=\"{class}\" latency=\"{latency}\" interval=\"{interval}\"{uses}/>"
        ));
    }
    let kind = one_of(random, &["rotating", "rotating", "static"]);
    let size = one_of(random, &[4, 8, 16]);
    let from_links = one_of(random, &["true", "false"]);
    let (reads, writes) = (1 + below(random, 3), 1 + below(random, 2));
    let all = "alu imul idiv pred fadd fmul fma fdiv sfu fast cvt lane valu vmul vfadd vfmul vfma vdot pair \
               vpair load store cload cstore io branch";
    let some = "alu imul pred fadd fmul lane valu vfadd vfmul load store cvt";
    let scalar = "alu imul pred fadd fmul cvt";
    for (name, width, classes) in [
        ("all", 128, all),
        ("some", 128, some),
        ("scalar", 32, scalar),
    ] {
        line(format_args!(
            "  <fu-type name=\"{name}\" width=\"{width}\" classes=\"{classes}\">"
        ));
        line(format_args!(
            "    <file name=\"r\" kind=\"{kind}\" size=\"{size}\" read-ports=\"{reads}\" \
             write-ports=\"{writes}\" from-links=\"{from_links}\"/>"
        ));
        line(format_args!(
            "    <file name=\"s\" kind=\"static\" size=\"16\" read-ports=\"3\" write-ports=\"1\"/>"
        ));
        line(format_args!("  </fu-type>"));
    }
    for function in ["rcp_fast", "rsqrt_fast", "sqrt_fast", "div_fast"] {
        let bits = 6 + below(random, 8);
        line(format_args!(
            "  <special function=\"{function}\" bits=\"{bits}\"/>"
        ));
    }
    for function in ["rcp", "rsqrt", "sqrt", "div"] {
        let (bits, steps) = (4 + below(random, 20), below(random, 4));
        let fused = one_of(random, &["true", "false"]);
        // The loops are in the form after the passes, for which code has its steps already.
        let refine = match function {
            "rcp" => one_of(random, &["unit", "code"]),
            _ => "unit",
        };
        if below(random, 2) == 0 {
            line(format_args!(
                "  <special function=\"{function}\" bits=\"{bits}\" steps=\"{steps}\" \
                 fused=\"{fused}\" refine=\"{refine}\"/>"
            ));
        }
    }
    let subnormals = one_of(random, &["keep", "keep", "flush"]);
    line(format_args!("  <float subnormals=\"{subnormals}\"/>"));
    let (rows, cols) = (2 + below(random, 3), 2 + below(random, 3));
    let topology = one_of(random, &["mesh", "mesh-diagonal", "torus", "one-hop"]);
    let topology = if wires.alone { "none" } else { topology };
    let delay = u32::from(below(random, 6) == 0);
    line(format_args!(
        "  <array rows=\"{rows}\" cols=\"{cols}\" topology=\"{topology}\" link-delay=\"{delay}\"{} \
         contexts=\"256\">",
        wires.attributes
    ));
    line(format_args!("    <row units=\"all some\"/>"));
    for _ in 1..rows {
        let (a, b) = (
            one_of(random, &["some", "all"]),
            one_of(random, &["scalar", "some"]),
        );
        line(format_args!("    <row units=\"{a} {b}\"/>"));
    }
    line(format_args!(
        "    <file name=\"word\" kind=\"central\" width=\"32\" size=\"64\"/>"
    ));
    line(format_args!(
        "    <file name=\"vec\" kind=\"central\" width=\"128\" size=\"32\"/>"
    ));
    line(format_args!(
        "    <file name=\"pred\" kind=\"central\" width=\"1\" size=\"16\"/>"
    ));
    line(format_args!("{}  </array>", wires.elements));
    let delay = below(random, 3);
    line(format_args!(
        "  <vliw slots=\"2\" branch-delay=\"{delay}\" mode-switch=\"2\" preload-width=\"4\"/>"
    ));
    line(format_args!("</machine>"));
    xml
}
