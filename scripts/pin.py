"""Write constraints.txt and constraints-dev.txt: every version pinned, every file by its hash.

Torch is in constraints-torch.txt, by its version alone: for one version there are files that
compute on the CPU only, of 0.2 GB, and files for GPUs, which need further packages of gigabytes.
Which one pip takes depends on where it looks, and either will do.

Run it with the oldest supported Python, inside any environment with a recent pip::

    python3.11 scripts/pin.py

It takes the newest releases that pyproject.toml allows. The index is whichever one pip is set up
to use; the files name versions and hashes only.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# hatchling asks for it only when it installs the checkout itself.
EDITABLE = ["editables~=0.3"]
TORCH = "torch"
FOR_GPUS = ("cuda-", "nvidia-", "triton")
PYTHONS = ("3.11", "3.12", "3.13")
# Newest tag first: pip prefers the first platform that has a file, as a real machine does.
LINUX = [f"manylinux_2_{minor}" for minor in range(36, 16, -1)] + ["manylinux2014"]
PLATFORMS = {
    "linux x86_64": [f"{tag}_x86_64" for tag in LINUX],
    "linux aarch64": [f"{tag}_aarch64" for tag in LINUX],
    # SUMO's files need macOS 15, all others are content with 14.
    "macos arm64": ["macosx_15_0_arm64", "macosx_14_0_arm64"],
}

Pins = dict[str, str]
Hashes = dict[str, set[str]]


def pip_report(arguments: list[str]) -> list[dict]:
    """Ask pip what it would install, and return its report's entries."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--dry-run"]
        command += ["--ignore-installed", "--report", str(report), *arguments]
        if "--platform" in arguments:  # pip asks for a target, which a dry run leaves empty
            command += ["--target", folder]
        subprocess.run(command, check=True)
        return json.loads(report.read_text())["install"]


def canonical(name: str) -> str:
    """Return a package's name as indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def resolve(requirements: list[str], pinned: Pins) -> Pins:
    """Return name → version of the requirements and all they need, keeping what is pinned."""
    arguments = [*requirements, *(f"{name}=={version}" for name, version in pinned.items())]
    entries = pip_report(["--only-binary=:all:", *arguments])
    return {canonical(entry["metadata"]["name"]): entry["metadata"]["version"] for entry in entries}


def file_hashes(pins: Pins) -> Hashes:
    """Return name → sha256 of every file that a supported Python and platform would take."""
    hashes: Hashes = {name: set() for name in pins}
    for platform, tags in PLATFORMS.items():
        for python in PYTHONS:
            print(f"hashes for Python {python} on {platform}", flush=True)
            arguments = ["--no-deps", "--only-binary=:all:", "--python-version", python]
            arguments += [part for tag in tags for part in ("--platform", tag)]
            arguments += [f"{name}=={version}" for name, version in pins.items()]
            for entry in pip_report(arguments):
                digest = entry["download_info"]["archive_info"]["hashes"]["sha256"]
                hashes[canonical(entry["metadata"]["name"])].add(digest)
    return hashes


def write(path: Path, heading: list[str], pins: Pins, hashes: Hashes) -> None:
    """Write one requirements file, sorted by name."""
    lines = list(heading)
    for name in sorted(pins):
        lines.append(f"{name}=={pins[name]} \\")
        lines += [f"    --hash=sha256:{digest} \\" for digest in sorted(hashes[name])]
        lines[-1] = lines[-1].removesuffix(" \\")
    temporary = path.with_suffix(".tmp")
    temporary.write_text("\n".join(lines) + "\n")
    temporary.replace(path)


def main() -> None:
    """Resolve, collect the hashes and write the files."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    extras = project["project"]["optional-dependencies"]
    needed = [*project["project"]["dependencies"], *project["build-system"]["requires"], *EDITABLE]
    runtime = resolve(needed, {})
    everything = resolve([line for line in extras["dev"] if not line.startswith("dmil")], runtime)
    everything = {k: v for k, v in everything.items() if not k.startswith(FOR_GPUS)}
    torch = everything.pop(TORCH).split("+")[0]  # what follows a + names the kind of file
    hashes = file_hashes(everything)
    note = "# Written by scripts/pin.py; do not edit by hand."
    write(
        ROOT / "constraints.txt",
        [note, "# What dmil needs to run, and what builds it."],
        runtime,
        hashes,
    )
    added = {name: version for name, version in everything.items() if name not in runtime}
    write(
        ROOT / "constraints-dev.txt",
        [note, "# What `make check` needs on top.", "-r constraints.txt"],
        added,
        hashes,
    )
    write(
        ROOT / "constraints-torch.txt",
        [
            note,
            "# What `make check` needs last. Without hashes: for one version there are files for",
            "# CPUs and files for GPUs, and which one pip takes depends on where it looks.",
        ],
        {TORCH: torch},
        {TORCH: set()},
    )


if __name__ == "__main__":
    main()
