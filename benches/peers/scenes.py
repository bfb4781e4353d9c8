"""Writes the scenes that all peers render, and a list of them.

    scenes.py OUT --scenes DIR --reference DIR

Sponza, the living room and the toy car come from the folder `--scenes`, the Cornell box with its reference from
`--reference`. What isn't there is listed as skipped.
"""

import argparse
import dataclasses
from dataclasses import dataclass
from pathlib import Path

import gltf
from jobs import write_json

SKYLIGHT = Path(__file__).parents[2] / "examples/skylight.gltf"
GRAY = gltf.Material("model", (0.5, 0.5, 0.5))


@dataclass
class Listed:
    """An entry of the list."""

    name: str
    task: str
    """`render` or `textures`."""
    file: str
    width: int
    height: int
    triangles: int
    environment: tuple = (0.0, 0.0, 0.0)
    reference: str | None = None
    """A converged picture (.exr) of that size or a multiple of it."""


def cornell(_scenes, reference):
    """The Cornell box as it comes: diffuse, but for a sphere of rough metal."""
    scene = gltf.read(reference / "cornell.glb")
    return scene, {"width": 256, "height": 256, "reference": str(reference / "ref_mitsuba.exr")}


def sponza(scenes, _reference):
    """Sponza with the lamps of `examples/skylight.gltf` over its roof and without their sun: all diffuse."""
    scene = gltf.Scene(camera=gltf.Camera.looking((5.6, 1.75, -1.25), (-0.4, 1.15, 0.05), 44.0))
    scene.add(gltf.read(scenes / "Sponza/Sponza.gltf"))
    # Whatever a lamp says about its surface, it is black.
    lamps = gltf.read(SKYLIGHT)
    lamps.materials = [dataclasses.replace(m, color=(0.0, 0.0, 0.0), metallic=False) for m in lamps.materials]
    scene.add(lamps)
    return scene, {"width": 320, "height": 180}


def living_room(scenes, _reference):
    """The living room under an even sky, without its glasses and with rough mirrors."""
    scene = gltf.read(scenes / "interior-living-room/living-room.gltf")
    return scene, {"width": 320, "height": 180, "environment": (1.0, 1.0, 1.0)}


def sponza_model(scenes, reference):
    """A toy car the size of a real one in Sponza: the paper's scene."""
    scene, size = sponza(scenes, reference)
    car = gltf.read(scenes / "khronos/ToyCar/ToyCar.gltf")
    scene.camera = gltf.Camera.looking((3.1, 1.5, -1.9), (0.5, 0.75, -0.2), 44.0)
    place = gltf.placement((0.6, -0.12, -0.2), 65.0, 100.0)
    scene.add(car, only=["ToyCar"], transform=place, material=GRAY)
    return scene, size


def knot(scenes, reference):
    """The knot of the Cornell box from nearby."""
    scene, _ = cornell(scenes, reference)
    knots = {mesh.material for mesh in scene.meshes if mesh.name == "knot"}
    for number in knots:
        scene.materials[number] = GRAY
    scene.camera = gltf.Camera.looking((-0.1, 0.0, 1.55), (-0.3, -0.1, 0.0), 39.3)
    return scene, {"width": 256, "height": 256}


ALL = {
    "cornell": ("render", cornell),
    "sponza": ("render", sponza),
    "living-room": ("render", living_room),
    "knot": ("textures", knot),
    "sponza-model": ("textures", sponza_model),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--scenes", type=Path, required=True)
    parser.add_argument("--reference", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    listed, skipped = [], []
    for name, (task, make) in ALL.items():
        try:
            scene, more = make(arguments.scenes, arguments.reference)
        except OSError as error:
            skipped.append({"name": name, "reason": str(error)})
            continue
        file = arguments.out / f"{name}.gltf"
        gltf.write(scene, file)
        entry = Listed(name, task, str(file), triangles=scene.triangle_count(), **more)
        listed.append(dataclasses.asdict(entry))
    # By which it is known whether they are to be written anew.
    origin = {"scenes": str(arguments.scenes), "reference": str(arguments.reference)}
    write_json(arguments.out / "scenes.json", {"scenes": listed, "skipped": skipped, "origin": origin})


if __name__ == "__main__":
    main()
