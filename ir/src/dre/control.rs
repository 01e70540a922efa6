//! Control code as XML: globals, functions, blocks, instructions.

use super::element::{Element, ElementExt, Read, Text};
use super::terms::{self, Files, Names};
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_archdesc::xml::tree::{Tag, Writer};

/// The kernels' names, which launches use.
pub(super) type KernelNames<'a> = &'a dyn Fn(Kernel) -> String;

pub(super) fn write_program(xml: &mut Writer, program: &Program, kernels: KernelNames<'_>) {
    for global in program.globals.values() {
        write_global(xml, program, global);
    }
    for (func, data) in program.funcs.iter() {
        let is_main = program.main == Some(func);
        write_function(xml, program, data, is_main, kernels);
    }
}

fn symbol_attr(tag: Tag, program: &Program, symbol: Symbol) -> Tag {
    match symbol {
        Symbol::Global(global) => tag.attr("global", &program.globals[global].name),
        Symbol::Func(func) => tag.attr("function", &program.funcs[func].name),
    }
}

fn write_global(xml: &mut Writer, program: &Program, data: &GlobalData) {
    let tag = Tag::new("global")
        .attr("name", &data.name)
        .attr("size", data.size)
        .attr("align", data.align)
        .attr_if("at", terms::pos(data.pos));
    if data.init.is_empty() && data.relocs.is_empty() {
        xml.leaf(tag);
        return;
    }
    xml.open(tag);
    terms::write_bytes(xml, &data.init);
    for reloc in &data.relocs {
        let tag = Tag::new("reloc").attr("offset", reloc.offset);
        xml.leaf(symbol_attr(tag, program, reloc.symbol).attr("addend", reloc.addend));
    }
    xml.close();
}

fn write_function(
    xml: &mut Writer,
    program: &Program,
    func: &Function,
    is_main: bool,
    kernels: KernelNames<'_>,
) {
    xml.open(
        Tag::new("function")
            .attr("name", &func.name)
            .list("results", &func.results)
            .attr_if("main", is_main.then_some(true))
            .attr_if("at", terms::pos(func.pos)),
    );
    for (slot, data) in func.slots.iter() {
        xml.leaf(
            Tag::new("slot")
                .attr("id", slot)
                .attr("name", &data.name)
                .attr("size", data.size)
                .attr("align", data.align),
        );
    }
    for &block in &func.layout {
        let data = &func.blocks[block];
        let mark = data.kernel.as_ref();
        xml.open(
            Tag::new("block")
                .attr("id", block)
                .list("params", typed(func, &data.params))
                .attr_if("kernel", mark.map(|m| &m.name))
                .attr_if("kernel-at", mark.and_then(|m| terms::pos(m.pos)))
                .attr_if("required", mark.map(|m| m.required)),
        );
        for &inst in &data.insts {
            write_inst(xml, program, func, &func.insts[inst], kernels);
        }
        write_end(xml, data);
        xml.close();
    }
    xml.close();
}

/// Values with their types, where they are defined.
fn typed<'a>(func: &'a Function, values: &'a [Value]) -> impl Iterator<Item = String> + 'a {
    values.iter().map(|v| format!("{v}:{}", func.values[*v]))
}

fn write_inst(
    xml: &mut Writer,
    program: &Program,
    func: &Function,
    data: &InstData,
    kernels: KernelNames<'_>,
) {
    let with_results = |tag: Tag| tag.list("out", typed(func, &data.results));
    let tag = match &data.kind {
        InstKind::Const(bits) => with_results(Tag::new("const")).attr("value", bits),
        InstKind::Op { op, args, imm } => with_results(Tag::new("op").attr("op", op))
            .list("args", args)
            .attr_if("imm", terms::imm(*op, *imm)),
        InstKind::SymbolAddr(symbol, offset) => {
            let tag = with_results(Tag::new("address"));
            symbol_attr(tag, program, *symbol).attr("offset", offset)
        }
        InstKind::SlotAddr(slot, offset) => with_results(Tag::new("address"))
            .attr("slot", slot)
            .attr("offset", offset),
        InstKind::Call { callee, args } => {
            let tag = match callee {
                Callee::Func(f) => Tag::new("call").attr("function", &program.funcs[*f].name),
                Callee::Indirect(target, _) => Tag::new("call").attr("target", target),
            };
            let tag = with_results(tag).list("args", args);
            match callee {
                Callee::Indirect(_, tys) => tag.list("results", tys),
                Callee::Func(_) => tag,
            }
        }
        InstKind::Launch { kernel, args } => {
            let tag = Tag::new("launch").attr("kernel", kernels(*kernel));
            with_results(tag).list("args", args)
        }
    };
    xml.leaf(tag.attr_if("at", terms::pos(data.pos)));
}

