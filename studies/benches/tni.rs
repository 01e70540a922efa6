//! How fast T&I units are simulated: cycles and rays of four units per second of one host core, and
//! what a second thread brings.
//!
//! ```text
//! cargo bench -p srp-studies --bench tni -- [SCENE.obj [MACHINE.xml [KIND [VIEW]]]]
//! ```
//!
//! Without a scene: Sibenik beside the repository, else the default scene. KIND is `primary`, `ao`
//! or `diffuse`, a view `X,Y,Z/DX,DY,DZ/FOV`.

use srp_archdesc::Unwatched;
use std::path::PathBuf;
use std::time::Instant;

use srp_archdesc::system::{Pipeline, SystemSpec};
use srp_runtime::bvh::{self, Layout};
use srp_runtime::scene::{self, Camera, Scene};
use srp_runtime::tni::Tracer;
use srp_runtime::tni::place_for;
use srp_studies::rays::{Kind, Order, Sampling, Source};
use srp_studies::tni::{Bench, Measure, Memories, Options, Outcome};

/// Looking down the nave of Sibenik.
const NAVE: &str = "-19.163326,-10.602377,1.502962/0.956693,-0.044955,-0.287606/73.7398";

const SIZE: (u32, u32) = (1024, 768);

fn read_scene(path: &std::path::Path, camera: Camera) -> Scene {
    match scene::read(path, Some(camera), &mut |path, _| std::fs::read(path)) {
        Ok(loaded) => loaded.scene,
        Err(messages) => panic!("{messages}"),
    }
}

fn machine(path: Option<&String>) -> SystemSpec {
    let shipped = srp_archdesc::machines::SGRT;
    let (name, text) = match path {
        Some(path) => (
            path.as_str(),
            std::fs::read_to_string(path).expect("the machine file can be read"),
        ),
        None => (shipped.name, shipped.xml.to_owned()),
    };
    let arch = srp_archdesc::parse(name, &text).expect("the machine file is valid");
    arch.system
}

fn main() {
    // Cargo says `--bench`.
    let args: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| a != "--bench")
        .collect();
    let beside =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes/sibenik/sibenik.obj");
    let path = args.first().map(PathBuf::from).unwrap_or(beside);
    let view = args.get(3).map_or(NAVE, String::as_str);
    let camera = Camera::parse(view).expect("the view is well-formed");
    let scene = if path.exists() {
        read_scene(&path, camera)
    } else {
        scene::demo::demo()
    };
    let kind = match args.get(2).map(String::as_str) {
        Some("ao") => Kind::AmbientOcclusion {
            samples: 32,
            radius: 5.0,
        },
        Some("diffuse") => Kind::Diffuse { samples: 32 },
        _ => Kind::Primary,
    };
    let spec = machine(args.get(1));
    let one_in = if kind == Kind::Primary { 1 } else { 32 };
    println!(
        "{}, {} triangles, {kind:?}",
        scene.name,
        scene.triangles.len()
    );
    let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
    let mut same: Option<Outcome> = None;
    for (pipeline, threads) in [
        (Pipeline::Parallel, 1),
        (Pipeline::Parallel, 2),
        (Pipeline::Single, 1),
    ] {
        let mut spec = spec.clone();
        spec.tni.pipeline = pipeline;
        let image = bvh::lay_out(&bvh, &scene.triangles, Layout::of(&spec.tni));
        let (memory, tree) = place_for(&spec, &image);
        let tracer = Tracer::new(&spec.tni, &tree, &memory);
        let view = (&scene.camera, SIZE);
        let source = Source::new(view, kind, &scene.triangles, tracer, Order::Morton);
        let options = Options {
            units: 4,
            memories: Memories::Private,
            threads,
            hits: false,
            costs: false,
        };
        let mut bench = Bench::new(&spec, &memory, tree, options);
        let samples = if kind == Kind::Primary { 1 } else { 32 };
        let sampling = Sampling::new(one_in, 12_288 * samples);
        let mut seconds = 0.0;
        for batch in 0..source.batches() {
            let batch = source.batch(batch);
            let start = Instant::now();
            bench.feed(batch, &sampling, &Unwatched);
            seconds += start.elapsed().as_secs_f64();
        }
        let start = Instant::now();
        let outcome = bench.finish(&Unwatched).expect("nobody cancels it");
        seconds += start.elapsed().as_secs_f64();
        let m = Measure::of(std::slice::from_ref(&outcome), 4, &spec);
        println!(
            "{pipeline:?}, {threads} thread(s): {seconds:.2} s; of 4 units, a second: {:.2} M cycles \
             of the SRP's clock, {:.2} M of the T&I units', {:.0} rays",
            m.cycles as f64 / seconds / 1e6 * f64::from(spec.srp_mhz) / f64::from(spec.tni_mhz),
            m.cycles as f64 / seconds / 1e6,
            m.rays as f64 / seconds
        );
        println!(
            "  simulated: {:.2} Mrays/s ± {:.1} %; a ray: {:.2} + {:.2} visits of {:.1} cycles, \
             {:.2} tests, {:.0} cycles; L1 {:.1} %, L2 {:.1} %, IST L1 {:.1} %, AABB {:.0} % busy \
             issuing, {:.2} GB/s",
            m.mrays_per_second,
            100.0 * m.relative_error.unwrap_or(0.0),
            m.inner_visits,
            m.leaf_visits,
            m.cycles_per_visit,
            m.triangle_tests,
            m.residence,
            100.0 * m.trv_l1,
            100.0 * m.trv_l2,
            100.0 * m.ist_l1,
            100.0 * m.trv_issue,
            m.gigabytes_per_second
        );
        match (&same, pipeline) {
            (Some(first), Pipeline::Parallel) => {
                assert!(*first == outcome, "threads change no figure");
            }
            (None, _) => same = Some(outcome),
            _ => {}
        }
    }
}
