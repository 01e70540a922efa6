//! Kernels: what is found of their errors, bounds and costs.

use srp_archdesc::diagnostic::Source;
use srp_archdesc::machines;
use srp_studies::kernel::{Question, Report, Study, Target, study};
use srp_toolchain::{Effort, Options, Session};
use std::path::Path;

fn studied(
    source: &Source,
    question: Question,
    points: usize,
    budget: usize,
) -> Result<Vec<Report>, String> {
    // The errors of a loop do not depend on how low its II is.
    let quick = Effort {
        percent: 5,
        ..Effort::default()
    };
    let options = Study {
        arch: srp_archdesc::parse("sgrt", machines::SGRT.xml)
            .expect("the machine that comes along"),
        options: Options {
            effort: quick,
            ..Options::default()
        },
        question,
        points,
        budget,
        grid: false,
        target: Target::parse("ulp=16").expect("a target"),
        threads: 2,
    };
    study(source, &options, &Session::default())
        .map(|studied| studied.reports)
        .map_err(|e| e.to_string())
}

fn ranges(list: &[(&str, f64, f64)]) -> Question {
    Question {
        ranges: list
            .iter()
            .map(|&(name, low, high)| (name.to_owned(), low, high))
            .collect(),
        ..Question::default()
    }
}

#[test]
fn benchmarks_keep_to_their_bounds() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fpcore/kernels.fpcore");
    let text = std::fs::read_to_string(path).expect("the benchmarks");
    let source = Source::new("kernels.fpcore", text);
    let reports = studied(&source, Question::default(), 128, 1).expect("all of them run");
    assert!(reports.len() >= 20, "{}", reports.len());
    let mut bounded = 0;
    for report in &reports {
        let (name, trial) = (&report.name, &report.trials[0]);
        assert_eq!(trial.error.not_finite, 0, "{name}");
        assert!(trial.error.compared > 0, "{name}");
        let Some(bound) = trial.bound else {
            assert!(trial.unbounded.is_some(), "{name}");
            continue;
        };
        bounded += 1;
        assert!(
            trial.error.absolute <= bound.absolute,
            "{name}: {:?} {bound:?}",
            trial.error
        );
        if let Some(relative) = bound.relative {
            assert!(
                trial.error.relative <= relative,
                "{name}: {:?} {bound:?}",
                trial.error
            );
        }
    }
    assert!(bounded >= 20, "{bounded}");
    let find = |name: &str| {
        reports
            .iter()
            .find(|r| r.name == name)
            .expect("it is there")
    };
    // Cancellation costs digits, and its cure has them.
    let (bad, good) = (
        find("quadratic root, plus"),
        find("quadratic root, plus, without cancellation"),
    );
    assert!(bad.trials[0].error.bits > good.trials[0].error.bits + 5.0);
    // 23 of Rump's 37 digits are lost even in binary64; 200 bits tell the truth.
    assert!(find("Rump's expression").trials[0].error.absolute > 1e25);
    let source = &bad.origins.origins[0];
    assert!(
        source.at.starts_with("kernels.fpcore:") || source.at.contains("math.c"),
        "{source:?}"
    );
}

#[test]
fn a_function_of_c_is_studied_by_its_parameters() {
    let text = "#pragma srp range(x, 1, 2)\nfloat f(float x)\n{\n    return 1.0f / x;\n}\n";
    let reports =
        studied(&Source::new("f.c", text), Question::default(), 512, 12).expect("it runs");
    let [report] = &reports[..] else {
        panic!("one function");
    };
    // The reciprocal comes in where the compiler may multiply by it.
    assert_eq!(report.units, ["rcp", "div"]);
    let base = &report.trials[0];
    // A correctly rounded quotient is off by half a unit in the last place at most.
    assert!(
        base.error
            .ulps
            .is_some_and(|ulps| ulps <= 0.5 && ulps > 0.4),
        "{:?}",
        base.error
    );
    let relative = base.bound.and_then(|b| b.relative).expect("it is bounded");
    assert!((5.9e-8..7e-8).contains(&relative), "{relative}");
    assert_eq!(report.origins.origins[0].at, "f.c:4");
    let coarse = report
        .trials
        .iter()
        .find(|t| t.words == "div 8 bits")
        .expect("it is tried");
    assert!(
        (4.0..9.0).contains(&(23.0 - coarse.error.ulps.map_or(0.0, f64::log2))),
        "{:?}",
        coarse.error
    );
    assert!(
        coarse.costs.cycles < base.costs.cycles,
        "{:?} {:?}",
        coarse.costs,
        base.costs
    );
    assert!(
        report.trials.iter().all(|t| t.not_exercised.is_empty()),
        "{report:?}"
    );
}

#[test]
fn arrays_pointers_and_whole_programs_are_studied() {
    let text = "void roots(float a, float b, float *x, float *y)\n{\n    *x = a + b;\n    *y = a - b;\n}\n\
                void scale(const float *in, float *out, int n)\n{\n    for (int i = 0; i < n; i++)\n        out[i] = in[i] * 0.1f;\n}\n";
    let source = Source::new("f.c", text);
    let reports =
        studied(&source, ranges(&[("a", 1.0, 2.0), ("b", 1.0, 2.0)]), 256, 1).expect("roots");
    assert_eq!(reports[0].outputs, ["x", "y"]);
    assert!(
        reports[0].trials[0]
            .error
            .ulps
            .is_some_and(|ulps| ulps <= 0.5)
    );
    let reports = studied(&source, ranges(&[("in", -1.0, 1.0)]), 4, 1).expect("scale");
    assert_eq!(reports[0].trials[0].error.compared, 4 * 64);
    assert!(
        reports[0].trials[0].bound.is_some(),
        "{:?}",
        reports[0].trials[0].unbounded
    );
    let program = "float in[8], out[8];\nint main(void)\n{\n    for (int i = 0; i < 8; i++)\n        out[i] = in[i] * in[i];\n    return 0;\n}\n";
    let reports = studied(
        &Source::new("p.c", program),
        ranges(&[("in", 0.0, 3.0)]),
        2,
        1,
    )
    .expect("a program");
    assert_eq!(
        (
            reports[0].name.as_str(),
            reports[0].trials[0].error.compared
        ),
        ("main", 16)
    );
}

