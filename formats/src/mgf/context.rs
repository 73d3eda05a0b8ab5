//! Named and unnamed contexts: the state that `c`, `m` and `v` open and that later entities change or use.

use super::source::Entity;
use crate::error::{FormatError, quote, suggestion};
use glam::DVec3;
use std::collections::HashMap;

/// All contexts of one kind. The unnamed one sits at index 0.
pub(super) struct Contexts<T> {
    kind: &'static str,
    indices: HashMap<String, usize>,
    names: Vec<String>,
    values: Vec<T>,
    current: usize,
    revision: u64,
}

impl<T: Clone + Default> Contexts<T> {
    /// Nothing but the unnamed context; `kind` is for messages.
    pub(super) fn new(kind: &'static str) -> Self {
        Self {
            kind,
            indices: HashMap::new(),
            names: vec![String::new()],
            values: vec![T::default()],
            current: 0,
            revision: 0,
        }
    }

    /// `m`, `m name`, `m name =`, `m name = template`.
    pub(super) fn open(&mut self, entity: Entity<'_>) -> Result<(), FormatError> {
        let arguments = entity.arguments();
        let value = match arguments {
            [] => {
                self.current = 0;
                self.revision += 1;
                self.values[0] = T::default();
                return Ok(());
            }
            [name] => {
                self.current = self.find(entity, name)?;
                return Ok(());
            }
            [_, equals] if equals == "=" => T::default(),
            [_, equals, template] if equals == "=" => {
                self.values[self.find(entity, template)?].clone()
            }
            _ => {
                let keyword = entity.keyword();
                return Err(entity.fault(format!(
                    "expected '{keyword}', '{keyword} name' or '{keyword} name = [template]', found {} arguments{}",
                    arguments.len(),
                    if arguments[1] == "=" { "" } else { " and no '=' after the name" },
                )));
            }
        };
        let name = &arguments[0];
        self.revision += 1;
        self.current = if let Some(&index) = self.indices.get(name) {
            self.values[index] = value;
            index
        } else {
            self.names.push(name.clone());
            self.values.push(value);
            self.indices.insert(name.clone(), self.values.len() - 1);
            self.values.len() - 1
        };
        Ok(())
    }

    /// The value that `name` stands for.
    pub(super) fn get(&self, entity: Entity<'_>, name: &str) -> Result<&T, FormatError> {
        Ok(&self.values[self.find(entity, name)?])
    }

    pub(super) fn current(&self) -> &T {
        &self.values[self.current]
    }

    pub(super) fn current_mut(&mut self) -> &mut T {
        self.revision += 1;
        &mut self.values[self.current]
    }

    /// `None` in the unnamed context.
    pub(super) fn current_name(&self) -> Option<&str> {
        (self.current > 0).then(|| self.names[self.current].as_str())
    }

    /// Differs whenever the current context may hold something else than before.
    pub(super) fn state(&self) -> (usize, u64) {
        (self.current, self.revision)
    }

    fn find(&self, entity: Entity<'_>, name: &str) -> Result<usize, FormatError> {
        self.indices.get(name).copied().ok_or_else(|| {
            // Between names of one or two letters everything is near.
            let known = self.names.iter().skip(1).map(String::as_str);
            let near = if name.len() > 2 {
                suggestion(name, known)
            } else {
                String::new()
            };
            let (keyword, kind, name) = (entity.keyword(), self.kind, quote(name));
            entity.fault(format!(
                "{keyword}: {kind} {name} is not defined above this line{near}"
            ))
        })
    }
}

/// What `v` holds. Transforms apply where the vertex is used, not where it is defined.
#[derive(Clone, Copy, Default)]
pub(super) struct Vertex {
    pub(super) position: DVec3,
    /// Unit.
    pub(super) normal: Option<DVec3>,
}

impl Vertex {
    /// `p x y z` and `n dx dy dz`; a normal of zero takes the normal away.
    pub(super) fn set(&mut self, entity: Entity<'_>) -> Result<(), FormatError> {
        let is_point = entity.keyword() == "p";
        entity.expect_count(3, if is_point { "p x y z" } else { "n dx dy dz" })?;
        let value = DVec3::new(
            entity.number(0, "x")?,
            entity.number(1, "y")?,
            entity.number(2, "z")?,
        );
        if is_point {
            self.position = value;
        } else {
            // Divided first, so that no square overflows.
            self.normal = (value / value.abs().max_element()).try_normalize();
        }
        Ok(())
    }
}
