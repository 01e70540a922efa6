//! Checks the invariants of every [`Program`]. Shares no code with the passes, so that a mistake in
//! one is not repeated in the other.

use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Kind, Opcode, Ty};
use std::collections::BTreeMap;
use std::fmt;

mod dominance;

/// One rule that does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// The function, if it is in one.
    pub func: Option<Func>,
    /// The block, if it is in one.
    pub block: Option<Block>,
    /// The instruction, if it is one.
    pub inst: Option<Inst>,
    /// The message.
    pub message: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(func) = self.func {
            write!(f, "{func}: ")?;
        }
        if let Some(block) = self.block {
            write!(f, "{block}: ")?;
        }
        if let Some(inst) = self.inst {
            write!(f, "{inst}: ")?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for Violation {}

/// Checks all that holds of a program and lists every violation, in program order.
///
/// Of the program:
/// * names are unique and not empty: files, globals, functions, kernels;
/// * `main` exists;
/// * a global's alignment is a power of two, its initial bytes lie inside it, and its relocations
///   lie inside it, do not overlap, and name something that exists.
///
/// Of a function:
/// * the layout is not empty; it and the blocks' lists name things that exist, each once;
/// * slots are aligned to a power of two up to 16;
/// * each value is defined once, as a parameter of a block or as a result;
/// * a use of a value is dominated by its definition (in blocks that can be reached; in others it
///   only has to have one);
/// * operands, results and immediates are those of the opcode table: the immediate is 0 where there
///   is none, a lane number is below 4, a swizzle below 256, a port not negative;
/// * a constant has the type of its value; addresses are words, of things that exist;
/// * calls bring the parameters and take the results of their function;
/// * jumps bring exactly the parameters of their target, and none goes to the entry;
/// * conditions are predicates; returns bring the function's results;
/// * positions name a file that exists.
pub fn verify(program: &Program) -> Result<(), Vec<Violation>> {
    let mut found = Vec::new();
    verify_names(program, &mut found);
    verify_globals(program, &mut found);
    if let Some(main) = program.main
        && program.funcs.get(main).is_none()
    {
        found.push(whole(format!("main is {main}, which does not exist")));
    }
    check_functions(program, program.funcs.keys(), found)
}

/// The rules of functions alone, for some functions of a program that is valid otherwise.
pub(crate) fn verify_functions(
    program: &Program,
    funcs: impl Iterator<Item = Func>,
) -> Result<(), Vec<Violation>> {
    check_functions(program, funcs, Vec::new())
}

fn check_functions(
    program: &Program,
    funcs: impl Iterator<Item = Func>,
    mut found: Vec<Violation>,
) -> Result<(), Vec<Violation>> {
    for func in funcs {
        Checker::new(program, func, &mut found).check();
    }
    if found.is_empty() { Ok(()) } else { Err(found) }
}

fn whole(message: String) -> Violation {
    Violation {
        func: None,
        block: None,
        inst: None,
        message,
    }
}

fn verify_names(program: &Program, found: &mut Vec<Violation>) {
    let kernels = program.funcs.values().flat_map(|f| {
        let marks = f.layout.iter().filter_map(|&b| f.blocks.get(b));
        marks.filter_map(|b| b.kernel.as_ref().map(|k| &k.name))
    });
    unique("file", program.files.values(), found);
    unique("global", program.globals.values().map(|g| &g.name), found);
    unique("function", program.funcs.values().map(|f| &f.name), found);
    unique("kernel", kernels, found);
}

fn unique<'a>(what: &str, names: impl Iterator<Item = &'a String>, found: &mut Vec<Violation>) {
    let mut seen = BTreeMap::new();
    for name in names {
        let count: &mut u32 = seen.entry(name).or_default();
        *count += 1;
        if name.is_empty() {
            found.push(whole(format!("a {what} has no name")));
        } else if *count == 2 {
            found.push(whole(format!("two {what}s are called {name}")));
        }
    }
}

fn verify_globals(program: &Program, found: &mut Vec<Violation>) {
    for (global, data) in program.globals.iter() {
        let mut wrong = |message: String| found.push(whole(format!("{global}: {message}")));
        if !data.align.is_power_of_two() {
            wrong(format!("alignment {} is no power of two", data.align));
        }
        if data.init.len() > data.size as usize {
            let len = data.init.len();
            wrong(format!("{len} initial bytes in a size of {}", data.size));
        }
        if !file_exists(program, data.pos) {
            wrong(format!("its position names {}", data.pos.file));
        }
        let mut taken: Vec<u32> = data.relocs.iter().map(|r| r.offset).collect();
        taken.sort_unstable();
        if taken.windows(2).any(|w| w[1] - w[0] < 4) {
            wrong("relocations overlap".to_owned());
        }
        for reloc in &data.relocs {
            if u64::from(reloc.offset) + 4 > u64::from(data.size) {
                wrong(format!("relocation at {} lies outside", reloc.offset));
            }
            if !symbol_exists(program, reloc.symbol) {
                wrong(format!("relocation of {}", show_symbol(reloc.symbol)));
            }
        }
    }
}

