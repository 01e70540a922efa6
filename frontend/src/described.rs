//! The types, variables and scopes of a checked program for a debugger: [`Described`].

use crate::ctype::{self, Int, TypeId, TypeTable};
use crate::interface::compilation;
use crate::lower::{Places, lower_with_places};
use crate::options::Options;
use crate::source::SourceMap;
use crate::typed::{Body, Checked, FunctionId, LocalId, PlaceKind, StmtId, StmtKind};
use crate::{Compilation, typed};
use srp_archdesc::diagnostic::{Diagnostic, Source, Span};
use srp_archdesc::entity::Entity;
use srp_ir::Program;
use srp_ir::described::{Described, Field, Kind, Type, Variable};
use srp_ir::program::{Func, Pos};
use std::collections::BTreeMap;

/// A program with warnings, and with what a debugger has to know of its source.
pub type WithDescription = (Program, Vec<Diagnostic>, Described);

/// [`compile`](crate::compile), with what a debugger has to know of the source.
///
/// # Errors
///
/// All that is wrong with the sources.
pub fn compile_described(
    sources: &[Source],
    options: &Options<'_>,
) -> Result<WithDescription, Vec<Diagnostic>> {
    let Compilation {
        map,
        messages,
        checked,
    } = compilation(sources, options)?;
    let (program, places) = lower_with_places(&checked, options);
    let described = describe(&checked, &map, &places);
    Ok((program, messages.into_list(), described))
}

fn describe(
    checked: &Checked,
    map: &SourceMap,
    places: &[(Func, FunctionId, Places)],
) -> Described {
    let types = &checked.types;
    let objects = checked.objects.values();
    let mut described = Described {
        types: types.ids().map(|id| described_type(types, id)).collect(),
        objects: objects.map(|o| (o.name.clone(), o.ty.ty.index())).collect(),
        ..Described::default()
    };
    for (func, id, places) in places {
        let function = &checked.functions[*id];
        if let Some(body) = &function.body {
            let mut scopes = Scopes {
                body,
                map,
                found: BTreeMap::new(),
                steps: Vec::new(),
            };
            scopes.find(function);
            let steps = body.exprs.values().filter(|e| scopes.is_in_step(e.span));
            described.steps.extend(steps.map(|e| e.pos));
            for ((local, data), slots) in body.locals.iter().zip(places) {
                let Some(&(from, to)) = scopes.found.get(&local) else {
                    continue;
                };
                described.variables.push(Variable {
                    name: data.name.to_string(),
                    ty: data.ty.ty.index(),
                    func: *func,
                    is_param: body.params.contains(&local),
                    from,
                    to,
                    slots: slots.clone(),
                });
            }
        }
    }
    described
}

fn described_type(types: &TypeTable, id: TypeId) -> Type {
    let integer = |signed, is_bool, is_char| Kind::Integer {
        signed,
        is_bool,
        is_char,
    };
    let kind = match types.get(id) {
        ctype::Type::Bool => integer(false, true, false),
        ctype::Type::Int(int) => {
            let is_char = matches!(int, Int::Char | Int::SChar | Int::UChar);
            integer(int.signed(), false, is_char)
        }
        ctype::Type::Float => Kind::Float,
        ctype::Type::Double => Kind::Double,
        ctype::Type::Vector(float) => {
            let lane = if *float {
                types.known.float
            } else {
                types.known.int
            };
            let lane = lane.index();
            Kind::Vector { lane }
        }
        ctype::Type::Pointer(to) => Kind::Pointer { to: to.ty.index() },
        ctype::Type::Array(of, length) => Kind::Array {
            of: of.ty.index(),
            length: length.unwrap_or(0),
        },
        ctype::Type::Record(record) => {
            let fields = types.record(*record).fields.iter().flatten();
            let field = |field: &ctype::Field| Field {
                name: field.name.as_ref().map_or(String::new(), |n| n.to_string()),
                ty: field.ty.ty.index(),
                offset: field.offset,
                bits: field.bits.map(|b| (b.unit, b.shift, b.width)),
            };
            Kind::Record(fields.map(field).collect())
        }
        ctype::Type::Void | ctype::Type::Function(_) | ctype::Type::Error => Kind::Opaque,
    };
    Type {
        name: types.show_plain(id),
        size: types.size(id).unwrap_or(0),
        kind,
    }
}

