//! The names that a scheduled program has for the parts of its machine.

use super::element::{Element, ElementExt, Read, Text, hint};
use super::scheduled::{Reg, RegAt, Source, Src};
use super::terms::{self, Names};
use srp_archdesc::arch::{Arch, Fu, Input, Link, RegFile, Wire};
use srp_archdesc::entity::EntityMap;
use std::collections::BTreeMap;

/// A machine with its names both ways.
///
/// Links have no names of their own: one is `from->to`, and where several lead the same way the
/// second is `from->to#2`. An operand from a wire is `wire:name`.
pub(super) struct Machine<'a> {
    pub(super) arch: &'a Arch,
    links: EntityMap<Link, String>,
    fu_of: BTreeMap<&'a str, Fu>,
    file_of: BTreeMap<&'a str, RegFile>,
    link_of: BTreeMap<String, Link>,
    wire_of: BTreeMap<&'a str, Wire>,
}

/// What stands before a wire's name where an operand is taken from it.
const WIRE: &str = "wire:";

impl<'a> Machine<'a> {
    pub(super) fn of(arch: &'a Arch) -> Machine<'a> {
        let mut machine = Machine {
            arch,
            links: EntityMap::new(),
            fu_of: arch
                .srp
                .fus
                .iter()
                .map(|(fu, s)| (&s.name[..], fu))
                .collect(),
            file_of: arch
                .srp
                .files
                .iter()
                .map(|(f, s)| (&s.name[..], f))
                .collect(),
            link_of: BTreeMap::new(),
            wire_of: arch
                .srp
                .wires
                .iter()
                .map(|(wire, s)| (&s.name[..], wire))
                .collect(),
        };
        let mut parallel: BTreeMap<(Fu, Fu), u32> = BTreeMap::new();
        for (link, spec) in arch.srp.links.iter() {
            let count = parallel.entry((spec.from, spec.to)).or_insert(0);
            *count += 1;
            let (from, to) = (&arch.srp.fus[spec.from].name, &arch.srp.fus[spec.to].name);
            let name = match *count {
                1 => format!("{from}->{to}"),
                n => format!("{from}->{to}#{n}"),
            };
            machine.link_of.insert(name.clone(), link);
            machine.links.push(name);
        }
        machine
    }

    pub(super) fn fu(&self, fu: Fu) -> &str {
        &self.arch.srp.fus[fu].name
    }

    pub(super) fn file(&self, file: RegFile) -> &str {
        &self.arch.srp.files[file].name
    }

    pub(super) fn link(&self, link: Link) -> &str {
        &self.links[link]
    }

    pub(super) fn wire(&self, wire: Wire) -> &str {
        &self.arch.srp.wires[wire].name
    }

    pub(super) fn input(&self, input: Input) -> &str {
        match input {
            Input::Unit(fu) => self.fu(fu),
            Input::Wire(wire) => self.wire(wire),
        }
    }

    /// `file[register]`.
    pub(super) fn reg(&self, reg: Reg) -> String {
        format!("{}[{}]", self.file(reg.file), reg.index)
    }

    /// `file[register]`, or `file[register%ring]`.
    pub(super) fn reg_at(&self, reg: RegAt) -> String {
        let file = self.file(reg.file);
        match reg.ring {
            1 => format!("{file}[{}]", reg.index),
            ring => format!("{file}[{}%{ring}]", reg.index),
        }
    }

    pub(super) fn src(&self, src: Src) -> String {
        match src {
            Src::Reg(reg) => self.reg(reg),
            Src::Const(bits) => bits.to_string(),
        }
    }

    /// A constant, `out`, a link, a wire, or a register with the iterations back that name it.
    pub(super) fn source(&self, source: Source) -> String {
        match source {
            Source::Const(bits) => bits.to_string(),
            Source::Out(None) => "out".to_owned(),
            Source::Out(Some(link)) => self.link(link).to_owned(),
            Source::Wire(wire) => format!("{WIRE}{}", self.wire(wire)),
            Source::Reg { reg, distance: 0 } => self.reg_at(reg),
            Source::Reg { reg, distance } => format!("{}@{distance}", self.reg_at(reg)),
        }
    }

    pub(super) fn read_fu(&self, text: Text<'_>) -> Read<Fu> {
        self.find("unit", &self.fu_of, text)
    }

    pub(super) fn read_file(&self, text: Text<'_>) -> Read<RegFile> {
        self.find("register file", &self.file_of, text)
    }

    pub(super) fn read_link(&self, text: Text<'_>) -> Read<Link> {
        self.find("link", &self.link_of, text)
    }

    pub(super) fn read_wire(&self, text: Text<'_>) -> Read<Wire> {
        self.find("wire", &self.wire_of, text)
    }

    /// Units and wires have no names in common.
    pub(super) fn read_input(&self, text: Text<'_>) -> Read<Input> {
        match self.wire_of.get(text.text) {
            Some(&wire) => Ok(Input::Wire(wire)),
            None => self.read_fu(text).map(Input::Unit),
        }
    }

    fn find<K: AsRef<str> + Ord + std::borrow::Borrow<str>, E: Copy>(
        &self,
        what: &str,
        known: &BTreeMap<K, E>,
        text: Text<'_>,
    ) -> Read<E> {
        match known.get(text.text) {
            Some(entity) => Ok(*entity),
            None => {
                let names: Vec<&str> = known.keys().map(AsRef::as_ref).collect();
                let near = srp_archdesc::nearest::nearest(text.text, names.iter().copied());
                let hint = match near {
                    None if names.len() > 8 => String::new(),
                    _ => hint(text.text, &names),
                };
                let machine = &self.arch.name;
                text.fault(format!(
                    "machine `{machine}` has no {what} `{}`{hint}",
                    text.text
                ))
            }
        }
    }

    /// Reads `file[index]`: the file, and the text in the brackets.
    fn read_register<'t>(&self, text: Text<'t>) -> Read<(RegFile, Text<'t>)> {
        match text.strip_suffix(']').and_then(|t| t.split_once('[')) {
            Some((file, index)) => Ok((self.read_file(file)?, index)),
            None => text.fault(format!("`{}` is not a register, `file[number]`", text.text)),
        }
    }

