//! Random loops: the divided program means what the whole one did, every conflict in memory that
//! really happens is ordered, and any schedule that keeps the orders computes the same.

use crate::execute::{Access, Run, schedule};
use crate::generate;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::arch::Precision;
use srp_archdesc::entity::Entity;
use srp_ir::dfg::{Dfg, Node};
use srp_ir::interp::{self, FlatWorld, Kernels, Options, Trap, TrapKind, World};
use srp_ir::layout::Layout;
use srp_ir::program::{Bits, Func, Kernel, Program};
use srp_ir::{dre, pass, split, verify};
use std::collections::BTreeMap;

const SRAM: u32 = 64 << 10;
const STEPS: u64 = 20_000;

/// Arguments: small words of both signs, and the address of the first global.
fn arguments(rng: &mut Pcg32, layout: &Layout) -> Vec<Bits> {
    let mut word = || Bits::Word((rng.next_u32() % 9).wrapping_sub(4));
    let mut args: Vec<Bits> = (0..3).map(|_| word()).collect();
    let first = layout.addresses.values().next().expect("a global");
    args.push(Bits::Word(*first));
    args
}

/// Counts of the loops of a test.
#[derive(Default)]
struct Seen {
    pipelined: usize,
    ran: usize,
    conflicts: usize,
}

/// Divides a program and runs whole and parts with a few arguments.
fn compare(whole: &Program, seed: u64, seen: &mut Seen) {
    verify(whole).unwrap_or_else(|v| panic!("seed {seed}: {v:?}"));
    let split = split::split(whole);
    let control = &split.dre.control;
    split
        .dre
        .verify()
        .unwrap_or_else(|v| panic!("seed {seed}: {v:?}"));
    let Some(dfg) = split.dre.kernels.values().next() else {
        return;
    };
    assert_eq!(dfg.topological(), dfg.nodes.keys().collect::<Vec<_>>());
    seen.pipelined += 1;
    let layout = Layout::of(whole, SRAM).expect("fits");
    let mut options = Options::new(&layout);
    options.steps = STEPS;
    let mut rng = Pcg32::new(seed, 5);
    for _ in 0..3 {
        let args = arguments(&mut rng, &layout);
        let mut world = FlatWorld::new(&layout, SRAM);
        let func = Func::new(0);
        let Ok(expected) = interp::run(whole, func, &args, &mut world, &options) else {
            continue;
        };
        seen.ran += 1;
        let mut divided_world = FlatWorld::new(&layout, SRAM);
        let divided = dre::run(&split.dre, func, &args, &mut divided_world, &options);
        let divided = divided.unwrap_or_else(|t| panic!("seed {seed}: {}", t.show(control)));
        assert_eq!(expected.end, divided.end, "seed {seed}");
        assert!(world == divided_world, "seed {seed}: memory differs");
        let mut shuffled = Shuffled {
            dfg,
            rng: Pcg32::new(seed, 3),
            conflicts: 0,
            seed,
        };
        let mut world_after = FlatWorld::new(&layout, SRAM);
        let ran = interp::run_with(
            control,
            func,
            &args,
            &mut world_after,
            &mut shuffled,
            &options,
        );
        assert_eq!(
            expected.end,
            ran.expect("runs").end,
            "seed {seed}, shuffled"
        );
        assert!(world == world_after, "seed {seed}: shuffled memory differs");
        seen.conflicts += shuffled.conflicts;
    }
}

#[test]
fn divided_programs_mean_the_same() {
    let (mut plain, mut optimised) = (Seen::default(), Seen::default());
    for seed in 0..2000 {
        let mut program = generate::program(seed);
        compare(&program, seed, &mut plain);
        let options = pass::Options::new(Precision::EXACT);
        pass::optimise(&mut program, &options);
        compare(&program, seed, &mut optimised);
    }
    for seen in [plain, optimised] {
        assert!(seen.pipelined > 1300, "{} kernels", seen.pipelined);
        assert!(seen.ran > seen.pipelined, "{} runs", seen.ran);
        assert!(seen.conflicts > 5000, "{} conflicts", seen.conflicts);
    }
}

/// Runs a kernel in order, checking its conflicts, and then again in the order of a schedule.
struct Shuffled<'a> {
    dfg: &'a Dfg,
    rng: Pcg32,
    conflicts: usize,
    seed: u64,
}

