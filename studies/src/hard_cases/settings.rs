//! The settings of a machine that cases are tried with.

use super::operands::Errors;
use srp_archdesc::arch::{Approx, Arch, Precision, Refine, Subnormals};
use srp_archdesc::datapath::Intersection;
use srp_archdesc::structure::Structure;
use srp_archdesc::system::Pipeline;

/// A machine with a name for what was changed in it.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The change, in words.
    pub name: String,
    pub(super) arch: Arch,
    /// True if kernels compute something else than in a setting before.
    pub(super) changes_kernels: bool,
    /// True if the texture unit does.
    pub(super) changes_textures: bool,
    /// True if the T&I unit does.
    pub(super) changes_tni: bool,
    /// The errors that units may make at the operands of the call that is judged, where these are known.
    pub(super) at_operands: Option<Errors>,
    /// How far narrow formats may bring the numbers of the call from those of binary32, where that is known.
    pub(super) narrow: Option<f64>,
}

/// The machine as it is, and its settings: everything exact, tables of 23, 16, 12 and 8 bits, 12 bits
/// and a Newton step, fused and not, and the step of reciprocals in code; subnormals flushed, or kept; each triangle
/// test, at the machine's precision and with 12 bits; both forms of the traversal unit; and each width of texture
/// weights.
pub(super) fn of(machine: &Arch) -> Vec<Setting> {
    let mut settings = Settings(Vec::new());
    settings.add("machine", machine.clone());
    settings.add("exact", with_approx(machine, Approx::Exact));
    for bits in [23, 16, 12, 8] {
        let table = Approx::table(bits, 0);
        settings.add(format!("{bits} bits"), with_approx(machine, table));
    }
    let improved = Approx::table(12, 1);
    settings.add("12 bits + 1 step", with_approx(machine, improved));
    let separate = Approx::Table {
        structure: Structure::Table,
        bits: 12,
        steps: 1,
        fused: false,
        refine: Refine::Unit,
    };
    let name = "12 bits + 1 step, not fused";
    settings.add(name, with_approx(machine, separate));
    let mut in_code = machine.clone();
    in_code.precision.rcp = Approx::Table {
        structure: Structure::Table,
        bits: 12,
        steps: 1,
        fused: true,
        refine: Refine::Code,
    };
    settings.add("12 bits + 1 step in code", in_code);
    let mut other = machine.clone();
    let (name, subnormals) = match machine.precision.subnormals {
        Subnormals::Keep => ("subnormals flushed", Subnormals::Flush),
        Subnormals::Flush => ("subnormals kept", Subnormals::Keep),
    };
    other.precision.subnormals = subnormals;
    settings.add(name, other);
    let twelve = with_approx(machine, Approx::table(12, 0));
    for (what, machine) in [("", machine), (", 12 bits", &twelve)] {
        for test in Intersection::ALL {
            let mut arch = machine.clone();
            arch.precision = settings.0[0].arch.precision;
            arch.system.tni.intersection = test;
            settings.add(format!("{}{what}", test.name()), arch);
        }
    }
    for (name, pipeline) in [
        ("single", Pipeline::Single),
        ("parallel", Pipeline::Parallel),
    ] {
        let mut arch = machine.clone();
        let tni = &mut arch.system.tni;
        tni.pipeline = pipeline;
        if pipeline == Pipeline::Single {
            (tni.pres, tni.aabbs, tni.posts) = (1, 1, 1);
        }
        settings.add(format!("{name} pipeline"), arch);
    }
    for bits in [12, 8, 4, 0] {
        let mut arch = machine.clone();
        arch.precision.texture_weight_bits = bits;
        settings.add(format!("weights of {bits} bits"), arch);
    }
    settings.0
}

struct Settings(Vec<Setting>);

impl Settings {
    /// Adds a machine, where it differs in what it computes from all that are there.
    fn add(&mut self, name: impl Into<String>, arch: Arch) {
        let without_weights = |p: &Precision| Precision {
            texture_weight_bits: 0,
            ..*p
        };
        let is_new = |differs: &dyn Fn(&Arch) -> bool| self.0.iter().all(|s| differs(&s.arch));
        let setting = Setting {
            changes_kernels: is_new(&|a| {
                without_weights(&a.precision) != without_weights(&arch.precision)
            }),
            changes_textures: is_new(&|a| {
                a.precision.texture_weight_bits != arch.precision.texture_weight_bits
            }),
            changes_tni: is_new(&|a| {
                a.system.tni != arch.system.tni || a.precision.rcp != arch.precision.rcp
            }),
            name: name.into(),
            arch,
            at_operands: None,
            narrow: None,
        };
        if setting.changes_kernels || setting.changes_textures || setting.changes_tni {
            self.0.push(setting);
        }
    }
}

/// The machine with all its special functions so, in the SRP and in the T&I unit, but those of fast units, which are
/// as they are. Exponential, logarithm and circular functions have no steps.
fn with_approx(machine: &Arch, approx: Approx) -> Arch {
    let plain = match approx {
        Approx::Table { bits, .. } => Approx::table(bits, 0),
        Approx::Exact => Approx::Exact,
    };
    let mut arch = machine.clone();
    let Precision {
        rcp,
        rsqrt,
        sqrt,
        div,
        exp2,
        log2,
        sincos,
        fast: _,
        subnormals: _,
        formats: _,
        texture_weight_bits: _,
    } = &mut arch.precision;
    for with_steps in [rcp, rsqrt, sqrt, div] {
        *with_steps = approx;
    }
    for without in [exp2, log2, sincos] {
        *without = plain;
    }
    arch.system.tni.rcp = approx;
    arch
}
