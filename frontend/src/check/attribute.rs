//! `__attribute__((…))`.

use super::Checker;
use crate::ast::{Attribute, ExprKind};
use crate::ctype::{Int, Type, TypeId};
use crate::message::{BAD_TYPE, IGNORED, UNSUPPORTED};
use srp_archdesc::diagnostic::Span;

/// The largest alignment that can be asked for, bytes.
const MAX_ALIGN: i128 = 4096;

/// True when attributes ask that calls of a function are not inlined.
pub(super) fn noinline(attributes: &[Attribute]) -> bool {
    let mut names = attributes.iter().map(|a| a.name.trim_matches('_'));
    names.any(|name| matches!(name, "noinline" | "noipa"))
}

impl Checker<'_> {
    /// The type with its attributes: `vector_size(16)` makes a vector of it, `mode` another number;
    /// and the least alignment that they ask for, or 1.
    pub(super) fn attributed(&mut self, ty: TypeId, attributes: &[Attribute]) -> (TypeId, u32) {
        let (mut ty, mut align) = (ty, 1);
        for attribute in attributes {
            match &*attribute.name {
                "vector_size" => ty = self.vector_type(ty, attribute),
                "mode" => ty = self.mode(ty, attribute),
                "aligned" => align = align.max(self.alignment(attribute)),
                name if attribute.has_effect() => {
                    let text = format!("the attribute `{name}` is not supported");
                    self.error(UNSUPPORTED, attribute.span, text, "");
                }
                name if !attribute.is_harmless() => {
                    let text = format!("the attribute `{name}` is unknown and ignored");
                    self.warning(IGNORED, attribute.span, text);
                }
                _ => {}
            }
        }
        (ty, align)
    }

    /// Returns the alignment that `aligned` asks for, in bytes; without an argument, the largest of
    /// any type.
    fn alignment(&mut self, attribute: &Attribute) -> u32 {
        let &[e] = attribute.args.as_slice() else {
            return 16;
        };
        match self.const_int(e, "an alignment") {
            None => 1,
            // `_Alignas(0)` asks for nothing.
            Some((0, _)) => 1,
            Some((bytes, _)) if (1..=MAX_ALIGN).contains(&bytes) && bytes & (bytes - 1) == 0 => {
                bytes as u32
            }
            Some(_) => {
                let text = format!("an alignment is a power of two up to {MAX_ALIGN}");
                self.error(BAD_TYPE, attribute.span, text, "");
                1
            }
        }
    }

    /// Refuses an alignment where there is nothing to be aligned.
    pub(super) fn no_alignment(&mut self, align: u32, span: Span) {
        if align > 1 {
            let text = "`aligned` stands with variables, members and structs only";
            self.error(UNSUPPORTED, span, text, "");
        }
    }

    /// The number type of the machine mode that `mode` names, signed as the type is.
    fn mode(&mut self, ty: TypeId, attribute: &Attribute) -> TypeId {
        let name = match attribute.args.as_slice() {
            &[e] => match &self.unit.exprs[e].kind {
                ExprKind::Name(name) => name.trim_matches('_').to_owned(),
                _ => String::new(),
            },
            _ => String::new(),
        };
        let known = self.types.known;
        let signed = !self.types.is_unsigned(ty);
        let size = match (name.as_str(), self.types.get(ty)) {
            (_, Type::Error) => return ty,
            ("SF", Type::Float | Type::Double) => return known.float,
            ("DF", Type::Float | Type::Double) => return known.double,
            ("QI" | "byte", Type::Int(_)) => 1,
            ("HI", Type::Int(_)) => 2,
            ("SI" | "word" | "pointer", Type::Int(_)) => 4,
            ("DI", Type::Int(_)) => 8,
            _ => {
                let text = format!("there is no mode `{name}` of {}", self.show(ty));
                self.error(UNSUPPORTED, attribute.span, text, "");
                return known.error;
            }
        };
        self.types.int(Int::of_size(size, signed))
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
