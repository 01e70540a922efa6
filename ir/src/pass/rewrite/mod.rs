//! Rewrites of floating-point expressions into others that are equal in real arithmetic: other digits are lost, and
//! other operations are needed. C allows none of them, so each is asked for by its rule and its line, and
//! leaves a [`Remark`].
//!
//! Which of them pays is not judged here: `srp accuracy` tries each place that [`places`](super::places) finds, and has both
//! numbers.

mod compensate;
mod difference;
mod polynomial;
mod power;
mod tree;

use super::{Remark, rename::Renames};
use crate::program::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt;
use tree::{Expressions, Library, Tree};

/// A rule by which expressions are rewritten.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Rule {
    /// A polynomial by pairs of terms and powers of its variable: a short way through many operations.
    Estrin,
    /// A polynomial by one multiplication and one addition a degree: few operations, one after the other.
    Horner,
    /// A power with a constant exponent as products, roots and a quotient.
    Products,
    /// Many products of one factor as exp2 (n · log2 x).
    Exp2Log2,
    /// √a − b as (a − b²) / (√a + b).
    RootDifference,
    /// a² − b² as (a − b) · (a + b).
    SquareDifference,
    /// a/b − c/d over one denominator.
    QuotientDifference,
    /// 1 − cos x as 2 sin² (x/2).
    HalfAngle,
    /// a·b − c·d with the rounding of one product made good by fused multiply-adds (Kahan).
    ProductDifference,
    /// A sum that a loop carries, with the sum of its rounding errors beside it (Kahan, Babuška, Neumaier; by
    /// Knuth's exact sum of two numbers).
    CompensatedSum,
}

impl Rule {
    /// All of them.
    pub const ALL: [Rule; 10] = [
        Rule::Estrin,
        Rule::Horner,
        Rule::Products,
        Rule::Exp2Log2,
        Rule::RootDifference,
        Rule::SquareDifference,
        Rule::QuotientDifference,
        Rule::HalfAngle,
        Rule::ProductDifference,
        Rule::CompensatedSum,
    ];

    /// Its name on command lines.
    pub const fn name(self) -> &'static str {
        match self {
            Rule::Estrin => "estrin",
            Rule::Horner => "horner",
            Rule::Products => "products",
            Rule::Exp2Log2 => "exp2-log2",
            Rule::RootDifference => "root-difference",
            Rule::SquareDifference => "square-difference",
            Rule::QuotientDifference => "quotient-difference",
            Rule::HalfAngle => "half-angle",
            Rule::ProductDifference => "product-difference",
            Rule::CompensatedSum => "compensated-sum",
        }
    }

    /// The forms before and after it.
    pub const fn what(self) -> &'static str {
        match self {
            Rule::Estrin => "a polynomial by pairs of terms (Estrin's scheme)",
            Rule::Horner => "a polynomial by one product and one sum a degree (Horner's scheme)",
            Rule::Products => "a power with a constant exponent as products and roots",
            Rule::Exp2Log2 => "products of one factor as exp2(n * log2(x))",
            Rule::RootDifference => "sqrt(a) - b as (a - b*b) / (sqrt(a) + b)",
            Rule::SquareDifference => "a*a - b*b as (a - b) * (a + b)",
            Rule::QuotientDifference => "a/b - c/d as (a*d - c*b) / (b*d)",
            Rule::HalfAngle => "1 - cos(x) as 2 * sin(x/2) * sin(x/2)",
            Rule::ProductDifference => {
                "a*b - c*d with one product's rounding made good by fused multiply-adds"
            }
            Rule::CompensatedSum => "a loop's sum with the sum of its rounding errors beside it",
        }
    }

    /// The rule of a name.
    pub fn parse(name: &str) -> Option<Rule> {
        Rule::ALL.into_iter().find(|rule| rule.name() == name)
    }

    /// The expression that takes the place of an instruction's result.
    fn plan(self, within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
        match self {
            Rule::Estrin => polynomial::estrin(within, inst),
            Rule::Horner => polynomial::horner(within, inst),
            Rule::Products => power::products(within, inst),
            Rule::Exp2Log2 => power::exp2_log2(within, inst),
            Rule::RootDifference => difference::roots(within, inst),
            Rule::SquareDifference => difference::squares(within, inst),
            Rule::QuotientDifference => difference::quotients(within, inst),
            Rule::HalfAngle => difference::half_angle(within, inst),
            Rule::ProductDifference => difference::products(within, inst),
            Rule::CompensatedSum => None,
        }
    }
}

/// A wish to rewrite what a rule fits on a line.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct Rewrite {
    /// The rule.
    pub rule: Rule,
    /// The end of the file's path, whole names of it; `None` for all files but the library's.
    pub file: Option<String>,
    /// The line, from 1.
    pub line: u32,
}

impl Rewrite {
    /// `RULE@LINE` or `RULE@FILE:LINE`.
    ///
    /// # Errors
    ///
    /// A sentence about what is wrong with it.
    pub fn parse(text: &str) -> Result<Rewrite, String> {
        let (name, place) = text
            .split_once('@')
            .ok_or("RULE@LINE or RULE@FILE:LINE is wanted")?;
        let rule = Rule::parse(name).ok_or_else(|| {
            let names = Rule::ALL.map(Rule::name);
            format!("no rule is named `{name}`; there are {}", names.join(", "))
        })?;
        let (file, line) = match place.rsplit_once(':') {
            Some((file, line)) => (Some(file.to_owned()), line),
            None => (None, place),
        };
        let line = line.parse().ok().filter(|&line| line > 0);
        let line = line.ok_or_else(|| format!("`{place}` does not end in a line's number"))?;
        Ok(Rewrite { rule, file, line })
    }

