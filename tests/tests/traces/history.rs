//! Histories of pixels: against the picture, and each thing against those that it was made of.

use super::frame::Film;
use srp_archdesc::isa::{Effect, Opcode, Ty};
use srp_runtime::system::{self, Timing};
use srp_toolchain::system_options;
use srp_traces::history::{Made, MadeWhat, Operation, Place, StoreWatch, Stored, Want, history};
use srp_traces::{Tracer, Window};
use std::collections::{BTreeMap, BTreeSet};

/// The words of a value of a type.
fn lanes(value: [u32; 4], ty: Ty) -> Vec<u32> {
    match ty {
        Ty::Vec => value.to_vec(),
        Ty::Word | Ty::Pred => value[..1].to_vec(),
    }
}

/// The words that can be read of something.
fn given(made: &Made) -> Vec<u32> {
    match &made.what {
        MadeWhat::Operation(operation) => match operation.result {
            Some((value, ty)) => lanes(value.0, ty),
            None => operation
                .operands
                .last()
                .map_or(Vec::new(), |&(v, ty)| lanes(v.0, ty)),
        },
        MadeWhat::Ray(ray) => ray.hit.words().to_vec(),
    }
}

/// The words that something has read.
fn taken(made: &Made) -> Vec<u32> {
    match &made.what {
        MadeWhat::Operation(operation) => {
            let operands = operation.operands.iter();
            let mut words: Vec<u32> = operands.flat_map(|&(v, ty)| lanes(v.0, ty)).collect();
            if operation.opcode.info().effect == Effect::Load {
                words.extend(given(made));
            }
            words
        }
        MadeWhat::Ray(ray) => ray.ray.words().to_vec(),
    }
}

fn operation(made: &Made) -> Option<&Operation> {
    match &made.what {
        MadeWhat::Operation(operation) => Some(operation),
        MadeWhat::Ray(_) => None,
    }
}

#[test]
fn a_pixel_is_made_of_its_history() {
    let film = Film::of((24, 16));
    let mut opcodes = BTreeSet::new();
    let mut hits = BTreeMap::new();
    for (x, y) in [(0, 0), (9, 5), (23, 15), (12, 8), (17, 11)] {
        let image = film.image();
        let pixel = image.frame.address + 4 * (y * image.frame.stride + x);
        let tile = y / 8 * image.across + x / 8;
        let (bytes, stored) = last_store(&film, pixel, tile);
        let made = recorded(&film, &stored, pixel);

        // What was stored last is what the picture has.
        let last = made.iter().rev().filter_map(operation).next();
        let last = last.expect("there is a store");
        assert_eq!(last.opcode.info().effect, Effect::Store);
        assert_eq!(last.address, Some(pixel));
        assert_eq!(last.operands[2].0.0[0].to_le_bytes()[..3], bytes[..3]);

        // Each thing has read a word of each that it was made of, after that was made.
        let by_id: BTreeMap<u32, &Made> = made.iter().map(|made| (made.id, made)).collect();
        for made in &made {
            for id in &made.from {
                let from = by_id[id];
                assert!(from.id < made.id && from.cycle <= made.cycle);
                let read = taken(made);
                let is_read = given(from).iter().any(|word| {
                    let is_part =
                        |&of: &u32| of == *word || word.to_le_bytes().contains(&(of as u8));
                    read.iter().any(is_part)
                });
                assert!(is_read, "{made:?} reads nothing of {from:?}");
            }
        }

        // A ray brings it about, and its launches are those that a window of one has.
        let rays = made.iter().filter(|made| operation(made).is_none()).count();
        assert!(rays > 0, "no ray for {x},{y}");
        for made in &made {
            if let MadeWhat::Ray(ray) = &made.what {
                assert!(ray.returned > made.cycle && ray.cost.is_some());
                *hits.entry(ray.hit.hit.is_hit()).or_insert(0) += 1;
            }
        }
        launches(&film, &stored, &made);
        opcodes.extend(made.iter().filter_map(operation).map(|o| o.opcode));
        // Whose value it has is not only told for its address.
        assert!(made.iter().any(|made| made.want == Want::Address));
        assert!(made.iter().filter(|made| made.want == Want::Value).count() > 40);
    }
    assert!(opcodes.contains(&Opcode::Tex) && opcodes.contains(&Opcode::Gsw));
    assert!(
        hits.len() == 2,
        "rays that hit, and rays that do not: {hits:?}"
    );
}

/// The bytes of a pixel, and its last store.
fn last_store(film: &Film, pixel: u32, tile: u32) -> ([u8; 4], Stored) {
    let session = srp_tests::session();
    let mut watch = StoreWatch::new(pixel, tile);
    let options = system::Options {
        observer: Some(&mut watch),
        ..system_options(
            &film.program,
            film.arch(),
            Default::default(),
            Timing::Full,
            &session,
        )
    };
    let cores = (0..film.arch().system.cores).map(|_| film.interpreter());
    let mut image = film.image();
    let report = system::run(&mut image, cores.collect(), film.arch(), options);
    report.expect("the frame is finished");
    let bytes = image
        .memory
        .get(pixel, 4)
        .expect("it is in the frame buffer");
    let bytes = bytes.try_into().expect("a pixel has four bytes");
    (bytes, watch.stored().expect("each pixel is stored"))
}

/// The history of a pixel.
fn recorded(film: &Film, stored: &Stored, pixel: u32) -> Vec<Made> {
    let window = Window::Cycles {
        cycles: stored.cycles.clone(),
        core: Some(stored.core),
    };
    let mut tracer = Tracer::new(&film.program, window).expect("it links");
    let cores = 0..film.arch().system.cores;
    let cores = cores.map(|_| tracer.core(film.interpreter())).collect();
    film.run(cores, Some(&mut tracer));
    let trace = tracer.trace().expect("the window was reached");
    assert_eq!(trace.cores.len(), 1);
    history(&trace, &stored.launches, pixel)
}

/// Operations on the array are in the cycles of the launch that is named.
fn launches(film: &Film, stored: &Stored, made: &[Made]) {
    let on_array = made.iter().find_map(|made| match operation(made)?.place {
        Place::Array { kernel, launch, .. } => Some((made.cycle, kernel, launch)),
        Place::Bundle(_) => None,
    });
    let (cycle, kernel, launch) = on_array.expect("kernels run on the array");
    let name = &film.spec.kernels[kernel as usize].name;
    let (trace, _) = film.traced(&format!("kernel:{name}#{launch}@{}", stored.core));
    assert!(trace.cycles.contains(&cycle), "{name}#{launch}");
}
