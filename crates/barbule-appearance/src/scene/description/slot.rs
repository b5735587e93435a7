//! What descriptions name and do not hold: files, and materials.

use std::sync::Arc;

use crate::fields::{FieldValue, Kind, Text, Value, wrong_kind};
use crate::identity::Hasher;
use crate::{Error, Result};

/// A name, and what it stands for once that is read. Equal where the names and what was read are.
#[derive(Debug)]
pub struct Slot<T> {
    /// The name: a file's as seen from the scene's folder, a material's.
    pub name: String,
    content: Option<Content<T>>,
}

#[derive(Debug)]
struct Content<T> {
    value: Arc<T>,
    hash: String,
}

impl<T> Slot<T> {
    /// A name whose content nobody has read.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), content: None }
    }

    /// What the name stands for.
    ///
    /// # Errors
    /// It is not read; never in a [`ReadyScene`](super::ReadyScene).
    pub fn value(&self) -> Result<&Arc<T>> {
        let unread = || Error::input(format!("'{}' is not read", crate::error::shortened(&self.name)));
        self.content.as_ref().map(|content| &content.value).ok_or_else(unread)
    }

    /// What the name stands for, if it is read.
    #[must_use]
    pub fn get(&self) -> Option<&T> {
        self.content.as_ref().map(|content| &*content.value)
    }

    /// BLAKE3 of what was read; empty before.
    #[must_use]
    pub fn hash(&self) -> &str {
        self.content.as_ref().map_or("", |content| &content.hash)
    }

    /// Whether it is read.
    #[must_use]
    pub fn is_read(&self) -> bool {
        self.content.is_some()
    }

    /// Says what the name stands for; `hash` is BLAKE3 of what was read.
    pub fn fill(&mut self, value: impl Into<Arc<T>>, hash: String) {
        self.content = Some(Content { value: value.into(), hash });
    }
}

impl<T> Clone for Slot<T> {
    fn clone(&self) -> Self {
        let content = self.content.as_ref().map(|c| Content { value: c.value.clone(), hash: c.hash.clone() });
        Self { name: self.name.clone(), content }
    }
}

impl<T> PartialEq for Slot<T> {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.hash() == other.hash()
    }
}

impl<T> FieldValue for Slot<T> {
    type Limits = Text;

    fn of_value(value: &Value, path: &str, _: &Text) -> Result<Self> {
        value.as_str().map(Self::new).ok_or_else(|| wrong_kind(value, path, "a text in quotes"))
    }

    fn to_value(&self, _: &Text) -> Option<Value> {
        Some(self.name.as_str().into())
    }

    fn check_value(&self, _: &str, _: &Text) -> Result<()> {
        Ok(())
    }

    /// What was read, whatever it is called; the name alone where nothing was.
    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.text(key, if self.is_read() { self.hash() } else { &self.name });
    }

    fn kind(limits: &Text) -> Kind {
        Kind::Text(limits.0)
    }
}
