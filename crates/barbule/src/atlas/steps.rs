//! Lists, steps and spans of numbers as plans write them.

use barbule_base::record;

use crate::error::shortened;
use crate::fields::{FieldValue, Kind, Record as _, Value, list, number, within, wrong_kind};
use crate::identity::Hasher;
use crate::math::steps::{decimal, stepped, steps_between};
use crate::{Error, Result};

/// Values along one axis, at most.
const MOST_STEPS: usize = 100_000;

record! {
    /// So many values from one end to the other, both included.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Counted {
        /// The first value.
        low: f64 = "low", within(-1e9, 1e9);
        /// The last value.
        high: f64 = "high", within(-1e9, 1e9);
        /// How many values.
        count: usize = "count", within(1, 100_000);
    }
}

/// Numbers along an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Steps {
    /// These.
    List(Vec<f64>),
    /// From the first to the second in steps of the third, both ends included where steps lead there.
    Stepped([f64; 3]),
    /// Anything between; what is drawn needs no more.
    Span([f64; 2]),
    /// So many, at equal distances.
    Counted(Counted),
}

impl Steps {
    /// Reads `low:high:step` or `low:high`.
    fn parse(text: &str, path: &str) -> Result<Self> {
        let numbers: Option<Vec<f64>> =
            text.split(':').map(|part| part.trim().parse().ok().filter(|v: &f64| v.is_finite())).collect();
        match numbers.as_deref() {
            Some(&[low, high, step]) => Ok(Self::Stepped([low, high, step])),
            Some(&[low, high]) => Ok(Self::Span([low, high])),
            _ => Err(Error::input(format!(
                "{path} is '{}'; write \"low:high:step\", \"low:high\" where `samples` draw, a list, or {{ low = …, high = …, count = … }}",
                shortened(text)
            ))
            .about(path)),
        }
    }

    /// The values; `path` is the key's.
    ///
    /// # Errors
    /// There are none, too many, one twice, a step that does not lead from end to end, or a span, which has no values of its own.
    pub fn values(&self, path: &str) -> Result<Vec<f64>> {
        let refuse = |what: String| Err(Error::input(format!("{path} {what}")).about(path));
        let values = match self {
            Self::List(values) => values.clone(),
            Self::Span([low, high]) => {
                return refuse(format!(
                    "is {low}:{high}, which says no values; give a step, as in \"{low}:{high}:{}\", or draw `samples`",
                    decimal(0.1 * (high - low).abs())
                ));
            }
            Self::Stepped([low, high, step]) => {
                let Some(count) = steps_between(*low, *high, *step) else {
                    return refuse(format!("has steps of {step}, which do not lead from {low} to {high}"));
                };
                if count >= MOST_STEPS as f64 {
                    return refuse(format!("has over {MOST_STEPS} values; give a larger step"));
                }
                stepped(*low, *step, count).collect()
            }
            Self::Counted(Counted { low, count: 1, .. }) => vec![*low],
            Self::Counted(Counted { low, high, count }) => {
                let part = |i: usize| i as f64 / (count - 1) as f64;
                (0..*count).map(|i| decimal(low + part(i) * (high - low))).collect()
            }
        };
        if values.is_empty() || values.len() > MOST_STEPS {
            return refuse(format!("has {} values; give 1 to {MOST_STEPS}", values.len()));
        }
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        if let Some(twice) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            return refuse(format!("has {} twice; give each value once", twice[0]));
        }
        Ok(values)
    }

    /// The value that a number from 0 to 1 stands for: between the ends, or of a list the one at that part of it.
    ///
    /// # Errors
    /// As [`Self::values`] where there are values; ends that are not two.
    pub fn drawn(&self, part: f64, path: &str) -> Result<f64> {
        let between = |low: f64, high: f64| Ok(low + part * (high - low));
        match self {
            Self::Span([low, high])
            | Self::Stepped([low, high, _])
            | Self::Counted(Counted { low, high, .. }) => {
                if low < high {
                    return between(*low, *high);
                }
                Err(Error::input(format!("{path} ends at {high}, but must end above {low}, where it begins"))
                    .about(path))
            }
            Self::List(_) => {
                let values = self.values(path)?;
                let at = (part * values.len() as f64) as usize;
                Ok(values[at.min(values.len() - 1)])
            }
        }
    }
}

