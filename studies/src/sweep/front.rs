//! Figures of several objectives compared: fronts, how crowded they are, and the volume that they dominate. All figures
//! here are the better the smaller they are.

use std::cmp::Ordering;

/// True if figures are as good as others in all objectives and better in one.
pub(super) fn dominates(a: &[f64], b: &[f64]) -> bool {
    let pairs = || a.iter().zip(b);
    pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
}

/// The numbers of those that no other dominates.
pub(super) fn front(all: &[Vec<f64>]) -> Vec<usize> {
    let stays = |i: &usize| !all.iter().any(|other| dominates(other, &all[*i]));
    (0..all.len()).filter(stays).collect()
}

/// The front of each rank: the first is that of all, each further one that of what is left (the fast non-dominated sort of
/// Deb, Pratap, Agarwal and Meyarivan, *A Fast and Elitist Multiobjective Genetic Algorithm: NSGA-II*, IEEE Transactions
/// on Evolutionary Computation 6(2), 2002).
pub(super) fn ranks(all: &[&[f64]]) -> Vec<Vec<usize>> {
    let mut worse: Vec<Vec<usize>> = vec![Vec::new(); all.len()];
    let mut better = vec![0; all.len()];
    for (a, figures) in all.iter().enumerate() {
        for (b, others) in all.iter().enumerate() {
            if dominates(figures, others) {
                worse[a].push(b);
                better[b] += 1;
            }
        }
    }
    let mut fronts = Vec::new();
    let mut front: Vec<usize> = (0..all.len()).filter(|&i| better[i] == 0).collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for &i in &front {
            for &j in &worse[i] {
                better[j] -= 1;
                if better[j] == 0 {
                    next.push(j);
                }
            }
        }
        next.sort_unstable();
        fronts.push(std::mem::replace(&mut front, next));
    }
    fronts
}

/// A front from the loneliest to the most crowded: by the distances of neighbours in every objective (Deb et al. 2002), ends
/// first. Of those with the same figures the first counts; the others come last.
pub(super) fn by_crowding(all: &[&[f64]], front: &[usize]) -> Vec<usize> {
    let mut once: Vec<usize> = Vec::with_capacity(front.len());
    let mut again = Vec::new();
    for &i in front {
        match once.iter().any(|&j| all[j] == all[i]) {
            true => again.push(i),
            false => once.push(i),
        }
    }
    let mut distance = vec![0.0; once.len()];
    let objectives = all.first().map_or(0, |figures| figures.len());
    let of = |objective: usize| once.iter().map(|&i| all[i][objective]).collect();
    for figures in (0..objectives).map(of) {
        let figures: Vec<f64> = figures;
        let mut order: Vec<usize> = (0..once.len()).collect();
        order.sort_by(|&a, &b| figures[a].total_cmp(&figures[b]));
        let (Some(&first), Some(&last)) = (order.first(), order.last()) else {
            continue;
        };
        let width = figures[last] - figures[first];
        distance[first] = f64::INFINITY;
        distance[last] = f64::INFINITY;
        if width > 0.0 {
            for around in order.windows(3) {
                distance[around[1]] += (figures[around[2]] - figures[around[0]]) / width;
            }
        }
    }
    let mut order: Vec<usize> = (0..once.len()).collect();
    order.sort_by(|&a, &b| (distance[b].total_cmp(&distance[a])).then(once[a].cmp(&once[b])));
    let order = order.into_iter().map(|i| once[i]);
    order.chain(again).collect()
}

/// The volume that a point dominates within the box from 0 to 1, and no other point does (the algorithm WFG: While,
/// Bradstreet and Barone, *A Fast Way of Calculating Exact Hypervolumes*, IEEE Transactions on Evolutionary Computation
/// 16(1), 2012).
pub(super) fn own_volume(point: &[f64], others: &[Vec<f64>]) -> f64 {
    let whole: f64 = point.iter().map(|p| (1.0 - p).max(0.0)).product();
    let limited = |other: &Vec<f64>| -> Vec<f64> {
        let pairs = other.iter().zip(point);
        pairs.map(|(a, b)| a.max(*b)).collect()
    };
    let limited: Vec<Vec<f64>> = others.iter().map(limited).collect();
    (whole - volume(limited)).max(0.0)
}

