//! JSON Schema of values that may be written in more than one way.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::{At, FixedAxes, GripText, List, NaturalText, OneOrMany, Pair, RodNames};

/// A schema in the place of the key, because these values have no table of their own in the reference.
macro_rules! inline {
    ($name:ident) => {
        fn inline_schema() -> bool {
            true
        }

        fn schema_name() -> Cow<'static, str> {
            stringify!($name).into()
        }
    };
}

impl<T: JsonSchema, const N: usize> JsonSchema for List<T, N> {
    inline!(List);

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let items = generator.subschema_for::<T>();
        json_schema!({ "type": "array", "items": items, "minItems": N, "maxItems": N })
    }
}

impl JsonSchema for Pair {
    inline!(Pair);

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let pair = generator.subschema_for::<List<f64, 2>>();
        json_schema!({ "anyOf": [{ "type": "number" }, pair] })
    }
}

impl JsonSchema for At {
    inline!(At);

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let arc = json_schema!({
            "type": "object",
            "properties": { "arc": { "type": "number", "description": "arc length, L: the node nearest to it" } },
            "required": ["arc"],
            "additionalProperties": false
        });
        json_schema!({
            "anyOf": [{ "enum": ["start", "end"] }, { "type": "integer", "minimum": 0 }, arc],
            "x-value": "`\"start\"`, `\"end\"`, an index, or `{ arc = s }`, the node nearest to an arc length s, L"
        })
    }
}

impl JsonSchema for GripText {
    inline!(GripText);

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [{ "enum": ["none", "endless"] }, { "type": "number", "exclusiveMinimum": 0 }],
            "x-value": "`\"none\"`, `\"endless\"` or a length",
            "x-default": "`\"none\"`: the rod ends in a point"
        })
    }
}

impl JsonSchema for FixedAxes {
    inline!(FixedAxes);

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [{ "type": "boolean" }, { "type": "array", "items": { "enum": ["x", "y", "z"] } }],
            "x-value": "true, false, or axes as `[\"x\", \"y\"]`",
            "x-default": "false"
        })
    }
}

impl JsonSchema for NaturalText {
    inline!(NaturalText);

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let curvature = generator.subschema_for::<List<f64, 2>>();
        json_schema!({
            "anyOf": [
                { "enum": ["straight", "as-shaped"] },
                {
                    "type": "object",
                    "properties": {
                        "curvature": curvature,
                        "twist": { "type": "number" },
                        "table": { "type": "string" }
                    },
                    "additionalProperties": false
                }
            ],
            "x-value": "`\"straight\"`, `\"as-shaped\"`, `{ curvature = [k1, k2], twist = k3 }` or `{ table \
             = \"file.csv\" }`"
        })
    }
}

impl JsonSchema for RodNames {
    inline!(RodNames);

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" }, "minItems": 1 }],
            "x-value": "name or list of names"
        })
    }
}

impl<T: JsonSchema> JsonSchema for OneOrMany<T> {
    inline!(OneOrMany);

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = generator.subschema_for::<T>();
        json_schema!({ "anyOf": [one, { "type": "array", "items": one }] })
    }
}
