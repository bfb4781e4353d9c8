"""Holds what MaterialX's nodes become against MaterialX's own OSL, run by Cycles.

    python benches/materialx/judge.py make OUT
    python benches/materialx/judge.py images OUT
    python benches/materialx/judge.py check OUT

`make` writes a document for each definition of MaterialX's library that gives numbers, `images` for those that read images: its inputs vary over a plane. Cycles renders
what MaterialX's generator makes of it, at 256 points, into OUT/NAME.MATERIAL.osl.f32; the points are in OUT/points.f32. `check`
compares OUT/NAME.MATERIAL.f32, which Patina has written, and prints a table. `cargo xtask materialx` does all.
"""

import os
import re
import sys
import zlib
from collections import defaultdict
from pathlib import Path

import numpy as np

GROUPS = "math adjustment compositing conditional channel procedural procedural2d procedural3d geometric application organization texture2d".split()
COUNTS = {"float": 1, "integer": 1, "boolean": 1, "color3": 3, "color4": 4, "vector2": 2, "vector3": 3, "vector4": 4}
SIDE = 16
LIMIT = 1e-4

# What inputs vary around, and how much; all others vary by 2 around 0.3. Counts and choices are constants.
AROUND = {
    "inlow": (-0.5, 0.3), "low": (-0.5, 0.3), "outlow": (-0.5, 0.3), "inhigh": (2.0, 0.3), "high": (1.0, 0.3), "outhigh": (2.0, 0.3),
    "gamma": (2.0, 0.3), "lacunarity": (2.0, 0.0), "diminish": (0.5, 0.0), "jitter": (0.8, 0.0), "radius": (0.4, 0.0),
    "thickness": (0.2, 0.0), "size": (0.5, 0.0), "interval1": (-0.4, 0.0), "interval2": (0.1, 0.0), "interval3": (0.4, 0.0),
    "interval4": (0.6, 0.0), "uvtiling": (3.0, 0.0), "freq": (2.0, 0.0), "min": (-1.0, 0.0), "max": (2.0, 0.0), "axis": (0.5, 0.3),
    "amount": (1.2, 1.0), "lumacoeffs": (0.4, 0.1), "which": (5.0, 5.0), "index": (1.0, 0.0), "octaves": (3.0, 0.0), "ior": (0.7, 0.1),
    "seed": (3.0, 0.0), "num_intervals": (4.0, 0.0), "interval_num": (1.0, 0.0), "style": (0.0, 0.0), "type": (0.0, 0.0),
    "operationorder": (0.0, 0.0), "interpolation": (1.0, 0.0), "center": (0.2, 0.0), "scale": (1.5, 0.4), "fps": (24.0, 0.0),
    "strength": (1.0, 0.0), "flip_g": (1.0, 0.0),
    "coverage": (0.5, 0.4), "falloff": (0.5, 0.2), "falloffcontrast": (0.5, 0.2),
}


def coefficients(name, i, is_image=False):
    """Two slopes and a middle for a component of an input. Images are seen so large that a pixel of theirs covers many of the picture:
    Cycles filters those that are smaller."""
    number = lambda salt: zlib.crc32(f"{name}{i}{salt}".encode()) / 2**31 - 1.0
    middle, size = AROUND.get(name, (0.3, 2.0))
    if is_image and name in ("texcoord", "st", "viewdir"):
        middle, size = 0.31, 0.12
    if is_image and name in ("uvtiling", "scale", "pivot", "offset", "uvoffset", "rotate", "realworldimagesize", "realworldtilesize", "rotation"):
        size = 0.0
        middle = {"scale": 1.5, "uvtiling": 1.5, "realworldimagesize": 1.5, "rotate": 20.0, "rotation": 20.0}.get(name, 0.7)
    if is_image and name in ("tiling", "rotationrange", "scalerange", "offsetrange"):
        return 0.0, 0.0, {"rotationrange": (10.0, 70.0), "scalerange": (0.8, 1.3), "offsetrange": (0.2, 0.9), "tiling": (1.5, 1.3)}[name][i]
    return size * number("x"), size * number("y"), middle + 0.1 * i * (size > 0)


