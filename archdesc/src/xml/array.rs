//! The array: which unit stands in each cell, its files, and the VLIW engine on it.

use std::collections::{BTreeMap, BTreeSet};

use super::de::Spanned;
use super::findings::Findings;
use super::limits;
use super::raw::{self, Text};
use super::units::{self, Body, BodyParts, OpContext};
use super::values;
use crate::arch::{FileKind, FileSpec, Fu, FuSpec, RegFile};
use crate::diagnostic::Span;
use crate::entity::EntityMap;

/// Words that stand for several units in a list of readers or writers.
pub(super) const ALL: &str = "all";
pub(super) const SLOTS: &str = "slots";

/// The units of an array, by cell.
pub(super) struct Units {
    pub(super) rows: u32,
    pub(super) cols: u32,
    /// True if the file says how large the array is; if not, rules about cells would report it twice.
    pub(super) sized: bool,
    pub(super) fus: EntityMap<Fu, FuSpec>,
    /// The elements that each unit was made from.
    pub(super) origins: EntityMap<Fu, Origin>,
    names: BTreeMap<String, Fu>,
    /// Names of units that have no cell, which was reported.
    dropped: BTreeSet<String>,
}

/// The elements of the file that a unit was made from.
#[derive(Clone)]
pub(super) struct Origin {
    /// Name of its `<fu-type>`, if it has one.
    pub(super) fu_type: Option<String>,
    /// Its `<fu>` or else its `<fu-type>`.
    pub(super) span: Span,
    /// Where the file gives it each class.
    pub(super) mentions: BTreeMap<crate::isa::Class, Span>,
    files: Vec<units::LocalFile>,
}

impl Units {
    /// The unit that `text` names; reports a name that no unit has.
    pub(super) fn find(&self, found: &Findings, text: &Text) -> Option<Fu> {
        let fu = self.names.get(&text.value).copied();
        let reported = || self.dropped.contains(&text.value) || found.suspects_any(&["fu", "name"]);
        if fu.is_none() && self.sized && !reported() {
            let known = self.fus.values().map(|f| f.name.as_str());
            values::unknown(found, "A0401", text, "unit", known);
        }
        fu
    }

    /// The width of a link that is as wide as both its ends.
    pub(super) fn link_width(&self, from: Fu, to: Fu) -> u32 {
        self.fus[from].width.min(self.fus[to].width)
    }

    /// The VLIW slots, in slot order.
    pub(super) fn slots(&self) -> Vec<Fu> {
        let mut slots: Vec<(u32, Fu)> = self
            .fus
            .iter()
            .filter_map(|(fu, f)| f.slot.map(|slot| (slot, fu)))
            .collect();
        slots.sort_unstable();
        slots.into_iter().map(|(_, fu)| fu).collect()
    }
}

/// The unit types by name.
type FuTypes<'r> = BTreeMap<&'r str, FuType>;

/// A unit type.
struct FuType {
    span: Span,
    body: Body,
}

fn fu_types<'r>(cx: &OpContext<'_>, raw: &'r [Spanned<raw::FuType>]) -> FuTypes<'r> {
    let mut seen = BTreeMap::new();
    let mut types = BTreeMap::new();
    for t in raw {
        let body = units::body(cx, None, &BodyParts::from(&t.value));
        let name = values::required_identifier(cx.found, &t.name, "fu-type", t.span);
        let (Some(name), Some(text)) = (name, &t.name) else {
            cx.found.suspect(t.span, "fu-type");
            continue;
        };
        if units::unique(cx.found, &mut seen, &name, text.span, "fu-type") {
            let span = text.span;
            types.insert(text.value.as_str(), FuType { span, body });
        }
    }
    types
}

/// A unit type with its name, or `None` (reported) where there is none of the name.
fn find_type<'r, 't>(
    found: &Findings,
    types: &'t FuTypes<'r>,
    text: &Text,
) -> Option<(&'r str, &'t FuType)> {
    let fu_type = types.get_key_value(text.value.as_str());
    if fu_type.is_none() {
        if !found.suspects_any(&["fu-type"]) {
            values::unknown(found, "A0402", text, "fu-type", types.keys().copied());
        }
        found.suspect(text.span, "type");
    }
    fu_type.map(|(&name, fu_type)| (name, fu_type))
}

