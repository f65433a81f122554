//! Structs whose fields have their defaults beside them.

/// Declares a struct with its default: each field may have a value after its type, and has the type's default otherwise.
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
