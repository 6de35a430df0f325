"""What the package carries: the command line, its types, and documents whose code runs."""

import inspect
import json
import pathlib
import re
import shutil
import subprocess
import sys

import pinwarp
import pytest
from conftest import ROOT, module


def test_the_script_is_the_command_line():
    script = pathlib.Path(sys.executable).parent / "pinwarp"
    said = subprocess.run([script, "--version"], capture_output=True, text=True)
    assert (said.returncode, said.stdout) == (0, f"pinwarp {pinwarp.__version__}\n")
    wrong = subprocess.run([script, "rendre"], capture_output=True, text=True)
    assert wrong.returncode == 2 and "render" in wrong.stderr


def test_types_are_packed_and_are_those_of_what_is_there():
    assert (pathlib.Path(pinwarp.__file__).parent / "py.typed").is_file()
    module("mypy")
    said = subprocess.run([sys.executable, "-m", "mypy.stubtest", "pinwarp"], capture_output=True, text=True)
    assert said.returncode == 0, said.stdout + said.stderr


def test_type_checkers_see_wrong_calls(tmp_path):
    module("mypy")
    use = tmp_path / "use.py"
    use.write_text(
        "import numpy, pinwarp\n"
        "image = numpy.zeros((4, 4), numpy.float32)\n"
        "warped = pinwarp.warp(image, [[0.5, 0.5, 0.6, 0.5]], units='pixels')\n"
        "picture = pinwarp.Shot('x').render(1).rgba()\n"
        "pinwarp.warp(image, filter='soft')\n"
    )
    said = subprocess.run([sys.executable, "-m", "mypy", "--strict", use], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 1 and "use.py:5: error" in said.stdout and "Found 1 error" in said.stdout, said.stdout


def test_signatures_are_readable():
    assert str(inspect.signature(pinwarp.Shot.render)) == "(self, /, frame, device='auto', progress=None)"


@pytest.fixture
def workplace(teapot, monkeypatch):
    """A folder with the files that the documents speak of."""
    folder = teapot.parent
    shutil.copy(ROOT / "scenes/flag/flag.png", folder / "picture.png")
    monkeypatch.chdir(folder)
    return folder


def run_blocks(blocks, name):
    """Runs blocks of code one after the other, in one namespace."""
    names = {"__name__": "__main__"}
    for number, block in enumerate(blocks):
        exec(compile(block, f"{name}, block {number + 1}", "exec"), names)
    return names


def test_the_guide_runs(workplace):
    text = (ROOT / "docs/PYTHON.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(blocks) >= 6
    run_blocks(blocks, "docs/PYTHON.md")


def test_the_python_of_the_tasks_runs(tmp_path, monkeypatch):
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes", ignore=shutil.ignore_patterns("out"))
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/GUIDE.md").read_text(), re.S)
    assert len(blocks) == 2
    run_blocks(blocks, "docs/GUIDE.md")


def test_the_notebook_runs(workplace):
    notebook = json.loads((ROOT / "docs/python.ipynb").read_text())
    assert notebook["nbformat"] == 4
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    names = run_blocks(cells, "docs/python.ipynb")
    assert len(cells) >= 5 and names["warped"].shape == names["image"].shape


def test_blocks_that_fail_are_found():
    with pytest.raises(NameError):
        run_blocks(["a = 1", "b"], "a document")


