//! The kernels that come along, and their headers, as text.

use srp_archdesc::diagnostic::Source;
use srp_kernels::File;

fn source(file: &File) -> Source {
    Source::new(file.path, file.text)
}

/// A header that comes along.
pub(crate) fn header(name: &str) -> Option<Source> {
    srp_kernels::header(name).map(source)
}

/// All headers that come along.
pub(crate) fn headers() -> impl Iterator<Item = Source> {
    srp_kernels::HEADERS.iter().map(source)
}

/// The kernels that come along.
pub(crate) fn sources() -> Vec<Source> {
    srp_kernels::SOURCES.iter().map(source).collect()
}
