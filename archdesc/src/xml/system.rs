//! The units round the array. What the file leaves out is the paper's.

use super::cache::Cache;
use super::de::Spanned;
use super::dram;
use super::findings::Findings;
use super::limits::{self, Limit};
use super::raw::{self, Text};
use super::special;
use super::values;
use crate::arch::Arch;
use crate::cost::FO4_PS;
use crate::cost::special::{self as cost, Build};
use crate::datapath::{FpLatency, Intersection, Latencies, RCP_LATENCY, rcp_depth};
use crate::isa::Class;
use crate::precision::Approx;
use crate::structure::Special;
use crate::system::{
    BankSpec, BufferSpec, BusSpec, CacheSpec, GivenLatencies, HIT_BYTES, NodeFormat, Pipeline,
    RAY_BYTES, SystemSpec, TniSpec,
};

/// The system of the SGRT paper: its section 4.1, and where it is silent the assumptions that
/// `FORMAT.md` lists.
fn default() -> SystemSpec {
    SystemSpec {
        cores: 4,
        tile_block: 4,
        srp_mhz: 1000,
        tni_mhz: 500,
        fo4_ps: FO4_PS as u32,
        sram_bytes: 240 << 10,
        sram_banks: None,
        data_cache: CacheSpec {
            line: 128,
            ..blocking(cache(4, 4, 1, 1, 4))
        },
        texture_cache: blocking(cache(32, 4, 1, 1, 8)),
        instruction_cache: None,
        buffers: BufferSpec {
            rays: 64,
            ray_buffers: 3,
            hit_buffers: 2,
            ray_bytes: RAY_BYTES,
            hit_bytes: HIT_BYTES,
        },
        tni: TniSpec {
            trvs: 4,
            ists: 1,
            pipeline: Pipeline::Parallel,
            pres: 1,
            aabbs: 1,
            posts: 1,
            stacks: 16,
            stack_depth: 64,
            given: GivenLatencies::default(),
            // These four follow.
            pre_latency: 1,
            aabb_latency: 1,
            post_latency: 1,
            ist_latency: 1,
            fifo: 16,
            rau_rows: 8,
            rau_rays: RAU_RAYS,
            trv_l1: cache(16, 2, 1, 1, 8),
            trv_l2: cache(128, 2, 20, 8, 16),
            ist_l1: cache(128, 4, 1, 1, 8),
            node_format: NodeFormat::F32,
            node_bytes: NodeFormat::F32.bytes(),
            triangle_bytes: 48,
            rcp: Approx::Exact,
            rcp_build: Build::default(),
            rcp_latency: RCP_LATENCY,
            rcp_interval: 1,
            intersection: Intersection::AnchorWaldScaled,
            any_hit: true,
        },
        bus: BusSpec {
            width: 16,
            mhz: 1000,
            latency: 4,
        },
        dram: dram::default(),
    }
}

/// Rays of a row of an accumulation unit, where the file does not say.
pub(super) const RAU_RAYS: u32 = 16;

const fn cache(kib: u32, ways: u32, latency: u32, banks: u32, misses: u32) -> CacheSpec {
    CacheSpec {
        bytes: kib << 10,
        ways,
        line: 64,
        latency,
        banks,
        misses,
        blocking: false,
    }
}

/// Attributes that an `<instruction-cache>` leaves out.
const INSTRUCTION_CACHE: CacheSpec = cache(8, 2, 1, 1, 1);

const fn blocking(cache: CacheSpec) -> CacheSpec {
    CacheSpec {
        blocking: true,
        ..cache
    }
}

