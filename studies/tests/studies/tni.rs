//! The T&I unit's hits against brute force in binary64.

use crate::support::{Random, check, image, machine, nearest, shared_scene, soup, triangle};
use glam::Vec3;
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Approx;
use srp_archdesc::dram::{DramSpec, FIXED};
use srp_archdesc::machines::SGRT;
use srp_archdesc::system::{Pipeline, SystemSpec};
use srp_runtime::bvh::{self, Builder, Layout, lay_out};
use srp_runtime::scene::Triangle;
use srp_runtime::scene::demo::demo;
use srp_runtime::tni::Tracer;
use srp_runtime::tni::arithmetic::{ANY_HIT, Ray};
use srp_runtime::tni::place_for;
use srp_studies::figure::estimate_of;
use srp_studies::rays::{Kind, Order, Sampling, Source};
use srp_studies::tni::sampled::{self, Found, Subject};
use srp_studies::tni::{Bench, Measure, Memories, Options, Outcome, UnitQuantity, drive};

fn rays(random: &mut Random, count: usize, lo: Vec3, hi: Vec3) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let origin = random.point(lo, hi).to_array();
            let direction = match i % 7 {
                // Along an axis: zeros in the direction.
                0 => [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, -0.0, 1.0]][i / 7 % 3],
                1 => (3.0 * random.direction()).to_array(),
                _ => random.direction().to_array(),
            };
            let flags = if i % 3 == 0 { ANY_HIT } else { 0 };
            let tmax = if i % 5 == 0 {
                0.5 * random.unit()
            } else {
                1e30
            };
            Ray::new(origin, direction, 0.0, tmax, flags)
        })
        .collect()
}

fn assert_true(rays: &[Ray], answer: &Outcome, triangles: &[Triangle]) {
    assert_eq!(rays.len(), answer.hits.len());
    let wrong: Vec<String> = rays
        .iter()
        .zip(&answer.hits)
        .filter_map(|(ray, hit)| check(ray, hit, nearest(ray, triangles.iter())).err())
        .collect();
    assert!(wrong.is_empty(), "{} wrong: {}", wrong.len(), wrong[0]);
}

#[test]
fn random_rays_hit_what_brute_force_hits() {
    let spec = machine();
    let mut random = Random::new(1);
    let triangles = soup(&mut random, 1500);
    let rays = rays(&mut random, 4000, Vec3::splat(-0.5), Vec3::splat(1.5));
    for builder in Builder::ALL {
        let answer = drive(&spec, &image(&triangles, builder), &rays);
        assert_true(&rays, &answer, &triangles);
        assert_eq!(answer.counters.unit.rays, rays.len() as u64);
        assert_eq!(answer.runs.len(), rays.len().div_ceil(64));
        assert_eq!(answer.counters.stacks.restarts, 0);
    }
}

