//! A program to its listing.

use crate::program::*;
use srp_archdesc::isa::Ty;
use std::fmt::Write;

/// Bytes of a global's initial value on one line.
const HEX_BYTES: usize = 32;

/// The listing of a program.
pub fn write(program: &Program) -> String {
    let mut writer = Writer {
        program,
        out: String::new(),
    };
    for (file, name) in program.files.iter() {
        writer.line(format_args!("{file} {}", quoted(name)), Pos::nowhere());
    }
    if let Some(main) = program.main {
        writer.line(format_args!("main {main}"), Pos::nowhere());
    }
    for (global, data) in program.globals.iter() {
        writer.global(global, data);
    }
    for (id, func) in program.funcs.iter() {
        writer.function(id, func);
    }
    writer.out
}

/// One instruction as its line in the listing, without the position.
pub fn show_inst(func: &Function, inst: &InstData) -> String {
    let mut out = String::new();
    if !inst.results.is_empty() {
        // The opcode tells the type of its result; calls and launches have to.
        let typed = matches!(inst.kind, InstKind::Call { .. } | InstKind::Launch { .. });
        let results = list(&inst.results, |&v| match typed {
            true => typed_value(func, v),
            false => v.to_string(),
        });
        out = format!("{results} = ");
    }
    out + &show_kind(&inst.kind)
}

fn show_kind(kind: &InstKind) -> String {
    match kind {
        InstKind::Const(bits) => format!("const {bits}"),
        InstKind::Op { op, args, imm } => {
            let mut text = op.to_string();
            if !args.is_empty() {
                text += " ";
                text += &list(args, Value::to_string);
            }
            text + &offset(" ", *imm)
        }
        InstKind::SymbolAddr(symbol, at) => format!("symbol {}{}", show(*symbol), offset("", *at)),
        InstKind::SlotAddr(slot, at) => format!("slot {slot}{}", offset("", *at)),
        InstKind::Call { callee, args } => {
            let args = list(args, Value::to_string);
            match callee {
                Callee::Func(func) => format!("call {func}({args})"),
                Callee::Indirect(target, _) => format!("call {target}({args})"),
            }
        }
        InstKind::Launch { kernel, args } => {
            format!("launch {kernel}({})", list(args, Value::to_string))
        }
    }
}

fn show(symbol: Symbol) -> String {
    match symbol {
        Symbol::Global(global) => global.to_string(),
        Symbol::Func(func) => func.to_string(),
    }
}

/// `+4`, `-4`, or nothing for 0.
fn offset(before: &str, by: i32) -> String {
    match by {
        0 => String::new(),
        _ => format!("{before}{by:+}"),
    }
}

fn list<T>(items: &[T], show: impl Fn(&T) -> String) -> String {
    items.iter().map(show).collect::<Vec<_>>().join(", ")
}

fn typed_value(func: &Function, value: Value) -> String {
    format!("{value}: {}", func.values[value])
}

/// A name, bare if it is a word, else in quotes.
fn word(name: &str) -> String {
    let starts = |c: char| c.is_ascii_alphabetic() || c == '_' || c == '.';
    if name.starts_with(starts) && name.chars().all(|c| starts(c) || c.is_ascii_digit()) {
        name.to_owned()
    } else {
        quoted(name)
    }
}

fn quoted(name: &str) -> String {
    let mut out = "\"".to_owned();
    for c in name.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => write!(out, "\\u{{{:x}}}", c as u32).expect("strings take text"),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

struct Writer<'a> {
    program: &'a Program,
    out: String,
}

