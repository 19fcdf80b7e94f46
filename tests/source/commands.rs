//! Commands in documents and comments can be typed: their targets, tests, scripts, features and flags exist.

use super::documents::{Document, comments, markdown, root};
use super::repository::Repository;
use std::fs;

/// Placeholder for a name in a command.
const PLACEHOLDER: &str = "NAME";

#[test]
fn commands_can_be_typed() {
    let repository = Repository::new(root());
    let (mut wrong, mut count) = (Vec::new(), 0);
    for document in markdown().iter().chain(&comments()) {
        for (line, command) in document.commands() {
            let Some(verdict) = repository.verdict(&command) else {
                continue;
            };
            count += 1;
            if let Err(reason) = verdict
                && !command.contains(PLACEHOLDER)
            {
                wrong.push(format!(
                    "{}:{line} names `{command}`: {reason}",
                    document.path
                ));
            }
        }
    }
    assert!(count > 100, "{count} commands");
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

#[test]
fn commands_with_unknown_features_or_tests_that_do_not_run_are_refused() {
    let repository = Repository::new(root());
    for (command, reason) in [
        ("cargo build --features=urdf,vkt", "feature vkt"),
        ("cargo test --features vkt --test search", "feature vkt"),
        (
            "cargo clippy -p hydroelastic-examples --features urdf",
            "feature urdf",
        ),
        // A helper function, an ignored test, and a test that is not ignored.
        ("cargo test --test source without_comment", "no test"),
        ("cargo test --test memory million", "no test"),
        (
            "cargo test --test source commands:: -- --ignored",
            "no test",
        ),
    ] {
        let refusal = repository.verdict(command).unwrap().unwrap_err();
        assert!(refusal.contains(reason), "{command}: {refusal}");
    }
    for command in [
        "cargo build --features=urdf,parry",
        "cargo test --features urdf --test source commands::",
        "cargo test --test memory million -- --ignored",
        "cargo test --test memory million -- --include-ignored",
        "cargo test --features argmin --test argmin",
    ] {
        repository.verdict(command).unwrap().unwrap();
    }
}

/// The module comment of a bench names its cargo command, or the script that runs the bench.
#[test]
fn every_bench_names_its_own_command() {
    let (repository, comments) = (Repository::new(root()), comments());
    assert!(repository.benches().count() > 5);
    for (name, source) in repository.benches() {
        let path = source.strip_prefix(root()).unwrap().to_str().unwrap();
        let is_own = |document: &&Document| document.path == path;
        let head = comments.iter().find(is_own).unwrap();
        let command = format!("cargo bench --bench {name}");
        let runs_it = |(_, span): &(usize, String)| {
            let script = fs::read_to_string(source.with_file_name(span));
            span.contains(&command)
                || script.is_ok_and(|text| text.contains(&format!("\"{name}\"")))
        };
        assert!(
            head.commands().iter().any(runs_it),
            "{path} names no command that runs it"
        );
    }
}
