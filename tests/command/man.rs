//! `srp man`: a page for every command, which readers of manual pages take.

use super::{folder, srp};
use std::process::{Command, Stdio};

#[test]
fn every_command_has_a_page() {
    let folder = folder("man");
    assert_eq!(srp(&folder, &["man", "pages"]).status.code(), Some(0));
    let help = srp(&folder, &["--help"]);
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = listed.map_while(|line| line.split_whitespace().next());
    let mut count = 0;
    for name in names.filter(|name| *name != "help") {
        let path = folder.join(format!("pages/srp-{name}.1"));
        let page = std::fs::read_to_string(path).unwrap_or_else(|_| panic!("srp {name}"));
        assert!(
            page.contains(".SH NAME") && page.contains(".SH SYNOPSIS"),
            "{page}"
        );
        count += 1;
    }
    assert!(count > 20, "{help}");
    let mut groff = Command::new("groff");
    groff
        .args(["-k", "-man", "-Tutf8", "-ww"])
        .current_dir(&folder);
    groff.args([
        "pages/srp.1",
        "pages/srp-render.1",
        "pages/srp-sweep-show.1",
    ]);
    match groff.stdout(Stdio::piped()).stderr(Stdio::piped()).output() {
        Err(_) => println!("skipped: there is no groff"),
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && said.is_empty(), "{said}");
            assert!(String::from_utf8_lossy(&output.stdout).contains("srp render"));
        }
    }
}
