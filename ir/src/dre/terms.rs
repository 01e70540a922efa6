//! How constants, positions, types, names of values and bytes are written in attributes.

use super::element::{Element, ElementExt, Read, Text, hint};
use crate::program::{Bits, Pos, SourceFile};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::xml::tree::{Tag, Writer};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Bytes in one element of data.
const BYTES_A_LINE: usize = 32;

/// Most bytes that a file may describe, so that a small file does not ask for all memory.
const MAX_DATA: usize = 256 << 20;

/// Files, without which positions mean nothing.
pub(super) type Files = EntityMap<SourceFile, String>;

/// `file:line:column`, files by number; nothing for no position.
pub(crate) fn pos(pos: Pos) -> Option<String> {
    let Pos { file, line, column } = pos;
    (pos != Pos::nowhere()).then(|| format!("{}:{line}:{column}", file.index()))
}

/// The position in attribute `name`.
pub(super) fn read_pos(element: &Element<'_>, name: &str, files: &Files) -> Read<Pos> {
    let Some(text) = element.optional(name) else {
        return Ok(Pos::nowhere());
    };
    let parts: Vec<Text<'_>> = text.split(|c| c == ':').collect();
    let [file, line, column] = parts[..] else {
        return text.fault(format!(
            "`{}` is not a position, which is file:line:column, the file by its number",
            text.text
        ));
    };
    let number = file.u32()? as usize;
    if number >= files.len() && files.len() + number > 0 {
        return file.fault(format!(
            "there is no file {number}; the file lists {}",
            files.len()
        ));
    }
    Ok(Pos {
        file: SourceFile::new(number),
        line: line.u32()?,
        column: column.u32()?,
    })
}

pub(super) fn write_files(xml: &mut Writer, files: &Files) {
    for name in files.values() {
        xml.leaf(Tag::new("file").attr("name", name));
    }
}

pub(super) fn read_files(root: &Element<'_>) -> Read<Files> {
    let files = root.children.iter().filter(|c| c.name == "file");
    let mut names = Files::new();
    for file in files {
        file.only(&["name"])?;
        names.push(file.required("name")?.text.to_owned());
    }
    Ok(names)
}

pub(super) fn read_bits(text: Text<'_>) -> Read<Bits> {
    match text.text {
        "true" => return Ok(Bits::Pred(true)),
        "false" => return Ok(Bits::Pred(false)),
        _ => {}
    }
    let lanes: Vec<Text<'_>> = text.split(|c| c == ':').collect();
    match lanes[..] {
        [word] => Ok(Bits::Word(word.u32()?)),
        [a, b, c, d] => Ok(Bits::Vec([a.u32()?, b.u32()?, c.u32()?, d.u32()?])),
        _ => text.fault(format!(
            "`{}` is not a constant: `true`, a number, or four numbers with `:` in between",
            text.text
        )),
    }
}

/// True if a term can only be a constant.
pub(super) fn is_bits(text: Text<'_>) -> bool {
    text.text.starts_with(|c: char| c.is_ascii_digit()) || matches!(text.text, "true" | "false")
}

pub(super) fn read_ty(text: Text<'_>) -> Read<Ty> {
    match Ty::parse(text.text) {
        Some(ty) => Ok(ty),
        None => text.fault(format!(
            "`{}` is not a type: `p` (predicate), `w` (word) or `v` (vector)",
            text.text
        )),
    }
}

pub(super) fn read_op(text: Text<'_>) -> Read<Opcode> {
    match Opcode::parse(text.text) {
        Some(op) => Ok(op),
        None => {
            let names: Vec<&str> = Opcode::ALL.iter().map(|op| op.name()).collect();
            let near = srp_archdesc::nearest::nearest(text.text, names);
            let near = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
            text.fault(format!("there is no operation `{}`{near}", text.text))
        }
    }
}

