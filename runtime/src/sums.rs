//! Counters that are added up, and of which there is a difference between two moments.

/// Gives a structure of counters `add` and `since`: by its numbers, and by its parts, which have them too.
macro_rules! sums {
    ($type:ty: $($number:ident)* $(; $($part:ident)*)?) => {
        impl $type {
            /// Adds what others have counted.
            pub fn add(&mut self, other: &Self) {
                $(self.$number += other.$number;)*
                $($(self.$part.add(&other.$part);)*)?
            }

            /// What has been counted since a moment.
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
