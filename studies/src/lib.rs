//! Studies: what is asked of machines, kernels and scenes, on top of the one chain of
//! [`srp_toolchain`].
//!
//! A study is a function from plain options to a report, which is data that `serde` writes. Nothing
//! here prints, parses a command line or makes a page; whoever shows a report is above.
//!
//! * [`accuracy`] tries settings of precision: what each buys, and costs.
//! * [`kernel`] does the same for functions of C and FPCore, against [`real`] arithmetic.
//! * [`fidelity`] runs frames at every level of simulation, and says what each level costs and is off by.
//! * [`hard_cases`] tries what goes wrong in float arithmetic with every setting of a machine.
//! * [`paper`] compares with the tables of the SGRT paper.
//! * [`views`] measures T&I units over the views of a scene; [`tni`] runs T&I units without SRPs on [`rays`], all of them or a sample.
//! * [`functional`] runs a frame without a schedule and a clock; [`attribution`] says where the errors of
//!   its picture come from.
//! * [`mod@reference`] renders in binary64; [`mod@exact`] decides about rays and triangles without rounding.
//! * [`watertight`] counts rays that meshes lose, and rays that hit what they pass by.
//! * [`effects`] measures the cost of each effect of a scene.
//! * [`energy`](mod@energy) says where the energy of a frame goes.
//! * [`loops`] reports on the loops of programs, [`map`](mod@map) on graphs; [`certificate`] is what proves
//!   their bounds.
//! * [`profile`] gives every cycle of a run to a function, a loop and a source line.
//! * [`sweep`] measures many machines, and says which is on a front and what moves it.
//! * [`figure`] says what is measured; [`survey`] is the statistics of samples.

pub mod accuracy;
mod attributes;
pub mod attribution;
mod bases;
pub mod certificate;
pub mod comparison;
pub mod effects;
pub mod energy;
mod error;
pub mod exact;
mod expansion;
pub mod fidelity;
pub mod figure;
pub mod functional;
pub mod hard_cases;
pub mod jobs;
pub mod kernel;
pub mod loops;
pub mod map;
pub mod paper;
pub mod profile;
pub mod proofs;
pub mod rays;
pub mod real;
pub mod reference;
mod same_loops;
mod search;
mod settings;
pub mod survey;
pub mod sweep;
pub mod tni;
pub mod views;
pub mod watertight;

pub use error::Error;
