//! Settings of techniques whose look-ups filter a light's map: first a technique's own settings, then those that all such techniques share.

/// Declares such settings, as [`settings!`](crate::__settings) does.
#[macro_export]
#[doc(hidden)]
macro_rules! __map_settings {
    ($(#[$meta:meta])* $visibility:vis struct $name:ident { $($own:tt)* }) => {
        $crate::technique::settings::settings! {
            $(#[$meta])*
            $visibility struct $name {
                $($own)*
                /// How a look-up weighs the texels about a point.
                filter: $crate::maps::FilterKind = $crate::technique::settings::FILTER;
                /// Texels that the box and the Gaussian reach, 1 to 8; the Gaussian's standard deviation is half the
                /// radius.
                radius: u32 = $crate::technique::settings::RADIUS;
                /// How the meshes are drawn as a light sees them; none: compute passes on GPUs, the rasterizer
                /// elsewhere.
                opaque: Option<$crate::maps::OpaqueWay> = $crate::technique::settings::OPAQUE;
            }
            every {
                /// Casters and tiles that no look-up reads are left out.
                skip: bool = $crate::technique::settings::SKIP;
            }
        }

        impl $name {
            /// How look-ups average.
            pub(in $crate::technique) fn filter(&self) -> $crate::maps::Filter {
                $crate::maps::Filter { kind: self.filter, radius: self.radius }
            }
        }
    };
}

pub use crate::__map_settings as map_settings;
