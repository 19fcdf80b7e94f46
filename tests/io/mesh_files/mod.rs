//! Mesh files in all formats, valid and damaged.

mod contents;
mod damage;
mod refusals;
mod sample_files;
