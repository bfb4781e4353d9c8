"""Whether Blender reads the layers of an EXR file by name, and gets the numbers that they should be.

    python benches/blender/layers.py PICTURE.EXR NAMES.JSON FOLDER MATTE...

NAMES.JSON is what `patina info --json` says of the picture. A matte is a pair of the name of a material and an EXR file that shows
its coverage, from the same samples. Everything goes through Blender's compositor, as an artist's node tree would.
`cargo xtask blender` runs this.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

# Parts of the light, and the picture, whose sums may differ by so much of its brightest.
SUM_LIMIT = 1e-5
MATTE_LIMIT = 1.0 / 255.0
CLASSES = ["Diffuse", "Glossy", "Transmission"]
# Blender shows the fourth channel of the picture as an output of its own, and ids by their groups of four channels.
PREFIX = "ViewLayer."


class Compositor:
    """One node tree, whose output is whatever socket is to be looked at."""

    def __init__(self, path, folder, size):
        self.folder = folder
        self.scene = bpy.context.scene
        self.image = bpy.data.images.load(str(path))
        self.tree = bpy.data.node_groups.new("layers", "CompositorNodeTree")
        self.tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        self.source = self.tree.nodes.new("CompositorNodeImage")
        self.source.image = self.image
        self.sink = self.tree.nodes.new("NodeGroupOutput")
        self.scene.compositing_node_group = self.tree
        render = self.scene.render
        render.use_compositing = True
        render.resolution_x, render.resolution_y = size
        render.resolution_percentage = 100
        settings = render.image_settings
        settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"

    def names(self):
        return [socket.name for socket in self.source.outputs]

    def values(self, socket):
        """Row 0 below, three channels."""
        self.tree.links.clear()
        self.tree.links.new(socket, self.sink.inputs[0])
        path = self.folder / "seen.exr"
        self.scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        return pixels(path)

    def layer(self, name):
        return self.values(self.source.outputs[name])

    def matte(self, layer, name):
        node = self.tree.nodes.new("CompositorNodeCryptomatteV2")
        node.source, node.image = "IMAGE", self.image
        node.layer_name = layer
        node.matte_id = name
        return self.values(node.outputs["Matte"])[..., 0]


def pixels(path):
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    values = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(height, width, 4)[..., :3]


def main(picture, facts, folder, *mattes):
    part = json.loads(Path(facts).read_text())["parts"][0]
    compositor = Compositor(picture, Path(folder), (part["width"], part["height"]))
    known = compositor.names()
    wrong = []

    layers = sorted({c["name"].rpartition(".")[0].removeprefix(PREFIX) for c in part["channels"]})
    missing = [name for name in layers if name not in known]
    print(f"{len(layers)} layers, {len(missing)} that Blender doesn't know by name")
    wrong += [f"no layer {name}" for name in missing]

    combined = compositor.layer("Combined")
    total = compositor.layer("Emission") + compositor.layer("Environment")
    for kind in CLASSES:
        light = compositor.layer(f"{kind} Direct") + compositor.layer(f"{kind} Indirect")
        total += compositor.layer(f"{kind} Color") * light
    groups = sum(compositor.layer(name) for name in layers if name.startswith("Combined_"))
    for what, parts in [("kinds of scattering", total), ("groups of lights", groups)]:
        off = float(np.max(np.abs(parts - combined)) / np.max(combined))
        print(f"{what} add up to the picture within {off:.1e} of its brightest")
        if off > SUM_LIMIT:
            wrong.append(what)

    for name, truth in zip(mattes[::2], mattes[1::2]):
        covered = pixels(truth)[..., 0]
        off = float(np.max(np.abs(compositor.matte("ViewLayer.CryptoMaterial", name) - covered)))
        print(f"matte of {name}: covers {100.0 * covered.mean():.2f} %, within {255.0 * off:.3f}/255 in every pixel")
        if off > MATTE_LIMIT or covered.max() < 0.5:
            wrong.append(f"matte of {name}")
    if wrong:
        sys.exit("wrong: " + ", ".join(wrong))


if __name__ == "__main__":
    main(*sys.argv[1:])
