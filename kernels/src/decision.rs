//! Lines of the kernels whose comparisons decide something that studies count by name: those with a comment
//! `decides: NAME`, as the build script finds them.

/// The question that a comparison decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// All light is mirrored at a surface that would let it through (Snell's law has no solution).
    TotalInternalReflection,
}

mod lines {
    use super::Decision;

    include!(concat!(env!("OUT_DIR"), "/decisions.rs"));
}

/// The decision of a line in the kernels that come along; `file` is a path that ends with their name.
pub fn decided_at(file: &str, line: u32) -> Option<Decision> {
    let name = file.rsplit('/').next()?;
    let found = lines::LINES
        .iter()
        .find(|(file, number, _)| (*file, *number) == (name, line));
    found.map(|(.., decision)| *decision)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_decides_about_total_internal_reflection() {
        let [(file, line, decision)] = lines::LINES else {
            panic!("lines that decide: {:?}", lines::LINES);
        };
        let source = crate::SOURCES.iter().find(|s| s.name == *file).expect(file);
        let text = source.text.lines().nth(*line as usize - 1).expect("a line");
        assert!(text.contains("square <= 0.0f"), "{text}");
        assert_eq!(*decision, Decision::TotalInternalReflection);
        assert_eq!(decided_at(source.path, *line), Some(*decision));
        assert_eq!(decided_at(source.path, line + 1), None);
    }
}