    fn check_index(&self, file: RegFile, last: u64, text: Text<'_>) -> Read<()> {
        let spec = &self.arch.srp.files[file];
        if last < u64::from(spec.size) {
            return Ok(());
        }
        text.fault(format!(
            "`{}` has {} registers, so there is no register {last}",
            spec.name, spec.size
        ))
    }

    pub(super) fn read_reg(&self, text: Text<'_>) -> Read<Reg> {
        let (file, number) = self.read_register(text)?;
        let index = number.u32()?;
        self.check_index(file, index.into(), number)?;
        Ok(Reg { file, index })
    }

    pub(super) fn read_reg_at(&self, text: Text<'_>) -> Read<RegAt> {
        let (file, inside) = self.read_register(text)?;
        let (number, ring) = match inside.split_once('%') {
            Some((number, ring)) => (number, ring.u32()?),
            None => (inside, 1),
        };
        if ring == 0 {
            return inside.fault("a ring has at least one register");
        }
        let index = number.u32()?;
        self.check_index(file, u64::from(index) + u64::from(ring) - 1, inside)?;
        Ok(RegAt { file, index, ring })
    }

    pub(super) fn read_src(&self, text: Text<'_>) -> Read<Src> {
        if terms::is_bits(text) {
            Ok(Src::Const(terms::read_bits(text)?))
        } else {
            Ok(Src::Reg(self.read_reg(text)?))
        }
    }

    pub(super) fn read_source(&self, text: Text<'_>) -> Read<Source> {
        if terms::is_bits(text) {
            return Ok(Source::Const(terms::read_bits(text)?));
        }
        if text.text == "out" {
            return Ok(Source::Out(None));
        }
        if text.text.starts_with(WIRE) {
            let name = text.piece(WIRE.len(), text.text.len());
            return Ok(Source::Wire(self.read_wire(name)?));
        }
        if text.text.contains("->") {
            return Ok(Source::Out(Some(self.read_link(text)?)));
        }
        let (reg, distance) = match text.split_once('@') {
            Some((reg, distance)) => (reg, distance.u32()?),
            None => (text, 0),
        };
        let reg = self.read_reg_at(reg)?;
        Ok(Source::Reg { reg, distance })
    }
}

/// Names of one kind, from attribute `id` of the elements called `name`.
pub(super) fn ids<E: srp_archdesc::entity::Entity>(
    what: &'static str,
    elements: &[Element<'_>],
    name: &str,
    attribute: &str,
) -> Read<Names<E>> {
    let mut names = Names::new(what);
    for element in elements.iter().filter(|e| e.name == name) {
        names.define(element.required(attribute)?)?;
    }
    Ok(names)
}
