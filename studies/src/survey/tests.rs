use super::*;

fn unit(random: &mut Random) -> f64 {
    random.draw() as f64 / u64::MAX as f64
}

/// Sizes and values: three kinds of units in runs, with few of the largest kind; values follow the sizes with
/// noise that grows with them.
fn population(random: &mut Random) -> (Vec<f64>, Vec<f64>) {
    let (mut sizes, mut values) = (Vec::new(), Vec::new());
    for run in 0..60 {
        let level = [10.0, 25.0, 25.0, 160.0][random.below(4)];
        for _ in 0..20 + run % 7 {
            let x = level * (0.9 + 0.4 * unit(random));
            sizes.push(x);
            values.push(40.0 + 3.0 * x * (0.7 + 0.6 * unit(random)));
        }
    }
    (sizes, values)
}

fn draw(population: &Population, seed: u64, draws: usize) -> Vec<u32> {
    population.batches(seed)[..draws].concat()
}

#[test]
fn batches_part_the_population_and_draw_every_stratum() {
    let (sizes, _) = population(&mut Random::new(3));
    let population = Population::sized(sizes.clone(), 30);
    assert!((20..=45).contains(&population.strata()));
    let batches = population.batches(9);
    let mut all = batches.concat();
    all.sort_unstable();
    assert!(all.into_iter().eq(0..sizes.len() as u32));
    assert_eq!(batches[0].len(), population.strata());
    assert_eq!(batches[1].len(), population.strata());
    assert_eq!(population.batches(9), batches);
    assert_ne!(population.batches(10), batches);
    // The large are drawn more often than the small.
    let mean =
        |units: &[u32]| units.iter().map(|&u| sizes[u as usize]).sum::<f64>() / units.len() as f64;
    let everything: Vec<u32> = (0..sizes.len() as u32).collect();
    assert!(mean(&batches[0]) > 1.3 * mean(&everything));
}

#[test]
fn intervals_cover_known_totals_and_ratios_in_19_of_20_samples() {
    let mut random = Random::new(17);
    let (sizes, values) = population(&mut random);
    let hits: Vec<f64> = values
        .iter()
        .map(|y| y * (0.5 + 0.4 * unit(&mut random)))
        .collect();
    let total: f64 = values.iter().sum();
    let rate = hits.iter().sum::<f64>() / total;
    let population = Population::sized(sizes, 40);
    let (mut covered, mut rates, mut error, mut plain) = (0, 0, 0.0, 0.0);
    let trials = 2000;
    for seed in 0..trials {
        let units = draw(&population, seed, 3);
        let sample = Sample::new(&population, &units);
        let of = |v: &[f64]| -> Vec<f64> { units.iter().map(|&u| v[u as usize]).collect() };
        let estimate = sample.total(&of(&values));
        covered += u32::from(estimate.covers(total));
        rates += u32::from(sample.ratio(&of(&hits), &of(&values)).covers(rate));
        error += (estimate.value - total) * (estimate.value - total);
        // The estimate of a sample without strata and sizes.
        let mut any: Vec<usize> = (0..values.len()).collect();
        random.shuffle(&mut any);
        let mean = any[..units.len()].iter().map(|&u| values[u]).sum::<f64>() / units.len() as f64;
        let off = mean * values.len() as f64 - total;
        plain += off * off;
    }
    assert!((1860..=1950).contains(&covered), "{covered}");
    assert!((1860..=1950).contains(&rates), "{rates}");
    assert!(error < plain / 10.0, "{error} {plain}");
}

/// Auxiliary variables explain more than sizes, though columns repeat each other, are empty or tell nothing;
/// and few units do not get many slopes.
#[test]
fn more_columns_make_narrower_intervals_that_hold() {
    let mut random = Random::new(29);
    let (sizes, _) = population(&mut random);
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut values = Vec::new();
    for &x in &sizes {
        let (a, b) = (x * unit(&mut random), x * unit(&mut random));
        let noise = unit(&mut random);
        rows.push(vec![x, 1.0, 0.0, a, 2.0 * a, b, x + a, noise]);
        values.push(3.0 * a + 7.0 * b + 20.0 + 0.2 * x * unit(&mut random));
    }
    let total: f64 = values.iter().sum();
    let known = Population::of(sizes.clone(), rows, 40);
    let sized = Population::sized(sizes, 40);
    let (mut covered, mut narrow, mut wide) = (0, 0.0, 0.0);
    for seed in 0..1000 {
        let units = draw(&known, seed, 2);
        let drawn: Vec<f64> = units.iter().map(|&u| values[u as usize]).collect();
        let estimate = Sample::new(&known, &units).total(&drawn);
        covered += u32::from(estimate.covers(total));
        narrow += estimate.half_width;
        wide += Sample::new(&sized, &units).total(&drawn).half_width;
    }
    assert!((930..=985).contains(&covered), "{covered}");
    assert!(narrow < wide / 3.0, "{narrow} {wide}");
    let few = &draw(&known, 1, 1)[..7];
    assert!(Sample::new(&known, few).total(&[1.0; 7]).value.is_finite());
}