/// The file's statements about the cells of the array.
struct Layout<'r, 't> {
    types: &'t FuTypes<'r>,
    /// The `<row>`s, to be repeated over the array.
    tile: Vec<Vec<Option<(&'r str, &'t FuType)>>>,
    /// The `<fu>`s by row and column.
    written: BTreeMap<(u32, u32), &'r Spanned<raw::Fu>>,
    /// The first cells of the first row that are VLIW slots.
    slots: u32,
    array: Span,
}

/// The units of the array.
pub(super) fn units(
    cx: &OpContext<'_>,
    machine: &raw::Machine,
    array: &Spanned<raw::Array>,
    slots: &Option<Text>,
) -> Units {
    let found = cx.found;
    let types = fu_types(cx, &machine.fu_type);
    let before = found.len();
    let size = |text, limit| values::required_number(found, text, limit, "array", array.span);
    let rows = size(&array.rows, limits::ROWS);
    let cols = size(&array.cols, limits::COLS);
    let sized = array.rows.is_some() && array.cols.is_some() && found.len() == before;
    let written = written(found, array, (rows, cols), sized);
    let layout = Layout {
        types: &types,
        tile: array
            .row
            .iter()
            .map(|row| row_types(found, &types, row))
            .collect(),
        written: written.cells,
        slots: first_slots(found, slots, cols, sized),
        array: array.span,
    };
    let mut units = Units {
        rows,
        cols,
        sized,
        fus: EntityMap::new(),
        origins: EntityMap::new(),
        names: BTreeMap::new(),
        dropped: written.dropped,
    };
    let mut seen = BTreeMap::new();
    let mut empty = None;
    for (row, col) in (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))) {
        let (unit, origin) = unit(cx, &layout, row, col).unwrap_or_else(|| {
            empty = empty.or(Some((row, col)));
            no_such_unit(&layout, row, col)
        });
        units::unique(found, &mut seen, &unit.name, origin.span, "unit");
        let name = unit.name.clone();
        let fu = units.fus.push(unit);
        units.names.insert(name, fu);
        units.origins.push(origin);
    }
    if let Some((row, col)) = empty
        && sized
        && !found.suspects_any(&["row", "fu", "units"])
    {
        no_unit(found, array.span, row, col);
    }
    units
}

fn no_unit(found: &Findings, array: Span, row: u32, col: u32) {
    let message = format!("cell ({row}, {col}) of the array has no unit");
    let help = "give the array `<row units=\"…\"/>`s, which repeat over it, or an `<fu>` there";
    found.push(
        found
            .error("A0409", array, message, "the layout leaves it empty")
            .help(help),
    );
}

/// How many cells of the first row are VLIW slots.
fn first_slots(found: &Findings, text: &Option<Text>, cols: u32, sized: bool) -> u32 {
    let slots = values::number(found, text, limits::SLOTS, cols);
    if let Some(text) = text
        && sized
        && slots > cols
    {
        let message = format!("{slots} VLIW slots do not fit in a row of {cols} units");
        let label = "more than the columns";
        found.push(
            found
                .error("A0502", text.span, message, label)
                .help("give units of other rows a `slot`"),
        );
    }
    slots.min(cols)
}

/// The unit in one cell; `None` where the layout leaves it empty.
fn unit(
    cx: &OpContext<'_>,
    layout: &Layout<'_, '_>,
    row: u32,
    col: u32,
) -> Option<(FuSpec, Origin)> {
    let found = cx.found;
    let written = layout.written.get(&(row, col)).copied();
    let tile_row = layout.tile.get(row as usize % layout.tile.len().max(1));
    let tiled = tile_row
        .filter(|types| !types.is_empty())
        .map(|types| types[col as usize % types.len()]);
    let fu_type = match written.and_then(|fu| fu.r#type.as_ref()) {
        Some(text) => find_type(found, layout.types, text),
        None => tiled.flatten(),
    };
    let base = fu_type.map(|(_, t)| &t.body);
    let body = match (written, base) {
        (Some(fu), base) => units::body(cx, base, &BodyParts::from(&fu.value)),
        (None, Some(base)) => base.clone(),
        (None, None) if tiled.is_some() => Body::default(),
        (None, None) => return None,
    };
    let span = match (written, fu_type) {
        (Some(fu), _) => fu.span,
        (None, Some((_, t))) => t.span,
        (None, None) => layout.array,
    };
    let slot = match written {
        Some(fu) if fu.slot.is_some() => Some(values::number(found, &fu.slot, limits::SLOT, 0)),
        _ => (row == 0 && col < layout.slots).then_some(col),
    };
    let name = written.and_then(|fu| unit_name(found, fu));
    let unit = FuSpec {
        name: name.unwrap_or_else(|| default_name(row, col)),
        row,
        col,
        width: body.width,
        pred_out: body.pred_out,
        constants: body.constants,
        slot,
        ops: body.ops.into_values().collect(),
    };
    let origin = Origin {
        fu_type: fu_type.map(|(name, _)| name.to_owned()),
        span,
        mentions: body.mentions,
        files: body.files,
    };
    Some((unit, origin))
}