/// Machines that differ in everything that may not change a hit.
fn variants() -> Vec<(&'static str, SystemSpec)> {
    let with = |change: &dyn Fn(&mut SystemSpec)| {
        let mut spec = machine();
        change(&mut spec);
        spec
    };
    vec![
        ("single", with(&|s| s.tni.pipeline = Pipeline::Single)),
        ("one entry of stack", with(&|s| s.tni.stack_depth = 1)),
        ("three entries", with(&|s| s.tni.stack_depth = 3)),
        (
            "everything full",
            with(&|s| {
                s.tni.fifo = 1;
                s.tni.rau_rows = 1;
                s.tni.trv_l1.misses = 1;
                s.tni.trv_l2.misses = 1;
                s.tni.ist_l1.misses = 1;
            }),
        ),
        (
            "single and full",
            with(&|s| {
                s.tni.pipeline = Pipeline::Single;
                s.tni.fifo = 2;
                s.tni.rau_rows = 2;
                s.tni.stack_depth = 2;
            }),
        ),
        ("no accumulation units", with(&|s| s.tni.rau_rows = 0)),
        (
            "no accumulation units, single and full",
            with(&|s| {
                s.tni.pipeline = Pipeline::Single;
                (s.tni.rau_rows, s.tni.fifo) = (0, 1);
                s.tni.trv_l1.misses = 1;
                s.tni.ist_l1.misses = 1;
            }),
        ),
        (
            "more stacks than room",
            with(&|s| {
                s.tni.fifo = 1;
                s.tni.stacks = 256;
            }),
        ),
        (
            "more stacks than room, single",
            with(&|s| {
                s.tni.pipeline = Pipeline::Single;
                s.tni.fifo = 2;
                s.tni.stacks = 200;
                s.tni.rau_rays = 200;
            }),
        ),
        (
            "shallow, and one intersection unit for many",
            with(&|s| {
                s.tni.fifo = 1;
                (s.tni.trvs, s.tni.stacks) = (8, 64);
                (s.tni.pre_latency, s.tni.aabb_latency) = (1, 2);
                (s.tni.post_latency, s.tni.ist_latency) = (1, 1);
            }),
        ),
        (
            "a reciprocal every seventh cycle",
            with(&|s| s.tni.rcp_interval = 7),
        ),
        (
            "many units",
            with(&|s| {
                s.tni.trvs = 7;
                s.tni.ists = 3;
                s.tni.stacks = 5;
            }),
        ),
        (
            "several of each",
            with(&|s| {
                s.tni.pres = 2;
                s.tni.aabbs = 3;
                s.tni.posts = 2;
                s.tni.rau_rays = 1;
                s.tni.any_hit = false;
            }),
        ),
        (
            "latencies of 65 nm",
            with(&|s| srp_archdesc::datapath::Latencies::Synthesis65nm.apply(&mut s.tni)),
        ),
        (
            "small caches",
            with(&|s| {
                s.tni.trv_l1.bytes = 256;
                s.tni.trv_l2.bytes = 1024;
                s.tni.ist_l1.bytes = 512;
            }),
        ),
        (
            "fast memory, odd clocks",
            with(&|s| {
                s.tni_mhz = 333;
                s.dram = DramSpec {
                    latency_ns: 1,
                    ..FIXED
                };
                s.bus.latency = 0;
            }),
        ),
    ]
}

#[test]
fn no_part_of_the_machine_changes_a_hit() {
    let mut random = Random::new(2);
    let triangles = soup(&mut random, 800);
    let tree = image(&triangles, Builder::Sweep);
    let rays: Vec<Ray> = rays(&mut random, 1500, Vec3::splat(-0.5), Vec3::splat(1.5))
        .into_iter()
        // Of a shadow ray, which hit is found first depends on the order of traversal.
        .map(|ray| Ray { flags: 0, ..ray })
        .collect();
    let expected = drive(&machine(), &tree, &rays);
    assert_true(&rays, &expected, &triangles);
    for (name, spec) in variants() {
        let answer = drive(&spec, &tree, &rays);
        assert!(answer.hits == expected.hits, "{name}");
        let stacks = answer.counters.stacks;
        let short = spec.tni.stack_depth < 4;
        assert_eq!(stacks.overflows > 0, short, "{name}");
        assert_eq!(stacks.restarts > 0, short, "{name}");
        let again = drive(&spec, &tree, &rays);
        assert_eq!(again.counters, answer.counters, "{name}");
        assert_eq!(again.cycles, answer.cycles, "{name}");
    }
}

