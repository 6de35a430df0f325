"""Writes the licences of all crates that are compiled into an artefact, to be shipped with it: each text once, with the crates that use it.

Usage: run `python3 licences.py` before `maturin build` to write `pinwarp/LICENSES.txt` of the wheel. For other artefacts, give `-o FILE`
and the Cargo arguments of their build:
python3 licences.py -o FILE --features=ofx --no-default-features --filter-platform=x86_64-pc-windows-gnu
In: the output of `cargo metadata`, and the licence files of the crates. Crates without a licence file are listed with the name of their
licence. The notices of Rust's standard library, which every artefact contains, follow at the end if the toolchain includes them.
"""

import argparse
import collections
import html
import json
import pathlib
import re
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
NAMES = ("LICENSE*", "LICENCE*", "license*", "COPYING*", "COPYRIGHT*", "NOTICE*", "UNLICENSE*")


def asked(*command: str) -> str:
    """Returns the output of a program."""
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def crates(more: list[str]) -> list[dict]:
    """Returns the package and all crates linked into it, by name, without build and test dependencies."""
    if not any(word.startswith("--filter-platform") for word in more):
        lines = asked("rustc", "-vV").splitlines()
        more = [*more, "--filter-platform=" + next(line.removeprefix("host: ") for line in lines if line.startswith("host: "))]
    said = json.loads(asked("cargo", "metadata", "--locked", "--format-version=1", *more))
    packages = {package["id"]: package for package in said["packages"]}
    nodes = {node["id"]: node for node in said["resolve"]["nodes"]}
    found, left = set(), [said["resolve"]["root"]]
    while left:
        name = left.pop()
        if name in found:
            continue
        found.add(name)
        own = nodes[name]["deps"]
        left += [other["pkg"] for other in own if any(kind["kind"] is None for kind in other["dep_kinds"])]
    return sorted((packages[name] for name in found), key=lambda package: (package["name"], package["version"]))


def texts(package: dict) -> list[str]:
    """Returns the licence texts of a crate."""
    folder = pathlib.Path(package["manifest_path"]).parent
    # Licences of fonts are stored beside the fonts.
    names = [*NAMES, "fonts/*.txt"]
    files = sorted({file for name in names for file in folder.glob(name) if file.is_file()})
    return [file.read_text(encoding="utf-8", errors="replace").strip() for file in files]


def library() -> str:
    """Returns the notices of Rust's standard library, without HTML tags."""
    page = pathlib.Path(asked("rustc", "--print", "sysroot").strip()) / "share/doc/rust/COPYRIGHT-library.html"
    if not page.is_file():
        return "Rust's standard library (MIT OR Apache-2.0): see https://github.com/rust-lang/rust\n"
    text = html.unescape(re.sub(r"<(style|head)\b.*?</\1>|<[^>]+>", "", page.read_text(encoding="utf-8"), flags=re.S))
    return re.sub(r"\n\s*\n\s*\n+", "\n\n", text).strip() + "\n"


def main() -> None:
    """Writes the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=pathlib.Path, default=HERE / "pinwarp" / "LICENSES.txt")
    options, more = parser.parse_known_args()
    by_text, without = collections.defaultdict(list), []
    for package in crates(more or ["--features=python"]):
        label = f"{package['name']} {package['version']} ({package['license'] or 'see its text'})"
        own = texts(package)
        for text in own:
            by_text[text].append(label)
        if not own:
            without.append(label)
    line = "=" * 100
    parts = [f"{line}\n" + "\n".join(labels) + f"\n{line}\n\n{text}\n" for text, labels in by_text.items()]
    head = "What is compiled into pinwarp, and its licences.\n"
    bare = "\n".join(["Crates that bring no text of their licence:", *without]) + "\n" if without else ""
    options.output.write_text("\n".join([head, bare, *parts, line, library()]), encoding="utf-8")
    print(f"{options.output.name}: {len(by_text)} texts, {len(without)} crates without one")


if __name__ == "__main__":
    main()
