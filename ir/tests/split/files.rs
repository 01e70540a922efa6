//! Files of divided and scheduled programs: written files are read back, and mistakes are found.

use crate::generate;
#[path = "../program/generate/mod.rs"]
#[expect(dead_code, reason = "the tests of programs use more of it")]
mod whole;

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::arch::{Arch, Carrier, Fu, Input, Link, RegFile, Wire};
use srp_archdesc::diagnostic::{self, render_all};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::dfg::{self, Dfg, Initial, Node};
use srp_ir::dre::scheduled::*;
use srp_ir::dre::{self, Dre};
use srp_ir::graph;
use srp_ir::pass::compact_program;
use srp_ir::program::*;
use srp_ir::split::split;

#[test]
fn divided_programs_are_read_back() {
    for seed in 0..400 {
        let mut program = whole::program(seed);
        compact_program(&mut program);
        program.globals[Global::new(0)].relocs.push(Reloc {
            offset: 4,
            symbol: Symbol::Func(Func::new(0)),
            addend: -8,
        });
        program.globals[Global::new(1)].name = "odd <&\"'> näme\n\t".to_owned();
        let dre = Dre {
            control: program,
            kernels: EntityMap::new(),
        };
        read_back(&dre);
        read_back(&split(&generate::program(seed)).dre);
    }
}

fn read_back(dre: &Dre) {
    let file = dre::write(dre);
    let again = dre::read(&file).unwrap_or_else(|e| panic!("{e}\n{file}"));
    assert!(again == *dre, "read differently:\n{file}");
    for dfg in dre.kernels.values() {
        drawn_back(dfg, &dre.control.files);
    }
}

/// Graphs written for Graphviz can be read back as well.
fn drawn_back(dfg: &Dfg, files: &EntityMap<SourceFile, String>) {
    let drawn = dfg::dot(dfg, files);
    let source = diagnostic::Source::new("loop.dot", drawn);
    let again = graph::read_dot(&source, &graph::Options::default());
    let again = again.unwrap_or_else(|e| panic!("{}", render_all(&e, &source.text, false)));
    assert!(again.dfg == *dfg, "read differently:\n{}", source.text);
    assert_eq!(again.files, *files);
}

struct Scheduler<'a> {
    rng: Pcg32,
    arch: &'a Arch,
}