fn write_end(xml: &mut Writer, block: &BlockData) {
    let to = |target: &Target| {
        let args: Vec<String> = target.args.iter().map(Value::to_string).collect();
        format!("{}({})", target.block, args.join(" "))
    };
    let tag = match &block.end {
        Terminator::Jump(target) => Tag::new("jump").attr("to", to(target)),
        Terminator::Branch { cond, then, other } => Tag::new("branch")
            .attr("if", cond)
            .attr("then", to(then))
            .attr("else", to(other)),
        Terminator::Return(values) => Tag::new("return").list("values", values),
        Terminator::Unreachable => Tag::new("unreachable"),
    };
    xml.leaf(tag.attr_if("at", terms::pos(block.end_pos)));
}

/// Names that hold in the whole program.
struct Globals {
    files: Files,
    globals: Names<Global>,
    funcs: Names<Func>,
}

impl Globals {
    /// The symbol that the element names, if it names one.
    fn symbol(&self, element: &Element<'_>) -> Read<Option<Symbol>> {
        match (element.optional("global"), element.optional("function")) {
            (Some(name), None) => Ok(Some(Symbol::Global(self.globals.get(name)?))),
            (None, Some(name)) => Ok(Some(Symbol::Func(self.funcs.get(name)?))),
            (None, None) => Ok(None),
            (Some(_), Some(name)) => name.fault("either `global` or `function`, not both"),
        }
    }
}

/// The globals and functions among the children of `root`.
pub(super) fn read_program(
    root: &Element<'_>,
    files: Files,
    kernels: &Names<Kernel>,
) -> Read<Program> {
    let mut names = Globals {
        files,
        globals: Names::new("global"),
        funcs: Names::new("function"),
    };
    let named = |name| root.children.iter().filter(move |c| c.name == name);
    for element in named("global") {
        names.globals.define(element.required("name")?)?;
    }
    for element in named("function") {
        names.funcs.define(element.required("name")?)?;
    }
    let mut program = Program::default();
    for element in named("global") {
        program.globals.push(read_global(element, &names)?);
    }
    for element in named("function") {
        let func = program.funcs.push(read_function(element, &names, kernels)?);
        if let Some(main) = element.optional("main")
            && main.bool()?
        {
            if program.main.is_some() {
                return main.fault("a second main function");
            }
            program.main = Some(func);
        }
    }
    program.files = names.files;
    Ok(program)
}

fn read_global(element: &Element<'_>, names: &Globals) -> Read<GlobalData> {
    element.only(&["name", "size", "align", "at"])?;
    let mut data = GlobalData {
        name: element.required("name")?.text.to_owned(),
        size: element.required("size")?.u32()?,
        align: element.required("align")?.u32()?,
        init: Vec::new(),
        relocs: Vec::new(),
        pos: terms::read_pos(element, "at", &names.files)?,
    };
    for child in &element.children {
        if terms::read_bytes(child, &mut data.init)? {
            continue;
        }
        if child.name != "reloc" {
            return child.misplaced(&["bytes", "zeros", "reloc"]);
        }
        child.only(&["offset", "global", "function", "addend"])?;
        let Some(symbol) = names.symbol(child)? else {
            return child.fault("`<reloc>` needs an attribute `global` or `function`");
        };
        data.relocs.push(Reloc {
            offset: child.required("offset")?.u32()?,
            symbol,
            addend: child.required("addend")?.i32()?,
        });
    }
    Ok(data)
}

