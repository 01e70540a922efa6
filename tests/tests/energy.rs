//! Where the energy of a frame goes: what a machine changes shows in its part, and in no other.

use srp_archdesc::Arch;
use srp_archdesc::arch::Approx;
use srp_archdesc::system::CacheSpec;
use srp_ir::check::Checked;
use srp_runtime::effect::{self, Guard};
use srp_runtime::memory::cache::CacheCounters;
use srp_runtime::scene::demo::demo;
use srp_runtime::system::{self, Report};
use srp_studies::energy::{Energy, Part, energy};
use srp_tests::LITTLE;
use srp_tests::studio::Studio;
use srp_toolchain::{Engine, Engines, schedule, system_options};

/// A small frame of the default scene, and the program that made it.
fn frame(studio: &Studio) -> (Checked, Report) {
    let effects = effect::find(&studio.scene).into_iter().collect();
    let session = srp_tests::session();
    let program = studio.program(effects);
    let compiled = schedule(program, &studio.arch, LITTLE, &session).expect("it compiles");
    let program = compiled.schedule.program;
    let engines = Engines::of(&program, Engine::Interpreter, &session).expect("it links");
    let timing = system::Timing::Full;
    let options = system_options(&program, &studio.arch, Guard::default(), timing, &session);
    let cores = engines.cores(studio.arch.system.cores);
    let rendered = system::render(studio.image(), cores, &studio.arch, options);
    let (_, report) = rendered.expect("the frame is finished");
    (program, report)
}

#[test]
fn a_changed_part_shows_in_its_energy() {
    let studio = Studio::of(demo(), (16, 16));
    let (program, report) = frame(&studio);
    let of = |change: &dyn Fn(&mut Arch)| {
        let mut arch = studio.arch.clone();
        change(&mut arch);
        energy(&report, &program, &arch)
    };
    let base = of(&|_| {});
    assert!(base.parts.iter().all(|share| share.mj > 0.0), "{base:?}");
    let sum: f64 = base.parts.iter().map(|share| share.mj).sum();
    assert!((sum / base.total_mj - 1.0).abs() < 1e-12);
    assert!(base.chip_mj.iter().all(|(_, mj)| *mj < base.total_mj));
    let only = |part: Part, others: &[Part], less: &Energy, more: &Energy| {
        for share in &less.parts {
            let now = more.of_part(share.part);
            if share.part == part {
                assert!(now > share.mj, "{part:?}");
            } else if !others.contains(&share.part) {
                assert_eq!(now, share.mj, "{part:?} moves {:?}", share.part);
            }
        }
    };
    let vliw = [Part::Vliw];
    let table = of(&|arch| arch.precision.rsqrt = Approx::table(8, 0));
    only(Part::ArraySpecial, &vliw, &table, &base);
    let coarse = of(&|arch| arch.system.tni.rcp = Approx::table(8, 0));
    assert!(coarse.of_part(Part::TriangleTests) < base.of_part(Part::TriangleTests));
    let ports = of(&|arch| {
        let files = arch.srp.files.values_mut();
        files.for_each(|file| file.read_ports += 4);
    });
    only(
        Part::ArrayRegisters,
        &[Part::Vliw, Part::Configuration],
        &base,
        &ports,
    );
    let longer = of(&|arch| arch.srp.links.values_mut().for_each(|link| link.delay += 1));
    only(Part::ArrayLinks, &[], &base, &longer);
    let constants = of(&|arch| arch.srp.fus.values_mut().for_each(|fu| fu.constants += 1));
    only(Part::Configuration, &vliw, &base, &constants);
    let texture = of(&|arch| arch.system.texture_cache.bytes *= 2);
    only(Part::TextureCache, &[Part::Leakage], &base, &texture);
    // The bundles of a cache for instructions, where a frame has one.
    let cached = |bytes: u32| {
        let (mut arch, mut report) = (studio.arch.clone(), report.clone());
        arch.system.instruction_cache = Some(CacheSpec {
            bytes,
            ..arch.system.texture_cache
        });
        report.cores[0].instruction_cache = Some(CacheCounters {
            hits: 1000,
            misses: 10,
            ..CacheCounters::default()
        });
        energy(&report, &program, &arch)
    };
    let (small, large) = (cached(4096), cached(8192));
    assert!(small.of_part(Part::InstructionCache) > 0.0);
    only(Part::InstructionCache, &[Part::Leakage], &small, &large);
    let level1 = of(&|arch| arch.system.tni.trv_l1.bytes *= 2);
    only(Part::TniCaches, &[Part::Leakage], &base, &level1);
}