#[test]
fn passes_and_visits_add_up() {
    let mut random = Random::new(3);
    let triangles = soup(&mut random, 500);
    let tree = image(&triangles, Builder::Sweep);
    let rays = rays(&mut random, 1000, Vec3::splat(-0.5), Vec3::splat(1.5));
    let parallel = drive(&machine(), &tree, &rays).counters;
    assert_eq!(parallel.pre.passes, parallel.node_visits());
    assert_eq!(parallel.aabb.passes, parallel.trv.inner_visits);
    // The rest enters one child only, and leaves the stack alone.
    let direct = parallel.node_visits() - parallel.post.passes;
    assert!(direct > parallel.node_visits() / 4);
    assert_eq!(
        parallel.pre.bypasses + parallel.aabb.bypasses + parallel.post.bypasses,
        0
    );
    assert_eq!(parallel.ist.passes, parallel.triangle_tests);
    assert_eq!(parallel.box_tests, 2 * parallel.trv.inner_visits);

    let mut spec = machine();
    spec.tni.pipeline = Pipeline::Single;
    let single = drive(&spec, &tree, &rays).counters;
    // A leaf passes through the rest of the pipeline, and again from its start on the way back.
    assert_eq!(single.post.bypasses, single.trv.leaf_visits + direct);
    assert_eq!(single.aabb.bypasses, 2 * single.trv.leaf_visits);
    assert_eq!(single.pre.bypasses, single.trv.leaf_visits);
    assert_eq!(single.stacks, parallel.stacks);
}

/// Without accumulation units a ray that misses stands, so that none joins it and none overtakes it.
#[test]
fn rays_that_stand_hold_up_those_behind_them() {
    let mut random = Random::new(4);
    let triangles = soup(&mut random, 800);
    let tree = image(&triangles, Builder::Sweep);
    let rays = rays(&mut random, 1500, Vec3::splat(-0.5), Vec3::splat(1.5));
    let with = |rows: u32| {
        let mut spec = machine();
        spec.tni.rau_rows = rows;
        drive(&spec, &tree, &rays)
    };
    let (none, one, all) = (with(0), with(1), with(16));
    assert!(none.cycles > one.cycles && one.cycles > all.cycles);
    let joined = |o: &Outcome| o.counters.trv_rau.joined + o.counters.ist_rau.joined;
    assert_eq!(joined(&none), 0);
    assert!(joined(&all) > 0);
}

/// A row waits for a line, and no more lines are asked for than there may be misses: more rows change nothing.
#[test]
fn rows_beyond_the_misses_stay_empty() {
    let mut random = Random::new(7);
    let triangles = soup(&mut random, 800);
    let tree = image(&triangles, Builder::Sweep);
    let rays = rays(&mut random, 1000, Vec3::splat(-0.5), Vec3::splat(1.5));
    for (name, mut spec) in variants() {
        let misses = spec.tni.trv_l1.misses.max(spec.tni.ist_l1.misses);
        let [fewer, enough, more] = [misses / 2, misses, 2 * misses + 3].map(|rows| {
            spec.tni.rau_rows = rows;
            drive(&spec, &tree, &rays).counters
        });
        assert_eq!(enough, more, "{name}");
        assert_ne!(fewer, enough, "{name}");
    }
}

#[test]
fn every_cycle_of_every_part_is_accounted_for() {
    let mut random = Random::new(9);
    let triangles = soup(&mut random, 500);
    let tree = image(&triangles, Builder::Sweep);
    let rays = rays(&mut random, 1000, Vec3::splat(-0.5), Vec3::splat(1.5));
    for (name, spec) in variants() {
        let c = drive(&spec, &tree, &rays).counters;
        let active = c.unit.active_cycles;
        assert_eq!(c.unit.dispatch.total(), active, "{name}");
        assert_eq!(c.unit.dispatch.work, rays.len() as u64, "{name}");
        let trvs = u64::from(spec.tni.trvs) * active;
        for (pipe, count) in [
            (&c.pre, trvs * u64::from(spec.tni.pres)),
            (&c.aabb, trvs * u64::from(spec.tni.aabbs)),
            (&c.post, trvs * u64::from(spec.tni.posts)),
            (&c.ist, active * u64::from(spec.tni.ists)),
        ] {
            let account = &pipe.account;
            assert_eq!(account.total(), count, "{name}: {account:?}");
            assert_eq!(account.work, pipe.passes, "{name}");
            assert_eq!(account.bypass, pipe.bypasses, "{name}");
            assert!(pipe.busy_cycles <= count, "{name}");
        }
    }
}

