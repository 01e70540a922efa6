//! Which graphs a command line names, and how each is read.

use crate::failure::Failure;
use crate::files::Kind;
use crate::{files, talk};
use srp_archdesc::diagnostic::{Diagnostic, Source, render};
use srp_ir::graph::{self, Graph, Options};
use std::path::{Path, PathBuf};

/// How deep folders are searched.
const MAX_DEPTH: u32 = 16;
/// Most graphs of one command.
const MAX_GRAPHS: usize = 10_000;

/// A graph's file.
pub(super) struct Found {
    pub(super) path: PathBuf,
    form: Form,
}

/// The forms of graphs.
enum Form {
    Dot,
    Json,
    /// JSON if it begins with a brace, else DOT: what comes in has no name that tells.
    Stream,
    /// Edges, with the file of the operations.
    Edges(PathBuf),
}

impl Found {
    /// The name of the file, until the graph says its own.
    pub(super) fn name(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// Reads the graph; what is wrong with it, rendered.
    pub(super) fn read(&self, options: &Options) -> Result<Graph, String> {
        let source = |path: &Path| files::read_source(path, Kind::Graph).map_err(|e| e.to_string());
        let main = source(&self.path)?;
        let is_json = main.text.trim_start().starts_with('{');
        match &self.form {
            Form::Stream if is_json => {
                graph::read_json(&main, options).map_err(|e| rendered(&e, &[&main]))
            }
            Form::Dot | Form::Stream => {
                graph::read_dot(&main, options).map_err(|e| rendered(&e, &[&main]))
            }
            Form::Json => graph::read_json(&main, options).map_err(|e| rendered(&e, &[&main])),
            Form::Edges(ops) => {
                let ops = source(ops)?;
                graph::read_edges(&main, &ops, options).map_err(|e| rendered(&e, &[&main, &ops]))
            }
        }
    }
}

/// Messages with the lines that they are about.
fn rendered(mistakes: &[Diagnostic], sources: &[&Source]) -> String {
    let text = |file: &str| {
        let source = sources.iter().find(|s| s.name == file);
        source.map_or("", |s| s.text.as_str())
    };
    let each = mistakes
        .iter()
        .map(|d| render(d, text(&d.file), talk::colour()));
    each.collect::<Vec<_>>().join("\n\n")
}

/// The graphs that these paths name: files, and folders to search.
pub(super) fn find(paths: &[PathBuf], ops: Option<&Path>) -> Result<Vec<Found>, Failure> {
    let mut found = Vec::new();
    for path in paths {
        if path.is_dir() {
            let before = found.len();
            walk(path, 0, &mut found)?;
            if found.len() == before {
                let message = format!(
                    "{} has no graphs: files .dot, .gv, .json or .edges",
                    path.display()
                );
                return Err(Failure::Message(message));
            }
        } else {
            found.push(of_file(path).ok_or_else(|| unknown(path))?);
        }
    }
    if let Some(ops) = ops {
        let edges = |f: &&mut Found| matches!(f.form, Form::Edges(_));
        let mut lists: Vec<&mut Found> = found.iter_mut().filter(edges).collect();
        let [only] = &mut lists[..] else {
            let message =
                "--ops goes with one list of edges; others have their NAME.ops beside them";
            return Err(Failure::usage(message));
        };
        only.form = Form::Edges(ops.to_owned());
    }
    for graph in &found {
        files::check_input(&graph.path)?;
        if let Form::Edges(ops) = &graph.form {
            files::check_input(ops)?;
        }
    }
    Ok(found)
}

fn unknown(path: &Path) -> Failure {
    if !path.exists() {
        return Failure::Message(format!(
            "{}: there is no such file or folder",
            path.display()
        ));
    }
    Failure::Message(format!(
        "{} is no graph by its name, which ends in .dot, .gv, .json or .edges",
        path.display()
    ))
}

/// A file as a graph, if its name is that of one; `-` is standard input.
fn of_file(path: &Path) -> Option<Found> {
    let extension = path.extension().and_then(|extension| extension.to_str());
    let form = match extension.unwrap_or_default() {
        "" if path == Path::new("-") => Form::Stream,
        "dot" | "gv" => Form::Dot,
        "json" => Form::Json,
        "edges" => Form::Edges(path.with_extension("ops")),
        _ => return None,
    };
    let path = path.to_owned();
    Some(Found { path, form })
}

/// Adds the graphs of a folder and those below it, by name.
fn walk(folder: &Path, depth: u32, found: &mut Vec<Found>) -> Result<(), Failure> {
    let refused =
        |e: std::io::Error| Failure::Message(format!("cannot search {}: {e}", folder.display()));
    if depth > MAX_DEPTH {
        let message = format!("{}: more than {MAX_DEPTH} folders deep", folder.display());
        return Err(Failure::Message(message));
    }
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(refused)? {
        let entry = entry.map_err(refused)?;
        entries.push((entry.path(), entry.file_type().map_err(refused)?));
    }
    entries.sort_by(|a, b| a.0.cmp(&b.0));
    for (path, kind) in entries {
        if kind.is_dir() {
            walk(&path, depth + 1, found)?;
        } else if let Some(graph) = of_file(&path) {
            if found.len() == MAX_GRAPHS {
                return Err(Failure::Message(format!("more than {MAX_GRAPHS} graphs")));
            }
            found.push(graph);
        }
    }
    Ok(())
}
