//! The structures of `scene.h`: where each field lies. The build script reads them from the header,
//! so whoever writes a structure in Rust and whoever reads it in C cannot disagree.

/// A structure that C code reads or writes in memory.
#[derive(Debug)]
pub struct Structure {
    /// Its name in C.
    pub name: &'static str,
    /// Its size.
    pub bytes: u32,
    /// Its fields in order: name and byte offset.
    pub fields: &'static [(&'static str, u32)],
}

impl Structure {
    /// The byte offset of a field.
    ///
    /// # Panics
    ///
    /// Where the structure has no such field.
    pub fn offset(&self, field: &str) -> u32 {
        let found = self.fields.iter().find(|(name, _)| *name == field);
        let (_, offset) = found.unwrap_or_else(|| panic!("{} has no field {field}", self.name));
        *offset
    }
}

include!(concat!(env!("OUT_DIR"), "/structures.rs"));

#[cfg(test)]
mod tests {
    use super::*;

    /// The offsets that the header's comments state.
    #[test]
    fn fields_lie_where_the_header_says() {
        let text = crate::header("scene.h").expect("it comes along").text;
        let mut checked = 0;
        for structure in [&SCENE, &TRIANGLE, &LIGHT, &MATERIAL, &TEXTURE_MAP, &RAY] {
            let end = text.find(&format!("}} {};", structure.name));
            let end = end.expect("it is declared");
            let body = text[..end].rsplit("typedef struct {").next();
            for line in body.unwrap_or_default().lines() {
                let Some((declaration, rest)) = line.split_once(';') else {
                    continue;
                };
                let comment = rest.trim_start().trim_start_matches("/*");
                let name = declaration.rsplit([' ', '*']).next().unwrap_or_default();
                let name = name.split('[').next().unwrap_or_default();
                let stated = comment.split(':').next().unwrap_or_default();
                if let Ok(stated) = stated.trim().parse::<u32>() {
                    assert_eq!(structure.offset(name), stated, "{}", structure.name);
                    checked += 1;
                }
            }
        }
        assert!(checked > 40, "{checked} comments with an offset");
    }
}
