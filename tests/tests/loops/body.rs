//! Random loop bodies, and a program round each that brings its live-ins and stores its live-outs.

use super::machine::{below, one_of};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Class, Effect, Kind, Opcode, Ty};
use srp_ir::dfg::{Dfg, Initial, LiveIn, Node, NodeData, Operand, Order};
use srp_ir::dre::Dre;
use srp_ir::program::{
    Bits, Function, GlobalData, InstKind, Kernel, Pos, Program, Symbol, Terminator, Value,
};

/// Bytes of the data that loops read and write, in SRAM and in system memory.
const DATA: u32 = 256;

/// The initial contents of system memory.
pub(crate) fn system_memory() -> Vec<u8> {
    (0..DATA).map(|i| (i * 37 + 11) as u8).collect()
}

/// A program with one random loop.
pub(crate) fn random(random: &mut Pcg64) -> Dre {
    let mut body = Body::new();
    let size = 2 + below(random, 30);
    while body.nodes.len() < size as usize {
        let op = Opcode::ALL[below(random, Opcode::ALL.len() as u32) as usize];
        if op.class() != Class::Io {
            body.add(random, op);
        }
    }
    body.order_memory();
    let values = |ty: Ty| {
        move |n: &Node, nodes: &EntityMap<Node, NodeData>| nodes[*n].op.result() == Some(ty)
    };
    let mut live_outs: Vec<Node> = Vec::new();
    for ty in Ty::ALL {
        let all: Vec<Node> = body
            .nodes
            .keys()
            .filter(|n| values(ty)(n, &body.nodes))
            .collect();
        if !all.is_empty() && below(random, 2) == 0 {
            live_outs.push(one_of(random, &all));
        }
    }
    let dfg = Dfg {
        name: "random".to_owned(),
        pos: Pos::nowhere(),
        live_ins: body
            .live_ins
            .iter()
            .map(|b| LiveIn {
                ty: b.ty(),
                pos: Pos::nowhere(),
            })
            .collect(),
        trip: Some(0),
        nodes: body.nodes,
        order: body.order,
        assumed: Vec::new(),
        live_outs,
    };
    around(random, dfg, body.live_ins)
}

/// A loop body as it grows.
struct Body {
    nodes: EntityMap<Node, NodeData>,
    order: Vec<Order>,
    /// Live-in 0 is the trip count, 1 the address of the SRAM data, 2 that of the system memory.
    live_ins: Vec<Bits>,
}

impl Body {
    fn new() -> Body {
        let addresses = [Bits::Word(0), Bits::Word(0), Bits::Word(0x8000_0000)];
        Body {
            nodes: EntityMap::new(),
            order: Vec::new(),
            live_ins: addresses.to_vec(),
        }
    }

    fn push(&mut self, op: Opcode, operands: Vec<Operand>, imm: i32) -> Node {
        self.nodes.push(NodeData {
            op,
            operands,
            imm,
            pos: Pos::nowhere(),
        })
    }

    /// Adds an operation, and before a memory access the computation of an address inside the data.
    fn add(&mut self, random: &mut Pcg64, op: Opcode) {
        let mut operands: Vec<Operand> = op
            .info()
            .operands
            .iter()
            .map(|&kind| self.operand(random, kind))
            .collect();
        let mut imm = if op.info().immediate {
            below(random, 4) as i32
        } else {
            0
        };
        if op == Opcode::Swz {
            imm = below(random, 256) as i32;
        }
        if let Some(bytes) = op.access_bytes() {
            let index = self.operand(random, Kind::I);
            let mask = Operand::Const(Bits::Word((DATA - 64) & !(bytes - 1)));
            let offset = self.push(Opcode::And, vec![index, mask], 0);
            let base = if op.space() == Some(srp_archdesc::isa::Space::Sram) {
                1
            } else {
                2
            };
            let offset = Operand::Node {
                node: offset,
                init: Vec::new(),
            };
            let address = self.push(Opcode::Add, vec![Operand::LiveIn(base), offset], 0);
            operands[1] = Operand::Node {
                node: address,
                init: Vec::new(),
            };
            imm = (below(random, 48 / bytes) * bytes) as i32;
        }
        if op.class() == Class::Idiv {
            // The divisor must not be zero.
            let odd = self.push(
                Opcode::Or,
                vec![operands[2].clone(), Operand::Const(Bits::Word(1))],
                0,
            );
            operands[2] = Operand::Node {
                node: odd,
                init: Vec::new(),
            };
        }
        self.push(op, operands, imm);
    }

    /// A random operand: a constant, a live-in, an earlier node, or any node of an earlier iteration.
    fn operand(&mut self, random: &mut Pcg64, kind: Kind) -> Operand {
        let ty = kind.ty();
        let producers: Vec<Node> = self
            .nodes
            .keys()
            .filter(|&n| self.nodes[n].op.result() == Some(ty))
            .collect();
        match below(random, 10) {
            0 => Operand::Const(constant(random, ty)),
            1 | 2 => Operand::LiveIn(self.live_in(random, ty)),
            3 | 4 if !producers.is_empty() => {
                let node = one_of(random, &producers);
                let distance = 1 + below(random, 3);
                let init = (0..distance).map(|_| self.initial(random, ty)).collect();
                Operand::Node { node, init }
            }
            _ if !producers.is_empty() => {
                let recent = producers.len().saturating_sub(6);
                let node = one_of(random, &producers[recent..]);
                Operand::Node {
                    node,
                    init: Vec::new(),
                }
            }
            _ => Operand::Const(constant(random, ty)),
        }
    }

