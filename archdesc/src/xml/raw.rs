//! The machine file as it is written: every attribute a text with its position, nothing resolved.
//!
//! `FORMAT.md` explains each of them; the names there are the ones here with hyphens.

use serde::Deserialize;

use super::de::Spanned;

/// An attribute's value.
pub(super) type Text = Spanned<String>;

/// An element of the raw form.
pub(super) trait Fields {
    /// The name of its type.
    const NAME: &'static str;
    /// The attributes and elements that it can have, with underscores for hyphens.
    const FIELDS: &[&str];

    /// What each of them is.
    fn members() -> Vec<Member>;
}

/// A part that an element can have.
pub(super) struct Member {
    field: &'static str,
    pub(super) part: Part,
}

impl Member {
    /// Its name in a machine file.
    pub(super) fn name(&self) -> String {
        self.field.trim_start_matches("r#").replace('_', "-")
    }
}

/// The kinds of parts of an element.
pub(super) enum Part {
    Attribute,
    Element {
        /// The name of its type.
        name: &'static str,
        /// True if there may be several of it.
        many: bool,
        members: fn() -> Vec<Member>,
    },
}

/// A field of a struct of the raw form.
trait Field {
    /// The part of an element that it stands for.
    fn part() -> Part;
}

impl Field for Option<Text> {
    fn part() -> Part {
        Part::Attribute
    }
}

impl<T: Fields> Field for Option<Spanned<T>> {
    fn part() -> Part {
        Part::Element {
            name: T::NAME,
            many: false,
            members: T::members,
        }
    }
}

impl<T: Fields> Field for Vec<Spanned<T>> {
    fn part() -> Part {
        Part::Element {
            name: T::NAME,
            many: true,
            members: T::members,
        }
    }
}

/// Declares the structs of the raw form: any attribute or element may be missing.
macro_rules! raw {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $ty:ty,)* })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, Default, Deserialize)]
        #[serde(default, rename_all = "kebab-case")]
        pub(super) struct $name { $(pub(super) $field: $ty,)* }

        impl Fields for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &[&str] = &[$(stringify!($field)),*];

            fn members() -> Vec<Member> {
                vec![$(Member { field: stringify!($field), part: <$ty as Field>::part() }),*]
            }
        }
    )*};
}

