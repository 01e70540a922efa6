//! Results of passes on the programs in `tests/passes`: the first line of a case names the passes,
//! the file beside it is the expected output. `UPDATE_GOLDENS=1 cargo test` writes it anew.

use crate::passes::{Case, run};
use srp_ir::pass::Remark;
use srp_ir::program::Program;
use srp_ir::text::{read, write};
use srp_ir::verify;
use std::path::Path;

#[test]
fn goldens() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/passes");
    let entries = std::fs::read_dir(&directory).expect("the cases are there");
    let mut cases: Vec<_> = entries
        .map(|e| e.expect("a readable entry").path())
        .collect();
    cases.retain(|path| path.extension().is_some_and(|e| e == "ir"));
    cases.sort();
    let mut wrong = Vec::new();
    for case in &cases {
        let text = std::fs::read_to_string(case).expect("a readable case");
        let output = transform(&text).unwrap_or_else(|e| panic!("{}: {e}", case.display()));
        let golden = case.with_extension("out");
        if std::env::var_os("UPDATE_GOLDENS").is_some() {
            std::fs::write(&golden, &output).expect("a writable golden");
        }
        if std::fs::read_to_string(&golden).unwrap_or_default() != output {
            wrong.push(format!("{}:\n{output}", golden.display()));
        }
    }
    assert!(!cases.is_empty());
    assert!(wrong.is_empty(), "not as expected:\n{}", wrong.join("\n"));
}

/// The program after the passes that its first line names, and their remarks.
fn transform(text: &str) -> Result<String, String> {
    let list = text
        .lines()
        .next()
        .and_then(|line| line.strip_prefix("// "));
    let list = list.ok_or("the first line is // and the passes")?;
    let mut program = read(text).map_err(|e| e.to_string())?;
    let case = Case::new(0, program.clone());
    let mut remarks = Vec::new();
    for name in list.split(", ") {
        remarks.extend(run(&mut program, name)?);
        if let Err(found) = verify(&program) {
            return Err(format!("{name}: {found:?}\n{}", write(&program)));
        }
        case.check(&program, name);
    }
    Ok(show(&program, &remarks))
}

fn show(program: &Program, remarks: &[Remark]) -> String {
    let line = |r: &Remark| {
        format!(
            "// {}: {}: {}\n",
            program.show_pos(r.pos),
            r.pass,
            r.message
        )
    };
    remarks.iter().map(line).collect::<String>() + &write(program)
}
