"""Renders MaterialX's example materials by MaterialX's own OSL in Cycles, on a ball between three lamps.

    python benches/materialx/examples.py make OUT EXAMPLES
    python benches/materialx/examples.py sheet OUT PICTURE

`make` writes the scene as OUT/ball.gltf, and for each material OUT/NAME.look.toml, for Patina, and OUT/NAME.cycles.exr. `sheet` puts
these pictures beside OUT/NAME.patina.exr. `cargo xtask materialx --examples DIR` does all.
"""

import base64
import json
import sys
from pathlib import Path

import numpy as np

from judge import Cycles

NAMES = [
    "standard_surface_marble_solid", "standard_surface_carpaint", "standard_surface_copper",
    "standard_surface_glass_tinted", "standard_surface_jade", "standard_surface_metal_brushed",
    "open_pbr_aluminum_brushed", "open_pbr_pearl", "gltf_pbr_carpaint",
    "usd_preview_surface_carpaint", "Copper_Old", "Motley_Patchwork_Rug",
]
SIDE = 192
SPP = 256
DEPTH = 12
BACKGROUND = 0.25
EYE, TARGET, FOV = np.array([0.0, 1.1, 5.2]), np.array([0.0, 0.0, 0.0]), 0.46
# Middles, half sides and radiance of the lamps, which look at the ball's middle.
LAMPS = [((-4.0, 4.0, 3.0), 1.2, 7.0), ((4.5, 2.5, 1.5), 0.7, 9.0), ((0.5, 4.5, -4.0), 1.5, 4.0)]


def ball(columns=192, rows=96):
    """Positions, normals, texture coordinates with v upwards, triangles. Y is up."""
    u, v = np.meshgrid(np.arange(columns + 1) / columns, np.arange(rows + 1) / rows)
    around, down = 2 * np.pi * u.ravel(), np.pi * v.ravel()
    p = np.stack([-np.cos(around) * np.sin(down), -np.cos(down), np.sin(around) * np.sin(down)], 1)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    above = first + columns + 1
    triangles = np.concatenate([
        np.stack([first, first + 1, above + 1], 1)[columns:],
        np.stack([first, above + 1, above], 1)[:-columns],
    ])
    return p, p, np.stack([u.ravel(), v.ravel()], 1), triangles


def quad(middle, x, y):
    middle, x, y = (np.array(a, float) for a in (middle, x, y))
    p = np.stack([middle - x - y, middle + x - y, middle + x + y, middle - x + y])
    n = np.cross(x, y)
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    return p, np.repeat([n / np.linalg.norm(n)], 4, 0), uv, np.array([[0, 1, 2], [0, 2, 3]])


def joined(parts):
    offsets = np.cumsum([0] + [len(part[0]) for part in parts])
    arrays = [np.concatenate([part[i] for part in parts]) for i in range(3)]
    return (*arrays, np.concatenate([part[3] + offset for part, offset in zip(parts, offsets)]))


def scene():
    """Names of materials with what has them, their colour and whether they shine."""
    tiles = [[], []]
    for i in range(-6, 6):
        for j in range(-6, 6):
            tiles[(i + j) % 2].append(quad((0.5 * i + 0.25, -1.0, 0.5 * j + 0.25), (0.25, 0, 0), (0, 0, -0.25)))
    parts = [("Ball", ball(), 0.5, False), ("Dark", joined(tiles[0]), 0.1, False), ("Light", joined(tiles[1]), 0.5, False)]
    for i, (middle, size, radiance) in enumerate(LAMPS):
        towards = -np.array(middle) / np.linalg.norm(middle)
        x = np.cross((0.0, 1.0, 0.0), towards)
        x *= size / np.linalg.norm(x)
        parts.append((f"Lamp{i}", quad(middle, x, np.cross(towards, x)), radiance, True))
    return parts


