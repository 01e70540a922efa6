//! A serde `Deserializer` over the [tree](super::tree), and [`Spanned`], through which a value
//! learns where it stands.
//!
//! A struct is an element; its fields are attributes and child elements alike, a `Vec` being child
//! elements that may be repeated. The derived code of serde stops at its first error, so the
//! deserializer makes none: it knows the fields of each struct, reports unknown, repeated and
//! misplaced ones to [`Findings`] itself and goes on. For that, every field must have a default and
//! every leaf must be a string.

use std::marker::PhantomData;

use serde::de::value::{BorrowedStrDeserializer, Error, StrDeserializer, U32Deserializer};
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, IntoDeserializer, MapAccess, SeqAccess, Visitor,
};
use serde::forward_to_deserialize_any;

use super::findings::Findings;
use super::quote::quoted;
use super::tree::{Attribute, Element};
use crate::diagnostic::Span;
use crate::nearest::nearest;

/// A value and where it stands: an attribute's value, or the name of an element.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Spanned<T> {
    /// The value.
    pub(super) value: T,
    /// Where it stands.
    pub(super) span: Span,
}

impl<T> std::ops::Deref for Spanned<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.value
    }
}

/// The struct name by which the deserializer knows that positions are asked for.
const SPANNED: &str = "$Spanned";
const SPANNED_FIELDS: &[&str] = &["$start", "$end", "$value"];

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Spanned<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SpannedVisitor<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for SpannedVisitor<T> {
            type Value = Spanned<T>;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a value with its position")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Spanned<T>, A::Error> {
                let missing = || serde::de::Error::custom("no position");
                let (_, start): (&str, u32) = map.next_entry()?.ok_or_else(missing)?;
                let (_, end): (&str, u32) = map.next_entry()?.ok_or_else(missing)?;
                let (_, value): (&str, T) = map.next_entry()?.ok_or_else(missing)?;
                let span = Span::new(start, end);
                Ok(Spanned { value, span })
            }
        }

        deserializer.deserialize_struct(SPANNED, SPANNED_FIELDS, SpannedVisitor(PhantomData))
    }
}

/// The value that the element `root` stands for.
pub(super) fn from_tree<'de, T: Deserialize<'de>>(
    root: &'de Element<'de>,
    found: &'de Findings,
) -> T {
    let node = Node {
        part: Part::Element(root),
        parent: root.span,
        is_guess: false,
        found,
    };
    T::deserialize(node).expect("every field has a default, and every leaf is a string")
}

/// A part of the tree, as a deserializer.
#[derive(Clone, Copy)]
struct Node<'de> {
    part: Part<'de>,
    /// Where the element stands that it is a part of.
    parent: Span,
    /// True if its name is none, and was reported: it is taken for the nearest one.
    is_guess: bool,
    found: &'de Findings,
}

#[derive(Clone, Copy)]
enum Part<'de> {
    Element(&'de Element<'de>),
    Attribute(&'de Attribute<'de>),
}

impl<'de> Node<'de> {
    fn name(self) -> &'de str {
        match self.part {
            Part::Element(element) => element.name,
            Part::Attribute(attribute) => attribute.name,
        }
    }

    fn span(self) -> Span {
        match self.part {
            Part::Element(element) => element.span,
            Part::Attribute(attribute) => attribute.value_span,
        }
    }

    /// Reports an attribute written as an element, or an element written as an attribute.
    fn misplaced(self) {
        let name = self.name();
        if self.is_guess {
            self.found.void(self.span());
            return;
        }
        let (span, message, label, help) = match self.part {
            Part::Element(element) => (
                element.span,
                format!("`{name}` is an attribute, not an element"),
                "an element here",
                format!("write `{name}=\"…\"` in the start tag"),
            ),
            Part::Attribute(attribute) => (
                attribute.name_span,
                format!("`{name}` is an element, not an attribute"),
                "an attribute here",
                format!("write `<{name} …/>` inside the element"),
            ),
        };
        let diagnostic = self.found.error("A0204", span, message, label);
        self.found.push(diagnostic.help(help));
        self.found.suspect(self.parent, name);
        self.found.void(self.span());
    }
}

impl<'de> Deserializer<'de> for Node<'de> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.part {
            Part::Attribute(attribute) => visitor.visit_borrowed_str(&attribute.value),
            Part::Element(_) => {
                self.misplaced();
                visitor.visit_borrowed_str("")
            }
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        if name == SPANNED {
            return visitor.visit_map(Position {
                node: self,
                next: 0,
            });
        }
        match self.part {
            Part::Element(element) => visitor.visit_map(Fields::of(element, fields, self.found)),
            Part::Attribute(_) => {
                self.misplaced();
                visitor.visit_map(Fields::default())
            }
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// The three fields of a [`Spanned`].
struct Position<'de> {
    node: Node<'de>,
    next: usize,
}

