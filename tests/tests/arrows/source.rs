//! Reads Rust sources as far as arrows between modules go: the tokens of a file, the paths in them, and
//! the files that they take in.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A token, without the blanks and comments around it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Token {
    /// An identifier, a keyword or a number.
    Name(String),
    /// A literal string, without its quotes.
    Text(String),
    /// Any other character.
    Sign(char),
}

impl Token {
    fn is(&self, name: &str) -> bool {
        matches!(self, Token::Name(n) if n == name)
    }
}

/// The tokens of a source.
pub(super) fn tokens(source: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let taken = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if first == '"' {
            let end = end_of_text(&rest[1..]);
            tokens.push(Token::Text(rest[1..1 + end].to_owned()));
            end + 2
        } else if let Some(hashes) = raw_text(rest) {
            let (start, close) = (hashes + 2, format!("\"{}", "#".repeat(hashes)));
            let end = rest[start..].find(&close).expect("a raw string ends");
            tokens.push(Token::Text(rest[start..start + end].to_owned()));
            start + end + close.len()
        } else if first == '\'' {
            character(rest)
        } else if first.is_alphanumeric() || first == '_' {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
            let name = &rest[..end.unwrap_or(rest.len())];
            tokens.push(Token::Name(name.to_owned()));
            name.len()
        } else {
            if !first.is_whitespace() {
                tokens.push(Token::Sign(first));
            }
            first.len_utf8()
        };
        rest = &rest[taken.min(rest.len())..];
    }
    tokens
}

/// Bytes before the quote that ends a string.
fn end_of_text(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at,
            _ => {}
        }
    }
    text.len()
}

/// The number of `#` of a raw string that begins here.
fn raw_text(text: &str) -> Option<usize> {
    let after = text.strip_prefix('r')?;
    let hashes = after.len() - after.trim_start_matches('#').len();
    after[hashes..].starts_with('"').then_some(hashes)
}

/// Bytes of a character, or of the quote of a lifetime.
fn character(text: &str) -> usize {
    let mut inside = text[1..].chars();
    match (inside.next(), inside.next()) {
        (Some('\\'), Some(escaped)) => {
            let from = 2 + escaped.len_utf8();
            text[from..].find('\'').map_or(1, |end| from + end + 1)
        }
        (Some(c), Some('\'')) => 2 + c.len_utf8(),
        _ => 1,
    }
}

/// The tokens without items under `#[cfg(test)]`; the modules among these that are files of their own go
/// to `test_files`.
fn without_tests(tokens: &[Token], test_files: &mut BTreeSet<String>) -> Vec<Token> {
    let marker = self::tokens("#[cfg(test)]");
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if !tokens[at..].starts_with(&marker) {
            kept.push(tokens[at].clone());
            at += 1;
            continue;
        }
        let start = at + marker.len();
        at = end_of_item(tokens, start);
        if tokens[at - 1] == Token::Sign(';')
            && let [.., Token::Name(keyword), Token::Name(name), _] = &tokens[start..at]
            && keyword == "mod"
        {
            test_files.insert(name.clone());
        }
    }
    kept
}

/// Where the item that begins at a token ends: behind its `;`, or behind the brace that closes it.
fn end_of_item(tokens: &[Token], start: usize) -> usize {
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate().skip(start) {
        match token {
            Token::Sign('{' | '(' | '[') => depth += 1,
            Token::Sign('}') if depth == 1 => return at + 1,
            Token::Sign('}' | ')' | ']') => depth -= 1,
            Token::Sign(';') if depth == 0 => return at + 1,
            _ => {}
        }
    }
    tokens.len()
}

/// Where the group ends that a bracket begins.
fn end_of_group(tokens: &[Token], start: usize) -> usize {
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate().skip(start) {
        match token {
            Token::Sign('{' | '(' | '[') => depth += 1,
            Token::Sign('}' | ')' | ']') => depth -= 1,
            _ => {}
        }
        if depth <= 0 {
            return at + 1;
        }
    }
    tokens.len()
}

/// A name that `use` brings into a module: a path, and the name that it has there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Import {
    /// The path as it is written, without a `*` at its end.
    pub(super) path: Vec<String>,
    /// The name; none for all that the path has, or for nothing.
    pub(super) name: Option<String>,
}