fn default_name(row: u32, col: u32) -> String {
    format!("fu_{row}_{col}")
}

/// Stands in for a unit that the file does not say, so that the cells after it keep their place.
fn no_such_unit(layout: &Layout<'_, '_>, row: u32, col: u32) -> (FuSpec, Origin) {
    let unit = FuSpec {
        name: default_name(row, col),
        row,
        col,
        width: 128,
        pred_out: true,
        constants: 0,
        slot: None,
        ops: Vec::new(),
    };
    let origin = Origin {
        fu_type: None,
        span: layout.array,
        mentions: BTreeMap::new(),
        files: Vec::new(),
    };
    (unit, origin)
}

fn row_types<'r, 't>(
    found: &Findings,
    types: &'t FuTypes<'r>,
    row: &Spanned<raw::Row>,
) -> Vec<Option<(&'r str, &'t FuType)>> {
    let Some(text) = &row.units else {
        values::missing(found, "units", "row", row.span);
        found.suspect(row.span, "units");
        return Vec::new();
    };
    let types: Vec<_> = values::words(text)
        .map(|word| find_type(found, types, &word))
        .collect();
    if types.is_empty() {
        let message = "a row has no units";
        found.push(found.error("A0409", text.span, message, "expected names of fu-types"));
        found.suspect(text.span, "units");
    }
    types
}

/// The `<fu>`s of an array.
#[derive(Default)]
struct Written<'r> {
    /// By row and column.
    cells: BTreeMap<(u32, u32), &'r Spanned<raw::Fu>>,
    /// Names of those that have no cell.
    dropped: BTreeSet<String>,
}

fn written<'r>(
    found: &Findings,
    array: &'r raw::Array,
    (rows, cols): (u32, u32),
    sized: bool,
) -> Written<'r> {
    let mut written = Written::default();
    for fu in &array.fu {
        let before = found.len();
        let row = values::required_number(found, &fu.row, limits::ROW, "fu", fu.span);
        let col = values::required_number(found, &fu.col, limits::COL, "fu", fu.span);
        let placed = found.len() == before && fu.row.is_some() && fu.col.is_some();
        let name = fu.name.as_ref().map(|name| name.value.clone());
        let name = name.unwrap_or_else(|| default_name(row, col));
        let complaint = if !placed {
            // Which unit this is cannot be said, so nothing is said about what the array lacks.
            found.suspect(fu.span, "fu");
            None
        } else if row >= rows || col >= cols {
            let message = format!("cell ({row}, {col}) is outside the {rows}×{cols} array");
            let label = "rows and columns count from 0";
            sized.then(|| found.error("A0406", fu.span, message, label))
        } else if let Some(first) = written.cells.get(&(row, col)) {
            let message = format!("cell ({row}, {col}) has two units");
            let diagnostic = found.error("A0407", fu.span, message, "the second");
            Some(diagnostic.also(first.span, "the first"))
        } else {
            written.cells.insert((row, col), fu);
            continue;
        };
        if let Some(diagnostic) = complaint {
            found.push(diagnostic);
        }
        written.dropped.insert(name);
    }
    written
}

fn unit_name(found: &Findings, fu: &raw::Fu) -> Option<String> {
    let text = fu.name.as_ref()?;
    let name = values::identifier(found, text)?;
    if [ALL, SLOTS].contains(&name.as_str()) {
        let message = format!("a unit cannot be called `{name}`");
        let label = "this word stands for several units";
        found.push(found.error("A0304", text.span, message, label));
        return None;
    }
    Some(name)
}

