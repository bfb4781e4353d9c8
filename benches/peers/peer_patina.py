"""Patina itself, through its command line, so that it is measured like the others."""

import json
import os
import subprocess
import time

from jobs import Render, Result, TextureCase, run, timed


def version():
    # Which program it is comes with the job; `devices` and others aren't asked for here.
    return "this checkout"


def _call(job, *arguments):
    # For a software driver; the flag `--threads` is for the device `native`, and GPUs know neither.
    environment = os.environ | {"LP_NUM_THREADS": str(job.threads)}
    done = subprocess.run([job.patina, *arguments], env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"patina {' '.join(arguments)} ended with {done.returncode}:\n{done.stderr}")


def _look(job):
    """A look file that says what the scene can't: its environment."""
    path = job.picture("patina.look.toml")
    color = ", ".join(str(float(c)) for c in job.environment)
    path.write_text(f"environment = {{ color = [{color}] }}\n")
    return path


def _render(job, look, spp):
    picture = job.picture(f"patina-{spp}-{job.seed}.exr")
    figures = job.picture("patina-stats.json")
    _call(
        job, "render", str(job.scene), "--look", str(look), "--size", f"{job.width}x{job.height}", "--spp", str(spp),
        "--max-depth", str(job.max_depth), "--seed", str(job.seed), "--filter", "box", "--no-energy-compensation",
        "--threads", str(job.threads), "--exr-float", "all", "-o", str(picture), "--stats-json", str(figures),
    )  # fmt: skip
    return str(picture), json.loads(figures.read_text())


def render(job):
    look = _look(job)
    # Compiles all kernels where no cache has them.
    (_, figures), load = timed(lambda: _render(job, look, 1))
    device = figures["device"]
    result = Result(f"{device['name']}, {device['driver']}", load)
    for spp in job.spp:
        picture, figures = _render(job, look, spp)
        result.renders.append(Render(spp, figures["seconds"]["render"], picture))
    return result


def textures(job):
    start = time.perf_counter()
    figures = job.picture("patina-textures.json")
    # As many threads as the others have, where it is threads that render.
    _, known = _render(job, _look(job), 1)
    device = ["--device", f"native:{job.threads}"] if known["device"]["name"] == "native" else []
    _call(
        job, "bench", "textures", *device, "--scene", str(job.scene), "--material", job.material, "--look", str(_look(job)),
        "--size", f"{job.width}x{job.height}", "--spp", str(job.spp[0]), "--runs", str(job.runs),
        "--max-depth", str(job.max_depth), "--ao-rays", ",".join(map(str, job.ao_samples)), "--modes", "stack",
        "-o", str(figures),
    )  # fmt: skip
    measured = json.loads(figures.read_text())
    result = Result("", time.perf_counter() - start)
    for row in measured["results"]:
        increase = {"median": row["increase_percent"], "low": row["increase_low"], "high": row["increase_high"]}
        case = TextureCase(
            row["mode"], row["texture"], row["ao_rays"], row["ms_per_spp"], increase, row["edit_ms"], 0.0
        )
        result.cases.append(case)
    return result


if __name__ == "__main__":
    run(version, render, textures)
