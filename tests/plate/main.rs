//! The plate stage: fields, maps, filters and meanings.

mod map;
