//! Messages about scenes that cannot be read, or only with doubt: each `scenes/NAME.obj` has its messages in
//! `scenes/NAME.expected`. `BLESS=1` writes them anew.

use std::io;
use std::path::{Path, PathBuf};

use srp_archdesc::diagnostic::Messages;
use srp_runtime::scene::{Loaded, read};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes")
}

/// Reads a scene of the folder; messages name it without the folder.
fn load(name: &str) -> Result<Loaded, Messages> {
    read(Path::new(name), None, &mut |path, _| {
        std::fs::read(folder().join(path)).map_err(|e| io::Error::new(e.kind(), "no such file"))
    })
}

#[test]
fn messages_are_as_expected() {
    let bless = std::env::var_os("BLESS").is_some();
    let mut names: Vec<PathBuf> = std::fs::read_dir(folder())
        .expect("the folder is there")
        .map(|entry| entry.expect("it can be read").path())
        .filter(|path| path.extension().is_some_and(|e| e == "obj"))
        .collect();
    names.push(folder().join("missing.obj"));
    names.sort();
    assert!(names.len() > 10);
    for path in names {
        let name = path.file_name().expect("a file").to_str().expect("ASCII");
        let said = match load(name) {
            Ok(loaded) => format!("{}can be used\n", loaded.warnings.render(false)),
            Err(messages) => messages.render(false),
        };
        let expected = path.with_extension("expected");
        if bless {
            std::fs::write(&expected, &said).expect("it can be written");
        } else {
            let wanted = std::fs::read_to_string(&expected).unwrap_or_default();
            assert_eq!(said, wanted, "{name}");
        }
    }
}

#[test]
fn bytes_of_any_kind_do_no_harm() {
    // Every single-byte change of a scene and of its library gives a scene or messages.
    let scene = b"mtllib a.mtl\nv 0 0 0 # c\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 \\\n 3/1/1\n";
    let library = b"newmtl a\nKd 0.5\nNs 10\nmap_Kd -o 1 x.png\nillum 2\n";
    let mut usable = 0;
    for part in 0..2 {
        let length = [scene.len(), library.len()][part];
        for at in 0..length {
            for byte in [
                b'-', b'0', b'9', b'/', b'\n', b' ', b'\\', b'#', b'n', 0xff, b'.',
            ] {
                let mut files = [scene.to_vec(), library.to_vec()];
                files[part][at] = byte;
                let [scene, library] = files;
                let loaded = read(
                    Path::new("a.obj"),
                    None,
                    &mut |path, _| match path.to_str() {
                        Some("a.obj") => Ok(scene.clone()),
                        Some("a.mtl") => Ok(library.clone()),
                        _ => Err(io::Error::from(io::ErrorKind::NotFound)),
                    },
                );
                match loaded {
                    Ok(loaded) => {
                        usable += 1;
                        assert!(!loaded.scene.triangles.is_empty());
                    }
                    Err(messages) => assert!(messages.errors() > 0, "{at} {byte}"),
                }
            }
        }
    }
    assert!(usable > 200);
}

#[test]
fn what_obj_files_may_hold_is_understood() {
    let scene = "mtllib two words.mtl\r\n\
        v 0 0 0 1.0\r\nv 1 0 0 0.5 0.5 0.5\r\nv 1 1 \\\r\n0\r\nv 0 1 0\r\n\
        vt 0.25 0.5 0\r\nvn 0 0 2\r\no thing\r\ns off\r\n\
        f -4//1 -3//1 -2//1 -1//1 # all of it\r\n\
        usemtl deep red\r\n\
        f 1/1 2/1 3/1\r\n\
        f 1//1 2 3//1\r\nl 1 2\r\np 1\r\n";
    let library = "newmtl deep red\nKd 0.5\nKs 0.1 0.2 0.3 # shiny\nNs 32\nd 0.25\nNi 1.5\nillum 7\nKe 1 0 0\n\
        map_Kd -s 1 1 1 -clamp on my texture.png\n";
    let loaded = read(
        Path::new("dir/a.obj"),
        None,
        &mut |path, _| match path.to_str() {
            Some("dir/a.obj") => Ok(scene.as_bytes().to_vec()),
            Some("dir/two words.mtl") => Ok(library.as_bytes().to_vec()),
            _ => Err(io::Error::from(io::ErrorKind::NotFound)),
        },
    )
    .expect("a correct scene");
    let warnings = loaded.warnings.render(false);
    assert!(warnings.starts_with("warning[R0212]: cannot read the texture `my texture.png`"));
    assert_eq!(loaded.warnings.diagnostics.len(), 1);
    let scene = loaded.scene;
    assert_eq!(scene.triangles.len(), 4);
    assert_eq!(scene.name, "a");
    // The quadrilateral, divided from its first corner, with the normal made unit.
    assert_eq!(scene.triangles[1].positions[2].to_array(), [0.0, 1.0, 0.0]);
    assert_eq!(scene.triangles[0].normals[1].to_array(), [0.0, 0.0, 1.0]);
    assert_eq!(
        scene.materials[scene.triangles[0].material as usize].name,
        "(none)"
    );
    let red = &scene.materials[scene.triangles[2].material as usize];
    assert_eq!((red.name.as_str(), red.diffuse), ("deep red", [0.5; 3]));
    assert_eq!(red.specular, [0.1, 0.2, 0.3]);
    assert_eq!(
        (red.exponent, red.dissolve, red.refraction_index),
        (32.0, 0.25, 1.5)
    );
    assert_eq!((red.illumination, red.emission), (7, [1.0, 0.0, 0.0]));
    assert_eq!(red.diffuse_map, None);
    assert_eq!(scene.triangles[2].uvs[0].to_array(), [0.25, 0.5]);
    // A face of which one corner has no normal is flat.
    assert_eq!(scene.triangles[3].normals[0].to_array(), [0.0, 0.0, 1.0]);
    // Its emitting faces are the light.
    assert_eq!(scene.lights[0].colour, [1.0, 0.0, 0.0]);
}
