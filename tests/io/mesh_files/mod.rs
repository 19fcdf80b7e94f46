//! Mesh files in all formats, sound and damaged.

mod contents;
mod damage;
mod refusals;
mod sample_files;