fn file_exists(program: &Program, pos: Pos) -> bool {
    pos.line == 0 || program.files.get(pos.file).is_some()
}

fn symbol_exists(program: &Program, symbol: Symbol) -> bool {
    match symbol {
        Symbol::Global(global) => program.globals.get(global).is_some(),
        Symbol::Func(func) => program.funcs.get(func).is_some(),
    }
}

fn show_symbol(symbol: Symbol) -> String {
    match symbol {
        Symbol::Global(global) => format!("{global}, which does not exist"),
        Symbol::Func(func) => format!("{func}, which does not exist"),
    }
}

/// Where a value is defined: parameters come before the first instruction.
#[derive(Clone, Copy)]
struct Def {
    block: Block,
    /// 0 for parameters, 1 + index for instructions.
    place: usize,
}

/// The checks of one function.
struct Checker<'a> {
    program: &'a Program,
    id: Func,
    func: &'a Function,
    defs: EntityMap<Value, Option<Def>>,
    /// The blocks of the layout that exist, in order, each once.
    blocks: Vec<Block>,
    /// True for each block of `blocks`.
    present: EntityMap<Block, bool>,
    found: &'a mut Vec<Violation>,
    block: Option<Block>,
    inst: Option<Inst>,
}

impl<'a> Checker<'a> {
    fn new(program: &'a Program, id: Func, found: &'a mut Vec<Violation>) -> Self {
        let func = &program.funcs[id];
        Checker {
            program,
            id,
            func,
            defs: EntityMap::filled(func.values.len(), None),
            blocks: Vec::new(),
            present: EntityMap::filled(func.blocks.len(), false),
            found,
            block: None,
            inst: None,
        }
    }

    fn wrong(&mut self, message: impl Into<String>) {
        self.found.push(Violation {
            func: Some(self.id),
            block: self.block,
            inst: self.inst,
            message: message.into(),
        });
    }

    fn check(&mut self) {
        if self.func.layout.is_empty() {
            return self.wrong("has no blocks");
        }
        if !file_exists(self.program, self.func.pos) {
            self.wrong("its position names no file");
        }
        for (slot, data) in self.func.slots.iter() {
            if !data.align.is_power_of_two() || data.align > 16 {
                self.wrong(format!("{slot} has alignment {}", data.align));
            }
        }
        self.collect_definitions();
        let func = self.func;
        for block in self.blocks.clone() {
            self.block = Some(block);
            for &inst in &func.blocks[block].insts {
                let Some(data) = func.insts.get(inst) else {
                    continue;
                };
                self.inst = Some(inst);
                self.check_inst(data);
                self.inst = None;
            }
            self.check_end(&func.blocks[block]);
        }
        self.block = None;
        self.check_dominance();
    }

    /// Finds the blocks and the definitions, and reports those that exist twice or not at all.
    fn collect_definitions(&mut self) {
        let func = self.func;
        let mut inst_seen = EntityMap::<Inst, bool>::filled(func.insts.len(), false);
        for &block in &func.layout {
            self.block = Some(block);
            let Some(data) = func.blocks.get(block) else {
                self.wrong("does not exist");
                continue;
            };
            if std::mem::replace(&mut self.present[block], true) {
                self.wrong("is in the layout twice");
                continue;
            }
            self.blocks.push(block);
            for &param in &data.params {
                self.define(param, Def { block, place: 0 });
            }
            for (i, &inst) in data.insts.iter().enumerate() {
                self.inst = Some(inst);
                match func.insts.get(inst) {
                    None => self.wrong("does not exist"),
                    Some(_) if inst_seen[inst] => self.wrong("is listed twice"),
                    Some(inst_data) => {
                        inst_seen[inst] = true;
                        for &result in &inst_data.results {
                            let place = i + 1;
                            self.define(result, Def { block, place });
                        }
                    }
                }
                self.inst = None;
            }
        }
        self.block = None;
    }

    fn define(&mut self, value: Value, def: Def) {
        match self.defs.get(value) {
            None => self.wrong(format!("defines {value}, which does not exist")),
            Some(Some(_)) => self.wrong(format!("defines {value} a second time")),
            Some(None) => self.defs[value] = Some(def),
        }
    }

    /// The type of a used value that exists; whether it is defined is checked with dominance.
    fn ty(&self, value: Value) -> Option<Ty> {
        self.func.values.get(value).copied()
    }

    fn expect(&mut self, value: Value, ty: Ty) {
        if let Some(actual) = self.ty(value)
            && actual != ty
        {
            self.wrong(format!("{value} has type {actual}, where {ty} is expected"));
        }
    }

    fn expect_all(
        &mut self,
        what: impl fmt::Display,
        values: &[Value],
        tys: impl Iterator<Item = Ty> + Clone,
    ) {
        let (n, m) = (values.len(), tys.clone().count());
        if n != m {
            return self.wrong(format!("{what}: {n} values where {m} are expected"));
        }
        for (&value, ty) in values.iter().zip(tys) {
            self.expect(value, ty);
        }
    }

