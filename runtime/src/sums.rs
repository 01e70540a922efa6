//! Counters that can be added up, and subtracted to count from one moment to another.

/// Gives a structure of counters `add` and `since`: by its numbers, and by its parts, which have them too.
macro_rules! sums {
    ($type:ty: $($number:ident)* $(; $($part:ident)*)?) => {
        impl $type {
            /// Adds the counts of others.
            pub fn add(&mut self, other: &Self) {
                $(self.$number += other.$number;)*
                $($(self.$part.add(&other.$part);)*)?
            }

            /// The counts since a moment.
            pub fn since(&self, before: &Self) -> Self {
                let mut after = *self;
                $(after.$number = self.$number.saturating_sub(before.$number);)*
                $($(after.$part = self.$part.since(&before.$part);)*)?
                after
            }
        }
    };
}

pub(crate) use sums;
