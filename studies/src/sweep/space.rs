//! The space of a search: every parameter's values by numbers, so that points can be mixed, changed and counted.

use super::point::{Parameter, Point};
use super::values::{Values, number, order, rounded};
use crate::survey::Random;

/// Most values of a range: numbers up to it are exact.
const MOST: u64 = 1 << 53;
/// Powers of two between the longest and the shortest step of a change.
const ORDERS: u64 = 8;
/// Steps in a unit of a range that is not of whole numbers: tables have six digits.
const STEPS: f64 = 1e6;

/// A point by the numbers of its values.
pub(super) type Genes = Vec<u64>;

/// A parameter whose values have numbers.
#[derive(Clone, Debug)]
struct Axis {
    name: String,
    scale: Scale,
}

#[derive(Clone, Debug)]
enum Scale {
    /// Values in order of their sizes, or words, none of which is nearer to another.
    Listed { values: Vec<String>, sized: bool },
    /// Whole numbers of steps: so many from this one on, of which so many make a unit.
    Stepped { from: f64, unit: f64, count: u64 },
    /// Parts of a range that is too wide for steps.
    Divided { from: f64, to: f64 },
}

impl Scale {
    fn of(values: &Values) -> Scale {
        match values {
            Values::These(listed) => {
                let mut values: Vec<String> = Vec::with_capacity(listed.len());
                let mut known = std::collections::BTreeSet::new();
                values.extend(listed.iter().filter(|v| known.insert(*v)).cloned());
                let sized = values.iter().all(|value| number(value).is_some());
                if sized {
                    values.sort_by(|a, b| order(a, b));
                }
                Scale::Listed { values, sized }
            }
            &Values::Between { from, to, whole } => {
                let unit = if whole { 1.0 } else { STEPS };
                let (first, last) = ((from * unit).round(), (to * unit).round());
                let most = MOST as f64;
                match first.abs() < most && last.abs() < most && last - first < most {
                    true => Scale::Stepped {
                        from: first,
                        unit,
                        count: (last - first) as u64 + 1,
                    },
                    false => Scale::Divided { from, to },
                }
            }
        }
    }

    fn count(&self) -> u64 {
        match self {
            Scale::Listed { values, .. } => values.len() as u64,
            Scale::Stepped { count, .. } => *count,
            Scale::Divided { .. } => MOST,
        }
    }

    fn value(&self, gene: u64) -> String {
        match self {
            Scale::Listed { values, .. } => values[gene as usize].clone(),
            Scale::Stepped { from, unit, .. } => rounded((from + gene as f64) / unit),
            Scale::Divided { from, to } => {
                rounded(from + (to - from) * (gene as f64 / (MOST - 1) as f64))
            }
        }
    }

    fn is_sized(&self) -> bool {
        !matches!(self, Scale::Listed { sized: false, .. })
    }
}

/// All points that a search may propose.
#[derive(Clone, Debug)]
pub(super) struct Space(Vec<Axis>);

impl Space {
    /// The space of some parameters.
    pub(super) fn of(parameters: &[Parameter]) -> Space {
        let axis = |parameter: &Parameter| Axis {
            name: parameter.name.clone(),
            scale: Scale::of(&parameter.values),
        };
        Space(parameters.iter().map(axis).collect())
    }

    /// How many points it has, or the largest number.
    pub(super) fn size(&self) -> u64 {
        let counts = self.0.iter().map(|axis| axis.scale.count());
        counts.fold(1, u64::saturating_mul)
    }

    /// Parameters.
    pub(super) fn parameters(&self) -> usize {
        self.0.len()
    }

    /// A point by its values.
    pub(super) fn point(&self, genes: &Genes) -> Point {
        let axes = self.0.iter().zip(genes);
        Point(
            axes.map(|(axis, &gene)| (axis.name.clone(), axis.scale.value(gene)))
                .collect(),
        )
    }

    /// So many points of a Latin hypercube; on short lists some may be the same.
    pub(super) fn latin(&self, count: usize, random: &mut Random) -> Vec<Genes> {
        let mut points = vec![Genes::new(); count];
        for axis in &self.0 {
            let mut strata: Vec<usize> = (0..count).collect();
            random.shuffle(&mut strata);
            for (point, stratum) in points.iter_mut().zip(strata) {
                let values = u128::from(axis.scale.count());
                // A place within the stratum, in parts of 2^32.
                let place = ((stratum as u128) << 32) + u128::from(random.draw() >> 32);
                point.push((place * values / ((count as u128) << 32)) as u64);
            }
        }
        points
    }

    /// A point of which each value is that of one of two others.
    pub(super) fn mix(&self, a: &Genes, b: &Genes, random: &mut Random) -> Genes {
        let pairs = a.iter().zip(b);
        pairs
            .map(|(&a, &b)| if random.below(2) == 0 { a } else { b })
            .collect()
    }

    /// Changes one value: a size by a step, which may be small or large, a word to any other.
    pub(super) fn change(&self, genes: &mut Genes, parameter: usize, random: &mut Random) {
        let scale = &self.0[parameter].scale;
        let (count, gene) = (scale.count(), &mut genes[parameter]);
        if count < 2 {
            return;
        }
        if !scale.is_sized() {
            *gene = (*gene + 1 + below(random, count - 1)) % count;
            return;
        }
        // Every order of magnitude is as likely as another, down to a part that changes little.
        let orders = u64::from(u64::BITS - (count - 1).leading_zeros()).min(ORDERS);
        let most = ((count - 1) >> below(random, orders)).max(1);
        let step = 1 + below(random, most);
        let up = random.below(2) == 0;
        let (above, under) = (count - 1 - *gene, *gene);
        *gene = match up {
            true if step <= above => *gene + step,
            false if step <= under => *gene - step,
            // Beyond the end: back from it, as far as there is room.
            true => *gene - step.min(under),
            false => *gene + step.min(above),
        };
    }

    /// The next point: the last parameter changes first, and after the last point comes the first.
    pub(super) fn advance(&self, genes: &mut Genes) {
        for (axis, gene) in self.0.iter().zip(genes.iter_mut()).rev() {
            *gene += 1;
            if *gene < axis.scale.count() {
                return;
            }
            *gene = 0;
        }
    }

    /// Any point.
    pub(super) fn any(&self, random: &mut Random) -> Genes {
        let axes = self.0.iter();
        axes.map(|axis| below(random, axis.scale.count())).collect()
    }
}

/// A number below `n` ≥ 1.
fn below(random: &mut Random, n: u64) -> u64 {
    ((u128::from(random.draw()) * u128::from(n)) >> 64) as u64
}
