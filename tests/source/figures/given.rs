//! Numbers in the documents that nobody measures.

use Origin::{Choice, Code, Formula};
use std::fs;

/// A block of a document without a command, by some words of it.
pub struct Given {
    pub document: &'static str,
    pub words: &'static str,
    pub origin: Origin,
}

/// Where its numbers come from.
pub enum Origin {
    /// From the code: files, and what stands in them.
    Code(&'static [(&'static str, &'static str)]),
    /// From a formula beside them.
    Formula,
    /// They are what a reader or a scene may choose, or how often something is done.
    Choice,
}

impl Given {
    /// What the code does not have.
    pub fn fault(&self) -> Option<String> {
        let Origin::Code(constants) = self.origin else {
            return None;
        };
        let is_there = |(file, line): &&(&str, &str)| {
            let code = fs::read_to_string(super::root().join(file));
            code.is_ok_and(|code| code.contains(line))
        };
        let (file, line) = constants.iter().find(|constant| !is_there(constant))?;
        Some(format!("{}: {file} has no {line}", self.document))
    }
}

const fn given(document: &'static str, words: &'static str, origin: Origin) -> Given {
    Given {
        document,
        words,
        origin,
    }
}

const COINCIDENCE: (&str, &str) = (
    "src/narrow_phase/equilibrium.rs",
    "const COINCIDENCE: u32 = 13;",
);
const MARGIN: (&str, &str) = (
    "src/narrow_phase/equilibrium.rs",
    "const SNAP: f64 = 3e-14;",
);
const EQUAL_FIELDS: (&str, &str) = (
    "src/narrow_phase/equilibrium.rs",
    "const EQUAL_FIELDS: f64 = 1e-9;",
);
const THINNESS: (&str, &str) = (
    "src/mesh/triangle_checks.rs",
    "const THINNESS: f64 = 1e-12;",
);

pub const GIVEN: [Given; 19] = [
    given(
        "ARCHITECTURE.md",
        "at 2, 4 and 8 lanes",
        Code(&[("src/lanes/traits.rs", "/// How many lanes: 2, 4 or 8.")]),
    ),
    given(
        "README.md",
        "less than about 1e-9 of themselves",
        Code(&[EQUAL_FIELDS]),
    ),
    given(
        "README.md",
        "within 2.5e-10 of the bodies' size",
        Code(&[COINCIDENCE, MARGIN]),
    ),
    given(
        "docs/guide/1_pressure_fields.md",
        "a height below 1e-12",
        Code(&[THINNESS]),
    ),
    given("docs/guide/1_pressure_fields.md", "κ is 0.990·κ_A", Formula),
    given(
        "docs/guide/1_pressure_fields.md",
        "7 % too much at d = R/10",
        Formula,
    ),
    given(
        "docs/guide/1_pressure_fields.md",
        "100 times the modulus, a tenth of the step",
        Formula,
    ),
    given(
        "docs/guide/1_pressure_fields.md",
        "That is 14 ms and 10 ms",
        Formula,
    ),
    given(
        "docs/guide/2_contact.md",
        "within 2.5e-10 of the size",
        Code(&[COINCIDENCE, MARGIN]),
    ),
    given("docs/guide/3_dynamics.md", "allows 0.15 ms", Formula),
    given(
        "docs/guide/3_dynamics.md",
        "1 % at a tenth of the limit",
        Formula,
    ),
    given(
        "docs/guide/4_gradients.md",
        "1 ms is more than `World::largest_stable_step` allows",
        Choice,
    ),
    given(
        "docs/guide/4_gradients.md",
        "as many steps as fit into 256 MiB",
        Code(&[(
            "src/gradient/experiment.rs",
            "const MEMORY: usize = 256 << 20;",
        )]),
    ),
    given("docs/guide/6_time_steps.md", "with time steps of 5 ms", Choice),
    given("docs/guide/6_time_steps.md", "5 ms is a good start", Choice),
    given(
        "docs/guide/6_time_steps.md",
        "3e-4 for values and 2e-3 for slopes by default",
        Code(&[
            ("src/dynamics/accuracy.rs", "values: 3e-4,"),
            ("src/dynamics/accuracy.rs", "slopes: 2e-3,"),
        ]),
    ),
    given(
        "docs/python/cluster.md",
        "of 32 rollouts at most",
        Code(&[("python/python/hydroelastic/ray.py", "_LONGEST_PART = 32")]),
    ),
    given(
        "docs/python/cluster.md",
        "`max_retries` times (5)",
        Code(&[("python/python/hydroelastic/ray.py", "max_retries: int = 5")]),
    ),
    given("examples/rerun/README.md", "0.1 s after the throw", Choice),
];
