//! System memory. Settings that the file leaves out are those of the named memory, and without a name those
//! of the default machine.

use super::de::Spanned;
use super::findings::Findings;
use super::limits;
use super::raw::{self, Text};
use super::values;
use crate::diagnostic::Span;
use crate::dram::{
    AddressField, AddressPart, BankedSpec, ControllerSpec, DramModel, DramSpec, DramTiming, FIXED,
    RowPolicy, presets,
};

/// Kinds of memory.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Fixed,
    Banked,
}

/// Words of the parts of an address.
pub(super) const PARTS: [(&str, AddressPart); 4] = [
    ("row", AddressPart::Row),
    ("channel", AddressPart::Channel),
    ("bank", AddressPart::Bank),
    ("column", AddressPart::Column),
];

/// Words of the row policies.
pub(super) const ROW_POLICIES: [(&str, RowPolicy); 2] =
    [("open", RowPolicy::Open), ("closed", RowPolicy::Closed)];

/// The memory that the default machine has: the paper's.
pub(super) fn default() -> DramSpec {
    let [paper, ..] = presets();
    paper.spec
}

/// The memory that the file describes.
pub(super) fn dram(found: &Findings, raw: &Option<Spanned<raw::Dram>>) -> DramSpec {
    const KINDS: [(&str, Kind); 2] = [("fixed", Kind::Fixed), ("banked", Kind::Banked)];
    let Some(raw) = raw else {
        return default();
    };
    let kind = values::word(found, &raw.kind, "kind", &KINDS);
    let kind = kind.unwrap_or(match (&raw.latency_ns, &raw.preset) {
        (Some(_), None) => Kind::Fixed,
        _ => Kind::Banked,
    });
    if kind == Kind::Fixed {
        no_banks(found, raw);
        return common(found, raw, FIXED);
    }
    let named = presets().map(|preset| (preset.name, preset.spec));
    let choices = [0, 1, 2, 3].map(|i| (named[i].0, i));
    let base = match values::word(found, &raw.preset, "preset", &choices) {
        Some(i) => named[i].1.clone(),
        None => default(),
    };
    let mut spec = common(found, raw, base);
    if let DramModel::Banked(banked) = &spec.model {
        spec.model = DramModel::Banked(banks(found, raw, spec.channels, banked));
    }
    spec
}

/// Reads the attributes that memories of both kinds have.
fn common(found: &Findings, raw: &raw::Dram, base: DramSpec) -> DramSpec {
    let number = |text, limit, default| values::number(found, text, limit, default);
    DramSpec {
        mhz: number(&raw.mhz, limits::MHZ, base.mhz),
        channels: values::power(found, &raw.channels, limits::CHANNELS, base.channels),
        bits: values::power(found, &raw.bits, limits::DRAM_BITS, base.bits),
        shared: values::flag(found, &raw.shared, "shared", base.shared),
        latency_ns: number(&raw.latency_ns, limits::LATENCY_NS, base.latency_ns),
        model: base.model,
    }
}

/// Reports what a memory without banks cannot have.
fn no_banks(found: &Findings, raw: &raw::Dram) {
    let spans = [
        ("preset", &raw.preset),
        ("banks", &raw.banks),
        ("rows", &raw.rows),
        ("columns", &raw.columns),
        ("burst", &raw.burst),
        ("mapping", &raw.mapping),
    ];
    let attributes = spans.map(|(name, text)| (name, text.as_ref().map(|t| t.span)));
    let elements = [
        ("timing", raw.timing.as_ref().map(|e| e.span)),
        ("controller", raw.controller.as_ref().map(|e| e.span)),
    ];
    for (name, span) in attributes.into_iter().chain(elements) {
        let Some(span) = span else {
            continue;
        };
        let message = format!("a memory of fixed latency has no `{name}`");
        found.push(
            found
                .error("A0605", span, message, "means nothing here")
                .help("`kind=\"banked\"` has banks, rows and a controller"),
        );
    }
}

