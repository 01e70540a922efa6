//! Operators and latencies of a T&I unit: those of the paper, and those that follow from operators.

use srp_archdesc::arch::Approx;
use srp_archdesc::datapath::{
    BOX_TEST, FpLatency, Intersection, Latencies, RCP_LATENCY, SYNTHESIS_65NM, box_depth,
};
use srp_archdesc::machines::SGRT;
use srp_archdesc::{parse, xml};

#[test]
fn operators_are_those_of_the_papers_table_1() {
    let trv = BOX_TEST.times(4);
    assert_eq!((trv.add, trv.mul, trv.cmp), (24, 24, 44));
    let ist = Intersection::Wald.operations(Approx::Exact);
    assert_eq!((ist.add, ist.mul, ist.rcp, ist.cmp), (12, 10, 1, 5));
}

#[test]
fn the_shipped_machine_has_the_calibrated_latencies() {
    let arch = parse(SGRT.name, SGRT.xml).expect("the shipped machine is valid");
    let mut tni = arch.system.tni;
    Latencies::Synthesis65nm.apply(&mut tni);
    assert_eq!(
        (tni.pre_latency, tni.aabb_latency, tni.post_latency),
        (1, 8, 2)
    );
    Latencies::Calibrated.apply(&mut tni);
    assert_eq!(tni, arch.system.tni);
    let asked = SGRT.xml.replace(
        "latencies=\"calibrated\"",
        "latencies=\"65nm\" aabb-latency=\"9\"",
    );
    let asked = parse(SGRT.name, &asked).expect("valid too").system.tni;
    assert_eq!(
        (asked.pre_latency, asked.aabb_latency, asked.post_latency),
        (1, 9, 2)
    );
    assert_eq!(
        asked.ist_latency,
        Intersection::AnchorWaldScaled.depth(Approx::Exact, SYNTHESIS_65NM)
    );
}

#[test]
fn latencies_follow_from_operators_unless_given() {
    let unit = |change: &[(&str, &str)]| {
        let mut xml = SGRT.xml.replace("latencies=\"calibrated\"", "");
        for (from, to) in change {
            assert!(xml.contains(from), "{from}");
            xml = xml.replace(from, to);
        }
        let arch = parse(SGRT.name, &xml).expect("a machine");
        let again = xml::write(&arch);
        assert_eq!(parse(SGRT.name, &again), Ok(arch.clone()));
        let tni = arch.system.tni;
        [
            tni.pre_latency,
            tni.aabb_latency,
            tni.post_latency,
            tni.ist_latency,
        ]
    };
    // At 1 GHz operators are SimTRaX's, and so is the unit, but for stacks of 8 KiB in more than one cycle.
    let fast = ("tni-mhz=\"500\"", "tni-mhz=\"1000\"");
    let at_1000 = FpLatency::at(1000, RCP_LATENCY);
    assert_eq!(at_1000, SYNTHESIS_65NM);
    let anchor = Intersection::AnchorWaldScaled;
    let ist = anchor.depth(Approx::Exact, SYNTHESIS_65NM);
    assert_eq!(unit(&[fast]), [1, 8, 3, ist]);
    // At half the clock an operator takes one.
    assert_eq!(unit(&[]), [1, 6, 2, 1 + 2 + 16 + 6 + 1]);
    // A unit's reciprocal, its test, and its operators count.
    let exact = "<special function=\"rcp\" bits=\"exact\"/>\n    </tni>";
    let coarse = (exact, "<special function=\"rcp\" bits=\"8\"/></tni>");
    assert!(unit(&[coarse])[3] < unit(&[])[3]);
    let wald = ("\"anchor-wald-scaled\"", "\"wald\"");
    assert_ne!(unit(&[fast, wald])[3], unit(&[fast])[3]);
    let fp = "<fp add=\"5\" mul=\"5\" cmp=\"2\" rcp=\"16\"/></tni>";
    assert_eq!(unit(&[("</tni>", fp)])[1], 18);
    let set = ("<tni ", "<tni aabb-latency=\"9\" ");
    assert_eq!(unit(&[set]), [1, 9, 2, unit(&[])[3]]);
}

#[test]
fn depths_follow_from_latencies() {
    let table = Approx::table(12, 1);
    assert_eq!(box_depth(SYNTHESIS_65NM), 8);
    assert_eq!(Intersection::Wald.depth(table, SYNTHESIS_65NM), 37);
    assert_eq!(Intersection::Wald.depth(Approx::Exact, SYNTHESIS_65NM), 35);
    assert_eq!(Intersection::AnchorWald.depth(table, SYNTHESIS_65NM), 35);
    assert_eq!(
        Intersection::AnchorWaldScaled.depth(table, SYNTHESIS_65NM),
        38
    );
    assert_eq!(Intersection::Woop.depth(table, SYNTHESIS_65NM), 35);
    assert_eq!(Intersection::WoopWide.depth(table, SYNTHESIS_65NM), 41);
}
