//! Compatible types (C11 6.2.7): those of one thing that two declarations or two sources name.

use super::{RecordId, Type, TypeId, TypeTable};
use std::collections::HashSet;

/// Records that a comparison of two types looks into; further ones of the same tags are taken for the same.
const MAX_COMPARED: usize = 4096;

/// Where two records that should be one type differ first.
#[derive(Clone, Copy, Debug)]
pub struct Difference {
    /// The two records.
    pub records: (RecordId, RecordId),
    /// The number of the member that one has and the other has not so; `None` where they differ as a whole.
    pub member: Option<usize>,
}

/// The walk through two types that are compared.
#[derive(Debug, Default)]
struct Comparison {
    /// Records that are taken for the same, as those around them are being compared.
    assumed: HashSet<(RecordId, RecordId)>,
    difference: Option<Difference>,
}

impl TypeTable {
    /// True if two types are compatible: equal except for array lengths that one leaves open.
    /// Structs of different sources are compatible if their tags and members are (C11 6.2.7).
    pub fn compatible(&self, a: TypeId, b: TypeId) -> bool {
        self.compatible_within(a, b, &mut Comparison::default())
    }

    /// Returns where two types differ that are not compatible, if it is in records of the same tag.
    pub fn difference(&self, a: TypeId, b: TypeId) -> Option<Difference> {
        let mut comparison = Comparison::default();
        self.compatible_within(a, b, &mut comparison);
        comparison.difference
    }

    fn compatible_within(&self, a: TypeId, b: TypeId, comparison: &mut Comparison) -> bool {
        if a == b {
            return true;
        }
        match (self.get(a), self.get(b)) {
            (Type::Error, _) | (_, Type::Error) => true,
            (Type::Pointer(a), Type::Pointer(b)) => {
                a.quals == b.quals && self.compatible_within(a.ty, b.ty, comparison)
            }
            (Type::Array(a, n), Type::Array(b, m)) => {
                (n == m || n.is_none() || m.is_none())
                    && a.quals == b.quals
                    && self.compatible_within(a.ty, b.ty, comparison)
            }
            (Type::Function(a), Type::Function(b)) => {
                let params = a.open
                    || b.open
                    || a.variadic == b.variadic
                        && a.params.len() == b.params.len()
                        && a.params
                            .iter()
                            .zip(&b.params)
                            .all(|(&a, &b)| self.compatible_within(a, b, comparison));
                params && self.compatible_within(a.result, b.result, comparison)
            }
            (&Type::Record(a), &Type::Record(b)) => self.same_record(a, b, comparison),
            _ => false,
        }
    }

    /// True if two records are the same one, declared in two sources.
    fn same_record(&self, a: RecordId, b: RecordId, comparison: &mut Comparison) -> bool {
        let (x, y) = (&self.records[a], &self.records[b]);
        if x.span != y.span && x.unit == y.unit || x.tag != y.tag || x.union != y.union {
            return false;
        }
        // Members lead back to the records that they are of.
        let known = !comparison.assumed.insert((a, b));
        if known || comparison.assumed.len() > MAX_COMPARED {
            return true;
        }
        let (Some(f), Some(g)) = (&x.fields, &y.fields) else {
            return true;
        };
        let pairs = f.iter().zip(g);
        let mut differs = pairs.map(|(f, g)| {
            f.name != g.name
                || f.ty.quals != g.ty.quals
                || f.bits != g.bits
                || !self.compatible_within(f.ty.ty, g.ty.ty, comparison)
                || f.offset != g.offset
        });
        let member = differs.position(|differs| differs);
        let member = member.or((f.len() != g.len()).then_some(f.len().min(g.len())));
        let whole = member.is_none() && (x.size != y.size || x.align != y.align);
        if member.is_some() || whole {
            // The innermost record is compared to its end first.
            comparison.difference.get_or_insert(Difference {
                records: (a, b),
                member,
            });
        }
        member.is_none() && !whole
    }
}