fn banks(
    found: &Findings,
    raw: &Spanned<raw::Dram>,
    channels: u32,
    base: &BankedSpec,
) -> BankedSpec {
    let before = found.len();
    let power = |text, limit, default| values::power(found, text, limit, default);
    let mut spec = BankedSpec {
        banks: power(&raw.banks, limits::DRAM_BANKS, base.banks),
        rows: power(&raw.rows, limits::DRAM_ROWS, base.rows),
        columns: power(&raw.columns, limits::DRAM_COLUMNS, base.columns),
        burst: power(&raw.burst, limits::BURST, base.burst),
        ..base.clone()
    };
    if spec.burst > spec.columns {
        let message = format!(
            "a burst of {} columns does not fit in a row of {}",
            spec.burst, spec.columns
        );
        let text = raw.burst.as_ref().or(raw.columns.as_ref());
        let span = text.map_or(raw.span, |t| t.span);
        found.push(found.error("A0606", span, message, "longer than a row"));
    }
    let sizes_are_good = found.len() == before;
    let written = raw.mapping.as_ref().map(|text| fields(found, text));
    let fields = match written {
        None => Some(flexible(&base.mapping)),
        Some(fields) => fields,
    };
    if let Some(fields) = fields
        && sizes_are_good
    {
        let span = raw.mapping.as_ref().map_or(raw.span, |text| text.span);
        spec.mapping = mapping(found, span, channels, &spec, &fields);
    }
    let before = found.len();
    spec.timing = timing(found, &raw.timing, &base.timing);
    spec.controller = controller(found, &raw.controller, &base.controller);
    if sizes_are_good && found.len() == before {
        refresh_leaves_time(found, raw, &spec);
    }
    spec
}

fn timing(
    found: &Findings,
    raw: &Option<Spanned<raw::DramTiming>>,
    base: &DramTiming,
) -> DramTiming {
    let Some(raw) = raw else {
        return *base;
    };
    let number = |text, limit, default| values::number(found, text, limit, default);
    DramTiming {
        cl: number(&raw.cl, limits::CL, base.cl),
        cwl: number(&raw.cwl, limits::CWL, base.cwl),
        rcd: number(&raw.rcd, limits::RCD, base.rcd),
        rp: number(&raw.rp, limits::RP, base.rp),
        ras: number(&raw.ras, limits::RAS, base.ras),
        rc: number(&raw.rc, limits::RC, base.rc),
        rrd: number(&raw.rrd, limits::RRD, base.rrd),
        faw: number(&raw.faw, limits::FAW, base.faw),
        wtr: number(&raw.wtr, limits::WTR, base.wtr),
        rtw: number(&raw.rtw, limits::RTW, base.rtw),
        wr: number(&raw.wr, limits::WR, base.wr),
        rtp: number(&raw.rtp, limits::RTP, base.rtp),
        ccd: number(&raw.ccd, limits::CCD, base.ccd),
        rfc: number(&raw.rfc, limits::RFC, base.rfc),
        refi: number(&raw.refi, limits::REFI, base.refi),
    }
}

fn controller(
    found: &Findings,
    raw: &Option<Spanned<raw::Controller>>,
    base: &ControllerSpec,
) -> ControllerSpec {
    let Some(raw) = raw else {
        return *base;
    };
    let number = |text, limit, default| values::number(found, text, limit, default);
    ControllerSpec {
        read_queue: number(&raw.read_queue, limits::READ_QUEUE, base.read_queue),
        write_queue: number(&raw.write_queue, limits::WRITE_QUEUE, base.write_queue),
        command_queue: number(
            &raw.command_queue,
            limits::COMMAND_QUEUE,
            base.command_queue,
        ),
        row_policy: values::word(found, &raw.row_policy, "row-policy", &ROW_POLICIES)
            .unwrap_or(base.row_policy),
        row_hits: number(&raw.row_hits, limits::ROW_HITS, base.row_hits),
        write_drain: number(&raw.write_drain, limits::WRITE_DRAIN, base.write_drain),
    }
}

/// A field as it is written; without bits, it has those that the others of its part leave.
struct RawField {
    part: AddressPart,
    bits: Option<u32>,
}

