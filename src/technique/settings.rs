//! Settings of techniques and consumers: structs with typed fields, each of which is a key of specs.

use super::keys::{Key, OneOf, Values, Word, check, word_of};
use crate::maps::{Filter, FilterKind, OpaqueWay};
use crate::world::World;
use crate::{Error, Result};

/// Word for values that the device, the scene or the technique decides.
pub const AUTO: &str = "auto";

/// Word for no file.
pub const NONE: &str = "none";

/// A field's values, its default, and its help text.
pub struct Setting<T> {
    /// The default.
    pub default: T,
    /// The default as written in specs.
    text: &'static str,
    values: Values,
    about: &'static str,
    with: Option<(&'static str, &'static str)>,
}

impl<T> Setting<T> {
    const fn new(default: T, text: &'static str, values: Values, about: &'static str) -> Self {
        Self { default, text, values, about, with: None }
    }

    /// Returns the key named `name`.
    pub const fn key(&self, name: &'static str) -> Key {
        Key { name, values: self.values, default: self.text, about: self.about, with: self.with }
    }
}

impl<T: Copy> Setting<T> {
    /// Restricts this setting to specs in which the other `key` has the value `word`.
    pub const fn with(self, key: &'static str, word: &'static str) -> Self {
        Self { with: Some((key, word)), ..self }
    }
}

impl<T: Word> Setting<T> {
    /// Creates a setting whose value is one of the words of `T`. Does not compile unless `default` is one of them.
    pub const fn word(default: &'static str, about: &'static str) -> Self {
        let mut at = 0;
        while !is_same(T::ALL[at].0, default) {
            at += 1;
        }
        Self::new(T::ALL[at].1, default, Values::OneOf(T::WORDS), about)
    }
}

impl<T: Word> Setting<Option<T>> {
    /// Creates a setting whose value is one of the words of `T`, or `auto`.
    pub const fn auto(about: &'static str) -> Self {
        Self::new(None, AUTO, Values::OneOf(T::WORDS), about)
    }
}

impl Setting<u32> {
    /// Creates a setting whose value is a whole number from `low` to `high`.
    pub const fn number(default: &'static str, low: u32, high: u32, about: &'static str) -> Self {
        Self::new(number(default), default, Values::Number(low, high), about)
    }

    /// Creates a setting whose value is a whole number from `low` to `high` that is divisible by `step`.
    pub const fn multiple(default: &'static str, [step, low, high]: [u32; 3], about: &'static str) -> Self {
        Self::new(number(default), default, Values::Multiple(step, low, high), about)
    }

    /// Creates a setting whose value is one of these numbers.
    pub const fn one_of(default: &'static str, numbers: OneOf, about: &'static str) -> Self {
        Self::new(number(default), default, Values::OneOf(numbers), about)
    }
}

impl Setting<Option<u32>> {
    /// Creates a setting whose value is a whole number from `low` to `high`, or `auto`.
    pub const fn auto_number(low: u32, high: u32, about: &'static str) -> Self {
        Self::new(None, AUTO, Values::Number(low, high), about)
    }
}

impl Setting<Option<String>> {
    /// Creates a setting whose value is `none` or the name of a file, which states the values of the keys `in_file`.
    pub const fn file(in_file: OneOf, about: &'static str) -> Self {
        Self::new(None, NONE, Values::Path(in_file), about)
    }
}

const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut at = 0;
    while at < a.len() && at < b.len() && a[at] == b[at] {
        at += 1;
    }
    at == a.len() && at == b.len()
}

/// Parses a default, which must consist of decimal digits.
const fn number(text: &str) -> u32 {
    let (mut number, mut at) = (0, 0);
    while at < text.len() {
        number = 10 * number + (text.as_bytes()[at] - b'0') as u32;
        at += 1;
    }
    number
}

/// A type that fields may have, with its conversion to and from the text of specs.
pub trait Field: Sized {
    /// Parses a value; `None` if the text denotes no value of the type.
    fn read(text: &str) -> Option<Self>;

    /// Returns the text of a value.
    fn text(&self) -> String;
}

