//! The catalogue against its oracles: every answer that it states is computed again, by arithmetic that
//! shares nothing with the kernels and the units.

mod geometry;
mod numbers;

use super::catalogue::{self, Case, Oracle};
use super::judge::ulp;
use super::picture;
use srp_runtime::scene::demo::demo;

/// A number that the catalogue states is the float nearest to what an oracle in binary64 says, or as
/// good as half way.
fn is_rounded(stated: f32, value: f64) -> bool {
    if value.is_nan() || stated.is_nan() {
        return value.is_nan() && stated.is_nan();
    }
    let stated = f64::from(stated);
    if stated == value {
        return stated.is_sign_negative() == value.is_sign_negative();
    }
    let largest = f64::from(f32::MAX);
    if stated.is_infinite() || value.is_infinite() {
        return stated == value.signum() * f64::INFINITY && value.abs() > largest;
    }
    (stated - value).abs() <= 0.5 * ulp(value) * (1.0 + 1e-6)
}

#[test]
fn the_catalogue_does_not_lie() {
    let cases = catalogue::own().unwrap_or_else(|e| panic!("{}", e.render(false)));
    assert!(cases.len() >= 1000, "{} cases", cases.len());
    let mut lies = Vec::new();
    for case in &cases {
        assert!(
            !case.source.is_empty() && !case.title.is_empty(),
            "{}",
            case.place
        );
        let said = match case.call.as_str() {
            "box" | "ray" | "leaks" | "acne" | "surface" => geometry::check(case),
            // Whether a basis is one follows from its answer; pictures are made in binary64 as they are tried.
            "basis" | "picture" => Ok(()),
            _ => numbers::check(case),
        };
        if let Err(what) = said {
            lies.push(format!("{} ({}): {what}", case.id, case.place));
        }
    }
    assert!(lies.is_empty(), "{} lies:\n{}", lies.len(), lies.join("\n"));
}

/// A picture of one colour says nothing.
#[test]
fn pictures_show_something() {
    let cases = catalogue::own().unwrap_or_else(|e| panic!("{}", e.render(false)));
    let pictures: Vec<&Case> = cases.iter().filter(|c| c.call == "picture").collect();
    assert!(pictures.len() >= 30, "{} pictures", pictures.len());
    for case in pictures {
        let shown = picture::in_binary64(case, &demo());
        let mut colours: Vec<[u8; 3]> = shown
            .iter()
            .map(|colour| colour.to_array().map(|c| c.round() as u8))
            .collect();
        colours.sort();
        colours.dedup();
        assert!(colours.len() > 2, "{}: {colours:?}", case.id);
    }
}

/// A machine that flushes subnormals answers as if its arguments were zeros.
#[test]
fn flushed_answers_are_those_of_flushed_arguments() {
    let cases = catalogue::own().unwrap_or_else(|e| panic!("{}", e.render(false)));
    let flushed: Vec<&Case> = cases.iter().filter(|c| !c.flushed.is_empty()).collect();
    assert!(flushed.len() > 10, "{}", flushed.len());
    for case in flushed {
        let mut of_zeros = Case {
            gives: case.flushed.clone(),
            ..case.clone()
        };
        for word in of_zeros.arguments.iter_mut().flat_map(|(_, words)| words) {
            if f32::from_bits(*word).is_subnormal() {
                *word &= 1 << 31;
            }
        }
        let said = numbers::check(&of_zeros);
        assert_eq!(said, Ok(()), "{} ({})", case.id, case.place);
    }
}

/// All that `numerics` lists is there, several times over.
#[test]
fn every_family_has_its_cases() {
    let cases = catalogue::own().unwrap_or_else(|e| panic!("{}", e.render(false)));
    let families: [(&str, std::ops::RangeInclusive<u32>); 10] = [
        ("S", 1..=11),
        ("T", 1..=17),
        ("O", 1..=10),
        ("M", 1..=12),
        ("X", 1..=9),
        ("C", 1..=6),
        ("R", 1..=6),
        ("B", 1..=6),
        ("F", 1..=15),
        ("H", 1..=8),
    ];
    for (letter, numbers) in families {
        for number in numbers {
            let family = format!("{letter}{number}.");
            let found = cases.iter().any(|c| c.id.starts_with(&family));
            assert!(found, "there is no case {family}");
        }
    }
    let exact = cases.iter().filter(|c| c.oracle == Oracle::Exact).count();
    assert!(exact > 100, "{exact} cases are decided by exact arithmetic");
}

/// A wrong answer for a case of each kind must be noticed.
#[test]
fn a_lie_is_noticed() {
    let cases = catalogue::own().unwrap_or_else(|e| panic!("{}", e.render(false)));
    let lie = |call: &str, gives: &[&str]| {
        let found = cases.iter().find(|c| c.call == call);
        let case = Case {
            gives: gives.iter().map(|w| (*w).to_owned()).collect(),
            ..found.expect("there is a case").clone()
        };
        match call {
            "box" | "ray" | "surface" => geometry::check(&case).is_err(),
            _ => numbers::check(&case).is_err(),
        }
    };
    assert!(lie("box", &["miss"]));
    assert!(lie("ray", &["miss"]));
    assert!(lie("surface", &["shadow", "dark"]));
    assert!(lie("unit", &["1", "0.0000001", "0"]));
    assert!(lie("power", &["0.5"]));
    assert!(lie("texture", &["0.5", "0.5", "0.5", "0.5"]));
    assert!(lie("bytes", &["xff000000"]));
    assert!(lie("fma", &["1"]));
    assert!(lie("powf", &["2"]));
    assert!(lie("radical-inverse", &["0.5"]));
    assert!(lie("sequence-x", &["0.75"]));
    assert!(lie("bounce", &["0", "1", "0", "1"]));
    assert!(lie("bounce-weight", &["1", "1", "1"]));
    assert!(lie("sum", &["102.4", "341.3333", "716.8"]));
}
