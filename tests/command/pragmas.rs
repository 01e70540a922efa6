//! Statements of pragmas about loops: that iterations are independent, which is believed, and checked by
//! `--engine ir`; and that a loop is a kernel, which is an error where it is not.

use super::{folder, refused, srp, write};

/// A loop that adds where an index says, under a pragma.
fn scatter(pragma: &str) -> String {
    format!(
        "int a[64], index[64];
static void scatter(int *p, int n)
{{
{pragma}
    for (int i = 0; i < n; i++) {{
        int x = p[index[i]];
        p[index[i]] = x * 3 + i;
    }}
}}
int main(void)
{{
    for (int i = 0; i < 64; i++) index[i] = i ^ 3;
    scatter(a, 60);
    return a[5] - 6;
}}
"
    )
}

/// The II of the loop `scatter`.
fn ii(report: &str) -> u32 {
    let (_, rest) = report.split_once("scatter at II = ").expect("it has one");
    let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().expect("a number")
}

#[test]
fn independent_iterations_overlap() {
    let folder = folder("independent");
    let report = |pragma: &str| {
        write(&folder, "scatter.c", &scatter(pragma));
        let report = srp(&folder, &["report", "scatter.c"]);
        ii(&String::from_utf8_lossy(&report.stdout))
    };
    let ordered = report("");
    for pragma in [
        "#pragma srp independent(p)",
        "#pragma ivdep",
        "#pragma GCC ivdep",
    ] {
        let free = report(pragma);
        assert!(
            free * 2 <= ordered,
            "{pragma}: II {free}, {ordered} without"
        );
    }
    // What is said of another variable does not help.
    assert_eq!(report("#pragma srp independent(a)"), ordered);
}

#[test]
fn iterations_that_are_not_independent_are_found() {
    let folder = folder("overlap");
    for pragma in ["#pragma srp independent(p)", "#pragma ivdep"] {
        let text = scatter(pragma);
        write(&folder, "right.c", &text);
        let right = srp(&folder, &["run", "right.c", "--engine", "ir"]);
        let said = String::from_utf8_lossy(&right.stderr);
        assert_eq!(right.status.code(), Some(0), "{said}");
        write(&folder, "wrong.c", &text.replace("i ^ 3", "i / 2"));
        let says = [
            "wrong.c:6:",
            "wrong.c:7:",
            "which a pragma of the loop denies",
        ];
        refused(&folder, &["run", "wrong.c", "--engine", "ir"], &says);
    }
    let text = "int a[64];
static void copy(int *p, const int *q, int n)
{
#pragma srp independent(p, q)
    for (int i = 0; i < n; i++)
        p[i] =
            q[i] + 1;
}
int main(void) { copy(a, a, 8); return 0; }
";
    write(&folder, "same.c", text);
    let says = ["same.c:6:", "same.c:7:"];
    refused(&folder, &["run", "same.c", "--engine", "ir"], &says);
}

#[test]
fn kernels_of_a_frame_that_are_not_on_the_array_are_refused() {
    let folder = folder("kernel");
    let text = "int a[8];
static int half(int n) { return n < 2 ? n : half(n / 2) + 1; }
int main(void)
{
#pragma srp kernel
    for (int i = 0; i < 8; i++)
        a[i] = half(i);
    return 0;
}
";
    std::fs::create_dir(folder.join("own")).expect("it can be made");
    write(&folder, "own/frame.c", text);
    let render = ["render", "--kernels", "own", "--size", "8x8"];
    let says = ["error[C0604]", "own/frame.c:7:", "-Wno-error=kernel"];
    refused(&folder, &render, &says);
    let output = srp(&folder, &[&render[..], &["-W", "no-error=kernel"]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("warning[C0604]: main is not"), "{said}");
    assert!(output.status.success(), "{said}");
}