/// The immediate in attribute `imm`; 0 where there is none.
pub(super) fn read_imm(element: &Element<'_>) -> Read<i32> {
    element.optional("imm").map_or(Ok(0), Text::i32)
}

/// The immediate, where it says something.
pub(super) fn imm(op: Opcode, imm: i32) -> Option<i32> {
    (op.info().immediate || imm != 0).then_some(imm)
}

/// Names in a file and what they stand for, numbered as they come.
pub(super) struct Names<E> {
    what: &'static str,
    known: BTreeMap<String, E>,
}

impl<E: Entity> Names<E> {
    pub(super) fn new(what: &'static str) -> Names<E> {
        Names {
            what,
            known: BTreeMap::new(),
        }
    }

    /// Makes the name stand for the next entity.
    pub(super) fn define(&mut self, name: Text<'_>) -> Read<E> {
        let entity = E::new(self.known.len());
        if self.known.insert(name.text.to_owned(), entity).is_some() {
            return name.fault(format!("{} `{}` is defined twice", self.what, name.text));
        }
        Ok(entity)
    }

    pub(super) fn get(&self, name: Text<'_>) -> Read<E> {
        match self.known.get(name.text) {
            Some(entity) => Ok(*entity),
            None => {
                let names: Vec<&str> = self.known.keys().map(String::as_str).collect();
                let hint = if names.is_empty() || names.len() > 8 {
                    let near = srp_archdesc::nearest::nearest(name.text, names);
                    near.map_or(String::new(), |n| format!("; did you mean `{n}`?"))
                } else {
                    hint(name.text, &names)
                };
                name.fault(format!("there is no {} `{}`{hint}", self.what, name.text))
            }
        }
    }

    pub(super) fn get_all<'a>(&self, names: impl Iterator<Item = Text<'a>>) -> Read<Vec<E>> {
        names.map(|name| self.get(name)).collect()
    }
}

/// Bytes, a line at a time; long stretches of zeros as their number.
pub(super) fn write_bytes(xml: &mut Writer, bytes: &[u8]) {
    let mut zeros = 0;
    for line in bytes.chunks(BYTES_A_LINE) {
        if line.len() == BYTES_A_LINE && line.iter().all(|b| *b == 0) {
            zeros += line.len();
            continue;
        }
        write_zeros(xml, &mut zeros);
        let mut hex = String::with_capacity(2 * line.len());
        for byte in line {
            let _ = write!(hex, "{byte:02x}");
        }
        xml.leaf(Tag::new("bytes").attr("hex", hex));
    }
    write_zeros(xml, &mut zeros);
}

fn write_zeros(xml: &mut Writer, zeros: &mut usize) {
    if *zeros > 0 {
        xml.leaf(Tag::new("zeros").attr("count", *zeros));
        *zeros = 0;
    }
}

/// Appends the bytes of a `<bytes>` or `<zeros>`; false if it is neither.
pub(super) fn read_bytes(element: &Element<'_>, bytes: &mut Vec<u8>) -> Read<bool> {
    match element.name {
        "bytes" => {
            element.only(&["hex"])?;
            let hex = element.required("hex")?;
            let digits: Option<Vec<u8>> = hex
                .text
                .chars()
                .map(|c| c.to_digit(16).map(|d| d as u8))
                .collect();
            match digits {
                Some(digits) if digits.len() % 2 == 0 => {
                    bytes.extend(digits.chunks(2).map(|pair| pair[0] << 4 | pair[1]));
                }
                _ => return hex.fault("two hexadecimal digits a byte are needed"),
            }
        }
        "zeros" => {
            element.only(&["count"])?;
            let count = element.required("count")?;
            let total = bytes.len() + count.u32()? as usize;
            if total > MAX_DATA {
                return count.fault(format!("more than {} MiB of data", MAX_DATA >> 20));
            }
            bytes.resize(total, 0);
        }
        _ => return Ok(false),
    }
    Ok(true)
}
