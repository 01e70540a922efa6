//! The kernels that come along, and their headers, as text.

use srp_archdesc::diagnostic::Source;

/// The headers, which any source can include.
const HEADERS: [(&str, &str); 7] = [
    ("srp.h", include_str!("../kernels/srp.h")),
    ("srp_host.h", include_str!("../kernels/srp_host.h")),
    ("scene.h", include_str!("../kernels/scene.h")),
    ("effects.h", include_str!("../kernels/effects.h")),
    ("forms.h", include_str!("../kernels/forms.h")),
    ("vector.h", include_str!("../kernels/vector.h")),
    ("rgs.h", include_str!("../kernels/rgs.h")),
];

/// The sources of the frame: ray generation, shading, output, and the job queue.
const SOURCES: [(&str, &str); 6] = [
    ("kernels/frame.c", include_str!("../kernels/frame.c")),
    ("kernels/generate.c", include_str!("../kernels/generate.c")),
    ("kernels/light.c", include_str!("../kernels/light.c")),
    (
        "kernels/secondary.c",
        include_str!("../kernels/secondary.c"),
    ),
    ("kernels/shade.c", include_str!("../kernels/shade.c")),
    ("kernels/tile.c", include_str!("../kernels/tile.c")),
];

/// A header that comes along.
pub(crate) fn header(name: &str) -> Option<Source> {
    let (name, text) = HEADERS.iter().find(|(header, _)| *header == name)?;
    Some(Source::new(format!("kernels/{name}"), *text))
}

/// All headers that come along.
pub(crate) fn headers() -> impl Iterator<Item = Source> {
    HEADERS
        .iter()
        .map(|(name, text)| Source::new(format!("kernels/{name}"), *text))
}

/// The kernels that come along.
pub(crate) fn sources() -> Vec<Source> {
    SOURCES
        .iter()
        .map(|(name, text)| Source::new(*name, *text))
        .collect()
}
