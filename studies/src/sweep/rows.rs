//! The folder of a sweep: its plan, its rows as they are done, and the table of them.
//!
//! Every process appends to a file of its own under `rows/`, a line of JSON for each row. A line that was cut off
//! by a kill is left out by the next reader.

use super::Shard;
use super::plan::Plan;
use crate::Error;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_toolchain::files;
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// A row: a point of the plan, measured on a subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Names everything that the row depends on.
    pub key: String,
    /// The number of the point in the plan, from 0.
    pub point: usize,
    /// The scene or program.
    pub subject: String,
    /// The settings of the point.
    pub settings: BTreeMap<String, String>,
    /// The outcome.
    pub outcome: Outcome,
    /// Names the machine by all that it is; empty where it is none.
    #[serde(rename = "machine_hash")]
    pub machine: String,
    /// Names the scene or program by all of its contents.
    #[serde(default)]
    pub subject_hash: String,
    /// Names the kernels by all of their contents; empty where they come along with the tools.
    #[serde(default)]
    pub kernels_hash: String,
    /// The build of the tools.
    pub build: String,
    /// The host that measured it.
    pub host: String,
    /// Seconds that it took.
    pub seconds: f64,
}

/// The outcome of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// Figures by their columns.
    Figures(BTreeMap<String, f64>),
    /// The point is no machine.
    Invalid(String),
    /// Compiling or simulating failed.
    Failed(String),
}

impl Row {
    /// True if it was measured.
    pub fn has_figures(&self) -> bool {
        matches!(self.outcome, Outcome::Figures(_))
    }

    /// The figure of a column.
    pub fn figure(&self, column: &str) -> Option<f64> {
        match &self.outcome {
            Outcome::Figures(figures) => figures.get(column).copied(),
            _ => None,
        }
    }
}

/// A row that is to be measured.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    /// The number of the point.
    pub point: usize,
    /// The name of the subject.
    pub subject: String,
    /// The settings of the point.
    pub settings: BTreeMap<String, String>,
    /// Names the row.
    pub key: String,
    /// Names the subject by its contents.
    #[serde(default)]
    pub subject_hash: String,
    /// Names the kernels by their contents.
    #[serde(default)]
    pub kernels_hash: String,
    /// The number of the subject.
    #[serde(skip)]
    pub(super) of: usize,
}

impl Job {
    /// The row without its outcome.
    pub(super) fn row(&self) -> Row {
        Row {
            key: self.key.clone(),
            point: self.point,
            subject: self.subject.clone(),
            settings: self.settings.clone(),
            outcome: Outcome::Failed(String::new()),
            machine: String::new(),
            subject_hash: self.subject_hash.clone(),
            kernels_hash: self.kernels_hash.clone(),
            build: srp_toolchain::BUILD_ID.to_owned(),
            host: host(),
            seconds: 0.0,
        }
    }

    /// A row as it stands in this plan: another plan may have measured it.
    pub(super) fn place(&self, row: &Row) -> Row {
        Row {
            point: self.point,
            subject: self.subject.clone(),
            subject_hash: self.subject_hash.clone(),
            kernels_hash: self.kernels_hash.clone(),
            ..row.clone()
        }
    }
}

/// The name of this host.
fn host() -> String {
    let named = std::fs::read_to_string("/proc/sys/kernel/hostname");
    named.map_or_else(|_| "unknown".to_owned(), |name| name.trim().to_owned())
}

/// The folder of a sweep.
#[derive(Clone, Debug)]
pub struct Folder(pub(super) PathBuf);

impl Folder {
    /// The folder, which is made where there is none.
    ///
    /// # Errors
    ///
    /// It cannot be made.
    pub fn make(path: &Path) -> Result<Folder, Error> {
        files::make_folder(&path.join("rows"))?;
        Ok(Folder(path.to_owned()))
    }

    /// A folder that is there.
    pub fn at(path: &Path) -> Folder {
        Folder(path.to_owned())
    }

    /// A file of the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes the plan and the keys of its rows as far as they are known, unless they are there: shards read the plan from
    /// here.
    pub(super) fn write_plan(&self, plan: &Plan, jobs: &[Job]) -> Result<(), Error> {
        let json = serde_json::to_string(jobs).map_err(Error::invalid)?;
        for (name, text) in [("plan.toml", plan.file.to_toml()), ("points.json", json)] {
            let path = self.path(name);
            if std::fs::read(&path).ok().as_deref() != Some(text.as_bytes()) {
                files::write(&path, text.as_bytes())?;
            }
        }
        Ok(())
    }