impl Writer<'_> {
    fn line(&mut self, text: impl std::fmt::Display, pos: Pos) {
        let start = self.out.len();
        write!(self.out, "{text}").expect("strings take text");
        if pos.line > 0 {
            // Positions stand in a column of their own where the text is short.
            let width = self.out[start..].chars().count();
            let pad = 40usize.saturating_sub(width).max(1);
            let file = match self.program.files.get(pos.file) {
                Some(name) => word_or_path(name),
                None => pos.file.to_string(),
            };
            let Pos { line, column, .. } = pos;
            write!(self.out, "{:pad$}; {file}:{line}:{column}", "").expect("strings take text");
        }
        self.out.push('\n');
    }

    fn global(&mut self, global: Global, data: &GlobalData) {
        let GlobalData { size, align, .. } = data;
        let head = format!("{global} {} size {size} align {align}", word(&data.name));
        if data.init.is_empty() && data.relocs.is_empty() {
            return self.line(head, data.pos);
        }
        self.line(head + " {", data.pos);
        for bytes in data.init.chunks(HEX_BYTES) {
            let mut line = "  hex".to_owned();
            for word in bytes.chunks(4) {
                line.push(' ');
                for byte in word {
                    write!(line, "{byte:02x}").expect("strings take text");
                }
            }
            self.line(line, Pos::nowhere());
        }
        for Reloc {
            offset: at,
            symbol,
            addend,
        } in &data.relocs
        {
            let line = format!("  reloc {at} {}{}", show(*symbol), offset("", *addend));
            self.line(line, Pos::nowhere());
        }
        self.line("}", Pos::nowhere());
    }

    fn function(&mut self, id: Func, func: &Function) {
        let params = match func.layout.first() {
            Some(&entry) => list(&func.blocks[entry].params, |&v| typed_value(func, v)),
            None => String::new(),
        };
        let results = match func.results.as_slice() {
            [] => String::new(),
            [one] => format!(" -> {one}"),
            more => format!(" -> ({})", list(more, Ty::to_string)),
        };
        let name = word(&func.name);
        let noinline = if func.noinline { " noinline" } else { "" };
        let head = format_args!("{id} {name}({params}){results}{noinline} {{");
        self.line(head, func.pos);
        for (slot, SlotData { name, size, align }) in func.slots.iter() {
            let line = format!("  {slot} {} size {size} align {align}", word(name));
            self.line(line, Pos::nowhere());
        }
        for (i, &block) in func.layout.iter().enumerate() {
            self.block(func, block, i == 0);
        }
        self.line("}", Pos::nowhere());
    }

    fn block(&mut self, func: &Function, block: Block, is_entry: bool) {
        let data = &func.blocks[block];
        let mut head = block.to_string();
        if !data.params.is_empty() && !is_entry {
            let params = list(&data.params, |&v| typed_value(func, v));
            write!(head, "({params})").expect("strings take text");
        }
        head.push(':');
        match &data.kernel {
            Some(mark) => {
                let required = if mark.required { " required" } else { "" };
                let nest = if mark.nest { " nest" } else { "" };
                let name = word(&mark.name);
                let restrict = match &mark.restrict[..] {
                    [] => String::new(),
                    numbers => format!(" restrict {}", list(numbers, u32::to_string)),
                };
                let slower = mark
                    .slower
                    .map(|e| format!(" slower {} {} {}", e.iterations, e.array, e.vliw));
                let slower = slower.unwrap_or_default();
                let mut independent = String::new();
                if mark.independence.all {
                    independent.push_str(" ivdep");
                }
                for group in &mark.independence.groups {
                    independent += &format!(" independent {}", list(group, u32::to_string));
                }
                let text = format_args!(
                    "{head} kernel {name}{required}{nest}{restrict}{slower}{independent}"
                );
                self.line(text, mark.pos);
            }
            None => self.line(head, Pos::nowhere()),
        }
        for &inst in &data.insts {
            let inst = &func.insts[inst];
            self.line(format_args!("  {}", show_inst(func, inst)), inst.pos);
        }
        self.line(format_args!("  {}", show_end(&data.end)), data.end_pos);
    }
}

fn show_end(end: &Terminator) -> String {
    let target = |t: &Target| match t.args.as_slice() {
        [] => t.block.to_string(),
        args => format!("{}({})", t.block, list(args, Value::to_string)),
    };
    match end {
        Terminator::Jump(to) => format!("jump {}", target(to)),
        Terminator::Branch { cond, then, other } => {
            format!("br {cond}, {}, {}", target(then), target(other))
        }
        Terminator::Return(values) if values.is_empty() => "ret".to_owned(),
        Terminator::Return(values) => format!("ret {}", list(values, Value::to_string)),
        Terminator::Unreachable => "unreachable".to_owned(),
    }
}

/// A file's name in a position: bare where it has nothing that would end it.
fn word_or_path(name: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_./-+".contains(c);
    if !name.is_empty() && name.chars().all(plain) {
        name.to_owned()
    } else {
        quoted(name)
    }
}