/// The system that the file describes.
pub(super) fn system(found: &Findings, raw: &Option<Spanned<raw::System>>) -> SystemSpec {
    let Some(raw) = raw else {
        let mut system = default();
        let mhz = system.tni_mhz_at_65nm();
        system.tni.derive_latencies(mhz);
        return system;
    };
    let default = default();
    let number = |text, limit, default| values::number(found, text, limit, default);
    let no_sram = raw::Sram::default();
    let sram = raw.sram.as_ref().map_or(&no_sram, |sram| &sram.value);
    let sram_bytes = multiple(found, &sram.size, limits::SRAM_SIZE, 16, default.sram_bytes);
    let sram_banks = sram_banks(found, sram);
    let mut system = SystemSpec {
        cores: number(&raw.cores, limits::CORES, default.cores),
        tile_block: number(&raw.tile_block, limits::TILE_BLOCK, default.tile_block),
        srp_mhz: number(&raw.srp_mhz, limits::SRP_MHZ, default.srp_mhz),
        tni_mhz: number(&raw.tni_mhz, limits::TNI_MHZ, default.tni_mhz),
        fo4_ps: number(&raw.fo4_ps, limits::FO4_PS, default.fo4_ps),
        sram_bytes,
        sram_banks,
        data_cache: Cache::Data.spec(found, &raw.data_cache, default.data_cache),
        texture_cache: Cache::Texture.spec(found, &raw.texture_cache, default.texture_cache),
        instruction_cache: (raw.instruction_cache.as_ref())
            .map(|_| Cache::Instructions.spec(found, &raw.instruction_cache, INSTRUCTION_CACHE)),
        buffers: buffers(found, &raw.buffers, default.buffers),
        tni: default.tni,
        bus: bus(found, &raw.bus, default.bus),
        dram: dram::dram(found, &raw.dram),
    };
    system.tni = tni(found, &raw.tni, system.tni_mhz_at_65nm(), default.tni);
    buffers_fit(found, raw, &system);
    system
}

/// A number of bytes that must be a multiple of `of`.
fn multiple(found: &Findings, text: &Option<Text>, limit: Limit, of: u32, default: u32) -> u32 {
    let n = values::number(found, text, limit, default);
    match text {
        Some(text) if !n.is_multiple_of(of) => {
            let message = format!("`{}` is not a multiple of {of} bytes", limit.name);
            let label = format!("leaves a remainder of {}", n % of);
            found.push(found.error("A0601", text.span, message, label));
            default
        }
        _ => n,
    }
}

/// The banks of the SRAM, where it is said that accesses compete for them.
fn sram_banks(found: &Findings, sram: &raw::Sram) -> Option<BankSpec> {
    let count = match values::number(found, &sram.banks, limits::SRAM_BANKS, 0) {
        0 => 0,
        _ => values::power(found, &sram.banks, limits::SRAM_BANKS, 1),
    };
    let banks = BankSpec {
        count,
        width: values::power(found, &sram.width, limits::BANK_WIDTH, 16),
        shared: values::flag(found, &sram.shared, "shared", false),
    };
    (count > 0).then_some(banks)
}

fn buffers(
    found: &Findings,
    raw: &Option<Spanned<raw::Buffers>>,
    default: BufferSpec,
) -> BufferSpec {
    let Some(raw) = raw else {
        return default;
    };
    let number = |text, limit, default| values::number(found, text, limit, default);
    BufferSpec {
        rays: number(&raw.rays, limits::RAYS, default.rays),
        ray_buffers: number(&raw.ray_buffers, limits::RAY_BUFFERS, default.ray_buffers),
        hit_buffers: number(&raw.hit_buffers, limits::HIT_BUFFERS, default.hit_buffers),
        ray_bytes: agreed(found, &raw.ray_bytes, limits::RAY_BYTES, RAY_BYTES),
        hit_bytes: agreed(found, &raw.hit_bytes, limits::HIT_BYTES, HIT_BYTES),
    }
}

/// A size that kernels and T&I unit agree on.
fn agreed(found: &Findings, text: &Option<Text>, limit: Limit, size: u32) -> u32 {
    let bytes = values::number(found, text, limit, size);
    if let Some(text) = text.as_ref().filter(|_| bytes != size) {
        let message = format!(
            "`{}` is {size}: kernels and T&I unit know no other size",
            limit.name
        );
        let error = found.error("A0611", text.span, message, "nothing runs on it");
        found.push(error.help("leave it out"));
    }
    size
}

