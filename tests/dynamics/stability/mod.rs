//! The largest stable time step against closed forms, against the eigenvalues of a step, and against rollouts that blow up just above it
//! and not just below.

mod blow_ups;
mod closed_forms;
mod eigenvalues;
mod energy_balance;
mod scenes;
mod step_checks;
mod stiffest_contact;
