//! The envelope of every JSON document that is written: what it is, who wrote it, and of what.
//!
//! A document is one object. The members of [`Envelope`] are in each, and the members of its [`Contents`] beside
//! them; `docs/json.md` says what may change of either, and when a version rises.

use crate::frame::{BUILD_ID, hash};
use crate::{Error, json, scene};
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Source, Span};
use srp_archdesc::xml;
use srp_runtime::scene::Scene;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// What a document says beside its envelope.
pub trait Contents: Serialize + JsonSchema {
    /// The name of the format, such as `srp-report`.
    const FORMAT: &'static str;
    /// The version of the members. It rises when one changes its meaning or goes away.
    const VERSION: u32;
    /// The commands that write it, in words.
    const WRITTEN_BY: &'static str;
}

impl<T: Contents> Contents for &T {
    const FORMAT: &'static str = T::FORMAT;
    const VERSION: u32 = T::VERSION;
    const WRITTEN_BY: &'static str = T::WRITTEN_BY;
}

/// A document: the members that all formats have, then those of this one.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Envelope<T> {
    /// The name of the format.
    pub format: &'static str,
    /// The version of the format.
    pub version: u32,
    /// The program that wrote the document.
    pub tool: Tool,
    /// The command and its settings.
    #[serde(flatten)]
    pub asked: Asked,
    /// The machine that it is about; null where it is about none or several.
    pub machine: Option<Named>,
    /// The scene that it is about; null where it is about none or several.
    pub scene: Option<Named>,
    /// What it says.
    #[serde(flatten)]
    pub contents: T,
}

/// The program that wrote a document.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Tool {
    /// Its version.
    pub version: Cow<'static, str>,
    /// Names its sources: another build has another name.
    pub build: Cow<'static, str>,
}

/// What was asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Asked {
    /// The command, such as `render` or `sweep report`.
    pub command: String,
    /// Its arguments by their names, with the defaults of those that were not given. Those that only say where
    /// the results go, how they look and how many threads compute them are not among them.
    pub options: BTreeMap<String, Setting>,
}

/// The value of an argument.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Setting {
    /// A flag: true if it was given.
    Flag(bool),
    /// A value, as it was written.
    Value(String),
    /// The values of an argument that may have several.
    Values(Vec<String>),
}

/// A machine or a scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// Names it by all that it is, whatever its file is called and however it is written.
    pub hash: String,
}

impl Named {
    /// A machine, named by its file as it is written in full.
    pub fn machine(arch: &Arch) -> Named {
        Named {
            name: arch.name.clone(),
            hash: hash(&xml::write(arch)),
        }
    }

    /// A scene, with its camera, lights and options.
    pub fn scene(of: &Scene) -> Named {
        Named {
            name: of.name.clone(),
            hash: scene::hash(of),
        }
    }
}

/// What a document is about.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct About {
    /// The machine, if it is one.
    pub machine: Option<Named>,
    /// The scene, if it is one.
    pub scene: Option<Named>,
}

impl About {
    /// A machine.
    pub fn machine(arch: &Arch) -> About {
        About {
            machine: Some(Named::machine(arch)),
            scene: None,
        }
    }

    /// A scene on a machine.
    pub fn scene(arch: &Arch, scene: &Scene) -> About {
        About {
            scene: Some(Named::scene(scene)),
            ..About::machine(arch)
        }
    }
}

impl<T: Contents> Envelope<T> {
    /// A document of this build.
    pub fn new(asked: Asked, about: About, contents: T) -> Envelope<T> {
        Envelope {
            format: T::FORMAT,
            version: T::VERSION,
            tool: Tool {
                version: env!("CARGO_PKG_VERSION").into(),
                build: BUILD_ID.into(),
            },
            asked,
            machine: about.machine,
            scene: about.scene,
            contents,
        }
    }

    /// The document's text.
    ///
    /// # Errors
    ///
    /// A key of a map is no text, or a number has no JSON.
    pub fn text(&self) -> Result<String, Error> {
        let text = serde_json::to_string_pretty(self);
        Ok(text.map_err(|e| Error::Invalid(e.to_string()))? + "\n")
    }
}

/// The JSON Schema (2020-12) of a format: of its documents as they are written.
pub fn schema<T: Contents>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let settings = settings.with_transform(RecursiveTransform(allow_null_for_numbers));
    let mut schema = settings
        .into_generator()
        .into_root_schema_for::<Envelope<T>>();
    let constant =
        |of: serde_json::Value, what: &str| serde_json::json!({ "description": what, "const": of });
    schema.insert("title".to_owned(), T::FORMAT.into());
    let description = format!("Written by {}.", T::WRITTEN_BY);
    schema.insert("description".to_owned(), description.into());
    let members = schema.get_mut("properties").and_then(|p| p.as_object_mut());
    if let Some(members) = members {
        let format = constant(T::FORMAT.into(), "The name of the format.");
        let version = constant(T::VERSION.into(), "The version of the format.");
        members.insert("format".to_owned(), format);
        members.insert("version".to_owned(), version);
    }
    schema
}