#[test]
fn branches_are_bounded_on_every_way() {
    let text = "float f(float x)\n{\n    if (x < 1.0f)\n        return x * x;\n    float s = 0;\n    for (int i = 0; i < 3; i++)\n        s += x;\n    return s;\n}\n";
    let reports = studied(
        &Source::new("f.c", text),
        ranges(&[("x", 0.5, 2.0)]),
        256,
        1,
    )
    .expect("it runs");
    let trial = &reports[0].trials[0];
    let bound = trial.bound.expect("it is bounded");
    assert!(
        trial.error.absolute <= bound.absolute && bound.absolute < 1e-6,
        "{bound:?}"
    );
}

#[test]
fn what_cannot_be_studied_is_said() {
    let refused = |text: &str, question: Question| {
        studied(&Source::new("f.c", text), question, 16, 1).expect_err("it is refused")
    };
    let f = "float f(float x, float y) { return x + y; }\n";
    assert!(refused(f, ranges(&[("x", 0.0, 1.0)])).contains("`y` without a range"));
    let unknown = refused(f, ranges(&[("z", 0.0, 1.0)]));
    assert!(
        unknown.contains("parameter `z`") && unknown.contains("there are x, y"),
        "{unknown}"
    );
    assert!(refused(f, ranges(&[])).contains("no parameter or object has a range"));
    assert!(
        refused(
            "double f(double x) { return x; }\n",
            ranges(&[("x", 0.0, 1.0)])
        )
        .contains("--double float")
    );
    assert!(
        refused("void f(float x) { (void)x; }\n", ranges(&[("x", 0.0, 1.0)]))
            .contains("gives no float")
    );
    let named = Question {
        function: Some("g".to_owned()),
        ..ranges(&[("x", 0.0, 1.0)])
    };
    assert!(refused(f, named).contains("no function `g`"));
    let wrong = studied(
        &Source::new("a.fpcore", "(FPCore (x) :pre (< 0 x 1) (erf x))"),
        Question::default(),
        1,
        1,
    );
    assert!(wrong.expect_err("no erf").contains("a.fpcore:1:28: `erf`"));
}

#[test]
fn benchmarks_that_cannot_be_used_leave_the_others_alone() {
    let text = "(FPCore f (x) (erf x))\n(FPCore g (x) (+ x 1))\n";
    let source = Source::new("a.fpcore", text);
    let reports = studied(&source, Question::default(), 16, 1).expect("one of them");
    assert_eq!(reports.len(), 1);
    assert_eq!(reports[0].name, "g");
    assert!(reports[0].notes[0].contains("`x` has no range"));
}

fn of_c(text: &str, question: Question) -> Result<Report, String> {
    let source = Source::new("k.c", text.to_owned());
    let mut reports = studied(&source, question, 64, 1)?;
    reports.pop().ok_or_else(|| "no report".to_owned())
}

#[test]
fn the_root_of_a_sum_of_squares_is_bounded() {
    let text = "float norm(float x, float y, float z) { float d = x - y; \
                return __builtin_sqrtf(d * d + y * y + z * z); }";
    let wide = [("x", -1.0, 1.0), ("y", -1.0, 1.0), ("z", -1.0, 1.0)];
    let report = of_c(text, ranges(&wide)).expect("it runs");
    let (trial, bound) = (&report.trials[0], report.trials[0].bound);
    let bound = bound.unwrap_or_else(|| panic!("{:?}", trial.unbounded));
    assert!(
        bound.absolute < 2e-3 && trial.error.absolute <= bound.absolute,
        "{bound:?}"
    );
    // A product of two numbers is none, whatever their ranges.
    let text = "float f(float x, float y) { return __builtin_sqrtf(x * y); }";
    let report = of_c(text, ranges(&wide[..2])).expect("it runs");
    assert!(report.trials[0].bound.is_none());
}

#[test]
fn an_array_that_is_too_short_is_told_its_length() {
    let text =
        "float third(const float *v, float *out) { out[1] = v[0] * v[4]; return v[1] + v[2]; }";
    let with = |lengths: &[(&str, u32)]| Question {
        lengths: lengths.iter().map(|&(n, k)| (n.to_owned(), k)).collect(),
        ..ranges(&[("v", -1.0, 1.0)])
    };
    let why = of_c(text, with(&[])).expect_err("five elements are read");
    assert!(
        why.contains("--length v=5") || why.contains("--length out=2"),
        "{why}"
    );
    let why = of_c(text, with(&[("v", 5)])).expect_err("two are written");
    assert!(
        why.contains("accesses 2 elements of `out`, which has 1"),
        "{why}"
    );
    let report = of_c(text, with(&[("v", 5), ("out", 2)])).expect("it runs");
    assert!(report.trials[0].bound.is_some());
}

#[test]
fn the_ends_of_a_range_are_among_the_elements_of_arrays() {
    // Only at an end of the range is there an error.
    let text = "float f(const float *v, int n) { float s = 0; \
                for (int i = 0; i < n; i++) s += v[i] == 0.7f ? 1.0f / 3.0f : 0.0f; return s; }";
    let question = ranges(&[("v", -2.0, f64::from(0.7f32))]);
    let report = of_c(text, question).expect("it runs");
    assert!(report.trials[0].error.absolute > 0.0);
}
