//! Figures in documents refer to rows of `docs/claims.md`. Every reference has a row, every row has a command, and every relative link
//! of every document has a target.

use super::documents::{Document, markdown, root};
use super::repository::Repository;
use std::collections::BTreeSet;
use std::fs;

const CLAIMS: &str = "docs/claims.md";

/// Returns the cells of the rows in the tables of `docs/claims.md` that begin with an id, for example `c4`.
fn rows(claims: &str) -> Vec<Vec<&str>> {
    let cells = |line| str::split(line, '|').map(str::trim).collect::<Vec<_>>();
    let rows = claims
        .lines()
        .filter(|line| line.starts_with('|'))
        .map(cells);
    rows.filter(|row| row.get(1).is_some_and(|cell| is_id(cell)))
        .collect()
}

fn is_id(text: &str) -> bool {
    let number = text.strip_prefix('c');
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
}

/// Yields ids in brackets, for example `[c4]`.
fn references(text: &str) -> impl Iterator<Item = &str> {
    let brackets = text
        .split('[')
        .skip(1)
        .filter_map(|rest| rest.split_once(']'));
    brackets
        .map(|(inner, _)| inner)
        .filter(|inner| is_id(inner))
}

#[test]
fn every_claim_has_a_value_and_a_command() {
    let (repository, claims) = (Repository::new(root()), read(CLAIMS));
    let rows = rows(&claims);
    assert!(rows.len() >= 15, "{} rows", rows.len());
    for row in rows {
        let [_, id, claim, value, command, ..] = row[..] else {
            panic!("{row:?} has not enough cells");
        };
        assert!(!claim.is_empty() && !value.is_empty(), "{id} is incomplete");
        let command = command.trim_matches('`');
        match repository.verdict(command) {
            Some(Ok(())) => {}
            Some(Err(reason)) => panic!("{id}: `{command}`: {reason}"),
            None => panic!("{id}: `{command}` is not a command"),
        }
    }
}

#[test]
fn every_reference_to_a_claim_has_a_row() {
    let claims = read(CLAIMS);
    let ids: BTreeSet<&str> = rows(&claims).into_iter().map(|row| row[1]).collect();
    let mut count = 0;
    for Document { path, text } in markdown() {
        for id in references(&text) {
            assert!(
                ids.contains(id),
                "{path} refers to {id}, which {CLAIMS} does not have"
            );
            count += 1;
        }
    }
    assert!(count >= 10, "{count} references");
}

#[test]
fn every_relative_link_has_a_target() {
    let documents = markdown();
    let anchors_of = |path: &str| {
        let mut documents = documents.iter();
        documents
            .find(|document| document.path == path)
            .map(Document::anchors)
    };
    let (mut missing, mut count) = (Vec::new(), 0);
    for document in &documents {
        for (line, link) in document.links() {
            // rustdoc checks the guide's links to items.
            if link.contains("://") || link.contains("::") || link.starts_with("mailto:") {
                continue;
            }
            count += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() {
                document.path.clone()
            } else {
                resolved(&document.path, file)
            };
            let exists = root().join(&target).exists();
            let has_anchor = anchor.is_empty()
                || anchors_of(&target)
                    .is_none_or(|anchors| anchors.iter().any(|heading| heading == anchor));
            if !exists || !has_anchor {
                missing.push(format!("{}:{line} links to {link}", document.path));
            }
        }
    }
    assert!(count > 50, "{count} links");
    assert!(missing.is_empty(), "\n{}\n", missing.join("\n"));
}

/// Returns the target of a link in a document as a path without `..`.
fn resolved(document: &str, link: &str) -> String {
    let mut parts: Vec<&str> = document.split('/').collect();
    parts.pop();
    for part in link
        .split('/')
        .filter(|part| !part.is_empty() && *part != ".")
    {
        if part == ".." {
            parts.pop();
        } else {
            parts.push(part);
        }
    }
    parts.join("/")
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap()
}
