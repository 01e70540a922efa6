//! Where the errors of pictures come from.

use srp_archdesc::Unwatched;
use srp_archdesc::arch::Approx;
use srp_archdesc::datapath::Intersection;
use srp_runtime::effect::{Effects, Guard, find};
use srp_runtime::scene::demo::demo;
use srp_studies::attribution::{self, Attribution, MOST_NODES};
use srp_studies::reference;
use srp_tests::studio::Studio;

/// Pixels of a frame.
const SIZE: (u32, u32) = (64, 48);

fn studio() -> (Studio, Effects) {
    let studio = Studio::of(demo(), SIZE);
    let built = find(&studio.scene).into_iter().collect();
    (studio, built)
}

/// The contributions of the sources add up to the squared error.
fn adds_up(found: &Attribution) {
    let sum: f64 = found.sources.iter().map(|source| source.squared).sum();
    let whole = found.squared_error;
    assert!(
        whole > 0.0 && (sum - whole).abs() <= 1e-9 * whole,
        "{sum} of {whole}"
    );
    for flip in &found.flips {
        assert!(!flip.because.is_empty(), "{flip:?}");
        assert!(flip.pixel.is_some(), "{flip:?}");
    }
}

#[test]
fn the_shadow_of_a_picture_is_the_picture_in_binary64() {
    let (studio, built) = studio();
    let program = studio.program(built);
    let found = studio.attribution(&program, 2, MOST_NODES);
    let found = found.unwrap_or_else(|e| panic!("{e}"));
    assert!(found.complete);
    adds_up(&found);
    let frame = studio.functional(&program, &Guard::default(), 2);
    let frame = frame.unwrap_or_else(|e| panic!("{e}"));
    let options = reference::Options {
        size: SIZE,
        packet: studio.arch.system.buffers.rays,
        threads: 2,
        watch: &Unwatched,
    };
    let expected = reference::picture(&studio.scene, &options).expect("nobody cancels");
    let (mut squares, mut channels, mut flipped) = (0.0, 0.0, 0);
    let pixels = found.pixels.iter().zip(frame.picture.rgba.chunks_exact(4));
    for ((pixel, bytes), expected) in pixels.zip(&expected) {
        let pixel = pixel.as_ref().expect("all tiles were looked into");
        assert_eq!(pixel.value.map(|value| value as u8), bytes[..3]);
        let contributed: f64 = pixel.top.iter().map(|c| c.size()).sum();
        assert!(contributed > 0.0 || pixel.squared_error() == 0.0);
        if pixel.flips > 0 {
            flipped += 1;
            continue;
        }
        for i in 0..3 {
            squares += (pixel.exact[i] - by_the_curve(expected[i])).powi(2);
            channels += 1.0;
        }
    }
    let decibels = 10.0 * (255.0 * 255.0 * channels / squares).log10();
    println!("{decibels:.1} dB, {flipped} pixels with flips");
    assert!(decibels > 90.0, "{decibels:.1} dB");
    assert!(flipped <= 8, "{flipped} pixels with flips");
}

/// A level of sRGB from 0 to 255 as the kernels come to it: on lines between eight places an octave,
/// and with the half that makes truncation round.
fn by_the_curve(level: f64) -> f64 {
    let s = level / 255.0;
    let linear = match s {
        ..=0.04045 => s / 12.92,
        _ => ((s + 0.055) / 1.055).powf(2.4),
    };
    let ends = [0x3900_0000, 0x3f7f_ffff].map(f32::from_bits);
    let linear = linear.clamp(f64::from(ends[0]), f64::from(ends[1]));
    let first = (linear as f32).to_bits() & !0xf_ffff;
    let [x0, x1] = [first, first + 0x10_0000].map(|bits| f64::from(f32::from_bits(bits)));
    let curve = |x: f64| match x {
        ..=0.0031308 => 255.0 * 12.92 * x,
        _ => 255.0 * (1.055 * x.powf(1.0 / 2.4) - 0.055),
    };
    let share = (linear - x0) / (x1 - x0);
    curve(x0) + share * (curve(x1) - curve(x0)) + 0.5
}