impl<T: Word + PartialEq> Field for T {
    fn read(text: &str) -> Option<Self> {
        T::ALL.iter().find(|(word, _)| *word == text).map(|(_, value)| *value)
    }

    fn text(&self) -> String {
        word_of(*self).into()
    }
}

impl<T: Word + PartialEq> Field for Option<T> {
    fn read(text: &str) -> Option<Self> {
        if text == AUTO { Some(None) } else { T::read(text).map(Some) }
    }

    fn text(&self) -> String {
        self.map_or(AUTO, word_of).into()
    }
}

impl Field for u32 {
    fn read(text: &str) -> Option<Self> {
        text.parse().ok()
    }

    fn text(&self) -> String {
        self.to_string()
    }
}

impl Field for Option<u32> {
    fn read(text: &str) -> Option<Self> {
        if text == AUTO { Some(None) } else { u32::read(text).map(Some) }
    }

    fn text(&self) -> String {
        self.map_or(AUTO.into(), |number| number.to_string())
    }
}

impl Field for Option<String> {
    fn read(text: &str) -> Option<Self> {
        Some(Some(text.to_owned()).filter(|text| text != NONE))
    }

    fn text(&self) -> String {
        self.clone().unwrap_or(NONE.into())
    }
}

/// Settings whose fields are keys of specs, declared by [`settings!`](crate::__settings).
pub trait Keyed: Default {
    /// One key per field, in order, without the keys that every technique has.
    const KEYS: &'static [Key];

    /// Sets the field named `key`. Returns false if there is no such field, or if `text` is not one of its values.
    fn set(&mut self, key: &str, text: &str) -> bool;

