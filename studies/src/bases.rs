//! A machine and the larger arrays that its file describes by itself, on which changes are tried: its rows repeat, and so do
//! the units of a row.

use crate::settings;
use srp_archdesc::Watch;
use srp_archdesc::arch::Arch;
use srp_archdesc::xml;
use srp_ir::dfg::Dfg;
use srp_scheduler::modulo::Options;
use srp_scheduler::what_if::{self, Change, Edit, WhatIf, what_if};
use std::borrow::Cow;

/// A machine, and the larger arrays of it.
pub(crate) struct Bases<'a>(Vec<Base<'a>>);

/// A machine that edits are made on.
struct Base<'a> {
    arch: Cow<'a, Arch>,
    /// The text of its file, where there is one.
    text: Option<Cow<'a, str>>,
    /// The changes that make it of the first, in words, each with the setting of the file that does.
    made: Vec<(&'static str, String)>,
}

/// A change of a machine: the number of a base, and edits of that.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Made {
    base: usize,
    edits: Vec<Edit>,
}

impl From<Change> for Made {
    fn from(Change { base, edits, .. }: Change) -> Made {
        Made { base, edits }
    }
}

impl<'a> Bases<'a> {
    /// A machine, and where the text of its file is known those of the larger arrays that the file is a machine with: of a row,
    /// a column, and both.
    pub(crate) fn of(arch: &'a Arch, text: Option<&'a str>) -> Bases<'a> {
        let base = Base {
            arch: Cow::Borrowed(arch),
            text: text.map(Cow::Borrowed),
            made: Vec::new(),
        };
        let (row, column) = (base.one_more_row(), base.one_more_column());
        let both = row.as_ref().and_then(Base::one_more_column);
        let larger = [row, column, both].into_iter().flatten();
        Bases(std::iter::once(base).chain(larger).collect())
    }

    /// Tries changes that might lower a loop's II below `ii`. Of those that give the same II the smallest comes first.
    pub(crate) fn try_changes(
        &self,
        dfg: &Dfg,
        ii: u32,
        options: &Options,
        (threads, watch): (usize, &dyn Watch),
    ) -> WhatIf {
        let bases = self.0.iter().map(|base| what_if::Base {
            srp: &base.arch.srp,
            changes: base.made.len(),
        });
        let bases: Vec<_> = bases.collect();
        let WhatIf { tried, changes } = what_if(dfg, &bases, ii, options, threads, watch);
        let priced = changes.into_iter().map(|change| {
            let made = Made {
                base: change.base,
                edits: change.edits.clone(),
            };
            (self.more_area(&made), change)
        });
        let mut priced: Vec<(f64, Change)> = priced.collect();
        priced.sort_by(|(a, one), (b, other)| one.ii.cmp(&other.ii).then(a.total_cmp(b)));
        let changes = priced.into_iter().map(|(_, change)| change).collect();
        WhatIf { tried, changes }
    }

    /// A change in words.
    pub(crate) fn in_words(&self, made: &Made) -> String {
        let base = &self.0[made.base];
        let mut words: Vec<String> = base
            .made
            .iter()
            .map(|(what, _)| (*what).to_owned())
            .collect();
        words.extend(what_if::in_words(&made.edits, &base.arch.srp));
        match words.split_last() {
            Some((last, [])) => last.clone(),
            Some((last, before)) => format!("{} and {last}", before.join(", ")),
            None => String::new(),
        }
    }

    /// The settings of the first machine's file that make a change; none where it takes more than these.
    pub(crate) fn settings(&self, made: &Made) -> Vec<String> {
        let base = &self.0[made.base];
        let own = match &base.text {
            Some(text) => settings::of(&made.edits, &base.arch, text),
            None => Vec::new(),
        };
        if own.is_empty() && !made.edits.is_empty() {
            return own;
        }
        let larger = base.made.iter().map(|(_, setting)| setting.clone());
        larger.chain(own).collect()
    }

    /// Area that an SRP has more with a change, mm² at 65 nm.
    pub(crate) fn more_area(&self, made: &Made) -> f64 {
        let srp = what_if::changed(&self.0[made.base].arch.srp, &made.edits);
        settings::more_area(srp, &self.0[0].arch)
    }
}

impl Base<'_> {
    fn one_more_row<'b>(&self) -> Option<Base<'b>> {
        self.larger("one more row of units", "rows", self.arch.srp.rows)
    }

    fn one_more_column<'b>(&self) -> Option<Base<'b>> {
        self.larger("one more column of units", "cols", self.arch.srp.cols)
    }

    /// The machine that the file with one attribute changed describes, if it is one.
    fn larger<'b>(&self, what: &'static str, side: &str, now: u32) -> Option<Base<'b>> {
        let setting = format!("array.{side}={}", now + 1);
        let text = setting
            .parse::<xml::Change>()
            .ok()?
            .make(self.text.as_deref()?)
            .ok()?;
        let arch = xml::parse("", &text).ok()?;
        let mut made = self.made.clone();
        made.push((what, setting));
        Some(Base {
            arch: Cow::Owned(arch),
            text: Some(Cow::Owned(text)),
            made,
        })
    }
}
