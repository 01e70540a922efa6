//! The reference of the machine file, `FORMAT.md`, taken apart: what it says of each element and attribute.

use std::collections::BTreeMap;

/// The reference, as it stands.
const FORMAT: &str = include_str!("../../FORMAT.md");

/// The values that an attribute can have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Values {
    /// `true` or `false`.
    Flag,
    /// A whole number.
    Number,
    /// One of these words.
    Words(Vec<String>),
    /// Others: lists, names, sizes, or numbers and words.
    Any,
}

/// What the reference says of an attribute.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    /// In words; empty where it says nothing.
    pub(super) text: String,
    /// The values.
    pub(super) values: Values,
}

/// The reference, by element. An element that is described for one place only is known as `parent/element`.
#[derive(Default)]
pub(super) struct Reference {
    /// Rows of tables of attributes: by element and attribute, the cells with their headings.
    rows: BTreeMap<(String, String), Vec<(String, String)>>,
    /// Headings, and paragraphs that begin with an element.
    elements: BTreeMap<String, String>,
    /// Rows of the table of elements: their attributes in one cell.
    cells: BTreeMap<String, String>,
    /// The sentence on the attributes of caches.
    caches: String,
}

/// Elements whose attributes are described as those of others are.
const LIKE: &[(&str, &str)] = &[("fu", "fu-type")];

/// The elements that are caches.
const CACHES: &[&str] = &[
    "data-cache",
    "texture-cache",
    "instruction-cache",
    "trv-l1",
    "trv-l2",
    "ist-l1",
];

impl Reference {
    /// That of machine files.
    pub(super) fn of_machine_files() -> Reference {
        let mut reference = Reference::default();
        let (mut element, mut headings) = (String::new(), Vec::new());
        for block in FORMAT.split("\n\n") {
            let first = block.lines().next().unwrap_or_default();
            if let Some(name) = named(first) {
                element = name.to_owned();
                let said = match first.split_once(">`: ") {
                    Some((_, said)) => said.to_owned(),
                    None => block.replace('\n', " "),
                };
                reference.elements.entry(element.clone()).or_insert(said);
            }
            if let Some((_, caches)) = block.split_once("Of a cache, ") {
                let caches = caches.replace('\n', " ");
                let end = caches.find("; `line` and").unwrap_or(caches.len());
                reference.caches = caches[..end].to_owned();
            }
            for line in block.lines().filter(|line| line.starts_with('|')) {
                let cells = line.trim_matches('|').split('|').map(str::trim);
                let cells: Vec<&str> = cells.collect();
                match cells[0] {
                    "attribute" | "element" => {
                        headings = cells.iter().map(|cell| cell.to_string()).collect();
                    }
                    _ => reference.row(&element, &headings, &cells),
                }
            }
        }
        reference
    }

    /// Takes in a row of a table.
    fn row(&mut self, element: &str, headings: &[String], cells: &[&str]) {
        let is_of_elements = headings.first().is_some_and(|heading| heading == "element");
        if is_of_elements && cells.len() > 1 {
            self.row_of_elements(cells[0], cells[1]);
            return;
        }
        let cells: Vec<(String, String)> = (headings.iter().zip(cells))
            .map(|(heading, cell)| (heading.clone(), cell.to_string()))
            .collect();
        let names = cells.first().map(|(_, names)| quoted(names));
        for name in names.into_iter().flatten() {
            self.rows.insert((element.to_owned(), name), cells.clone());
        }
    }

    /// Takes in a row of the table of elements: an element, or an attribute of the caches before it.
    fn row_of_elements(&mut self, first: &str, said: &str) {
        let mut names = quoted(first)
            .into_iter()
            .map(|name| name.replace(['<', '>'], ""));
        let name = names.next().unwrap_or_default();
        if first.starts_with("`<") {
            let key = match names.next() {
                Some(parent) => format!("{parent}/{name}"),
                None => name,
            };
            self.cells.insert(key, said.to_owned());
            return;
        }
        let values = said.split(',').next().unwrap_or_default();
        let row = [("range", values), ("meaning", said)];
        let row = row.map(|(heading, cell)| (heading.to_owned(), cell.to_owned()));
        for cache in &CACHES[..2] {
            self.rows
                .insert((cache.to_string(), name.clone()), row.to_vec());
        }
    }

    /// The row of the table of elements for the element at a path.
    fn cell(&self, path: &[&str]) -> Option<&str> {
        let name = path.last()?;
        let parent = path.len().checked_sub(2).map(|parent| path[parent]);
        let within = parent.and_then(|parent| self.cells.get(&format!("{parent}/{name}")));
        within.or_else(|| self.cells.get(*name)).map(String::as_str)
    }

