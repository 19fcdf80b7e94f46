//! Every figure in a document names the command that makes it, and every command that is named can be typed.
//!
//! A figure is a number in a table, or one in a sentence or in printed output that looks measured (`quantities`). Its command
//! stands in the same block, or in a heading, paragraph or script above it in the same section; an item of a list serves itself
//! alone. Numbers that nobody measures, constants of the code, settings and closed forms, are listed in `given`.

mod blocks;
mod commands;
mod given;
mod quantities;
mod repository;
mod test_names;
mod trials;
mod words;

use blocks::{Block, Kind, blocks, code_spans};
use given::{GIVEN, Given};
use quantities::has_figures;
use repository::Repository;
use std::fs;
use std::path::{Path, PathBuf};

/// Their Markdown files are the documents; folders below are not.
const FOLDERS: [&str; 9] = [
    "",
    "docs",
    "docs/guide",
    "docs/python",
    "docs/render",
    "benches/peers",
    "examples/rerun",
    "fuzz",
    "python",
];

/// Tells of the past.
const HISTORY: &str = "CHANGELOG.md";

/// In a command, stands for each name in the first column of the section's tables.
const PLACEHOLDER: &str = "NAME";

struct Document {
    path: String,
    blocks: Vec<Block>,
}

impl Document {
    fn new(path: &str, markdown: &str) -> Self {
        Self {
            path: path.to_owned(),
            blocks: blocks(markdown),
        }
    }

    /// Blocks of one section after the other, each with its heading if it has one.
    fn sections(&self) -> impl Iterator<Item = &[Block]> {
        self.blocks.chunk_by(|_, next| next.kind != Kind::Heading)
    }

    /// Figures without a command.
    fn unexplained(&self, repository: &Repository) -> Vec<&Block> {
        let mut found = Vec::new();
        for section in self.sections() {
            let mut is_explained = false;
            for block in section {
                let own = named_in(block, section);
                let makes_figures = own
                    .iter()
                    .any(|command| repository.verdict(command) == Some(Ok(true)));
                if has_figures(block) && !makes_figures && !is_explained {
                    found.push(block);
                }
                let is_for_all =
                    matches!(block.kind, Kind::Heading | Kind::Paragraph | Kind::Script);
                is_explained |= makes_figures && is_for_all;
            }
        }
        found
    }

    /// Commands that cannot be typed.
    fn impossible(&self, repository: &Repository) -> Vec<String> {
        let mut found = Vec::new();
        for (block, section) in self
            .sections()
            .flat_map(|section| section.iter().map(move |block| (block, section)))
        {
            for command in named_in(block, section) {
                if let Some(Err(reason)) = repository.verdict(&command) {
                    let place = format!("{}:{}", self.path, block.line);
                    found.push(format!("{place} names `{command}`: {reason}"));
                }
            }
        }
        found
    }

    fn violations(&self, repository: &Repository, given: &[Given]) -> Vec<String> {
        let mut found = self.impossible(repository);
        let unexplained = self.unexplained(repository);
        let listed: Vec<&Given> = given
            .iter()
            .filter(|given| given.document == self.path)
            .collect();
        let covers = |given: &Given, block: &Block| block.flat().contains(given.words);
        for block in &unexplained {
            if !listed.iter().any(|given| covers(given, block)) {
                let beginning: String = block.flat().chars().take(60).collect();
                found.push(format!(
                    "{}:{} has figures and names no command: {beginning}",
                    self.path, block.line
                ));
            }
        }
        for given in listed {
            let covered = unexplained.iter().filter(|block| covers(given, block));
            if covered.count() != 1 {
                found.push(format!(
                    "{} has not one block for the words in the list: {}",
                    self.path, given.words
                ));
            }
        }
        found
    }
}

/// The commands of a block; one with the placeholder as often as the section's tables have names for it.
fn named_in(block: &Block, section: &[Block]) -> Vec<String> {
    let tables = section.iter().filter(|block| block.kind == Kind::Table);
    let rows = tables.flat_map(|table| table.text.lines().skip(2));
    let names: Vec<&str> = rows
        .filter_map(|row| code_spans(row.split('|').nth(1)?).next())
        .collect();
    let expanded = |command: String| {
        if !command.contains(PLACEHOLDER) || names.is_empty() {
            return vec![command];
        }
        let with = |name: &&str| command.replace(PLACEHOLDER, name);
        names.iter().map(with).collect()
    };
    block.commands().into_iter().flat_map(expanded).collect()
}

