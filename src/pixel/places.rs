//! What lies at an address: objects of the program, and parts of the scene.

use srp_archdesc::isa::Space;
use srp_ir::dre::scheduled::DataSymbol;
use srp_kernels::layout::{LIGHT, MATERIAL, SCENE, Structure, TEXTURE_MAP, TRIANGLE};
use srp_runtime::memory::BASE;
use srp_runtime::scene_image::SceneImage;

/// Names of addresses.
pub(super) struct Places {
    symbols: Vec<DataSymbol>,
    /// Parts of the memory that all cores share, from the one at the lowest address on.
    parts: Vec<Part>,
}

/// A part of the memory that all cores share.
struct Part {
    start: u32,
    name: &'static str,
    /// What its elements look like; else it has words.
    structure: Option<&'static Structure>,
}

impl Places {
    /// Of a program's objects, and of the scene that it renders.
    pub(super) fn of(symbols: &[DataSymbol], image: &SceneImage) -> Places {
        let header = |field| {
            let bytes = image.memory.get(BASE + SCENE.offset(field), 4);
            let bytes = bytes.and_then(|bytes| bytes.try_into().ok());
            bytes.map_or(0, u32::from_le_bytes)
        };
        let part = |start, name, structure| Part {
            start,
            name,
            structure,
        };
        let mut parts = vec![
            part(BASE, "scene", Some(&SCENE)),
            part(image.shading.materials, "material", Some(&MATERIAL)),
            part(header("lights"), "light", Some(&LIGHT)),
            part(image.tree.nodes, "node data", None),
            part(image.tree.triangles, "triangle data", None),
            part(image.shading.triangles, "triangle", Some(&TRIANGLE)),
            part(image.shading.maps, "texture", Some(&TEXTURE_MAP)),
            part(image.frame.address, "frame buffer", None),
        ];
        let texels = image.shading.texels.first().copied();
        parts.push(part(texels.unwrap_or(image.frame.address), "texels", None));
        // Of two at one address, the first is empty.
        parts.sort_by_key(|part| part.start);
        Places {
            symbols: symbols.to_vec(),
            parts,
        }
    }

    /// The name of an address: object and bytes behind its beginning, or element and field.
    pub(super) fn name(&self, space: Space, address: u32) -> String {
        match space {
            Space::Sram => self.object(address),
            Space::Cached => self.part(address),
        }
    }

    fn object(&self, address: u32) -> String {
        let symbol = self
            .symbols
            .iter()
            .find(|symbol| (symbol.address..symbol.address + symbol.size).contains(&address));
        match symbol {
            Some(symbol) => match address - symbol.address {
                0 => symbol.name.clone(),
                offset => format!("{}+{offset}", symbol.name),
            },
            None => format!("{address:#x}"),
        }
    }

    fn part(&self, address: u32) -> String {
        let behind = self.parts.partition_point(|part| part.start <= address);
        let Some(part) = behind.checked_sub(1).map(|i| &self.parts[i]) else {
            return format!("{address:#x}");
        };
        let offset = address - part.start;
        let Some(structure) = part.structure else {
            return format!("{}+{offset}", part.name);
        };
        let (element, offset) = (offset / structure.bytes, offset % structure.bytes);
        let mut fields = structure.fields.iter().rev();
        let field = fields.find(|(_, start)| *start <= offset);
        let (field, start) = field.copied().unwrap_or(("", 0));
        let lane = match offset - start {
            0 => String::new(),
            bytes => format!("[{}]", bytes / 4),
        };
        match part.name {
            "scene" => format!("scene.{field}{lane}"),
            name => format!("{name} {element}.{field}{lane}"),
        }
    }
}
