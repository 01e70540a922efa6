//! `-ffast-math` and its parts: each changes what it names and nothing else, and tells where.

use super::{folder, srp, write};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

const PROGRAM: &str = "#include <math.h>
float a[64], b[64], c[64];
float sum(void)
{
    float s = 0;
    for (int i = 0; i < 64; i++)
        s = s + a[i] + b[i];
    return s;
}
void divide(void)
{
    for (int i = 0; i < 64; i++)
        b[i] = a[i] / 3.0f;
}
void contract(void)
{
    for (int i = 0; i < 64; i++)
        c[i] = a[i] * b[i] + 1.0f;
}
void power(void)
{
    for (int i = 0; i < 64; i++)
        a[i] = powf(b[i], 1.5f);
}
";

/// The functions of the program after the passes with these options, and what is told of them.
fn functions(folder: &Path, options: &[&str]) -> (BTreeMap<String, String>, String) {
    let compile = [
        "compile", "f.c", "--emit", "ir", "--passes", "standard", "-o", ".", "-R", "pass",
    ];
    let compiled = srp(folder, &[&compile[..], options].concat());
    let said = String::from_utf8_lossy(&compiled.stderr).into_owned();
    assert!(compiled.status.success(), "{said}");
    let text = std::fs::read_to_string(folder.join("f.ir")).expect("it was written");
    let mut functions = BTreeMap::<String, String>::new();
    let mut name = String::new();
    for line in text.lines() {
        // The functions' numbers depend on what there is of the library.
        let mut words = line.splitn(2, ' ');
        let head = words.next().is_some_and(|word| word.starts_with("fn"));
        let line = words.next().filter(|_| head).unwrap_or(line);
        if head {
            name = line.split('(').next().unwrap_or_default().to_owned();
        }
        *functions.entry(name.clone()).or_default() += line;
    }
    (functions, said)
}

#[test]
fn a_rewrite_changes_its_line() {
    let folder = folder("rewrite");
    write(&folder, "f.c", PROGRAM);
    let (exact, said) = functions(&folder, &[]);
    assert!(!said.contains("--rewrite"), "{said}");
    let (rewritten, said) = functions(&folder, &["--rewrite", "products@f.c:23"]);
    let own = ["sum", "divide", "contract", "power"];
    let changed = own.into_iter().filter(|f| rewritten[*f] != exact[*f]);
    assert_eq!(changed.collect::<Vec<_>>(), ["power"]);
    let told =
        "f.c:23:16: a power with a constant exponent as products and roots (--rewrite products)";
    assert!(said.contains(told), "{said}");
    let refused = srp(&folder, &["report", "f.c", "--rewrite", "horner@23"]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    let why = "--rewrite horner@23: line 23 has nothing that `horner` fits";
    assert!(said.contains(why), "{said}");
    let unknown = srp(&folder, &["report", "f.c", "--rewrite", "honer@23"]);
    assert_eq!(unknown.status.code(), Some(2));
}

#[test]
fn each_part_changes_what_it_names() {
    let folder = folder("fast_math");
    write(&folder, "f.c", PROGRAM);
    let (exact, said) = functions(&folder, &[]);
    assert!(exact.len() >= 5 && !said.contains("-f"), "{exact:?} {said}");
    let changed = |options: &[&str]| {
        let (functions, said) = functions(&folder, options);
        let own = ["sum", "divide", "contract", "power"];
        let changed = own.into_iter().filter(|f| functions[*f] != exact[*f]);
        (changed.collect::<Vec<_>>(), said)
    };
    for (option, function, line) in [
        ("-freciprocal-math", "divide", "f.c:13:"),
        ("-ffp-contract=fast", "contract", "f.c:18:"),
    ] {
        let (changed, said) = changed(&[option]);
        assert_eq!(changed, [function], "{option}");
        let told = said.lines().find(|l| l.contains(option));
        assert!(told.is_some_and(|l| l.contains(line)), "{option}: {said}");
    }
    let (associated, said) = changed(&["-fassociative-math"]);
    assert!(associated.contains(&"sum") && !associated.contains(&"divide"));
    assert!(said.contains("f.c:7:"), "{said}");
    let (approximated, said) = changed(&["-fapprox-func"]);
    assert_eq!(approximated, ["power"]);
    let told =
        "f.c:23:16: `powf` is the unit's 2^(y log2 x), whose exponent is rounded (-fapprox-func)";
    assert!(said.contains(told), "{said}");
    // All together say of every line what each has changed.
    let (all, said) = changed(&["-ffast-math"]);
    assert_eq!(all, ["sum", "divide", "contract", "power"]);
    for line in [
        "f.c:7: the sum",
        "f.c:13: the quotient",
        "f.c:18: the sum",
        "f.c:23: `powf`",
    ] {
        let (at, what) = line.rsplit_once(": ").unwrap_or_default();
        let told = |l: &str| l.contains(&format!("{at}:")) && l.contains(what);
        assert!(said.lines().any(told), "{line}: {said}");
    }
}

/// Only where asked are sums taken in another order: what the loop carries comes last, so that the
/// recurrence has one addition in place of four. Of these numbers no sum is rounded.
#[test]
fn sums_are_reassociated_when_asked() {
    let folder = folder("associative");
    let sum = "
static float x[64];
int main(void)
{
    for (int i = 0; i < 64; i++)
        x[i] = (float)i;
    float s = 0.0f;
#pragma srp kernel
    for (int i = 0; i < 61; i++)
        s = s + x[i] + x[i + 1] + x[i + 2] + x[i + 3];
    return (int)s == 7686 ? 7 : 1;
}
";
    write(&folder, "sum.c", sum);
    let text = |args: &[&str], status: i32| {
        let output = srp(&folder, args);
        assert_eq!(output.status.code(), Some(status), "srp {args:?}");
        String::from_utf8(output.stdout).expect("text is written")
    };
    let bound = |flags: &[&str]| {
        let args = [&["report", "sum.c", "--json"], flags].concat();
        let json: Value = serde_json::from_str(&text(&args, 0)).expect("JSON");
        let loops = json["loops"].as_array().expect("a list").iter();
        let bounds = loops.filter_map(|l| l["rec_mii"].as_u64());
        bounds.max().expect("a loop is on the array")
    };
    let (asked, not) = (bound(&["-fassociative-math"]), bound(&[]));
    assert_eq!(
        4 * asked,
        not,
        "the recurrence has a fourth of the additions"
    );
    for flags in [&[][..], &["-fassociative-math"]] {
        let args = [&["run", "sum.c", "--engine", "interp"], flags].concat();
        text(&args, 7);
    }
}
