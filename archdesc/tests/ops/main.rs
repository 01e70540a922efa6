//! Tests of the opcodes against definitions that share nothing with `ops`: big integers, `rustc_apfloat`,
//! double-double series, and the C twin in `kernels/srp_host.h`.

mod certificates;
mod double_double;
mod elementary;
mod host;
mod ieee;
mod integer;
mod structures;
mod table;
mod texture;
mod values;