/// Checks that schedules give the SRP's caches their time.
pub(super) fn hits_in_time(found: &Findings, raw: &Option<Spanned<raw::System>>, arch: &Arch) {
    let Some(Spanned { value: raw, .. }) = raw else {
        return;
    };
    let system = &arch.system;
    for (element, raw, cache, class) in [
        (
            "data-cache",
            &raw.data_cache,
            &system.data_cache,
            Class::Cload,
        ),
        (
            "texture-cache",
            &raw.texture_cache,
            &system.texture_cache,
            Class::Tex,
        ),
    ] {
        let text = raw.as_ref().and_then(|raw| raw.value.latency.as_ref());
        if let (Some(text), Some(least)) = (text, arch.srp.least_latency(class))
            && cache.latency > least
        {
            let message = format!(
                "a hit in `{element}` takes {} cycles, and class `{class}`, by which schedules are made, {least}",
                cache.latency
            );
            let help = format!(
                "have `<op class=\"{class}\" latency=\"{}\"/>`",
                cache.latency
            );
            found.push(
                found
                    .error("A0610", text.span, message, "too slow")
                    .help(help),
            );
        }
    }
}

/// Checks that ray and hit buffers, which lie in the SRAM, have room there.
fn buffers_fit(found: &Findings, raw: &Spanned<raw::System>, system: &SystemSpec) {
    let b = &system.buffers;
    let packet = u64::from(b.ray_buffers) * u64::from(b.ray_bytes)
        + u64::from(b.hit_buffers) * u64::from(b.hit_bytes);
    let bytes = u64::from(b.rays) * packet;
    if bytes > u64::from(system.sram_bytes) {
        let buffers = raw.buffers.as_ref().map(|b| b.span);
        let sram = raw.sram.as_ref().map(|s| s.span);
        let message = format!(
            "ray and hit buffers of {bytes} bytes do not fit in the SRAM of {}",
            system.sram_bytes
        );
        let span = buffers.or(sram).unwrap_or(raw.span);
        found.push(
            found
                .error("A0604", span, message, "too large together")
                .help("have fewer or smaller buffers, or a larger `<sram size=\"…\"/>`"),
        );
    }
}

