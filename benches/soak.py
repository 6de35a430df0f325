"""Kills pinwarp with SIGKILL at random moments, fills its disk and slows it down, and checks the files that are left.

    python3 benches/soak.py target/release/pinwarp [--kills 400] [--seed N] [--devices cpu,vulkan] [--only NAME]

In: the program. Out: a line per case; exit code 1 if a rule is violated, with the seed that repeats the random choices.
The rules:

- A file under a final name is complete: it has the bytes of an undisturbed run. This is checked after every kill.
- A run with `--resume` ends with exactly those files. No temporary or hidden files are left.
- A chunk that fails or is killed can be restarted, in parallel with others, until all are done (as a farm does).
- On a full disk the exit code is 1 or 2, never a signal. The message names the file, says that no space is left, and what
  to do.

Needs only Python 3.10 and Linux. Mounting file systems requires root; otherwise that part is skipped, as the last lines
report. `openjd` (PyPI `openjd-cli`) and `strace` are used if they are installed.
"""

import argparse
import contextlib
import dataclasses
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
FRAMES = 12
# Longest duration of a run in seconds; a longer run counts as hung.
TIMEOUT = 300
# Folder next to the frames that is meant to stay.
TRAJECTORIES = ".pinwarp-trajectories"


class Broken(Exception):
    """A violated rule."""


@dataclasses.dataclass
class Job:
    """A command that fills a folder with files; `{out}` stands for the folder."""

    name: str
    words: list[str]
    # Contents of each file of an undisturbed run, and its duration.
    files: dict[str, bytes] = dataclasses.field(default_factory=dict)
    seconds: float = 0.0
    kills: int = 0
    # Number of runs that ended before they were killed.
    early: int = 0

    def command(self, out: pathlib.Path, *more: str) -> list[str]:
        return [word.format(out=out) for word in self.words] + list(more)