/// All register files: those of the array in the order of the file, then each unit's own.
pub(super) fn files(
    found: &Findings,
    array: &raw::Array,
    units: &Units,
) -> (EntityMap<RegFile, FileSpec>, EntityMap<RegFile, Span>) {
    let mut files = EntityMap::new();
    let mut spans = EntityMap::new();
    let mut seen = BTreeMap::new();
    let mut users = 0;
    for file in &array.file {
        if found.is_full() {
            break;
        }
        if let Some(spec) = array_file(found, file, units)
            && units::unique(found, &mut seen, &spec.name, file.span, "file")
        {
            users += spec.readers.len() + spec.writers.len();
            if users > limits::MAX_FILE_USERS {
                let most = limits::MAX_FILE_USERS;
                let message = format!("files have more than {most} readers and writers in all");
                found.push(found.error("A0410", file.span, message, "too many"));
                break;
            }
            files.push(spec);
            spans.push(file.span);
        }
    }
    for (fu, origin) in units.origins.iter() {
        let unit = &units.fus[fu];
        for local in &origin.files {
            let name = format!("{}_{}", unit.name, local.name);
            if units::unique(found, &mut seen, &name, local.span, "file") {
                files.push(FileSpec {
                    name,
                    width: local.width.unwrap_or(unit.width),
                    size: local.size,
                    kind: local.kind,
                    read_ports: local.read_ports,
                    write_ports: local.write_ports,
                    readers: vec![fu],
                    writers: vec![fu],
                    from_links: local.from_links,
                });
                spans.push(local.span);
            }
        }
    }
    (files, spans)
}

fn array_file(found: &Findings, file: &Spanned<raw::File>, units: &Units) -> Option<FileSpec> {
    const KINDS: [(&str, FileKind); 3] = [
        ("central", FileKind::Central),
        ("rotating", FileKind::Rotating),
        ("static", FileKind::Static),
    ];
    let at = file.span;
    let name = values::required_identifier(found, &file.name, "file", at);
    for (attribute, given) in [("kind", &file.kind), ("width", &file.width)] {
        if given.is_none() {
            values::missing(found, attribute, "file", at);
        }
    }
    let size = values::required_number(found, &file.size, limits::FILE_SIZE, "file", at);
    let kind = values::word(found, &file.kind, "kind", &KINDS);
    let slots = units.slots();
    let central = kind == Some(FileKind::Central);
    let (reads, writes) = match slots.len() as u32 {
        n if central && n > 0 => (3 * n, n),
        _ => (2, 1),
    };
    let list = |text: &Option<Text>, name| match text {
        Some(text) => unit_list(found, text, units, &slots),
        None if central => slots.clone(),
        None => {
            if kind.is_some() {
                values::missing(found, name, "file", at);
            }
            Vec::new()
        }
    };
    let spec = FileSpec {
        name: name.clone().unwrap_or_default(),
        width: values::width(found, &file.width, "width", &[1, 32, 128]).unwrap_or(32),
        size,
        kind: kind.unwrap_or(FileKind::Static),
        read_ports: values::number(found, &file.read_ports, limits::READ_PORTS, reads),
        write_ports: values::number(found, &file.write_ports, limits::WRITE_PORTS, writes),
        readers: list(&file.readers, "readers"),
        writers: list(&file.writers, "writers"),
        from_links: values::flag(found, &file.from_links, "from-links", false),
    };
    if name.is_none() || kind.is_none() {
        found.suspect(at, "file");
    }
    name.map(|_| spec)
}

/// The units that a list names, in the order of the list.
pub(super) fn unit_list(found: &Findings, text: &Text, units: &Units, slots: &[Fu]) -> Vec<Fu> {
    let mut list = Vec::new();
    let mut seen = BTreeSet::new();
    for word in values::words(text) {
        let named: Vec<Fu> = match word.as_str() {
            ALL => units.fus.keys().collect(),
            SLOTS => slots.to_vec(),
            _ => units.find(found, &word).into_iter().collect(),
        };
        for fu in named {
            if seen.insert(fu) {
                list.push(fu);
            }
        }
        if list.len() == units.fus.len() {
            break;
        }
    }
    if text.trim().is_empty() {
        let message = "at least one unit is needed here";
        found.push(found.error("A0411", text.span, message, "names no unit"));
    }
    list
}
