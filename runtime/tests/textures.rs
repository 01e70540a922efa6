//! Textures from the statement in an MTL file to the texels in system memory.

use srp_archdesc::ops::V4;
use srp_archdesc::ops::semantics::texture;
use srp_runtime::bvh;
use srp_runtime::memory::BASE;
use srp_runtime::scene::{Level, Loaded, Map, read};
use srp_runtime::scene_image;
use std::io::Cursor;
use std::path::Path;

const OBJ: &str = "mtllib lib/a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
    usemtl plain\nf 1/1 2/2 3/3\nusemtl one\nf 1/1 2/2 3/3\nusemtl two\nf 1/1 2/2 3/3\n";

const MTL: &str = "newmtl unused\nmap_Kd jpg.jpg\nnewmtl plain\nKd 1 0 0\nnewmtl one\n\
    map_Kd sub\\png.png\nmap_Ks -clamp on sub/png.png\nmap_d gray.png\n\
    newmtl two\nmap_Kd jpg.jpg\nmap_Ka sub/png.png\n";

/// Bytes of `srp_material`.
const MATERIAL: u32 = 128;

/// Red grows to the right, green downwards.
fn picture(width: u32, height: u32) -> image::RgbaImage {
    image::RgbaImage::from_fn(width, height, |x, y| {
        image::Rgba([10 * x as u8, 10 * y as u8, 200, 255 - x as u8])
    })
}

fn file(format: image::ImageFormat, picture: image::DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).expect("it is written");
    bytes.into_inner()
}

fn load(mtl: &str) -> Loaded {
    let rgba = image::DynamicImage::ImageRgba8(picture(6, 5));
    let rgb = image::DynamicImage::ImageRgb8(rgba.to_rgb8());
    let gray = image::DynamicImage::ImageLuma8(image::GrayImage::from_pixel(1, 1, [77].into()));
    let files = [
        ("a.obj", OBJ.as_bytes().to_vec()),
        ("lib/a.mtl", mtl.as_bytes().to_vec()),
        ("lib/sub/png.png", file(image::ImageFormat::Png, rgba)),
        ("lib/gray.png", file(image::ImageFormat::Png, gray)),
        ("lib/jpg.jpg", file(image::ImageFormat::Jpeg, rgb)),
        ("lib/torn.png", b"\x89PNG\r\n\x1a\n torn".to_vec()),
    ];
    let find = |path: &Path| {
        let found = files.iter().find(|(name, _)| Path::new(name) == path);
        let missing = || std::io::Error::from(std::io::ErrorKind::NotFound);
        found.map(|(_, bytes)| bytes.clone()).ok_or_else(missing)
    };
    read(Path::new("a.obj"), None, &mut |path, _| find(path)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn textures_in_use_are_read_once_and_turned_upright() {
    let Loaded { scene, warnings } = load(MTL);
    assert_eq!(warnings.render(false), "");
    let names: Vec<&str> = scene.textures.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names, ["lib/sub/png.png", "lib/gray.png", "lib/jpg.jpg"]);
    let material = |i: usize| &scene.materials[scene.triangles[i].material as usize];
    assert_eq!(material(0).maps().count(), 0);
    let map = |texture, clamp| Some(Map { texture, clamp });
    assert_eq!(material(1).diffuse_map, map(0, false));
    assert_eq!(material(1).specular_map, map(0, true));
    assert_eq!(material(1).dissolve_map, map(1, false));
    assert_eq!(material(2).diffuse_map, map(2, false));
    // The first row is the lowest of the picture; brightness stands for the alpha that is missing.
    let png = &scene.textures[0];
    assert_eq!(png.texel(3, 0).to_le_bytes(), [30, 40, 200, 252]);
    assert_eq!(png.texel(0, 4).to_le_bytes(), [0, 0, 200, 255]);
    assert_eq!(scene.textures[1].texel(0, 0).to_le_bytes()[3], 77);
}

/// The texture unit reads the texels of the scene at the descriptors of the image.
#[test]
fn the_image_holds_what_the_texture_unit_reads() {
    let Loaded { scene, .. } = load(MTL);
    let sgrt = srp_archdesc::machines::SGRT;
    let arch = srp_archdesc::parse("sgrt.xml", sgrt.xml).expect("it is shipped");
    let tree = bvh::build(&scene.triangles, &bvh::Options::default());
    let image = scene_image::build(&scene, &tree, &scene.camera, &arch, (8, 8)).expect("it fits");
    let word = |address: u32| {
        let bytes = image.memory.get(address, 4).expect("it is mapped");
        u32::from_le_bytes(bytes.try_into().expect("four bytes"))
    };
    // `materials` and the three maps of a material, as the header has them.
    let materials = word(BASE + 168);
    let descriptors = |triangle: usize| {
        let material = scene.triangles[triangle].material;
        [52, 56, 60].map(|offset| word(materials + material * MATERIAL + offset))
    };
    assert_eq!(descriptors(0), [0; 3]);
    let [kd, ks, d] = descriptors(1);
    assert!(kd != ks && d != 0 && kd % 16 == 0);
    let descriptor = |map: u32| V4([0, 4, 8, 12].map(|i| word(map + i)));
    let [kd, ks, d] = [kd, ks, d].map(descriptor);
    assert_eq!(
        [kd, ks, d].map(|map| map.0[3] & texture::CLAMP),
        [0, texture::CLAMP, 0]
    );
    // 6 x 5, then 3 x 2 and 1 x 1; a picture of one texel has no smaller level.
    assert_eq!([kd, ks, d].map(texture::levels), [2, 2, 0]);
    let png = &scene.textures[0];
    assert_eq!(kd.0[1..3], [png.width, png.height]);
    let whole = Level {
        width: png.width,
        height: png.height,
        texels: png.texels.clone(),
    };
    for (number, level) in std::iter::once(whole).chain(png.smaller()).enumerate() {
        for y in 0..level.height {
            for x in 0..level.width {
                let at = |i: u32, n: u32| ((i as f32 + 0.5) / n as f32).to_bits();
                let detail = (number as f32).to_bits();
                let uv = V4([at(x, level.width), at(y, level.height), detail, 0]);
                let footprint = texture::footprint(kd, uv, 8);
                let texel = level.texels[(y * level.width + x) as usize];
                assert_eq!(word(footprint.addresses[0]), texel);
                assert_eq!(footprint.weights, [0, 0]);
            }
        }
    }
}

#[test]
fn what_is_not_done_is_named_with_its_line() {
    let mtl = "newmtl one\nmap_Kd -s 2 2 1 -o 0 0 0 -clamp on -texres 256 sub/png.png\n\
        map_Ks none.png\nmap_d torn.png\nnewmtl plain\nnewmtl two\n";
    let Loaded { scene, warnings } = load(mtl);
    let text = warnings.render(false);
    for (line, part) in [
        (2, "option `-s` of `map_Kd` is ignored"),
        (2, "option `-texres` of `map_Kd` is ignored"),
        (3, "cannot read the texture `none.png`"),
        (4, "cannot read the texture `torn.png`"),
    ] {
        let at = text.find(part).unwrap_or_else(|| panic!("{part}: {text}"));
        let place = format!("a.mtl:{line}:");
        let next = text[at..].lines().nth(1).unwrap_or("");
        assert!(next.contains(&place), "{part}: {next}");
    }
    assert_eq!(warnings.diagnostics.len(), 4, "{text}");
    assert_eq!(scene.textures.len(), 1);
    assert_eq!(
        scene.materials[2].diffuse_map,
        Some(Map {
            texture: 0,
            clamp: true
        })
    );
}
