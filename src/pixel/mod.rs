//! `srp render --pixel X,Y`: all that a pixel was made of.

mod document;
mod places;
mod text;

use crate::failure::Failure;
use crate::{interrupt, talk, trace};
pub(crate) use document::HistoryDocument;
use places::Places;
use srp_debugger::Variables;
use srp_ir::check::Checked;
use srp_runtime::scene_image::{SceneImage, tile_size};
use srp_toolchain::envelope::About;
use srp_toolchain::{Engines, Frame, Session};
use srp_traces::Trace;
use srp_traces::history::{Made, StoreWatch, Stored, history};

/// A pixel of a frame whose history is wanted.
pub(crate) struct Wanted {
    x: u32,
    y: u32,
    tile: u32,
    /// The address of its bytes in the frame buffer.
    address: u32,
}

/// The history of a pixel, and what its parts are called.
pub(crate) struct History {
    wanted: Wanted,
    /// Red, green, blue, and a byte that means nothing.
    bytes: [u8; 4],
    stored: Stored,
    trace: Trace,
    made: Vec<Made>,
    variables: Variables,
    places: Places,
}

impl Wanted {
    /// The pixel that is asked for.
    pub(crate) fn of(
        pixel: Option<(u32, u32)>,
        frame: &Frame,
        image: &SceneImage,
    ) -> Result<Option<Wanted>, Failure> {
        let Some((x, y)) = pixel else {
            return Ok(None);
        };
        let of = &image.frame;
        if x >= of.width || y >= of.height {
            return Err(Failure::Message(format!(
                "--pixel {x},{y}: the frame has {}x{} pixels",
                of.width, of.height
            )));
        }
        let (across, down) = tile_size(frame.arch.system.buffers.rays);
        Ok(Some(Wanted {
            x,
            y,
            tile: y / down * image.across + x / across,
            address: of.address + 4 * (y * of.stride + x),
        }))
    }

    /// What sees its last store.
    pub(crate) fn watch(&self) -> StoreWatch {
        StoreWatch::new(self.address, self.tile)
    }

    /// Its history: the frame is run again, as far as to that store, and recorded.
    pub(crate) fn history(
        self,
        stored: Option<Stored>,
        (program, engines): (&Checked, &Engines),
        frame: &Frame,
        session: &Session<'_>,
    ) -> Result<History, Failure> {
        let Some(stored) = stored else {
            return Err(Failure::Message(format!(
                "--pixel {},{}: no core has stored there",
                self.x, self.y
            )));
        };
        let image = frame.image()?;
        let places = Places::of(&program.symbols, &image);
        let window = (stored.cycles.clone(), stored.core);
        let recorded = trace::recorded(window, image, (program, engines), frame, session);
        let (trace, memory) = recorded?;
        if trace.is_cut {
            return Err(Failure::Message(format!(
                "--pixel {},{}: cycles {}..{} of core {} are more than there is room for; use fewer samples \
                 a pixel, or follow less light",
                self.x, self.y, stored.cycles.start, stored.cycles.end, stored.core
            )));
        }
        interrupt::end_if_requested()?;
        let bytes = memory.get(self.address, 4);
        let bytes = bytes.and_then(|bytes| bytes.try_into().ok());
        let front = frame.build.front_end(&frame.arch);
        Ok(History {
            bytes: bytes.unwrap_or_default(),
            made: history(&trace, &stored.launches, self.address),
            // It was compiled before.
            variables: front.map_or_else(
                |_| Variables::default(),
                |front| Variables::of(&front.program),
            ),
            wanted: self,
            stored,
            trace,
            places,
        })
    }
}

impl History {
    /// Prints it.
    pub(crate) fn show(&self, about: About, json: bool) -> Result<(), Failure> {
        let text = match json {
            true => crate::document::json(about, &self.document())?,
            false => self.text(),
        };
        Ok(talk::print(text)?)
    }
}