    /// What is said of the element at a path.
    pub(super) fn element(&self, path: &[&str]) -> String {
        let heading = path.last().and_then(|name| self.elements.get(*name));
        let said = heading.map(String::as_str).or_else(|| self.cell(path));
        let sentence = plain(said.unwrap_or_default());
        match sentence.ends_with('.') || sentence.is_empty() {
            true => sentence,
            false => sentence + ".",
        }
    }

    /// What is said of an attribute of the element at a path.
    pub(super) fn attribute(&self, path: &[&str], attribute: &str) -> Entry {
        let element = path.last().copied().unwrap_or_default();
        let like = LIKE.iter().find(|(name, _)| *name == element);
        let mut elements = [Some(element), like.map(|(_, like)| *like)]
            .into_iter()
            .flatten();
        let row = elements.find_map(|element| {
            let key = (element.to_owned(), attribute.to_owned());
            self.rows.get(&key)
        });
        if let Some(cells) = row {
            return entry(cells);
        }
        let said = match CACHES.contains(&element) {
            true => clause_of_caches(&self.caches, attribute),
            false => self.cell(path).and_then(|cell| clause(cell, attribute)),
        };
        let in_a_tag = || {
            let said = self.elements.get(element)?;
            said.contains(&format!(" {attribute}=\""))
                .then(|| said.clone())
        };
        Entry {
            text: plain(&said.or_else(in_a_tag).unwrap_or_default()),
            values: Values::Any,
        }
    }
}

/// The element that a heading, or the begin of a paragraph, is about.
fn named(line: &str) -> Option<&str> {
    let rest = line
        .strip_prefix("## `<")
        .or_else(|| line.strip_prefix("**`<"))?;
    rest.split([' ', '>']).next()
}

/// The words in backquotes that stand first in a cell, those of a list.
fn quoted(cell: &str) -> Vec<String> {
    cell.split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

/// An attribute's row.
fn entry(cells: &[(String, String)]) -> Entry {
    let of = |heading: &str| {
        let cell = cells.iter().find(|(of, _)| of == heading);
        cell.map(|(_, cell)| cell.as_str())
            .filter(|cell| !cell.is_empty())
    };
    let mut said: Vec<String> = of("meaning").map(plain).into_iter().collect();
    if let (Some(from), Some(to)) = (of("from"), of("to")) {
        said.push(format!("cycles from: {}; to: {}", plain(from), plain(to)));
    }
    for (heading, name) in [("range", "Values"), ("default", "Default")] {
        said.extend(of(heading).map(|cell| format!("{name}: {}", plain(cell))));
    }
    Entry {
        text: said.join(". ") + ".",
        values: of("range").map_or(Values::Any, values),
    }
}

/// The values that a cell describes.
fn values(cell: &str) -> Values {
    if cell == "flag" {
        return Values::Flag;
    }
    let is_digit = |c: char| c.is_ascii_digit() || ",–  ".contains(c);
    let range = cell.trim_end_matches(", a power of two");
    if !range.is_empty() && range.chars().all(is_digit) {
        return Values::Number;
    }
    let items: Vec<&str> = cell.split([',', ';']).map(str::trim).collect();
    let word = |item: &&str| {
        let word = item.strip_prefix('`')?.strip_suffix('`')?;
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-_".contains(c);
        word.chars().all(plain).then(|| word.to_owned())
    };
    match items.iter().map(word).collect() {
        Some(words) => Values::Words(words),
        None => Values::Any,
    }
}

/// The part of a row of the table of elements that describes an attribute.
fn clause(about: &str, attribute: &str) -> Option<String> {
    let name = format!("`{attribute}`");
    let found = about.split("; ").find(|clause| clause.contains(&name));
    found.map(str::to_owned)
}

/// The part of the sentence on caches that describes an attribute.
fn clause_of_caches(caches: &str, attribute: &str) -> Option<String> {
    let name = format!("`{attribute}` ");
    let start = caches.find(&name)?;
    let end = caches[start..]
        .find(", `")
        .map_or(caches.len(), |end| start + end);
    Some(caches[start..end].to_owned())
}

/// Text without the marks of Markdown.
fn plain(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(open) = rest.find('[') {
        let link = rest[open..].find("](").map(|middle| open + middle);
        let close = link.and_then(|middle| rest[middle..].find(')').map(|end| middle + end));
        let (Some(middle), Some(close)) = (link, close) else {
            break;
        };
        out.push_str(&rest[..open]);
        out.push_str(&rest[open + 1..middle]);
        rest = &rest[close + 1..];
    }
    out.push_str(rest);
    out.replace(['`'], "").replace("**", "")
}
