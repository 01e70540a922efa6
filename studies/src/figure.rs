//! Figures: what is measured, as a type, with its value and interval. Names and units are for whoever shows
//! or writes them.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use crate::survey::Estimate;

/// A quantity that is measured. It is shown by its name.
pub trait Quantity: Clone + PartialEq + fmt::Debug + fmt::Display {
    /// Its unit.
    fn unit(&self) -> Unit;
}

/// The unit of a quantity. It is shown, and written, as its symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// None: a number, or a ratio of numbers. Its symbol is empty.
    Number,
    /// A part of a whole, in %. Its errors are differences, those of others are ratios.
    Percent,
    /// Cycles of the SRP's clock.
    Cycles,
    /// Cycles of the T&I unit's clock.
    TniCycles,
    /// ms.
    Milliseconds,
    /// ns.
    Nanoseconds,
    /// 10⁶ rays a second.
    MraysPerSecond,
    /// 10⁹ bytes a second.
    GigabytesPerSecond,
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Unit::Number => "",
            Unit::Percent => "%",
            Unit::Cycles => "cycles",
            Unit::TniCycles => "T&I cycles",
            Unit::Milliseconds => "ms",
            Unit::Nanoseconds => "ns",
            Unit::MraysPerSecond => "Mrays/s",
            Unit::GigabytesPerSecond => "GB/s",
        })
    }
}

impl Serialize for Unit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl JsonSchema for Unit {
    fn schema_name() -> Cow<'static, str> {
        "Unit".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "description": "The symbol of a unit; empty for a number." })
    }
}

/// The members that [`name_and_unit`] writes.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "it is only described")]
pub struct NameAndUnit {
    /// The quantity's name.
    name: String,
    /// Its unit.
    unit: Unit,
}

/// A quantity with its value and interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure<Q> {
    /// The quantity that is measured.
    pub quantity: Q,
    /// Its value and interval.
    pub estimate: Estimate,
}

impl<Q: Quantity> Serialize for Figure<Q> {
    /// As an object with `name`, `unit`, `value` and `half_width`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut figure = serializer.serialize_struct("Figure", 4)?;
        figure.serialize_field("name", &self.quantity.to_string())?;
        figure.serialize_field("unit", &self.quantity.unit())?;
        figure.serialize_field("value", &self.estimate.value)?;
        figure.serialize_field("half_width", &self.estimate.half_width)?;
        figure.end()
    }
}

impl<Q: Quantity> JsonSchema for Figure<Q> {
    fn schema_name() -> Cow<'static, str> {
        "Figure".into()
    }

    fn schema_id() -> Cow<'static, str> {
        concat!(module_path!(), "::Figure").into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "object",
            "description": "A quantity with its value and interval.",
            "properties": {
                "name": { "type": "string", "description": "The quantity's name." },
                "unit": generator.subschema_for::<Unit>(),
                "value": { "type": "number", "description": "The value." },
                "half_width": {
                    "type": "number",
                    "description": "Half the width of its 95 % interval; null where the sample is too small to know it.",
                },
            },
            "required": ["name", "unit", "value", "half_width"],
        })
    }
}

/// Writes a quantity as its name.
///
/// # Errors
///
/// Those of the serializer.
pub fn name<Q: Quantity, S: Serializer>(quantity: &Q, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(quantity)
}

/// Writes a quantity as an object with `name` and `unit`, which may be flattened.
///
/// # Errors
///
/// Those of the serializer.
pub fn name_and_unit<Q: Quantity, S: Serializer>(
    quantity: &Q,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut object = serializer.serialize_struct("Quantity", 2)?;
    object.serialize_field("name", &quantity.to_string())?;
    object.serialize_field("unit", &quantity.unit())?;
    object.end()
}

/// The estimate of a quantity, where it is among these figures.
pub fn estimate_of<Q: Quantity>(figures: &[Figure<Q>], quantity: &Q) -> Option<Estimate> {
    let figure = figures.iter().find(|f| f.quantity == *quantity);
    figure.map(|f| f.estimate)
}
