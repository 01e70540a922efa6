//! The calls that a case can make, the arguments and answers that each takes, and limits on their sizes: a case
//! that passes can be tried.

use super::super::functions::{self, Function};
use super::{Case, Level, number};
use srp_archdesc::datapath::Intersection;
use srp_runtime::scene::{MAX_BOUNCES, MAX_SAMPLES};

/// Most rays of a case.
const MAX_RAYS: f32 = 1e6;

/// Most triangles of a mesh that a case names by numbers.
const MAX_TRIANGLES: f32 = 1e6;

/// Longest side of a texture.
const MAX_SIDE: f32 = 65536.0;

/// Longest side of a picture.
const MAX_PICTURE_SIDE: f32 = 256.0;

/// Most texels of one.
const MAX_TEXELS: f32 = 262_144.0;

/// Why a case cannot be tried.
pub(super) struct Refusal {
    /// The keyword of the line that is wrong.
    pub(super) keyword: &'static str,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

fn refuse<T>(
    keyword: &'static str,
    message: impl Into<String>,
    help: Option<String>,
) -> Result<T, Refusal> {
    Err(Refusal {
        keyword,
        message: message.into(),
        help,
    })
}

/// An argument: its name, the least and the most words, and whether a call is nothing without it.
type Argument = (&'static str, usize, usize, bool);

/// Arguments that stand for triangles.
const MESHES: [Argument; 7] = [
    ("tri", 9, 9 << 10, false),
    ("sphere", 6, 6, false),
    ("grid", 1, 1, false),
    ("identical", 1, 1, false),
    ("nested", 1, 1, false),
    ("ladder", 1, 1, false),
    ("scene", 0, 0, false),
];

/// A call: its arguments, and the levels that have it.
struct Form {
    arguments: Vec<Argument>,
    levels: &'static [Level],
}

/// Arguments of pictures.
const PICTURE: [Argument; 19] = [
    ("size", 2, 2, true),
    ("eye", 3, 3, true),
    ("at", 3, 3, true),
    ("up", 3, 3, false),
    ("fov", 1, 1, false),
    ("light", 3, 3, false),
    ("ambient", 1, 1, false),
    ("background", 3, 3, false),
    ("samples", 1, 1, false),
    ("bounces", 1, 1, false),
    ("inter", 1, 1, false),
    ("occlusion", 2, 2, false),
    ("diffuse", 3, 3, false),
    ("shiny", 2, 2, false),
    ("mirror", 1, 1, false),
    ("glass", 2, 2, false),
    ("glow", 1, 1, false),
    ("moved", 3, 3, false),
    ("scaled", 1, 1, false),
];

/// The form of a call that is more than one function of the driver.
fn own_form(call: &str) -> Option<Form> {
    const RAY: [Argument; 2] = [("from", 3, 3, true), ("along", 3, 3, true)];
    const AIMED: [Argument; 6] = [
        ("rays", 1, 1, true),
        ("seed", 1, 1, true),
        ("edges", 0, 0, false),
        ("vertices", 0, 0, false),
        ("faces", 0, 0, false),
        ("grazing", 0, 0, false),
    ];
    let (own, with_meshes, levels): (&[&[Argument]], bool, &[Level]) = match call {
        "ray" => (
            &[&RAY, &[("range", 2, 2, false), ("any", 0, 0, false)]],
            true,
            &[Level::Tni],
        ),
        "box" => (
            &[
                &RAY,
                &[
                    ("low", 3, 3, true),
                    ("high", 3, 3, true),
                    ("range", 2, 2, false),
                ],
            ],
            false,
            &[Level::Host, Level::Srp, Level::Tni],
        ),
        "surface" => (
            &[&[
                ("tri", 9, 9 << 10, true),
                ("weights", 2, 2, true),
                ("view", 3, 3, true),
                ("light", 3, 3, true),
                ("index", 1, 1, true),
                ("normals", 9, 9, false),
            ]],
            false,
            &[Level::Host, Level::Srp],
        ),
        "leaks" => (&[&AIMED], true, &[Level::Tni]),
        "acne" => (
            &[&AIMED, &[("light", 3, 3, false), ("index", 1, 1, true)]],
            true,
            &[Level::Srp],
        ),
        "picture" => (&[&PICTURE], true, &[Level::Frame]),
        _ => return None,
    };
    let meshes = MESHES.into_iter().filter(|_| with_meshes);
    Some(Form {
        arguments: own.concat().into_iter().chain(meshes).collect(),
        levels,
    })
}

/// The form of a function of the driver.
fn function_form(function: &Function) -> Form {
    let arguments = function.arguments.iter().map(|&name| (name, 1, 4, false));
    let size = (function.name == "texture").then_some(("size", 2, 4, false));
    Form {
        arguments: arguments.chain(size).collect(),
        // The host's library is not what kernels are linked with.
        levels: match function.name {
            "math" => &[Level::Srp],
            _ => &[Level::Host, Level::Srp],
        },
    }
}

/// Checks that a case can be tried.
pub(super) fn check(case: &Case) -> Result<(), Refusal> {
    if case.call.is_empty() {
        return refuse("case", "it has no `call`", None);
    }
    let own = own_form(&case.call);
    let function = functions::find(&case.call).filter(|_| own.is_none());
    let form = own.or(function.map(function_form));
    let Some(form) = form else {
        let known = "docs/hard-cases.md lists the calls";
        return refuse(
            "call",
            format!("nothing is called `{}`", case.call),
            Some(known.to_owned()),
        );
    };
    if case.gives.is_empty() {
        return refuse("case", "it has no `gives`", None);
    }
    levels(case, &form)?;
    arguments(case, &form)?;
    sizes(case)?;
    if case.call == "picture" {
        picture(case)?;
    }
    for (keyword, answer) in answers(case) {
        match function {
            Some(function) if function.name != "basis" => numbers(function, keyword, answer)?,
            _ => words(&case.call, keyword, answer)?,
        }
    }
    names(case)
}

fn counted(numbers: usize) -> String {
    match numbers {
        1 => "1 number".to_owned(),
        n => format!("{n} numbers"),
    }
}

fn levels(case: &Case, form: &Form) -> Result<(), Refusal> {
    let names = |levels: &[Level]| {
        levels
            .iter()
            .map(|l| l.name())
            .collect::<Vec<_>>()
            .join(", ")
    };
    if case.levels.is_empty() {
        return refuse(
            "case",
            "no line says which levels it runs at",
            Some(format!(
                "write `on {}`",
                names(form.levels).replace(',', "")
            )),
        );
    }
    match case.levels.iter().find(|l| !form.levels.contains(l)) {
        Some(other) => refuse(
            "on",
            format!("`{}` does not run at the level {}", case.call, other.name()),
            Some(format!("it runs at: {}", names(form.levels))),
        ),
        None => Ok(()),
    }
}

fn arguments(case: &Case, form: &Form) -> Result<(), Refusal> {
    for (name, values) in &case.arguments {
        let found = form.arguments.iter().find(|(known, ..)| known == name);
        let Some(&(_, least, most, _)) = found else {
            let names = form.arguments.iter().map(|(name, ..)| *name);
            let names = names.collect::<Vec<_>>().join(", ");
            let why = format!("`{}` has no argument `{name}`", case.call);
            return refuse("call", why, Some(format!("its arguments are {names}")));
        };
        if !(least..=most).contains(&values.len()) || (name == "tri" && values.len() % 9 != 0) {
            let takes = match (name.as_str(), least, most) {
                ("tri", ..) => format!("9 numbers a triangle, of at most {} triangles", most / 9),
                (_, least, most) if least == most => counted(least),
                _ => format!("{least} to {most} numbers"),
            };
            let why = format!("`{name}` has {} and takes {takes}", counted(values.len()));
            return refuse("call", why, None);
        }
    }
    let missing = |(name, _, _, needed): &&Argument| *needed && case.argument(name).is_none();
    match form.arguments.iter().find(missing) {
        Some((name, ..)) => refuse("call", format!("`{}` needs `{name}`", case.call), None),
        None => Ok(()),
    }
}

/// Checks that a number of an argument is in its range.
fn within(name: &str, value: f32, least: f32, most: f32) -> Result<(), Refusal> {
    match value >= least && value <= most {
        true => Ok(()),
        false => refuse(
            "call",
            format!("{value} is no size of `{name}`"),
            Some(format!("it is from {least} to {most}")),
        ),
    }
}

/// Checks the numbers of a picture.
fn picture(case: &Case) -> Result<(), Refusal> {
    for (name, words) in &case.arguments {
        let range = match name.as_str() {
            "size" => (1.0, MAX_PICTURE_SIDE),
            "fov" => (0.01, 179.0),
            "samples" => (1.0, MAX_SAMPLES as f32),
            "bounces" | "inter" => (0.0, MAX_BOUNCES as f32),
            "diffuse" | "background" | "mirror" => (0.0, 1.0),
            "ambient" | "glow" => (0.0, 1e6),
            "scaled" => (-60.0, 60.0),
            _ => (f32::MIN, f32::MAX),
        };
        // Those whose numbers have ranges of their own.
        let ranges = match name.as_str() {
            "shiny" => [(0.0, 1.0), (0.0, 1e6)],
            "glass" => [(0.01, 100.0), (0.0, 1.0)],
            "occlusion" => [(0.0, MAX_SAMPLES as f32), (0.0, f32::MAX)],
            _ => [range; 2],
        };
        for (number, &word) in words.iter().enumerate() {
            let (least, most) = ranges.get(number).copied().unwrap_or(range);
            within(name, f32::from_bits(word), least, most)?;
        }
    }
    let [width, height] = case.floats("size");
    let [samples] = case
        .argument("samples")
        .map_or([1.0], |_| case.floats("samples"));
    let rays = width * height * samples;
    match rays > MAX_RAYS {
        true => refuse(
            "call",
            format!("{rays} rays from the eye are more than {MAX_RAYS}"),
            None,
        ),
        false => Ok(()),
    }
}

/// Checks counts and sizes, which have limits, and numbers that have to be finite.
fn sizes(case: &Case) -> Result<(), Refusal> {
    let mut triangles = 0.0;
    for (name, words) in &case.arguments {
        let values: Vec<f32> = words.iter().map(|&w| f32::from_bits(w)).collect();
        match (name.as_str(), &values[..]) {
            ("grid", &[n]) => {
                within(name, n, 1.0, 500.0)?;
                triangles += 2.0 * n * n;
            }
            ("identical" | "nested" | "ladder", &[n]) => {
                within(name, n, 1.0, MAX_TRIANGLES)?;
                triangles += n;
            }
            ("sphere", &[columns, rows, ..]) => {
                within(name, columns, 3.0, MAX_TRIANGLES)?;
                within(name, rows, 2.0, MAX_TRIANGLES)?;
                triangles += 2.0 * columns * rows;
            }
            ("rays", &[n]) => within(name, n, 1.0, MAX_RAYS)?,
            ("size", sides) if case.call != "picture" => {
                for &side in &sides[..2] {
                    within(name, side, 0.0, MAX_SIDE)?;
                }
                within(name, sides[0] * sides[1], 0.0, MAX_TEXELS)?;
                let levels = sides.get(3).copied().unwrap_or(0.0);
                within(name, levels, 0.0, MAX_SIDE.log2())?;
            }
            _ => {}
        }
        // What is aimed at, and what rays start on, is somewhere.
        let is_placed = matches!(case.call.as_str(), "surface" | "leaks" | "acne" | "picture");
        if is_placed && name != "seed" && !values.iter().all(|v| v.is_finite()) {
            return refuse("call", format!("a number of `{name}` is not finite"), None);
        }
        if name == "view" && case.call == "surface" && values.iter().all(|&v| v == 0.0) {
            return refuse("call", "the view has no direction", None);
        }
    }
    match triangles > MAX_TRIANGLES {
        true => refuse(
            "call",
            format!("{triangles} triangles are more than {MAX_TRIANGLES}"),
            None,
        ),
        false => Ok(()),
    }
}

/// The answers of a case, each with its keyword.
fn answers(case: &Case) -> impl Iterator<Item = (&'static str, &[String])> {
    let flushed = (!case.flushed.is_empty()).then_some(("flushed", &case.flushed[..]));
    let may = case.may.iter().map(|answer| ("may", &answer[..]));
    std::iter::once(("gives", &case.gives[..]))
        .chain(may)
        .chain(flushed)
}

fn numbers(function: &Function, keyword: &'static str, answer: &[String]) -> Result<(), Refusal> {
    if let Some(word) = answer.iter().find(|word| number(word).is_none()) {
        let help = "a number is decimal, `inf`, `nan`, or `x` and its bits in hexadecimal";
        return refuse(
            keyword,
            format!("`{word}` is no number"),
            Some(help.to_owned()),
        );
    }
    match answer.len() == function.words {
        true => Ok(()),
        false => refuse(
            keyword,
            format!(
                "the answer has {}, not {}",
                counted(function.words),
                answer.len()
            ),
            None,
        ),
    }
}

/// Checks an answer that has words.
fn words(call: &str, keyword: &'static str, answer: &[String]) -> Result<(), Refusal> {
    let is = |word: &String, allowed: &[&str]| allowed.contains(&word.as_str());
    let is_number = |word: &String| number(word).is_some();
    let (good, form) = match call {
        "basis" => (answer == ["orthonormal"], "orthonormal"),
        "box" => match answer {
            [one] => (is(one, &["hit", "miss"]), "hit, miss or `miss pass`"),
            _ => (answer == ["miss", "pass"], "hit, miss or `miss pass`"),
        },
        "ray" => {
            let form = "miss, or hit with the triangles that it may be, then `t` and the distance";
            let mut parts = answer.split(|word| word == "t");
            let (first, distance) = (parts.next().unwrap_or_default(), parts.next());
            let is_hit = match first {
                [miss] if miss == "miss" => distance.is_none(),
                [hit, triangles @ ..] => hit == "hit" && triangles.iter().all(is_number),
                [] => false,
            };
            let is_far = distance.is_none_or(|t| matches!(t, [t] if is_number(t)));
            (is_hit && is_far && parts.next().is_none(), form)
        }
        "surface" => {
            let form = "`shadow lit|dark|empty`, `mirror` and `through` a triangle, miss or none";
            let pair = |pair: &[String]| match pair {
                [what, found] if what == "shadow" => is(found, &["lit", "dark", "empty"]),
                [what, found] if is(what, &["mirror", "through"]) => {
                    is(found, &["miss", "none"]) || found.parse::<u32>().is_ok()
                }
                _ => false,
            };
            (answer.chunks(2).all(pair), form)
        }
        "picture" => (
            matches!(answer, [off, n] if off == "off" && n.parse::<u32>().is_ok()),
            "`off` and how many pixels may be",
        ),
        _ => {
            let form = match call {
                "leaks" => "`lost 0`",
                _ => "`self 0`, `lost 0`, `dark 0`",
            };
            let known: &[&str] = if call == "leaks" {
                &["lost"]
            } else {
                &["self", "lost", "dark"]
            };
            let pair =
                |pair: &[String]| matches!(pair, [what, none] if is(what, known) && none == "0");
            (answer.chunks(2).all(pair), form)
        }
    };
    match good {
        true => Ok(()),
        false => refuse(
            keyword,
            format!("`{}` is no answer of `{call}`", answer.join(" ")),
            Some(format!("an answer is {form}")),
        ),
    }
}

/// Checks the names of units and of tests.
fn names(case: &Case) -> Result<(), Refusal> {
    const UNITS: [&str; 9] = [
        "rcp", "rsqrt", "sqrt", "div", "exp2", "log2", "sincos", "tni", "weight",
    ];
    if let Some((name, _)) = case
        .costs
        .iter()
        .find(|(name, _)| !UNITS.contains(&name.as_str()))
    {
        let help = format!("the units are {}", UNITS.join(", "));
        return refuse("costs", format!("no unit is called `{name}`"), Some(help));
    }
    let tests = Intersection::ALL.map(Intersection::name);
    let is_test =
        |name: &str| name == "coarse" || tests.contains(&name.trim_end_matches("-coarse"));
    match case.loses.iter().find(|(name, _)| !is_test(name)) {
        Some((name, _)) => refuse(
            "loses",
            format!("no triangle test is called `{name}`"),
            Some(format!("the tests are {}, and coarse", tests.join(", "))),
        ),
        None => Ok(()),
    }
}
