//! [`check`] and the token of its success, [`Checked`].

use super::sequence::Stretch;
use super::{Violation, check_control, check_kernels, check_sequence};
use crate::dre::scheduled::ScheduledDre;
use crate::program::Program;
use srp_archdesc::arch::Arch;
use std::fmt;
use std::ops::Deref;

/// A scheduled program that keeps all rules, and the machine on which it does.
///
/// Only [`check`] and [`check_against`] make one, and nobody can change it afterwards. So later
/// stages need not check again that everything the program names exists and fits. It keeps the
/// machine, since the same program may break rules on another one.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    program: ScheduledDre,
    arch: Arch,
}

impl Checked {
    /// The machine on which the program keeps the rules.
    pub fn arch(&self) -> &Arch {
        &self.arch
    }

    /// The program, to be changed.
    pub fn into_inner(self) -> ScheduledDre {
        self.program
    }
}

impl Deref for Checked {
    type Target = ScheduledDre;

    fn deref(&self) -> &ScheduledDre {
        &self.program
    }
}

/// A scheduled program that breaks rules. As text, it is an indented line for each of the first
/// violations, with their places in the source and in the program.
#[derive(Clone, Debug, PartialEq)]
pub struct Refused {
    /// The program.
    pub program: Box<ScheduledDre>,
    /// The rules that it breaks; at least one.
    pub violations: Vec<Violation>,
}

/// Most violations that [`Refused`] shows.
const MOST_LINES: usize = 20;

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = self.violations.iter().take(MOST_LINES);
        let mut lines: Vec<String> = shown.map(|v| v.describe(&self.program)).collect();
        let more = self.violations.len().saturating_sub(MOST_LINES);
        lines.extend((more > 0).then(|| format!("and {more} more")));
        let lines: Vec<String> = lines.into_iter().map(|line| format!("  {line}")).collect();
        f.write_str(&lines.join("\n"))
    }
}

impl std::error::Error for Refused {}

/// Checks that a program keeps all rules on a machine.
///
/// # Errors
///
/// The program, and the rules that it breaks.
pub fn check(program: ScheduledDre, arch: &Arch) -> Result<Checked, Refused> {
    checked(program, None, arch)
}

/// The same, and that the bundles do the operations of `sequence`, which come from `control`.
///
/// # Errors
///
/// The program, and the rules that it breaks.
pub fn check_against(
    program: ScheduledDre,
    sequence: &[Stretch],
    control: &Program,
    arch: &Arch,
) -> Result<Checked, Refused> {
    checked(program, Some((sequence, control)), arch)
}

fn checked(
    program: ScheduledDre,
    sequence: Option<(&[Stretch], &Program)>,
    arch: &Arch,
) -> Result<Checked, Refused> {
    let mut violations = check_control(&program, arch);
    violations.extend(check_kernels(&program, &arch.srp));
    // The sequence is followed only through bundles that can be understood.
    if let (true, Some((sequence, control))) = (violations.is_empty(), sequence) {
        violations = check_sequence(&program, sequence, control, &arch.srp);
    }
    if violations.is_empty() {
        let arch = arch.clone();
        Ok(Checked { program, arch })
    } else {
        let program = Box::new(program);
        Err(Refused {
            program,
            violations,
        })
    }
}
