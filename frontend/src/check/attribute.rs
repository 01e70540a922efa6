//! `__attribute__((…))`.

use super::Checker;
use crate::ast::Attribute;
use crate::ctype::{Int, Type, TypeId};
use crate::message::{BAD_TYPE, IGNORED, UNSUPPORTED};

/// Attributes that say nothing about what the program does.
const HARMLESS: &[&str] = &[
    "always_inline",
    "cold",
    "const",
    "deprecated",
    "fallthrough",
    "flatten",
    "format",
    "gnu_inline",
    "hot",
    "inline",
    "leaf",
    "malloc",
    "noclone",
    "noinline",
    "nonnull",
    "noreturn",
    "nothrow",
    "optimize",
    "pure",
    "returns_nonnull",
    "sentinel",
    "unused",
    "used",
    "visibility",
    "warn_unused_result",
];

/// Attributes that change a layout or what is called, so that they cannot be left out.
const REFUSED: &[&str] = &[
    "alias",
    "aligned",
    "cleanup",
    "constructor",
    "destructor",
    "mode",
    "packed",
    "section",
    "transparent_union",
    "weak",
];

impl Checker<'_> {
    /// The type with its attributes: `vector_size(16)` makes a vector of it.
    pub(super) fn attributed(&mut self, ty: TypeId, attributes: &[Attribute]) -> TypeId {
        let mut ty = ty;
        for attribute in attributes {
            let name = &*attribute.name;
            if name == "vector_size" {
                ty = self.vector_type(ty, attribute);
            } else if REFUSED.contains(&name) {
                let text = format!("the attribute `{name}` is not supported");
                self.error(UNSUPPORTED, attribute.span, text, "");
            } else if !HARMLESS.contains(&name) {
                let text = format!("the attribute `{name}` is unknown and ignored");
                self.warning(IGNORED, attribute.span, text);
            }
        }
        ty
    }

    fn vector_type(&mut self, lane: TypeId, attribute: &Attribute) -> TypeId {
        let known = self.types.known;
        let bytes = match attribute.args.as_slice() {
            &[bytes] => self.const_int(bytes, "the size of a vector"),
            _ => None,
        };
        match (bytes, self.types.get(lane)) {
            (Some((16, _)), Type::Float) => known.float4,
            (Some((16, _)), Type::Int(Int::Int)) => known.int4,
            (_, Type::Error) => lane,
            _ => {
                let text = "a vector is 16 bytes of `float` or of `int`";
                self.error(BAD_TYPE, attribute.span, text, "");
                known.error
            }
        }
    }
}
