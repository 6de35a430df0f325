"""Writes `pinwarp/LICENSES.txt`: the licences of all crates that are compiled into the package, for the wheel to carry.

Usage: python3 licences.py, before `maturin build`. In: what `cargo metadata` tells, the files that crates bring. Out: every text once, with
the crates that it is for. Crates that bring no text are listed with the name of their licence.
"""

import collections
import json
import pathlib
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
NAMES = ("LICENSE*", "LICENCE*", "license*", "COPYING*", "COPYRIGHT*", "NOTICE*", "UNLICENSE*")


def crates() -> list[dict]:
    """The package and all crates that it is built of, by name; those that only build or test it are left out."""
    about = subprocess.run(["rustc", "-vV"], check=True, stdout=subprocess.PIPE, text=True).stdout
    host = next(line.removeprefix("host: ") for line in about.splitlines() if line.startswith("host: "))
    command = ["cargo", "metadata", "--locked", "--format-version=1", "--features=python", f"--filter-platform={host}"]
    said = json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)
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
    """The texts that a crate brings."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = sorted({file for name in NAMES for file in folder.glob(name) if file.is_file()})
    return [file.read_text(encoding="utf-8", errors="replace").strip() for file in files]


def main() -> None:
    """Writes the file."""
    by_text, without = collections.defaultdict(list), []
    for package in crates():
        label = f"{package['name']} {package['version']} ({package['license'] or 'see its text'})"
        own = texts(package)
        for text in own:
            by_text[text].append(label)
        if not own:
            without.append(label)
    line = "=" * 100
    parts = [f"{line}\n" + "\n".join(labels) + f"\n{line}\n\n{text}\n" for text, labels in by_text.items()]
    head = "Pinwarp's compiled part is made of these crates.\n"
    bare = "\n".join(["Crates that bring no text of their licence:", *without]) + "\n" if without else ""
    (HERE / "pinwarp" / "LICENSES.txt").write_text("\n".join([head, bare, *parts]), encoding="utf-8")
    print(f"LICENSES.txt: {len(by_text)} texts, {len(without)} crates without one")


if __name__ == "__main__":
    main()
