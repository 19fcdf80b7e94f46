//! The tests of a target, read from its sources: their paths, as the test runner has them, and whether it leaves them out.

use std::fs;
use std::path::{Path, PathBuf};

#[derive(Debug, PartialEq, Eq)]
pub struct Test {
    pub path: String,
    pub is_ignored: bool,
}

/// All tests of the target whose root is the file.
pub fn tests_of(root: &Path) -> Vec<Test> {
    let mut found = Vec::new();
    collect(root, "", root.parent().unwrap(), &mut found);
    found
}

/// Adds the tests of a file and of the modules below it. `module` is the path before the names of its tests, and the files of
/// its own modules are in the folder, but for those with a path of their own, which is from where the file is.
fn collect(file: &Path, module: &str, folder: &Path, found: &mut Vec<Test>) {
    let text = fs::read_to_string(file).unwrap();
    let parsed = parsed(&text, module);
    found.extend(parsed.tests);
    for (name, path) in parsed.modules {
        let inner = folder.join(&name);
        let file = match path {
            Some(path) => file.parent().unwrap().join(path),
            None => existing(&folder.join(format!("{name}.rs")), &inner.join("mod.rs")),
        };
        let is_folder_root = file.file_name().is_some_and(|name| name == "mod.rs");
        let folder = if is_folder_root {
            file.parent().unwrap().to_owned()
        } else {
            inner
        };
        collect(&file, &format!("{module}{name}::"), &folder, found);
    }
}

fn existing(file: &Path, folder_root: &Path) -> PathBuf {
    if file.exists() { file } else { folder_root }.to_owned()
}

#[derive(Default)]
struct Parsed {
    tests: Vec<Test>,
    /// Modules in files of their own, with the path where one is given.
    modules: Vec<(String, Option<String>)>,
}

/// What a file, as rustfmt leaves it, has in its lines.
fn parsed(text: &str, module: &str) -> Parsed {
    let mut parsed = Parsed::default();
    // Modules in braces that are open, each with its indentation.
    let mut open: Vec<(&str, usize)> = Vec::new();
    let (mut is_test, mut is_ignored, mut path) = (false, false, None);
    for line in text.lines() {
        let code = line.trim_start();
        let indentation = line.len() - code.len();
        if code.starts_with('#') {
            is_test |= code == "#[test]";
            is_ignored |= code.starts_with("#[ignore");
            path = quoted(code, "#[path = ").or(path);
            continue;
        }
        if code == "}"
            && open
                .last()
                .is_some_and(|(_, indent)| *indent == indentation)
        {
            open.pop();
        }
        if let Some((name, rest)) = named(code, "mod ") {
            match rest {
                ";" => parsed.modules.push((name.to_owned(), path.take())),
                " {" => open.push((name, indentation)),
                _ => {}
            }
        }
        if let Some((name, _)) = named(code, "fn ") {
            if is_test {
                let inner = open.iter().flat_map(|(name, _)| [*name, "::"]);
                let path = [module].into_iter().chain(inner).chain([name]).collect();
                parsed.tests.push(Test { path, is_ignored });
            }
            (is_test, is_ignored) = (false, false);
        }
    }
    parsed
}

/// The name behind a keyword at the beginning of a line, perhaps behind `pub`, and what follows it.
fn named<'c>(code: &'c str, keyword: &str) -> Option<(&'c str, &'c str)> {
    let private = code.strip_prefix("pub ").unwrap_or(code);
    let name = private.strip_prefix(keyword)?;
    let end = name.find(|next: char| !next.is_alphanumeric() && next != '_')?;
    Some(name.split_at(end))
}

fn quoted(code: &str, before: &str) -> Option<String> {
    Some(code.strip_prefix(before)?.split('"').nth(1)?.to_owned())
}

#[test]
fn tests_are_read_with_their_modules() {
    let text = "mod outer;\n#[path = \"../other.rs\"]\nmod other;\nmod inner {\n    #[test]\n    #[ignore = \"hours\"]\n    fn long() {}\n}\n\
                proptest! {\n    #[test]\n    fn random(\n    ) {}\n}\nfn no_test() {}\n";
    let parsed = parsed(text, "root::");
    let test = |path: &str, is_ignored| Test {
        path: path.to_owned(),
        is_ignored,
    };
    let expected = [test("root::inner::long", true), test("root::random", false)];
    assert_eq!(parsed.tests, expected);
    let modules = [("outer", None), ("other", Some("../other.rs"))];
    let modules = modules.map(|(name, path)| (name.to_owned(), path.map(str::to_owned)));
    assert_eq!(parsed.modules, modules);
}
