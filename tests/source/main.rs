//! The source itself: its rooms, and the Rust version it promises.

mod architecture;
mod circles;
mod figures;
mod rust_version;
