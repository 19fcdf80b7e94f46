//! Implicit steps. To print the tables in docs/measurements.md, run `cargo test --test dynamics implicit:: -- --nocapture`, and for longer
//! forms add `--include-ignored`.

mod conservation;
mod derivatives;
mod energy;
mod falls;
mod flat_falls;
mod forces;
mod grasp;
mod hostile;
mod islands;
mod order;
mod scenes;
mod slopes;
mod stacks;
mod throws;
mod tunneling;
