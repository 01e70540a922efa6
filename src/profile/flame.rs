//! The cycles of a profile from the whole down to lines: functions, their loops on the array and their VLIW code, the
//! lines of these. Each row is as wide as the one above, in the order of the cycles.

use super::{anchor, class_of, percent};
use maud::{Markup, PreEscaped, html};
use srp_runtime::digits::thousands;
use srp_studies::profile::{BEFORE_ALL, CodeProfile, Parts, Profile};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Width of the drawing, and height of a row.
const WIDTH: f64 = 1000.0;
const ROW: f64 = 20.0;

/// The least width of what is drawn.
const LEAST: f64 = 0.4;

/// A part of the whole, with its own parts.
#[derive(Default)]
struct Node<'a> {
    parts: Parts,
    below: BTreeMap<Part<'a>, Node<'a>>,
}

/// The kind and name of a part of the whole.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Part<'a> {
    Function(&'a str),
    Vliw,
    Loop(&'a str),
    Line(&'a str, u32),
}

impl Part<'_> {
    fn name(&self) -> String {
        match self {
            Part::Function("") => BEFORE_ALL.to_owned(),
            Part::Function(name) | Part::Loop(name) => (*name).to_owned(),
            Part::Vliw => "VLIW code".to_owned(),
            Part::Line(_, 0) => "no line".to_owned(),
            Part::Line(file, line) => format!("{}:{line}", file.rsplit('/').next().unwrap_or(file)),
        }
    }
}

impl<'a> Node<'a> {
    fn add(&mut self, code: &'a CodeProfile) {
        let half = code.kernel.as_deref().map_or(Part::Vliw, Part::Loop);
        let way = [
            Part::Function(&code.function),
            half,
            Part::Line(&code.file, code.line),
        ];
        self.parts += code.parts;
        let mut node = self;
        for part in way {
            node = node.below.entry(part).or_default();
            node.parts += code.parts;
        }
    }

    /// Draws its parts below a row, from `left` on.
    fn draw(&self, drawn: &mut String, (left, row): (f64, usize), whole: u64) {
        let mut below: Vec<(&Part, &Node)> = self.below.iter().collect();
        below.sort_by_key(|(part, node)| (Reverse(node.parts.total()), **part));
        let mut x = left;
        for (part, node) in below {
            let width = WIDTH * node.parts.total() as f64 / whole.max(1) as f64;
            if width >= LEAST {
                rectangle(drawn, *part, node, (x, row as f64 * ROW, width), whole);
                node.draw(drawn, (x, row + 1), whole);
            }
            x += width;
        }
    }
}

fn rectangle(
    drawn: &mut String,
    part: Part<'_>,
    node: &Node<'_>,
    (x, y, width): (f64, f64, f64),
    whole: u64,
) {
    let class = class_of(&node.parts);
    let (name, cycles) = (part.name(), node.parts.total());
    let title = html! { (name) ": " (thousands(cycles)) " cycles, " (percent(cycles, whole)) " %" };
    let height = ROW - 1.0;
    let (open, close) = match part {
        Part::Line(file, line) if line > 0 => {
            let place = anchor(&format!("{file}:{line}"));
            (format!("<a href=\"#{place}\">"), "</a>")
        }
        _ => ("<g>".to_owned(), "</g>"),
    };
    let _ = write!(
        drawn,
        "{open}<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\">\
         <title>{}</title></rect>",
        title.into_string()
    );
    if width > 6.5 * name.len() as f64 {
        let label = html! { (name) }.into_string();
        let (x, y) = (x + 4.0, y + 13.0);
        let _ = write!(drawn, "<text x=\"{x:.1}\" y=\"{y:.1}\">{label}</text>");
    }
    drawn.push_str(close);
}

/// The cycles from the whole down to lines.
pub(super) fn flame(profile: &Profile) -> Markup {
    let mut root = Node::default();
    profile.code.iter().for_each(|code| root.add(code));
    let mut drawn = String::new();
    root.draw(&mut drawn, (0.0, 0), root.parts.total());
    html! {
        section {
            h3 { "From functions down to lines" }
            p.soft { "Functions, below each its loops on the array and its VLIW code, below these their lines, as wide as \
                their cycles and in the colour of what most of them are. A line leads to its source." }
            svg.areas viewBox=(format!("0 0 {WIDTH} {}", 3.0 * ROW)) role="img" { (PreEscaped(drawn)) }
        }
    }
}
