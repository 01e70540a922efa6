//! The loops of `kernels/micro`: each becomes a kernel, and its program has the same output and exit
//! status from the host's compiler and from the intermediate form, whole and divided.

use srp_ir::split;
use srp_tests::{
    compiled, equal, failures, has_host_compiler, interpreted, machine, meaning, on_host,
};
use std::path::Path;

#[test]
fn loops_mean_the_same_to_the_host() {
    if !has_host_compiler() {
        eprintln!("skipped: there is no C compiler `cc`");
        return;
    }
    let arch = machine("sgrt");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let binary = folder.join(format!("micro-{}", std::process::id()));
    let failures = failures(|suite| {
        if !suite.runs_alone {
            return Ok(());
        }
        let expected = on_host(&suite.sources, &binary)?;
        equal("the intermediate form", &meaning(suite, &arch)?, &expected)
    });
    let _ = std::fs::remove_file(binary);
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn every_loop_becomes_a_kernel() {
    let arch = machine("sgrt");
    let mut loops = 0;
    let failures = failures(|suite| {
        let divided = split::split(&compiled(&suite.sources, &arch)?);
        let text = |path| std::fs::read_to_string(path).map_err(|e| e.to_string());
        let texts = suite
            .sources
            .iter()
            .map(text)
            .collect::<Result<Vec<_>, _>>()?;
        let pragmas = texts
            .iter()
            .map(|text| text.matches("#pragma srp kernel").count());
        let asked: usize = pragmas.sum();
        loops += asked;
        let made = divided.dre.kernels.len();
        // Which kernels the frame has is a matter of the effects that it is built for.
        let asked = if suite.runs_alone { asked } else { 1 };
        if made < asked || !divided.not_pipelined.is_empty() {
            let reasons = divided.not_pipelined.iter();
            let reasons: Vec<_> = reasons
                .map(|n| format!("{}: {}", n.name, n.reason))
                .collect();
            return Err(format!("{made} kernels of {asked}: {}", reasons.join(", ")));
        }
        if !suite.runs_alone {
            return Ok(());
        }
        let found = interpreted(&divided.dre, &arch)?;
        equal("divided", &found, &meaning(suite, &arch)?)
    });
    assert!(failures.is_empty(), "{failures}");
    assert!(loops > 100, "{loops} loops");
}