/// The volume that points dominate within the box from 0 to 1.
pub(super) fn volume(mut points: Vec<Vec<f64>>) -> f64 {
    points.retain(|point| point.iter().all(|p| *p < 1.0));
    points.sort_by(|a, b| lexical(a, b));
    points.dedup();
    let mut kept: Vec<Vec<f64>> = Vec::with_capacity(points.len());
    for point in points {
        // Nothing that comes later is smaller in the first objective that differs, so it dominates nothing before.
        if !kept.iter().any(|other| dominates(other, &point)) {
            kept.push(point);
        }
    }
    match kept.first().map(Vec::len) {
        None => 0.0,
        Some(1) => 1.0 - kept[0][0],
        Some(2) => {
            // The second figures fall from point to point.
            let mut above = 1.0;
            let strip = |point: &Vec<f64>| {
                let strip = (1.0 - point[0]) * (above - point[1]);
                above = point[1];
                strip
            };
            kept.iter().map(strip).sum()
        }
        Some(_) => {
            let own = |i: usize| own_volume(&kept[i], &kept[i + 1..]);
            (0..kept.len()).map(own).sum()
        }
    }
}

fn lexical(a: &[f64], b: &[f64]) -> Ordering {
    let orders = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
    orders.fold(Ordering::Equal, Ordering::then)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::Random;

    /// Points on a coarse grid, so that figures are often the same.
    fn drawn(count: usize, objectives: usize, random: &mut Random) -> Vec<Vec<f64>> {
        let mut figure = || random.below(9) as f64 / 8.0;
        let mut point = || (0..objectives).map(|_| figure()).collect();
        (0..count).map(|_| point()).collect()
    }

    #[test]
    fn ranks_are_fronts_of_what_is_left() {
        let mut random = Random::new(1);
        for objectives in 1..5 {
            let all = drawn(60, objectives, &mut random);
            let figures: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
            let mut left: Vec<usize> = (0..all.len()).collect();
            for rank in ranks(&figures) {
                let kept: Vec<Vec<f64>> = left.iter().map(|&i| all[i].clone()).collect();
                let expected: Vec<usize> = front(&kept).into_iter().map(|i| left[i]).collect();
                assert_eq!(rank, expected);
                left.retain(|i| !rank.contains(i));
            }
            assert!(left.is_empty());
        }
    }

    #[test]
    fn volumes_are_those_of_counted_cells() {
        let mut random = Random::new(2);
        for objectives in 1..5 {
            for _ in 0..20 {
                let all = drawn(12, objectives, &mut random);
                let cells = 8usize.pow(objectives as u32);
                let lies_in = |cell: &usize| {
                    let corner = |o| (cell / 8usize.pow(o as u32) % 8) as f64 / 8.0;
                    let within = |point: &Vec<f64>| (0..objectives).all(|o| point[o] <= corner(o));
                    all.iter().any(within)
                };
                let counted = (0..cells).filter(lies_in).count() as f64 / cells as f64;
                assert!((volume(all.clone()) - counted).abs() < 1e-12, "{all:?}");
                let own = own_volume(&all[0], &all[1..]);
                let rest = volume(all[1..].to_vec());
                assert!((own + rest - counted).abs() < 1e-12, "{all:?}");
            }
        }
    }

    #[test]
    fn ends_and_lonely_points_come_before_crowded_ones() {
        let all = [
            [0.0, 1.0],
            [0.1, 0.9],
            [0.2, 0.8],
            [0.6, 0.4],
            [1.0, 0.0],
            [0.6, 0.4],
        ];
        let figures: Vec<&[f64]> = all.iter().map(|f| &f[..]).collect();
        let order = by_crowding(&figures, &[0, 1, 2, 3, 4, 5]);
        assert_eq!(order, [0, 4, 3, 2, 1, 5]);
    }
}
