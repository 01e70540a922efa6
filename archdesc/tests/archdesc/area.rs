//! Area of a T&I unit: the paper's, and what tests and caches add.

use srp_archdesc::area::{area, cache_area, cache_energy};
use srp_archdesc::datapath::Intersection;
use srp_archdesc::machines::SGRT;
use srp_archdesc::parse;
use srp_archdesc::system::{Pipeline, SystemSpec};

fn machine() -> SystemSpec {
    let arch = parse(SGRT.name, SGRT.xml).expect("the shipped machine is valid");
    arch.system
}

#[test]
fn the_papers_machine_has_about_the_papers_area() {
    let mut system = machine();
    system.tni.intersection = Intersection::Wald;
    let parallel = area(&system.tni, &system.buffers, 500);
    let sum = parallel.trv.operations.plus(parallel.ist.operations);
    assert_eq!((sum.add, sum.mul, sum.rcp, sum.cmp), (36, 34, 1, 49));
    assert!(
        (parallel.total / 3.32 - 1.0).abs() < 0.03,
        "{}",
        parallel.total
    );
    system.tni.pipeline = Pipeline::Single;
    let single = area(&system.tni, &system.buffers, 500);
    assert!(single.total < parallel.total);
    assert!((single.total / 3.28 - 1.0).abs() < 0.03, "{}", single.total);
}

#[test]
fn caches_lie_on_a_curve_through_the_known_sizes() {
    assert!((cache_area(16 << 10) - 0.06).abs() < 1e-12);
    assert!((cache_area(128 << 10) - 0.64).abs() < 1e-12);
    assert!(cache_area(64 << 10) > cache_area(32 << 10));
    assert_eq!(cache_energy(16 << 10), 0.126_381);
    let between = cache_energy(24 << 10);
    assert!(between > 0.1264 && between < 0.1682);
}

#[test]
fn costlier_tests_take_more() {
    let of = |test: Intersection| {
        let mut system = machine();
        system.tni.intersection = test;
        area(&system.tni, &system.buffers, 500).total
    };
    let [wald, anchor, scaled, woop, wide] = Intersection::ALL.map(of);
    assert_eq!(wald, anchor);
    assert!(scaled > anchor && woop > scaled && wide > woop);
}
