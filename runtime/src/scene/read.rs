//! From an OBJ file and its material libraries to a [`Scene`].

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use glam::{Vec2, Vec3};
use srp_archdesc::diagnostic::{Diagnostic, Messages, Source};

use super::lines::Findings;
use super::load::{Load, Part};
use super::obj::{self, Checked};
use super::texture::{Channel, Map, Pictures, Texture};
use super::{Camera, Material, Options, Origin, Scene, Triangle, bounds, default_lights, map, mtl};

/// Light that reaches every surface where a file does not say.
const AMBIENT: [f32; 3] = [0.18; 3];

/// The light behind the scene where a file does not state it.
const BACKGROUND: [f32; 3] = [0.66, 0.9, 1.36];

/// Most bytes of a scene file: positions in it are counted with 32 bits.
const MAX_FILE_BYTES: usize = 1 << 30;

/// Most bytes of all libraries of materials together.
const MAX_LIBRARY_BYTES: usize = 64 << 20;

/// Most libraries that one line names.
const MAX_LIBRARIES: usize = 16;

/// A scene, and the doubts about its files.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// Warnings.
    pub warnings: Messages,
}

fn add(messages: &mut Messages, findings: Findings, name: &str, text: String) {
    let found = findings.finish(name);
    if !found.is_empty() {
        messages.sources.push(Source::new(name, text));
        messages.diagnostics.extend(found);
    }
}

/// Reads the scene in the OBJ file at `path`. `load` gives the bytes of a file; material libraries
/// are asked for beside the OBJ file. Text that is not UTF-8 is taken where it does not matter.
///
/// A missing material library or material is a warning, and its faces are grey; so is a texture that
/// cannot be read, and its material is the same everywhere. Pictures, png or jpg, are asked for
/// beside the library that names them.
///
/// The camera looks at
/// the whole scene from its upper right front, unless `camera` is given; the light follows
/// [`default_lights`].
pub fn read(path: &Path, camera: Option<Camera>, load: &mut Load<'_>) -> Result<Loaded, Messages> {
    let name = path.display().to_string();
    let mut messages = Messages::default();
    let text = match load(path, Part::Geometry) {
        Ok(bytes) => into_text(bytes),
        Err(why) => {
            let message = format!("cannot read the scene: {why}");
            messages
                .diagnostics
                .push(Diagnostic::error("R0100", &name, message));
            return Err(messages);
        }
    };
    if text.len() > MAX_FILE_BYTES {
        let message = format!("the file is larger than {MAX_FILE_BYTES} bytes");
        messages
            .diagnostics
            .push(Diagnostic::error("R0118", &name, message));
        return Err(messages);
    }
    let mut findings = Findings::new();
    let checked = obj::check(&name, &text, &mut findings);
    let mut of_libraries = Messages::default();
    let found = libraries(path, &checked, &mut findings, &mut of_libraries, load);
    let (mut materials, indices) = resolve(&checked, &found, &name, &mut findings);
    let textures = in_use(found.pictures.textures, &mut materials);
    add(&mut messages, findings, &name, text);
    messages.diagnostics.extend(of_libraries.diagnostics);
    messages.sources.extend(of_libraries.sources);
    if messages.errors() > 0 {
        return Err(messages);
    }
    let triangles = triangles(&checked, &indices).map_err(|why| {
        let message = format!("the scene cannot be read: {why}");
        Messages {
            diagnostics: vec![Diagnostic::error("R0115", &name, message)],
            sources: Vec::new(),
        }
    })?;
    let stem = path.file_stem().unwrap_or_default();
    let camera = camera.unwrap_or_else(|| overview(&triangles));
    let lights = default_lights(&triangles, &materials, &camera);
    Ok(Loaded {
        scene: Scene {
            name: stem.to_string_lossy().into_owned(),
            lights,
            triangles,
            materials,
            textures,
            ambient: AMBIENT,
            background: BACKGROUND,
            camera,
            options: Options::default(),
        },
        warnings: messages,
    })
}

/// Bytes as text, without a mark of their order; a question mark stands for each that is no part of one.
fn into_text(mut bytes: Vec<u8>) -> String {
    if bytes.starts_with("\u{feff}".as_bytes()) {
        bytes.drain(..3);
    }
    String::from_utf8(bytes).unwrap_or_else(|e| {
        let mut bytes = e.into_bytes();
        let mut done = 0;
        while let Err(e) = std::str::from_utf8(&bytes[done..]) {
            let wrong = done + e.valid_up_to();
            done = (wrong + e.error_len().unwrap_or(1)).min(bytes.len());
            bytes[wrong..done].fill(b'?');
        }
        String::from_utf8(bytes).expect("all that was not UTF-8 is replaced")
    })
}