/// A file of a crate.
#[derive(Clone, Debug)]
pub(super) struct File {
    /// Where it is.
    pub(super) path: PathBuf,
    /// Its module, from the crate's root.
    pub(super) module: Vec<String>,
    /// Its tokens, without those of its tests.
    pub(super) tokens: Vec<Token>,
    /// Its imports.
    pub(super) imports: Vec<Import>,
    /// All paths in it of more than one part, imports among them.
    pub(super) paths: Vec<Vec<String>>,
}

impl File {
    pub(super) fn of(path: PathBuf, module: Vec<String>, tokens: Vec<Token>) -> File {
        let (mut imports, mut paths) = (Vec::new(), Vec::new());
        let mut at = 0;
        while at < tokens.len() {
            if tokens[at].is("use") {
                at = tree(&tokens, at + 1, &[], &mut imports);
                continue;
            }
            let (path, end) = path_at(&tokens, at);
            if path.len() > 1 {
                paths.push(path);
            }
            at = end.max(at + 1);
        }
        paths.extend(imports.iter().map(|i| i.path.clone()));
        File {
            path,
            module,
            tokens,
            imports,
            paths,
        }
    }

    /// The files that it takes in by a macro or an attribute, as they are written.
    pub(super) fn taken_in(&self) -> Vec<&str> {
        let macros = ["include", "include_str", "include_bytes"];
        let text = |at: usize| match self.tokens.get(at) {
            Some(Token::Text(text)) => Some(text.as_str()),
            _ => None,
        };
        let by_macro = |at: usize| match &self.tokens[at..] {
            [Token::Name(name), Token::Sign('!'), ..] if macros.contains(&name.as_str()) => {
                // The path may stand in `concat!(env!(…), "…")`: the last string counts.
                let end = end_of_group(&self.tokens, at + 2);
                (at..end).rev().find_map(text)
            }
            [Token::Sign('#'), Token::Sign('['), Token::Name(name), ..] if name == "path" => {
                text(at + 4)
            }
            _ => None,
        };
        (0..self.tokens.len()).filter_map(by_macro).collect()
    }

    /// True if it calls one of these macros.
    pub(super) fn calls(&self, macros: &[&str]) -> bool {
        self.tokens.windows(2).any(|pair| match pair {
            [Token::Name(name), Token::Sign('!')] => macros.contains(&name.as_str()),
            _ => false,
        })
    }
}

/// The path that begins at a token, and where it ends.
fn path_at(tokens: &[Token], start: usize) -> (Vec<String>, usize) {
    let mut path = Vec::new();
    let mut at = start;
    while let Some(Token::Name(name)) = tokens.get(at) {
        path.push(name.clone());
        at += 1;
        match tokens.get(at..at + 2) {
            Some([Token::Sign(':'), Token::Sign(':')]) => at += 2,
            _ => break,
        }
    }
    (path, at)
}

/// Reads the tree of a `use` behind a prefix; where it ends.
fn tree(tokens: &[Token], start: usize, prefix: &[String], imports: &mut Vec<Import>) -> usize {
    let (path, mut at) = path_at(tokens, start);
    let mut whole: Vec<String> = prefix.to_vec();
    whole.extend(path);
    match tokens.get(at) {
        Some(Token::Sign('{')) => {
            at += 1;
            while at < tokens.len() && tokens[at] != Token::Sign('}') {
                at = match tokens[at] {
                    Token::Sign(',') => at + 1,
                    _ => tree(tokens, at, &whole, imports),
                };
            }
            at + 1
        }
        Some(Token::Sign('*')) => {
            imports.push(Import {
                path: whole,
                name: None,
            });
            at + 1
        }
        _ => {
            if whole.last().is_some_and(|last| last == "self") {
                whole.pop();
            }
            let mut name = whole.last().cloned();
            if let Some([Token::Name(keyword), Token::Name(other)]) = tokens.get(at..at + 2)
                && keyword == "as"
            {
                name = Some(other.clone());
                at += 2;
            }
            imports.push(Import { path: whole, name });
            at.max(start + 1)
        }
    }
}

/// The files of a crate's `src`, without those that only tests use.
pub(super) fn files(src: &Path) -> Vec<File> {
    let mut files = Vec::new();
    for root in ["lib.rs", "main.rs"] {
        let path = src.join(root);
        if path.exists() {
            collect(&path, src, Vec::new(), &mut files);
        }
    }
    assert!(!files.is_empty(), "{} has a root", src.display());
    files
}

