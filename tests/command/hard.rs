//! `srp hard-cases`: the whole matrix.

use super::{folder, srp};

#[test]
fn hard_cases_are_right_or_within_the_bounds_stated() {
    let folder = folder("hard");
    let output = srp(&folder, &["hard-cases", "--html", "cases.html"]);
    let text = String::from_utf8_lossy(&output.stdout);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{text}{message}");
    assert!(text.contains(", 0 wrong"), "{text}");
    let page = std::fs::read_to_string(folder.join("cases.html")).expect("it was written");
    assert!(page.contains("Hard cases on sgrt") && !page.contains("http://"));

    // A test that loses rays is no excuse for one that must not.
    let json = srp(&folder, &["hard-cases", "--filter", "L1", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).expect("it is JSON");
    let results = json["cases"].as_array().into_iter().flatten();
    let results = results.flat_map(|case| case["results"].as_array().into_iter().flatten());
    let (mut lost, mut all) = (0, 0);
    for result in results {
        let setting = result["setting"].as_str().unwrap_or_default();
        let right = result["verdict"] == "right";
        let leaky = setting.starts_with("wald") || setting.starts_with("anchor-wald");
        let leaky = leaky && !setting.contains("scaled");
        assert!(right || leaky, "{result}");
        (lost, all) = (lost + u32::from(!right), all + 1);
    }
    assert!(lost > 10 && all > 100, "{lost} of {all}");
    let unknown = srp(&folder, &["hard-cases", "--filter", "nonsense"]);
    assert_eq!(unknown.status.code(), Some(2));
}
