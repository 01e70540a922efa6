//! Remarks on functions of math.h that `-fapprox-func` lets be what the special-function unit gives. The library is
//! compiled otherwise then, so no pass knows of it: the calls of the program are looked at before the passes.

use srp_archdesc::arch::{Approx, Arch};
use srp_frontend::library;
use srp_ir::pass::{APPROXIMATE, Remark};
use srp_ir::program::{Callee, Func, InstKind, Program};
use std::collections::{BTreeMap, BTreeSet};

/// A function of the library that the permission changes.
struct Change {
    /// Its name.
    name: &'static str,
    /// How it is computed instead.
    now: &'static str,
    /// True if it is the same on a machine.
    same: fn(&Arch) -> bool,
}

/// Those that `__SRP_APPROX_FUNC` stands in, in `kernels/libc/math.c`.
const CHANGES: &[Change] = &[
    Change {
        name: "fmodf",
        now: "x - floor(x / y) y in binary32, for quotients that a float holds",
        same: |_| false,
    },
    Change {
        name: "sqrtf",
        now: "the root of the special-function unit",
        same: |arch| arch.precision.sqrt == Approx::Exact,
    },
    Change {
        name: "exp2f",
        now: "the unit's 2^x",
        same: |arch| arch.precision.exp2 == Approx::Exact,
    },
    Change {
        name: "expf",
        now: "the unit's 2^(x log2 e), whose exponent is rounded",
        same: |_| false,
    },
    Change {
        name: "logarithm",
        now: "the unit's log2 x, times a constant",
        same: |arch| arch.precision.log2 == Approx::Exact,
    },
    Change {
        name: "powf",
        now: "the unit's 2^(y log2 x), whose exponent is rounded",
        same: |_| false,
    },
    Change {
        name: "sinf",
        now: "the unit's sine",
        same: |arch| arch.precision.sincos == Approx::Exact,
    },
    Change {
        name: "cosf",
        now: "the unit's cosine",
        same: |arch| arch.precision.sincos == Approx::Exact,
    },
];

/// Returns a remark for every call by the program of a function that is changed, or that computes by one.
pub(crate) fn remarks(program: &Program, arch: &Arch) -> Vec<Remark> {
    let calls: BTreeMap<Func, Vec<Func>> = (program.funcs.keys())
        .map(|func| (func, callees(program, func)))
        .collect();
    let mut remarks = Vec::new();
    for func in program.funcs.keys().filter(|&f| !is_library(program, f)) {
        let function = &program.funcs[func];
        for &inst in function
            .layout
            .iter()
            .flat_map(|&b| &function.blocks[b].insts)
        {
            let data = &function.insts[inst];
            let InstKind::Call {
                callee: Callee::Func(callee),
                ..
            } = data.kind
            else {
                continue;
            };
            if is_library(program, callee)
                && let Some((by, change)) = change(program, arch, &calls, callee)
            {
                let name = &program.funcs[callee].name;
                let message = match by == callee || change.name == "logarithm" {
                    true => format!("`{name}` is {}", change.now),
                    false => format!(
                        "`{name}` computes by `{}`, which is {}",
                        change.name, change.now
                    ),
                };
                remarks.push(Remark {
                    pos: data.pos,
                    pass: APPROXIMATE,
                    message,
                });
            }
        }
    }
    remarks
}

/// The first function on the way of a call that is changed.
fn change(
    program: &Program,
    arch: &Arch,
    calls: &BTreeMap<Func, Vec<Func>>,
    callee: Func,
) -> Option<(Func, &'static Change)> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![callee]);
    while let Some(func) = open.pop() {
        if !seen.insert(func) || !is_library(program, func) {
            continue;
        }
        // Two functions of a name, one of them static, have a number behind it.
        let name = program.funcs[func].name.split('.').next();
        let found = CHANGES.iter().find(|change| Some(change.name) == name);
        if let Some(change) = found.filter(|change| !(change.same)(arch)) {
            return Some((func, change));
        }
        open.extend(calls[&func].iter().rev());
    }
    None
}

fn callees(program: &Program, func: Func) -> Vec<Func> {
    let insts = program.funcs[func].insts.values();
    let callee = |kind: &InstKind| match kind {
        InstKind::Call {
            callee: Callee::Func(callee),
            ..
        } => Some(*callee),
        _ => None,
    };
    insts.filter_map(|inst| callee(&inst.kind)).collect()
}

/// True if a function stands in a file of the library.
fn is_library(program: &Program, func: Func) -> bool {
    let file = program.files.get(program.funcs[func].pos.file);
    file.is_some_and(|name| library::text(name).is_some())
}
