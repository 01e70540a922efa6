//! The line-level check of an OBJ file.
//!
//! `tobj` has no line numbers, lets NaN vertices and bad texture indices pass, refuses comments at
//! the end of a line, and fills in a neighbour's normal where a face gives none. So every line is
//! checked here first, all mistakes in one run, and `tobj` gets a plain rewriting of the file: no
//! comments, no continued lines, only elements that a scene is made of. What a face gives is
//! remembered beside it, in the order of the triangles that `tobj` makes of it.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use srp_archdesc::diagnostic::{Diagnostic, Span};

use super::lines::{Findings, Line, Word, join_continued, lines, number, numbers};
use super::{MAX_COORDINATE, MAX_MATERIALS, MAX_TRIANGLES};

/// Most corners of one face.
const MAX_CORNERS: usize = 1024;

/// Most lines that name libraries of materials.
const MAX_LIBRARIES: usize = 1024;

/// Most vertices, and most of what else a corner names: three for every triangle.
const MAX_ELEMENTS: usize = 3 * MAX_TRIANGLES;

/// An OBJ file, checked.
pub(super) struct Checked {
    /// The rewriting for `tobj`, without `mtllib` and `usemtl` lines.
    pub(super) plain: String,
    /// The properties of each triangle, in `tobj`'s order.
    pub(super) gives: Vec<Gives>,
    /// Names of material libraries, with where they are asked for.
    pub(super) libraries: Vec<(String, Span)>,
    /// Names of materials in order of first use, with where.
    pub(super) used: Vec<(String, Span)>,
}

/// Properties of a triangle beside its vertices.
#[derive(Clone, Copy)]
pub(super) struct Gives {
    /// All its corners have normals.
    pub(super) normals: bool,
    /// All its corners have texture coordinates.
    pub(super) texcoords: bool,
    /// Index into [`Checked::used`], or `None` before the first `usemtl`.
    pub(super) material: Option<u32>,
}

/// Checks `text` line by line; mistakes go to `findings`.
pub(super) fn check(file: &str, text: &str, findings: &mut Findings) -> Checked {
    let joined = join_continued(text);
    let mut reader = Reader {
        file,
        findings,
        vertices: Vec::new(),
        texcoords: 0,
        normals: 0,
        material: None,
        names: BTreeMap::new(),
        checked: Checked {
            plain: String::with_capacity(text.len()),
            gives: Vec::new(),
            libraries: Vec::new(),
            used: Vec::new(),
        },
    };
    let cut_off = !text.is_empty() && !text.ends_with('\n');
    let mut all = lines(&joined).peekable();
    while let Some(line) = all.next() {
        let before = reader.findings.errors;
        reader.line(&line);
        if reader.findings.errors > before && cut_off && all.peek().is_none() {
            let note = "the file ends in this line, without a line break: it may be cut off";
            if let Some(last) = reader.findings.messages.last_mut() {
                last.notes.push(note.to_owned());
            }
        }
    }
    if reader.checked.gives.is_empty() && reader.findings.errors == 0 {
        let message = "the file has no faces: there is nothing to render";
        reader
            .findings
            .push(Diagnostic::error("R0101", file, message));
    }
    reader.checked
}

struct Reader<'a> {
    file: &'a str,
    findings: &'a mut Findings,
    vertices: Vec<[f32; 3]>,
    texcoords: usize,
    normals: usize,
    material: Option<u32>,
    /// The indices of names in [`Checked::used`].
    names: BTreeMap<String, u32>,
    checked: Checked,
}

/// A corner of a face: indices from 0.
struct Corner {
    vertex: usize,
    texcoord: Option<usize>,
    normal: Option<usize>,
}