impl Kernels for Shuffled<'_> {
    fn launch(
        &mut self,
        _: Kernel,
        args: &[Bits],
        world: &mut dyn World,
        _: &mut u64,
    ) -> Result<Vec<Bits>, Trap> {
        let mut in_order = Run::new(self.dfg, args);
        let mut scratch = Overlay {
            below: world,
            written: BTreeMap::new(),
        };
        for iteration in 0..in_order.trip() {
            for node in self.dfg.nodes.keys() {
                assert!(in_order.step(node, iteration, &mut scratch));
            }
        }
        self.conflicts += check_conflicts(self.dfg, &in_order.accesses, self.seed);

        let (ii, times) = schedule(self.dfg, &mut self.rng);
        let mut events: Vec<(i64, bool, u32, Node)> = Vec::new();
        for iteration in 0..in_order.trip() {
            for (node, data) in self.dfg.nodes.iter() {
                let time = times[node.index()] + i64::from(ii) * i64::from(iteration);
                // Stores write at the end of their cycle.
                events.push((time, data.op.result().is_none(), iteration, node));
            }
        }
        events.sort_by_key(|(time, store, iteration, node)| (*time, *store, *iteration, *node));
        let mut run = Run::new(self.dfg, args);
        for (_, _, iteration, node) in events {
            if !run.step(node, iteration, world) {
                return Err(TrapKind::Unreachable.nowhere());
            }
        }
        assert_eq!(run.live_outs(), in_order.live_outs(), "seed {}", self.seed);
        Ok(run.live_outs())
    }
}

/// A world whose changes go no further.
struct Overlay<'a> {
    below: &'a mut dyn World,
    written: BTreeMap<u32, u8>,
}

impl World for Overlay<'_> {
    fn load(
        &mut self,
        space: srp_archdesc::isa::Space,
        address: u32,
        bytes: u32,
    ) -> Option<srp_archdesc::ops::Value> {
        let mut value = self.below.load(space, address, bytes)?;
        for i in 0..bytes {
            if let Some(byte) = self.written.get(&(address + i)) {
                let (lane, shift) = ((i / 4) as usize, 8 * (i % 4));
                value.0[lane] &= !(0xff << shift);
                value.0[lane] |= u32::from(*byte) << shift;
            }
        }
        Some(value)
    }

    fn store(
        &mut self,
        space: srp_archdesc::isa::Space,
        address: u32,
        bytes: u32,
        value: srp_archdesc::ops::Value,
    ) -> Option<()> {
        self.below.load(space, address, bytes)?;
        for i in 0..bytes {
            let byte = value.0[(i / 4) as usize] >> (8 * (i % 4));
            self.written.insert(address + i, byte as u8);
        }
        Some(())
    }

    fn port_in(&mut self, _: u32) -> Option<u32> {
        None
    }

    fn port_out(&mut self, _: u32, _: u32) -> interp::PortOut {
        interp::PortOut::Blocked
    }
}

/// Checks that a path of dependences leads from the earlier to the later of any two accesses that
/// meet, with no more iterations in between; how many there were.
fn check_conflicts(dfg: &Dfg, accesses: &[Access], seed: u64) -> usize {
    let least = least_distances(dfg);
    let mut found = 0;
    for (k, a) in accesses.iter().enumerate() {
        for b in &accesses[k + 1..] {
            let meet = a.space == b.space
                && (a.is_store || b.is_store)
                && a.address < b.address + b.bytes
                && b.address < a.address + a.bytes;
            if !meet || a.node == b.node {
                continue;
            }
            found += 1;
            let apart = u64::from(b.iteration - a.iteration);
            let ordered = least[a.node.index()][b.node.index()];
            assert!(
                ordered.is_some_and(|d| d <= apart),
                "seed {seed}: {a:?} and {b:?} meet, but the order asks for {ordered:?}\n{dfg:#?}"
            );
        }
    }
    found
}

/// The least distance of a path from each node to each other.
fn least_distances(dfg: &Dfg) -> Vec<Vec<Option<u64>>> {
    let n = dfg.nodes.len();
    let mut least: Vec<Vec<Option<u64>>> = vec![vec![None; n]; n];
    let shorten = |slot: &mut Option<u64>, d: u64| *slot = Some(slot.map_or(d, |s| s.min(d)));
    for (from, to, dep) in dfg.deps() {
        shorten(&mut least[from.index()][to.index()], dep.distance.into());
    }
    for k in 0..n {
        for i in 0..n {
            for j in 0..n {
                if let (Some(a), Some(b)) = (least[i][k], least[k][j]) {
                    shorten(&mut least[i][j], a + b);
                }
            }
        }
    }
    least
}
