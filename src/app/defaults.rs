//! Structs with the defaults beside the fields.

/// Declares a struct with its default: a field may have a value after its type, or else has the default of the type.
macro_rules! with_defaults {
    ($(#[$of:meta])* pub struct $name:ident { $($(#[$one:meta])* pub $field:ident: $type:ty $(= $value:expr)?,)+ }) => {
        $(#[$of])*
        pub struct $name {
            $($(#[$one])* pub $field: $type),+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $crate::app::defaults::with_defaults!(@ $($value)?)),+ }
            }
        }
    };
    (@) => { Default::default() };
    (@ $value:expr) => { $value };
}
pub(in crate::app) use with_defaults;
