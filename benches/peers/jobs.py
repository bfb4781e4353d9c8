"""What all peers have in common: a job comes in as JSON, a result goes out as JSON.

A peer is a file `peer_NAME.py` that calls `run` with up to three functions and knows nothing of the others:

    version() -> str              the version of the renderer; ImportError or OSError where it isn't installed
    render(job) -> Result         one render for each entry of `job.spp`
    textures(job) -> Result       plain gray, rust and scratches in turn (optional)

Every peer is used in the same three ways:

    peer_NAME.py --version        prints the version, or ends with 3 and the reason why the peer can't be used
    peer_NAME.py JOB RESULT       does the job in one file, writes the result to the other
"""

import dataclasses
import json
import os
import resource
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

# Exit code of a peer that isn't installed.
ABSENT = 3


@dataclass(frozen=True)
class Job:
    """What is to be rendered. Unknown fields are refused, so that a misspelt one isn't ignored."""

    task: str
    """`render` or `textures`."""
    scene: Path
    """A glTF file as `scenes.py` writes it, with one camera."""
    width: int
    height: int
    spp: list
    """Samples per pixel of each render; of all renders of `textures`, the only one."""
    out: Path
    """Folder for pictures."""
    max_depth: int = 9
    """At most so many surface points scatter light along a path."""
    threads: int = 1
    seed: int = 0
    environment: tuple = (0.0, 0.0, 0.0)
    """Radiance from all directions, linear Rec.709, W/(m2 sr)."""
    patina: str = "patina"
    """The program of that name."""
    build: str = ""
    """Which build of it that is, in its own jobs: another one is another job."""
    material: str = "model"
    """`textures`: what is gray, rusty and scratched in turn."""
    ao_samples: tuple = (4, 16)
    """`textures`: rays of ambient occlusion at a hit."""
    runs: int = 3
    """`textures`: timed renders of each case."""

    @staticmethod
    def read(path):
        """Raises ValueError where a field is missing or unknown."""
        fields = json.loads(Path(path).read_text())
        known = {f.name for f in dataclasses.fields(Job)}
        if unknown := sorted(set(fields) - known):
            raise ValueError(f"{path}: unknown fields {', '.join(unknown)}")
        try:
            job = Job(**fields)
        except TypeError as error:
            raise ValueError(f"{path}: {error}") from error
        if job.task not in ("render", "textures"):
            raise ValueError(f"{path}: unknown task {job.task}")
        return dataclasses.replace(job, scene=Path(job.scene), out=Path(job.out))

    def picture(self, name):
        """Where a picture of that name goes."""
        return self.out / name


@dataclass
class Render:
    """One timed render."""

    spp: int
    seconds: float
    """Wall time without loading, building hierarchies and compiling."""
    picture: str
    """Linear floats: `.npy` of shape (height, width, 3), top row first, or an OpenEXR file."""


@dataclass
class TextureCase:
    """One texture of a job `textures`."""

    form: str
    """How the renderer evaluates textures."""
    texture: str
    ao_samples: int
    ms_per_spp: float
    """Median."""
    increase_percent: dict
    """More than gray of the same run takes: `median`, `low`, `high`."""
    edit_ms: float
    """From the edit of a parameter to the first sample of all pixels; 0 for gray."""
    unedited_ms: float
    """The first sample of all pixels again, without an edit; 0 where that isn't measured."""
    picture: str = ""


@dataclass
class Result:
    """What a peer did."""

    details: str
    """Variant, device, driver: what a reader has to know beside the version."""
    load_seconds: float
    """Everything before the first timed render, including a render that isn't counted."""
    renders: list = field(default_factory=list)
    cases: list = field(default_factory=list)


def spread(values):
    """Median, lowest and highest of at least one number."""
    ordered = sorted(values)
    middle = len(ordered) // 2
    median = ordered[middle] if len(ordered) % 2 else 0.5 * (ordered[middle - 1] + ordered[middle])
    return {"median": median, "low": ordered[0], "high": ordered[-1]}


def increase(times, gray):
    """Time over plain gray in percent, run by run."""
    return spread([(t / g - 1.0) * 100.0 for t, g in zip(times, gray, strict=True)])


def timed(action):
    """What `action` returns, and the seconds of wall time that it took."""
    start = time.perf_counter()
    result = action()
    return result, time.perf_counter() - start


def write_json(path, value):
    """Writes aside, then renames, so that nobody reads half a file."""
    path = Path(path)
    aside = path.with_name(path.name + ".part")
    aside.write_text(json.dumps(value, indent=1) + "\n")
    os.replace(aside, path)


def run(version, render, textures=None):
    """The command line of a peer."""
    arguments = sys.argv[1:]
    if arguments not in (["--version"],) and len(arguments) != 2:
        sys.exit(f"usage: {Path(sys.argv[0]).name} --version | JOB RESULT")
    try:
        number = version()
    except (ImportError, OSError) as error:
        print(error, file=sys.stderr)
        sys.exit(ABSENT)
    if arguments == ["--version"]:
        print(number)
        return
    job = Job.read(arguments[0])
    job.out.mkdir(parents=True, exist_ok=True)
    task = {"render": render, "textures": textures}[job.task]
    if task is None:
        sys.exit(f"{Path(sys.argv[0]).name} has no task {job.task}")
    result = dataclasses.asdict(task(job))
    result["version"] = number
    result["peak_mib"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    write_json(arguments[1], result)
