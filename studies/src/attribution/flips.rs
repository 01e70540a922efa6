//! Decisions that binary64 makes otherwise, and what they come from.

use super::Studio;
use super::pixels::{Contribution, largest};
use super::tni::{DECISION, FrameShadows};
use srp_ir::shadow::Decision;
use srp_ir::shadow::tape::{Contributions, Sweep};
use srp_kernels::decision::{Decision as Named, decided_at};

/// Sources that are told of each flip.
const MOST_TOLD: usize = 3;

/// A kind of decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FlipKind {
    /// Which triangle a ray hits.
    Primitive,
    /// A shadow ray is stopped or not.
    Shadow,
    /// A ray hits the surface on which it begins, or not.
    SelfHit,
    /// All light is mirrored, or not.
    TotalReflection,
    /// Which texels a texture is filtered from.
    Texel,
    /// Any other.
    Other,
}

impl FlipKind {
    /// All of them.
    pub const ALL: [FlipKind; 6] = [
        FlipKind::Primitive,
        FlipKind::Shadow,
        FlipKind::SelfHit,
        FlipKind::TotalReflection,
        FlipKind::Texel,
        FlipKind::Other,
    ];

    /// The name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            FlipKind::Primitive => "primitive",
            FlipKind::Shadow => "shadow",
            FlipKind::SelfHit => "self-hit",
            FlipKind::TotalReflection => "total internal reflection",
            FlipKind::Texel => "texel",
            FlipKind::Other => "other",
        }
    }
}

/// A decision that binary64 makes otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// Which kind.
    pub kind: FlipKind,
    /// The pixel that it was made for, if that is known.
    pub pixel: Option<(u32, u32)>,
    /// The source that decides, by its number in [`Attribution::sources`](super::Attribution::sources).
    pub source: usize,
    /// The subject of the decision, or the triangles: in the run, and in binary64.
    pub what: String,
    /// Contributions to the difference, the largest first. Where the unit that decides does so otherwise by
    /// itself, that is the first.
    pub because: Vec<Contribution>,
}

/// The flips of a tile: those of rays, then those of the program.
pub(super) fn of(
    studio: &Studio<'_>,
    shadows: &FrameShadows<'_>,
    place: &dyn Fn(u32) -> Option<(u32, u32)>,
) -> Vec<Flip> {
    let (mut sweep, mut contributions) = (Sweep::default(), Contributions::default());
    let tape = &shadows.shadows.tape;
    let mut flips = Vec::new();
    for lost in &shadows.lost {
        contributions.collect(&mut sweep, tape, &lost.roots);
        let mut because = largest(&contributions, MOST_TOLD);
        if lost.by_unit {
            because.insert(
                0,
                Contribution {
                    source: DECISION as usize,
                    error: [0.0; 3],
                },
            );
            because.truncate(MOST_TOLD);
        }
        let triangle =
            |hit: Option<u32>| hit.map_or("nothing".to_owned(), |p| format!("triangle {p}"));
        flips.push(Flip {
            kind: match (lost.at_origin, lost.any) {
                (true, _) => FlipKind::SelfHit,
                (false, true) => FlipKind::Shadow,
                (false, false) => FlipKind::Primitive,
            },
            pixel: place(lost.tag),
            source: DECISION as usize,
            what: format!("{}, not {}", triangle(lost.real), triangle(lost.shadow)),
            because,
        });
    }
    for flip in &shadows.shadows.flips {
        let roots = [
            (flip.nodes[0], [1.0, 0.0, 0.0]),
            (flip.nodes[1], [-1.0, 0.0, 0.0]),
        ];
        contributions.collect(&mut sweep, tape, &roots);
        let [a, b] = flip.values;
        let [c, d] = flip.shadows;
        flips.push(Flip {
            kind: studio.kind(flip.decision, flip.source),
            pixel: place(flip.tag),
            source: flip.source as usize,
            what: match flip.decision {
                Decision::Integer => format!("{a:?}, not {c:?}"),
                _ => format!("{a:?} and {b:?}, not {c:?} and {d:?}"),
            },
            because: largest(&contributions, MOST_TOLD),
        });
    }
    flips
}

impl Studio<'_> {
    fn kind(&self, decision: Decision, source: u32) -> FlipKind {
        match decision {
            Decision::Texel => FlipKind::Texel,
            Decision::Integer | Decision::Number => FlipKind::Other,
            Decision::Comparison => {
                let at = self.sources.get(source).and_then(|source| source.at);
                let named = at.and_then(|(file, line)| {
                    let file = self.stage.program.files.get(file)?;
                    decided_at(file, line)
                });
                match named {
                    Some(Named::TotalInternalReflection) => FlipKind::TotalReflection,
                    None => FlipKind::Other,
                }
            }
        }
    }
}
