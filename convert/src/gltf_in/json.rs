//! JSON values that know where they stand, so that every complaint names its place as a JSON pointer (RFC 6901).

use serde_json::{Map, Value};

use super::fault::{Checked, Fault};

/// A JSON value and its place.
#[derive(Clone, Debug)]
pub(super) struct At<'a> {
    value: &'a Value,
    place: String,
}

impl<'a> At<'a> {
    /// The whole file.
    pub(super) const fn root(value: &'a Value) -> Self {
        Self { value, place: String::new() }
    }

    /// Where it stands.
    pub(super) fn place(&self) -> &str {
        &self.place
    }

    /// Where a member stands, whether it is there or not.
    pub(super) fn place_of(&self, key: &str) -> String {
        format!("{}/{}", self.place, key.replace('~', "~0").replace('/', "~1"))
    }

    /// A fault of the value itself.
    pub(super) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::broken(if self.place.is_empty() { "/" } else { &self.place }, message)
    }

    /// A fault of a member.
    pub(super) fn fault_of(&self, key: &str, message: impl Into<String>) -> Fault {
        Fault::broken(self.place_of(key), message)
    }

    /// The value as compact JSON.
    pub(super) fn to_json(&self) -> String {
        self.value.to_string()
    }

    /// The value as an object.
    pub(super) fn object(&self) -> Checked<&'a Map<String, Value>> {
        match self.value {
            Value::Object(map) => Ok(map),
            other => Err(self.fault(format!("expected an object, found {}", kind(other)))),
        }
    }

    /// A member; `None` when it is absent or null.
    pub(super) fn get(&self, key: &str) -> Option<Self> {
        let value = self.value.as_object()?.get(key).filter(|value| !value.is_null())?;
        Some(Self { value, place: self.place_of(key) })
    }

    /// A member that must be there.
    pub(super) fn require(&self, key: &str) -> Checked<Self> {
        self.object()?;
        self.get(key).ok_or_else(|| self.fault_of(key, "is missing"))
    }

    /// `extensions.name`.
    pub(super) fn extension(&self, name: &str) -> Option<Self> {
        self.get("extensions")?.get(name)
    }

    /// The members that are not null, in alphabetical order.
    pub(super) fn members(&self) -> Checked<Vec<(&'a str, Self)>> {
        let map = self.object()?;
        Ok(map
            .iter()
            .filter(|(_, value)| !value.is_null())
            .map(|(key, value)| (key.as_str(), Self { value, place: self.place_of(key) }))
            .collect())
    }

    /// The elements of an array.
    pub(super) fn items(&self) -> Checked<Vec<Self>> {
        match self.value {
            Value::Array(items) => Ok(items
                .iter()
                .enumerate()
                .map(|(at, value)| Self { value, place: format!("{}/{at}", self.place) })
                .collect()),
            other => Err(self.fault(format!("expected an array, found {}", kind(other)))),
        }
    }

    /// The elements of a member that is an array; none when it is absent.
    pub(super) fn list(&self, key: &str) -> Checked<Vec<Self>> {
        self.get(key).map_or(Ok(Vec::new()), |member| member.items())
    }

    /// The value as text.
    pub(super) fn text(&self) -> Checked<&'a str> {
        self.value.as_str().ok_or_else(|| self.fault(format!("expected a string, found {}", kind(self.value))))
    }

    /// A text member.
    pub(super) fn text_of(&self, key: &str) -> Checked<Option<&'a str>> {
        self.get(key).map(|member| member.text()).transpose()
    }

    /// A member that is true or false; absent is false.
    pub(super) fn flag(&self, key: &str) -> Checked<bool> {
        self.get(key).map_or(Ok(false), |member| {
            member
                .value
                .as_bool()
                .ok_or_else(|| member.fault(format!("expected true or false, found {}", kind(member.value))))
        })
    }

    /// The value as a whole number that is not negative.
    pub(super) fn unsigned(&self) -> Checked<u64> {
        let whole = |number: f64| (number >= 0.0 && number.fract() == 0.0 && number < 9e15).then_some(number as u64);
        self.value.as_u64().or_else(|| self.value.as_f64().and_then(whole)).ok_or_else(|| {
            let found = if self.value.is_number() { self.value.to_string() } else { kind(self.value).into() };
            self.fault(format!("expected a whole number that is not negative, found {found}"))
        })
    }

    /// A member that is a whole number.
    pub(super) fn unsigned_of(&self, key: &str) -> Checked<Option<u64>> {
        self.get(key).map(|member| member.unsigned()).transpose()
    }

    /// A member that is a size or count in memory.
    pub(super) fn size_of(&self, key: &str) -> Checked<Option<usize>> {
        let Some(number) = self.unsigned_of(key)? else { return Ok(None) };
        usize::try_from(number)
            .map(Some)
            .map_err(|_| self.fault_of(key, format!("{number} is more than this machine can address")))
    }

    /// The value as a position in one of the file's lists.
    pub(super) fn index(&self, count: usize, what: &str) -> Checked<usize> {
        let number = self.unsigned()?;
        usize::try_from(number).ok().filter(|&index| index < count).ok_or_else(|| {
            self.fault(match count {
                0 => format!("{what} {number} does not exist: the file has none"),
                _ => format!("{what} {number} does not exist: the last is {}", count - 1),
            })
        })
    }

    /// A member that is a position in one of the file's lists.
    pub(super) fn index_of(&self, key: &str, count: usize, what: &str) -> Checked<Option<usize>> {
        self.get(key).map(|member| member.index(count, what)).transpose()
    }

    /// The value as a finite number.
    pub(super) fn number(&self) -> Checked<f32> {
        let Some(number) = self.value.as_f64() else {
            return Err(self.fault(format!("expected a number, found {}", kind(self.value))));
        };
        let number = number as f32;
        if number.is_finite() { Ok(number) } else { Err(self.fault("the number does not fit 32 bits")) }
    }

    /// A member that is a number.
    pub(super) fn number_of(&self, key: &str) -> Checked<Option<f32>> {
        self.get(key).map(|member| member.number()).transpose()
    }

    /// A member that is a number in a range.
    pub(super) fn number_in(&self, key: &str, low: f32, high: f32) -> Checked<Option<f32>> {
        let number = self.number_of(key)?;
        match number {
            Some(number) if !(low..=high).contains(&number) => {
                let range =
                    if high < f32::MAX { format!("from {low} to {high}") } else { format!("of at least {low}") };
                Err(self.fault_of(key, format!("expected a number {range}, found {number}")))
            }
            _ => Ok(number),
        }
    }

    /// A member that is a list of so many numbers.
    pub(super) fn numbers_of<const N: usize>(&self, key: &str) -> Checked<Option<[f32; N]>> {
        let Some(member) = self.get(key) else { return Ok(None) };
        let items = member.items()?;
        if items.len() != N {
            return Err(member.fault(format!("expected {N} numbers, found {}", items.len())));
        }
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(&items) {
            *number = item.number()?;
        }
        Ok(Some(numbers))
    }

    /// A member that is a list of numbers, of any length.
    pub(super) fn all_numbers_of(&self, key: &str) -> Checked<Option<Vec<f32>>> {
        let Some(member) = self.get(key) else { return Ok(None) };
        member.items()?.iter().map(Self::number).collect::<Checked<_>>().map(Some)
    }
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    }
}