/// A function being read.
struct Reader<'a> {
    names: &'a Globals,
    kernels: &'a Names<Kernel>,
    blocks: Names<Block>,
    values: Names<Value>,
    slots: Names<Slot>,
    func: Function,
}

fn read_function(
    element: &Element<'_>,
    names: &Globals,
    kernels: &Names<Kernel>,
) -> Read<Function> {
    element.only(&["name", "results", "main", "at"])?;
    let results: Read<Vec<Ty>> = element.words("results").map(terms::read_ty).collect();
    let mut reader = Reader {
        names,
        kernels,
        blocks: Names::new("block"),
        values: Names::new("value"),
        slots: Names::new("slot"),
        func: Function {
            name: element.required("name")?.text.to_owned(),
            results: results?,
            noinline: false,
            blocks: EntityMap::new(),
            layout: Vec::new(),
            insts: EntityMap::new(),
            values: EntityMap::new(),
            slots: EntityMap::new(),
            pos: terms::read_pos(element, "at", &names.files)?,
        },
    };
    for child in &element.children {
        match child.name {
            "slot" => reader.slot(child)?,
            "block" => reader.define_block(child)?,
            _ => return child.misplaced(&["slot", "block"]),
        }
    }
    for child in element.children.iter().filter(|c| c.name == "block") {
        reader.block(child)?;
    }
    if reader.func.layout.is_empty() {
        return element.fault("a function needs a block");
    }
    Ok(reader.func)
}