#[test]
fn a_census_is_exact_and_too_little_is_said_to_be() {
    let (sizes, values) = population(&mut Random::new(5));
    let total: f64 = values.iter().sum();
    let population = Population::sized(sizes, 20);
    let all: Vec<u32> = (0..values.len() as u32).collect();
    let census = Sample::new(&population, &all).total(&values);
    assert!((census.value - total).abs() < 1e-6 * total);
    assert_eq!(census.half_width, 0.0);
    let one = draw(&population, 1, 1);
    let few: Vec<f64> = one.iter().map(|&u| values[u as usize]).collect();
    assert_eq!(
        Sample::new(&population, &one).total(&few).half_width,
        f64::INFINITY
    );
}

/// Stopping by the rule must not spoil the coverage.
#[test]
fn stopping_when_the_error_is_met_keeps_the_promise() {
    let (sizes, values) = population(&mut Random::new(23));
    let total: f64 = values.iter().sum();
    let population = Population::sized(sizes, 40);
    let target = 0.02;
    let (mut covered, trials) = (0, 1000);
    for seed in 0..trials {
        let batches = population.batches(seed);
        let mut draws = LEAST_DRAWS;
        let estimate = loop {
            let units = batches[..draws].concat();
            let drawn: Vec<f64> = units.iter().map(|&u| values[u as usize]).collect();
            let estimate = Sample::new(&population, &units).total(&drawn);
            if estimate.relative() <= target || draws == batches.len() {
                break estimate;
            }
            draws = draws_needed(draws, estimate.relative(), target).min(batches.len());
        };
        assert!(estimate.relative() <= target);
        covered += u32::from(estimate.covers(total));
    }
    assert!(covered >= 930, "{covered}");
}

#[test]
fn ratios_of_simple_samples_hold_in_19_of_20_cases() {
    let mut random = Random::new(41);
    let mut covered = 0;
    for _ in 0..2000 {
        let below: Vec<f64> = (0..24).map(|_| 50.0 + 30.0 * unit(&mut random)).collect();
        let above: Vec<f64> = below
            .iter()
            .map(|b| b * (0.2 + 0.4 * unit(&mut random)))
            .collect();
        covered += u32::from(ratio(&above, &below).covers(0.4));
    }
    assert!((1860..=1945).contains(&covered), "{covered}");
    assert_eq!(ratio(&[1.0], &[2.0]).half_width, f64::INFINITY);
}

#[test]
fn quantiles_of_student() {
    for (freedom, t) in [
        (1.0, 12.706),
        (2.0, 4.303),
        (3.0, 3.182),
        (5.0, 2.571),
        (10.0, 2.228),
        (120.0, 1.980),
    ] {
        let got = student(freedom);
        assert!((got / t - 1.0).abs() < 0.01, "{freedom}: {got}");
    }
}

/// Of a population only a random part is looked at, and of that a part drawn: the intervals know of both.
#[test]
fn what_was_not_looked_at_widens_intervals_as_it_must() {
    let mut random = Random::new(53);
    let (sizes, values) = population(&mut random);
    let all = sizes.len();
    let ones: Vec<f64> = sizes
        .iter()
        .map(|x| 5.0 + 0.1 * x * unit(&mut random))
        .collect();
    let total: f64 = values.iter().sum();
    let mean = ones.iter().sum::<f64>() / sizes.iter().sum::<f64>();
    let (mut covered, mut known, mut width) = (0, 0, 0.0);
    for seed in 0..2000 {
        let mut random = Random::new(seed);
        let (mut strata, mut rows, mut units) = (Vec::new(), Vec::new(), Vec::new());
        let mut drawn = Vec::new();
        for h in 0..20 {
            let mut of: Vec<usize> = (all * h / 20..all * (h + 1) / 20).collect();
            random.shuffle(&mut of);
            let first = rows.len() as u32;
            let looked = 12;
            for &u in &of[..looked] {
                rows.push(vec![sizes[u], 1.0, ones[u]]);
                units.push(u);
            }
            drawn.extend(first..first + 4);
            strata.push(Stratum {
                of: of.len() as f64,
                looked: (first..first + looked as u32).collect(),
            });
        }
        let sample = Sample::new(&Population::looked_at(rows, strata), &drawn);
        let of: Vec<f64> = drawn.iter().map(|&u| values[units[u as usize]]).collect();
        let estimate = sample.total(&of);
        covered += u32::from(estimate.covers(total));
        known += u32::from(sample.known(2, 0).covers(mean));
        let variance = sample.variance(&of);
        assert!(variance.unlooked > 0.0 && variance.drawn > 0.0);
        width += estimate.half_width / (variance.unlooked + variance.drawn).sqrt();
    }
    assert!((1850..=1950).contains(&covered), "{covered}");
    assert!((1850..=1950).contains(&known), "{known}");
    // The parts add up to the whole, times Student's t.
    assert!((1.96..2.3).contains(&(width / 2000.0)), "{width}");
}