    /// All rows that any process has finished, by their keys.
    ///
    /// # Errors
    ///
    /// A file of rows cannot be read.
    pub fn rows(&self) -> Result<BTreeMap<String, Row>, Error> {
        let wrong = |path: &Path, e: std::io::Error| {
            Error::Invalid(format!("cannot read {}: {e}", path.display()))
        };
        let folder = self.path("rows");
        let entries = std::fs::read_dir(&folder).map_err(|e| wrong(&folder, e))?;
        let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        paths.retain(|p| p.extension().is_some_and(|e| e == "jsonl"));
        paths.sort();
        let mut rows = BTreeMap::new();
        for path in paths {
            let bytes = files::read_bytes(&path, files::Kind::Rows)?;
            for line in bytes.split(|&b| b == b'\n') {
                if let Ok(row) = serde_json::from_slice::<Row>(line) {
                    rows.insert(row.key.clone(), row);
                }
            }
        }
        Ok(rows)
    }

    /// The writer of a shard's rows.
    pub(super) fn writer(&self, shard: Shard) -> Result<Writer, Error> {
        let name = match shard {
            Shard::WHOLE => format!("rows/{}-{}.jsonl", host(), std::process::id()),
            Shard { number, of } => {
                format!(
                    "rows/shard-{number}-of-{of}-{}-{}.jsonl",
                    host(),
                    std::process::id()
                )
            }
        };
        Ok(Writer {
            path: self.path(&name),
            file: Mutex::new(None),
        })
    }
}

/// The file that a process appends its rows to. It is made with the first of them.
pub(super) struct Writer {
    path: PathBuf,
    file: Mutex<Option<File>>,
}

impl Writer {
    /// Appends a row; it is there for others when this returns.
    pub(super) fn write(&self, row: &Row) -> Result<(), Error> {
        let mut line = serde_json::to_vec(row).map_err(Error::invalid)?;
        line.push(b'\n');
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let wrong = |e| Error::from(files::FileError::writing(&self.path, e));
        if file.is_none() {
            let opened = OpenOptions::new()
                .create(true)
                .append(true)
                .open(&self.path);
            *file = Some(opened.map_err(wrong)?);
        }
        let file = file.as_mut().expect("it was opened");
        let end = file.seek(SeekFrom::End(0)).map_err(wrong)?;
        let written = file.write_all(&line).and_then(|()| file.sync_data());
        written.map_err(|e| {
            // Half a line is left out by readers; without it the next row stands alone, too.
            let _ = file.set_len(end);
            wrong(e)
        })
    }
}

/// The columns of settings of some rows, in order.
pub fn settings(rows: &[Row]) -> Vec<String> {
    let mut names: Vec<String> = rows
        .iter()
        .flat_map(|r| r.settings.keys().cloned())
        .collect();
    names.sort();
    names.dedup();
    names
}

/// The columns of figures of some rows: those of every row first, details such as `ii.NAME` after them.
pub fn figures(rows: &[Row]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for row in rows {
        if let Outcome::Figures(figures) = &row.outcome {
            names.extend(figures.keys().cloned());
        }
    }
    names.sort_by_key(|name| (name.contains('.'), rank(name), name.clone()));
    names.dedup();
    names
}

/// Where a column stands.
fn rank(name: &str) -> usize {
    const ORDER: [&str; 7] = ["ii", "cycles", "ms", "fps", "energy", "area", "psnr"];
    let first = name.split('.').next().unwrap_or(name);
    ORDER
        .iter()
        .position(|n| *n == first)
        .unwrap_or(ORDER.len())
}

/// The table as comma-separated values (RFC 4180), without what differs from run to run.
pub fn csv(rows: &[Row]) -> String {
    let (settings, figures) = (settings(rows), figures(rows));
    let mut out = String::from("point,subject");
    for name in &settings {
        out += &format!(",{}", quoted(name));
    }
    for name in &figures {
        out += &format!(",{name}");
    }
    out += ",machine,build,error\n";
    for row in rows {
        out += &format!("{},{}", row.point, quoted(&row.subject));
        for name in &settings {
            out += &format!(
                ",{}",
                quoted(row.settings.get(name).map_or("", String::as_str))
            );
        }
        for name in &figures {
            let figure = row.figure(name).map(|f| f.to_string());
            out += &format!(",{}", figure.unwrap_or_default());
        }
        let error = match &row.outcome {
            Outcome::Figures(_) => "",
            Outcome::Invalid(why) | Outcome::Failed(why) => why,
        };
        out += &format!(",{},{},{}\n", row.machine, row.build, quoted(error));
    }
    out
}

/// A field, in quotes where it needs them.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}