def combined(name, count, ty):
    """Nodes that make a vector whose components vary."""
    lines = []
    for i in range(count):
        x, y, c = coefficients(name, i)
        lines.append(f'<dotproduct name="I_{name}_{i}" type="float"><input name="in1" type="vector3" nodename="Q"/><input name="in2" type="vector3" value="{x:.6f},{y:.6f},{c:.6f}"/></dotproduct>')
    parts = "".join(f'<input name="in{i + 1}" type="float" nodename="I_{name}_{i}"/>' for i in range(count))
    return lines + [f'<combine{count} name="I_{name}" type="{ty}">{parts}</combine{count}>']


def matrix(definition, name, ty):
    """Nodes that make a matrix whose rows vary. Where a point goes through four rows the last stays away: OSL leaves it out, the
    shaders of MaterialX's other languages add it, and so does Patina."""
    size = int(ty[-1])
    width = 3 if definition.getName() == "ND_transformmatrix_vector3M4" else size
    lines = []
    for row in range(width):
        lines += combined(f"{name}{row}", width, f"vector{width}")
    parts = "".join(f'<input name="in{row + 1}" type="vector{width}" nodename="I_{name}{row}"/>' for row in range(width))
    return lines + [f'<creatematrix name="I_{name}" type="{ty}">{parts}</creatematrix>']


