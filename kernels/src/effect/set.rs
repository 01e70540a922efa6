//! Sets of effects. With an effect, a set contains those that it needs.

use std::fmt;

use super::{Effect, TABLE};

/// A set of effects. With an effect it has those that the effect needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Effects(u32);

/// A name that no effect has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownEffect {
    /// The name.
    pub name: String,
}

impl fmt::Display for UnknownEffect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = TABLE.iter().map(|e| e.name).collect();
        write!(
            f,
            "there is no effect `{}`; there are {}",
            self.name,
            names.join(", ")
        )
    }
}

impl std::error::Error for UnknownEffect {}

impl Effects {
    /// The empty set.
    pub const NONE: Effects = Effects(0);

    /// All effects, for which a universal simulator is built.
    pub fn all() -> Effects {
        TABLE.iter().map(|e| e.effect).collect()
    }

    /// True if an effect is in it.
    pub fn contains(self, effect: Effect) -> bool {
        self.0 & bit(effect) != 0
    }

    /// With an effect and all that it needs.
    pub fn with(self, effect: Effect) -> Effects {
        let needs = effect.entry().needs;
        let needed = needs.iter().fold(self, |set, &e| set.with(e));
        Effects(needed.0 | bit(effect))
    }

    /// Without an effect and all that need it.
    pub fn without(self, effect: Effect) -> Effects {
        let left = Effects(self.0 & !bit(effect));
        let users = TABLE.iter().filter(|e| e.needs.contains(&effect));
        users.fold(left, |set, user| set.without(user.effect))
    }

    /// The effects of this set that another does not have.
    pub fn minus(self, other: Effects) -> impl Iterator<Item = Effect> {
        Effects(self.0 & !other.0).iter()
    }

    /// The effects, in the order of the table.
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        let all = TABLE.iter().map(|e| e.effect);
        all.filter(move |&e| self.contains(e))
    }

    /// Changes a set as a list says: `+name` puts an effect in, `-name` leaves it out, and a list
    /// of names without signs is a set of its own. The second value says whether it is.
    pub fn parse(self, list: &str) -> Result<(Effects, bool), UnknownEffect> {
        let words: Vec<&str> = list.split(',').map(str::trim).collect();
        let is_whole = !words.iter().any(|w| w.starts_with(['+', '-']));
        let start = if is_whole { Effects::NONE } else { self };
        let change = |set: Effects, word: &&str| {
            let name = word.trim_start_matches(['+', '-']);
            match name {
                "" | "none" => return Ok(set),
                "all" if word.starts_with('-') => return Ok(Effects::NONE),
                "all" => return Ok(Effects::all()),
                _ => {}
            }
            let entry = TABLE.iter().find(|e| e.name == name);
            let entry = entry.ok_or_else(|| UnknownEffect {
                name: name.to_owned(),
            })?;
            Ok(match word.starts_with('-') {
                true => set.without(entry.effect),
                false => set.with(entry.effect),
            })
        };
        let set = words.iter().try_fold(start, change)?;
        Ok((set, is_whole))
    }

    /// The macros that tell the kernels their effects: names and values.
    pub fn defines(self) -> impl Iterator<Item = (String, String)> {
        TABLE.iter().map(move |entry| {
            let value = u8::from(self.contains(entry.effect));
            (format!("SRP_EFFECT_{}", entry.name), value.to_string())
        })
    }
}

fn bit(effect: Effect) -> u32 {
    1 << effect as u32
}

impl FromIterator<Effect> for Effects {
    fn from_iter<I: IntoIterator<Item = Effect>>(effects: I) -> Effects {
        effects.into_iter().fold(Effects::NONE, Effects::with)
    }
}

impl fmt::Display for Effects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.iter().map(Effect::name).collect();
        f.write_str(if names.is_empty() { "none" } else { "" })?;
        f.write_str(&names.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_closed_under_what_effects_need() {
        for entry in &TABLE {
            let with = Effects::NONE.with(entry.effect);
            assert!(
                entry.needs.iter().all(|&e| with.contains(e)),
                "{}",
                entry.name
            );
            let without = Effects::all().without(entry.effect);
            let users = TABLE.iter().filter(|e| e.needs.contains(&entry.effect));
            assert!(
                users.into_iter().all(|e| !without.contains(e.effect)),
                "{}",
                entry.name
            );
        }
        let (set, whole) = Effects::NONE.parse("tinted_shadow").expect("it is a name");
        assert!(whole && set.to_string() == "light,shadow,tinted_shadow");
        let (set, whole) = set.parse("-shadow,+fresnel").expect("they are names");
        assert!(!whole && set.to_string() == "light,reflection,fresnel");
        assert_eq!(set.parse("fog").expect_err("there is none").name, "fog");
        assert_eq!(Effects::all().parse("none"), Ok((Effects::NONE, true)));
    }
}
