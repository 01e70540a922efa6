//! The functions of the driver in `driver.c`: their names in the catalogue, their arguments and results.

/// A function that the driver runs, under one of the names that the catalogue calls it by.
pub(super) struct Function {
    pub(super) name: &'static str,
    /// Its number in the driver.
    pub(super) number: usize,
    /// Its arguments, each a `float4`.
    pub(super) arguments: &'static [&'static str],
    /// `float4`s that it gives.
    pub(super) results: usize,
    /// The words of these that are looked at.
    pub(super) first: usize,
    pub(super) words: usize,
}

const fn function(
    name: &'static str,
    number: usize,
    arguments: &'static [&'static str],
    results: usize,
    first: usize,
    words: usize,
) -> Function {
    Function {
        name,
        number,
        arguments,
        results,
        first,
        words,
    }
}

/// A function of `math.h`, chosen by its number in the driver.
pub(super) const MATH: usize = 15;

/// The functions of `math.h` in the driver's order.
pub(super) const MATH_FUNCTIONS: [&str; 24] = [
    "powf", "expf", "exp2f", "logf", "log2f", "log10f", "sinf", "cosf", "tanf", "asinf", "acosf",
    "atanf", "atan2f", "sinhf", "coshf", "tanhf", "sqrtf", "cbrtf", "hypotf", "fmodf", "rintf",
    "roundf", "fminf", "fmaxf",
];

/// The number of the function that samples textures.
pub(super) const TEXTURE: usize = 11;
/// The number of the function that makes rays.
const RAY: usize = 12;
/// The number of the one that shades a hit.
const SURFACE: usize = 14;
/// How many the driver has.
pub(super) const COUNT: usize = 19;

const OF: &[&str] = &["of"];

pub(super) const FUNCTIONS: &[Function] = &[
    function("unit", 0, &["of", "else"], 1, 0, 3),
    function("plain-unit", 1, OF, 1, 0, 3),
    function("difference", 2, OF, 1, 0, 1),
    function("mirror", 3, &["of", "at"], 1, 0, 3),
    function("basis", 4, OF, 2, 0, 8),
    function("power", 5, OF, 1, 0, 1),
    function("rcp", 6, OF, 2, 0, 1),
    function("rsqrt", 6, OF, 2, 1, 1),
    function("sqrt", 6, OF, 2, 2, 1),
    function("exp2", 6, OF, 2, 3, 1),
    function("log2", 6, OF, 2, 4, 1),
    function("sin", 6, OF, 2, 5, 1),
    function("cos", 6, OF, 2, 6, 1),
    function("floor", 6, OF, 2, 7, 1),
    function("min", 7, OF, 4, 0, 1),
    function("max", 7, OF, 4, 1, 1),
    function("fma", 7, OF, 4, 2, 1),
    function("add", 7, OF, 4, 3, 1),
    function("sub", 7, OF, 4, 4, 1),
    function("mul", 7, OF, 4, 5, 1),
    function("div", 7, OF, 4, 6, 1),
    function("abs", 7, OF, 4, 7, 1),
    function("ftoi", 7, OF, 4, 8, 1),
    function("ftou", 7, OF, 4, 9, 1),
    function("itof", 7, OF, 4, 10, 1),
    function("utof", 7, OF, 4, 11, 1),
    function("less", 7, OF, 4, 12, 1),
    function("less-equal", 7, OF, 4, 13, 1),
    function("equal", 7, OF, 4, 14, 1),
    function("not-greater", 7, OF, 4, 15, 1),
    function("cross-self", 8, OF, 3, 0, 3),
    function("square-less-square", 8, OF, 3, 3, 1),
    function("add-subtract", 8, OF, 3, 4, 1),
    function("add-right", 8, OF, 3, 5, 1),
    function("third", 8, OF, 3, 6, 1),
    function("half-twice", 8, OF, 3, 7, 1),
    function("guarded-quotient", 8, OF, 3, 8, 1),
    function("folded-reciprocal", 8, OF, 3, 9, 1),
    function("chain", 8, OF, 3, 10, 1),
    function("folded-sum", 8, OF, 3, 11, 1),
    function("fraction", 9, OF, 1, 0, 1),
    function("scrambled-fraction", 9, OF, 1, 2, 1),
    function(
        "phong",
        10,
        &[
            "light",
            "normal",
            "geometric",
            "back",
            "diffuse",
            "specular",
            "colour",
        ],
        1,
        0,
        4,
    ),
    function("texture", TEXTURE, &["at"], 1, 0, 4),
    function("ray", RAY, &["from", "along"], 4, 0, 16),
    function("bytes", 13, OF, 1, 0, 1),
    function(
        "surface",
        SURFACE,
        &["of", "view", "light", "scene", "places"],
        12,
        0,
        48,
    ),
    function("math", MATH, OF, 1, 0, 1),
    function("sequence-x", 16, OF, 1, 0, 1),
    function("sequence-y", 16, OF, 1, 1, 1),
    function("radical-inverse", 16, OF, 1, 2, 1),
    function("bounce", 17, &["seed", "normal", "diffuse"], 2, 0, 4),
    function("bounce-weight", 17, &["seed", "normal", "diffuse"], 2, 4, 3),
    function("sum", 18, &["from", "of"], 1, 0, 3),
];

/// The function with this name in the catalogue.
pub(super) fn find(name: &str) -> Option<&'static Function> {
    let name = match MATH_FUNCTIONS.contains(&name) {
        true => "math",
        false => name,
    };
    FUNCTIONS.iter().find(|f| f.name == name)
}