def document(definition):
    """The text of a document that uses a definition, or why there is none."""
    lines = []
    add = lines.append
    add('<position name="P" type="vector3"><input name="space" type="string" value="world"/></position>')
    add('<add name="Q" type="vector3"><input name="in1" type="vector3" nodename="P"/><input name="in2" type="vector3" value="0,0,1"/></add>')
    inputs = []
    is_image = has_image(definition)
    for port in definition.getActiveInputs():
        name, ty = port.getName(), port.getType()
        if ty in ("string",) and name in ("space",):
            inputs.append(f'<input name="{name}" type="string" value="world"/>')
            continue
        if ty == "filename":
            inputs.append(f'<input name="{name}" type="filename" value="image.png"/>')
            continue
        if name == "filtertype":
            inputs.append('<input name="filtertype" type="string" value="closest"/>')
            continue
        if ty in ("matrix33", "matrix44"):
            lines += matrix(definition, name, ty)
            inputs.append(f'<input name="{name}" type="{ty}" nodename="I_{name}"/>')
            continue
        if ty not in COUNTS:
            continue
        if ty == "boolean":
            add(f'<ifgreater name="I_{name}" type="boolean"><input name="value1" type="float" nodename="I_{name}_0"/><input name="value2" type="float" value="0"/></ifgreater>')
        if port.getIsUniform() or (ty == "integer" and name in AROUND) or ty == "boolean" and name in ("doclamp", "staggered", "clampoutput"):
            middle = AROUND.get(name, (1.0, 0.0))[0]
            value = {"integer": str(int(middle)), "boolean": "true"}.get(ty, ",".join([str(middle)] * COUNTS[ty]))
            inputs.append(f'<input name="{name}" type="{ty}" value="{value}"/>')
            if ty == "boolean":
                lines.pop()
            continue
        for i in range(COUNTS[ty]):
            x, y, c = coefficients(name, i, is_image)
            add(f'<dotproduct name="I_{name}_{i}" type="float"><input name="in1" type="vector3" nodename="Q"/><input name="in2" type="vector3" value="{x:.6f},{y:.6f},{c:.6f}"/></dotproduct>')
        source = f"I_{name}_0"
        if ty == "integer":
            add(f'<multiply name="I_{name}_m" type="float"><input name="in1" type="float" nodename="{source}"/><input name="in2" type="float" value="3"/></multiply>')
            add(f'<floor name="I_{name}" type="integer"><input name="in" type="float" nodename="I_{name}_m"/></floor>')
            source = f"I_{name}"
        elif ty == "boolean":
            lines.append(lines.pop(-2))
            source = f"I_{name}"
        elif COUNTS[ty] > 1:
            parts = "".join(f'<input name="in{i + 1}" type="float" nodename="I_{name}_{i}"/>' for i in range(COUNTS[ty]))
            add(f'<combine{COUNTS[ty]} name="I_{name}" type="{ty}">{parts}</combine{COUNTS[ty]}>')
            source = f"I_{name}"
            if name in ("normal", "tangent", "bitangent"):
                add(f'<normalize name="U_{name}" type="vector3"><input name="in" type="vector3" nodename="{source}"/></normalize>')
                source = f"U_{name}"
        inputs.append(f'<input name="{name}" type="{ty}" nodename="{source}"/>')
    outputs = [(o.getName(), o.getType()) for o in definition.getActiveOutputs()]
    ty = definition.getType()
    add(f'<{definition.getNodeString()} name="N" type="{ty}" nodedef="{definition.getName()}">' + "".join(inputs) + f"</{definition.getNodeString()}>")
    parts = []  # numbers of the result, as attributes of an input
    for name, ty in outputs:
        output = f' output="{name}"' if len(outputs) > 1 else ""
        if ty not in COUNTS:
            return None, f"gives {ty}"
        if ty in ("integer", "boolean"):
            add(f'<convert name="F_{name}" type="float"><input name="in" type="{ty}" nodename="N"{output}/></convert>')
            parts.append(f'nodename="F_{name}"')
        elif COUNTS[ty] == 1:
            parts.append(f'nodename="N"{output}')
        else:
            add(f'<separate{COUNTS[ty]} name="S_{name}" type="multioutput"><input name="in" type="{ty}" nodename="N"{output}/></separate{COUNTS[ty]}>')
            letters = "rgba" if ty.startswith("color") else "xyzw"
            parts += [f'nodename="S_{name}" output="out{letters[i]}"' for i in range(COUNTS[ty])]
    materials = []
    tail = []
    for k in range(0, len(parts), 3):
        group = (parts[k : k + 3] * 3)[:3]
        ports = "".join(f'<input name="in{i + 1}" type="float" {part}/>' for i, part in enumerate(group))
        add(f'<combine3 name="C{k}" type="color3">{ports}</combine3>')
        add(f'<output name="O{k}" type="color3" nodename="C{k}"/>')
        materials.append(f"M{k}")
        tail.append(f'<standard_surface name="S{k}" type="surfaceshader"><input name="emission" type="float" value="1"/><input name="emission_color" type="color3" nodegraph="g" output="O{k}"/></standard_surface>')
        tail.append(f'<surfacematerial name="M{k}" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S{k}"/></surfacematerial>')
    body = "\n    ".join(lines)
    return '<?xml version="1.0"?>\n<materialx version="1.39">\n  <nodegraph name="g">\n    ' + body + "\n  </nodegraph>\n  " + "\n  ".join(tail) + "\n</materialx>\n", materials


def library():
    import MaterialX as mx

    lib = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), lib)
    found = []
    for definition in lib.getNodeDefs():
        types = [output.getType() for output in definition.getActiveOutputs()]
        if definition.getNodeGroup() in GROUPS and all(ty in COUNTS for ty in types):
            found.append(definition)
    return lib, found


def has_image(definition):
    return any(port.getType() == "filename" for port in definition.getActiveInputs())