    /// True of a place on its line.
    pub fn is_at(&self, file: &str, line: u32) -> bool {
        let is_file = match &self.file {
            Some(wanted) => file
                .strip_suffix(wanted.as_str())
                .is_some_and(|rest| rest.is_empty() || rest.ends_with('/')),
            None => !is_library(file),
        };
        is_file && self.line == line
    }
}

impl fmt::Display for Rewrite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) => write!(f, "{}@{file}:{}", self.rule.name(), self.line),
            None => write!(f, "{}@{}", self.rule.name(), self.line),
        }
    }
}

/// True of the files of the C library.
pub(super) fn is_library(file: &str) -> bool {
    file.starts_with("kernels/libc/")
}

/// Rewrites what is asked for. True if anything was.
pub(super) fn rewrite(
    program: &mut Program,
    wishes: &[Rewrite],
    remarks: &mut Vec<Remark>,
) -> bool {
    let before = remarks.len();
    for rule in Rule::ALL {
        let wishes: Vec<&Rewrite> = wishes.iter().filter(|wish| wish.rule == rule).collect();
        if wishes.is_empty() {
            continue;
        }
        let library = Library::of(program);
        let Program { funcs, files, .. } = &mut *program;
        let is_wished = |pos: Pos| {
            let file = files.get(pos.file).map_or("", String::as_str);
            wishes.iter().any(|wish| wish.is_at(file, pos.line))
        };
        for func in funcs.values_mut() {
            let done = match rule {
                Rule::CompensatedSum => compensate::compensate(func, &is_wished),
                _ => replace(func, rule, &library, &is_wished),
            };
            remarks.extend(done.into_iter().map(|pos| Remark {
                pos,
                pass: rule.name(),
                message: rule.what().to_owned(),
            }));
        }
    }
    remarks.len() > before
}

/// The places of a program that some rule fits as it stands, in files that are not the library's.
pub(super) fn fits(program: &Program) -> BTreeSet<Rewrite> {
    let mut found = BTreeSet::new();
    let library = Library::of(program);
    for func in program.funcs.values() {
        let within = Expressions::of(func, &library);
        for rule in Rule::ALL {
            let fits = match rule {
                Rule::CompensatedSum => compensate::places(func),
                _ => {
                    let plans = plans(&within, rule, &|_| true);
                    let insts = plans.into_iter().map(|(_, inst, _)| inst);
                    insts.map(|inst| func.insts[inst].pos).collect()
                }
            };
            found.extend(fits.into_iter().filter_map(|pos| {
                let file = program.files.get(pos.file)?;
                (pos.line > 0 && !is_library(file)).then(|| Rewrite {
                    rule,
                    file: Some(file.clone()),
                    line: pos.line,
                })
            }));
        }
    }
    found
}

/// The instructions of a function with their blocks.
fn listed(func: &Function) -> impl Iterator<Item = (Block, Inst)> {
    let blocks = func.layout.iter();
    blocks.flat_map(|&block| func.blocks[block].insts.iter().map(move |&i| (block, i)))
}

/// The expressions that a rule puts at some places, with the block and the instruction of each.
fn plans(
    within: &Expressions<'_>,
    rule: Rule,
    is_wished: &dyn Fn(Pos) -> bool,
) -> Vec<(Block, Inst, Tree)> {
    let func = within.func;
    let wished = listed(func).filter(|&(_, inst)| is_wished(func.insts[inst].pos));
    let mut plans: Vec<(Block, Inst, Tree)> = wished
        .filter_map(|(block, inst)| Some((block, inst, rule.plan(within, inst)?)))
        .collect();
    // Of an expression and a part of it, which a rule may fit as well, the whole is rewritten.
    let parts: BTreeSet<Inst> = (plans.iter())
        .flat_map(|(_, inst, _)| within.made.below(func, *inst))
        .collect();
    plans.retain(|(_, inst, _)| !parts.contains(inst));
    plans
}

/// Puts what a rule makes in the place of the results at the places that are wished for. Returns them.
fn replace(
    func: &mut Function,
    rule: Rule,
    library: &Library,
    is_wished: &dyn Fn(Pos) -> bool,
) -> Vec<Pos> {
    let plans = plans(&Expressions::of(func, library), rule, is_wished);
    let mut done = Vec::new();
    let mut renames = Renames::default();
    for (block, inst, tree) in plans {
        let pos = func.insts[inst].pos;
        let old = func.insts[inst].results[0];
        let mut made = Vec::new();
        let new = tree.build(func, func.values[old], pos, &mut made);
        let insts = &mut func.blocks[block].insts;
        let at = insts.iter().position(|&i| i == inst).unwrap_or(insts.len());
        insts.splice(at..at, made);
        renames.replace(old, new);
        done.push(pos);
    }
    renames.apply(func);
    done
}