/// Schedules of every shape, which need not be right.
impl Scheduler<'_> {
    fn below(&mut self, n: usize) -> usize {
        self.rng.next_u32() as usize % n.max(1)
    }

    fn many<T>(&mut self, most: usize, mut one: impl FnMut(&mut Self) -> T) -> Vec<T> {
        (0..self.below(most + 1)).map(|_| one(self)).collect()
    }

    fn fu(&mut self) -> Fu {
        Fu::new(self.below(self.arch.srp.fus.len()))
    }

    fn link(&mut self) -> Link {
        Link::new(self.below(self.arch.srp.links.len()))
    }

    fn wire(&mut self) -> Wire {
        Wire::new(self.below(self.arch.srp.wires.len()))
    }

    fn reg(&mut self) -> Reg {
        let file = RegFile::new(self.below(self.arch.srp.files.len()));
        let index = self.below(self.arch.srp.files[file].size as usize) as u32;
        Reg { file, index }
    }

    fn reg_at(&mut self) -> RegAt {
        let Reg { file, index } = self.reg();
        let left = self.arch.srp.files[file].size - index;
        let ring = 1 + self.below(left as usize) as u32;
        RegAt { file, index, ring }
    }

    fn bits(&mut self) -> Bits {
        let mut word = || self.rng.next_u32();
        match word() % 3 {
            0 => Bits::Pred(word() % 2 == 0),
            1 => Bits::Word(word()),
            _ => Bits::Vec([word(), word(), word(), word()]),
        }
    }

    fn pos(&mut self) -> Pos {
        match self.below(4) {
            0 => Pos::nowhere(),
            _ => Pos {
                file: SourceFile::new(self.below(2)),
                line: self.rng.next_u32() % 1000,
                column: self.rng.next_u32() % 100,
            },
        }
    }

    fn bundle_of(&mut self, count: usize) -> Bundle {
        Bundle::new(self.below(count))
    }

    fn slot_op(&mut self) -> SlotOp {
        let op = Opcode::ALL[self.below(Opcode::ALL.len())];
        let srcs = self.many(3, |s| match s.below(2) {
            0 => Src::Reg(s.reg()),
            _ => Src::Const(s.bits()),
        });
        SlotOp {
            fu: self.fu(),
            op,
            srcs,
            imm: self.rng.next_u32() as i32,
            dst: (self.below(3) > 0).then(|| self.reg()),
            pos: self.pos(),
        }
    }

    fn control(&mut self, bundles: usize, kernels: usize) -> Control {
        match self.below(9) {
            0 => Control::Jump(self.bundle_of(bundles)),
            1 => Control::Branch {
                cond: self.reg(),
                sense: self.below(2) == 0,
                target: self.bundle_of(bundles),
            },
            2 => Control::Call {
                target: self.bundle_of(bundles),
                link: self.reg(),
            },
            3 => Control::CallReg {
                target: self.reg(),
                link: self.reg(),
            },
            4 => Control::Return(self.reg()),
            5 if kernels > 0 => Control::Launch(Kernel::new(self.below(kernels))),
            6 => Control::Halt(self.reg()),
            7 => Control::StackOverflow,
            _ => Control::Unreachable,
        }
    }

    fn kernel(&mut self, dfg: Dfg) -> ModuloSchedule {
        let nodes = dfg.nodes.len();
        let live_ins = dfg.live_ins.len();
        let placed = |s: &mut Self| PlacedOp {
            node: Node::new(s.below(nodes)),
            is_move: s.below(2) == 0,
            fu: s.fu(),
            time: s.rng.next_u32() % 100,
            operands: s.many(3, |s| match s.below(5) {
                0 => Source::Const(s.bits()),
                1 => Source::Out(None),
                2 => Source::Out(Some(s.link())),
                3 => Source::Wire(s.wire()),
                _ => Source::Reg {
                    reg: s.reg_at(),
                    distance: s.rng.next_u32() % 3,
                },
            }),
            writes: s.many(2, Self::reg_at),
        };
        ModuloSchedule {
            ii: 1 + self.rng.next_u32() % 9,
            length: self.rng.next_u32() % 50,
            ops: self.many(20, placed).into_iter().collect(),
            transfers: self.many(3, |s| PlacedTransfer {
                node: Node::new(s.below(nodes)),
                over: match s.below(2) {
                    0 => Carrier::Link(s.link()),
                    _ => Carrier::Wire(s.wire()),
                },
                time: s.rng.next_u32() % 50,
                to: s.reg_at(),
            }),
            hops: self.many(5, |s| PlacedHop {
                node: Node::new(s.below(nodes)),
                wire: s.wire(),
                from: match s.below(2) {
                    0 => Input::Unit(s.fu()),
                    _ => Input::Wire(s.wire()),
                },
                time: s.rng.next_u32() % 50,
            }),
            preloads: self.many(4, |s| {
                let Reg { file, index } = s.reg();
                Preload {
                    file,
                    index,
                    value: match s.below(2) {
                        0 => Initial::Const(s.bits()),
                        _ => Initial::LiveIn(s.below(live_ins) as u32),
                    },
                    ty: Ty::ALL[s.below(3)],
                }
            }),
            live_in_regs: self.many(3, Self::reg),
            live_out_regs: self.many(3, Self::reg),
            dfg,
        }
    }

    fn program(&mut self, seed: u64) -> ScheduledDre {
        let split = split(&generate::program(seed)).dre;
        let dfgs: Vec<Dfg> = split.kernels.values().cloned().collect();
        let kernels: EntityMap<Kernel, ModuloSchedule> =
            dfgs.into_iter().map(|dfg| self.kernel(dfg)).collect();
        let count = 1 + self.below(20);
        let bundles = (0..count).map(|_| BundleData {
            ops: self.many(4, Self::slot_op),
            control: match self.below(3) {
                0 => Some((self.control(count, kernels.len()), self.pos())),
                _ => None,
            },
        });
        let bundles = bundles.collect();
        let zeros = self.below(200);
        let mut image = self.many(100, |s| s.rng.next_u32() as u8);
        image.resize(image.len() + zeros, 0);
        image.extend(self.many(50, |s| s.rng.next_u32() as u8));
        ScheduledDre {
            machine: self.arch.name.clone(),
            files: ["a.c", "dir/b & c.c"]
                .map(String::from)
                .into_iter()
                .collect(),
            image,
            symbols: self.many(4, |s| DataSymbol {
                name: format!("g{}", s.below(9)),
                address: s.rng.next_u32(),
                size: s.rng.next_u32(),
            }),
            bundles,
            functions: self.many(3, |s| FunctionEntry {
                name: format!("f{}", s.below(9)),
                bundle: s.bundle_of(count),
            }),
            start: self.bundle_of(count),
            kernels,
        }
    }
}

fn machines() -> Vec<Arch> {
    let shipped = srp_archdesc::machines::ALL;
    let wires = "wires=\"mesh row column:2\" topology=";
    let parsed = shipped.iter().map(|m| {
        let wired = m.xml.replace("topology=", wires);
        srp_archdesc::parse(m.name, &wired)
    });
    parsed
        .map(|arch| arch.expect("shipped machines are valid"))
        .collect()
}