def generate(lib, text, output, out):
    """MaterialX's OSL of an output of the document."""
    import MaterialX as mx
    import MaterialX.PyMaterialXGenOsl as osl
    import MaterialX.PyMaterialXGenShader as shader

    doc = mx.createDocument()
    mx.readFromXmlString(doc, text)
    doc.setDataLibrary(lib)
    generator = osl.OslShaderGenerator.create()
    context = shader.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    # As MaterialX's own tests of its OSL have it: v goes upwards.
    context.getOptions().fileTextureVerticalFlip = True
    generator.registerTypeDefs(doc)
    element = doc.getNodeGraph("g").getOutput(output)
    source = generator.generate("s", element, context).getSourceCode("pixel")
    source = source.replace('"image.png"', f'"{out}/image.png"')
    if "hextiled" in text:
        # These have no input for the filter.
        source = source.replace('"swrap"', '"interp", "closest", "swrap"')
    folder = Path(mx.__file__).parent / "libraries/stdlib/genosl/include"
    return source.replace('"mx_funcs.h"', f'"{folder}/mx_funcs.h"')


class Cycles:
    """A plane from -1 to 1, rendered with a script for its emission, 16 by 16 pixels."""

    def __init__(self, out):
        import bpy

        inner = Path(bpy.utils.resource_path("LOCAL")) / "python/lib/python3.11/site-packages"
        sys.path.append(str(inner))
        self.bpy, self.out = bpy, out
        scene = bpy.context.scene
        for thing in list(bpy.data.objects):
            bpy.data.objects.remove(thing)
        scene.render.engine = "CYCLES"
        scene.cycles.device = "CPU"
        scene.cycles.shading_system = True
        scene.cycles.samples = 1
        scene.cycles.use_denoising = False
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.pixel_filter_type = "BOX"
        scene.cycles.filter_width = 0.01
        scene.cycles.sample_clamp_direct = 0
        scene.cycles.sample_clamp_indirect = 0
        scene.cycles.max_bounces = 0
        scene.render.threads_mode = "FIXED"
        scene.render.threads = 1
        scene.render.resolution_x = scene.render.resolution_y = SIDE
        scene.render.resolution_percentage = 100
        bpy.ops.mesh.primitive_plane_add(size=2)
        plane = bpy.context.object
        camera = bpy.data.cameras.new("camera")
        camera.type, camera.ortho_scale = "ORTHO", 2
        camera = bpy.data.objects.new("camera", camera)
        camera.location = (0, 0, 3)
        scene.collection.objects.link(camera)
        scene.camera = camera
        material = bpy.data.materials.new("material")
        material.use_nodes = True
        self.tree = material.node_tree
        self.tree.nodes.clear()
        self.script = self.tree.nodes.new("ShaderNodeScript")
        self.script.mode = "EXTERNAL"
        self.emission = self.tree.nodes.new("ShaderNodeEmission")
        output = self.tree.nodes.new("ShaderNodeOutputMaterial")
        self.tree.links.new(self.emission.outputs[0], output.inputs["Surface"])
        plane.data.materials.append(material)
        settings = scene.render.image_settings
        if hasattr(settings, "media_type"):
            settings.media_type = "IMAGE"
        settings.file_format, settings.color_depth = "OPEN_EXR", "32"
        settings.exr_codec = "NONE"
        self.path = str(out / "render.exr")
        scene.render.filepath = self.path

    def compile(self, source, name):
        """Compiles in a process of its own: a source that is refused ends it."""
        import _cycles

        path = str(self.out / f"{name}.osl")
        Path(path).write_text(source)
        child = os.fork()
        if child == 0:
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, 1)
            os.dup2(null, 2)
            os._exit(0 if _cycles.osl_compile(path, path[:-1] + "o") else 3)
        return os.waitpid(child, 0)[1] == 0 and path[:-1] + "o"

    def render(self, compiled):
        from cycles import osl

        self.script.filepath = compiled
        osl.update_script_node(self.script, lambda *message: None)
        self.tree.links.new(self.script.outputs[0], self.emission.inputs["Color"])
        self.bpy.ops.render.render(write_still=True)
        image = self.bpy.data.images.load(self.path, check_existing=False)
        pixels = np.empty(SIDE * SIDE * 4, np.float32)
        image.pixels.foreach_get(pixels)
        self.bpy.data.images.remove(image)
        return pixels.reshape(-1, 4)[:, :3].copy()


