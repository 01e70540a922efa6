//! Bounds of what sums and products in narrow formats round away in one call of the driver.
//!
//! Intervals with errors ([`real`](crate::real)) run through the driver as its text means it: once with the formats and
//! units of the machine, once with binary32 and exact units, each along every way that decisions may take there. What
//! the machine computes is no farther from what binary32 computes than these are apart.

use super::call::Calls;
use super::engine::{Kernels, options};
use crate::Error;
use crate::kernel::computed;
use crate::real::Undefined;
use srp_archdesc::arch::{Arch, Precision};
use srp_ir::layout::Layout;
use srp_ir::program::Program;
use srp_toolchain::front_end;

/// The driver before any pass.
pub(super) struct Narrow {
    program: Program,
    layout: Layout,
    precision: Precision,
}

impl Narrow {
    /// Compiles the driver for some calls.
    pub(super) fn compile(kernels: &Kernels, calls: &Calls, arch: &Arch) -> Result<Self, Error> {
        let (program, _) = front_end(kernels.sources(), arch, &options(kernels, calls, arch))?;
        Ok(Narrow {
            layout: Layout::of(&program, arch.system.sram_bytes).map_err(Error::invalid)?,
            program,
            precision: arch.precision,
        })
    }

    /// How far any number that a call gives may be from that of binary32; the error is why that is not known.
    pub(super) fn most(&self, call: &Calls) -> Result<f64, Undefined> {
        let bytes = call.memory();
        let places: Vec<u32> = call.places(&bytes).into_iter().flatten().collect();
        let words = super::call::words(&bytes);
        let exact = Precision {
            subnormals: self.precision.subnormals,
            texture_weight_bits: self.precision.texture_weight_bits,
            ..Precision::EXACT
        };
        let both = (&self.program, &self.layout);
        let [narrow, single] =
            [&self.precision, &exact].map(|precision| computed(both, &words, &places, precision));
        let apart = narrow?.into_iter().zip(single?);
        let apart = apart.map(|(a, b)| (a[1] - b[0]).max(b[1] - a[0]));
        Ok(apart.fold(0.0, f64::max))
    }
}
