//! Effects that are left out of a frame: what is said of them is what the pictures show.

use super::{folder, srp};
use std::path::Path;

/// Renders the default scene without a clock. Returns the picture, and what was said.
fn render(folder: &Path, args: &[&str]) -> (image::RgbImage, String) {
    let frame = ["render", "--size", "64x48", "--fidelity", "functional"];
    let output = srp(folder, &[&frame[..], args].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    let picture = image::open(folder.join("out.png")).expect("it is a picture");
    (picture.to_rgb8(), said)
}

#[test]
fn the_pixels_that_an_effect_touches_are_told() {
    let folder = folder("left-out");
    let (whole, said) = render(&folder, &[]);
    assert!(!said.contains("left out"), "{said}");
    let mut told = Vec::new();
    for effect in ["shadow", "reflection", "texture"] {
        let (without, said) = render(&folder, &["--effects", &format!("-{effect}")]);
        let differ = whole
            .pixels()
            .zip(without.pixels())
            .filter(|(a, b)| a != b)
            .count();
        let line = format!("`{effect}`, which is left out, touches {differ} of 3072 pixels\n");
        // Digits stand in groups.
        let close = |text: &str| text.replace(' ', "");
        assert!(close(&said).contains(&close(&line)), "{line}{said}");
        told.push(differ);
    }
    told.dedup();
    assert_eq!(told.len(), 3, "each has pixels of its own: {told:?}");

    // What is not called for touches nothing, and nothing is said of it.
    let (same, said) = render(&folder, &["--effects", "-emission"]);
    assert!(same == whole && !said.contains("left out"), "{said}");
}