    fn check_inst(&mut self, inst: &InstData) {
        if !file_exists(self.program, inst.pos) {
            self.wrong("its position names no file");
        }
        match &inst.kind {
            InstKind::Const(bits) => {
                self.expect_all("result", &inst.results, [bits.ty()].into_iter())
            }
            InstKind::Op { op, args, imm } => self.check_op(*op, args, *imm, &inst.results),
            InstKind::SymbolAddr(symbol, _) => {
                if !symbol_exists(self.program, *symbol) {
                    self.wrong(format!("address of {}", show_symbol(*symbol)));
                }
                self.expect_all("result", &inst.results, [Ty::Word].into_iter());
            }
            InstKind::SlotAddr(slot, _) => {
                if self.func.slots.get(*slot).is_none() {
                    self.wrong(format!("address of {slot}, which does not exist"));
                }
                self.expect_all("result", &inst.results, [Ty::Word].into_iter());
            }
            InstKind::Call { callee, args } => self.check_call(callee, args, &inst.results),
            InstKind::Launch { .. } => {}
        }
    }

    fn check_op(&mut self, op: Opcode, args: &[Value], imm: i32, results: &[Value]) {
        let operands = op.info().operands.iter().copied().map(Kind::ty);
        self.expect_all(op, args, operands);
        self.expect_all("result", results, op.result().into_iter());
        let range = match op {
            Opcode::Vext | Opcode::Vins => 0..=3,
            Opcode::Swz => 0..=255,
            Opcode::In | Opcode::Out => 0..=i32::MAX,
            // The number of a `restrict` pointer or independent variable.
            Opcode::Mov => 0..=i32::MAX,
            _ if op.info().immediate => i32::MIN..=i32::MAX,
            _ => 0..=0,
        };
        if !range.contains(&imm) {
            self.wrong(format!("{op} has the immediate {imm}"));
        }
    }

    fn check_call(&mut self, callee: &Callee, args: &[Value], results: &[Value]) {
        match callee {
            Callee::Indirect(target, tys) => {
                self.expect(*target, Ty::Word);
                self.expect_all("results", results, tys.iter().copied());
            }
            Callee::Func(func) => {
                let Some(callee) = self.program.funcs.get(*func) else {
                    return self.wrong(format!("calls {func}, which does not exist"));
                };
                let entry = callee.layout.first().and_then(|&b| callee.blocks.get(b));
                if let Some(entry) = entry {
                    let params = entry.params.iter();
                    let tys = params.filter_map(|&p| callee.values.get(p).copied());
                    self.expect_all("arguments", args, tys);
                }
                self.expect_all("results", results, callee.results.iter().copied());
            }
        }
    }

    fn check_end(&mut self, block: &BlockData) {
        let func = self.func;
        let marks = block.kernel.iter().map(|k| k.pos);
        if !marks
            .chain([block.end_pos])
            .all(|pos| file_exists(self.program, pos))
        {
            self.wrong("a position names no file");
        }
        match &block.end {
            Terminator::Branch { cond, .. } => self.expect(*cond, Ty::Pred),
            Terminator::Return(values) => {
                self.expect_all("return", values, func.results.iter().copied());
            }
            Terminator::Jump(_) | Terminator::Unreachable => {}
        }
        for target in block.end.targets() {
            if self.present.get(target.block) != Some(&true) {
                self.wrong(format!("jumps to {}, which does not exist", target.block));
                continue;
            }
            if target.block == func.layout[0] {
                self.wrong("jumps to the entry");
            }
            let params = func.blocks[target.block].params.iter();
            let tys = params.filter_map(|&p| func.values.get(p).copied());
            let what = format_args!("jump to {}", target.block);
            self.expect_all(what, &target.args, tys);
        }
    }

    /// Checks that each use has a definition, and that it comes first.
    fn check_dominance(&mut self) {
        let func = self.func;
        let dominance = dominance::Dominance::of(func, &self.blocks);
        for block in self.blocks.clone() {
            self.block = Some(block);
            let data = &func.blocks[block];
            for (i, &inst) in data.insts.iter().enumerate() {
                let Some(inst_data) = func.insts.get(inst) else {
                    continue;
                };
                self.inst = Some(inst);
                let mut uses = Vec::new();
                inst_data.kind.for_each_use(|v| uses.push(v));
                for value in uses {
                    self.check_use(&dominance, value, block, i + 1);
                }
                self.inst = None;
            }
            let mut uses = Vec::new();
            data.end.for_each_use(|v| uses.push(v));
            for value in uses {
                self.check_use(&dominance, value, block, usize::MAX);
            }
        }
        self.block = None;
    }

    fn check_use(
        &mut self,
        dominance: &dominance::Dominance,
        value: Value,
        block: Block,
        place: usize,
    ) {
        let Some(def) = self.defs.get(value).copied().flatten() else {
            return self.wrong(format!("uses {value}, which is not defined"));
        };
        let comes_first = if def.block == block {
            def.place < place
        } else {
            dominance.dominates(def.block, block)
        };
        if !comes_first && dominance.is_reached(block) {
            self.wrong(format!("uses {value} before its definition"));
        }
    }
}