/// A unit that is made worse is named, in the picture and in each pixel, however many threads look.
#[test]
fn the_worst_unit_is_named() {
    let coarse = Approx::table(10, 0);
    let (mut studio, built) = studio();
    studio.arch.system.tni.rcp = coarse;
    let program = studio.program(built);
    let [one, two] = [1, 3].map(|threads| {
        let found = studio.attribution(&program, threads, MOST_NODES);
        found.unwrap_or_else(|e| panic!("{e}"))
    });
    adds_up(&one);
    assert_eq!(one.sources, two.sources);
    assert_eq!(one.flips, two.flips);
    assert_eq!(one.pixels, two.pixels);
    // Nor does it matter how much is remembered.
    let short = studio.attribution(&program, 2, 20_000);
    let short = short.unwrap_or_else(|e| panic!("{e}"));
    for (source, expected) in short.sources.iter().zip(&one.sources) {
        let off = (source.squared - expected.squared).abs();
        assert!(off <= 1e-9 * one.squared_error, "{source:?} {expected:?}");
        assert_eq!(source.flips, expected.flips, "{source:?}");
    }
    // A hit that a coarse reciprocal puts in front of the box of its leaf is put onto the box.
    let unit = ["T&I: reciprocal", "T&I: box"];
    let worst = &one.sources[one.ranking[0]];
    assert!(worst.at.is_empty() && unit.contains(&worst.what.as_str()));
    let its = one
        .sources
        .iter()
        .filter(|s| unit.contains(&s.what.as_str()));
    let squared: f64 = its.map(|s| s.squared).sum();
    assert!(
        squared > 0.9 * one.squared_error,
        "{squared} of {}",
        one.squared_error
    );

    let off = |at: &usize| one.pixels[*at].as_ref().map_or(0.0, |p| p.squared_error());
    let at = (0..one.pixels.len()).max_by(|a, b| off(a).total_cmp(&off(b)));
    let at = at.expect("there are pixels") as u32;
    let told = attribution::explain(
        &studio.scene.triangles,
        &studio.image(),
        &program,
        &studio.arch,
        &Guard::default(),
        (at % SIZE.0, at / SIZE.0),
    );
    let told = told.unwrap_or_else(|e| panic!("{e}")).expect("a pixel");
    let known = one.pixels[at as usize].as_ref().expect("a pixel");
    assert_eq!(
        (told.pixel.value, told.pixel.exact),
        (known.value, known.exact)
    );
    let error = told.pixel.error();
    for channel in 0..3 {
        let sum: f64 = told
            .contributions
            .iter()
            .map(|(_, _, error)| error[channel])
            .sum();
        assert!((sum - error[channel]).abs() <= 1e-9 * error[told.channel].abs());
    }
    let (first, last) = (&told.chain[0], told.chain.last().expect("steps"));
    assert!(unit.contains(&first.what.as_str()), "{first:?}");
    assert!((last.effect - error[told.channel]).abs() <= 1e-9 * last.effect.abs());
    assert!(last.at.starts_with("tile.c:"), "{last:?}");

    // The special functions of the SRP, by the lines that use them.
    studio.arch.system.tni.rcp = Approx::Exact;
    studio.arch.precision.rsqrt = coarse;
    let found = studio.attribution(&studio.program(built), 2, MOST_NODES);
    let found = found.unwrap_or_else(|e| panic!("{e}"));
    adds_up(&found);
    let of_roots = found.sources.iter().filter(|source| source.what == "rsqrt");
    let squared: f64 = of_roots.map(|source| source.squared).sum();
    assert!(squared > 0.9 * found.squared_error);
}

/// Whichever test the T&I unit makes, however exact, the shadow of the picture is one and the same.
#[test]
fn the_shadow_does_not_depend_on_the_unit() {
    let mut studio = Studio::of(demo(), (40, 32));
    let built: Effects = find(&studio.scene).into_iter().collect();
    let program = studio.program(built);
    let mut all = Vec::new();
    for test in Intersection::ALL {
        for rcp in [Approx::Exact, Approx::table(16, 0)] {
            studio.arch.system.tni.intersection = test;
            studio.arch.system.tni.rcp = rcp;
            let found = studio.attribution(&program, 2, MOST_NODES);
            let found = found.unwrap_or_else(|e| panic!("{}: {e}", test.name()));
            adds_up(&found);
            all.push((test.name(), found));
        }
    }
    let (_, first) = &all[0];
    for (name, found) in &all[1..] {
        let (mut squares, mut channels) = (0.0, 0.0);
        for (pixel, expected) in found
            .pixels
            .iter()
            .flatten()
            .zip(first.pixels.iter().flatten())
        {
            if pixel.flips > 0 || expected.flips > 0 {
                continue;
            }
            for i in 0..3 {
                squares += (pixel.exact[i] - expected.exact[i]).powi(2);
                channels += 1.0;
            }
        }
        let off: f64 = f64::sqrt(squares / channels);
        assert!(
            channels > 3000.0 && off < 2e-3,
            "{name}: off by {off:e} levels"
        );
    }
}
