//! Values that may be written in more than one way. Visitors by hand instead of untagged enums, because their errors
//! name the expected value and its position.

mod schema;

use std::fmt;
use std::marker::PhantomData;
use std::path::PathBuf;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Serialize, Serializer};

/// A list of exactly `N` values; a longer list is an error, too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::scene::file) struct List<T, const N: usize>(pub [T; N]);

impl<T: Serialize, const N: usize> Serialize for List<T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.as_slice().serialize(serializer)
    }
}

impl<T: Default + Copy, const N: usize> Default for List<T, N> {
    fn default() -> Self {
        Self([T::default(); N])
    }
}

impl<const N: usize> From<List<f64, N>> for nalgebra::SVector<f64, N> {
    fn from(list: List<f64, N>) -> Self {
        list.0.into()
    }
}

/// One number for both section axes, or a pair.
#[derive(Debug, Clone, Copy)]
pub(in crate::scene::file) struct Pair(pub [f64; 2]);

/// A node: `"start"`, `"end"`, an index, or `{ arc = s }` for the node nearest to an arc length.
#[derive(Debug, Clone, Copy)]
pub(in crate::scene::file) enum At {
    Start,
    End,
    Node(usize),
    Arc(f64),
}

/// Fixed components: `true`, `false`, or a list of `"x"`, `"y"`, `"z"`.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::scene::file) struct FixedAxes(pub [bool; 3]);

/// The stress-free state: `"straight"`, `"as-shaped"`, `{ curvature = [k1, k2], twist = k3 }`, or `{ table = file }`.
#[derive(Debug, Clone, Default)]
pub(in crate::scene::file) enum NaturalText {
    #[default]
    Straight,
    AsShaped,
    Uniform(UniformText),
    Table(PathBuf),
}

#[derive(Debug, Clone, Copy)]
pub(in crate::scene::file) struct UniformText {
    pub curvature: [f64; 2],
    pub twist: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StrainsText {
    curvature: Option<List<f64, 2>>,
    twist: Option<f64>,
    table: Option<PathBuf>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ArcText {
    arc: f64,
}

/// One table or a list of tables.
#[derive(Debug, Clone)]
pub(in crate::scene::file) struct OneOrMany<T>(pub Vec<T>);

impl<T> Default for OneOrMany<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

/// Rods: a name or a list of names; empty where none is given.
#[derive(Debug, Clone, Default)]
pub(in crate::scene::file) struct RodNames(pub Vec<String>);

struct ListVisitor<T, const N: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Default + Copy, const N: usize> Visitor<'de> for ListVisitor<T, N> {
    type Value = List<T, N>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a list of {N} numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<List<T, N>, A::Error> {
        let mut list = List::default();
        for (k, slot) in list.0.iter_mut().enumerate() {
            *slot = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(k, &self))?;
        }
        let mut length = N;
        while seq.next_element::<T>()?.is_some() {
            length += 1;
        }
        if length == N { Ok(list) } else { Err(A::Error::invalid_length(length, &self)) }
    }
}

struct PairVisitor;