#[test]
fn scheduled_programs_are_read_back() {
    for arch in machines() {
        for seed in 0..60 {
            let rng = Pcg32::new(seed, 9);
            let dre = Scheduler { rng, arch: &arch }.program(seed);
            let file = dre::write_scheduled(&dre, &arch);
            let again = dre::read_scheduled(&file, &arch);
            let again = again.unwrap_or_else(|e| panic!("{e}\n{file}"));
            assert!(again == dre, "read differently:\n{file}");
        }
    }
}

#[test]
fn damaged_files_are_refused_or_read() {
    let arch = &machines()[0];
    let mut rng = Pcg32::new(1, 2);
    let plain = dre::write(&split(&generate::program(3)).dre);
    // Without the initial data, which are most of it and say little.
    let is_data = |line: &&str| !line.trim_start().starts_with("<bytes");
    let plain: String = plain
        .lines()
        .filter(is_data)
        .map(|l| format!("{l}\n"))
        .collect();
    let scheduled = Scheduler {
        rng: Pcg32::new(4, 9),
        arch,
    };
    let scheduled = dre::write_scheduled(&{ scheduled }.program(3), arch);
    dre::read(&plain).expect("undamaged");
    dre::read_scheduled(&scheduled, arch).expect("undamaged");
    let mut refused = 0;
    for i in 0..4000 {
        let original = if i % 2 == 0 { &plain } else { &scheduled };
        let mut bytes = original.clone().into_bytes();
        for _ in 0..1 + rng.next_u32() % 3 {
            let at = rng.next_u32() as usize % bytes.len();
            match rng.next_u32() % 3 {
                0 => bytes[at] = b"<>\"'=&/0x9an@[]:%-> "[rng.next_u32() as usize % 20],
                1 => drop(bytes.remove(at)),
                _ => {
                    let from = rng.next_u32() as usize % bytes.len();
                    let to = (from + rng.next_u32() as usize % 40).min(bytes.len());
                    let copy = bytes[from..to].to_vec();
                    bytes.splice(at..at, copy);
                }
            }
        }
        let text = String::from_utf8(bytes).expect("the files are ASCII");
        let error = if i % 2 == 0 {
            dre::read(&text).err()
        } else {
            dre::read_scheduled(&text, arch).err()
        };
        if let Some(error) = error {
            refused += 1;
            let lines = text.lines().count() as u32;
            assert!(error.line >= 1 && error.line <= lines + 1, "{error}");
            assert!(!error.message.is_empty());
        }
    }
    assert!(refused > 2000, "{refused} of 4000 refused");
}

/// Changes one piece of a file and shows the message.
fn said(file: &str, from: &str, to: &str, read: impl Fn(&str) -> Option<dre::DreError>) -> String {
    assert!(file.contains(from), "{from} is not in\n{file}");
    let changed = file.replacen(from, to, 1);
    read(&changed).map_or("nothing".to_owned(), |e| e.to_string())
}

#[test]
fn mistakes_are_named_with_their_place() {
    let file = include_str!("cases/recurrence.dre.xml");
    let read = |text: &str| dre::read(text).err();
    let cases = [
        ("op=\"shl\"", "op=\"shll\""),
        ("n2@1[in1]", "n2@2[in1]"),
        ("n2@1[in1]", "n22@1[in1]"),
        ("args=\"in2 n0\"", "args=\"in2\""),
        ("args=\"in2 n0\"", "args=\"in2 true\""),
        ("<order from", "<ordre from"),
        ("distance=\"3\"", "distanc=\"3\""),
        ("distance=\"3\"", "distance=\"-3\""),
        ("args=\"v1 v2 v3 v7\"", "args=\"v1 v2 v3\""),
        ("out=\"v7:w\"", "out=\"v6:w\""),
        ("at=\"0:5:12\"", "at=\"7:5:12\""),
        ("to=\"bb2(v9)\"", "to=\"bb2()\""),
        ("</kernel>", "</kernels>"),
        ("version=\"1\"", "version=\"2\""),
        ("<dre ", "text<dre "),
    ];
    let found: String = cases
        .iter()
        .map(|(from, to)| format!("{from} -> {to}\n  {}\n", said(file, from, to, read)))
        .collect();
    let arch = &machines()[0];
    let rng = Pcg32::new(4, 9);
    let scheduled = dre::write_scheduled(&Scheduler { rng, arch }.program(3), arch);
    let read = |text: &str| dre::read_scheduled(text, arch).err();
    let other = said(&scheduled, &arch.name, "other", read);
    let found = format!("{found}machine\n  {other}\n");
    crate::golden::compare_case("mistakes.txt", &found);
}