/// The materials of the libraries by name, with their pictures; `complete` where all libraries could
/// be read.
struct Found {
    materials: BTreeMap<String, Material>,
    pictures: Pictures,
    complete: bool,
}

fn libraries(
    path: &Path,
    checked: &Checked,
    findings: &mut Findings,
    messages: &mut Messages,
    load: &mut Load<'_>,
) -> Found {
    let mut found = Found {
        materials: BTreeMap::new(),
        pictures: Pictures::default(),
        complete: true,
    };
    let beside = |name: &str| path.parent().unwrap_or(Path::new("")).join(name);
    let mut seen: BTreeSet<&str> = BTreeSet::new();
    let mut room = MAX_LIBRARY_BYTES;
    for (given, span) in &checked.libraries {
        if seen.contains(given.as_str()) {
            continue;
        }
        // A name may contain blanks; a line may also name several files.
        let whole = load(&beside(given), Part::Materials);
        let loaded: Vec<(&str, io::Result<Vec<u8>>)> = match whole {
            Err(_) if given.contains(char::is_whitespace) => (given.split_whitespace())
                .take(MAX_LIBRARIES)
                .map(|name| (name, load(&beside(name), Part::Materials)))
                .collect(),
            whole => vec![(given, whole)],
        };
        for (name, bytes) in loaded {
            if !seen.insert(name) {
                continue;
            }
            let why = match bytes {
                Ok(bytes) if bytes.len() <= room => {
                    room -= bytes.len();
                    library(&beside(name), into_text(bytes), &mut found, messages, load);
                    continue;
                }
                Ok(_) => "all libraries together are larger than 64 MiB".to_owned(),
                Err(why) => why.to_string(),
            };
            found.complete = false;
            let message = format!("cannot read the material library `{name}`: {why}");
            findings.push(
                Diagnostic::warning("R0116", &path.display().to_string(), message)
                    .at(*span, "its materials are grey"),
            );
        }
    }
    found
}

fn library(
    path: &Path,
    text: String,
    found: &mut Found,
    messages: &mut Messages,
    load: &mut Load<'_>,
) {
    let name = &path.display().to_string();
    let mut findings = Findings::new();
    let (plain, mut origins) = mtl::check(name, &text, &mut findings);
    found.complete &= findings.errors == 0;
    if findings.errors == 0 {
        match tobj::load_mtl_buf(&mut plain.as_bytes()) {
            Ok((materials, _)) => {
                for material in materials {
                    let origin = origins.remove(&material.name);
                    found
                        .materials
                        .insert(material.name.clone(), convert(material, origin));
                }
            }
            Err(why) => findings.push(Diagnostic::error(
                "R0211",
                name,
                format!("the material library cannot be read: {why}"),
            )),
        }
    }
    if findings.errors == 0 {
        maps(path, &text, found, &mut findings, load);
    }
    add(messages, findings, name, text);
}

/// Gives the materials of a library their textures.
fn maps(path: &Path, text: &str, found: &mut Found, findings: &mut Findings, load: &mut Load<'_>) {
    let library = path.display().to_string();
    for statement in map::statements(&library, text, findings) {
        let Some(material) = found.materials.get_mut(&*statement.material) else {
            continue;
        };
        let (place, channel) = match statement.keyword.as_str() {
            "map_Kd" => (&mut material.diffuse_map, Channel::Colour),
            "map_Ks" => (&mut material.specular_map, Channel::Colour),
            _ => (&mut material.dissolve_map, Channel::Dissolve),
        };
        // Files from other systems write their own separators.
        let file = statement.file.replace('\\', "/");
        let at = path.parent().unwrap_or(Path::new("")).join(file);
        *place = match found.pictures.read(&at, channel, load) {
            Ok(texture) => Some(Map {
                texture,
                clamp: statement.clamp,
            }),
            Err(why) => {
                let message = format!("cannot read the texture `{}`: {why}", statement.file);
                let label = "the material is the same everywhere";
                findings.push(
                    Diagnostic::warning("R0212", &library, message).at(statement.span, label),
                );
                None
            }
        };
    }
}

/// The pictures that materials name, which are numbered anew.
fn in_use(pictures: Vec<Texture>, materials: &mut [Material]) -> Vec<Texture> {
    let mut numbers = BTreeMap::new();
    for map in materials.iter_mut().flat_map(Material::maps_mut) {
        let next = numbers.len() as u32;
        map.texture = *numbers.entry(map.texture).or_insert(next);
    }
    let numbered = (0..)
        .zip(pictures)
        .filter_map(|(old, t)| Some((*numbers.get(&old)?, t)));
    let numbered: BTreeMap<u32, Texture> = numbered.collect();
    numbered.into_values().collect()
}