def write_gltf(path):
    data, views, accessors, meshes, materials = b"", [], [], [], []

    def accessor(array, component, kind):
        nonlocal data
        raw = array.tobytes()
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(raw)})
        data += raw
        entry = {"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind}
        if kind == "VEC3":
            entry |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
        accessors.append(entry)
        return len(accessors) - 1

    for name, (p, n, uv, triangles), value, shines in scene():
        down = uv * [1, -1] + [0, 1]
        attributes = {
            "POSITION": accessor(p.astype(np.float32), 5126, "VEC3"),
            "NORMAL": accessor(n.astype(np.float32), 5126, "VEC3"),
            "TEXCOORD_0": accessor(down.astype(np.float32), 5126, "VEC2"),
        }
        indices = accessor(triangles.astype(np.uint32).ravel(), 5125, "SCALAR")
        meshes.append({"primitives": [{"attributes": attributes, "indices": indices, "material": len(materials)}]})
        color = 0.0 if shines else value
        material = {"name": name, "doubleSided": True}
        material["pbrMetallicRoughness"] = {"baseColorFactor": [color] * 3 + [1], "metallicFactor": 0, "roughnessFactor": 1}
        # Plain Lambertian surfaces beside the one that is looked at.
        material["extensions"] = {"KHR_materials_specular": {"specularFactor": 0}}
        if shines:
            material["emissiveFactor"] = [1, 1, 1]
            material["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": value}
        if name == "Ball":
            material = {"name": name}
        materials.append(material)
    eye = (EYE - TARGET) / np.linalg.norm(EYE - TARGET)
    right = np.cross((0.0, 1.0, 0.0), eye)
    right /= np.linalg.norm(right)
    matrix = [*right, 0, *np.cross(eye, right), 0, *eye, 0, *EYE, 1]
    nodes = [{"mesh": i} for i in range(len(meshes))] + [{"camera": 0, "matrix": [float(x) for x in matrix]}]
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes,
        "materials": materials, "accessors": accessors, "bufferViews": views,
        "cameras": [{"type": "perspective", "perspective": {"yfov": FOV, "aspectRatio": 1, "znear": 0.1}}],
        "extensionsUsed": ["KHR_materials_specular", "KHR_materials_emissive_strength"],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
    }
    path.write_text(json.dumps(gltf))


def generate(path):
    """MaterialX's OSL of the first material of a document, as a closure."""
    import MaterialX as mx
    import MaterialX.PyMaterialXFormat as files
    import MaterialX.PyMaterialXGenOsl as osl
    import MaterialX.PyMaterialXGenShader as shader

    lib = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), lib)
    doc = mx.createDocument()
    mx.readFromXmlFile(doc, str(path))
    doc.setDataLibrary(lib)
    files.flattenFilenames(doc, files.FileSearchPath(str(path.parent)))
    generator = osl.OslShaderGenerator.create()
    context = shader.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    context.getOptions().fileTextureVerticalFlip = True
    # Colours of images and constants are converted as the document says.
    colors = shader.DefaultColorManagementSystem.create(generator.getTarget())
    colors.loadLibrary(lib)
    generator.setColorManagementSystem(colors)
    context.getOptions().targetColorSpaceOverride = "lin_rec709"
    generator.registerTypeDefs(doc)
    source = generator.generate("s", doc.getMaterialNodes()[0], context).getSourceCode("pixel")
    folder = Path(mx.__file__).parent / "libraries/stdlib/genosl/include"
    source = source.replace('"mx_funcs.h"', f'"{folder}/mx_funcs.h"')
    # Cycles' u, v and dPdu are the triangle's own; those of the mesh come by sockets.
    head, body = source.rsplit("output MATERIAL out = 0", 1)
    head += "vector mesh_uv = vector(0), vector mesh_tangent = vector(0), output MATERIAL out = 0"
    for own, ours in [("vector2(u,v)", "vector2(mesh_uv[0], mesh_uv[1])"), ("dPdu", "mesh_tangent"), ("dPdv", "cross(N, mesh_tangent)")]:
        body = body.replace(own, ours)
    return head + body


