//! Import cycles: files that import each other, directly or through other files.
//!
//! A file imports another file if it names one of its items in a `use`. A name that `mod.rs` re-exports with `pub use` belongs to the file
//! that defines it.

use std::collections::{BTreeMap, BTreeSet};

/// A path as its names, for example `crate`, `mesh`, `TetMesh`.
type Names = Vec<String>;

/// Returns the files in cycles or between two cycles, with the files that they import. The input is each file with its code.
pub fn in_circles(files: &[(String, String)]) -> BTreeMap<String, BTreeSet<String>> {
    let modules: BTreeMap<Names, &str> = files
        .iter()
        .map(|(path, _)| (module_of(path), path.as_str()))
        .collect();
    let uses: Vec<Vec<Use>> = files
        .iter()
        .map(|(path, code)| uses_of(&module_of(path), code, &modules))
        .collect();
    let mut passed_on = BTreeMap::new();
    for ((path, _), uses) in files.iter().zip(&uses) {
        for Use { target, .. } in uses.iter().filter(|import| import.is_public) {
            let name = target.last().cloned();
            let names: Names = module_of(path).into_iter().chain(name).collect();
            passed_on.insert(names, target.clone());
        }
    }
    let mut graph = BTreeMap::new();
    for ((path, _), uses) in files.iter().zip(&uses) {
        let is_root = path.ends_with("mod.rs");
        let private_uses = uses.iter().filter(|import| !(is_root && import.is_public));
        let imported =
            private_uses.filter_map(|import| file_of(&import.target, &modules, &passed_on));
        let imported: BTreeSet<_> = imported.filter(|file| file != path).collect();
        graph.insert(path.clone(), imported);
    }
    trimmed(graph)
}

/// Removes files that import no remaining file, or that no remaining file imports, until none is left to remove.
fn trimmed(mut graph: BTreeMap<String, BTreeSet<String>>) -> BTreeMap<String, BTreeSet<String>> {
    loop {
        let remaining: BTreeSet<_> = graph.keys().cloned().collect();
        let imported: BTreeSet<_> = graph.values().flatten().cloned().collect();
        graph.retain(|path, imports| {
            imports.retain(|file| remaining.contains(file));
            !imports.is_empty() && imported.contains(path)
        });
        if graph.len() == remaining.len() {
            return graph;
        }
    }
}

/// A name that a file imports.
struct Use {
    target: Names,
    is_public: bool,
}

/// Returns the module of a file, as its names below the crate.
fn module_of(path: &str) -> Names {
    let path = path.trim_end_matches(".rs");
    let path = path.strip_suffix("/mod").unwrap_or(path);
    let names = path.split('/').filter(|name| *name != "lib");
    names.map(str::to_owned).collect()
}

/// Returns all names that a file imports from the crate.
fn uses_of(module: &Names, code: &str, modules: &BTreeMap<Names, &str>) -> Vec<Use> {
    let mut uses = Vec::new();
    for statement in code.split(';') {
        let lines = statement.lines().map(str::trim).collect::<Vec<_>>();
        let Some(first) = lines.iter().position(|line| {
            line.starts_with("use ") || (line.starts_with("pub") && line.contains(" use "))
        }) else {
            continue;
        };
        let statement = lines[first..].join(" ");
        let (before, tree) = statement.split_once("use ").unwrap_or_default();
        for path in paths_of(tree) {
            uses.extend(absolute(module, &path, modules).map(|target| Use {
                target,
                is_public: before.starts_with("pub"),
            }));
        }
    }
    uses
}