/// The comments of a source file, as Markdown: lines of code are empty ones. `marks` are what comments begin with, longer ones
/// before those that they begin with.
fn comments(text: &str, marks: &[&str]) -> String {
    let comment = |line: &str| {
        let line = line.trim_start();
        let text = marks.iter().find_map(|mark| line.strip_prefix(mark));
        text.map_or(String::new(), |text| {
            text.strip_prefix(' ').unwrap_or(text).to_owned()
        })
    };
    text.lines().map(comment).collect::<Vec<_>>().join("\n")
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files with the extension: in the folder, and in those below if `is_deep`.
fn files(folder: &str, extension: &str, is_deep: bool) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(root().join(folder)).unwrap() {
        let path: PathBuf = entry.unwrap().path();
        let name = path
            .strip_prefix(root())
            .unwrap()
            .to_str()
            .unwrap()
            .replace('\\', "/");
        if path.is_dir() && is_deep {
            found.extend(files(&name, extension, is_deep));
        } else if path.extension().is_some_and(|found| found == extension) {
            found.push((name, fs::read_to_string(&path).unwrap()));
        }
    }
    found.sort();
    found
}

fn documents() -> Vec<Document> {
    let texts = FOLDERS.iter().flat_map(|folder| files(folder, "md", false));
    let of_today = texts.filter(|(path, _)| path != HISTORY);
    of_today
        .map(|(path, text)| Document::new(&path, &text))
        .collect()
}

#[test]
fn every_figure_in_the_documents_names_its_command() {
    let (repository, documents) = (Repository::new(root()), documents());
    // A checker that finds no documents finds no fault.
    let expected = [
        "README.md",
        "docs/measurements.md",
        "docs/guide/5_performance.md",
    ];
    for expected in expected
        .into_iter()
        .chain(GIVEN.iter().map(|given| given.document))
    {
        assert!(
            documents.iter().any(|document| document.path == expected),
            "{expected}"
        );
    }
    let violations = |document: &Document| document.violations(&repository, &GIVEN);
    let mut found: Vec<String> = documents.iter().flat_map(violations).collect();
    found.extend(GIVEN.iter().filter_map(Given::fault));
    assert!(found.is_empty(), "\n{}\n", found.join("\n"));
}

#[test]
fn commands_in_comments_can_be_typed() {
    let repository = Repository::new(root());
    let sources = ["src", "tests", "benches", "examples"].map(|folder| files(folder, "rs", true));
    let rust = sources
        .into_iter()
        .flatten()
        .map(|(path, text)| (path, comments(&text, &["//!", "///", "//"])));
    let scripts = files("benches/peers", "py", false);
    let (mut found, mut commands) = (Vec::new(), 0);
    for (path, text) in rust.chain(scripts) {
        let document = Document::new(&path, &text);
        let named = document.blocks.iter().flat_map(Block::commands);
        let known = |command: &String| repository.verdict(command).is_some();
        commands += named.filter(known).count();
        found.extend(document.impossible(&repository));
    }
    // A checker that finds no commands finds no fault.
    assert!(commands > 20, "{commands}");
    assert!(found.is_empty(), "\n{}\n", found.join("\n"));
}

/// Either as a bench of cargo, or by the script beside it, which names the bench.
#[test]
fn every_bench_names_its_own_command() {
    let repository = Repository::new(root());
    assert!(repository.benches().count() > 5);
    for (name, source) in repository.benches() {
        let header = Document::new(
            name,
            &comments(&fs::read_to_string(source).unwrap(), &["//!"]),
        );
        let spans: Vec<String> = header.blocks.iter().flat_map(Block::commands).collect();
        let own = format!("cargo bench --bench {name}");
        let runs_it = |span: &String| {
            let script = fs::read_to_string(source.with_file_name(span));
            span.contains(&own) || script.is_ok_and(|text| text.contains(&format!("\"{name}\"")))
        };
        assert!(
            spans.iter().any(runs_it),
            "{}: names no command that runs it",
            source.display()
        );
    }
}
