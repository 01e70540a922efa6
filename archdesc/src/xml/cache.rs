//! Caches of a machine file.

use super::de::Spanned;
use super::findings::Findings;
use super::limits;
use super::raw::{self, Text};
use super::values;
use crate::system::CacheSpec;

/// A cache, by the element that describes it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Cache {
    /// Of the SRP's accesses to system memory.
    Data,
    /// Of its texture unit.
    Texture,
    /// Of its instructions.
    Instructions,
    /// Of a traversal unit.
    TrvL1,
    /// Of all traversal units of a T&I unit.
    TrvL2,
    /// Of an intersection unit.
    IstL1,
}

impl Cache {
    fn element(self) -> &'static str {
        match self {
            Cache::Data => "data-cache",
            Cache::Texture => "texture-cache",
            Cache::Instructions => "instruction-cache",
            Cache::TrvL1 => "trv-l1",
            Cache::TrvL2 => "trv-l2",
            Cache::IstL1 => "ist-l1",
        }
    }

    /// The cache that an element describes, where one stands; else the default.
    pub(super) fn spec(
        self,
        found: &Findings,
        raw: &Option<Spanned<raw::Cache>>,
        default: CacheSpec,
    ) -> CacheSpec {
        let Some(raw) = raw else {
            return default;
        };
        let number = |text, limit, default| values::number(found, text, limit, default);
        let before = found.len();
        self.misplaced(found, raw);
        let banks = values::power(found, &raw.banks, limits::BANKS, default.banks);
        if let Some(text) = (raw.banks.as_ref()).filter(|_| banks > 1 && self != Cache::TrvL2) {
            let element = self.element();
            let message = format!("`{element}` has one bank: only `<trv-l2>` has several");
            found.push(found.error("A0601", text.span, message, "leave it out"));
        }
        let cache = CacheSpec {
            bytes: number(&raw.size, limits::CACHE_SIZE, default.bytes),
            ways: number(&raw.ways, limits::WAYS, default.ways),
            line: values::power(found, &raw.line, limits::LINE, default.line),
            latency: number(&raw.latency, limits::CACHE_LATENCY, default.latency),
            banks,
            misses: number(&raw.misses, limits::MISSES, default.misses),
            blocking: values::flag(found, &raw.blocking, "blocking", default.blocking),
        };
        if found.len() > before {
            return default;
        }
        let Some(complaint) = complaint(&cache) else {
            return cache;
        };
        let message = format!("`{}` cannot be built: {complaint}", self.element());
        let label = "sets = size / (ways × line)";
        found.push(found.error("A0603", raw.span, message, label).help(format!(
            "a set is {} ways × {} bytes",
            cache.ways, cache.line
        )));
        default
    }

    /// Refuses attributes that such a cache does not have.
    fn misplaced(self, found: &Findings, raw: &raw::Cache) {
        let element = self.element();
        let refuse = |text: &Option<Text>, message: String| {
            if let Some(text) = text {
                found.push(found.error("A0601", text.span, message, "leave it out"));
            }
        };
        match self {
            Cache::Data | Cache::Texture => {}
            Cache::Instructions => {
                for (name, text) in [
                    ("latency", &raw.latency),
                    ("banks", &raw.banks),
                    ("misses", &raw.misses),
                    ("blocking", &raw.blocking),
                ] {
                    let why = "every miss is waited for";
                    refuse(text, format!("an `<{element}>` has no `{name}`: {why}"));
                }
            }
            Cache::TrvL1 | Cache::TrvL2 | Cache::IstL1 => refuse(
                &raw.blocking,
                format!(
                    "`blocking` is of the data and texture caches of the SRP: a `<{element}>` never blocks"
                ),
            ),
        }
    }
}

/// The reason why a cache cannot be built.
fn complaint(cache: &CacheSpec) -> Option<String> {
    let (set, sets) = (cache.ways * cache.line, cache.sets());
    if !cache.bytes.is_multiple_of(set) {
        let bytes = cache.bytes;
        return Some(format!(
            "{bytes} bytes are not a whole number of sets of {set}"
        ));
    }
    if !sets.is_power_of_two() {
        return Some(format!(
            "it would have {sets} sets, which is not a power of two"
        ));
    }
    let banks = cache.banks;
    (banks > sets).then(|| format!("it has {sets} sets, fewer than its {banks} banks"))
}
