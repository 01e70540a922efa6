//! A search for the points that nothing beats: NSGA-II (Deb, Pratap, Agarwal and Meyarivan, *A Fast and Elitist
//! Multiobjective Genetic Algorithm: NSGA-II*, IEEE Transactions on Evolutionary Computation 6(2), 2002).
//!
//! It proposes whole generations, whose points can be measured side by side. A generation follows from the plan, its seed
//! and the figures of the generations before, and from nothing else, so a search that was stopped proposes the same
//! points when it goes on. No point is proposed twice.

use super::front;
use super::point::{MAX_POINTS, Parameter, Point};
use super::space::{Genes, Space};
use crate::Error;
use crate::survey::Random;
use std::collections::BTreeSet;

/// Of so many children nine have two parents; the tenth is a changed copy of one.
const MIXED_OF_TEN: usize = 9;
/// Changes of a child that is known already, before any other point takes its place.
const CHANGES: usize = 32;
/// Bounds of the usual number of points of a generation.
const USUAL: (usize, usize) = (4, 100);

/// How far a search goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Budget {
    /// Points, at most.
    pub(super) points: usize,
    /// Points of a generation.
    pub(super) generation: usize,
}

impl Budget {
    /// Reads `N` or `N:P`: N points, P in a generation.
    pub(super) fn parse(text: &str) -> Option<Budget> {
        let (points, generation) = match text.split_once(':') {
            Some((points, generation)) => (points, Some(generation.parse().ok()?)),
            None => (text, None),
        };
        let points: usize = points.parse().ok()?;
        // Few, so that there are many generations to learn from; the points of one are measured side by side.
        let usual = (points as f64).sqrt().ceil() as usize;
        let generation = generation.unwrap_or(usual.clamp(USUAL.0, USUAL.1).min(points));
        let fits = (1..=MAX_POINTS).contains(&points) && (1..=points).contains(&generation);
        fits.then_some(Budget { points, generation })
    }
}

/// A search as a plan says it.
#[derive(Clone, Debug)]
pub struct Search {
    budget: Budget,
    seed: u64,
    space: Space,
}

impl Search {
    /// The search of some parameters.
    pub(super) fn new(
        budget: Budget,
        seed: u64,
        parameters: &[Parameter],
    ) -> Result<Search, Error> {
        if parameters.is_empty() {
            return Err(Error::Invalid(
                "a search needs parameters: say --set PARAMETER=VALUES, or [set] in the plan"
                    .to_owned(),
            ));
        }
        Ok(Search {
            budget,
            seed,
            space: Space::of(parameters),
        })
    }

    /// Points that it proposes in the end.
    pub fn points(&self) -> usize {
        usize::try_from(self.space.size()).map_or(self.budget.points, |s| s.min(self.budget.points))
    }

    /// Points that the plan allows.
    pub fn budget(&self) -> usize {
        self.budget.points
    }

    /// Points of a generation.
    pub fn generation(&self) -> usize {
        self.budget.generation
    }

    /// The course of the search, from its beginning.
    pub(super) fn begin(&self) -> Course<'_> {
        Course {
            search: self,
            // Draws of the same seed by another way of sampling are others.
            random: Random::new(Random::new(self.seed).draw()),
            tried: Vec::new(),
            known: BTreeSet::new(),
            parents: Vec::new(),
        }
    }
}

/// A search under way.
pub(super) struct Course<'a> {
    search: &'a Search,
    random: Random,
    /// All points that were proposed, in order.
    tried: Vec<Genes>,
    known: BTreeSet<Genes>,
    /// The numbers of the points that the next are made of, the best first.
    parents: Vec<usize>,
}

impl Course<'_> {
    /// The points of the next generation; none when the search is over.
    ///
    /// `figures` has those of every point that was proposed before, the smaller the better, and `None` of points that
    /// are no machine, or fail: they come behind all others.
    pub(super) fn next(&mut self, figures: &[Option<Vec<f64>>]) -> Vec<Point> {
        assert_eq!(figures.len(), self.tried.len(), "every point was measured");
        let space = &self.search.space;
        let count = (self.search.points() - self.tried.len()).min(self.search.budget.generation);
        let first = self.tried.len();
        if count == 0 {
            return Vec::new();
        }
        let mut begun = Vec::new();
        if first == 0 {
            begun = space.latin(count, &mut self.random);
        } else {
            self.survive(figures);
        }
        for i in 0..count {
            let child = match begun.get(i) {
                Some(point) => point.clone(),
                None => self.child(),
            };
            let child = self.unknown(child);
            self.known.insert(child.clone());
            self.tried.push(child);
        }
        self.tried[first..]
            .iter()
            .map(|genes| space.point(genes))
            .collect()
    }

    /// Chooses the parents among those before and their children: by ranks of fronts, then the loneliest first.
    fn survive(&mut self, figures: &[Option<Vec<f64>>]) {
        let size = self.search.budget.generation;
        let children = self.tried.len() - size..self.tried.len();
        let mut all: Vec<usize> = self.parents.iter().copied().chain(children).collect();
        all.sort_unstable();
        let (able, unable): (Vec<usize>, Vec<usize>) =
            all.into_iter().partition(|&i| figures[i].is_some());
        let of_able: Vec<&[f64]> = able.iter().filter_map(|&i| figures[i].as_deref()).collect();
        let ranks = front::ranks(&of_able);
        let order = ranks
            .iter()
            .flat_map(|rank| front::by_crowding(&of_able, rank));
        self.parents = order.map(|i| able[i]).chain(unable).take(size).collect();
    }

    /// A parent: the better one of two.
    fn parent(&mut self) -> usize {
        let mut draw = || self.random.below(self.parents.len());
        let better = draw().min(draw());
        self.parents[better]
    }

    /// A child of two parents, of which about one value is changed.
    fn child(&mut self) -> Genes {
        let space = &self.search.space;
        let (a, b) = (self.parent(), self.parent());
        let (a, b) = (&self.tried[a], &self.tried[b]);
        let mut child = match self.random.below(10) < MIXED_OF_TEN {
            true => space.mix(a, b, &mut self.random),
            false => a.clone(),
        };
        for parameter in 0..space.parameters() {
            if self.random.below(space.parameters()) == 0 {
                space.change(&mut child, parameter, &mut self.random);
            }
        }
        child
    }

    /// The point itself if it is new, or one that is: near it, if that is soon found.
    fn unknown(&mut self, mut genes: Genes) -> Genes {
        let space = &self.search.space;
        for _ in 0..CHANGES {
            if !self.known.contains(&genes) {
                return genes;
            }
            let parameter = self.random.below(space.parameters());
            space.change(&mut genes, parameter, &mut self.random);
        }
        // There is one left, for no more are asked for than there are.
        genes = space.any(&mut self.random);
        while self.known.contains(&genes) {
            space.advance(&mut genes);
        }
        genes
    }
}

#[cfg(test)]
mod tests;
