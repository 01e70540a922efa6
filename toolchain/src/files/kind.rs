//! The kinds of files that are read: how large each may be, and how it begins.

/// A kind of input file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// C, a header, or a kernel in another language.
    Source,
    /// A machine.
    Machine,
    /// A program in the intermediate form (`.ir`).
    Program,
    /// A divided program (`.dre.xml`).
    Divided,
    /// A scheduled program, or schedules of loops (`.sched.xml`).
    Scheduled,
    /// A dataflow graph.
    Graph,
    /// Geometry of a scene (`.obj`).
    Geometry,
    /// A library of materials (`.mtl`).
    Materials,
    /// A picture on surfaces.
    Picture,
    /// Viewpoints (`cameras.json`).
    Cameras,
    /// Rays for the T&I unit.
    Rays,
    /// Answers of another ray tracer.
    Answers,
    /// Requests to a memory.
    Trace,
    /// A report, a profile or the account of a frame, as JSON.
    Report,
    /// A plan of a sweep.
    Plan,
    /// Hard cases.
    Cases,
    /// The jobs and rows in the folder of a sweep.
    Rows,
    /// The state of a frame or a program on the way.
    Checkpoint,
}

/// How a file of a kind can be told from others before anything of it is read, and shown.
type Sign = (fn(&[u8]) -> bool, &'static str);

const XML: Option<Sign> = Some((
    |text| first(text) == Some(b'<'),
    "not XML, which begins with `<`",
));
const JSON: Option<Sign> = Some((
    |text| matches!(first(text), Some(b'{' | b'[')),
    "not JSON, which begins with `{` or `[`",
));
const NUMBERS: Option<Sign> = Some((
    |text| first_of_data(text).is_none_or(|b| b.is_ascii_digit() || b"+-.".contains(&b)),
    "the first line does not begin with a number",
));
const VERTICES: Option<Sign> = Some((has_vertices, "no line begins with `v`"));

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 18] = [
        Kind::Source,
        Kind::Machine,
        Kind::Program,
        Kind::Divided,
        Kind::Scheduled,
        Kind::Graph,
        Kind::Geometry,
        Kind::Materials,
        Kind::Picture,
        Kind::Cameras,
        Kind::Rays,
        Kind::Answers,
        Kind::Trace,
        Kind::Report,
        Kind::Plan,
        Kind::Cases,
        Kind::Rows,
        Kind::Checkpoint,
    ];

    /// The table: what a file is, the most bytes of it, and its sign.
    const fn row(self) -> (&'static str, u64, Option<Sign>) {
        const MIB: u64 = 1 << 20;
        match self {
            Kind::Source => ("source", 64 * MIB, None),
            Kind::Machine => ("machine", 16 * MIB, XML),
            Kind::Program => ("program", 64 * MIB, None),
            Kind::Divided => ("divided program", 64 * MIB, XML),
            Kind::Scheduled => ("schedule", 64 * MIB, XML),
            Kind::Graph => ("graph", 16 * MIB, None),
            Kind::Geometry => ("scene", 1024 * MIB, VERTICES),
            Kind::Materials => ("library of materials", 16 * MIB, None),
            Kind::Picture => ("picture", 256 * MIB, None),
            Kind::Cameras => ("file of cameras", 16 * MIB, JSON),
            Kind::Rays => ("file of rays", 1024 * MIB, NUMBERS),
            Kind::Answers => ("file of answers", 64 * MIB, NUMBERS),
            Kind::Trace => ("trace", 1024 * MIB, NUMBERS),
            Kind::Report => ("report", 64 * MIB, JSON),
            Kind::Plan => ("plan", MIB, None),
            Kind::Cases => ("file of hard cases", 16 * MIB, None),
            Kind::Rows => ("table of a sweep", 256 * MIB, JSON),
            Kind::Checkpoint => ("checkpoint", 1024 * MIB, None),
        }
    }

    /// The words for a file of this kind.
    pub const fn what(self) -> &'static str {
        self.row().0
    }

    /// The most bytes of a file of this kind.
    pub const fn limit(self) -> u64 {
        self.row().1
    }

    /// Why these bytes are no file of this kind, where that shows without a look at what they say.
    pub(super) fn refusal(self, bytes: &[u8]) -> Option<String> {
        let (what, _, sign) = self.row();
        let (has_sign, lacks) = sign?;
        let is_blank = bytes.trim_ascii().is_empty();
        (!is_blank && !has_sign(bytes)).then(|| format!("{lacks}: it is no {what}"))
    }
}

/// The first byte that is no blank, after a byte order mark.
fn first(text: &[u8]) -> Option<u8> {
    let text = text.strip_prefix("\u{feff}".as_bytes()).unwrap_or(text);
    text.trim_ascii_start().first().copied()
}

/// The first byte of the first line that is no comment.
fn first_of_data(text: &[u8]) -> Option<u8> {
    let mut lines = text.split(|&b| b == b'\n').map(<[u8]>::trim_ascii_start);
    lines.find_map(|line| line.first().copied().filter(|&b| b != b'#'))
}

/// True if a line has a vertex, with which every scene begins.
fn has_vertices(text: &[u8]) -> bool {
    let mut lines = text.split(|&b| b == b'\n').map(<[u8]>::trim_ascii_start);
    lines.any(|line| matches!(line, [b'v', b' ' | b'\t', ..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_other_kinds_are_told() {
        let passwords = b"root:x:0:0:root:/root:/bin/bash\nvera:x:1:1:\n";
        for kind in Kind::ALL {
            let refusal = kind.refusal(passwords);
            assert_eq!(refusal.is_some(), kind.row().2.is_some(), "{kind:?}");
            assert!(!refusal.unwrap_or_default().contains("root"), "{kind:?}");
            assert_eq!(kind.refusal(b" \n"), None, "{kind:?}: its reader says more");
        }
        assert_eq!(Kind::Machine.refusal("\u{feff}\n<srp/>".as_bytes()), None);
        assert_eq!(Kind::Rays.refusal(b"# rays\n\n-1 0 0 1 0 0\n"), None);
        assert_eq!(Kind::Geometry.refusal(b"mtllib a\n  v 0 0 0\n"), None);
    }
}
