//! Specialization constants by name. build.rs assigns each name one id for all shaders: see [`crate::shaders::constant`].

use std::collections::BTreeMap;
use std::marker::PhantomData;

/// A specialization constant of type `T`.
pub struct Constant<T> {
    id: u32,
    value: PhantomData<T>,
}

impl<T> Constant<T> {
    /// Creates the constant with this id.
    pub const fn new(id: u32) -> Self {
        Self { id, value: PhantomData }
    }

    /// Returns the constant's id in the program's shaders.
    pub const fn id(&self) -> u32 {
        self.id
    }
}

/// Types that a specialization constant can have, all of four bytes.
pub trait ConstantValue {
    /// Returns the value as a word, as Vulkan takes it.
    fn word(self) -> u32;
}

impl ConstantValue for u32 {
    fn word(self) -> u32 {
        self
    }
}

impl ConstantValue for bool {
    fn word(self) -> u32 {
        self.into()
    }
}

impl ConstantValue for f32 {
    fn word(self) -> u32 {
        self.to_bits()
    }
}

/// Values of specialization constants. A constant that is not set keeps the shader's default; one that a shader does
/// not declare is ignored.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Constants(BTreeMap<u32, u32>);

impl Constants {
    /// Creates a set of values in which no constant is set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the same values, with `constant` set to `value`.
    pub fn set<T: ConstantValue>(mut self, constant: Constant<T>, value: T) -> Self {
        self.0.insert(constant.id, value.word());
        self
    }

    /// Returns the values of both; `others` win.
    pub fn and(mut self, others: &Self) -> Self {
        self.0.extend(&others.0);
        self
    }

    /// Returns the value of the constant with this id, as Vulkan takes it; `None` if it is not set.
    pub fn word(&self, id: u32) -> Option<u32> {
        self.0.get(&id).copied()
    }

    /// Returns the ids, and their values in the same order.
    pub(in crate::gpu) fn ids_and_words(&self) -> (Vec<u32>, Vec<u32>) {
        self.0.iter().unzip()
    }
}