/// The mapping of these fields, with all their bits.
fn mapping(
    found: &Findings,
    span: Span,
    channels: u32,
    spec: &BankedSpec,
    fields: &[RawField],
) -> Vec<AddressField> {
    let mut mapping = Vec::new();
    for field in fields {
        let mut bits = field.bits;
        if bits.is_none() {
            let rest = fields.iter().filter(|f| f.part == field.part);
            let fixed: u32 = rest.filter_map(|f| f.bits).sum();
            let needed = needed(spec, channels, field.part);
            bits = needed.checked_sub(fixed);
        }
        let part = field.part;
        mapping.push(AddressField {
            part,
            bits: bits.unwrap_or(0),
        });
    }
    for (word, part) in PARTS {
        let of_part = |f: &&AddressField| f.part == part;
        let bits: u32 = mapping.iter().filter(of_part).map(|f| f.bits).sum();
        let needed = needed(spec, channels, part);
        if bits != needed {
            let message =
                format!("the address has {bits} bits for the {word}, which needs {needed}");
            found.push(found.error("A0607", span, message, "does not fit").help(
                "`mapping` lists `row`, `channel`, `bank` and `column` from the top; one field of \
                 each may leave out its number of bits",
            ));
        }
    }
    mapping
}

fn needed(spec: &BankedSpec, channels: u32, part: AddressPart) -> u32 {
    let bits = spec.address_bits(channels);
    bits.iter().find(|(p, _)| *p == part).map_or(0, |(_, b)| *b)
}

/// The fields of a named memory. The first field of each part adapts to other sizes.
fn flexible(base: &[AddressField]) -> Vec<RawField> {
    let adapt = |(i, field): (usize, &AddressField)| RawField {
        part: field.part,
        bits: base[..i]
            .iter()
            .any(|f| f.part == field.part)
            .then_some(field.bits),
    };
    base.iter().enumerate().map(adapt).collect()
}

/// The fields of a mapping, unless something is wrong with them.
fn fields(found: &Findings, text: &Text) -> Option<Vec<RawField>> {
    let before = found.len();
    let mut fields: Vec<RawField> = Vec::new();
    for word in values::words(text) {
        let (name, bits) = match word.value.split_once(':') {
            Some((name, bits)) => (name.to_owned(), Some(bits.to_owned())),
            None => (word.value.clone(), None),
        };
        let at = |value| Text {
            value,
            span: word.span,
        };
        let bits = bits.map(|bits| values::number(found, &Some(at(bits)), limits::FIELD_BITS, 1));
        let name = at(name);
        let Some(&(_, part)) = PARTS.iter().find(|(word, _)| *word == name.value) else {
            let known = PARTS.iter().map(|(word, _)| *word);
            values::unknown(found, "A0608", &name, "part of an address", known);
            continue;
        };
        let open = |f: &RawField| f.part == part && f.bits.is_none();
        if bits.is_none() && fields.iter().any(open) {
            let message = format!("two fields of the {} without their bits", name.value);
            let label = "write `:` and how many";
            found.push(found.error("A0607", word.span, message, label));
        }
        fields.push(RawField { part, bits });
    }
    (found.len() == before).then_some(fields)
}

/// A memory that is always busy refreshing would never answer.
fn refresh_leaves_time(found: &Findings, raw: &Spanned<raw::Dram>, spec: &BankedSpec) {
    let (refi, least) = (spec.timing.refi, spec.refresh_and_access());
    if refi == 0 || refi >= least {
        return;
    }
    let timing = raw.timing.as_ref();
    let text = timing.and_then(|t| t.refi.as_ref().or(t.rfc.as_ref()));
    let element = timing.map_or(raw.span, |t| t.span);
    let span: Span = text.map_or(element, |t| t.span);
    let message = format!("refreshes every {refi} cycles leave no time for requests");
    found.push(
        found
            .error("A0609", span, message, "too often")
            .help(format!(
                "with these times `refi` is at least {least}, or 0 for no refreshes"
            )),
    );
}