/// A number that is infinite, or none, has no JSON: null is written for it.
fn allow_null_for_numbers(schema: &mut Schema) {
    if schema.get("type").is_some_and(|kind| kind == "number") {
        let kinds = serde_json::json!(["number", "null"]);
        schema.insert("type".to_owned(), kinds);
    }
}

/// The envelope of a document that was read; what else is in it is not looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Head {
    /// The name of its format, one of those that were expected.
    pub format: &'static str,
    /// Where that name stands.
    pub place: Span,
    /// The machine.
    pub machine: Option<Named>,
    /// The scene.
    pub scene: Option<Named>,
}

/// Refuses two documents that are not of one format.
///
/// # Errors
///
/// They are not: with the place in the second.
pub fn of_one_format(first: (&Source, &Head), second: (&Source, &Head)) -> Result<(), Error> {
    let ((old, first), (new, second)) = (first, second);
    if first.format == second.format {
        return Ok(());
    }
    let why = format!(
        "this document is a `{}`, but {} is a `{}`: give two of one format",
        second.format, old.name, first.format
    );
    Err(json::at_byte(new, second.place, &why))
}

/// A format that a reader takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Its name.
    pub format: &'static str,
    /// The version that is read.
    pub version: u32,
    /// The commands that write it, in words.
    pub written_by: &'static str,
}

impl Expected {
    /// Documents of these contents.
    pub const fn of<T: Contents>() -> Expected {
        Expected {
            format: T::FORMAT,
            version: T::VERSION,
            written_by: T::WRITTEN_BY,
        }
    }
}

/// Reads the envelope of a document, which has to be of one of the formats.
///
/// # Errors
///
/// The text is no JSON, or its envelope is missing, of another format or another version: with the place.
pub fn read(source: &Source, expected: &[Expected]) -> Result<Head, Error> {
    #[derive(Deserialize)]
    struct Raw<'t> {
        #[serde(borrow)]
        format: Option<&'t RawValue>,
        #[serde(borrow)]
        version: Option<&'t RawValue>,
        #[serde(borrow)]
        machine: Option<&'t RawValue>,
        #[serde(borrow)]
        scene: Option<&'t RawValue>,
    }
    let writers: Vec<String> = expected
        .iter()
        .map(|e| format!("`{}` is written by {}", e.format, e.written_by))
        .collect();
    let start = source.text.len() - source.text.trim_start().len();
    let first = Span::point(start as u32);
    let wrong = |span: Span, why: String| json::advise(source, span, &why, &writers);
    let raw: Raw<'_> = serde_json::from_str(&source.text)
        .map_err(|e| json::wrong_with(source, 0, &e, &writers))?;
    let Some(format) = raw.format else {
        let why = "this document has no `format`, which every document of srp begins with";
        return Err(wrong(first, why.to_owned()));
    };
    let place = |raw: &RawValue| {
        let start = raw.get().as_ptr() as usize - source.text.as_ptr() as usize;
        Span::new(start as u32, (start + raw.get().len()) as u32)
    };
    let name: Result<Cow<'_, str>, _> = serde_json::from_str(format.get());
    let known = expected
        .iter()
        .find(|e| name.as_ref().is_ok_and(|n| *n == e.format));
    let Some(known) = known else {
        let names: Vec<String> = expected.iter().map(|e| format!("`{}`", e.format)).collect();
        let why = format!("the format is {}, not {}", format.get(), names.join(" or "));
        return Err(wrong(place(format), why));
    };
    let version = raw.version.map(RawValue::get);
    if version.and_then(|v| v.parse().ok()) != Some(known.version) {
        let has = version.map_or("no version".to_owned(), |v| format!("version {v}"));
        let (name, reads) = (known.format, known.version);
        let why = format!("the document has {has} of `{name}`, and this srp reads version {reads}");
        return Err(wrong(raw.version.map_or(first, place), why));
    }
    let named = |raw: Option<&RawValue>| match raw {
        None => Ok(None),
        Some(raw) => serde_json::from_str::<Option<Named>>(raw.get())
            .map_err(|e| json::wrong(source, place(raw).start as usize, &e)),
    };
    Ok(Head {
        format: known.format,
        place: place(format),
        machine: named(raw.machine)?,
        scene: named(raw.scene)?,
    })
}
