//! The full-sweep builder of Wald, "On fast construction of SAH-based bounding volume
//! hierarchies" (2007): triangles sorted once along each axis, every split of every node weighed,
//! the sorted lists divided stably.

use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;

use super::{Box3, MAX_DEPTH, half_area};

/// Builds a tree whose leaves hold at most `max_leaf` boxes.
///
/// A node becomes a leaf if that costs no more than its best split; the cost of a split is
/// `traversal_cost + (A_l·N_l + A_r·N_r)/A`. The builder splits a node in the middle if no split tells the
/// boxes apart (all their centres in one point), or if the levels left down to [`MAX_DEPTH`] are only just
/// enough to halve its triangles.
pub fn sweep(boxes: &[Box3], max_leaf: u32, traversal_cost: f32) -> Bvh2 {
    let mut builder = Sweep::new(boxes, max_leaf as usize, f64::from(traversal_cost));
    if boxes.is_empty() {
        return builder.tree;
    }
    let root = builder.bounds(0, boxes.len());
    builder.tree.nodes.push(Bvh2Node::new(root, 0, 0));
    let mut open = vec![Range {
        node: 0,
        begin: 0,
        end: boxes.len(),
        level: 0,
    }];
    let mut deepest = 0;
    while let Some(range) = open.pop() {
        deepest = deepest.max(range.level);
        if let Some([left, right]) = builder.split(&range) {
            open.extend([right, left]);
        }
    }
    builder.tree.primitive_indices = builder.order.swap_remove(0);
    builder.tree.children_are_ordered_after_parents = true;
    builder.tree.max_depth = builder.tree.max_depth.max(deepest + 1);
    builder.tree
}

/// A node that is not yet split: its boxes are `order[axis][begin..end]` for each axis.
struct Range {
    node: usize,
    begin: usize,
    end: usize,
    level: usize,
}

struct Sweep<'a> {
    boxes: &'a [Box3],
    max_leaf: usize,
    traversal_cost: f64,
    tree: Bvh2,
    /// Box indices sorted by the centre along each axis.
    order: Vec<Vec<u32>>,
    /// True for each box that goes to the left child, while its node is split.
    left: Vec<bool>,
    /// Costs of the boxes to the right of each split.
    right_cost: Vec<f64>,
    scratch: Vec<u32>,
}

