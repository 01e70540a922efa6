//! Constants and live-ins come from as many files as an operation needs, and values without a way are refused.

use super::{graph, machine};
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::check::check_loop;
use srp_ir::dfg::{Dfg, LiveIn, Node, NodeData, Operand};
use srp_ir::program::{Bits, Pos};
use srp_scheduler::modulo::{self, Destination, Unschedulable};

/// A loop of one operation.
fn of(op: Opcode, operands: Vec<Operand>) -> Dfg {
    let live_in = LiveIn {
        ty: Ty::Word,
        pos: Pos::nowhere(),
    };
    let mut nodes = EntityMap::new();
    nodes.push(NodeData {
        op,
        operands,
        imm: 0,
        pos: Pos::nowhere(),
    });
    Dfg {
        name: "one".to_owned(),
        pos: Pos::nowhere(),
        live_ins: vec![live_in; 4],
        trip: Some(3),
        nodes,
        order: Vec::new(),
        assumed: Vec::new(),
        live_outs: vec![Node::new(0)],
    }
}

/// One unit, whose files have so many read ports: the central one, and two static ones.
fn unit([central, a, b]: [u32; 3]) -> Arch {
    let file = |name: &str, ports: u32| match ports {
        0 => String::new(),
        _ => format!(r#"<file name="{name}" kind="static" size="8" read-ports="{ports}"/>"#),
    };
    let (a, b) = (file("a", a), file("b", b));
    machine(&format!(
        r#"<machine name="one">
             <fu-type name="all" width="32" constants="0" classes="alu fma">{a}{b}</fu-type>
             <array rows="1" cols="1" topology="none" contexts="64">
               <row units="all"/>
               <file name="word" kind="central" width="32" size="32" read-ports="{central}" readers="all" writers="all"/>
             </array>
             <vliw slots="0"/>
           </machine>"#
    ))
}

#[test]
fn constants_and_live_ins_come_from_any_files_with_ports() {
    let live_ins = || [0, 1, 2].map(Operand::LiveIn);
    let constants = || [1, 2, 3].map(|word| Operand::Const(Bits::Word(word)));
    for ports in [
        [3, 1, 1],
        [1, 1, 1],
        [1, 1, 2],
        [1, 0, 2],
        [3, 0, 3],
        [1, 0, 1],
        [2, 3, 0],
    ] {
        let arch = unit(ports);
        let [central, a, b] = ports;
        for (operands, offered) in [(live_ins(), central + a + b), (constants(), a + b)] {
            // One register is one read, however many operands it is.
            let [first, second, _] = &operands;
            let twice = [first.clone(), second.clone(), first.clone()];
            for (operands, wanted) in [(operands, 3), (twice, 2)] {
                let dfg = of(Opcode::Fma, operands.to_vec());
                let found =
                    modulo::schedule(&dfg, &arch.srp, &modulo::Options::default(), &Unwatched);
                match found {
                    Ok(found) => {
                        assert_eq!(check_loop(&found.schedule, &arch.srp), [], "{ports:?}");
                        assert!(offered >= wanted, "{ports:?} {operands:?}");
                    }
                    Err(why) => {
                        assert!(offered < wanted, "{ports:?} {operands:?} {why}");
                        assert!(matches!(why, Unschedulable::NoPlace(_)), "{ports:?} {why}");
                    }
                }
            }
        }
    }
}

#[test]
fn values_without_a_way_are_refused_for_that() {
    let two = |topology: &str| {
        machine(&format!(
            r#"<machine name="two">
                 <fu-type name="loads" width="32" classes="load"/>
                 <fu-type name="roots" width="32" classes="sfu"/>
                 <array rows="1" cols="2" topology="{topology}" contexts="64">
                   <row units="loads roots"/>
                   <file name="word" kind="central" width="32" size="32"/>
                 </array>
             <vliw slots="0"/>
           </machine>"#
        ))
    };
    let root = graph(
        "root.dot",
        "digraph { a [op=load]; b [op=sqrt]; a -> b }".to_owned(),
    );
    let find = |arch: &Arch| {
        modulo::schedule(
            &root.dfg,
            &arch.srp,
            &modulo::Options::default(),
            &Unwatched,
        )
    };
    assert!(find(&two("mesh")).is_ok());
    let why = find(&two("none")).expect_err("the units are apart");
    let Unschedulable::NoWay {
        from,
        to: Destination::Operation(to),
        in_register: false,
    } = why
    else {
        panic!("{why}");
    };
    assert_eq!([from.op, to.op], [Opcode::Lw, Opcode::Sqrt]);
}