def picture():
    """A PNG of 8 by 8 opaque pixels, all different."""
    import struct

    random = np.random.default_rng(3)
    rows = random.integers(0, 256, (8, 8, 4), np.uint8)
    rows[:, :, 3] = 255
    raw = b"".join(b"\0" + row.tobytes() for row in rows)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = struct.pack(">IIBBBBB", 8, 8, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")


def make(out, with_images=False):
    lib, definitions = library()
    definitions = [definition for definition in definitions if has_image(definition) == with_images]
    out.mkdir(parents=True, exist_ok=True)
    (out / "image.png").write_bytes(picture())
    cycles = Cycles(out)
    points = cycles.compile("shader points(output color c = 0) { c = color(P); }", "points")
    cycles.render(points).tofile(out / "points.f32")
    refused = {}
    for definition in definitions:
        name = definition.getName()
        text, materials = document(definition)
        if text is None:
            refused[name] = materials
            continue
        ours = text
        if "hextiled" in name:
            ours = re.sub("(</hextiled)", '<input name="filtertype" type="string" value="closest"/>' + r"\1", text)
        (out / f"{name}.mtlx").write_text(ours)
        for material in materials:
            if (out / f"{name}.{material}.osl.f32").exists():
                continue
            try:
                source = generate(lib, text, material.replace("M", "O"), out)
            except Exception as error:
                refused[name] = "MaterialX generates no OSL: " + str(error).splitlines()[0][:80]
                break
            compiled = cycles.compile(source, f"{name}.{material}")
            if not compiled:
                refused[name] = "its OSL does not compile"
                break
            cycles.render(compiled).tofile(out / f"{name}.{material}.osl.f32")
    with open(out / "refused.txt", "a" if with_images else "w") as file:
        file.writelines(f"{name}: {why}\n" for name, why in sorted(refused.items()))


def images(out):
    """Definitions that read images: in a process of their own, since the cache of images, which all its scripts share, gives other
    pixels after hundreds of others."""
    make(out, with_images=True)


def check(out):
    _, definitions = library()
    refused = dict(line.split(": ", 1) for line in (out / "refused.txt").read_text().splitlines())
    groups = defaultdict(lambda: [0, 0])
    short = []
    for definition in definitions:
        name = definition.getName()
        group = groups[definition.getNodeGroup()]
        group[1] += 1
        why = refused.get(name) or compare(out, name)
        if why is None:
            group[0] += 1
        else:
            short.append((definition.getNodeGroup(), name, why))
    for group, name, why in sorted(short):
        print(f"{group:14} {name:44} {why}")
    print()
    for group, (same, all_) in sorted(groups.items()):
        print(f"| {group} | {same} | {all_} |")
    same, all_ = (sum(group[i] for group in groups.values()) for i in (0, 1))
    print(f"| all | {same} | {all_} |")


def compare(out, name):
    """Why values differ; None where they don't."""
    references = sorted(out.glob(f"{name}.M*.osl.f32"))
    if not references:
        return "no reference"
    for reference in references:
        ours = Path(str(reference).replace(".osl.f32", ".f32"))
        if not ours.exists():
            return "Patina gives nothing"
        wanted = np.fromfile(reference, np.float32)
        given = np.fromfile(ours, np.float32)
        known = np.isfinite(wanted) & (np.abs(wanted) < 1e30)
        far = np.abs(given - wanted)[known] / np.maximum(1.0, np.abs(wanted[known]))
        off = ~(far <= LIMIT)
        if off.any():
            return f"{off.sum()} of {off.size} numbers differ, by {np.nanmax(far):.2g} at most"
    return None


if __name__ == "__main__":
    {"make": make, "images": images, "check": check}[sys.argv[1]](Path(sys.argv[2]).resolve())
