//! Settings of a kernel: the structure, bits and steps of each special-function unit, and what the
//! compiler may do.

use crate::attributes::words;
use srp_archdesc::arch::{Approx, Arch, Subnormals};
use srp_archdesc::format::{Format, KINDS};
use srp_archdesc::structure::{Special, Structure};
use srp_ir::pass::Rewrite;
use srp_toolchain::Options;
use std::sync::Arc;

/// A machine and a compiler.
#[derive(Clone, Debug)]
pub(super) struct Subject {
    pub(super) arch: Arch,
    pub(super) options: Options,
}

type Change = Arc<dyn Fn(&mut Subject) + Send + Sync>;

/// A value of a knob.
#[derive(Clone)]
pub(super) struct Value {
    /// In a few words; empty where everything stays as it is.
    pub(super) words: String,
    /// How a user says it.
    pub(super) how: String,
    change: Change,
}

/// The knobs that can be turned.
#[derive(Clone)]
pub(super) struct Knob {
    pub(super) name: String,
    /// The unit that it is of; a permission of the compiler has none.
    pub(super) unit: Option<Special>,
    /// Its values, the first of which leaves everything as it is.
    pub(super) values: Vec<Value>,
}

impl Value {
    fn as_it_is() -> Value {
        Value {
            words: String::new(),
            how: String::new(),
            change: Arc::new(|_| {}),
        }
    }
}

/// Tables that are tried of units with Newton–Raphson steps: bits and steps.
const STEPPED: [(u32, u32); 9] = [
    (16, 0),
    (12, 0),
    (8, 0),
    (16, 1),
    (12, 1),
    (8, 1),
    (16, 2),
    (12, 2),
    (8, 2),
];

/// The precisions that are tried of a unit.
fn precisions(special: Special) -> Vec<Approx> {
    let polynomial = |bits| {
        let segments = special.segments(2, bits);
        Approx::built(
            Structure::Polynomial {
                degree: 2,
                segments,
            },
            bits,
        )
    };
    let mut all = vec![Approx::Exact];
    match special.has_steps() {
        true => all.extend(
            STEPPED
                .iter()
                .map(|&(bits, steps)| Approx::table(bits, steps)),
        ),
        false => all.extend([16, 12, 8].map(|bits| Approx::table(bits, 0))),
    }
    all.push(Approx::built(Structure::Offsets { tables: 1 }, 16));
    all.push(polynomial(16));
    all.push(polynomial(22));
    all
}

/// The knobs of a kernel that uses some units, on a machine as it is.
pub(super) fn knobs(units: &[Special], base: &Subject) -> Vec<Knob> {
    let mut knobs: Vec<Knob> = units.iter().map(|&special| unit(special, base)).collect();
    let allowed = base.options.fast_math;
    let mut permission = |name: &str, has: bool, allow: fn(&mut Subject)| {
        if !has {
            let value = Value {
                words: "yes".to_owned(),
                how: format!("-f{name}"),
                change: Arc::new(allow),
            };
            knobs.push(Knob {
                name: name.to_owned(),
                unit: None,
                values: vec![Value::as_it_is(), value],
            });
        }
    };
    permission("associative-math", allowed.associative, |s| {
        s.options.fast_math.associative = true;
    });
    permission("reciprocal-math", allowed.reciprocal, |s| {
        s.options.fast_math.reciprocal = true;
    });
    permission("fp-contract=fast", allowed.contract, |s| {
        s.options.fast_math.contract = true;
    });
    permission("approx-func", allowed.approximate, |s| {
        s.options.fast_math.approximate = true;
    });
    if base.arch.precision.subnormals == Subnormals::Keep {
        knobs.push(Knob {
            name: "subnormals".to_owned(),
            unit: None,
            values: vec![
                Value::as_it_is(),
                Value {
                    words: "flush".to_owned(),
                    how: "<float subnormals=\"flush\"/>".to_owned(),
                    change: Arc::new(|s| s.arch.precision.subnormals = Subnormals::Flush),
                },
            ],
        });
    }
    knobs.extend(formats(base));
    knobs
}

/// The knob of a rewrite, at a place as the user knows it.
pub(super) fn rewritten(rewrite: &Rewrite, place: &str) -> Knob {
    let name = format!("{}@{place}", rewrite.rule.name());
    let wish = rewrite.clone();
    let value = Value {
        words: "yes".to_owned(),
        how: format!("--rewrite {name}"),
        change: Arc::new(move |s| s.options.rewrites.push(wish.clone())),
    };
    Knob {
        name,
        unit: None,
        values: vec![Value::as_it_is(), value],
    }
}

/// The knobs of the formats of sums and products that are in binary32.
fn formats(base: &Subject) -> impl Iterator<Item = Knob> {
    let value = |kind: usize, (word, format): (&str, Format)| Value {
        words: word.to_owned(),
        how: format!("<float {}=\"{word}\"/>", KINDS[kind].0),
        change: Arc::new(move |s: &mut Subject| {
            *s.arch.precision.formats.of_kind(kind) = format;
        }),
    };
    let single = base.arch.precision.formats.all().into_iter().enumerate();
    let single = single.filter(|(_, own)| *own == Format::SINGLE);
    single.map(move |(kind, _)| {
        let narrow = Format::NAMED
            .into_iter()
            .filter(|(_, f)| *f != Format::SINGLE);
        Knob {
            name: format!("{} in", KINDS[kind].1),
            unit: None,
            values: std::iter::once(Value::as_it_is())
                .chain(narrow.map(|named| value(kind, named)))
                .collect(),
        }
    })
}

fn unit(special: Special, base: &Subject) -> Knob {
    let known = base.arch.precision.of(special);
    let tried = precisions(special)
        .into_iter()
        .filter(|&approx| approx != known);
    let value = |approx: Approx| {
        let (words, attributes) = words(approx);
        Value {
            words,
            how: format!("<special function=\"{}\" {attributes}/>", special.name()),
            change: Arc::new(move |s: &mut Subject| *s.arch.precision.of_mut(special) = approx),
        }
    };
    Knob {
        name: special.name().to_owned(),
        unit: Some(special),
        values: std::iter::once(Value::as_it_is())
            .chain(tried.map(value))
            .collect(),
    }
}

/// The knob of a unit that the program uses only with a permission: each of its values gives that too.
pub(super) fn brought(special: Special, base: &Subject, by: &Knob) -> Knob {
    let mut knob = unit(special, base);
    for value in knob.values.iter_mut().skip(1) {
        let (permission, own) = (Arc::clone(&by.values[1].change), Arc::clone(&value.change));
        value.words += &format!(" with {}", by.name);
        value.how = format!("{}  {}", by.values[1].how, value.how);
        value.change = Arc::new(move |s| {
            permission(s);
            own(s);
        });
    }
    knob
}

/// A subject with a value of every knob.
pub(super) fn applied(base: &Subject, knobs: &[Knob], point: &[usize]) -> Subject {
    let mut subject = base.clone();
    for (knob, &value) in knobs.iter().zip(point) {
        (knob.values[value].change)(&mut subject);
    }
    subject.arch.derive_cycles();
    subject
}
