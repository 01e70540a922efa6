//! The objects that lie in system memory, by name: a miss of a cache is for one of them.

use std::ops::Range;

use super::SceneImage;
use crate::memory::BASE;
use crate::scene::Scene;

/// An object in system memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Object {
    /// Its name.
    pub name: String,
    /// Its addresses, up to those of the next object.
    pub addresses: Range<u32>,
}

/// The objects of a scene's image, in the order of their addresses, without gaps.
pub fn objects(image: &SceneImage, scene: &Scene) -> Vec<Object> {
    let shading = &image.shading;
    let mut starts = vec![
        ("scene".to_owned(), BASE),
        ("materials".to_owned(), shading.materials),
        ("lights".to_owned(), shading.lights),
        ("nodes of the tree".to_owned(), image.tree.nodes),
        ("triangles of the tree".to_owned(), image.tree.triangles),
        ("shading data of triangles".to_owned(), shading.triangles),
        ("texture descriptors".to_owned(), shading.maps),
    ];
    let texels = scene.textures.iter().zip(&shading.texels);
    starts.extend(texels.map(|(texture, &start)| (format!("texels of {}", texture.name), start)));
    starts.push(("frame buffer".to_owned(), image.frame.address));
    let ends = (starts[1..].iter()).map(|&(_, start)| start);
    let ends: Vec<u32> = ends.chain([BASE + image.memory.len() as u32]).collect();
    let all = starts.into_iter().zip(ends);
    all.map(|((name, start), end)| Object {
        name,
        addresses: start..end,
    })
    .filter(|object| !object.addresses.is_empty())
    .collect()
}
