//! From records to events: the registers of each core go along.

use crate::event::{Done, Event, Outside, Turn, What};
use crate::trace::{CoreTrace, Trace};
use srp_archdesc::isa::Ty;
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::spec::{Action, Cell, KernelSpec, Landing, Operand, Role, SimSpec, Step};
use srp_csimgen::{Record, Snapshot};

/// Gives all events of a trace to `sink`, by cycles, those of one cycle core by core.
pub fn replay(trace: &Trace, sink: &mut dyn FnMut(Event<'_>)) {
    let mut cores: Vec<Replay<'_>> = (trace.cores.iter())
        .map(|core| Replay::new(&trace.spec, core, trace.cycles.start))
        .collect();
    let mut outside = trace.outside.as_slice();
    loop {
        let cycles = cores.iter().filter_map(Replay::next);
        let next = cycles.chain(outside.first().map(|e| e.0)).min();
        let Some(cycle) = next else { break };
        for core in &mut cores {
            if core.next() == Some(cycle) {
                core.advance(cycle, sink);
            }
        }
        while let Some((at, core, event)) = outside.first().filter(|e| e.0 == cycle) {
            sink(of_outside(*at, *core, event));
            outside = &outside[1..];
        }
    }
}

fn of_outside(cycle: u64, core: u32, event: &Outside) -> Event<'_> {
    Event {
        cycle,
        core,
        what: What::Outside(event),
    }
}

/// A core on its way through its records.
struct Replay<'t> {
    spec: &'t SimSpec,
    trace: &'t CoreTrace,
    /// The first event has all registers.
    begins: Option<u64>,
    turn: usize,
    doing: usize,
    state: Registers<'t>,
    /// The iteration that has begun last.
    iteration: u64,
    /// Cells that have changed, as they are from this cycle on.
    changed: (u64, Vec<u32>),
    /// The rotating stores of each kernel.
    rotating: Vec<Vec<u32>>,
}

/// The registers of a core, rotating files in their physical order.
struct Registers<'t> {
    spec: &'t SimSpec,
    cells: Vec<V4>,
    /// How far each store has advanced, 0 for those that do not rotate.
    advanced: Vec<u32>,
}

impl<'t> Registers<'t> {
    fn of(spec: &'t SimSpec, start: &Snapshot) -> Registers<'t> {
        let mut of_rotating = start.advanced.iter();
        let advanced = spec.stores.iter().map(|store| match store.role {
            Role::Rotating => of_rotating.next().copied().unwrap_or(0),
            _ => 0,
        });
        Registers {
            spec,
            advanced: advanced.collect(),
            cells: start.cells.clone(),
        }
    }

    /// The physical cell that a name stands for, where `n` iterations have begun in the contexts.
    fn physical(&self, cell: Cell, n: u32) -> u32 {
        let store = self.spec.store(cell);
        let flat = self.spec.flat(cell, n);
        match store.role {
            Role::Rotating => self.turned(cell.store, flat),
            _ => flat,
        }
    }

    /// The physical cell of one in a store, which may have advanced.
    fn turned(&self, number: u32, flat: u32) -> u32 {
        let store = &self.spec.stores[number as usize];
        store.base + (flat - store.base + self.advanced[number as usize]) % store.size
    }

    /// Writes a value of a type, which leaves the lanes beyond it as they are.
    fn write(&mut self, cell: u32, ty: Ty, value: V4) {
        let cell = &mut self.cells[cell as usize];
        match ty {
            Ty::Pred | Ty::Word => cell.0[0] = value.0[0],
            Ty::Vec => *cell = value,
        }
    }
}

/// The rotating stores that a kernel uses.
fn rotating(spec: &SimSpec, kernel: &KernelSpec) -> Vec<u32> {
    let mut stores: Vec<u32> = kernel.stores().into_iter().collect();
    stores.retain(|&store| spec.stores[store as usize].role == Role::Rotating);
    stores
}

impl<'t> Replay<'t> {
    fn new(spec: &'t SimSpec, trace: &'t CoreTrace, first: u64) -> Replay<'t> {
        Replay {
            spec,
            trace,
            begins: Some(first),
            turn: 0,
            doing: 0,
            state: Registers::of(spec, &trace.start),
            iteration: trace.start.on_array.map_or(0, |(_, iteration)| iteration),
            changed: (0, Vec::new()),
            rotating: spec.kernels.iter().map(|k| rotating(spec, k)).collect(),
        }
    }

    /// The next cycle with an event.
    fn next(&self) -> Option<u64> {
        if self.begins.is_some() {
            return self.begins;
        }
        let changed = (!self.changed.1.is_empty()).then_some(self.changed.0);
        let turn = self.trace.turns.get(self.turn).map(|t| t.0);
        let doing = self.trace.doings.get(self.doing).map(|d| d.0);
        [changed, turn, doing].into_iter().flatten().min()
    }