class Studio(Cycles):
    """The same scene in Cycles, coordinates as they are: Y is up there, too."""

    def __init__(self, out):
        super().__init__(out)
        bpy, scene_ = self.bpy, self.bpy.context.scene
        for thing in list(bpy.data.objects):
            bpy.data.objects.remove(thing)
        settings = scene_.cycles
        settings.samples, settings.max_bounces = SPP, DEPTH
        for kind in ("diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
            setattr(settings, kind, DEPTH)
        settings.blur_glossy = 0
        settings.filter_width = 1.0
        scene_.render.threads_mode = "AUTO"
        scene_.render.resolution_x = scene_.render.resolution_y = SIDE
        for name, (p, _, uv, triangles), value, shines in scene():
            mesh = bpy.data.meshes.new(name)
            mesh.from_pydata(p.tolist(), [], triangles.tolist())
            layer = mesh.uv_layers.new(name="UVMap")
            layer.data.foreach_set("uv", uv[triangles.ravel()].astype(np.float32).ravel())
            mesh.polygons.foreach_set("use_smooth", [name == "Ball"] * len(triangles))
            mesh.materials.append(bpy.data.materials["material"] if name == "Ball" else self.plain(name, value, shines))
            scene_.collection.objects.link(bpy.data.objects.new(name, mesh))
        self.place_camera(scene_)
        world = bpy.data.worlds.new("world")
        world.use_nodes = True
        world.node_tree.nodes["Background"].inputs[0].default_value = (BACKGROUND, BACKGROUND, BACKGROUND, 1)
        scene_.world = world
        uv, tangent = self.tree.nodes.new("ShaderNodeUVMap"), self.tree.nodes.new("ShaderNodeTangent")
        uv.uv_map = tangent.uv_map = "UVMap"
        tangent.direction_type = "UV_MAP"
        self.mesh_sockets = {"mesh_uv": uv.outputs[0], "mesh_tangent": tangent.outputs[0]}
        self.surface = next(node for node in self.tree.nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"]

    def plain(self, name, value, shines):
        material = self.bpy.data.materials.new(name)
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        node = tree.nodes.new("ShaderNodeEmission" if shines else "ShaderNodeBsdfDiffuse")
        node.inputs["Color"].default_value = (1, 1, 1, 1) if shines else (value, value, value, 1)
        if shines:
            node.inputs["Strength"].default_value = value
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(node.outputs[0], output.inputs["Surface"])
        return material

    def place_camera(self, scene_):
        from mathutils import Matrix, Vector

        camera = self.bpy.data.cameras.new("eye")
        camera.angle = FOV
        thing = self.bpy.data.objects.new("eye", camera)
        eye = Vector((EYE - TARGET).tolist()).normalized()
        right = Vector((0, 1, 0)).cross(eye).normalized()
        up = eye.cross(right)
        thing.matrix_world = Matrix([[right[i], up[i], eye[i], float(EYE[i])] for i in range(3)] + [[0, 0, 0, 1]])
        scene_.collection.objects.link(thing)
        scene_.camera = thing

    def shoot(self, compiled, path):
        from cycles import osl

        self.script.filepath = compiled
        osl.update_script_node(self.script, lambda *message: None)
        for name, source in self.mesh_sockets.items():
            self.tree.links.new(source, self.script.inputs[name])
        self.tree.links.new(self.script.outputs[0], self.surface)
        self.bpy.context.scene.render.filepath = str(path)
        self.bpy.ops.render.render(write_still=True)


def make(out, examples):
    out.mkdir(parents=True, exist_ok=True)
    write_gltf(out / "ball.gltf")
    found = {path.stem: path for path in examples.rglob("*.mtlx")}
    missing = [name for name in NAMES if name not in found]
    if missing:
        sys.exit(f"{examples} has no {', '.join(missing)}: it should be resources/Materials/Examples of MaterialX 1.39")
    studio = Studio(out)
    for name in NAMES:
        look = f'environment = {{ color = [{BACKGROUND}, {BACKGROUND}, {BACKGROUND}] }}\n[[materialx]]\nfile = {json.dumps(str(found[name]))}\nname = "Ball"\n'
        (out / f"{name}.look.toml").write_text(look)
        picture = out / f"{name}.cycles.exr"
        if picture.exists():
            continue
        compiled = studio.compile(generate(found[name]), name)
        if not compiled:
            sys.exit(f"the OSL of {name} does not compile")
        studio.shoot(compiled, picture)


def sheet(out, path):
    """Pairs, three in a row: left by Patina, right by Cycles."""
    import bpy

    def pixels(name):
        image = bpy.data.images.load(str(out / name))
        image.colorspace_settings.name = "Non-Color"
        values = np.empty(SIDE * SIDE * 4, np.float32)
        image.pixels.foreach_get(values)
        return values.reshape(SIDE, SIDE, 4)[:, :, :3]

    rows = []
    for first in range(0, len(NAMES), 3):
        pair = lambda name: [pixels(f"{name}.patina.exr"), pixels(f"{name}.cycles.exr"), np.ones((SIDE, 6, 3))]
        rows += [np.concatenate(sum((pair(name) for name in NAMES[first : first + 3]), [])[:-1], 1)]
        rows += [np.ones((6, rows[0].shape[1], 3))]
    # The lowest row comes first.
    linear = np.clip(np.concatenate(rows[-2::-1]), 0, 1)
    shown = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    image = bpy.data.images.new("sheet", shown.shape[1], shown.shape[0])
    image.pixels.foreach_set(np.concatenate([shown, np.ones_like(shown[:, :, :1])], 2).astype(np.float32).ravel())
    image.file_format = "JPEG"
    image.filepath_raw = str(path)
    image.save(quality=90)


if __name__ == "__main__":
    {"make": make, "sheet": sheet}[sys.argv[1]](*(Path(argument).resolve() for argument in sys.argv[2:]))
