#!/usr/bin/env python3
"""Builds the site: all documents, the Rust reference, and the Python reference if the package is installed.

    python3 docs/site/build.py            # into target/site, after `cargo doc --no-deps --all-features`
    python3 docs/site/build.py --output F # into another folder

The documents keep their places, so that relative links work on the site as in the repository. Links to files that are not part of
the site become plain text. The first run installs MkDocs into target/site_environment; the site itself needs no network.
"""

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import venv

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
REQUIREMENTS = ["mkdocs==1.6.1"]
PAGES = ["*.md", "docs/**/*.md", "examples/**/*.md", "python/*.md", "benches/**/*.md", "fuzz/*.md"]
PICTURES = ["docs/**/*.svg", "docs/**/*.png", "examples/**/*.png"]
LICENSES = ["LICENSE-MIT", "LICENSE-APACHE", "CITATION.cff"]
# Inline code comes first, so that it is left as it is.
LINK = re.compile(r"(`[^`]*`)|(!?)\[([^\]]*)\]\(([^)\s]+)\)")

RUST = re.compile(r"^```rust\n.*?^```$", re.MULTILINE | re.DOTALL)
# Lines of Rust programs that rustdoc hides.
HIDDEN = re.compile(r"^#( .*)?\n", re.MULTILINE)


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("--output", type=pathlib.Path, default=TARGET / "site")
    output = options.parse_args().output.resolve()
    if output.exists() and any(output.iterdir()) and not (output / "search").exists():
        sys.exit(f"{output} is not empty and holds no earlier site: building would erase it")
    source = TARGET / "site_source"
    shutil.rmtree(source, ignore_errors=True)
    copy_documents(source)
    command = [environment() / "bin" / "mkdocs", "build", "--quiet", "--strict", "--clean"]
    settings = ["--config-file", HERE / "mkdocs.yml", "--site-dir", output]
    subprocess.run([*command, *settings], check=True, env=os.environ | {"SITE_SOURCE": str(source)})
    for name, folder in {"rust": TARGET / "doc", "python_reference": TARGET / "python_reference"}.items():
        if folder.exists():
            shutil.copytree(folder, output / name, dirs_exist_ok=True)
        else:
            print(f"{folder} does not exist: the site has no {name}", file=sys.stderr)
    print(f"the site is in {output}")


def copy_documents(source):
    """Copies pages and pictures, with links to other files taken out."""
    pages = {path for pattern in PAGES for path in ROOT.glob(pattern) if "target" not in path.relative_to(ROOT).parts}
    pages = {path for path in pages if "node_modules" not in path.parts}
    others = {path for pattern in PICTURES for path in ROOT.glob(pattern)} | {ROOT / name for name in LICENSES}
    copied = pages | others
    for path in others:
        place = source / path.relative_to(ROOT)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, place)
    for path in pages:
        place = source / path.relative_to(ROOT)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(with_known_links(path, copied), encoding="utf-8")


def with_known_links(page, copied):
    """The text of a page. A link to a file that is not on the site becomes its text."""

    def replaced(match):
        code, mark, text, link = match.groups()
        if code or "://" in link or link.startswith("#"):
            return match[0]
        target = (page.parent / link.split("#")[0]).resolve()
        return match[0] if target in copied else (f"`{text}`" if mark else text)

    text = RUST.sub(lambda program: HIDDEN.sub("", program[0]), page.read_text(encoding="utf-8"))
    return LINK.sub(replaced, text)


def environment():
    """A virtual environment with MkDocs."""
    folder = TARGET / "site_environment"
    if not (folder / "bin" / "mkdocs").exists():
        venv.create(folder, with_pip=True)
        subprocess.run([folder / "bin" / "python", "-m", "pip", "install", "--quiet", *REQUIREMENTS], check=True)
    return folder


if __name__ == "__main__":
    main()
