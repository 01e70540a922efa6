//! Scenes and frames for every command that needs one, with what is doubtful about them said.

use crate::cli::{self, Building};
use crate::failure::Failure;
use crate::talk;
use srp_runtime::bvh::Builder;
use srp_runtime::scene::{Camera, Scene};
use srp_toolchain::scene::{self, Loaded};
use srp_toolchain::{Frame, Session};
use std::path::Path;

/// Reads a scene, or makes the default one.
pub(crate) fn read(
    path: Option<&Path>,
    camera: Option<Camera>,
    session: &Session<'_>,
) -> Result<Scene, Failure> {
    let loaded = scene::read(path, camera, session)?;
    say(&loaded);
    Ok(loaded.scene)
}

/// Reads what a frame is of, and builds its tree.
pub(crate) fn frame(
    args: &cli::Frame,
    building: Option<&Building>,
    builder: Builder,
    size: (u32, u32),
    session: &Session<'_>,
) -> Result<Frame, Failure> {
    let arch = args.machine.read()?;
    let options = args.options(building, builder, size)?;
    Ok(Frame::read(arch, &options, &mut say, session)?)
}

/// Says what is doubtful about a scene.
pub(crate) fn say(loaded: &Loaded) {
    talk::say_all(&loaded.warnings.render(talk::colour()));
    for what in &loaded.unsupported {
        talk::complain(format_args!("warning: {what}"));
    }
}