impl FieldValue for Steps {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        match value {
            Value::String(text) => Self::parse(text, path),
            Value::Object(_) => Counted::read(value, path).map(Self::Counted),
            Value::Array(_) => {
                let values = list(value, path)?.iter().enumerate();
                let read = values.map(|(i, value)| number(value, &format!("{path}[{i}]")));
                read.collect::<Result<_>>().map(Self::List)
            }
            Value::Number(_) => Ok(Self::List(vec![number(value, path)?])),
            _ => Err(wrong_kind(
                value,
                path,
                "a number, a list of them, \"low:high:step\", or a table of low, high and count",
            )),
        }
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        let text = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(":");
        Some(match self {
            Self::List(values) => values.clone().into(),
            Self::Stepped(numbers) => text(numbers).into(),
            Self::Span(numbers) => text(numbers).into(),
            Self::Counted(counted) => counted.table(),
        })
    }

    fn check_value(&self, _: &str, (): &()) -> Result<()> {
        Ok(())
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        let (kind, numbers) = match self {
            Self::List(values) => ("list", values.clone()),
            Self::Stepped(numbers) => ("stepped", numbers.to_vec()),
            Self::Span(numbers) => ("span", numbers.to_vec()),
            Self::Counted(Counted { low, high, count }) => ("counted", vec![*low, *high, *count as f64]),
        };
        to.text(key, kind).numbers("values", &numbers);
    }

    fn kind((): &()) -> Kind {
        let numbers = Kind::Number { low: -1e9, high: 1e9, whole: false };
        Kind::Either(vec![
            Kind::List { of: Box::new(numbers), least: 1, most: MOST_STEPS },
            Kind::Text("\"low:high:step\", or \"low:high\" where samples draw"),
            Kind::Table(Counted::keys()),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn read(value: Value) -> Result<Steps> {
        Steps::of_value(&value, "vary[0].values", &())
    }

    #[test]
    fn lists_steps_and_counts_are_the_same_numbers() {
        let values = |value: Value| read(value).unwrap().values("x").unwrap();
        let expected = [0.1, 0.2, 0.3, 0.4];
        assert_eq!(values(json!("0.1:0.4:0.1")), expected);
        assert_eq!(values(json!([0.1, 0.2, 0.3, 0.4])), expected);
        assert_eq!(values(json!({"low": 0.1, "high": 0.4, "count": 4})), expected);
        assert_eq!(values(json!("3:1:-1")), [3.0, 2.0, 1.0]);
        assert_eq!(values(json!(5)), [5.0]);
        for text in ["0.1:0.4:0.1", "0.1:0.4"] {
            assert_eq!(read(json!(text)).unwrap().to_value(&()), Some(json!(text)));
        }
    }

    #[test]
    fn draws_lie_between_the_ends_or_in_the_list() {
        let drawn = |value: Value, part| read(value).unwrap().drawn(part, "x").unwrap();
        assert_eq!(drawn(json!("1:3"), 0.25), 1.5);
        assert_eq!(drawn(json!([4, 5, 6]), 0.999), 6.0);
        assert_eq!(drawn(json!([4, 5, 6]), 0.0), 4.0);
        assert!(read(json!("3:1")).unwrap().drawn(0.5, "x").is_err());
    }

    #[test]
    fn what_is_no_axis_is_refused_with_a_remedy() {
        let message = |value: Value| {
            let found = read(value).and_then(|steps| steps.values("vary[0].values"));
            found.unwrap_err().to_string()
        };
        for (value, part) in [
            (json!("0.1:0.4"), "which says no values; give a step, as in \"0.1:0.4:0.03\""),
            (json!("1:2:0"), "steps of 0, which do not lead from 1 to 2"),
            (json!("1:2:-1"), "do not lead"),
            (json!("0:1:1e-9"), "has over 100000 values"),
            (json!("a:b"), "is 'a:b'; write \"low:high:step\""),
            (json!([1, 2, 1]), "has 1 twice"),
            (json!([]), "has 0 values; give 1 to 100000"),
            (json!(["a"]), "vary[0].values[0] is the text 'a', but must be a number"),
            (json!(true), "is true, but must be a number, a list"),
            (json!({"low": 1, "high": 2}), "vary[0].values.count is missing"),
        ] {
            let text = message(value);
            assert!(text.starts_with("vary[0].values") && text.contains(part), "{text}");
        }
    }
}