fn convert(m: tobj::Material, origin: Option<Origin>) -> Material {
    let filter = m.unknown_param.get("Tf").map(|text| rgb(text));
    Material {
        diffuse: m.diffuse.unwrap_or([0.8; 3]),
        specular: m.specular.unwrap_or([0.0; 3]),
        emission: m.emissive.unwrap_or([0.0; 3]),
        exponent: m.shininess.unwrap_or(1.0),
        dissolve: m.dissolve.unwrap_or(1.0),
        refraction_index: m.optical_density.unwrap_or(1.0),
        filter: filter.unwrap_or([1.0; 3]),
        // A highlight without a model is meant to be seen.
        illumination: m.illumination_model.unwrap_or(2),
        diffuse_map: None,
        specular_map: None,
        dissolve_map: None,
        name: m.name,
        origin,
    }
}

/// The three numbers that the check has written.
fn rgb(text: &str) -> [f32; 3] {
    let mut numbers = text.split_whitespace().map_while(|w| w.parse().ok());
    [(); 3].map(|()| numbers.next().unwrap_or(1.0))
}

/// The material of faces that name none, or one that is not found.
fn grey() -> Material {
    Material::diffuse("(none)", [0.7; 3])
}

/// The materials of the scene, and for each name that is used the index of its material. The
/// first material is the grey one.
fn resolve(
    checked: &Checked,
    found: &Found,
    file: &str,
    findings: &mut Findings,
) -> (Vec<Material>, Vec<u32>) {
    let mut materials = vec![grey()];
    let mut indices = Vec::with_capacity(checked.used.len());
    for (name, span) in &checked.used {
        match found.materials.get(name) {
            Some(material) => {
                indices.push(materials.len() as u32);
                materials.push(material.clone());
            }
            None => {
                indices.push(0);
                if found.complete {
                    let message = format!("unknown material `{name}`");
                    let label = if found.materials.is_empty() {
                        "no material library is given; its faces are grey"
                    } else {
                        "in none of the material libraries; its faces are grey"
                    };
                    findings.push(Diagnostic::warning("R0117", file, message).at(*span, label));
                }
            }
        }
    }
    (materials, indices)
}

fn triangles(checked: &Checked, indices: &[u32]) -> Result<Vec<Triangle>, tobj::LoadError> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ..Default::default()
    };
    let (models, _) = tobj::load_obj_buf(&mut checked.plain.as_bytes(), &options, |_| {
        tobj::load_mtl_buf(&mut io::empty())
    })?;
    let mut gives = checked.gives.iter();
    let mut triangles = Vec::with_capacity(checked.gives.len());
    for mesh in models.iter().map(|m| &m.mesh) {
        let vec3 = |from: &[f32], i: u32| Vec3::from_slice(&from[3 * i as usize..]);
        for (n, corners) in mesh.indices.chunks_exact(3).enumerate() {
            let gives = gives.next().ok_or(tobj::LoadError::GenericFailure)?;
            let mut triangle = Triangle {
                positions: [0, 1, 2].map(|k| vec3(&mesh.positions, corners[k])),
                normals: [Vec3::ZERO; 3],
                uvs: [Vec2::ZERO; 3],
                material: gives.material.map_or(0, |m| indices[m as usize]),
            };
            let geometric = triangle.geometric_normal();
            triangle.normals = [geometric; 3];
            if gives.normals {
                triangle.normals = [0, 1, 2].map(|k| {
                    let given = vec3(&mesh.normals, mesh.normal_indices[3 * n + k]).as_dvec3();
                    given.normalize_or(geometric.as_dvec3()).as_vec3()
                });
            }
            if gives.texcoords {
                triangle.uvs = [0, 1, 2].map(|k| {
                    let i = mesh.texcoord_indices[3 * n + k] as usize;
                    Vec2::from_slice(&mesh.texcoords[2 * i..])
                });
            }
            triangles.push(triangle);
        }
    }
    if gives.next().is_some() {
        return Err(tobj::LoadError::GenericFailure);
    }
    Ok(triangles)
}

/// A camera outside the scene that sees all of it.
fn overview(triangles: &[Triangle]) -> Camera {
    let (lo, hi) = bounds(triangles).unwrap_or((Vec3::ZERO, Vec3::ONE));
    let centre = 0.5 * lo + 0.5 * hi;
    // In binary64, where no square of a length underflows or overflows.
    let radius = (0.5 * hi - 0.5 * lo).as_dvec3().length() as f32;
    let radius = radius.max(f32::MIN_POSITIVE);
    let from = Vec3::new(0.5, 0.45, 0.75).normalize();
    Camera::looking_at(centre + from * (2.6 * radius), centre, 45.0)
}
