//! The interface of a program: its functions and objects with their types, and what pragmas say of their
//! values. For those who call functions of sources that they have not written.

use crate::check::{Sources, check};
use crate::ctype::{QualType, Type, TypeId, TypeTable};
use crate::library::Archive;
use crate::message::Messages;
use crate::options::Options;
use crate::parse::parse;
use crate::source::SourceMap;
use crate::typed::Checked;
use crate::{Compilation, ast};
use srp_archdesc::diagnostic::{Diagnostic, Source};
use srp_ir::program::Pos;

/// The functions and objects that a program defines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interface {
    /// Functions, but for those of the library.
    pub functions: Vec<Function>,
    /// Objects with static storage.
    pub objects: Vec<Object>,
    /// The ranges that `#pragma srp range(name, low, high)` states, in the order of the text.
    pub ranges: Vec<StatedRange>,
}

/// A function.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// Its parameters.
    pub params: Vec<(String, Shape)>,
    /// Its result.
    pub result: Shape,
    /// The file that defines it.
    pub file: String,
    /// The line of its definition.
    pub line: u32,
}

/// An object with static storage.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its name.
    pub name: String,
    /// Its type.
    pub shape: Shape,
    /// True when it is `const`.
    pub constant: bool,
}

/// A type, as far as numbers are concerned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Shape {
    /// No value.
    Void,
    /// An integer of 32 bits or fewer.
    Integer,
    /// A float.
    Float,
    /// A pointer to numbers of this shape.
    Pointer {
        /// The type that it points to.
        to: Box<Shape>,
        /// True when that is `const`.
        constant: bool,
        /// True when it lies in system memory.
        global: bool,
    },
    /// An array of so many numbers in all.
    Array(Box<Shape>, u32),
    /// Anything else, as C writes it.
    Other(String),
}

/// The range that a pragma states for the values of a parameter or object.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedRange {
    /// Its name.
    pub name: String,
    /// The least value.
    pub low: f64,
    /// The greatest value.
    pub high: f64,
    /// The file that says it.
    pub file: String,
    /// The line.
    pub line: u32,
}

/// The interface of a program.
///
/// # Errors
///
/// All that is wrong with the sources.
pub fn interface(sources: &[Source], options: &Options<'_>) -> Result<Interface, Vec<Diagnostic>> {
    let Compilation { map, checked, .. } = compilation(sources, options)?;
    let name = |pos: Pos| map.name(pos.file).to_owned();
    let functions = checked.functions.values().filter(|f| !f.optional);
    let functions = functions.filter_map(|function| {
        let body = function.body.as_ref()?;
        let Type::Function(signature) = checked.types.get(function.ty) else {
            return None;
        };
        let param = |&local: &_| {
            let local = &body.locals[local];
            (local.name.to_string(), shape(&checked.types, local.ty.ty))
        };
        Some(Function {
            name: function.name.clone(),
            params: body.params.iter().map(param).collect(),
            result: shape(&checked.types, signature.result),
            file: name(function.pos),
            line: function.pos.line,
        })
    });
    let objects = checked
        .objects
        .values()
        .filter(|o| o.defined && !o.optional);
    let objects = objects.map(|object| Object {
        name: object.name.clone(),
        shape: shape(&checked.types, object.ty.ty),
        constant: is_constant(&checked, object.ty),
    });
    let ranges = map.ranges.iter().map(|range| {
        let pos = map.pos(range.span);
        StatedRange {
            name: range.name.clone(),
            low: range.low,
            high: range.high,
            file: name(pos),
            line: pos.line,
        }
    });
    Ok(Interface {
        functions: functions.collect(),
        objects: objects.collect(),
        ranges: ranges.collect(),
    })
}

fn is_constant(checked: &Checked, ty: QualType) -> bool {
    match checked.types.get(ty.ty) {
        Type::Array(of, _) => ty.quals.constant || is_constant(checked, *of),
        _ => ty.quals.constant,
    }
}

fn shape(types: &TypeTable, id: TypeId) -> Shape {
    match types.get(id) {
        Type::Void => Shape::Void,
        Type::Float => Shape::Float,
        Type::Bool => Shape::Integer,
        Type::Int(int) if int.size() <= 4 => Shape::Integer,
        Type::Pointer(to) => Shape::Pointer {
            to: Box::new(shape(types, to.ty)),
            constant: to.quals.constant,
            global: to.quals.global,
        },
        Type::Array(of, Some(length)) => match shape(types, of.ty) {
            Shape::Array(of, inner) => Shape::Array(of, inner * length),
            of => Shape::Array(Box::new(of), *length),
        },
        _ => Shape::Other(types.show_plain(id)),
    }
}

/// Parses and checks sources, and what they use of the library; or says all that is wrong with them.
pub(crate) fn compilation(
    sources: &[Source],
    options: &Options<'_>,
) -> Result<Compilation, Vec<Diagnostic>> {
    let mut map = SourceMap::new();
    let mut messages = Messages::new();
    let units: Vec<_> = sources
        .iter()
        .map(|source| parse(source, options, &mut map, &mut messages))
        .collect();
    let mut archive = Archive::of(&units, options.software());
    let mut library: Vec<ast::Unit> = Vec::new();
    while let Some(source) = archive.next(library.last()) {
        library.push(parse(&source, options, &mut map, &mut messages));
    }
    let program = Sources {
        units: &units,
        library: &library,
        owned: &archive.owned,
        map: &map,
    };
    match check(&program, options, &mut messages) {
        Some(checked) => Ok(Compilation {
            map,
            messages,
            checked,
        }),
        None => Err(messages.into_list()),
    }
}
