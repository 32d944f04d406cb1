//! Settings of techniques whose look-ups filter a light's map: the technique's own settings first, then the shared ones.

/// Declares such settings in the same way as [`settings!`](crate::__settings).
#[macro_export]
#[doc(hidden)]
macro_rules! __map_settings {
    ($(#[$meta:meta])* $visibility:vis struct $name:ident { $($own:tt)* }) => {
        $crate::technique::settings::settings! {
            $(#[$meta])*
            $visibility struct $name {
                $($own)*
                /// How a look-up weighs the texels around a point.
                filter: $crate::maps::FilterKind = $crate::technique::settings::FILTER;
                /// Radius of the box and Gaussian filters in texels, 1 to 8. The standard deviation of the Gaussian is half the radius.
                radius: u32 = $crate::technique::settings::RADIUS;
                /// How the opaque maps are drawn. `None`: compute passes on GPUs, the rasterizer elsewhere.
                opaque: Option<$crate::maps::OpaqueWay> = $crate::technique::settings::OPAQUE;
            }
            every {
                /// Whether casters and tiles that no look-up reads are skipped.
                skip: bool = $crate::technique::settings::SKIP;
            }
        }

        impl $name {
            /// Returns the filter of look-ups.
            pub(in $crate::technique) fn filter(&self) -> $crate::maps::Filter {
                $crate::maps::Filter { kind: self.filter, radius: self.radius }
            }
        }
    };
}

pub use crate::__map_settings as map_settings;