/// Reads a file and those of its modules, which are in `folder`.
fn collect(path: &Path, folder: &Path, module: Vec<String>, files: &mut Vec<File>) {
    let text = std::fs::read_to_string(path).expect("sources can be read");
    let mut test_files = BTreeSet::new();
    let tokens = without_tests(&tokens(&text), &mut test_files);
    for part in tokens.windows(3) {
        if let [keyword, Token::Name(name), Token::Sign(';')] = part
            && keyword.is("mod")
            && !test_files.contains(name)
        {
            let own = folder.join(name);
            let candidates = [folder.join(format!("{name}.rs")), own.join("mod.rs")];
            // A generated module, or one with a path of its own, is no file here.
            if let Some(file) = candidates.iter().find(|file| file.exists()) {
                let module = [&module[..], std::slice::from_ref(name)].concat();
                collect(file, &own, module, files);
            }
        }
    }
    files.push(File::of(path.to_owned(), module, tokens));
}

/// Which modules of a crate use which: for each module, the modules that its paths lead into.
pub(super) fn uses(files: &[File]) -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
    let modules: BTreeMap<&[String], &File> = files.iter().map(|f| (&f.module[..], f)).collect();
    let mut uses: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = BTreeMap::new();
    for file in files {
        let of = uses.entry(file.module.clone()).or_default();
        for path in &file.paths {
            if let Some(found) = resolved(&file.module, path, &modules, 8) {
                of.insert(found);
            }
        }
    }
    uses
}

/// The module in which the item of a path is defined, seen from a module; none outside of the crate.
fn resolved(
    from: &[String],
    path: &[String],
    modules: &BTreeMap<&[String], &File>,
    depth: u32,
) -> Option<Vec<String>> {
    let mut at = from.to_vec();
    let mut parts = path.iter();
    let mut first = parts.next()?;
    let mut is_relative = true;
    if first == "crate" {
        at.clear();
    } else if first == "super" {
        at.pop();
    } else if first != "self" {
        is_relative = false;
    }
    if is_relative {
        loop {
            match parts.next() {
                None => return Some(at),
                Some(next) if next == "super" => {
                    at.pop();
                }
                Some(next) => {
                    first = next;
                    break;
                }
            }
        }
    }
    loop {
        let child = [&at[..], std::slice::from_ref(first)].concat();
        if modules.contains_key(&child[..]) {
            at = child;
        } else if let Some(import) = (modules.get(&at[..]))
            .and_then(|file| file.imports.iter().find(|i| i.name.as_ref() == Some(first)))
            && depth > 0
            && import.path != path
        {
            let rest = parts.cloned().collect::<Vec<_>>();
            let whole = [&import.path[..], &rest].concat();
            return resolved(&at, &whole, modules, depth - 1);
        } else {
            return (is_relative || at != from).then_some(at);
        }
        match parts.next() {
            Some(next) => first = next,
            None => return Some(at),
        }
        is_relative = true;
    }
}

/// Circles among modules with the same parent: groups in which each module uses all others of its group,
/// directly or not. The imports of a module count for all modules above it.
pub(super) fn circles(uses: &BTreeMap<Vec<String>, BTreeSet<Vec<String>>>) -> Vec<Vec<String>> {
    let mut between: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = BTreeMap::new();
    for (from, to) in uses
        .iter()
        .flat_map(|(f, all)| all.iter().map(move |t| (f, t)))
    {
        let shared = from.iter().zip(to).take_while(|(a, b)| a == b).count();
        if from.len() > shared && to.len() > shared {
            let (a, b) = (&from[..=shared], &to[..=shared]);
            between.entry(a.to_vec()).or_default().insert(b.to_vec());
        }
    }
    let mut circles = BTreeSet::new();
    for start in between.keys() {
        let forth = reached(start, &between);
        let group: BTreeSet<_> = (forth.iter())
            .filter(|other| reached(other, &between).contains(start))
            .map(|module| module.join("::"))
            .collect();
        if group.len() > 1 {
            circles.insert(group.into_iter().collect());
        }
    }
    circles.into_iter().collect()
}

/// All modules that are used by a module, by some way.
fn reached(
    start: &[String],
    between: &BTreeMap<Vec<String>, BTreeSet<Vec<String>>>,
) -> BTreeSet<Vec<String>> {
    let mut reached = BTreeSet::new();
    let mut open = vec![start.to_vec()];
    while let Some(module) = open.pop() {
        for next in between.get(&module).into_iter().flatten() {
            if reached.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    reached
}
