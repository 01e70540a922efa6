//! The body of a function in a listing.

use super::TextError;
use super::lex::{Line, Token};
use super::read::{comma_list, in_parens, object, params, symbol, ty};
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Opcode, Ty};

/// A function being read: its uses have the numbers of the listing until [`finish`](Body::finish).
pub(super) struct Body {
    pub(super) func: Function,
    values: FxHashMap<u32, Value>,
    blocks: FxHashMap<u32, Block>,
    slots: FxHashMap<u32, Slot>,
    /// Where a value or block is first used.
    value_uses: Vec<(u32, u32, u32)>,
    block_uses: Vec<(u32, u32, u32)>,
    /// The block being filled, and whether it has its end.
    block: Option<(Block, bool)>,
}

impl Body {
    pub(super) fn new(func: Function) -> Body {
        Body {
            func,
            values: FxHashMap::default(),
            blocks: FxHashMap::default(),
            slots: FxHashMap::default(),
            value_uses: Vec::new(),
            block_uses: Vec::new(),
            block: None,
        }
    }

    /// Reads one line; whether it was the last.
    pub(super) fn line(&mut self, mut line: Line<'_>, pos: Pos) -> Result<bool, TextError> {
        if line.eat('}') {
            line.done()?;
            return Ok(true);
        }
        if line.peek_entity("ss").is_some() {
            self.slot(&mut line)?;
        } else if line.peek_entity("bb").is_some() {
            self.open_block(&mut line, pos)?;
        } else {
            let block = match self.block {
                Some((block, false)) => block,
                Some((_, true)) => return Err(line.error("the block has already ended")),
                None => return Err(line.wanted("a block")),
            };
            match self.end(&mut line)? {
                Some(end) => {
                    self.func.blocks[block].end = end;
                    self.func.blocks[block].end_pos = pos;
                    self.block = Some((block, true));
                }
                None => self.inst(&mut line, block, pos)?,
            }
        }
        line.done()?;
        Ok(false)
    }

    fn slot(&mut self, line: &mut Line<'_>) -> Result<(), TextError> {
        let at = line.clone();
        let number = line.entity("ss")?;
        let (name, size, align) = object(line)?;
        let slot = self.func.slots.push(SlotData { name, size, align });
        match self.slots.insert(number, slot) {
            None => Ok(()),
            Some(_) => Err(at.error(format!("ss{number} is defined twice"))),
        }
    }

    fn open_block(&mut self, line: &mut Line<'_>, pos: Pos) -> Result<(), TextError> {
        if let Some((_, false)) = self.block {
            return Err(line.wanted("the end of the block (jump, br, ret, unreachable)"));
        }
        let at = line.clone();
        let number = line.entity("bb")?;
        let block = match self.block {
            None => self.func.entry(),
            Some(_) => self.func.add_block(),
        };
        if self.blocks.insert(number, block).is_some() {
            return Err(at.error(format!("bb{number} is defined twice")));
        }
        if self.block.is_some() && !line.eat(':') {
            let params = params(line)?;
            self.define_params(line, block, params)?;
            line.expect(':')?;
        } else if self.block.is_none() {
            line.expect(':')?;
        }
        if line.eat_word("kernel") {
            self.func.blocks[block].kernel = Some(KernelMark {
                name: line.name()?,
                required: line.eat_word("required"),
                nest: line.eat_word("nest"),
                restrict: match line.eat_word("restrict") {
                    true => comma_list(line, |line| line.number())?,
                    false => Vec::new(),
                },
                slower: match line.eat_word("slower") {
                    true => Some(Estimate {
                        iterations: line.number()?,
                        array: line.number()?,
                        vliw: line.number()?,
                    }),
                    false => None,
                },
                independence: independence(line)?,
                pos,
            });
        } else if line.pos.is_some() {
            return Err(line.error("a block has a position only with a kernel"));
        }
        self.block = Some((block, false));
        Ok(())
    }

    pub(super) fn define_params(
        &mut self,
        line: &Line<'_>,
        block: Block,
        params: Vec<(u32, Ty)>,
    ) -> Result<(), TextError> {
        for (number, ty) in params {
            let value = self.func.add_param(block, ty);
            self.define(line, number, value)?;
        }
        Ok(())
    }

    fn define(&mut self, line: &Line<'_>, number: u32, value: Value) -> Result<(), TextError> {
        match self.values.insert(number, value) {
            None => Ok(()),
            Some(_) => Err(line.error(format!("v{number} is defined twice"))),
        }
    }

    /// A use of a value, under its number in the listing.
    fn value(&mut self, line: &mut Line<'_>) -> Result<Value, TextError> {
        let column = line.column();
        let number = line.entity("v")?;
        self.value_uses.push((number, line.number, column));
        Ok(Value::new(number as usize))
    }

    fn target(&mut self, line: &mut Line<'_>) -> Result<Target, TextError> {
        let column = line.column();
        let number = line.entity("bb")?;
        self.block_uses.push((number, line.number, column));
        let args = match line.peek() {
            Some(Token::Sign('(')) => in_parens(line, |line| self.value(line))?,
            _ => Vec::new(),
        };
        Ok(Target {
            block: Block::new(number as usize),
            args,
        })
    }

    fn end(&mut self, line: &mut Line<'_>) -> Result<Option<Terminator>, TextError> {
        Ok(Some(if line.eat_word("jump") {
            Terminator::Jump(self.target(line)?)
        } else if line.eat_word("br") {
            let cond = self.value(line)?;
            line.expect(',')?;
            let then = self.target(line)?;
            line.expect(',')?;
            let other = self.target(line)?;
            Terminator::Branch { cond, then, other }
        } else if line.eat_word("ret") {
            Terminator::Return(match line.peek() {
                None => Vec::new(),
                Some(_) => comma_list(line, |line| self.value(line))?,
            })
        } else if line.eat_word("unreachable") {
            Terminator::Unreachable
        } else {
            return Ok(None);
        }))
    }