/// Returns the paths of a `use` without groups: for `a::{b, c::d}`, these are `a::b` and `a::c::d`.
fn paths_of(tree: &str) -> Vec<Names> {
    let tree = tree.trim();
    let Some((head, group)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or(tree);
        return vec![
            path.split("::")
                .map(|name| name.trim().to_owned())
                .collect(),
        ];
    };
    let head: Names = head
        .split("::")
        .map(|name| name.trim().to_owned())
        .filter(|name| !name.is_empty())
        .collect();
    let group = group.trim_end().strip_suffix('}').unwrap_or(group);
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for character in group.chars() {
        match character {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        match parts.last_mut() {
            Some(_) if character == ',' && depth == 0 => parts.push(String::new()),
            Some(part) => part.push(character),
            None => {}
        }
    }
    let parts = parts.iter().filter(|part| !part.trim().is_empty());
    let paths = parts.flat_map(|part| paths_of(part));
    paths
        .map(|path| head.iter().cloned().chain(path).collect())
        .collect()
}

/// Returns a path below the crate, or `None` if the path leads to another crate.
fn absolute(module: &Names, path: &Names, modules: &BTreeMap<Names, &str>) -> Option<Names> {
    let climbs = path.iter().take_while(|name| *name == "super").count();
    let below = |names: &[String], rest: &[String]| [names, rest].concat();
    match path.first()?.as_str() {
        "crate" => Some(path[1..].to_vec()),
        "self" => Some(below(module, &path[1..])),
        "super" => {
            let parent = module.len().checked_sub(climbs)?;
            Some(below(&module[..parent], &path[climbs..]))
        }
        child => {
            let child = below(module, &[child.to_owned()]);
            modules.contains_key(&child).then(|| below(module, path))
        }
    }
}

/// Returns the file that defines the item at a path.
fn file_of(
    target: &Names,
    modules: &BTreeMap<Names, &str>,
    passed_on: &BTreeMap<Names, Names>,
) -> Option<String> {
    let module = (1..=target.len())
        .rev()
        .find(|&count| modules.contains_key(&target[..count]))?;
    if module < target.len()
        && let Some(further) = passed_on.get(&target[..=module])
        && further != target
    {
        return file_of(further, modules, passed_on);
    }
    modules
        .get(&target[..module])
        .map(|file| (*file).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circles_of(files: &[(&str, &str)]) -> Vec<String> {
        let owned = |&(path, code): &(&str, &str)| (path.to_owned(), code.to_owned());
        let files: Vec<_> = files.iter().map(owned).collect();
        in_circles(&files).into_keys().collect()
    }

    #[test]
    fn files_that_import_each_other_are_found() {
        let mesh = (
            "mesh/mod.rs",
            "mod a;\nmod b;\npub use a::{A, X};\npub(crate) use b::B;\n",
        );
        let above = ("contact/pair.rs", "use crate::mesh::A;\n");
        let a = ("mesh/a.rs", "use super::{\n    b::B as Other,\n};\n");
        for back in [
            "use super::a::A;",
            "use super::A;",
            "use crate::mesh::{A};",
            "use super::{B, a};",
        ] {
            let b = format!("/// Text.\n{back}\nstruct B;\n");
            let circles = circles_of(&[mesh, above, a, ("mesh/b.rs", &b)]);
            assert_eq!(circles, ["mesh/a.rs", "mesh/b.rs"], "{back}");
        }
        for imports in [
            "use std::a::A;",
            "use nalgebra::{A, a};",
            "use super::c::C;",
        ] {
            let circles = circles_of(&[mesh, above, a, ("mesh/b.rs", imports), ("mesh/c.rs", "")]);
            assert_eq!(circles, [""; 0], "{imports}");
        }
    }

    #[test]
    fn a_long_circle_is_found() {
        let files = [
            ("mesh/a.rs", "use super::b::B;\n"),
            ("mesh/b.rs", "use crate::search::c::C;\n"),
            ("search/c.rs", "use crate::mesh::a::A;\n"),
            ("search/d.rs", "use super::c::C;\n"),
        ];
        assert_eq!(
            circles_of(&files),
            ["mesh/a.rs", "mesh/b.rs", "search/c.rs"]
        );
    }
}
