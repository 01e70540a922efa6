//! Haste of a T&I unit: none of what fits its cycles, and that of all operators of a latency that is too short.

use srp_archdesc::haste::{Haste, OperatorHaste};
use srp_archdesc::machines::SGRT;
use srp_archdesc::parse;
use srp_archdesc::system::SystemSpec;

fn haste(tni: &str, clock: &str) -> Haste {
    let xml = SGRT.xml.replace("latencies=\"calibrated\"", tni);
    let xml = xml.replace("tni-mhz=\"500\"", clock);
    let arch = parse(SGRT.name, &xml).expect("a machine");
    let system: &SystemSpec = &arch.system;
    Haste::of(&system.tni, system.tni_mhz_at_65nm())
}

#[test]
fn what_fits_has_none() {
    let none = Haste {
        pre: 1.0,
        aabb: OperatorHaste::all(1.0),
        post: 1.0,
        ist: OperatorHaste::all(1.0),
    };
    assert_eq!(haste("latencies=\"calibrated\"", "tni-mhz=\"500\""), none);
    for mhz in [45, 500, 1000, 2000, 2500] {
        assert_eq!(haste("", &format!("tni-mhz=\"{mhz}\"")), none, "{mhz}");
    }
    let synthesis = haste("latencies=\"65nm\"", "tni-mhz=\"1000\"");
    assert!(
        synthesis.aabb.add < 1.05 && synthesis.ist.add < 1.05,
        "{synthesis:?}"
    );
}

#[test]
fn a_short_latency_is_that_of_all_operators() {
    // Sum, product and four comparisons are 153 FO4, of which a cycle of 500 MHz has 72.
    let box_test = haste("aabb-latency=\"1\"", "tni-mhz=\"500\"");
    assert!((box_test.aabb.add - 2.12).abs() < 0.02, "{box_test:?}");
    assert_eq!(box_test.ist, OperatorHaste::all(1.0));
    let triangle = haste("ist-latency=\"8\"", "tni-mhz=\"500\"");
    assert!(
        triangle.ist.rcp > 1.5 && triangle.ist.rcp < 2.0,
        "{triangle:?}"
    );
    let quick = haste("latencies=\"65nm\"", "tni-mhz=\"2000\"");
    assert!(quick.aabb.add > 1.5 && quick.pre > 2.0 && quick.post > 2.0);
}
