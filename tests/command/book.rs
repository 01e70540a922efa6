//! The book, `docs/`: what its walks show is what happens, its contents are complete, and its links lead somewhere.

use super::{cache, folder};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A fenced block of a page.
struct Block {
    /// What stands behind the fence: the language.
    kind: String,
    text: String,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The fenced blocks of a page, and the rest of it.
fn blocks(page: &str) -> (Vec<Block>, String) {
    let (mut blocks, mut prose) = (Vec::<Block>::new(), String::new());
    let mut inside = false;
    for line in page.lines() {
        match (line.strip_prefix("```"), inside) {
            (Some(kind), false) => {
                let (kind, text) = (kind.to_owned(), String::new());
                blocks.push(Block { kind, text });
            }
            (Some(_), true) => {}
            (None, true) => {
                let block = blocks.last_mut().expect("a fence was opened");
                block.text += line;
                block.text.push('\n');
            }
            (None, false) => {
                prose += line;
                prose.push('\n');
            }
        }
        inside ^= line.starts_with("```");
    }
    assert!(!inside, "a fence is open at the end");
    (blocks, prose)
}

/// Makes the change of a unified diff with one hunk.
fn patch(folder: &Path, diff: &str) {
    let name = diff
        .lines()
        .next()
        .and_then(|line| line.strip_prefix("--- "));
    let path = folder.join(name.expect("the file's name comes first"));
    let hunk: Vec<&str> = diff.lines().skip(3).collect();
    let side = |other: char| {
        let lines = hunk.iter().filter(|line| !line.starts_with(other));
        lines
            .map(|line| format!("{}\n", line.get(1..).unwrap_or_default()))
            .collect::<String>()
    };
    let text = read(&path);
    let (before, after) = (side('+'), side('-'));
    assert_eq!(text.matches(&before).count(), 1, "{before}");
    std::fs::write(&path, text.replace(&before, &after)).expect("it can be written");
}

/// Runs lines of commands as a reader does, and returns what they print. `# ends with N` behind a command is its status.
fn run(folder: &Path, commands: &str) -> String {
    let own = Path::new(env!("CARGO_BIN_EXE_srp")).parent();
    let own = own.expect("the command is in a folder").to_owned();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([own].into_iter().chain(std::env::split_paths(&others)));
    let path = path.expect("no folder has a colon");
    let mut said = String::new();
    for line in commands.replace("\\\n", " ").lines() {
        let output = Command::new("sh")
            .args(["-c", line])
            .current_dir(folder)
            .env("PATH", &path)
            .env("SRP_CACHE", cache())
            .output()
            .expect("there is a shell");
        let errors = String::from_utf8_lossy(&output.stderr);
        let expected = line
            .split_once("# ends with ")
            .map_or("0", |(_, rest)| rest);
        let expected = expected.split([' ', ',']).next().unwrap_or_default();
        let status = output.status.code().map(|code| code.to_string());
        assert_eq!(status.as_deref(), Some(expected), "{line}: {errors}");
        said += &String::from_utf8_lossy(&output.stdout);
        said += &errors;
    }
    said
}

/// A page shows what is printed: its lines, in their order; `…` stands for some, or for the rest of a line.
fn shows(shown: &str, said: &str) {
    let mut rest = said.lines();
    for line in shown.lines().filter(|line| line.trim() != "…") {
        let found = match line.strip_suffix('…') {
            Some(begin) => rest.any(|own| own.starts_with(begin)),
            None => rest.any(|own| own.trim_end() == line),
        };
        assert!(found, "`{line}` is not what is printed then:\n{said}");
    }
}

/// Goes through a page from top to bottom: writes the files that it shows, changes them as it says, runs its commands, and
/// finds in what they print all that it shows.
///
/// A file is a block of any other language whose first line is a comment that begins with `NAME: `.
fn walk(name: &str) {
    let folder = folder(name);
    let page = read(&root().join(format!("docs/{name}.md")));
    let (mut said, mut shown) = (String::new(), 0);
    for Block { kind, text } in blocks(&page).0 {
        match kind.as_str() {
            "sh" => said = run(&folder, &text),
            "diff" => patch(&folder, &text),
            "text" => {
                shows(&text, &said);
                shown += 1;
            }
            "" => {}
            _ => {
                let first = text.lines().next().unwrap_or_default();
                let named = first.trim_start_matches(['/', '*', '#', ' ']);
                let (file, _) = named.split_once(": ").expect("a file says its name");
                std::fs::write(folder.join(file), &text).expect("it can be written");
            }
        }
    }
    assert!(shown > 0, "the page shows nothing");
}

/// The pages with commands to try, each a test of its own.
macro_rules! walks {
    ($($test:ident = $page:literal),+ $(,)?) => {
        const WALKS: &[&str] = &[$($page),+];
        $(#[test] fn $test() { walk($page); })+
    };
}

walks! {
    the_first_shader_is_as_the_page_says = "first-shader",
    the_first_machine_is_as_the_page_says = "first-machine",
    the_loop_gets_from_15_to_3 = "from-15-to-3",
    accuracy_costs_what_the_page_says = "what-accuracy-costs",
    the_sweep_is_the_same_everywhere = "sweep-on-a-cluster",
}

/// The pages in `docs/`.
fn pages() -> BTreeSet<PathBuf> {
    let entries = std::fs::read_dir(root().join("docs")).expect("there are pages");
    let paths = entries.map(|entry| entry.expect("it can be read").path());
    paths
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .collect()
}

/// Where the links and pictures of prose lead.
fn links(prose: &str) -> Vec<&str> {
    let parts = prose.split("](").skip(1);
    parts
        .filter_map(|part| part.split_once(')'))
        .map(|(to, _)| to)
        .collect()
}

/// The anchors of a page's headings, as mdbook and forges make them.
fn anchors(prose: &str) -> BTreeSet<String> {
    let headings = prose.lines().filter(|line| line.starts_with('#'));
    let anchor = |heading: &str| {
        let text = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = text
            .chars()
            .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

#[test]
fn the_contents_have_every_page_once() {
    let docs = root().join("docs");
    let contents = read(&docs.join("SUMMARY.md"));
    let listed: Vec<PathBuf> = links(&contents).iter().map(|to| docs.join(to)).collect();
    let set: BTreeSet<PathBuf> = listed.iter().cloned().collect();
    assert_eq!(listed.len(), set.len(), "a page is listed twice");
    let mut pages = pages();
    pages.remove(&docs.join("SUMMARY.md"));
    assert_eq!(set, pages);
}

#[test]
fn pages_with_commands_are_walked() {
    let with_commands = pages().into_iter().filter(|path| {
        let (blocks, _) = blocks(&read(path));
        blocks.iter().any(|block| block.kind == "sh")
    });
    let names: BTreeSet<String> = with_commands
        .map(|path| {
            path.file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    assert_eq!(names, WALKS.iter().map(|name| (*name).to_owned()).collect());
}

#[test]
fn links_lead_somewhere() {
    let others = [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "CHANGELOG.md",
        "archdesc/FORMAT.md",
    ];
    let mut wrong = Vec::new();
    for page in pages()
        .into_iter()
        .chain(others.map(|name| root().join(name)))
    {
        let (_, prose) = blocks(&read(&page));
        for link in links(&prose)
            .into_iter()
            .filter(|link| !link.contains("://"))
        {
            let (to, anchor) = link.split_once('#').unwrap_or((link, ""));
            let path = match to {
                "" => page.clone(),
                _ => page.parent().expect("a folder").join(to),
            };
            let holds = path.exists()
                && (anchor.is_empty() || anchors(&blocks(&read(&path)).1).contains(anchor));
            if !holds {
                wrong.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
