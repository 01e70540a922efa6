//! Writing XML: tags with attributes, two spaces a level.
//!
//! Line breaks and tabs in values are written as references, since XML would turn them into spaces.

use std::fmt::{Display, Write};

/// A start tag with its attributes.
pub struct Tag {
    name: &'static str,
    text: String,
}

impl Tag {
    /// A tag without attributes.
    pub fn new(name: &'static str) -> Tag {
        Tag {
            name,
            text: format!("<{name}"),
        }
    }

    /// An attribute more.
    pub fn attr(mut self, name: &str, value: impl Display) -> Tag {
        self.text.push(' ');
        self.text.push_str(name);
        self.text.push_str("=\"");
        for c in value.to_string().chars() {
            match c {
                '&' => self.text.push_str("&amp;"),
                '<' => self.text.push_str("&lt;"),
                '"' => self.text.push_str("&quot;"),
                '\t' | '\n' | '\r' => drop(write!(self.text, "&#{};", u32::from(c))),
                c => self.text.push(c),
            }
        }
        self.text.push('"');
        self
    }

    /// The attribute, if there is anything to say.
    pub fn attr_if(self, name: &str, value: Option<impl Display>) -> Tag {
        match value {
            Some(value) => self.attr(name, value),
            None => self,
        }
    }

    /// The attribute with the items, divided by spaces, if there are any.
    pub fn list(self, name: &str, items: impl IntoIterator<Item = impl Display>) -> Tag {
        let items: Vec<String> = items.into_iter().map(|item| item.to_string()).collect();
        if items.is_empty() {
            self
        } else {
            self.attr(name, items.join(" "))
        }
    }
}

/// A document being written.
pub struct Writer {
    text: String,
    open: Vec<&'static str>,
}

impl Default for Writer {
    /// A document without an element.
    fn default() -> Writer {
        Writer {
            text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(),
            open: Vec::new(),
        }
    }
}

impl Writer {
    /// The text of the document.
    pub fn into_text(self) -> String {
        self.text
    }

    fn indent(&mut self) {
        for _ in 0..self.open.len() {
            self.text.push_str("  ");
        }
    }

    /// An element without children.
    pub fn leaf(&mut self, tag: Tag) {
        self.indent();
        self.text.push_str(&tag.text);
        self.text.push_str("/>\n");
    }

    /// An element with text in it.
    pub fn text(&mut self, tag: Tag, text: &str) {
        self.indent();
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        self.text
            .push_str(&format!("{}>{text}</{}>\n", tag.text, tag.name));
    }

    /// The start of an element with children.
    pub fn open(&mut self, tag: Tag) {
        self.indent();
        self.text.push_str(&tag.text);
        self.text.push_str(">\n");
        self.open.push(tag.name);
    }

    /// The end of the last element opened.
    pub fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.indent();
            self.text.push_str("</");
            self.text.push_str(name);
            self.text.push_str(">\n");
        }
    }
}
