//! Searches of a model of a machine that costs nothing to measure, so that its front is known.

use super::super::front;
use super::super::point::Target;
use super::super::values::Values;
use super::*;
use std::process::Command;

/// A parameter with values as on the command line.
fn parameter(name: &str, values: &str) -> Parameter {
    Parameter {
        name: name.to_owned(),
        target: Target::Effort,
        values: Values::parse(values).expect("values"),
    }
}

/// 8 × 8 × 7 × 6 × 4 points; a sixth of them are no machines.
fn model() -> Vec<Parameter> {
    vec![
        parameter("cache", "1K,2K,4K,8K,16K,32K"),
        parameter("cols", "1:8:1"),
        parameter("latency", "2..8"),
        parameter("rows", "1:8:1"),
        parameter("units", "slow,plain,fast,huge"),
    ]
}

/// Time and area.
fn measure(point: &Point) -> Option<Vec<f64>> {
    let number = |name: &str| super::super::values::number(&point.0[name]).expect("a number");
    let (rows, cols) = (number("rows"), number("cols"));
    let (speed, size) = match point.0["units"].as_str() {
        "slow" => (0.6, 0.7),
        "plain" => (1.0, 1.0),
        "fast" => (1.3, 1.6),
        _ => (1.35, 3.0),
    };
    let time = (64.0 / (rows * cols)).max(4.0) / speed
        + number("latency")
        + 4096.0 / number("cache")
        + (rows - cols).abs() * 0.1;
    let area = rows * cols * size * (1.0 + 4.0 / number("latency")) + number("cache") / 2048.0;
    (rows <= 2.0 * cols || rows < 4.0).then(|| vec![time, area])
}

/// The whole course of a search: every point with its figures.
fn course(
    search: &Search,
    figures: impl Fn(&Point) -> Option<Vec<f64>>,
) -> Vec<(Point, Option<Vec<f64>>)> {
    let mut course = search.begin();
    let mut all: Vec<(Point, Option<Vec<f64>>)> = Vec::new();
    loop {
        let known: Vec<Option<Vec<f64>>> = all.iter().map(|(_, figures)| figures.clone()).collect();
        let points = course.next(&known);
        if points.is_empty() {
            return all;
        }
        assert!(points.len() <= search.generation());
        all.extend(
            points
                .into_iter()
                .map(|point| (point.clone(), figures(&point))),
        );
    }
}

fn search(budget: &str, seed: u64, parameters: &[Parameter]) -> Search {
    let budget = Budget::parse(budget).expect("a budget");
    Search::new(budget, seed, parameters).expect("a search")
}

/// The part of the box of the model's figures that these dominate.
fn volume(figures: impl Iterator<Item = Option<Vec<f64>>>) -> f64 {
    let scaled = |f: Vec<f64>| vec![(f[0] - 5.0) / 170.0, (f[1] - 2.0) / 600.0];
    front::volume(figures.flatten().map(scaled).collect())
}

/// How much of the front's volume a search of so many points misses, over some seeds.
fn missed(points: usize, seeds: u64) -> f64 {
    let of = |seed| {
        let found = course(&search(&points.to_string(), seed, &model()), measure);
        volume(found.into_iter().map(|(_, figures)| figures))
    };
    let whole = whole();
    (0..seeds).map(|seed| whole - of(seed)).sum::<f64>() / seeds as f64
}

/// The volume of the model's front.
fn whole() -> f64 {
    let space = Space::of(&model());
    let mut genes = vec![0; space.parameters()];
    let all = (0..space.size()).map(|_| {
        space.advance(&mut genes);
        measure(&space.point(&genes))
    });
    volume(all)
}

#[test]
fn a_search_comes_closer_to_the_front_than_chance() {
    let space = Space::of(&model());
    let drawn = |seed| {
        let mut random = Random::new(seed);
        let drawn = (0..400).map(|_| measure(&space.point(&space.any(&mut random))));
        volume(drawn)
    };
    let whole = whole();
    let chance = (0..10).map(|seed| whole - drawn(seed)).sum::<f64>() / 10.0;
    let search = missed(400, 10);
    assert!(search < 0.5 * chance, "{search} of {chance} by chance");
}