impl<'a> Sweep<'a> {
    fn new(boxes: &'a [Box3], max_leaf: usize, traversal_cost: f64) -> Sweep<'a> {
        // Half the sum could overflow; the sum of halves cannot.
        let centre = |i: u32, axis: usize| {
            let Aabb { min, max } = boxes[i as usize].aabb();
            0.5 * min[axis] + 0.5 * max[axis]
        };
        let sorted = |axis: usize| {
            let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
            order.sort_by(|&a, &b| {
                let by_centre = centre(a, axis).total_cmp(&centre(b, axis));
                by_centre.then(a.cmp(&b))
            });
            order
        };
        Sweep {
            boxes,
            max_leaf,
            traversal_cost,
            tree: Bvh2::default(),
            order: (0..3).map(sorted).collect(),
            left: vec![false; boxes.len()],
            right_cost: vec![0.0; boxes.len()],
            scratch: Vec::new(),
        }
    }

    fn bounds(&self, begin: usize, end: usize) -> Aabb {
        let mut bounds = Aabb::INVALID;
        for &i in &self.order[0][begin..end] {
            bounds = bounds.union(&self.boxes[i as usize].aabb());
        }
        bounds
    }

    /// Splits a node in two, or makes it a leaf.
    fn split(&mut self, range: &Range) -> Option<[Range; 2]> {
        let Range { begin, end, .. } = *range;
        let count = end - begin;
        let leaf_cost = count as f64;
        let best = (count > 1 && !self.must_halve(range))
            .then(|| self.best(range))
            .flatten();
        let (axis, middle) = match best {
            Some(Best { cost, .. }) if count <= self.max_leaf && leaf_cost <= cost => {
                return self.leaf(range);
            }
            Some(Best { axis, middle, .. }) => (axis, middle),
            None if count <= self.max_leaf => return self.leaf(range),
            None => (0, begin + count / 2),
        };
        self.divide(range, axis, middle);
        let first = self.tree.nodes.len();
        self.tree.nodes[range.node].make_inner(first as u32);
        for (from, to) in [(begin, middle), (middle, end)] {
            let bounds = self.bounds(from, to);
            self.tree.nodes.push(Bvh2Node::new(bounds, 0, 0));
        }
        let child = |node, begin, end| Range {
            node,
            begin,
            end,
            level: range.level + 1,
        };
        Some([child(first, begin, middle), child(first + 1, middle, end)])
    }

    fn leaf(&mut self, range: &Range) -> Option<[Range; 2]> {
        let node = &mut self.tree.nodes[range.node];
        node.prim_count = (range.end - range.begin) as u32;
        node.first_index = range.begin as u32;
        // Leaves read the list of axis 0; the others need not agree with it any more.
        None
    }

    /// True if any split but a halving could make the tree too deep.
    fn must_halve(&self, range: &Range) -> bool {
        let leaves = (range.end - range.begin).div_ceil(self.max_leaf);
        let halvings = leaves.next_power_of_two().trailing_zeros() as usize;
        // One level more, because halves of odd counts are uneven.
        range.level + halvings + 1 >= MAX_DEPTH
    }

    /// The cheapest split; of equal ones that nearest to the middle, then that of the first axis.
    /// `None` where all centres coincide.
    fn best(&mut self, range: &Range) -> Option<Best> {
        let Range { begin, end, .. } = *range;
        let area = half_area(self.tree.nodes[range.node].aabb());
        let mut best: Option<Best> = None;
        for axis in 0..3 {
            if !self.spreads(axis, range) {
                continue;
            }
            let mut bounds = Aabb::INVALID;
            for at in (begin + 1..end).rev() {
                bounds = bounds.union(&self.boxes[self.order[axis][at] as usize].aabb());
                self.right_cost[at] = half_area(&bounds) * (end - at) as f64;
            }
            let mut bounds = Aabb::INVALID;
            for middle in begin + 1..end {
                let i = self.order[axis][middle - 1];
                bounds = bounds.union(&self.boxes[i as usize].aabb());
                let sum = half_area(&bounds) * (middle - begin) as f64 + self.right_cost[middle];
                let candidate = Best {
                    // Boxes of no area are met by no line: their cost is 0, as of their parts.
                    cost: self.traversal_cost + if area > 0.0 { sum / area } else { 0.0 },
                    unevenness: (2 * middle).abs_diff(begin + end),
                    axis,
                    middle,
                };
                if best.as_ref().is_none_or(|b| candidate.beats(b)) {
                    best = Some(candidate);
                }
            }
        }
        best
    }

    /// True if the centres of a node's boxes differ along `axis`.
    fn spreads(&self, axis: usize, range: &Range) -> bool {
        let centre = |at: usize| {
            let b = self.boxes[self.order[axis][at] as usize].aabb();
            0.5 * b.min[axis] + 0.5 * b.max[axis]
        };
        centre(range.begin) < centre(range.end - 1)
    }

    /// Divides all three lists of a node, each keeping its order, by the split of one of them.
    fn divide(&mut self, range: &Range, axis: usize, middle: usize) {
        for at in range.begin..range.end {
            self.left[self.order[axis][at] as usize] = at < middle;
        }
        for list in &mut self.order {
            self.scratch.clear();
            let mut to = range.begin;
            for from in range.begin..range.end {
                let i = list[from];
                if self.left[i as usize] {
                    list[to] = i;
                    to += 1;
                } else {
                    self.scratch.push(i);
                }
            }
            list[to..range.end].copy_from_slice(&self.scratch);
        }
    }
}

struct Best {
    cost: f64,
    unevenness: usize,
    axis: usize,
    middle: usize,
}

impl Best {
    fn beats(&self, other: &Best) -> bool {
        self.cost < other.cost || (self.cost == other.cost && self.unevenness < other.unevenness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    fn point_boxes(centres: impl Iterator<Item = f32>) -> Vec<Box3> {
        centres
            .map(|x| Box3(Aabb::from_point(Vec3A::new(x, 0.0, 0.0))))
            .collect()
    }

    #[test]
    fn depth_is_bounded_where_centres_halve() {
        // Each split of 2^-i takes one box off: without the bound, a chain.
        let boxes = point_boxes((0..126).map(|i| 2f32.powi(-i)));
        for max_leaf in [1, 4] {
            let tree = sweep(&boxes, max_leaf, 1.0);
            assert!(super::super::depth(&tree) <= MAX_DEPTH);
            tree.validate(&boxes, false, true);
        }
    }

    #[test]
    fn identical_boxes_are_halved() {
        let boxes = point_boxes(std::iter::repeat_n(1.0, 1000));
        let tree = sweep(&boxes, 4, 1.0);
        assert_eq!(super::super::depth(&tree), 8);
        tree.validate(&boxes, false, true);
    }

    #[test]
    fn few_boxes() {
        for count in 0..4 {
            let boxes = point_boxes((0..count).map(|i| i as f32));
            let tree = sweep(&boxes, 1, 1.0);
            assert_eq!(tree.nodes.len(), (2 * boxes.len()).saturating_sub(1));
            tree.validate(&boxes, false, true);
        }
    }
}