raw! {
    /// `<machine>`
    Machine {
        name: Option<Text>,
        op: Vec<Spanned<Op>>,
        resource: Vec<Spanned<Resource>>,
        fu_type: Vec<Spanned<FuType>>,
        array: Option<Spanned<Array>>,
        vliw: Option<Spanned<Vliw>>,
        special: Vec<Spanned<Special>>,
        float: Option<Spanned<Float>>,
        system: Option<Spanned<System>>,
    }

    /// `<float>`
    Float {
        subnormals: Option<Text>,
        add: Option<Text>,
        multiply: Option<Text>,
        fused: Option<Text>,
    }

    /// `<op>`, in a machine, a `<fu-type>` or an `<fu>`
    Op {
        class: Option<Text>,
        latency: Option<Text>,
        interval: Option<Text>,
        uses: Option<Text>,
    }

    /// `<resource>`
    Resource {
        name: Option<Text>,
        count: Option<Text>,
    }

    /// `<fu-type>`
    FuType {
        name: Option<Text>,
        width: Option<Text>,
        pred_out: Option<Text>,
        constants: Option<Text>,
        classes: Option<Text>,
        op: Vec<Spanned<Op>>,
        file: Vec<Spanned<LocalFile>>,
    }

    /// `<file>` in a `<fu-type>` or an `<fu>`
    LocalFile {
        name: Option<Text>,
        kind: Option<Text>,
        width: Option<Text>,
        size: Option<Text>,
        read_ports: Option<Text>,
        write_ports: Option<Text>,
        from_links: Option<Text>,
    }

    /// `<array>`
    Array {
        rows: Option<Text>,
        cols: Option<Text>,
        topology: Option<Text>,
        link_delay: Option<Text>,
        link_width: Option<Text>,
        wires: Option<Text>,
        wire_delay: Option<Text>,
        wire_width: Option<Text>,
        hops: Option<Text>,
        contexts: Option<Text>,
        shared_contexts: Option<Text>,
        row: Vec<Spanned<Row>>,
        fu: Vec<Spanned<Fu>>,
        file: Vec<Spanned<File>>,
        link: Vec<Spanned<Link>>,
        wire: Vec<Spanned<Wire>>,
    }

    /// `<row>`
    Row {
        units: Option<Text>,
    }

    /// `<fu>`
    Fu {
        row: Option<Text>,
        col: Option<Text>,
        name: Option<Text>,
        r#type: Option<Text>,
        slot: Option<Text>,
        width: Option<Text>,
        pred_out: Option<Text>,
        constants: Option<Text>,
        classes: Option<Text>,
        op: Vec<Spanned<Op>>,
        file: Vec<Spanned<LocalFile>>,
    }

    /// `<file>` in the `<array>`
    File {
        name: Option<Text>,
        kind: Option<Text>,
        width: Option<Text>,
        size: Option<Text>,
        read_ports: Option<Text>,
        write_ports: Option<Text>,
        readers: Option<Text>,
        writers: Option<Text>,
        from_links: Option<Text>,
    }

    /// `<link>`
    Link {
        from: Option<Text>,
        to: Option<Text>,
        delay: Option<Text>,
        width: Option<Text>,
    }

    /// `<wire>`
    Wire {
        name: Option<Text>,
        from: Option<Text>,
        to: Option<Text>,
        delay: Option<Text>,
        width: Option<Text>,
    }

    /// `<vliw>`
    Vliw {
        slots: Option<Text>,
        branch_delay: Option<Text>,
        mode_switch: Option<Text>,
        preload_width: Option<Text>,
    }

    /// `<special>`, in a machine or in `<tni>`
    Special {
        function: Option<Text>,
        bits: Option<Text>,
        structure: Option<Text>,
        degree: Option<Text>,
        segments: Option<Text>,
        tables: Option<Text>,
        radix: Option<Text>,
        unrolled: Option<Text>,
        steps: Option<Text>,
        fused: Option<Text>,
        refine: Option<Text>,
        datapath: Option<Text>,
        latency: Option<Text>,
        interval: Option<Text>,
        area_um2: Option<Text>,
        energy_fj: Option<Text>,
    }

    /// `<system>`
    System {
        cores: Option<Text>,
        tile_block: Option<Text>,
        srp_mhz: Option<Text>,
        tni_mhz: Option<Text>,
        fo4_ps: Option<Text>,
        sram: Option<Spanned<Sram>>,
        data_cache: Option<Spanned<Cache>>,
        texture_cache: Option<Spanned<Cache>>,
        instruction_cache: Option<Spanned<Cache>>,
        texture: Option<Spanned<Texture>>,
        buffers: Option<Spanned<Buffers>>,
        tni: Option<Spanned<Tni>>,
        bus: Option<Spanned<Bus>>,
        dram: Option<Spanned<Dram>>,
    }

    /// `<sram>`
    Sram {
        size: Option<Text>,
        banks: Option<Text>,
        width: Option<Text>,
        shared: Option<Text>,
    }

    /// `<data-cache>`, `<texture-cache>`, `<instruction-cache>`, `<trv-l1>`, `<trv-l2>`, `<ist-l1>`
    Cache {
        size: Option<Text>,
        ways: Option<Text>,
        line: Option<Text>,
        latency: Option<Text>,
        banks: Option<Text>,
        misses: Option<Text>,
        blocking: Option<Text>,
    }

    /// `<texture>`
    Texture {
        weight_bits: Option<Text>,
    }

    /// `<buffers>`
    Buffers {
        rays: Option<Text>,
        ray_buffers: Option<Text>,
        hit_buffers: Option<Text>,
        ray_bytes: Option<Text>,
        hit_bytes: Option<Text>,
    }

    /// `<tni>`
    Tni {
        trvs: Option<Text>,
        ists: Option<Text>,
        pipeline: Option<Text>,
        pres: Option<Text>,
        aabbs: Option<Text>,
        posts: Option<Text>,
        stacks: Option<Text>,
        stack_depth: Option<Text>,
        pre_latency: Option<Text>,
        aabb_latency: Option<Text>,
        post_latency: Option<Text>,
        ist_latency: Option<Text>,
        fifo: Option<Text>,
        rau_rows: Option<Text>,
        rau_rays: Option<Text>,
        node_bytes: Option<Text>,
        node_format: Option<Text>,
        triangle_bytes: Option<Text>,
        intersection: Option<Text>,
        any_hit: Option<Text>,
        latencies: Option<Text>,
        fp: Option<Spanned<Fp>>,
        trv_l1: Option<Spanned<Cache>>,
        trv_l2: Option<Spanned<Cache>>,
        ist_l1: Option<Spanned<Cache>>,
        special: Vec<Spanned<Special>>,
    }

    /// `<fp>` in `<tni>`
    Fp {
        add: Option<Text>,
        mul: Option<Text>,
        cmp: Option<Text>,
        rcp: Option<Text>,
    }

    /// `<bus>`
    Bus {
        width: Option<Text>,
        mhz: Option<Text>,
        latency: Option<Text>,
    }

    /// `<dram>`
    Dram {
        kind: Option<Text>,
        preset: Option<Text>,
        shared: Option<Text>,
        mhz: Option<Text>,
        channels: Option<Text>,
        bits: Option<Text>,
        latency_ns: Option<Text>,
        banks: Option<Text>,
        rows: Option<Text>,
        columns: Option<Text>,
        burst: Option<Text>,
        mapping: Option<Text>,
        timing: Option<Spanned<DramTiming>>,
        controller: Option<Spanned<Controller>>,
    }

    /// `<timing>` in `<dram>`
    DramTiming {
        cl: Option<Text>,
        cwl: Option<Text>,
        rcd: Option<Text>,
        rp: Option<Text>,
        ras: Option<Text>,
        rc: Option<Text>,
        rrd: Option<Text>,
        faw: Option<Text>,
        wtr: Option<Text>,
        rtw: Option<Text>,
        wr: Option<Text>,
        rtp: Option<Text>,
        ccd: Option<Text>,
        rfc: Option<Text>,
        refi: Option<Text>,
    }

    /// `<controller>` in `<dram>`
    Controller {
        read_queue: Option<Text>,
        write_queue: Option<Text>,
        command_queue: Option<Text>,
        row_policy: Option<Text>,
        row_hits: Option<Text>,
        write_drain: Option<Text>,
    }
}
