//! Links of the array: those its topology means, and those the file adds.

use std::collections::BTreeMap;

use super::array::Units;
use super::findings::Findings;
use super::limits;
use super::raw;
use super::values;
use crate::arch::{Fu, Link, LinkSpec};
use crate::diagnostic::Span;
use crate::entity::{Entity, EntityMap};

/// Which units a unit's output reaches.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Topology {
    /// No others.
    None,
    /// The four neighbours.
    Mesh,
    /// The eight neighbours.
    MeshDiagonal,
    /// The four neighbours, the edges of the array joined.
    Torus,
    /// The four neighbours and those two steps away in the row and the column.
    OneHop,
    /// All.
    Full,
}

pub(super) const TOPOLOGIES: &[(&str, Topology)] = &[
    ("none", Topology::None),
    ("mesh", Topology::Mesh),
    ("mesh-diagonal", Topology::MeshDiagonal),
    ("torus", Topology::Torus),
    ("one-hop", Topology::OneHop),
    ("full", Topology::Full),
];

impl Topology {
    /// The units that unit `at` reaches in an array of this size, all numbered row by row.
    pub(super) fn reached(self, rows: usize, cols: usize, at: usize) -> Vec<usize> {
        let (row, col) = ((at / cols) as isize, (at % cols) as isize);
        let mesh = [(-1, 0), (0, -1), (0, 1), (1, 0)];
        let steps: Vec<(isize, isize)> = match self {
            Topology::None => Vec::new(),
            Topology::Mesh | Topology::Torus => mesh.to_vec(),
            Topology::MeshDiagonal => {
                let diagonal = [(-1, -1), (-1, 1), (1, -1), (1, 1)];
                [mesh, diagonal].concat()
            }
            Topology::OneHop => {
                let two = [(-2, 0), (0, -2), (0, 2), (2, 0)];
                [mesh, two].concat()
            }
            Topology::Full => return (0..rows * cols).filter(|&to| to != at).collect(),
        };
        let (rows, cols) = (rows as isize, cols as isize);
        let mut reached: Vec<usize> = steps
            .into_iter()
            .map(|(down, right)| (row + down, col + right))
            .map(|(r, c)| match self {
                Topology::Torus => (r.rem_euclid(rows), c.rem_euclid(cols)),
                _ => (r, c),
            })
            .filter(|&(r, c)| (0..rows).contains(&r) && (0..cols).contains(&c))
            .map(|(r, c)| (r * cols + c) as usize)
            .filter(|&to| to != at)
            .collect();
        reached.sort_unstable();
        reached.dedup();
        reached
    }
}

/// All links of the array. Those of the topology come first, by unit; then those written.
pub(super) fn links(
    found: &Findings,
    raw: &raw::Array,
    array: Span,
    units: &Units,
) -> EntityMap<Link, LinkSpec> {
    let topology = values::word(found, &raw.topology, "topology", TOPOLOGIES);
    if raw.topology.is_none() {
        values::missing(found, "topology", "array", array);
    }
    let delay = values::number(found, &raw.link_delay, limits::LINK_DELAY, 0);
    let widest = values::width(found, &raw.link_width, "link-width", &[1, 32, 128]);
    let mut links = EntityMap::new();
    let mut seen: BTreeMap<(Fu, Fu, u32), Option<Span>> = BTreeMap::new();
    let topology = topology.unwrap_or(Topology::None);
    for from in units.fus.keys() {
        for to in topology.reached(units.rows as usize, units.cols as usize, from.index()) {
            let to = Fu::new(to);
            if links.len() < limits::MAX_LINKS {
                let width = units.link_width(from, to).min(widest.unwrap_or(128));
                links.push(LinkSpec {
                    from,
                    to,
                    delay,
                    width,
                });
                seen.insert((from, to, delay), None);
            } else if units.sized {
                too_many(found, raw.topology.as_ref().map_or(array, |t| t.span));
                return links;
            }
        }
    }
    for link in &raw.link {
        let Some(spec) = written(found, link, link.span, units) else {
            continue;
        };
        let key = (spec.from, spec.to, spec.delay);
        if let Some(&first) = seen.get(&key) {
            let message = "a link is given twice";
            let diagnostic = found.error("A0408", link.span, message, "given again");
            found.push(match first {
                Some(first) => diagnostic.also(first, "first given here"),
                None => diagnostic.note("the topology of the array has it already"),
            });
            continue;
        }
        seen.insert(key, Some(link.span));
        if links.len() == limits::MAX_LINKS {
            too_many(found, link.span);
            return links;
        }
        links.push(spec);
    }
    links
}

fn too_many(found: &Findings, at: Span) {
    let message = format!("the array has more than {} links", limits::MAX_LINKS);
    found.push(
        found
            .error("A0410", at, message, "too many")
            .help("choose a smaller array or another topology"),
    );
}

/// The link that a `<link>` means, unless its units are wrong.
fn written(found: &Findings, raw: &raw::Link, at: Span, units: &Units) -> Option<LinkSpec> {
    let end = |text: &Option<raw::Text>, name| match text {
        Some(text) => units.find(found, text),
        None => {
            values::missing(found, name, "link", at);
            None
        }
    };
    let (from, to) = (end(&raw.from, "from"), end(&raw.to, "to"));
    let delay = values::number(found, &raw.delay, limits::DELAY, 0);
    let (from, to) = (from?, to?);
    if from == to {
        let message = format!("unit `{}` is linked to itself", units.fus[from].name);
        found.push(
            found
                .error("A0408", at, message, "from and to are the same")
                .help("leave it out: a unit always reads its own output"),
        );
        return None;
    }
    let widest = units.link_width(from, to);
    let width = values::width(found, &raw.width, "width", &[1, 32, 128]).unwrap_or(widest);
    Some(LinkSpec {
        from,
        to,
        delay,
        width,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Which units unit 5 (row 1, column 1 of a 4×4 array) and unit 0 reach.
    #[track_caller]
    fn reaches(topology: Topology, inner: &[usize], corner: &[usize]) {
        assert_eq!(topology.reached(4, 4, 5), inner);
        assert_eq!(topology.reached(4, 4, 0), corner);
    }

    #[test]
    fn topologies_reach_their_neighbours() {
        reaches(Topology::None, &[], &[]);
        reaches(Topology::Mesh, &[1, 4, 6, 9], &[1, 4]);
        reaches(
            Topology::MeshDiagonal,
            &[0, 1, 2, 4, 6, 8, 9, 10],
            &[1, 4, 5],
        );
        reaches(Topology::Torus, &[1, 4, 6, 9], &[1, 3, 4, 12]);
        reaches(Topology::OneHop, &[1, 4, 6, 7, 9, 13], &[1, 2, 4, 8]);
        let others: Vec<usize> = (1..16).collect();
        assert_eq!(Topology::Full.reached(4, 4, 0), others);
        assert_eq!(Topology::Torus.reached(1, 2, 0), [1]);
        assert!(Topology::Torus.reached(1, 1, 0).is_empty());
    }
}