class Soak:
    """The work folder, the program and the random generator."""

    def __init__(self, program: pathlib.Path, work: pathlib.Path, rng: random.Random):
        self.program, self.work, self.rng = program, work, rng
        self.skipped: list[str] = []
        self.kills = 0
        # Number of kills that left an incomplete file under its temporary name.
        self.partial = 0

    def start(self, words: list[str], before: tuple[str, ...] = ()) -> subprocess.Popen:
        with open(self.work / "log", "wb") as log:
            return subprocess.Popen(
                [*before, str(self.program), *words],
                cwd=self.work,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def log(self) -> str:
        return (self.work / "log").read_text(errors="replace")

    def run(self, words: list[str], code: int | None = 0, before: tuple[str, ...] = ()) -> int:
        """Runs a command to its end and checks its exit code, unless `code` is `None`."""
        process = self.start(words, before)
        try:
            ended = process.wait(TIMEOUT)
        except subprocess.TimeoutExpired:
            kill_all(process)
            raise Broken(f"{' '.join(words)}: does not end within {TIMEOUT} s") from None
        if code is not None and ended != code:
            raise Broken(f"{' '.join(words)}: exit code {ended}, not {code}:\n{self.log()[-2000:]}")
        return ended

    def skip(self, what: str) -> None:
        print(f"SKIPPED: {what}", flush=True)
        self.skipped.append(what)

    def folder(self, name: str) -> pathlib.Path:
        folder = self.work / name
        shutil.rmtree(folder, ignore_errors=True)
        return folder


def kill_all(process: subprocess.Popen) -> None:
    """Sends SIGKILL to a process and all its descendants, and waits until they are gone."""
    children = descendants(process.pid)
    for pid in [process.pid, *children]:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    process.wait()
    # The locks of a killed process are released when it is gone, not when the signal is sent.
    while any(os.path.exists(f"/proc/{pid}") for pid in children):
        time.sleep(0.001)


def descendants(pid: int) -> list[int]:
    parents: dict[int, list[int]] = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            with contextlib.suppress(OSError):
                with open(f"/proc/{entry}/stat") as stat:
                    parent = int(stat.read().rsplit(")", 1)[1].split()[1])
                parents.setdefault(parent, []).append(int(entry))
    found, left = [], [pid]
    while left:
        children = parents.get(left.pop(), [])
        found += children
        left += children
    return found


def listed(folder: pathlib.Path) -> dict[str, pathlib.Path]:
    """All files below a folder by name, except solved trajectories under their final names."""
    files = {str(file.relative_to(folder)): file for file in sorted(folder.rglob("*")) if file.is_file()}
    kept = re.compile(re.escape(TRAJECTORIES) + r"/[^./][^/]*(?<!\.tmp)")
    return {name: file for name, file in files.items() if not kept.fullmatch(name)}


def is_temporary(name: str) -> bool:
    return any(part.startswith(".") and part != TRAJECTORIES for part in name.split("/"))


def check_whole(job: Job, folder: pathlib.Path) -> int:
    """Checks that every file under a final name has the bytes of the undisturbed run; returns their number."""
    finals = {name: file for name, file in listed(folder).items() if not is_temporary(name)}
    for name, file in finals.items():
        if name not in job.files:
            raise Broken(f"{job.name}: {name} is a file that an undisturbed run does not make")
        if file.read_bytes() != job.files[name]:
            raise Broken(f"{job.name}: {name} ({file.stat().st_size} bytes) differs from {len(job.files[name])} bytes")
    return len(finals)


def check_finished(job: Job, folder: pathlib.Path) -> None:
    """Checks that the folder has the files of the undisturbed run and no others."""
    check_whole(job, folder)
    names = set(listed(folder))
    if names != set(job.files):
        raise Broken(f"{job.name}: missing {sorted(set(job.files) - names)}, stray {sorted(names - set(job.files))}")


def shots(work: pathlib.Path) -> None:
    """Writes shots, small enough for hundreds of runs."""
    for name in ("teapot/teapot.glb", "flag/flag.png", "flag/pole.png"):
        shutil.copy(ROOT / "scenes" / name, work)
    teapot = (ROOT / "scenes/teapot/shot.toml").read_text()
    teapot = re.sub(r"last = 24", f"last = {FRAMES}", teapot)
    teapot = re.sub(r"(?m)^size .*", "size = [320, 180]", teapot)
    teapot = re.sub(r"(?m)^samples .*", "samples = 2", teapot)
    teapot = re.sub(r"(?m)^path .*", 'path = "openjd/f.####.exr"', teapot)
    (work / "teapot.toml").write_text(teapot)
    over_time = teapot.replace('box = "follow" }', 'box = "follow" }\nsolve = { temporal = 0.3 }')
    (work / "time.toml").write_text(over_time)
    flag = (ROOT / "scenes/flag/shot.toml").read_text().replace("last = 24", f"last = {FRAMES}")
    (work / "flag.toml").write_text(flag)


def jobs(soak: Soak, devices: list[str]) -> list[Job]:
    """The commands to kill, with the files of their undisturbed runs."""
    shots(soak.work)
    soak.run(["render", "teapot.toml", "--device", "cpu", "-o", "plates/p.####.exr"])
    soak.run(["render", "teapot.toml", "--device", "cpu", "-o", "stills/s.####.exr", "--preview"])
    render = ["render", "teapot.toml", "-o", "{out}/f.####.exr", "--preview", "--device"]
    # A software Vulkan driver is used for resampling only if its index is given.
    named = {"cpu": ("cpu", "cpu"), "vulkan": ("vulkan", "0")}
    all_jobs = []
    for device in devices:
        draws, resamples = named[device]
        plates = ["warp", "plates/p.####.exr", "--shot", "teapot.toml", "-o", "{out}/w.####.exr", "--device", resamples]
        all_jobs += [Job(f"render {device}", [*render, draws]), Job(f"warp {device}", plates)]
    stills = ["warp", "stills/s.####.png", "--shot", "teapot.toml", "-o", "{out}/w.####.png", "--device", "cpu"]
    all_jobs += [
        Job("render over time", ["render", "time.toml", "-o", "{out}/f.####.exr", "--device", "cpu"]),
        Job("warp PNG", stills),
        Job("render pictures", ["render", "flag.toml", "--scale", "1/3", "-o", "{out}/f.####.exr"]),
    ]
    for job in all_jobs:
        folder = soak.folder("undisturbed")
        start = time.monotonic()
        soak.run(job.command(folder))
        job.seconds = time.monotonic() - start
        job.files = {name: file.read_bytes() for name, file in listed(folder).items()}
        again = soak.folder("again")
        soak.run(job.command(again))
        check_finished(job, again)
        size = sum(map(len, job.files.values())) >> 10
        print(f"{job.name}: {len(job.files)} files, {size} KiB, {job.seconds:.1f} s", flush=True)
    return all_jobs


def wait_for_the_moment(soak: Soak, job: Job, folder: pathlib.Path, process: subprocess.Popen) -> bool:
    """Waits until a random moment of the run, in half of all cases one while a file is being written; returns whether it still runs."""
    end = time.monotonic() + soak.rng.uniform(0, job.seconds)
    while_writing = soak.rng.random() < 0.5
    while time.monotonic() < end:
        if process.poll() is not None:
            return False
        time.sleep(0.001)
    if while_writing:
        end = time.monotonic() + job.seconds
        while process.poll() is None and time.monotonic() < end:
            if folder.is_dir() and any(name.endswith(".tmp") for name in listed(folder)):
                time.sleep(soak.rng.uniform(0, 0.01))
                break
    return process.poll() is None


def kill_once(
    soak: Soak, job: Job, folder: pathlib.Path, words: list[str], before: tuple[str, ...] = (), may_fail: bool = False
) -> None:
    """Starts a run and kills it, unless it ends before; checks that the files left are complete."""
    process = soak.start(words, before)
    if wait_for_the_moment(soak, job, folder, process):
        kill_all(process)
        soak.kills += 1
        job.kills += 1
        left = listed(folder) if folder.is_dir() else {}
        soak.partial += any(name.endswith(".tmp") for name in left)
    else:
        job.early += 1
        if process.returncode not in ((0, 1, 2) if may_fail else (0,)):
            raise Broken(f"{job.name}: exit code {process.returncode}:\n{soak.log()[-2000:]}")
    check_whole(job, folder)


def kills(soak: Soak, job: Job, count: int) -> None:
    """Kills up to four runs in a folder, then lets one finish; repeats until `count` kills are reached."""
    runs = 0
    while job.kills < count:
        folder = soak.folder("killed")
        more = soak.rng.choice([["--resume"], ["--resume", "--verify"], ["--resume", "--fsync"]])
        for _ in range(soak.rng.randint(1, 4)):
            kill_once(soak, job, folder, job.command(folder, *more))
        soak.run(job.command(folder, *more))
        check_finished(job, folder)
        runs += 1
    print(f"{job.name}: {job.kills} kills, {runs} finished runs, {job.early} too quick to kill: same bytes", flush=True)


def farm(soak: Soak, job: Job) -> None:
    """Runs chunks in random order, two at a time; kills some and restarts them until all succeed; then runs the report."""
    folder = soak.folder("farm")
    size = soak.rng.randint(1, 5)
    waiting = [(first, min(first + size - 1, FRAMES)) for first in range(1, FRAMES + 1, size)]
    soak.rng.shuffle(waiting)
    running: list[tuple[subprocess.Popen, tuple[int, int], float]] = []
    retries = 0
    deadline = time.monotonic() + TIMEOUT
    while waiting or running:
        if time.monotonic() > deadline:
            raise Broken(f"{job.name}: the farm does not end")
        while waiting and len(running) < 2:
            chunk = waiting.pop()
            process = soak.start(job.command(folder, "--frames", "{}-{}".format(*chunk), "--resume"))
            is_doomed = soak.rng.random() < 0.6
            running.append((process, chunk, time.monotonic() + soak.rng.uniform(0, job.seconds) if is_doomed else 1e12))
        for entry in list(running):
            process, chunk, doom = entry
            if process.poll() is None and time.monotonic() > doom:
                kill_all(process)
                soak.kills += 1
            if process.poll() is not None:
                running.remove(entry)
                check_whole(job, folder)
                if process.returncode not in (0, -signal.SIGKILL):
                    raise Broken(f"{job.name}: a chunk ends with {process.returncode}:\n{soak.log()[-2000:]}")
                if process.returncode != 0:
                    retries += 1
                    waiting.insert(0, chunk)
        time.sleep(0.001)
    check_finished(job, folder)
    soak.run(["report", str(folder), "--verify"])
    print(f"{job.name}: farm of chunks of {size}, {retries} retries: same bytes", flush=True)


def openjd(soak: Soak, job: Job, times: int) -> None:
    """Runs the job template with openjd, kills it with all its descendants and runs it again, `times` times."""
    beside = pathlib.Path(sys.executable).with_name("openjd")
    tool = str(beside) if beside.is_file() else shutil.which("openjd")
    if tool is None:
        return soak.skip("the job template: openjd (PyPI openjd-cli) is not installed")
    # The output folder that the shot itself names.
    folder = soak.folder("openjd")
    more = [word for word in job.words[2:] if word not in ("-o", "{out}/f.####.exr")]
    program = ["--program", str(soak.program), "--chunk", "3"]
    soak.run(["job", "teapot.toml", *program, "-o", "soak.json", "--overwrite", "--", *more])
    command = [tool, "run", "soak.json", "--step", "Report", "--run-dependencies"]
    for attempt in range(times + 1):
        with open(soak.work / "log", "wb") as log:
            process = subprocess.Popen(command, cwd=soak.work, stdout=log, stderr=log, start_new_session=True)
        is_last = attempt == times
        if not is_last:
            time.sleep(soak.rng.uniform(0.5, 2 + job.seconds))
            if process.poll() is None:
                kill_all(process)
                soak.kills += 1
            check_whole(job, folder)
        elif process.wait(TIMEOUT) != 0:
            raise Broken(f"openjd ends with {process.returncode}:\n{soak.log()[-2000:]}")
    check_finished(job, folder)
    print(f"{job.name}: openjd run, killed {times} times: same bytes", flush=True)


@contextlib.contextmanager
def mounted(soak: Soak, kind: str, options: str, size_kib: int):
    """Mounts a new file system; yields its folder, or `None` if it cannot be mounted."""
    folder = soak.folder("disk")
    folder.mkdir()
    image = soak.work / "disk.img"
    if kind == "tmpfs":
        mount = ["mount", "-t", "tmpfs", "-o", f"size={size_kib}k,{options}", "tmpfs", str(folder)]
    else:
        with open(image, "wb") as file:
            file.truncate(size_kib << 10)
        succeeds(["mkfs.ext4", "-q", "-m", "0", str(image)])
        mount = ["mount", "-o", f"loop,{options}", str(image), str(folder)]
    if not succeeds(mount):
        soak.skip(f"a {kind} with {options}: it cannot be mounted here (are you root?)")
        yield None
        return
    try:
        yield folder
    finally:
        succeeds(["umount", str(folder)]) or succeeds(["umount", "-l", str(folder)])


def succeeds(command: list[str]) -> bool:
    try:
        return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0
    except FileNotFoundError:
        return False


def fill(disk: pathlib.Path, left_kib: int) -> pathlib.Path:
    """Fills a disk with one file, except for the given space."""
    ballast = disk / "ballast"
    with open(ballast, "wb", buffering=0) as file:
        with contextlib.suppress(OSError):
            while file.write(bytes(1 << 12)):
                pass
        size = file.seek(0, os.SEEK_END)
        file.truncate(max(0, size - (left_kib << 10)))
        os.fsync(file.fileno())
    return ballast


def full_disk(soak: Soak, job: Job, kind: str, share: float) -> None:
    """Runs on a disk too small for all files, and kills some of the runs; then frees space and finishes."""
    needed = sum(map(len, job.files.values())) >> 10
    with mounted(soak, kind, "rw", 2 * needed + 8192) as disk:
        if disk is None:
            return
        folder = disk / "out"
        ballast = fill(disk, int(share * needed))
        words = job.command(folder, "--resume")
        code, log = soak.run(words, None), soak.log()
        if code not in (1, 2):
            raise Broken(f"{job.name}: exit code {code} on a full disk:\n{log[-2000:]}")
        if any(part not in log for part in ("o space left", "free some space", str(folder))):
            raise Broken(f"{job.name}: on a full disk it says\n{log[-2000:]}")
        whole = check_whole(job, folder)
        if stray := [name for name in listed(folder) if is_temporary(name)]:
            raise Broken(f"{job.name}: {stray} stay on a full disk")
        for _ in range(3):
            kill_once(soak, job, folder, words, may_fail=True)
        ballast.unlink()
        soak.run(words)
        check_finished(job, folder)
        print(f"{job.name}: full {kind}, exit code {code}, {whole} of {len(job.files)} files, then the rest", flush=True)


def slow_disk(soak: Soak, job: Job, count: int) -> None:
    """Kills runs on a file system with synchronous writes, then runs in which every write takes 5 ms longer."""
    with mounted(soak, "ext4", "sync", 65536) as disk:
        if disk is not None:
            kill_and_finish(soak, job, disk / "out", count, ())
    strace = ["strace", "-f", "-qqq", "-o", "/dev/null", "-e", "trace=write,pwrite64,rename", "-e", "inject=all:delay_exit=5000"]
    if succeeds([*strace, "true"]):
        kill_and_finish(soak, job, soak.folder("slow"), count, tuple(strace))
    else:
        soak.skip("slow writes: strace is not there, or cannot delay calls")


def kill_and_finish(soak: Soak, job: Job, folder: pathlib.Path, count: int, before: tuple[str, ...]) -> None:
    for _ in range(count):
        kill_once(soak, job, folder, job.command(folder, "--resume", "--fsync"), before)
    start = time.monotonic()
    soak.run(job.command(folder, "--resume", "--fsync"), before=before)
    check_finished(job, folder)
    how = "delayed writes" if before else "ext4 with sync"
    print(f"{job.name}: {how}, {count} kills, the rest in {time.monotonic() - start:.1f} s: same bytes", flush=True)


def soak_all(soak: Soak, options: argparse.Namespace) -> None:
    every = jobs(soak, options.devices.split(","))
    chosen = [job for job in every if options.only in job.name]
    for job in chosen:
        kills(soak, job, -(-options.kills // len(chosen)))
    for job in chosen:
        farm(soak, job)
    for job in (job for job in chosen if job.name.startswith("render") and "teapot.toml" in job.words):
        openjd(soak, job, 4)
    for job in chosen:
        for kind, share in (("tmpfs", 0.02), ("tmpfs", soak.rng.uniform(0.1, 0.9)), ("ext4", soak.rng.uniform(0.3, 0.9))):
            full_disk(soak, job, kind, share)
    for job in chosen:
        slow_disk(soak, job, 4)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--kills", type=int, default=400, help="kills of plain runs, over all cases; others come on top")
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1 << 32))
    parser.add_argument("--devices", default="cpu,vulkan")
    parser.add_argument("--only", default="", help="cases whose name contains this")
    options = parser.parse_args()
    print(f"seed {options.seed}", flush=True)
    work = pathlib.Path(tempfile.mkdtemp(prefix="pinwarp-soak-"))
    soak = Soak(options.program.resolve(), work, random.Random(options.seed))
    try:
        soak_all(soak, options)
    except Broken as broken:
        print(f"BROKEN (seed {options.seed}): {broken}\nwhat is left lies in {work}")
        return 1
    except BaseException:
        print(f"seed {options.seed}")
        shutil.rmtree(work, ignore_errors=True)
        raise
    shutil.rmtree(work, ignore_errors=True)
    print(f"{soak.kills} kills, {soak.partial} of them with a file half-written: every rule held")
    for what in soak.skipped:
        print(f"SKIPPED: {what}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