    fn inst(&mut self, line: &mut Line<'_>, block: Block, pos: Pos) -> Result<(), TextError> {
        let start = line.clone();
        let mut defs = Vec::new();
        if line.peek_entity("v").is_some() {
            defs = comma_list(line, |line| {
                let number = line.entity("v")?;
                let ty = if line.eat(':') { Some(ty(line)?) } else { None };
                Ok((number, ty))
            })?;
            line.expect('=')?;
        }
        let (kind, tys) = self.kind(line, &defs, &start)?;
        if defs.len() != tys.len() {
            let (n, m) = (defs.len(), tys.len());
            return Err(start.error(format!("{n} results given, {m} expected")));
        }
        if defs
            .iter()
            .zip(&tys)
            .any(|((_, given), ty)| given.is_some_and(|g| g != *ty))
        {
            return Err(start.error("the result has another type"));
        }
        let inst = self.func.append(block, kind, &tys, pos);
        let results = self.func.insts[inst].results.clone();
        for ((number, _), value) in defs.into_iter().zip(results) {
            self.define(&start, number, value)?;
        }
        Ok(())
    }

    /// Reads an instruction without its results; returns it with their types.
    fn kind(
        &mut self,
        line: &mut Line<'_>,
        defs: &[(u32, Option<Ty>)],
        start: &Line<'_>,
    ) -> Result<(InstKind, Vec<Ty>), TextError> {
        let at = line.clone();
        let name = line.atom("an instruction")?;
        let given = || -> Result<Vec<Ty>, TextError> {
            let tys: Option<Vec<Ty>> = defs.iter().map(|&(_, ty)| ty).collect();
            tys.ok_or_else(|| start.error(format!("the results of a {name} need types")))
        };
        Ok(match name {
            "const" => {
                let bits = constant(line)?;
                (InstKind::Const(bits), vec![bits.ty()])
            }
            "symbol" => {
                let symbol = symbol(line)?;
                (InstKind::SymbolAddr(symbol, line.offset()?), vec![Ty::Word])
            }
            "slot" => {
                let at = line.clone();
                let number = line.entity("ss")?;
                let slot = self.slots.get(&number).copied();
                let slot = slot.ok_or_else(|| at.error(format!("ss{number} is not defined")))?;
                (InstKind::SlotAddr(slot, line.offset()?), vec![Ty::Word])
            }
            "call" => {
                let tys = given()?;
                let callee = match line.peek_entity("fn") {
                    Some(_) => Callee::Func(Func::new(line.entity("fn")? as usize)),
                    None => Callee::Indirect(self.value(line)?, tys.clone()),
                };
                let args = in_parens(line, |line| self.value(line))?;
                (InstKind::Call { callee, args }, tys)
            }
            "launch" => {
                let tys = given()?;
                let kernel = Kernel::new(line.entity("k")? as usize);
                let args = in_parens(line, |line| self.value(line))?;
                (InstKind::Launch { kernel, args }, tys)
            }
            _ => {
                let op = Opcode::parse(name).ok_or_else(|| at.wanted("an instruction"))?;
                let args = match op.info().operands {
                    [] => Vec::new(),
                    _ => comma_list(line, |line| self.value(line))?,
                };
                let imm = line.offset()?;
                (
                    InstKind::Op { op, args, imm },
                    op.result().into_iter().collect(),
                )
            }
        })
    }

    /// Gives uses the numbers of the function.
    pub(super) fn finish(mut self, start: &Line<'_>) -> Result<Function, TextError> {
        match self.block {
            Some((_, true)) => {}
            Some((_, false)) => return Err(start.error("its last block has no end")),
            None => return Err(start.error("a function has at least one block")),
        }
        for &(number, line, column) in &self.value_uses {
            if !self.values.contains_key(&number) {
                let message = format!("v{number} is not defined");
                return Err(TextError::new(line, column, message));
            }
        }
        for &(number, line, column) in &self.block_uses {
            if !self.blocks.contains_key(&number) {
                let message = format!("bb{number} is not defined");
                return Err(TextError::new(line, column, message));
            }
        }
        let rename = |v: &mut Value| *v = self.values[&(v.index() as u32)];
        let func = &mut self.func;
        for inst in func.insts.values_mut() {
            inst.kind.for_each_use_mut(rename);
        }
        for block in func.blocks.values_mut() {
            block.end.for_each_use_mut(rename);
            for target in block.end.targets_mut() {
                target.block = self.blocks[&(target.block.index() as u32)];
            }
        }
        Ok(self.func)
    }
}

/// `true`, `0x2a`, `0x1:0x2:0x3:0x4`.
fn constant(line: &mut Line<'_>) -> Result<Bits, TextError> {
    if line.eat_word("true") {
        return Ok(Bits::Pred(true));
    }
    if line.eat_word("false") {
        return Ok(Bits::Pred(false));
    }
    let first = line.number()?;
    if !line.eat(':') {
        return Ok(Bits::Word(first));
    }
    let mut lanes = [first, line.number()?, 0, 0];
    for lane in &mut lanes[2..] {
        line.expect(':')?;
        *lane = line.number()?;
    }
    Ok(Bits::Vec(lanes))
}

/// Reads the words about the independence of a kernel's iterations.
fn independence(line: &mut Line<'_>) -> Result<Independence, TextError> {
    let mut independence = Independence {
        all: line.eat_word("ivdep"),
        groups: Vec::new(),
    };
    while line.eat_word("independent") {
        let group = comma_list(line, |line| line.number())?;
        independence.groups.push(group);
    }
    Ok(independence)
}
