//! Named arrays of plain numbers: what tables are given as and put together from.

use std::borrow::Cow;

use crate::{Error, Result};

/// Numbers in the precision in which they are evaluated.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers<'a> {
    /// 64 bits.
    F64(Cow<'a, [f64]>),
    /// 32 bits.
    F32(Cow<'a, [f32]>),
    /// 16 bits.
    I16(Cow<'a, [i16]>),
}

/// An array by its name, rows first.
#[derive(Debug, Clone, PartialEq)]
pub struct TableArray<'a> {
    /// As `docs/formats/brdf-tables.md` has it.
    pub name: String,
    /// Lengths of its axes; the last one runs fastest.
    pub shape: Vec<usize>,
    /// As many as the shape says.
    pub numbers: Numbers<'a>,
}

/// Numbers of one type.
pub(super) trait Number: Copy + PartialOrd + Into<f64> + 'static {
    /// What messages call the type.
    const NAME: &'static str;

    fn of<'a>(numbers: &'a Numbers<'_>) -> Option<&'a [Self]>;

    fn borrowed(numbers: &[Self]) -> Numbers<'_>;
}

macro_rules! number {
    ($type:ty, $variant:ident) => {
        impl Number for $type {
            const NAME: &'static str = stringify!($variant);

            fn of<'a>(numbers: &'a Numbers<'_>) -> Option<&'a [Self]> {
                match numbers {
                    Numbers::$variant(values) => Some(values),
                    _ => None,
                }
            }

            fn borrowed(numbers: &[Self]) -> Numbers<'_> {
                Numbers::$variant(Cow::Borrowed(numbers))
            }
        }
    };
}

number!(f64, F64);
number!(f32, F32);
number!(i16, I16);

impl<'a> TableArray<'a> {
    pub(super) fn new<T: Number>(name: impl Into<String>, shape: &[usize], numbers: &'a [T]) -> Self {
        Self { name: name.into(), shape: shape.to_vec(), numbers: T::borrowed(numbers) }
    }
}

/// Arrays from which tables are put together.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrays<'a> {
    all: &'a [TableArray<'a>],
}

impl<'a> Arrays<'a> {
    pub(super) fn new(all: &'a [TableArray<'a>]) -> Self {
        Self { all }
    }

    /// An array of this type and shape, each number in its range; ranges follow each other along the last axis.
    pub(super) fn get<T: Number>(self, name: &str, shape: &[usize], ranges: &[[f64; 2]]) -> Result<&'a [T]> {
        let array = self.all.iter().find(|array| array.name == name).ok_or_else(|| {
            Error::input(format!("array {name} is missing; make the tables again from the material"))
        })?;
        let numbers = T::of(&array.numbers)
            .ok_or_else(|| Error::input(format!("array {name} has another type than {}", T::NAME)))?;
        if array.shape != shape || numbers.len() != shape.iter().product::<usize>() {
            return Err(Error::input(format!(
                "array {name} has {} numbers and not the shape {shape:?} that the header asks for",
                numbers.len()
            )));
        }
        let wrong = |(at, value): (usize, &T)| {
            let [low, high] = ranges[at % ranges.len()];
            let value: f64 = (*value).into();
            !(low <= value && value <= high)
        };
        match numbers.iter().enumerate().position(wrong) {
            None => Ok(numbers),
            Some(at) => {
                let ([low, high], value) = (ranges[at % ranges.len()], numbers[at].into());
                Err(Error::input(format!(
                    "{name}[{at}] = {value} is not in {low} to {high}; make the tables again from the material"
                )))
            }
        }
    }

    /// The same of an axis, which rises.
    pub(super) fn rising(self, name: &str, count: usize, range: [f64; 2]) -> Result<&'a [f64]> {
        let places = self.get::<f64>(name, &[count], &[range])?;
        match places.windows(2).position(|pair| pair[0] >= pair[1]) {
            None => Ok(places),
            Some(at) => Err(Error::input(format!("{name}[{}] does not exceed the value before it", at + 1))),
        }
    }
}
