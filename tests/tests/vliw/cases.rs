//! Programs by hand: each says in its first lines how it ends.

use super::engine::End;
use super::{compare_program, machines, strange_machine};
use std::path::Path;

#[test]
fn programs_end_as_they_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vliw/cases");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .expect("the folder of cases")
        .map(|entry| entry.expect("a case").path())
        .collect();
    files.sort();
    assert!(!files.is_empty());
    let strange = (0..40).map(strange_machine);
    let arches: Vec<_> = machines().into_iter().chain(strange).collect();
    for path in files {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(&path).expect("a case is text");
        let program = srp_ir::text::read(&text).unwrap_or_else(|e| panic!("{name}:{e}"));
        assert_eq!(srp_ir::verify(&program), Ok(()), "{name}");
        for arch in &arches {
            let said = match compare_program(&name, &program, arch) {
                End::Halted(status) => format!("// Returns {status}.\n"),
                End::Trap(kind, _) => format!("// Traps: {kind}.\n"),
            };
            assert!(text.contains(&said), "{name} on {}: {said}", arch.name);
        }
    }
}