    fn initial(&mut self, random: &mut Pcg64, ty: Ty) -> Initial {
        if below(random, 2) == 0 {
            Initial::Const(constant(random, ty))
        } else {
            Initial::LiveIn(self.live_in(random, ty))
        }
    }

    /// A live-in of a type: one there is, or a new one while there are few.
    fn live_in(&mut self, random: &mut Pcg64, ty: Ty) -> u32 {
        let known: Vec<u32> = (3..self.live_ins.len() as u32)
            .filter(|&i| self.live_ins[i as usize].ty() == ty)
            .collect();
        if known.len() < 4 && (known.is_empty() || below(random, 2) == 0) {
            self.live_ins.push(constant(random, ty));
            return self.live_ins.len() as u32 - 1;
        }
        one_of(random, &known)
    }

    /// Every store is ordered against every access of its memory, in this iteration and the next.
    fn order_memory(&mut self) {
        let accesses: Vec<Node> = self
            .nodes
            .keys()
            .filter(|&n| self.nodes[n].op.space().is_some())
            .collect();
        for &a in &accesses {
            for &b in &accesses {
                let (first, second) = (self.nodes[a].op, self.nodes[b].op);
                let store = |op: Opcode| op.info().effect == Effect::Store;
                if first.space() != second.space() || !(store(first) || store(second)) {
                    continue;
                }
                if a < b {
                    self.order.push(Order {
                        from: a,
                        to: b,
                        distance: 0,
                    });
                } else {
                    self.order.push(Order {
                        from: a,
                        to: b,
                        distance: 1,
                    });
                }
            }
        }
    }
}

fn constant(random: &mut Pcg64, ty: Ty) -> Bits {
    let word = |random: &mut Pcg64| match below(random, 4) {
        0 => below(random, 64),
        1 => 0x3f80_0000 + (below(random, 16) << 20),
        2 => below(random, u32::MAX),
        _ => 0u32.wrapping_sub(below(random, 64)),
    };
    match ty {
        Ty::Pred => Bits::Pred(random.next_u64() & 1 == 0),
        Ty::Word => Bits::Word(word(random)),
        Ty::Vec => Bits::Vec([word(random), word(random), word(random), word(random)]),
    }
}

/// A main function that launches the loop and stores what it gives.
fn around(random: &mut Pcg64, dfg: Dfg, live_ins: Vec<Bits>) -> Dre {
    let mut program = Program::default();
    program.files.push("random.c".to_owned());
    let global = |name: &str, size| GlobalData {
        name: name.to_owned(),
        size,
        align: 16,
        init: (0..size).map(|i| (i * 73 + 5) as u8).collect(),
        relocs: Vec::new(),
        pos: Pos::nowhere(),
    };
    let data = program.globals.push(global("data", DATA));
    let out = program.globals.push(global("out", 16 * 8));
    let mut main = Function::new("main", &[], vec![Ty::Word], Pos::nowhere());
    let entry = main.entry();
    let here = Pos::nowhere();
    let trip = one_of(random, &[1, 2, 3, 5, 17, 40]);
    let address = |main: &mut Function, symbol| {
        let inst = main.append(entry, InstKind::SymbolAddr(symbol, 0), &[Ty::Word], here);
        main.insts[inst].results[0]
    };
    let base = address(&mut main, Symbol::Global(data));
    let args: Vec<Value> = (live_ins.iter().enumerate())
        .map(|(i, &bits)| match i {
            0 => main.append_const(entry, Bits::Word(trip), here),
            1 => base,
            _ => main.append_const(entry, bits, here),
        })
        .collect();
    let types: Vec<Ty> = dfg
        .live_outs
        .iter()
        .map(|&n| dfg.ty(n).expect("a live-out has a value"))
        .collect();
    let launch = InstKind::Launch {
        kernel: Kernel::new(0),
        args,
    };
    let launch = main.append(entry, launch, &types, here);
    let results = main.insts[launch].results.clone();
    let always = main.append_const(entry, Bits::Pred(true), here);
    let target = address(&mut main, Symbol::Global(out));
    for (i, (&value, &ty)) in results.iter().zip(&types).enumerate() {
        let (op, value) = match ty {
            Ty::Pred => {
                let word = main.append_op(entry, Opcode::Ptoi, &[value], 0, here);
                (Opcode::Sw, word.expect("ptoi has a result"))
            }
            Ty::Word => (Opcode::Sw, value),
            Ty::Vec => (Opcode::Sv, value),
        };
        main.append_op(entry, op, &[always, target, value], 16 * i as i32, here);
    }
    let zero = main.append_const(entry, Bits::Word(0), here);
    main.blocks[entry].end = Terminator::Return(vec![zero]);
    program.main = Some(program.funcs.push(main));
    let mut kernels = EntityMap::new();
    kernels.push(dfg);
    Dre {
        control: program,
        kernels,
    }
}
