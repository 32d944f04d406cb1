//! Specialization constants by name. build.rs gives each name one id in all shaders: see [`crate::shaders::constant`].

use std::collections::BTreeMap;
use std::marker::PhantomData;

/// A specialization constant whose values are `T`.
pub struct Constant<T> {
    id: u32,
    value: PhantomData<T>,
}

impl<T> Constant<T> {
    /// The constant of that id.
    pub const fn new(id: u32) -> Self {
        Self { id, value: PhantomData }
    }

    /// Its id in the shaders of the program.
    pub const fn id(&self) -> u32 {
        self.id
    }
}

/// Types of specialization constants: four bytes.
pub trait ConstantValue {
    /// The value as a word, as Vulkan takes it.
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
    /// No constant is set.
    pub fn new() -> Self {
        Self::default()
    }

    /// The same values, with `constant` set to `value`.
    pub fn set<T: ConstantValue>(mut self, constant: Constant<T>, value: T) -> Self {
        self.0.insert(constant.id, value.word());
        self
    }

    /// The value of the constant of that id, as Vulkan takes it; none where it is not set.
    pub fn word(&self, id: u32) -> Option<u32> {
        self.0.get(&id).copied()
    }

    /// Ids, and their values in the same order.
    pub(in crate::gpu) fn ids_and_words(&self) -> (Vec<u32>, Vec<u32>) {
        self.0.iter().unzip()
    }
}