    /// Returns the name and text of each field, in order.
    fn texts(&self) -> Vec<(&'static str, String)>;

    /// Checks that each field has an allowed value. Constructors call this, since settings may come from code instead of a spec.
    ///
    /// # Errors
    /// [`Error::Input`], naming the first field whose value is not allowed, and the allowed values.
    fn check(&self) -> Result<()> {
        for (key, text) in Self::KEYS.iter().zip(self.texts().into_iter().map(|(_, text)| text)) {
            check(key, &text).map_err(|known| Error::input(format!("{}={text}", key.name), "is not known", known))?;
        }
        Ok(())
    }
}

/// Declares the settings of a technique: a public struct with defaults, and for each field a key of specs with the field's name. The
/// [`Setting`] of a field defines its allowed values. Fields of `every` belong to keys that all techniques have.
#[macro_export]
#[doc(hidden)]
macro_rules! __settings {
    (
        $(#[$meta:meta])*
        $visibility:vis struct $name:ident { $($(#[$field_meta:meta])* $field:ident: $type:ty = $setting:expr;)+ }
        $(every { $($(#[$every_meta:meta])* $every:ident: $every_type:ty = $every_setting:expr;)+ })?
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, Eq)]
        $visibility struct $name {
            $($(#[$field_meta])* pub $field: $type,)+
            $($($(#[$every_meta])* pub $every: $every_type,)+)?
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    $($field: { const SETTING: $crate::technique::settings::Setting<$type> = $setting; SETTING.default },)+
                    $($($every: {
                        const SETTING: $crate::technique::settings::Setting<$every_type> = $every_setting;
                        SETTING.default
                    },)+)?
                }
            }
        }

        impl $crate::technique::settings::Keyed for $name {
            const KEYS: &'static [$crate::technique::keys::Key] = &[$({
                const SETTING: &$crate::technique::settings::Setting<$type> = &$setting;
                SETTING.key(stringify!($field))
            }),+];

            fn set(&mut self, key: &str, text: &str) -> bool {
                use $crate::technique::settings::Field;
                match key {
                    $(stringify!($field) => Field::read(text).map(|value| self.$field = value).is_some(),)+
                    $($(stringify!($every) => Field::read(text).map(|value| self.$every = value).is_some(),)+)?
                    _ => false,
                }
            }

            fn texts(&self) -> Vec<(&'static str, String)> {
                use $crate::technique::settings::Field;
                vec![
                    $((stringify!($field), Field::text(&self.$field)),)+
                    $($((stringify!($every), Field::text(&self.$every)),)+)?
                ]
            }
        }
    };
}

pub use crate::__settings as settings;

/// `size` of techniques whose maps may have any size.
pub const SIZE: Setting<u32> = Setting::number("256", 1, 16384, "texels per side of a light's map");

/// `levels`: number of levels of detail.
pub const LEVELS: Setting<u32> = Setting::number(
    "1",
    1,
    12,
    "levels of detail, the map itself among them, for pixels that are wider than its texels",
);

/// `filter`: how a look-up averages texels.
pub const FILTER: Setting<FilterKind> =
    Setting::word("bilinear", "how a look-up weighs texels: the nearest four, or all within a radius");

/// `radius`: how far the filter reaches.
pub const RADIUS: Setting<u32> =
    Setting::number("2", 1, 8, "texels that the box and the Gaussian reach; the Gaussian's deviation is half of it");

/// `filter` of opaque shadows: how many comparisons a look-up averages (Reeves, Salesin and Cook 1987).
pub const PCF: Setting<u32> = Setting::one_of(
    "1",
    &["1", "3", "5", "7", "9"],
    "texels per side of the square whose comparisons a look-up averages",
);

/// `opaque`: how the opaque maps are drawn.
pub const OPAQUE: Setting<Option<OpaqueWay>> = Setting::auto(
    "opaque maps are drawn by the device's rasterizer, or in compute, all maps at once; auto: compute on GPUs",
);

/// `skip`: whether unneeded work is skipped.
pub const SKIP: Setting<bool> =
    Setting::word("on", "leave out casters and tiles that no look-up misses, and builds where nothing has changed");

settings! {
    /// Settings of a technique that has maps and no settings of its own.
    #[derive(Copy)]
    pub struct MapSettings {
        /// Texels per side of a light's map, 1 to 16,384.
        size: u32 = SIZE;
        /// How a look-up weighs the texels around a point.
        filter: FilterKind = FILTER;
        /// Radius of the box and Gaussian filters in texels, 1 to 8. The standard deviation of the Gaussian is half the radius.
        radius: u32 = RADIUS;
        /// How the opaque maps are drawn. `None`: compute passes on GPUs, the rasterizer elsewhere.
        opaque: Option<OpaqueWay> = OPAQUE;
    }
}

impl MapSettings {
    /// Returns the filter of look-ups, after checking it against the maps of `world`.
    ///
    /// # Errors
    /// [`Error::Input`] if the filter does not fit into these maps, or a setting's value is not allowed.
    pub fn filter(&self, world: &World) -> Result<Filter> {
        self.check()?;
        let filter = Filter { kind: self.filter, radius: self.radius };
        filter.check(world, self.size)?;
        Ok(filter)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::technique::keys::{EVERY, Name};
    use crate::technique::{self as all, Entry, REGISTRY, Spec, parse};
    use proptest::prelude::*;
    use std::fmt::Debug;

    /// Returns texts that a key accepts: all its words, or numbers at both ends of its range and in between.
    fn known(key: &Key) -> Vec<String> {
        let default = key.default.to_owned();
        let more: Vec<String> = match key.values {
            Values::OneOf(words) => words.iter().map(|word| (*word).to_owned()).collect(),
            Values::Number(low, high) => [low, low + (high - low) / 3, high].map(|n| n.to_string()).to_vec(),
            Values::Multiple(step, low, high) => [low, low + step, high].map(|n| n.to_string()).to_vec(),
            Values::Path(_) => vec!["a=b:c.gobo".into()],
        };
        std::iter::once(default).chain(more).collect()
    }

    /// Asserts that specs and settings hold the same values: a text that is converted to settings and back stays the same, for each key
    /// alone and for all keys at once.
    pub(crate) fn goes_both_ways<S: Keyed + PartialEq + Debug>(entry: &'static Entry, more: &'static [Key]) {
        let again = |spec: &Spec| Spec::new(entry, more).with(&spec.settings::<S>());
        let default = Spec::new(entry, more);
        assert_eq!(default.settings::<S>(), S::default(), "{}", entry.name);
        assert_eq!(again(&default).to_string(), default.to_string());
        let has = |key: &&Key| S::default().texts().iter().any(|(name, _)| *name == key.name);
        let keys: Vec<_> = default.keys().filter(has).collect();
        assert!(S::KEYS.iter().all(|key| keys.iter().any(|known| known.name == key.name)), "{}", entry.name);
        for key in &keys {
            for value in known(key) {
                let with = key.with.map_or(String::new(), |(other, word)| format!(",{other}={word}"));
                let text = format!("{}:{}={value}{with}", entry.name, key.name);
                let spec = parse(&text, more).expect(&text).remove(0);
                spec.settings::<S>().check().expect(&text);
                assert_eq!(again(&spec).to_string(), spec.to_string(), "{text}");
                assert_eq!((again(&spec).short(), again(&spec).variant()), (spec.short(), spec.variant()), "{text}");
            }
        }
        let all: Vec<_> = keys.into_iter().map(|key| (*key, known(key))).collect();
        proptest!(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) }, |(
            picked in prop::collection::vec(any::<prop::sample::Index>(), all.len()),
        )| {
            let mut spec = default.clone();
            for ((key, values), index) in all.iter().zip(&picked).filter(|((key, _), _)| !matches!(key.values, Values::Path(_))) {
                spec.set(key, &values[index.index(values.len())]);
            }
            prop_assert_eq!(again(&spec).to_string(), spec.to_string());
            prop_assert_eq!(again(&spec).settings::<S>(), spec.settings::<S>());
        });
    }

    /// Runs the round trip between specs and settings for each technique.
    #[test]
    fn specs_and_settings_are_one() {
        let mut seen = vec![all::none::ENTRY.name];
        macro_rules! each {
            ($($module:ident),*) => { $(
                goes_both_ways::<all::$module::Settings>(&all::$module::ENTRY, &[]);
                seen.push(all::$module::ENTRY.name);
            )* };
        }
        each!(
            avsm,
            beer_shadow_map,
            deep_shadow_map,
            density_grid,
            fourier,
            grid_query,
            half_angle,
            ism,
            layers,
            marched,
            moments,
            optical_depth_grid,
            psm,
            ray_query,
            shadow_map,
            stochastic,
            translucency_map,
            uncompressed,
            voxel_grid,
            voxelized,
            wavelet
        );
        for entry in REGISTRY {
            assert!(seen.contains(&entry.name), "{} is not among these", entry.name);
            for key in entry.all_keys() {
                let names = |in_file: OneOf| in_file.iter().all(|name| entry.keys.iter().any(|key| key.name == *name));
                assert!(!matches!(key.values, Values::Path(in_file) if !names(in_file)), "{}", entry.name);
            }
        }
    }

    /// Asserts that each constant of [`Name`] names a key.
    #[test]
    fn names_are_keys() {
        let names =
            [Name::PATH, Name::SIZE, Name::GRID, Name::SLICES, Name::POINTS, Name::FILTER, Name::OPAQUE, Name::SKIP];
        for name in names {
            assert!(REGISTRY.iter().any(|e| e.all_keys().any(|key| Name::from(key) == name)), "{name:?}");
        }
        assert_eq!(EVERY.len(), 1);
    }

    /// Asserts that settings from code are checked like settings from specs.
    #[test]
    fn what_no_spec_says_is_refused() {
        use all::{avsm, psm, voxelized};
        let told = |result: Result<()>| result.expect_err("refused").to_string();
        let avsm = told(avsm::Settings { nodes: 5, ..Default::default() }.check());
        assert_eq!(avsm, "nodes=5: is not known; choose one of: 4, 8, 16");
        let none = told(avsm::Settings { capacity: Some(0), ..Default::default() }.check());
        assert_eq!(none, "capacity=0: is not known; give a whole number from 1 to 268435456, or auto");
        let slices = told(psm::Settings { slices: 6, ..Default::default() }.check());
        assert!(slices.contains("divisible by 4"), "{slices}");
        let file = told(voxelized::Settings { file: Some("a\nb".into()), ..Default::default() }.check());
        assert!(file.contains("the name of a file"), "{file}");
    }
}
