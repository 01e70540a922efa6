//! Precisions of special functions as reports and machine files write them.

use srp_archdesc::arch::{Approx, Refine};
use srp_archdesc::structure::Structure;

/// A precision in a few words, and as attributes of a machine file.
pub(crate) fn words(approx: Approx) -> (String, String) {
    let Approx::Table {
        structure,
        bits,
        steps,
        fused,
        refine,
    } = approx
    else {
        return ("exact".to_owned(), "bits=\"exact\"".to_owned());
    };
    let mut words = format!("{bits} bits");
    let mut how = format!("bits=\"{bits}\"");
    if structure != Structure::Table {
        words += &format!(" {}", structure.name());
        how += &format!(" structure=\"{}\"", structure.name());
        if let Structure::Polynomial { degree, .. } = structure {
            words += &format!(" {degree}");
            how += &format!(" degree=\"{degree}\"");
        }
    }
    if steps > 0 {
        let plural = if steps > 1 { "s" } else { "" };
        words += &format!(" + {steps} step{plural}");
        how += &format!(" steps=\"{steps}\"");
    }
    if !fused {
        words += " not fused";
        how += " fused=\"false\"";
    }
    if refine == Refine::Code {
        words += " in code";
        how += " refine=\"code\"";
    }
    (words, how)
}
