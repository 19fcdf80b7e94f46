//! The checker is tried on bad documents too.

use super::given::{Given, Origin};
use super::repository::Repository;
use super::{Document, root};
use std::sync::LazyLock;

static REPOSITORY: LazyLock<Repository> = LazyLock::new(|| Repository::new(root()));

fn violations_of(markdown: &str, given: &[Given]) -> Vec<String> {
    Document::new("x.md", markdown).violations(&REPOSITORY, given)
}

const TABLE: &str = "| scene | cost |\n|---|---|\n| ball | 3 |\n";

#[test]
fn figures_are_explained_by_commands_above_them_in_their_section() {
    let command = "By `cargo bench --bench contact`:";
    for explained in [
        format!("# A\n\n{command}\n\n{TABLE}\nIt takes 5 ms.\n"),
        format!("# A: `cargo bench --bench contact`\n{TABLE}"),
        format!("# A\n\n    cargo bench --bench contact    # minutes\n\n{TABLE}"),
        format!("# A\n```sh\ncargo bench --bench contact\n```\n```text\ntook 5 ms\n```\n{TABLE}"),
        "- It takes 5 ms (`RAYON_NUM_THREADS=1 cargo\n  bench --bench contact`).\n".to_owned(),
        "By `cargo run --example NAME`:\n\n| name | s |\n|---|---|\n| `stack` | 3 |\n| `settle` | 5 |\n".to_owned(),
    ] {
        assert_eq!(violations_of(&explained, &[]), [""; 0], "{explained}");
    }
    for unexplained in [
        format!("# A\n{TABLE}"),
        format!("# A\n{TABLE}\n{command}\n"),
        format!("# A\n{command}\n## B\n{TABLE}"),
        format!("# A\n- {command}\n\n{TABLE}"),
        format!("# A\nRun `cargo test`, `cargo build` and `cargo test --test contact`.\n\n{TABLE}"),
        format!("# A\nAs `cargo mutants --list` says:\n\n{TABLE}"),
        format!("# A\n```rust\n// cargo bench --bench contact\n```\n{TABLE}"),
        "- It takes 5 ms.\n- It takes 5 s (`cargo bench --bench contact`).\n".to_owned(),
        "It prints\n```text\n5 ms\n```\n".to_owned(),
    ] {
        let found = violations_of(&unexplained, &[]);
        assert!(
            found.len() == 1 && found[0].contains("names no command"),
            "{unexplained}: {found:?}"
        );
    }
    let line = violations_of(&format!("# A\n\n{TABLE}"), &[]);
    assert!(line[0].starts_with("x.md:3 has figures"), "{line:?}");
}

#[test]
fn commands_that_cannot_be_typed_are_found() {
    for (command, reason) in [
        ("cargo bench --bench contacts", "no bench is named contacts"),
        (
            "cargo bench --bench growth -- --fast",
            "the program does not know --fast",
        ),
        ("cargo test --test contacts", "no test is named contacts"),
        (
            "cargo test --test contact jacobian::x",
            "no test of contact is named jacobian::x",
        ),
        (
            "cargo test --test contact hostile::many",
            "all tests of contact named hostile::many are left out",
        ),
        (
            "cargo test --test contact jacobian:: -- --ignored",
            "all tests of contact named jacobian:: are left out",
        ),
        (
            "cargo test --test contact jacobian:: -- --all",
            "the test runner does not know --all",
        ),
        (
            "cargo test --test serde worlds",
            "serde needs the feature serde",
        ),
        (
            "cargo test --doc guide::costs",
            "no chapter of the guide is named guide::costs",
        ),
        ("cargo run --example stacks", "no example is named stacks"),
        (
            "cargo run --release --example stack -- --film x",
            "the program does not know --film",
        ),
        (
            "cargo +nightly fuzz run stp",
            "fuzz/fuzz_targets/stp.rs does not exist",
        ),
        (
            "cargo llvm-cov --summary-only --test contacts",
            "no test is named contacts",
        ),
        (
            "cargo mutants -f 'src/contacts/**'",
            "src/contacts/ does not exist",
        ),
        ("cargo time --release", "no such subcommand is known here"),
        ("cargo test --fast", "--fast is not known here"),
        (
            "python3 benches/peers/times.py",
            "benches/peers/times.py does not exist",
        ),
        (
            "python3 benches/peers/compare.py --fast",
            "the program does not know --fast",
        ),
        (
            "UNREAD=1 cargo bench --bench contact",
            "no program reads UNREAD",
        ),
        ("HOSTILES_FIRST=1", "no program reads HOSTILES_FIRST"),
    ] {
        let found = violations_of(&format!("`{command}`"), &[]);
        let expected = format!("x.md:1 names `{command}`: {reason}");
        assert!(
            found.len() == 1 && found[0].starts_with(&expected),
            "{found:?}"
        );
    }
    for possible in [
        "cargo test --release --test contact hostile::many -- --ignored --nocapture",
        "cargo test --test contact jacobian:: -- --include-ignored",
        "cargo test --all-features --test serde worlds",
        "cargo bench --bench growth -- --svg docs/growth.svg",
        "cargo bench --no-default-features --features vtk --bench peers_ours",
        "HOSTILE_FIRST=5 cargo test --release --test contact hostile::many -- --ignored",
        "cargo +nightly fuzz run stl -- -max_total_time=5",
        "pip install ./python",
    ] {
        assert_eq!(
            violations_of(&format!("`{possible}`"), &[]),
            [""; 0],
            "{possible}"
        );
    }
}

#[test]
fn numbers_that_nobody_measures_are_listed_once() {
    let listed = |words, origin| Given {
        document: "x.md",
        words,
        origin,
    };
    let text = "Steps of 5 ms are\na good start.\n";
    assert_eq!(
        violations_of(text, &[listed("5 ms are a good", Origin::Choice)]),
        [""; 0]
    );
    for stale in ["7 ms are", "start. "] {
        let found = violations_of(text, &[listed(stale, Origin::Choice)]);
        assert!(
            found
                .iter()
                .any(|message| message.contains("has not one block")),
            "{found:?}"
        );
    }
    let constants = [
        Origin::Code(&[("src/contact/plane_polygon.rs", "const SLIVER: f64 = 1e-9;")]),
        Origin::Code(&[("src/contact/plane_polygon.rs", "const SLIVER: f64 = 1e-8;")]),
    ];
    let [there, gone] = constants.map(|origin| listed("", origin).fault());
    assert_eq!(there, None);
    let expected = "x.md: src/contact/plane_polygon.rs has no const SLIVER: f64 = 1e-8;";
    assert_eq!(gone.as_deref(), Some(expected));
}
