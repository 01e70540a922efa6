//! Mistakes in machine files: each `tests/errors/NAME.xml` and the exact text shown for it, in
//! `NAME.stderr` there; and machines that are right and not as they seem, in `tests/warnings`. `BLESS=1 cargo test` writes these
//! texts anew.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::{Duration, Instant};

use srp_archdesc::diagnostic::{Diagnostic, render_all};
use srp_archdesc::machines;
use srp_archdesc::parse;
use srp_archdesc::xml;

#[test]
fn every_mistake_is_shown_as_expected() {
    let codes = shown_as_expected("errors", |name, xml| parse(name, xml).expect_err(name));
    assert_eq!(codes, CODES, "a code without a case");
}

#[test]
fn every_warning_is_shown_as_expected() {
    let codes = shown_as_expected("warnings", |name, xml| {
        assert!(parse(name, xml).is_ok(), "{name}");
        xml::warnings(name, xml)
    });
    assert_eq!(
        codes,
        ["A0701", "A0702", "A0703", "A0704"],
        "a code without a case"
    );
    // A function may be as quick as its unit is built, which is no haste of an operator.
    let table = machines::SGRT.xml.replace(
        "<op class=\"sfu\"/>",
        "<op class=\"sfu\" latency=\"2\"/><special function=\"rcp\" bits=\"8\"/>",
    );
    assert_ne!(table, machines::SGRT.xml);
    let table = ("table", table.as_str());
    for (name, xml) in machines::ALL
        .map(|m| (m.name, m.xml))
        .into_iter()
        .chain([table])
    {
        let shown = xml::warnings(name, xml);
        assert!(shown.is_empty(), "{name}: {shown:?}");
        let expanded = xml::write(&parse(name, xml).expect(name));
        let shown = xml::warnings(name, &expanded);
        assert!(shown.is_empty(), "{name}, expanded: {shown:?}");
    }
}

/// The sgrt machine with one text in place of another.
fn edited(from: &str, to: &str) -> String {
    let text = machines::SGRT.xml.replacen(from, to, 1);
    assert_ne!(text, machines::SGRT.xml, "{from}");
    text
}

#[test]
fn what_an_attribute_is_worth_by_itself_is_not_warned_of() {
    for (from, to) in [
        ("stacks=\"16\"", "stacks=\"56\""),
        // Its links have a delay of 0.
        ("topology=\"mesh-diagonal\"", "topology=\"none\""),
        // An exact reciprocal has one recurrence with the roots unless it has a number.
        (
            "<op class=\"alu\"/>",
            "<op class=\"alu\"/><special function=\"rcp\" datapath=\"0\"/>",
        ),
        // A root in code is a product with the inverse root.
        (
            "<op class=\"alu\"/>",
            "<op class=\"alu\"/><special function=\"sqrt\" bits=\"12\" refine=\"code\"/>\
             <special function=\"rsqrt\" bits=\"12\" refine=\"code\"/>",
        ),
        (
            "topology=\"mesh-diagonal\"",
            "topology=\"mesh\" wires=\"mesh\" hops=\"2\" wire-width=\"32\"",
        ),
        (
            "shared=\"true\"/>",
            "shared=\"false\"><timing faw=\"33\" rc=\"35\" ccd=\"3\"/></dram>",
        ),
    ] {
        let shown = xml::warnings("machine", &edited(from, to));
        assert!(shown.is_empty(), "{to}: {shown:?}");
    }
}

/// Compares what is shown for each file of a folder with the text beside it, and returns the codes.
fn shown_as_expected(
    folder: &str,
    messages: impl Fn(&str, &str) -> Vec<Diagnostic>,
) -> Vec<&'static str> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(folder);
    let mut codes = BTreeSet::new();
    let mut wrong = Vec::new();
    for entry in std::fs::read_dir(&directory).expect("the directory of cases") {
        let path = entry.expect("a case").path();
        if path.extension().is_none_or(|e| e != "xml") {
            continue;
        }
        let xml = std::fs::read_to_string(&path).expect("a readable case");
        let name = path.file_name().and_then(|n| n.to_str()).expect("a name");
        let errors = messages(name, &xml);
        codes.extend(errors.iter().map(|e| e.code));
        let shown = render_all(&errors, &xml, false);
        let expected = path.with_extension("stderr");
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(&expected, shown).expect("a writable expectation");
        } else if std::fs::read_to_string(&expected).ok().as_ref() != Some(&shown) {
            wrong.push(format!("{name} shows\n{shown}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    Vec::from_iter(codes)
}

/// Every code that a message about a machine file can have.
const CODES: &[&str] = &[
    "A0101", "A0102", "A0103", "A0104", "A0105", "A0106", "A0107", "A0108", "A0109", "A0201",
    "A0202", "A0203", "A0204", "A0205", "A0206", "A0301", "A0302", "A0303", "A0304", "A0305",
    "A0306", "A0307", "A0401", "A0402", "A0403", "A0404", "A0405", "A0406", "A0407", "A0408",
    "A0409", "A0410", "A0411", "A0412", "A0413", "A0501", "A0502", "A0503", "A0504", "A0505",
    "A0506", "A0507", "A0508", "A0509", "A0601", "A0602", "A0603", "A0604", "A0605", "A0606",
    "A0607", "A0608", "A0609", "A0610", "A0611",
];

/// Pieces that matter to the parser, put into files at random places.
const PIECES: &[&str] = &[
    "<",
    ">",
    "/>",
    "</",
    "\"",
    "'",
    "&",
    "&lt;",
    "=",
    " ",
    "\n",
    "\t",
    "<!--",
    "-->",
    "<![CDATA[",
    "]]>",
    "<?",
    "?>",
    "<!DOCTYPE",
    "0",
    "-1",
    "4294967296",
    "0x",
    "K",
    "65",
    "é",
    "\u{feff}",
    "\0",
    "<fu",
    "<op class=\"alu\"",
    "<file",
    "slots",
    "all",
    "full",
    "none",
    "central",
    "name=\"\"",
];

/// SplitMix64, seeded with a constant: the same mutations in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// `text` with a few pieces deleted, repeated or inserted.
fn mutate(text: &str, random: &mut Random) -> String {
    let mut text = text.to_owned();
    for _ in 0..=random.below(4) {
        let mut at = |limit: usize| text.floor_char_boundary(random.below(limit + 1));
        let from = at(text.len());
        let to = text.floor_char_boundary((from + at(30)).min(text.len()));
        match random.below(4) {
            0 => text.replace_range(from..to.max(from), ""),
            1 => {
                let piece = text[from..to.max(from)].to_owned();
                text.insert_str(from, &piece);
            }
            2 => text.truncate(from.max(text.floor_char_boundary(text.len() / 2))),
            _ => text.insert_str(from, PIECES[random.below(PIECES.len())]),
        }
    }
    text
}

#[test]
fn no_text_makes_the_parser_panic() {
    let mut random = Random(2013);
    let start = Instant::now();
    let (mut machines, mut mistakes) = (0, 0);
    while start.elapsed() < Duration::from_secs(1) {
        for machine in machines::ALL {
            let xml = mutate(machine.xml, &mut random);
            match parse("mutated.xml", &xml) {
                Ok(_) => machines += 1,
                Err(errors) => {
                    assert!(!errors.is_empty());
                    assert!(!render_all(&errors, &xml, false).is_empty());
                    mistakes += errors.len();
                }
            }
        }
    }
    assert!(machines > 0 && mistakes > 0, "{machines} {mistakes}");
}
