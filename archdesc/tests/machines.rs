//! The shipped machines: what they are, that they grow, and that their expanded form is the same
//! machine.

use srp_archdesc::diagnostic::render_all;
use srp_archdesc::machines::{ALL, Machine, SGRT};
use srp_archdesc::{Arch, parse, xml};

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

#[test]
fn expanded_form_is_the_same_machine() {
    for m in ALL {
        let arch = machine(m);
        let expanded = xml::write(&arch);
        let again = read("expanded", &expanded);
        assert_eq!(again, arch, "{}", m.name);
        assert_eq!(xml::write(&again), expanded, "{}", m.name);
    }
}

#[test]
fn default_machine_has_the_papers_peak() {
    let arch = machine(SGRT);
    let gflops = arch.peak_flops_per_cycle() * f64::from(arch.system.srp_mhz) / 1000.0;
    assert_eq!(gflops, 72.5);
}