fn tni(found: &Findings, raw: &Option<Spanned<raw::Tni>>, mhz: u32, default: TniSpec) -> TniSpec {
    const PIPELINES: [(&str, Pipeline); 2] = [
        ("single", Pipeline::Single),
        ("parallel", Pipeline::Parallel),
    ];
    let Some(raw) = raw else {
        let mut tni = default;
        tni.rcp_latency = rcp_depth(mhz);
        tni.derive_latencies(mhz);
        return tni;
    };
    let number = |text, limit, default| values::number(found, text, limit, default);
    let words = |text, limit, default| multiple(found, text, limit, 4, default);
    let intersections = Intersection::ALL.map(|i| (i.name(), i));
    let intersection = values::word(found, &raw.intersection, "intersection", &intersections)
        .unwrap_or(default.intersection);
    let formats = NodeFormat::ALL.map(|f| (f.name(), f));
    let node_format = values::word(found, &raw.node_format, "node-format", &formats)
        .unwrap_or(default.node_format);
    let (rcp, rcp_build) = special::tni_rcp(found, &raw.special, mhz);
    let unit = cost::unit(Special::Rcp, rcp, &rcp_build, mhz);
    let rcp_latency = unit.latency.unwrap_or_else(|| rcp_depth(mhz));
    let rcp_interval = unit.interval.unwrap_or(default.rcp_interval);
    let mut default = TniSpec {
        intersection,
        rcp,
        rcp_build,
        rcp_latency,
        rcp_interval,
        ..default
    };
    let presets = Latencies::ALL.map(|l| (l.name(), l));
    if let Some(preset) = values::word(found, &raw.latencies, "latencies", &presets) {
        preset.apply(&mut default);
    }
    let pipeline = values::word(found, &raw.pipeline, "pipeline", &PIPELINES);
    let operators = fp_latency(found, &raw.fp);
    let tests = default.given.aabb && operators.is_none();
    default.given = GivenLatencies {
        pre: default.given.pre || raw.pre_latency.is_some(),
        aabb: tests || raw.aabb_latency.is_some(),
        post: default.given.post || raw.post_latency.is_some(),
        ist: tests || raw.ist_latency.is_some(),
        operators,
    };
    let mut tni = TniSpec {
        given: default.given,
        trvs: number(&raw.trvs, limits::TRVS, default.trvs),
        ists: number(&raw.ists, limits::ISTS, default.ists),
        pipeline: pipeline.unwrap_or(default.pipeline),
        pres: number(&raw.pres, limits::PRES, default.pres),
        aabbs: number(&raw.aabbs, limits::AABBS, default.aabbs),
        posts: number(&raw.posts, limits::POSTS, default.posts),
        stacks: number(&raw.stacks, limits::STACKS, default.stacks),
        stack_depth: number(&raw.stack_depth, limits::STACK_DEPTH, default.stack_depth),
        pre_latency: number(&raw.pre_latency, limits::PRE_LATENCY, default.pre_latency),
        aabb_latency: number(
            &raw.aabb_latency,
            limits::AABB_LATENCY,
            default.aabb_latency,
        ),
        post_latency: number(
            &raw.post_latency,
            limits::POST_LATENCY,
            default.post_latency,
        ),
        ist_latency: number(&raw.ist_latency, limits::IST_LATENCY, default.ist_latency),
        fifo: number(&raw.fifo, limits::FIFO, default.fifo),
        rau_rows: number(&raw.rau_rows, limits::RAU_ROWS, default.rau_rows),
        rau_rays: number(&raw.rau_rays, limits::RAU_RAYS, default.rau_rays),
        trv_l1: Cache::TrvL1.spec(found, &raw.trv_l1, default.trv_l1),
        trv_l2: Cache::TrvL2.spec(found, &raw.trv_l2, default.trv_l2),
        ist_l1: Cache::IstL1.spec(found, &raw.ist_l1, default.ist_l1),
        node_format,
        node_bytes: words(
            &raw.node_bytes,
            Limit {
                min: node_format.bytes(),
                ..limits::NODE_BYTES
            },
            node_format.bytes(),
        ),
        triangle_bytes: words(
            &raw.triangle_bytes,
            limits::TRIANGLE_BYTES,
            default.triangle_bytes,
        ),
        rcp,
        rcp_build,
        rcp_latency,
        rcp_interval,
        intersection,
        any_hit: values::flag(found, &raw.any_hit, "any-hit", default.any_hit),
    };
    tni.derive_latencies(mhz);
    for (text, count) in [
        (&raw.pres, tni.pres),
        (&raw.aabbs, tni.aabbs),
        (&raw.posts, tni.posts),
    ] {
        if let Some(text) = text
            && tni.pipeline == Pipeline::Single
            && count > 1
        {
            let message = "a single pipeline has one of each stage";
            found.push(
                found
                    .error("A0605", text.span, message, "more than one")
                    .help("write `pipeline=\"parallel\"`, or 1 here"),
            );
        }
    }
    tni
}

fn fp_latency(found: &Findings, raw: &Option<Spanned<raw::Fp>>) -> Option<FpLatency> {
    let raw = raw.as_ref()?;
    let operator = |text, limit| values::required_number(found, text, limit, "fp", raw.span);
    Some(FpLatency {
        add: operator(&raw.add, limits::FP_ADD),
        mul: operator(&raw.mul, limits::FP_MUL),
        cmp: operator(&raw.cmp, limits::FP_CMP),
        rcp: operator(&raw.rcp, limits::FP_RCP),
    })
}

fn bus(found: &Findings, raw: &Option<Spanned<raw::Bus>>, default: BusSpec) -> BusSpec {
    let Some(raw) = raw else {
        return default;
    };
    BusSpec {
        width: values::power(found, &raw.width, limits::BUS_WIDTH, default.width),
        mhz: values::number(found, &raw.mhz, limits::MHZ, default.mhz),
        latency: values::number(found, &raw.latency, limits::BUS_LATENCY, default.latency),
    }
}
