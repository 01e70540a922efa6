//! Statements of materials that the kernels do not support.

use std::fmt;

use crate::scene::Scene;

/// Statements of MTL that should change the picture and do not, and the rendering without them.
const UNKNOWN: [(&[&str], &str); 8] = [
    (&["map_bump", "map_Bump", "bump"], "surfaces stay smooth"),
    (&["norm", "map_norm", "map_Norm"], "surfaces stay smooth"),
    (&["disp", "map_disp"], "surfaces are not displaced"),
    (&["decal", "map_decal"], "nothing is stuck on"),
    (&["refl", "map_refl"], "mirrors show the scene alone"),
    (&["map_Ke"], "surfaces shine evenly"),
    (&["map_Ns"], "highlights are even"),
    (
        &["Pr", "Pm", "Ps", "Pc", "Pcr", "aniso", "anisor"],
        "materials are Phong's, not physically based ones",
    ),
];

/// A statement of used materials that the kernels do not support.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsupported {
    /// The statement.
    pub keyword: String,
    /// The first material that makes it.
    pub material: String,
    /// The file that it is in.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// Materials that make it, those of at least one face.
    pub materials: usize,
    /// Faces of these.
    pub faces: usize,
    /// The rendering without it.
    pub instead: &'static str,
}

impl fmt::Display for Unsupported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let others = match self.materials {
            1 => String::new(),
            n => format!(" and {} more", n - 1),
        };
        write!(
            f,
            "{}:{}: `{}` of material `{}`{others} ({} faces) is not supported: {}",
            self.file, self.line, self.keyword, self.material, self.faces, self.instead
        )
    }
}

/// Finds the statements of a scene's used materials that the kernels do not support, one of each kind.
pub fn unsupported(scene: &Scene) -> Vec<Unsupported> {
    let mut faces = vec![0; scene.materials.len()];
    for triangle in &scene.triangles {
        faces[triangle.material as usize] += 1;
    }
    let mut found = Vec::new();
    for (keywords, instead) in UNKNOWN {
        let mut first: Option<Unsupported> = None;
        for (material, &faces) in scene.materials.iter().zip(&faces) {
            let Some(origin) = material.origin.as_ref().filter(|_| faces > 0) else {
                continue;
            };
            let stated = keywords
                .iter()
                .find_map(|&k| origin.statements.get_key_value(k));
            let Some((keyword, &line)) = stated else {
                continue;
            };
            let found = first.get_or_insert_with(|| Unsupported {
                keyword: keyword.clone(),
                material: material.name.clone(),
                file: origin.file.clone(),
                line,
                materials: 0,
                faces: 0,
                instead,
            });
            found.materials += 1;
            found.faces += faces;
        }
        found.extend(first);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;
    use std::path::Path;

    #[test]
    fn what_used_materials_ask_for_in_vain_is_named() {
        let mtl = "newmtl a\nKd 1 1 1\nmap_bump a.png\nnewmtl b\nbump -bm 2 b.png\nnorm b.png\n";
        let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
        let read = |obj: &str| {
            let load = &mut |path: &Path, _| match path.extension().and_then(|e| e.to_str()) {
                Some("obj") => Ok(obj.as_bytes().to_vec()),
                Some("mtl") => Ok(mtl.as_bytes().to_vec()),
                _ => Err(io::ErrorKind::NotFound.into()),
            };
            let loaded = crate::scene::read(Path::new("s.obj"), None, load);
            let loaded = loaded.expect("the scene is right");
            unsupported(&loaded.scene)
                .iter()
                .map(Unsupported::to_string)
                .collect::<Vec<_>>()
        };
        let of_a =
            "m.mtl:3: `map_bump` of material `a` (1 faces) is not supported: surfaces stay smooth";
        assert_eq!(read(obj), [of_a]);
        let both = read(&format!("{obj}usemtl b\nf 3 2 1\nf 1 3 2\n"));
        assert!(both[0].contains("`a` and 1 more (3 faces)"), "{both:?}");
        assert!(
            both[1].starts_with("m.mtl:6: `norm` of material `b` (2 faces)"),
            "{both:?}"
        );
    }
}
