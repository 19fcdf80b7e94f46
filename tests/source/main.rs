//! Checks of the sources and the documents: architecture, Rust version, commands, links and claims.

mod architecture;
mod circles;
mod claims;
mod commands;
mod documents;
mod repository;
mod rust_version;
