//! csimgen
