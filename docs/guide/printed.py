#!/usr/bin/env python3
"""What the guide's programs print: runs each that prints something, and compares with what the chapter says it prints.

`cargo test --doc` runs all of these programs, but shows nothing of a program that passes. Run

    python3 docs/guide/printed.py        # all chapters, minutes
    python3 docs/guide/printed.py 4 6    # some

The programs become a package in cargo's target directory. It ends with an error where a line that a chapter shows was printed
by none of its programs.
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
REPOSITORY = HERE.parent.parent
LIBRARIES = ["nalgebra", "num-dual", "serde_json"]


def main():
    chapters = [path for path in sorted(HERE.glob("*.md")) if not sys.argv[1:] or path.name[0] in sys.argv[1:]]
    programs = {
        f"{chapter.stem}_line_{line}": source for chapter in chapters for line, source in programs_that_print(chapter)
    }
    manifest = written_package(target_directory() / "guide_programs", programs)
    missing = []
    for chapter in chapters:
        printed = []
        for name in (name for name in programs if name.startswith(chapter.stem)):
            output = run(manifest, name)
            print(f"{name}\n{output}")
            printed += output.splitlines()
        missing += [f"{chapter.name}:{line}: {text}" for line, text in lines_shown(chapter) if text not in printed]
    sys.exit("\n".join(["printed by no program:", *missing]) if missing else 0)


def blocks(chapter):
    """Fences of a chapter: the paragraph above, the number of the first line, the language and the text."""
    text = chapter.read_text()
    for match in re.finditer(r"^```(\w*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        before = text[: match.start()]
        yield before.rstrip().split("\n\n")[-1], before.count("\n") + 2, match[1], match[2]


def programs_that_print(chapter):
    for _, line, language, text in blocks(chapter):
        if language == "rust" and "println!" in text:
            # Lines that the guide hides.
            source = re.sub(r"^# ", "", text, flags=re.MULTILINE)
            yield line, f"fn main() -> Result<(), Box<dyn std::error::Error>> {{\n{source}}}\n"


def lines_shown(chapter):
    for above, line, language, text in blocks(chapter):
        if language == "text" and re.search(r"\bprints\b", above):
            yield from enumerate(text.splitlines(), line)


def metadata():
    command = ["cargo", "metadata", "--no-deps", "--format-version", "1"]
    return json.loads(subprocess.run(command, cwd=REPOSITORY, check=True, capture_output=True).stdout)


def target_directory():
    return pathlib.Path(metadata()["target_directory"])


def written_package(folder, programs):
    """A package with the programs, each by its name; the path of its manifest."""
    shutil.rmtree(folder / "src", ignore_errors=True)
    (folder / "src" / "bin").mkdir(parents=True)
    for name, source in programs.items():
        (folder / "src" / "bin" / f"{name}.rs").write_text(source)
    library = next(package for package in metadata()["packages"] if package["name"] == "hydroelastic")
    wanted = {item["name"]: item["req"] for item in library["dependencies"]}
    libraries = [f'{name} = "{wanted[name]}"' for name in LIBRARIES]
    libraries.append(f"hydroelastic = {{ path = {json.dumps(str(REPOSITORY))}, features = [\"serde\"] }}")
    package = '[package]\nname = "guide_programs"\nversion = "0.0.0"\nedition = "2024"\n\n[workspace]\n'
    manifest = folder / "Cargo.toml"
    manifest.write_text("\n".join([package, "[dependencies]", *libraries, ""]))
    shutil.copy(REPOSITORY / "Cargo.lock", folder)
    return manifest


def run(manifest, name):
    command = ["cargo", "run", "--quiet", "--release", "--manifest-path", manifest, "--bin", name]
    return subprocess.run(command, cwd=REPOSITORY, check=True, capture_output=True, text=True).stdout


if __name__ == "__main__":
    main()
