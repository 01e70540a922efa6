//! Output of the tools: the generated text of a small program, and the linker's error.

use crate::build::*;
use crate::kernels;
use srp_csimgen::{emit, link};

/// The text of a program with one kernel. `BLESS=1` writes the expectation anew.
#[test]
fn generated_text() {
    let code = kernels::launching(kernels::doubling(), &[5, 508], &[]);
    let (program, _) = combine([&code]);
    let spec = link(&checked(program, &tiny())).unwrap_or_else(|error| panic!("{error}"));
    let source = emit(&spec);
    assert_eq!(source, emit(&spec));
    let mut found = String::new();
    for name in ["state.rs", "control.rs", "k0_double.rs"] {
        found += &format!("// {name}\n{}\n", source.files[name]);
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/engines/double.golden");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(path, &found).expect("the golden file can be written");
    }
    let expected = std::fs::read_to_string(path).expect("the golden file");
    assert!(found == expected, "BLESS=1 and look at the difference");
}

/// Simulators keep a bit for each iteration under way.
#[test]
fn as_many_stages_as_there_is_room_for() {
    let with_length = |length| {
        let mut kernel = kernels::doubling();
        kernel.length = length;
        let (program, _) = combine([&kernels::launching(kernel, &[5, 508], &[])]);
        link(&checked(program, &tiny()))
    };
    assert!(with_length(3 * 64).is_ok());
    let error = with_length(3 * 64 + 1).expect_err("there is no room for 65");
    assert_eq!(
        error.to_string(),
        "case.c:99:1: 65 iterations of kernel `double` overlap; simulators have room for 64"
    );
}