    /// Gives the events of a cycle.
    fn advance(&mut self, cycle: u64, sink: &mut dyn FnMut(Event<'_>)) {
        let core = self.trace.core;
        let mut give = |what: What<'_>| sink(Event { cycle, core, what });
        if self.begins.take().is_some() {
            for (cell, &value) in (0..).zip(&self.state.cells) {
                give(What::Cell(cell, value));
            }
        }
        if self.changed.0 == cycle {
            let mut cells = std::mem::take(&mut self.changed.1);
            cells.sort_unstable();
            cells.dedup();
            for cell in cells {
                give(What::Cell(cell, self.state.cells[cell as usize]));
            }
        }
        while let Some(&(_, doing)) = self.trace.doings.get(self.doing).filter(|d| d.0 <= cycle) {
            give(What::Does(doing));
            self.doing += 1;
        }
        let Some(&(at, first)) = self.trace.turns.get(self.turn).filter(|t| t.0 == cycle) else {
            return;
        };
        self.turn += 1;
        let end = self.trace.turns.get(self.turn).map(|t| t.1);
        let records = &self.trace.records[first..end.unwrap_or(self.trace.records.len())];
        self.changed.0 = at + 1;
        self.take(records, &mut give);
    }

    /// Goes through the records of a cycle.
    fn take(&mut self, mut records: &'t [Record], give: &mut dyn FnMut(What<'_>)) {
        while let Some((record, rest)) = records.split_first() {
            records = rest;
            match *record {
                Record::Bundle(number) => records = self.bundle(number, rest, give),
                Record::Context {
                    kernel,
                    context,
                    stages,
                } => records = self.context(kernel, context, stages, rest, give),
                Record::Word(cell, value) => self.land(cell, Ty::Word, V4([value, 0, 0, 0])),
                Record::Vector(cell, value) => self.land(cell, Ty::Vec, value),
                Record::Entered(kernel) => self.enter(kernel, give),
                Record::Rotated(kernel) => self.rotate(kernel),
                // The steps have taken theirs.
                Record::Value(_) => {}
            }
        }
    }

    /// A result of VLIW code lands.
    fn land(&mut self, cell: u32, ty: Ty, value: V4) {
        let stores = &self.spec.stores;
        let number = stores.partition_point(|store| store.base <= cell) - 1;
        let cell = self.state.turned(number as u32, cell);
        self.state.write(cell, ty, value);
        self.changed.1.push(cell);
    }

    /// The registers of a kernel are set: they are as they are in this cycle already.
    fn enter(&mut self, kernel: u32, give: &mut dyn FnMut(What<'_>)) {
        self.state.advanced.fill(0);
        self.iteration = 0;
        for preset in &self.spec.kernels[kernel as usize].preloads {
            let (value, source) = self.operand(preset.value, 0);
            let cell = self.spec.flat(preset.cell, 0);
            self.state.write(cell, preset.ty, value);
            give(What::Preset(cell, self.state.cells[cell as usize], source));
        }
    }

    fn rotate(&mut self, kernel: u32) {
        self.iteration += 1;
        for &store in &self.rotating[kernel as usize] {
            let advanced = &mut self.state.advanced[store as usize];
            *advanced = (*advanced + 1) % self.spec.stores[store as usize].size;
        }
    }

    fn bundle(
        &mut self,
        number: u32,
        records: &'t [Record],
        give: &mut dyn FnMut(What<'_>),
    ) -> &'t [Record] {
        give(What::Turn(Turn::Bundle(number)));
        let bundle = &self.spec.bundles[number as usize];
        if let Some((control, at)) = &bundle.control {
            give(What::Control(control, *at));
        }
        let mut records = records;
        for step in &bundle.steps {
            records = self.step(step, (0, None), records, give);
        }
        records
    }

    fn context(
        &mut self,
        kernel: u32,
        context: u32,
        stages: u64,
        records: &'t [Record],
        give: &mut dyn FnMut(What<'_>),
    ) -> &'t [Record] {
        let spec: &KernelSpec = &self.spec.kernels[kernel as usize];
        let (slot, n) = (context % spec.ii, context / spec.ii);
        let iteration = self.iteration;
        give(What::Turn(Turn::Context {
            kernel,
            slot,
            iteration,
            stages,
        }));
        let mut records = records;
        for step in &spec.contexts[slot as usize] {
            let is_done = step.stage.is_none_or(|stage| stages >> stage & 1 != 0);
            if is_done {
                let of = step.stage.map(|s| iteration.wrapping_sub(u64::from(s)));
                records = self.step(step, (n, of), records, give);
            }
        }
        records
    }

    fn operand(&self, operand: Operand, n: u32) -> (V4, Option<u32>) {
        match operand {
            Operand::Const(bits) => (V4(bits.lanes()), None),
            Operand::Cell(cell) => {
                let cell = self.state.physical(cell, n);
                (self.state.cells[cell as usize], Some(cell))
            }
        }
    }

    /// A step, whose value is the next record.
    fn step(
        &mut self,
        step: &'t Step,
        (n, iteration): (u32, Option<u64>),
        records: &'t [Record],
        give: &mut dyn FnMut(What<'_>),
    ) -> &'t [Record] {
        let Some((&Record::Value(value), rest)) = records.split_first() else {
            return records;
        };
        let (mut operands, mut sources) = ([V4::default(); 3], [None; 3]);
        let mut take = |i: usize, operand| (operands[i], sources[i]) = self.operand(operand, n);
        match &step.action {
            Action::Copy(cell) => take(0, Operand::Cell(*cell)),
            Action::Op { operands, .. } => {
                (operands.iter().take(3).enumerate()).for_each(|(i, &operand)| take(i, operand));
            }
        }
        let dests = step.dests.iter().map(|&cell| self.state.physical(cell, n));
        let dests: Vec<u32> = dests.collect();
        if let (Some(ty), Landing::InPlace) = (step.ty, step.landing) {
            for &cell in &dests {
                self.state.write(cell, ty, value);
            }
            self.changed.1.extend(&dests);
        }
        give(What::Step(Done {
            step,
            operands,
            sources,
            value,
            dests: &dests,
            iteration,
        }));
        rest
    }
}
