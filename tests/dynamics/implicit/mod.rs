//! Implicit steps. The tables in docs/measurements.md are printed by
//! `cargo test --test dynamics implicit:: -- --nocapture`, in longer forms with `--include-ignored`.

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