#[test]
fn deep_trees_and_degenerate_ones() {
    let flat = |x: f32, size: f32| {
        let at = |y: f32, z: f32| Vec3::new(x, y, z);
        triangle([at(-size, -size), at(size, -size), at(0.0, size)])
    };
    let scenes: Vec<(&str, Vec<Triangle>)> = vec![
        ("none", vec![]),
        ("one", vec![flat(0.5, 1.0)]),
        ("two", vec![flat(0.5, 1.0), flat(0.25, 0.5)]),
        (
            "no area",
            vec![triangle([Vec3::ZERO, Vec3::ONE, 2.0 * Vec3::ONE]); 20],
        ),
        ("identical", vec![flat(0.5, 1.0); 1000]),
        // Centres at 2^-i: one triangle is split off a level, 70 levels deep.
        ("deep", (0..120).map(|i| flat(2f32.powi(-i), 1.0)).collect()),
    ];
    let mut random = Random::new(4);
    let mut rays = rays(&mut random, 600, Vec3::splat(-1.0), Vec3::splat(1.0));
    rays.push(Ray::new([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0, 10.0, 0));
    for (name, triangles) in &scenes {
        for builder in Builder::ALL {
            for depth in [1, 4, 64] {
                let mut spec = machine();
                spec.tni.stack_depth = depth;
                let answer = drive(&spec, &image(triangles, builder), &rays);
                for (ray, hit) in rays.iter().zip(&answer.hits) {
                    let truth = nearest(ray, triangles.iter());
                    if let Err(wrong) = check(ray, hit, truth) {
                        panic!("{name}, {}: {wrong}", builder.name());
                    }
                }
                if *name == "identical" {
                    // Of equally near triangles the first counts, whatever the order.
                    let last = answer.hits.last().expect("rays were traced");
                    assert_eq!(last.hit.primitive, 0);
                }
            }
        }
    }
}

#[test]
fn void_rays_hit_nothing_and_do_not_stop_the_others() {
    let triangles = vec![triangle([
        Vec3::new(-9.0, -9.0, 1.0),
        Vec3::new(9.0, -9.0, 1.0),
        Vec3::new(0.0, 9.0, 1.0),
    ])];
    let good = Ray::new([0.0; 3], [0.0, 0.0, 1.0], 0.0, 10.0, 0);
    let mut rays = vec![good; 10];
    rays[1].origin[0] = f32::NAN;
    rays[3].direction = [0.0; 3];
    rays[4].tmax = -1.0;
    rays[6].far[2] = f32::NAN;
    rays[8].flags = ANY_HIT;
    let answer = drive(&machine(), &image(&triangles, Builder::Sweep), &rays);
    let hits: Vec<bool> = answer.hits.iter().map(|r| r.hit.is_hit()).collect();
    let expected = [
        true, false, true, false, false, true, false, true, true, true,
    ];
    assert_eq!(hits, expected);
    assert_eq!(answer.counters.unit.void_rays, 4);
    let runs = answer.runs[0];
    assert_eq!(
        [
            runs.shadow_hits,
            runs.shadow_misses,
            runs.other_hits,
            runs.other_misses
        ],
        [1, 0, 5, 4]
    );
}

#[test]
fn an_approximate_reciprocal_changes_distances_but_loses_nothing() {
    let mut random = Random::new(6);
    let triangles = soup(&mut random, 300);
    let tree = image(&triangles, Builder::Sweep);
    let rays: Vec<Ray> = rays(&mut random, 1000, Vec3::splat(-0.5), Vec3::splat(1.5))
        .into_iter()
        .map(|ray| Ray {
            flags: 0,
            tmax: 1e30,
            ..ray
        })
        .collect();
    let mut spec = machine();
    spec.tni.rcp = Approx::table(12, 0);
    let answer = drive(&spec, &tree, &rays);
    for (ray, record) in rays.iter().zip(&answer.hits) {
        let truth = nearest(ray, triangles.iter());
        let found = triangles.get(record.hit.primitive as usize);
        let Some((t, inside)) = found.and_then(|triangle| crate::support::truth(ray, triangle))
        else {
            assert_eq!(truth, None, "{ray:?}");
            continue;
        };
        // Triangles reach as much farther as the reciprocal is coarse, so that none is lost.
        assert!(inside > -0.05, "{ray:?}");
        assert!((f64::from(record.hit.t) / t - 1.0).abs() < 1e-3, "{ray:?}");
        assert!(truth.is_none_or(|truth| t <= truth * 1.001), "{ray:?}");
    }
}

/// Rays that are kept have the hits and, in sum, the costs of their pixels.
#[test]
fn kept_rays_have_their_hits_and_costs() {
    let mut random = Random::new(8);
    let triangles = soup(&mut random, 300);
    let tree = image(&triangles, Builder::Sweep);
    let mut rays = rays(&mut random, 1000, Vec3::splat(-0.5), Vec3::splat(1.5));
    for (pixel, ray) in (0..).zip(&mut rays) {
        ray.payload = pixel % 100;
    }
    let spec = machine();
    let (memory, root) = place_for(&spec, &tree);
    let options = Options {
        units: 3,
        memories: Memories::Shared,
        threads: 2,
        hits: true,
        costs: true,
    };
    let mut bench = Bench::new(&spec, &memory, root, options);
    bench.feed(rays.clone(), &Sampling::new(1, 1000), &Unwatched);
    let answer = bench.finish(&Unwatched).expect("nobody cancels it");
    assert_eq!(answer.rays.len(), rays.len());
    let mut sums = vec![(0, 0, 0); 100];
    for ((traced, ray), record) in answer.rays.iter().zip(&rays).zip(&answer.hits) {
        assert_eq!((traced.ray, traced.hit), (*ray, record.hit));
        let sum = &mut sums[ray.payload as usize];
        sum.0 += traced.cycles;
        sum.1 += u64::from(traced.visits);
        sum.2 += u64::from(traced.tests);
    }
    let pixels = answer.costs.iter().map(|c| (c.cycles, c.visits, c.tests));
    assert!(pixels.eq(sums));
}

/// A triangle test takes as many cycles of its unit as the reciprocal is taken.
#[test]
fn the_interval_of_the_reciprocal_bounds_the_tests() {
    let mut random = Random::new(7);
    let triangles = soup(&mut random, 300);
    let tree = image(&triangles, Builder::Sweep);
    let rays = rays(&mut random, 1000, Vec3::splat(-0.5), Vec3::splat(1.5));
    let cycles = [1, 8, 16].map(|interval| {
        let mut spec = machine();
        spec.tni.rcp_interval = interval;
        let answer = drive(&spec, &tree, &rays);
        let unit = &answer.counters;
        assert!(unit.unit.active_cycles >= unit.triangle_tests * u64::from(interval));
        unit.unit.active_cycles
    });
    assert!(cycles[0] < cycles[1] && cycles[1] < cycles[2], "{cycles:?}");
}

#[test]
fn sibenik_hits_equal_brute_force() {
    let Some(scene) = shared_scene("sibenik/sibenik.obj") else {
        return;
    };
    let mut random = Random::new(7);
    let (lo, hi) = srp_runtime::scene::bounds(&scene.triangles).expect("a scene has triangles");
    let rays: Vec<Ray> = (0..100_000)
        .map(|i| {
            let origin = random.point(lo, hi).to_array();
            let flags = if i % 4 == 0 { ANY_HIT } else { 0 };
            Ray::new(origin, random.direction().to_array(), 0.0, 1e30, flags)
        })
        .collect();
    let answer = drive(&machine(), &image(&scene.triangles, Builder::Sweep), &rays);
    let truth = crate::support::NearestTree::new(&scene.triangles);
    for ray in &rays[..200] {
        assert_eq!(truth.nearest(ray), nearest(ray, scene.triangles.iter()));
    }
    let mut wrong = Vec::new();
    for (ray, record) in rays.iter().zip(&answer.hits) {
        if let Err(message) = check(ray, record, truth.nearest(ray)) {
            wrong.push(message);
        }
    }
    assert!(wrong.is_empty(), "{} wrong: {}", wrong.len(), wrong[0]);
    println!("{} cycles, {:#?}", answer.cycles, answer.counters);
}

/// Samples of rays: near what all rays take, the same for any number of threads, and refused where they would be most
/// of the rays.
#[test]
fn samples_are_near_what_all_rays_take() {
    let arch = srp_archdesc::parse(SGRT.name, SGRT.xml).expect("the shipped machine is valid");
    let spec = &arch.system;
    let scene = demo();
    let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
    let (memory, tree) = place_for(
        spec,
        &lay_out(&bvh, &scene.triangles, Layout::of(&spec.tni)),
    );
    let kind = Kind::AmbientOcclusion {
        samples: 4,
        radius: 2.0,
    };
    let source = |size| {
        let tracer = Tracer::new(&spec.tni, &tree, &memory);
        let view = (&scene.camera, size);
        Source::new(view, kind, &scene.triangles, tracer, Order::Morton)
    };
    let near = |memories: Memories| {
        let options = |threads| Options {
            units: 4,
            memories,
            threads,
            hits: false,
            costs: false,
        };
        let views = [source((480, 360)), source((320, 240))];
        let sample = |views: &[Source], threads, seed, error| {
            let subject = Subject {
                spec,
                memory: &memory,
                tree,
                views,
                options: options(threads),
                watch: &Unwatched,
            };
            sampled::sample(&subject, seed, error).expect("nobody cancels it")
        };
        let Found::Sample(one) = sample(&views, 1, 3, 0.1) else {
            panic!("a sample is enough");
        };
        assert_eq!(sample(&views, 3, 3, 0.1), Found::Sample(one.clone()));
        assert_ne!(sample(&views, 1, 4, 0.1), Found::Sample(one.clone()));
        assert!(one.run < one.blocks / 2);
        assert_eq!(sample(&[source((64, 48))], 1, 3, 0.1), Found::TooMuch);

        let outcomes = views.each_ref().map(|view| {
            let mut bench = Bench::new(spec, &memory, tree, options(2));
            let all = Sampling::new(1, 1);
            for batch in 0..view.batches() {
                bench.feed(view.batch(batch), &all, &Unwatched);
            }
            bench.finish(&Unwatched).expect("nobody cancels it")
        });
        let truth = Measure::of(&outcomes, 4, spec);
        let figure = |quantity| {
            let estimate = estimate_of(&one.figures, &quantity);
            estimate.unwrap_or_else(|| panic!("no {quantity}"))
        };
        for (name, value) in [
            (UnitQuantity::InnerNodesPerRay, truth.inner_visits),
            (UnitQuantity::LeavesPerRay, truth.leaf_visits),
            (UnitQuantity::TestsPerRay, truth.triangle_tests),
        ] {
            let estimate = figure(name);
            assert!(estimate.covers(value), "{name}: {estimate:?}, {value}");
            // Nothing is left to drawing of what all rays were looked at for.
            let is_known = estimate.half_width == 0.0;
            assert_eq!(is_known, one.looked == one.blocks, "{name}");
        }
        let rate = figure(UnitQuantity::Rate);
        assert!(
            rate.covers(truth.mrays_per_second),
            "{rate:?}, {}",
            truth.mrays_per_second
        );
        assert!(rate.relative() < 0.15, "{rate:?}");
        let hits = figure(UnitQuantity::TrvL1Hits);
        assert!(
            hits.covers(100.0 * truth.trv_l1) && hits.half_width < 4.0,
            "{hits:?}, {}",
            truth.trv_l1
        );
    };
    std::thread::scope(|scope| {
        scope.spawn(|| near(Memories::Private));
        near(Memories::Shared);
    });
}