impl<'de> Visitor<'de> for PairVisitor {
    type Value = Pair;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, or two numbers [about d1, about d2]")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Pair, E> {
        Ok(Pair([value; 2]))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Pair, E> {
        Ok(Pair([value as f64; 2]))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Pair, E> {
        Ok(Pair([value as f64; 2]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Pair, A::Error> {
        ListVisitor::<f64, 2>(PhantomData).visit_seq(seq).map(|list| Pair(list.0))
    }
}

struct AtVisitor;

impl<'de> Visitor<'de> for AtVisitor {
    type Value = At;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("\"start\", \"end\", a node index, or { arc = arc length }")
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<At, E> {
        match value {
            "start" => Ok(At::Start),
            "end" => Ok(At::End),
            _ => Err(E::invalid_value(Unexpected::Str(value), &self)),
        }
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<At, E> {
        usize::try_from(value).map(At::Node).map_err(|_| E::invalid_value(Unexpected::Signed(value), &self))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<At, E> {
        usize::try_from(value).map(At::Node).map_err(|_| E::invalid_value(Unexpected::Unsigned(value), &self))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<At, A::Error> {
        ArcText::deserialize(MapAccessDeserializer::new(map)).map(|text| At::Arc(text.arc))
    }
}

/// What prolongs an end: `"none"`, `"endless"`, or a length.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::scene::file) enum GripText {
    #[default]
    None,
    Endless,
    Length(f64),
}

struct GripVisitor;

impl Visitor<'_> for GripVisitor {
    type Value = GripText;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("\"none\", \"endless\" or a length")
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<GripText, E> {
        match value {
            "none" => Ok(GripText::None),
            "endless" => Ok(GripText::Endless),
            _ => Err(E::invalid_value(Unexpected::Str(value), &self)),
        }
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<GripText, E> {
        Ok(GripText::Length(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<GripText, E> {
        Ok(GripText::Length(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<GripText, E> {
        Ok(GripText::Length(value as f64))
    }
}

impl<'de> Deserialize<'de> for GripText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(GripVisitor)
    }
}

struct AxesVisitor;

impl<'de> Visitor<'de> for AxesVisitor {
    type Value = FixedAxes;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("true, false, or a list of \"x\", \"y\", \"z\"")
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<FixedAxes, E> {
        Ok(FixedAxes([value; 3]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<FixedAxes, A::Error> {
        let mut axes = [false; 3];
        while let Some(name) = seq.next_element::<String>()? {
            let index = ["x", "y", "z"].iter().position(|axis| *axis == name);
            axes[index.ok_or_else(|| A::Error::invalid_value(Unexpected::Str(&name), &self))?] = true;
        }
        Ok(FixedAxes(axes))
    }
}

struct NaturalVisitor;

impl<'de> Visitor<'de> for NaturalVisitor {
    type Value = NaturalText;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("\"straight\", \"as-shaped\", { curvature = [k1, k2], twist = k3 }, or { table = file }")
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<NaturalText, E> {
        match value {
            "straight" => Ok(NaturalText::Straight),
            "as-shaped" => Ok(NaturalText::AsShaped),
            _ => Err(E::invalid_value(Unexpected::Str(value), &self)),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<NaturalText, A::Error> {
        let text = StrainsText::deserialize(MapAccessDeserializer::new(map))?;
        match (text.table, text.curvature, text.twist) {
            (Some(table), None, None) => Ok(NaturalText::Table(table)),
            (Some(_), ..) => Err(A::Error::custom("a table gives all natural strains: remove curvature and twist")),
            (None, curvature, twist) => {
                let curvature = curvature.unwrap_or_default().0;
                Ok(NaturalText::Uniform(UniformText { curvature, twist: twist.unwrap_or_default() }))
            }
        }
    }
}

struct ManyVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for ManyVisitor<T> {
    type Value = OneOrMany<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a table or a list of tables, such as { to = … }")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<OneOrMany<T>, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(|one| OneOrMany(vec![one]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<OneOrMany<T>, A::Error> {
        TablesVisitor(PhantomData).visit_seq(seq).map(OneOrMany)
    }
}

/// A table only, because serde's derived readers would also accept a list with its values in the order of the keys.
struct TableOnly<T>(T);

struct TableVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for TableVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map))
    }
}

struct TablesVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for TablesVisitor<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of tables")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Vec<T>, A::Error> {
        let mut tables = Vec::new();
        while let Some(TableOnly(table)) = seq.next_element()? {
            tables.push(table);
        }
        Ok(tables)
    }
}

/// Reads a table into a struct.
pub(in crate::scene::file) fn table<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
    deserializer.deserialize_any(TableVisitor(PhantomData))
}

/// Reads an optional table into a struct.
pub(in crate::scene::file) fn some_table<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    table(deserializer).map(Some)
}

/// Reads a list of tables into structs.
pub(in crate::scene::file) fn tables<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    deserializer.deserialize_any(TablesVisitor(PhantomData))
}

struct NamesVisitor;

impl<'de> Visitor<'de> for NamesVisitor {
    type Value = RodNames;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("the name of a rod or a list of names")
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<RodNames, E> {
        Ok(RodNames(vec![value.to_owned()]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<RodNames, A::Error> {
        let names = Vec::deserialize(SeqAccessDeserializer::new(seq))?;
        if names.is_empty() { Err(A::Error::invalid_length(0, &self)) } else { Ok(RodNames(names)) }
    }
}

impl<'de, T: Deserialize<'de> + Default + Copy, const N: usize> Deserialize<'de> for List<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ListVisitor(PhantomData))
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for TableOnly<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        table(deserializer).map(TableOnly)
    }
}

impl<'de> Deserialize<'de> for Pair {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PairVisitor)
    }
}

impl<'de> Deserialize<'de> for At {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AtVisitor)
    }
}

impl<'de> Deserialize<'de> for FixedAxes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AxesVisitor)
    }
}

impl<'de> Deserialize<'de> for NaturalText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NaturalVisitor)
    }
}

impl<'de> Deserialize<'de> for RodNames {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NamesVisitor)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for OneOrMany<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ManyVisitor(PhantomData))
    }
}
