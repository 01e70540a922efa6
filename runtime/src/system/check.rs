//! Which machines can be simulated.

use srp_archdesc::SystemSpec;

use crate::bvh::TRIANGLE_BYTES;
use crate::tni::{HIT_BYTES, RAY_BYTES};

/// Checks that the units of a machine fit each other. The error names those that do not.
pub fn check(spec: &SystemSpec) -> Result<(), String> {
    let tni = &spec.tni;
    let rays = u64::from(tni.trvs) * u64::from(tni.stacks);
    let at_least = |what: &str, is: u32, least: u32| match is >= least {
        true => Ok(()),
        false => Err(format!("{what} is {is}, and must be at least {least}")),
    };
    let exactly = |what: &str, is: u32, must: u32| match is == must {
        true => Ok(()),
        false => Err(format!("{what} is {is}, and must be {must}")),
    };
    at_least("the number of traversal units", tni.trvs, 1)?;
    at_least("the number of intersection units", tni.ists, 1)?;
    at_least("the number of stacks", tni.stacks, 1)?;
    at_least(
        "the size of a node",
        tni.node_bytes,
        tni.node_format.bytes(),
    )?;
    at_least("the size of a triangle", tni.triangle_bytes, TRIANGLE_BYTES)?;
    exactly("the size of a ray", spec.buffers.ray_bytes, RAY_BYTES)?;
    exactly("the size of a hit", spec.buffers.hit_bytes, HIT_BYTES)?;
    if rays >= u64::from(u16::MAX) {
        return Err(format!(
            "{rays} rays in a T&I unit, which numbers them with 16 bits"
        ));
    }
    if !tni.node_bytes.is_multiple_of(4) || !tni.triangle_bytes.is_multiple_of(4) {
        return Err("nodes and triangles do not consist of whole words".to_owned());
    }
    if !tni.trv_l2.line.is_multiple_of(tni.trv_l1.line) {
        return Err(format!(
            "a line of the T&I unit's level-2 cache, of {} bytes, is not made of lines of level 1, of {}: make \
             it a multiple of them",
            tni.trv_l2.line, tni.trv_l1.line
        ));
    }
    for (name, cache) in [
        ("data", Some(&spec.data_cache)),
        ("texture", Some(&spec.texture_cache)),
        ("instruction", spec.instruction_cache.as_ref()),
        ("TRV L1", Some(&tni.trv_l1)),
        ("TRV L2", Some(&tni.trv_l2)),
        ("IST L1", Some(&tni.ist_l1)),
    ] {
        let Some(cache) = cache else { continue };
        let whole = cache.ways > 0 && cache.line > 0 && cache.sets() > 0 && cache.misses > 0;
        if !whole {
            return Err(format!("the {name} cache has no sets, or allows no miss"));
        }
    }
    Ok(())
}