/// Where the variables of a function can be named.
struct Scopes<'a> {
    body: &'a Body,
    map: &'a SourceMap,
    /// The place of the declaration, and the last line.
    found: BTreeMap<LocalId, (Pos, u32)>,
    /// The steps of `for` loops.
    steps: Vec<Span>,
}

/// Variables that are declared, and whose scope goes on.
type Open = Vec<(LocalId, Pos)>;

impl Scopes<'_> {
    fn find(&mut self, function: &typed::Function) {
        let mut last = function.pos.line;
        if let Some(root) = self.body.root {
            let (line, open) = self.walk(root);
            last = line;
            self.close(open, last);
        }
        for &param in &self.body.params {
            self.found.insert(param, (function.pos, last));
        }
        // What is declared without a value begins where it is used first.
        for place in self.body.places.values() {
            let (PlaceKind::Local(local), pos) = (&place.kind, self.map.pos(place.span)) else {
                continue;
            };
            if pos.file == function.pos.file {
                let scope = self.found.entry(*local).or_insert((pos, pos.line));
                scope.0 = scope.0.min(pos);
                scope.1 = scope.1.max(pos.line);
            }
        }
    }

    fn close(&mut self, open: Open, last: u32) {
        for (local, from) in open {
            self.found.insert(local, (from, last));
        }
    }

    fn is_in_step(&self, span: Span) -> bool {
        let mut steps = self.steps.iter();
        steps.any(|step| step.start <= span.start && span.end <= step.end)
    }

    /// The last line of a statement, and what it declares for those after it.
    fn walk(&mut self, stmt: StmtId) -> (u32, Open) {
        let data = &self.body.stmts[stmt];
        let mut last = data.pos.line;
        let mut open = Open::new();
        let (body, map) = (self.body, self.map);
        let mut ends = |expr: typed::ExprId| {
            let span = body.exprs[expr].span;
            let end = Span {
                start: span.end,
                ..span
            };
            last = last.max(map.pos(end).line);
        };
        match &data.kind {
            StmtKind::Expr(expr) | StmtKind::Return(Some(expr)) => ends(*expr),
            StmtKind::Init(local, init) => {
                init.parts.iter().for_each(|part| ends(part.value));
                open.push((*local, data.pos));
            }
            StmtKind::Block(list) => {
                let is_init = |s: &StmtId| matches!(body.stmts[*s].kind, StmtKind::Init(..));
                let only_declares = list.iter().all(is_init);
                for &inner in list {
                    let (line, declared) = self.walk(inner);
                    last = last.max(line);
                    open.extend(declared);
                }
                if !only_declares {
                    self.close(std::mem::take(&mut open), last);
                }
            }
            StmtKind::If(cond, then, other) => {
                ends(*cond);
                for inner in std::iter::once(*then).chain(*other) {
                    last = last.max(self.inner(inner));
                }
            }
            StmtKind::Loop(data) => {
                data.cond.into_iter().chain(data.step).for_each(&mut ends);
                self.steps
                    .extend(data.step.map(|step| body.exprs[step].span));
                let declared = data.init.map(|init| self.walk(init).1);
                last = last.max(self.inner(data.body));
                self.close(declared.unwrap_or_default(), last);
            }
            StmtKind::Switch(data) => {
                ends(data.value);
                last = last.max(self.inner(data.body));
            }
            StmtKind::Label(_) | StmtKind::Target(_) | StmtKind::Goto(_) => {}
            StmtKind::Break | StmtKind::Continue | StmtKind::Return(None) => {}
        }
        (last, open)
    }

    fn inner(&mut self, stmt: StmtId) -> u32 {
        let (last, open) = self.walk(stmt);
        self.close(open, last);
        last
    }
}
