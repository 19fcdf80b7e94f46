//! Mesh files in all formats, valid and damaged.

mod contents;
mod damage;
mod programs;
mod refusals;
mod sample_files;
