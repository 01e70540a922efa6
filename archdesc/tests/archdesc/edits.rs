//! Settings of attributes: what is set is what the parser reads, and what is not there is refused.

use srp_archdesc::xml::{self, AttributePath, EditError};
use srp_archdesc::{Arch, machines};

fn set(path: &str, value: &str) -> Result<String, EditError> {
    let text = machines::ALL[0].xml;
    path.parse::<AttributePath>()?.set(text, value)
}

#[test]
fn what_is_set_is_what_the_parser_reads() {
    let read = |path: &str, value: &str| {
        let text = set(path, value).unwrap_or_else(|e| panic!("{e}"));
        xml::parse("a", &text).unwrap_or_else(|e| panic!("{path}: {e:?}"))
    };
    assert_eq!(read("array.rows", "6").srp.rows, 6);
    assert_eq!(read("machine/array.cols", "5").srp.cols, 5);
    assert_eq!(read("array.contexts", "64").srp.contexts, 64);
    let with_table = read("special[function=rcp].bits", "9");
    assert_ne!(with_table.precision, read("array.rows", "4").precision);
    let flushing = read("float.subnormals", "flush");
    assert_ne!(flushing.precision, read("array.rows", "4").precision);
    let small = read("fu-type[*]/file[name=r].size", "8");
    let sizes = |arch: &Arch| -> u32 { arch.srp.files.values().map(|f| f.size).sum() };
    assert!(sizes(&small) < sizes(&read("array.rows", "4")));
    let slow = read("op[class=fadd].latency", "5");
    assert_ne!(slow.srp.fus, read("array.rows", "4").srp.fus);
}

#[test]
fn values_and_elements_go_where_they_are_read() {
    let xml = "<machine name='m'>\n  <array rows='4'></array>\n  <system cores=\"2\" />\n  \
               <!-- </machine> -->\n</machine>";
    let set = |path: &str, value: &str| {
        let path: AttributePath = path.parse().expect("it is a path");
        path.set(xml, value).expect("it can be set")
    };
    let quoted = set("array.rows", "5' hops='2");
    assert!(quoted.contains("rows='5&apos; hops=&apos;2'"), "{quoted}");
    let inside = set("system/sram.size", "64K");
    let added = "<system cores=\"2\" ><sram size=\"64K\"/></system>";
    assert!(inside.contains(added), "{inside}");
    let linked = set("link[from=fu_0_0].delay", "1");
    let added = "<array rows='4'><link from=\"fu_0_0\" delay=\"1\"/></array>";
    assert!(linked.contains(added), "{linked}");
    let last = set("float.subnormals", "flush");
    let end = "<!-- </machine> -->\n<float subnormals=\"flush\"/>\n</machine>";
    assert!(last.ends_with(end), "{last}");
}

#[test]
fn what_is_not_there_is_refused_with_a_hint() {
    let words = |path: &str| set(path, "1").expect_err("it is wrong").to_string();
    assert!(words("aray.rows").contains("did you mean `array`?"));
    assert!(
        words("op.latency").contains("[class=alu]"),
        "{}",
        words("op.latency")
    );
    assert!(words("resource[name=sram_ports].count").contains("`<resource>`"));
    assert!(words("rows").contains("no path"));
    assert!(words("array/.rows").contains("no path"));
    assert!(words("op[class=none]/x.y").contains("no `<x>`"));
    let of_tni = set("tni/special[function=rcp].bits", "9").expect("it is there");
    let of_srp = set("special[function=rcp].bits", "9").expect("it is added");
    assert!(of_tni.contains(r#"<special function="rcp" bits="9"/>"#) && of_tni != of_srp);
}
