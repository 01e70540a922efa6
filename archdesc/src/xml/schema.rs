//! The XML Schema of machine files: the elements and attributes that the reader knows, with the sentences of
//! `FORMAT.md` as their documentation.

use std::collections::BTreeSet;

use super::raw::{Fields, Machine, Member, Part};
use super::reference::{Entry, Reference, Values};
use super::tree::{Tag, Writer};

/// The XML Schema (1.0) of machine files.
///
/// It has every element and attribute that the reader knows, and the values of those attributes that are words, flags
/// or numbers. Whatever depends on several values is the reader's to say.
pub fn schema() -> String {
    let mut schema = Schema {
        out: Writer::default(),
        reference: Reference::of_machine_files(),
        written: BTreeSet::new(),
    };
    let namespace = "http://www.w3.org/2001/XMLSchema";
    schema
        .out
        .open(Tag::new("xs:schema").attr("xmlns:xs", namespace));
    let root = Tag::new("xs:element").attr("name", "machine");
    schema.out.leaf(root.attr("type", Machine::NAME));
    schema.plain_type("flag", "true|false");
    schema.plain_type("number", "0x[0-9A-Fa-f]+|[0-9]+");
    schema.element_type(Machine::NAME, &["machine"], &Machine::members());
    schema.out.close();
    schema.out.into_text()
}

/// The schema being written.
struct Schema {
    out: Writer,
    reference: Reference,
    /// Types of elements that are written already.
    written: BTreeSet<&'static str>,
}

impl Schema {
    /// A type of attributes whose values fit a pattern.
    fn plain_type(&mut self, name: &str, pattern: &str) {
        let out = &mut self.out;
        out.open(Tag::new("xs:simpleType").attr("name", name));
        out.open(Tag::new("xs:restriction").attr("base", "xs:string"));
        out.leaf(Tag::new("xs:pattern").attr("value", pattern));
        out.close();
        out.close();
    }

    /// The type of an element that lies at a path, and the types of those in it.
    fn element_type(&mut self, name: &'static str, path: &[&str], members: &[Member]) {
        if !self.written.insert(name) {
            return;
        }
        self.out.open(Tag::new("xs:complexType").attr("name", name));
        let inner: Vec<(String, &Part)> = (members.iter())
            .filter(|member| !matches!(member.part, Part::Attribute))
            .map(|member| (member.name(), &member.part))
            .collect();
        if !inner.is_empty() {
            // Their order does not matter.
            let any = Tag::new("xs:choice").attr("minOccurs", 0);
            self.out.open(any.attr("maxOccurs", "unbounded"));
            for (element, part) in &inner {
                self.element(element, part, path);
            }
            self.out.close();
        }
        for member in members.iter().filter(|m| matches!(m.part, Part::Attribute)) {
            let attribute = member.name();
            let entry = self.reference.attribute(path, &attribute);
            self.attribute(&attribute, entry);
        }
        self.out.close();
        for (element, part) in inner {
            if let Part::Element { name, members, .. } = part {
                self.element_type(name, &[path, &[&element]].concat(), &members());
            }
        }
    }

    fn element(&mut self, element: &str, part: &Part, path: &[&str]) {
        let Part::Element { name, many, .. } = part else {
            return;
        };
        let tag = Tag::new("xs:element").attr("name", element);
        self.out.open(tag.attr("type", name));
        let count = match many {
            true => "Any number of them.",
            false => "At most one.",
        };
        let what = self.reference.element(&[path, &[element]].concat());
        self.documentation(&[what.as_str(), count].join(" "));
        self.out.close();
    }

    fn attribute(&mut self, name: &str, entry: Entry) {
        let tag = Tag::new("xs:attribute").attr("name", name);
        let (kind, words) = match entry.values {
            Values::Flag => (Some("flag"), Vec::new()),
            Values::Number => (Some("number"), Vec::new()),
            Values::Words(words) => (None, words),
            Values::Any => (Some("xs:string"), Vec::new()),
        };
        self.out.open(tag.attr_if("type", kind));
        self.documentation(&entry.text);
        if !words.is_empty() {
            self.out.open(Tag::new("xs:simpleType"));
            self.out
                .open(Tag::new("xs:restriction").attr("base", "xs:string"));
            for word in words {
                self.out
                    .leaf(Tag::new("xs:enumeration").attr("value", word));
            }
            self.out.close();
            self.out.close();
        }
        self.out.close();
    }

    fn documentation(&mut self, text: &str) {
        self.out.open(Tag::new("xs:annotation"));
        self.out.text(Tag::new("xs:documentation"), text.trim());
        self.out.close();
    }
}