impl Reader<'_> {
    fn line(&mut self, line: &Line<'_>) {
        match line.key.text {
            "v" => self.vertex(line),
            "vt" => self.texcoord(line),
            "vn" => self.normal(line),
            "f" | "fo" => self.face(line),
            "usemtl" => self.use_material(line),
            "mtllib" => self.library(line),
            // Names, smoothing groups, points and lines make no triangles.
            "o" | "g" | "s" | "p" | "l" | "usemap" | "maplib" | "lod" | "bevel" | "c_interp"
            | "d_interp" | "shadow_obj" | "trace_obj" | "vp" | "mg" => {}
            "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm" | "trim"
            | "hole" | "scrv" | "sp" | "end" | "con" => self.findings.push(
                Diagnostic::warning(
                    "R0103",
                    self.file,
                    format!("`{}` is ignored", line.key.text),
                )
                .at(line.key.span(), "free-form geometry is not supported"),
            ),
            "call" | "csh" => self.findings.push(
                Diagnostic::warning(
                    "R0103",
                    self.file,
                    format!("`{}` is ignored", line.key.text),
                )
                .at(
                    line.key.span(),
                    "no other file is read and no command is run",
                ),
            ),
            other => self.findings.push(
                Diagnostic::error("R0102", self.file, format!("unknown element `{other}`"))
                    .at(line.key.span(), "not an element of OBJ files"),
            ),
        }
    }

    fn error(&mut self, code: &'static str, message: String, span: Span, label: &str) {
        self.findings
            .push(Diagnostic::error(code, self.file, message).at(span, label));
    }

    /// Reads the numbers of a line, `least` to `most` of them. Wrong ones give a placeholder, so that later
    /// indices still count.
    fn numbers(&mut self, line: &Line<'_>, least: usize, most: usize) -> Option<Vec<f32>> {
        if line.words.len() < least || line.words.len() > most {
            let wanted = if least == most {
                format!("{least}")
            } else {
                format!("{least} to {most}")
            };
            self.error(
                "R0104",
                format!(
                    "`{}` with {} instead of {wanted}",
                    line.key.text,
                    numbers(line.words.len())
                ),
                line.span(),
                "",
            );
            return None;
        }
        let mut values = Vec::with_capacity(line.words.len());
        for word in &line.words {
            match number(word.text) {
                Ok(value) => values.push(value),
                Err(why) => {
                    let message = format!("bad number in `{}`", line.key.text);
                    self.error("R0105", message, word.span(), &why);
                    return None;
                }
            }
        }
        Some(values)
    }

    /// True where there is room for one more of `count` elements, of which there may be `most`.
    fn has_room(&mut self, line: &Line<'_>, count: usize, most: usize) -> bool {
        if count >= most {
            let message = format!("more than {most} elements `{}`", line.key.text);
            self.error("R0119", message, line.span(), "the limit is reached here");
        }
        count < most
    }

    /// x y z, an optional w, or an optional colour, which is not used.
    fn vertex(&mut self, line: &Line<'_>) {
        if !self.has_room(line, self.vertices.len(), MAX_ELEMENTS) {
            return;
        }
        let mut position = [0.0; 3];
        if let Some(values) = self.numbers(line, 3, 7) {
            let w = if values.len() == 4 { values[3] } else { 1.0 };
            position = [values[0] / w, values[1] / w, values[2] / w];
            if let Some(word) = (0..3)
                .find(|&k| position[k].is_nan() || position[k].abs() > MAX_COORDINATE)
                .map(|k| line.words[k])
            {
                self.error(
                    "R0106",
                    format!("coordinate outside ±{MAX_COORDINATE:e}"),
                    word.span(),
                    "too far away to be traced in 32 bits",
                );
                position = [0.0; 3];
            }
        }
        self.vertices.push(position);
        let [x, y, z] = position;
        self.plain(format_args!("v {x:?} {y:?} {z:?}"));
    }

    fn texcoord(&mut self, line: &Line<'_>) {
        if !self.has_room(line, self.texcoords, MAX_ELEMENTS) {
            return;
        }
        let values = self.numbers(line, 1, 3).unwrap_or_default();
        let u = values.first().copied().unwrap_or(0.0);
        let v = values.get(1).copied().unwrap_or(0.0);
        self.texcoords += 1;
        self.plain(format_args!("vt {u:?} {v:?}"));
    }

    fn normal(&mut self, line: &Line<'_>) {
        if !self.has_room(line, self.normals, MAX_ELEMENTS) {
            return;
        }
        let values = self.numbers(line, 3, 3).unwrap_or(vec![0.0; 3]);
        self.normals += 1;
        let (x, y, z) = (values[0], values[1], values[2]);
        self.plain(format_args!("vn {x:?} {y:?} {z:?}"));
    }

    fn plain(&mut self, line: std::fmt::Arguments<'_>) {
        writeln!(self.checked.plain, "{line}").expect("writing to a String does not fail");
    }

    fn face(&mut self, line: &Line<'_>) {
        if line.words.len() < 3 || line.words.len() > MAX_CORNERS {
            let corners = match line.words.len() {
                n if n > MAX_CORNERS => format!("more than {MAX_CORNERS}"),
                n => n.to_string(),
            };
            let message = format!("face of {corners} corners instead of 3 to {MAX_CORNERS}");
            self.error("R0107", message, line.span(), "");
            return;
        }
        let before = self.findings.errors;
        let corners: Vec<Corner> = line.words.iter().map(|w| self.corner(w)).collect();
        if self.findings.errors > before {
            return;
        }
        self.warn_if_concave(&corners, line);
        let gives = Gives {
            normals: corners.iter().all(|c| c.normal.is_some()),
            texcoords: corners.iter().all(|c| c.texcoord.is_some()),
            material: self.material,
        };
        let triangles = corners.len() - 2;
        if self.checked.gives.len() + triangles > MAX_TRIANGLES {
            if self.checked.gives.len() <= MAX_TRIANGLES {
                let message = format!("more than {MAX_TRIANGLES} triangles");
                self.error("R0108", message, line.span(), "the limit is reached here");
            }
            return;
        }
        self.checked
            .gives
            .extend(std::iter::repeat_n(gives, triangles));
        let mut text = String::from("f");
        for corner in &corners {
            write!(text, " {}", corner.vertex + 1).expect("writing to a String does not fail");
            // A corner's normal counts only where all its face's corners have one.
            let texcoord = corner.texcoord.filter(|_| gives.texcoords);
            let normal = corner.normal.filter(|_| gives.normals);
            match (texcoord, normal) {
                (None, None) => Ok(()),
                (Some(t), None) => write!(text, "/{}", t + 1),
                (None, Some(n)) => write!(text, "//{}", n + 1),
                (Some(t), Some(n)) => write!(text, "/{}/{}", t + 1, n + 1),
            }
            .expect("writing to a String does not fail");
        }
        self.plain(format_args!("{text}"));
    }

    fn corner(&mut self, word: &Word<'_>) -> Corner {
        let mut parts = word.text.split('/');
        let mut start = word.start;
        let mut next = |count: usize, what: &str, reader: &mut Self| {
            let text = parts.next()?;
            let part = Word { text, start };
            start += text.len() + 1;
            reader.index(part, count, what)
        };
        let corner = Corner {
            vertex: next(self.vertices.len(), "vertex", self).unwrap_or(0),
            texcoord: next(self.texcoords, "texture coordinate", self),
            normal: next(self.normals, "normal", self),
        };
        let slashes = word.text.matches('/').count();
        if slashes > 2 || word.text.starts_with('/') {
            let message = "face corner is not of the form v, v/vt, v//vn or v/vt/vn".to_owned();
            self.error("R0109", message, word.span(), "");
        }
        corner
    }

    /// An index as written: from 1, or negative and relative to the end. Empty gives `None`.
    fn index(&mut self, part: Word<'_>, count: usize, what: &str) -> Option<usize> {
        if part.text.is_empty() {
            return None;
        }
        let Ok(index) = part.text.parse::<i64>() else {
            let message = format!("bad {what} index");
            let why = format!("`{}` is not an integer", part.text);
            self.error("R0110", message, part.span(), &why);
            return None;
        };
        let count = count as i64;
        let absolute = if index < 0 { count + index } else { index - 1 };
        if (0..count).contains(&absolute) {
            return Some(absolute as usize);
        }
        let label = match (index, count) {
            (0, _) => "indices start at 1".to_owned(),
            (_, 0) => format!("there is no {what} before this line"),
            (_, 1) => format!("there is 1 {what} before this line"),
            _ => format!(
                "there are {count} {} before this line",
                what.replace("vertex", "vertice") + "s"
            ),
        };
        let message = format!("{what} index out of range");
        self.error("R0111", message, part.span(), &label);
        None
    }

    /// A face of more than three corners becomes a fan of triangles round its first corner, which
    /// is right for convex faces only.
    fn warn_if_concave(&mut self, corners: &[Corner], line: &Line<'_>) {
        if corners.len() < 4 {
            return;
        }
        let point = |i: usize| {
            let corner = &corners[i % corners.len()];
            glam::DVec3::from(self.vertices[corner.vertex].map(f64::from))
        };
        let cross = |i: usize| (point(i + 1) - point(i)).cross(point(i + 2) - point(i + 1));
        let first = point(0);
        let normal: glam::DVec3 = (1..corners.len() - 1)
            .map(|i| (point(i) - first).cross(point(i + 1) - first))
            .sum();
        let bent = (0..corners.len()).any(|i| {
            let turn = cross(i);
            turn.dot(normal) < -1e-3 * turn.length() * normal.length()
        });
        if bent {
            self.findings.push(
                Diagnostic::warning("R0112", self.file, "this face is not convex")
                    .at(line.span(), "made into triangles round its first corner")
                    .help("divide it into triangles before writing the file"),
            );
        }
    }

    fn use_material(&mut self, line: &Line<'_>) {
        let name = line.rest.text;
        if name.is_empty() {
            let message = "`usemtl` without a name".to_owned();
            self.error("R0113", message, line.key.span(), "");
            return;
        }
        if let Some(known) = self.names.get(name) {
            self.material = Some(*known);
        } else if self.has_room(line, self.names.len(), MAX_MATERIALS) {
            let next = self.checked.used.len() as u32;
            self.names.insert(name.to_owned(), next);
            self.checked.used.push((name.to_owned(), line.rest.span()));
            self.material = Some(next);
        }
    }

    fn library(&mut self, line: &Line<'_>) {
        if line.rest.text.is_empty() {
            let message = "`mtllib` without a name".to_owned();
            self.error("R0114", message, line.key.span(), "");
            return;
        }
        if self.has_room(line, self.checked.libraries.len(), MAX_LIBRARIES) {
            let name = line.rest.text.to_owned();
            self.checked.libraries.push((name, line.rest.span()));
        }
    }
}