impl<'de> MapAccess<'de> for Position<'de> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Error> {
        let Some(field) = SPANNED_FIELDS.get(self.next) else {
            return Ok(None);
        };
        self.next += 1;
        seed.deserialize(BorrowedStrDeserializer::new(field))
            .map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Error> {
        let number = |n: u32| -> U32Deserializer<Error> { n.into_deserializer() };
        match self.next {
            1 => seed.deserialize(number(self.node.span().start)),
            2 => seed.deserialize(number(self.node.span().end)),
            _ => seed.deserialize(self.node),
        }
    }
}

/// Repeated child elements.
struct Elements<I>(I);

impl<'de, I: Iterator<Item = Node<'de>>> SeqAccess<'de> for Elements<I> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Error> {
        self.0.next().map(|node| seed.deserialize(node)).transpose()
    }
}

/// The known attributes and child elements of an element, by field.
#[derive(Default)]
struct Fields<'de> {
    fields: std::vec::IntoIter<(&'static str, Vec<Node<'de>>)>,
    value: Vec<Node<'de>>,
}

impl<'de> Fields<'de> {
    fn of(
        element: &'de Element<'de>,
        known: &'static [&'static str],
        found: &'de Findings,
    ) -> Fields<'de> {
        let mut fields: Vec<(&'static str, Vec<Node<'de>>)> =
            known.iter().map(|&name| (name, Vec::new())).collect();
        let attributes = element.attributes.iter().map(Part::Attribute);
        let children = element.children.iter().map(Part::Element);
        let mut unknown = Vec::new();
        for part in attributes.chain(children) {
            let node = Node {
                part,
                parent: element.span,
                is_guess: false,
                found,
            };
            match fields.iter_mut().find(|(name, _)| *name == node.name()) {
                Some((_, nodes)) => nodes.push(node),
                None => unknown.push(node),
            }
        }
        for node in unknown {
            guess(element, node, &mut fields);
        }
        fields.retain(|(_, nodes)| !nodes.is_empty());
        Fields {
            fields: fields.into_iter(),
            value: Vec::new(),
        }
    }
}

impl<'de> MapAccess<'de> for Fields<'de> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Error> {
        let Some((name, nodes)) = self.fields.next() else {
            return Ok(None);
        };
        self.value = nodes;
        seed.deserialize(StrDeserializer::new(name)).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Error> {
        seed.deserialize(Children(std::mem::take(&mut self.value)))
    }
}

/// Everything an element has of one name, at least one.
struct Children<'de>(Vec<Node<'de>>);

impl<'de> Children<'de> {
    /// The only one, or the first with a complaint about the others.
    fn single(self) -> Node<'de> {
        let first = self.0[0];
        // A guess that was wrong is no second mistake.
        for &node in self.0[1..].iter().filter(|node| !node.is_guess) {
            let message = format!("`{}` is given twice", node.name());
            let diagnostic = node
                .found
                .error("A0203", node.span(), message, "given again")
                .also(first.span(), "first given here");
            node.found.push(diagnostic);
        }
        first
    }
}

impl<'de> Deserializer<'de> for Children<'de> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.single().deserialize_any(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self.single())
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let elements = self.0.into_iter().filter(|node| match node.part {
            Part::Element(_) => true,
            Part::Attribute(_) => {
                node.misplaced();
                false
            }
        });
        visitor.visit_seq(Elements(elements))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.single().deserialize_struct(name, fields, visitor)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct newtype_struct tuple tuple_struct map enum identifier ignored_any
    }
}

/// Reports an attribute or a child that `element` does not have. It is read as the one that was probably meant, so that
/// one slip of the pen is one mistake.
fn guess<'de>(
    element: &Element<'_>,
    node: Node<'de>,
    fields: &mut [(&'static str, Vec<Node<'de>>)],
) {
    let Node { part, found, .. } = node;
    if found.is_full() {
        return;
    }
    let (code, what, span) = match part {
        Part::Element(child) => ("A0201", "element", child.span),
        Part::Attribute(attribute) => ("A0202", "attribute", attribute.name_span),
    };
    let message = format!("`{}` has no {what} {}", element.name, quoted(node.name()));
    let diagnostic = found.error(code, span, message, format!("unknown {what}"));
    let known: Vec<&str> = fields.iter().map(|(name, _)| *name).collect();
    // What is there under its own name is hardly meant once more.
    let missing = fields.iter().filter(|(_, nodes)| nodes.is_empty());
    let near = nearest(node.name(), missing.map(|(name, _)| *name));
    let Some(near) = near.or_else(|| nearest(node.name(), known.iter().copied())) else {
        found.push(diagnostic.help(format!("it has {}", known.join(", "))));
        return;
    };
    found.push(diagnostic.help(format!("did you mean `{near}`?")));
    found.suspect(element.span, near);
    let is_child = matches!(part, Part::Element(_));
    let field = fields.iter_mut().find(|(name, _)| *name == near);
    if let Some((_, nodes)) = field.filter(|(_, nodes)| nodes.is_empty() || is_child) {
        nodes.push(Node {
            is_guess: true,
            ..node
        });
    }
}