#[test]
fn a_search_misses_no_more_than_that_of_others() {
    let script = include_str!("optuna.py");
    let others = Command::new("python3")
        .args(["-c", script, "200", "5"])
        .output();
    let Some(others) = others.ok().filter(|others| others.status.success()) else {
        println!("skipped: there is no optuna for python3");
        return;
    };
    // Every line is a point: seed, then settings; the figures are those of the model here.
    let text = String::from_utf8(others.stdout).expect("a table");
    let whole = whole();
    let mut of_seeds = vec![Vec::new(); 5];
    for line in text.lines() {
        let (seed, settings) = line.split_once(' ').expect("two parts");
        let settings = settings
            .split(' ')
            .map(|s| s.split_once('=').expect("a setting"));
        let point = Point(
            settings
                .map(|(a, b)| (a.to_owned(), b.to_owned()))
                .collect(),
        );
        of_seeds[seed.parse::<usize>().expect("a number")].push(measure(&point));
    }
    let missed_by_others = of_seeds.into_iter().map(|points| {
        assert_eq!(points.len(), 200);
        whole - volume(points.into_iter())
    });
    let others = missed_by_others.sum::<f64>() / 5.0;
    let own = missed(200, 5);
    assert!(own <= others, "{own} of {others} by others");
}

#[test]
fn every_point_is_proposed_once_until_there_are_no_more() {
    let parameters = [
        parameter("a", "3,1,2,1"),
        parameter("b", "x,y"),
        parameter("c", "-1..2"),
        parameter("d", "0.5..0.500002"),
    ];
    let small = search("100", 3, &parameters);
    assert_eq!((small.points(), small.generation()), (72, 10));
    // Nothing can be learnt from figures that are all the same, or not there.
    for figures in [Some(vec![1.0, 2.0]), None] {
        let found = course(&small, |_| figures.clone());
        let mut points: Vec<String> = found.iter().map(|(p, _)| format!("{:?}", p.0)).collect();
        points.sort();
        points.dedup();
        assert_eq!(points.len(), 72);
    }
    let wide = search(
        "60",
        3,
        &[parameter("e", "1e-3..1e300"), parameter("f", "1..64")],
    );
    assert_eq!(course(&wide, |_| None).len(), 60);
}

#[test]
fn a_single_objective_is_a_search_for_its_least_figure() {
    let ranges = [parameter("e", "0.0..100"), parameter("f", "-64..64")];
    let number = |point: &Point, name: &str| point.0[name].parse::<f64>().expect("a number");
    let off = |point: &Point| {
        let (e, f) = (number(point, "e"), number(point, "f"));
        assert!((0.0..=100.0).contains(&e) && (-64.0..=64.0).contains(&f) && f.fract() == 0.0);
        Some(vec![(e - 33.3).abs() + (f - 20.0).abs()])
    };
    for seed in 0..5 {
        let found = course(&search("300", seed, &ranges), off);
        let figures = found
            .iter()
            .filter_map(|(_, figures)| Some(figures.as_ref()?[0]));
        let least = figures.fold(f64::INFINITY, f64::min);
        assert!(least < 1.0, "{least} of seed {seed}");
    }
}

#[test]
fn generations_follow_from_seed_and_figures_alone() {
    let points = |seed, figures: fn(&Point) -> Option<Vec<f64>>| -> Vec<Point> {
        let found = course(&search("90:30", seed, &model()), figures);
        found.into_iter().map(|(point, _)| point).collect()
    };
    let first = points(1, measure);
    assert_eq!(first, points(1, measure));
    assert_ne!(first[..30], points(2, measure)[..30]);
    let other = points(1, |point| measure(point).map(|f| vec![-f[0], f[1]]));
    assert_eq!(first[..30], other[..30]);
    assert_ne!(first[30..], other[30..]);
}

#[test]
fn budgets_are_read() {
    let read = |text| Budget::parse(text).map(|b| (b.points, b.generation));
    assert_eq!(read("60"), Some((60, 8)));
    assert_eq!(read("3"), Some((3, 3)));
    assert_eq!(read("60:20"), Some((60, 20)));
    for wrong in ["", "0", "60:0", "60:61", "60:x", "1000001", "60:20:1"] {
        assert_eq!(read(wrong), None, "{wrong}");
    }
}
