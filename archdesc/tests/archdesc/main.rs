//! Machine files: what they are read as, what is wrong with them, and what follows from them in cycles, area and energy.

mod area;
mod datapath;
mod edits;
mod errors;
mod formats;
mod haste;
mod knobs;
mod machines;
mod published;
mod schema;
