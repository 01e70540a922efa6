//! Builds of kernels that are ready: the cache has the schedules of all their loops, and the whole program where the
//! compiler had nothing to say.
//!
//! Kernels that are built for more effects than a scene calls for make the same picture in more cycles
//! ([`srp_kernels::effect`]). To simulate these takes a fraction of a second; to schedule kernels takes seconds. Who
//! has many scenes that call for different effects may therefore take the nearest build that is ready. Cycles then
//! depend on what was built before, so nothing does that unasked.

use crate::cache::key::Builder;
use crate::cache::{Damage, Key, Kind};
use crate::{BUILD_ID, Build, Compiled, Error, Session, loops};
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::Arch;
use srp_ir::check::{self, Checked};
use srp_ir::dre::scheduled::ScheduledDre;
use srp_kernels::effect::{Effect, Effects};

/// The entry of a build that is ready.
#[derive(Serialize, Deserialize)]
struct Entry {
    /// The digest of all that is equal in builds of which one can take another's place.
    family: [u8; Key::BYTES],
    /// Names of its effects, as [`Effects::parse`] has them.
    effects: String,
    /// Secondary rays in a row that there is room for.
    bounces: u32,
    /// Entries without which it is not ready: the whole program, or else the schedules of its loops.
    needs: Vec<Key>,
}

/// A build that is ready, in the place of another.
#[derive(Clone, Debug)]
pub struct Ready {
    /// The build.
    pub build: Build,
    /// Effects that the other does not have.
    pub more: Vec<Effect>,
}

/// Kernels that can be simulated.
pub enum Scheduled {
    /// They were compiled before, without a message.
    Before(Box<Checked>),
    /// They are compiled now.
    Now(Box<Compiled>),
}

impl Scheduled {
    /// The program.
    ///
    /// # Errors
    ///
    /// [`Error::NoMain`].
    pub fn program(&self) -> Result<&Checked, Error> {
        match self {
            Scheduled::Before(program) => Ok(program),
            Scheduled::Now(compiled) => compiled.runnable(),
        }
    }
}

impl Build {
    /// The kernels, compiled now if they were not before. Who wants to know more of them than how they run
    /// [compiles](Build::compile) them.
    ///
    /// # Errors
    ///
    /// Those of [`Build::compile`].
    pub fn scheduled(&self, arch: &Arch, session: &Session<'_>) -> Result<Scheduled, Error> {
        let key = self.program_key(arch);
        let kept: Option<ScheduledDre> = session.cache.get(key, session.watch);
        match kept.map(|program| check::check(program, arch)) {
            Some(Ok(program)) => return Ok(Scheduled::Before(Box::new(program))),
            Some(Err(_)) => session.cache.forget(key, Damage::Rules, session.watch),
            None => {}
        }
        let compiled = self.compile(arch, session)?;
        let refused = compiled.not_pipelined.iter().any(|n| n.required);
        if let (false, false, Ok(program)) =
            (refused, session.watch.cancelled(), compiled.runnable())
        {
            let needs = match compiled.messages.diagnostics.is_empty() {
                true => {
                    (session.cache).put::<ScheduledDre>(key, program, session.watch);
                    vec![key]
                }
                false => {
                    let options = self.effort.modulo();
                    let loops = program.kernels.values();
                    (loops.map(|l| loops::key(&l.dfg, &arch.srp, &options))).collect()
                }
            };
            self.remember(needs, arch, session);
        }
        Ok(Scheduled::Now(Box::new(compiled)))
    }

    /// The build for all effects, else as this one.
    #[must_use]
    pub fn universal(&self) -> Build {
        Build {
            effects: Effects::all(),
            ..self.clone()
        }
    }

    /// Of the builds that are ready and do all that this one does, one of the fewest effects: this one if it is among them.
    pub fn nearest(&self, arch: &Arch, session: &Session<'_>) -> Option<Ready> {
        let family = self.family(arch);
        let known: Vec<Entry> = session.cache.all(Kind::Builds, session.watch);
        let candidates = known.iter().filter_map(|entry| {
            let (effects, _) = Effects::NONE.parse(&entry.effects).ok()?;
            let serves = entry.family == *family.digest()
                && entry.bounces >= self.bounces
                && self.effects.minus(effects).next().is_none();
            serves.then_some((effects, entry))
        });
        let mut candidates: Vec<(Effects, &Entry)> = candidates.collect();
        candidates.sort_by_key(|&(effects, entry)| {
            let more = effects.minus(self.effects).count();
            (more, entry.bounces, effects)
        });
        // What the cache has dropped since is not ready.
        let is_there = |key: &Key| session.cache.bytes(*key, session.watch).is_some();
        let of = |(effects, entry): (Effects, &Entry)| {
            entry.needs.iter().all(is_there).then(|| Ready {
                build: Build {
                    effects,
                    bounces: entry.bounces,
                    ..self.clone()
                },
                more: effects.minus(self.effects).collect(),
            })
        };
        candidates.into_iter().find_map(of)
    }

    /// Names the scheduled program.
    fn program_key(&self, arch: &Arch) -> Key {
        let key = Key::of(Kind::Programs).text(BUILD_ID).value(arch);
        let key = key.value(&self.options());
        key.text(self.kernels.digest()).finish()
    }

    /// Remembers that this build is ready.
    fn remember(&self, needs: Vec<Key>, arch: &Arch, session: &Session<'_>) {
        let entry = Entry {
            family: *self.family(arch).digest(),
            effects: self.effects.to_string(),
            bounces: self.bounces,
            needs,
        };
        let key = Key::of(Kind::Builds).value(&entry).finish();
        if session.cache.bytes(key, session.watch).is_none() {
            session.cache.put(key, &entry, session.watch);
        }
    }

    /// Names all but effects and bounces.
    fn family(&self, arch: &Arch) -> Key {
        let bare = Build {
            effects: Effects::NONE,
            bounces: 0,
            ..self.clone()
        };
        let family: Builder = Key::of(Kind::Builds).text(BUILD_ID).value(arch);
        let family = family.value(&bare.options());
        family.text(self.kernels.digest()).finish()
    }
}
