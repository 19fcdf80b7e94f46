//! The source itself: its rooms, and the Rust version it promises.

mod architecture;
mod rust_version;