impl Reader<'_> {
    fn slot(&mut self, element: &Element<'_>) -> Read<()> {
        element.only(&["id", "name", "size", "align"])?;
        self.slots.define(element.required("id")?)?;
        self.func.slots.push(SlotData {
            name: element.required("name")?.text.to_owned(),
            size: element.required("size")?.u32()?,
            align: element.required("align")?.u32()?,
        });
        Ok(())
    }

    /// Defines the names of a block, its parameters and its results.
    fn define_block(&mut self, element: &Element<'_>) -> Read<()> {
        element.only(&["id", "params", "kernel", "kernel-at", "required"])?;
        self.blocks.define(element.required("id")?)?;
        element.words("params").try_for_each(|v| self.define(v))?;
        for child in &element.children {
            child.words("out").try_for_each(|v| self.define(v))?;
        }
        Ok(())
    }

    /// Defines `name:type`.
    fn define(&mut self, text: Text<'_>) -> Read<()> {
        let Some((name, ty)) = text.split_once(':') else {
            return text.fault(format!(
                "`{}` is defined here without its type; write `{0}:w` for a word",
                text.text
            ));
        };
        self.values.define(name)?;
        self.func.values.push(terms::read_ty(ty)?);
        Ok(())
    }

    /// The values that an attribute defines.
    fn defined(&self, element: &Element<'_>, name: &str) -> Read<Vec<Value>> {
        let name_of = |text: Text<'_>| match text.split_once(':') {
            Some((name, _)) => self.values.get(name),
            None => self.values.get(text),
        };
        element.words(name).map(name_of).collect()
    }

    fn block(&mut self, element: &Element<'_>) -> Read<()> {
        let params = self.defined(element, "params")?;
        let kernel = match element.optional("kernel") {
            None => None,
            Some(name) => Some(KernelMark {
                name: name.text.to_owned(),
                pos: terms::read_pos(element, "kernel-at", &self.names.files)?,
                required: element.required("required")?.bool()?,
                slower: None,
                nest: false,
                restrict: Vec::new(),
                independence: Default::default(),
            }),
        };
        let Some((last, insts)) = element.children.split_last() else {
            return element.fault("a block needs an end: a jump, branch or return");
        };
        let mut block = BlockData {
            params,
            insts: Vec::new(),
            end: self.end(last)?,
            end_pos: terms::read_pos(last, "at", &self.names.files)?,
            kernel,
        };
        for inst in insts {
            let data = InstData {
                kind: self.inst(inst)?,
                results: self.defined(inst, "out")?,
                pos: terms::read_pos(inst, "at", &self.names.files)?,
            };
            block.insts.push(self.func.insts.push(data));
        }
        let block = self.func.blocks.push(block);
        self.func.layout.push(block);
        Ok(())
    }

    fn inst(&self, element: &Element<'_>) -> Read<InstKind> {
        let args = || self.values.get_all(element.words("args"));
        match element.name {
            "const" => {
                element.only(&["out", "value", "at"])?;
                let bits = terms::read_bits(element.required("value")?)?;
                Ok(InstKind::Const(bits))
            }
            "op" => {
                element.only(&["op", "out", "args", "imm", "at"])?;
                Ok(InstKind::Op {
                    op: terms::read_op(element.required("op")?)?,
                    args: args()?,
                    imm: terms::read_imm(element)?,
                })
            }
            "address" => self.address(element),
            "call" => {
                element.only(&["function", "target", "out", "args", "results", "at"])?;
                let callee = self.callee(element)?;
                Ok(InstKind::Call {
                    callee,
                    args: args()?,
                })
            }
            "launch" => {
                element.only(&["kernel", "out", "args", "at"])?;
                Ok(InstKind::Launch {
                    kernel: self.kernels.get(element.required("kernel")?)?,
                    args: args()?,
                })
            }
            _ => element.misplaced(&["const", "op", "address", "call", "launch"]),
        }
    }

    fn address(&self, element: &Element<'_>) -> Read<InstKind> {
        element.only(&["out", "global", "function", "slot", "offset", "at"])?;
        let offset = element.required("offset")?.i32()?;
        match (self.names.symbol(element)?, element.optional("slot")) {
            (Some(symbol), None) => Ok(InstKind::SymbolAddr(symbol, offset)),
            (None, Some(slot)) => Ok(InstKind::SlotAddr(self.slots.get(slot)?, offset)),
            _ => element.fault("`<address>` is of one thing: a `global`, `function` or `slot`"),
        }
    }

    fn callee(&self, element: &Element<'_>) -> Read<Callee> {
        match (element.optional("function"), element.optional("target")) {
            (Some(name), None) => Ok(Callee::Func(self.names.funcs.get(name)?)),
            (None, Some(target)) => {
                let tys: Read<Vec<Ty>> = element.words("results").map(terms::read_ty).collect();
                Ok(Callee::Indirect(self.values.get(target)?, tys?))
            }
            _ => element.fault("`<call>` needs either `function` or `target`"),
        }
    }

    fn end(&self, element: &Element<'_>) -> Read<Terminator> {
        match element.name {
            "jump" => {
                element.only(&["to", "at"])?;
                Ok(Terminator::Jump(self.target(element.required("to")?)?))
            }
            "branch" => {
                element.only(&["if", "then", "else", "at"])?;
                Ok(Terminator::Branch {
                    cond: self.values.get(element.required("if")?)?,
                    then: self.target(element.required("then")?)?,
                    other: self.target(element.required("else")?)?,
                })
            }
            "return" => {
                element.only(&["values", "at"])?;
                let values = self.values.get_all(element.words("values"))?;
                Ok(Terminator::Return(values))
            }
            "unreachable" => {
                element.only(&["at"])?;
                Ok(Terminator::Unreachable)
            }
            _ => element.fault(format!(
                "a block ends with `<jump>`, `<branch>`, `<return>` or `<unreachable>`, not `<{}>`",
                element.name
            )),
        }
    }

    /// `block(value value)`.
    fn target(&self, text: Text<'_>) -> Read<Target> {
        let parts = text.strip_suffix(')').and_then(|t| t.split_once('('));
        let Some((block, args)) = parts else {
            return text.fault(format!("`{}` is not `block(values)`", text.text));
        };
        Ok(Target {
            block: self.blocks.get(block)?,
            args: self.values.get_all(args.words())?,
        })
    }
}
