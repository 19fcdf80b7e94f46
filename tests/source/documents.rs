//! A parser for commands, links and headings in Markdown.

use std::fs;
use std::path::{Path, PathBuf};

/// A Markdown file, or the comments of a source file.
pub struct Document {
    /// Path from the root of the repository.
    pub path: String,
    pub text: String,
}

impl Document {
    /// Returns code between backticks outside fences, and lines of fences and indented blocks that are neither Rust nor output. Each has
    /// its line number.
    pub fn commands(&self) -> Vec<(usize, String)> {
        let mut commands = Vec::new();
        for (line, text, fence) in self.lines() {
            match fence {
                None if text.starts_with("    ") => commands.push((line, without_comment(text))),
                None => {
                    let spans = text.split('`').skip(1).step_by(2);
                    commands.extend(spans.map(|span| (line, span.to_owned())));
                }
                Some("" | "rust" | "text") => {}
                Some(_) => commands.push((line, without_comment(text))),
            }
        }
        commands
    }

    /// Returns the targets of all links outside fences, with their line numbers.
    pub fn links(&self) -> Vec<(usize, String)> {
        let mut links = Vec::new();
        for (line, text, fence) in self.lines() {
            let outside_code = text.split('`').step_by(2).collect::<Vec<_>>().join("`");
            for rest in outside_code.split("](").skip(1).filter(|_| fence.is_none()) {
                let target = rest.split([')', ' ']).next().unwrap_or_default();
                links.push((line, target.to_owned()));
            }
        }
        links
    }

    /// Returns the anchors of the headings, as on GitHub.
    pub fn anchors(&self) -> Vec<String> {
        let outside = self.lines().filter(|(_, _, fence)| fence.is_none());
        let headings = outside.filter_map(|(_, text, _)| {
            let title = text.trim_start_matches('#');
            (title.len() < text.len()).then(|| title.trim())
        });
        let is_kept = |letter: &char| letter.is_alphanumeric() || " -_".contains(*letter);
        let anchor = |title: &str| {
            let kept = title
                .to_lowercase()
                .chars()
                .filter(is_kept)
                .collect::<String>();
            kept.replace(' ', "-")
        };
        headings.map(anchor).collect()
    }

    /// Yields lines with their numbers and the language of the surrounding fence. The lines of the fences themselves are omitted.
    fn lines(&self) -> impl Iterator<Item = (usize, &str, Option<&str>)> {
        let mut fence = None;
        (1..)
            .zip(self.text.lines())
            .filter_map(move |(line, text)| {
                if let Some(language) = text.trim_start().strip_prefix("```") {
                    fence = if fence.is_some() {
                        None
                    } else {
                        Some(language)
                    };
                    return None;
                }
                Some((line, text, fence))
            })
    }
}

fn without_comment(line: &str) -> String {
    line.split(" #").next().unwrap_or(line).trim().to_owned()
}

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns all Markdown files of the repository.
pub fn markdown() -> Vec<Document> {
    let folders = ["docs", "benches", "examples", "fuzz", "python"];
    let inner = folders
        .into_iter()
        .flat_map(|folder| documents(folder, "md", true));
    documents("", "md", false)
        .into_iter()
        .chain(inner)
        .collect()
}

/// Returns the comments of all source files as Markdown. Lines of code become empty lines.
pub fn comments() -> Vec<Document> {
    let folders = ["src", "tests", "benches", "examples"];
    let sources = folders
        .into_iter()
        .flat_map(|folder| documents(folder, "rs", true));
    let comment = |line: &str| {
        let line = line.trim_start();
        let text = ["//!", "///", "//"]
            .iter()
            .find_map(|mark| line.strip_prefix(mark));
        text.map_or_else(String::new, |text| {
            text.strip_prefix(' ').unwrap_or(text).to_owned()
        })
    };
    sources
        .map(|Document { path, text }| Document {
            path,
            text: text.lines().map(comment).collect::<Vec<_>>().join("\n"),
        })
        .collect()
}

/// Returns the files with the extension in a folder, and in its subfolders if `is_deep`.
fn documents(folder: &str, extension: &str, is_deep: bool) -> Vec<Document> {
    let mut collected = Vec::new();
    for entry in fs::read_dir(root().join(folder)).unwrap() {
        let path: PathBuf = entry.unwrap().path();
        let name = path
            .strip_prefix(root())
            .unwrap()
            .to_str()
            .unwrap()
            .replace('\\', "/");
        let is_built = ["target", "node_modules", ".venv"]
            .iter()
            .any(|built| path.ends_with(built));
        if path.is_dir() && is_deep && !is_built {
            collected.extend(documents(&name, extension, is_deep));
        } else if path.extension().is_some_and(|ending| ending == extension) {
            let text = fs::read_to_string(&path).unwrap();
            collected.push(Document { path: name, text });
        }
    }
    collected.sort_by(|a, b| a.path.cmp(&b.path));
    collected
}

#[test]
fn commands_links_and_anchors_are_found() {
    let text = "# Two words, `code`\n`cargo run` and [a link](b.md#c)\n```sh\ncargo test # all\n```\n```rust\nno();\n```\n    ls\n";
    let document = Document {
        path: String::new(),
        text: text.to_owned(),
    };
    let commands = [(1, "code"), (2, "cargo run"), (4, "cargo test"), (9, "ls")];
    assert_eq!(
        document.commands(),
        commands.map(|(line, text)| (line, text.to_owned()))
    );
    assert_eq!(document.links(), [(2, "b.md#c".to_owned())]);
    assert_eq!(document.anchors(), ["two-words-code"]);
}
