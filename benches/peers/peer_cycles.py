"""Blender Cycles on the CPU, through Blender's Python module."""

import re
from pathlib import Path

import numpy as np

from gltf import read
from jobs import Render, Result, TextureCase, increase, run, spread, timed

# Edits of a parameter whose time is taken.
EDITS = 9


def version():
    import bpy

    return bpy.app.version_string


def _settings(job):
    """What makes Cycles render what the others render."""
    import bpy

    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = job.width, job.height
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", job.threads
    output = scene.render.image_settings
    output.file_format, output.color_mode, output.color_depth = "OPEN_EXR", "RGB", "32"
    output.exr_codec = "NONE"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.use_guiding = False
    # Pays with many lamps; there are one or two.
    cycles.use_light_tree = False
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.use_auto_tile = False
    # Cycles doesn't count the first vertex.
    bounces = job.max_depth - 1
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = bounces
    cycles.transmission_bounces = cycles.transparent_max_bounces = bounces
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.seed = job.seed
    return scene


def _load(job):
    """Blender's scene, and its materials by name."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = _settings(job)
    source = read(job.scene)
    materials = [_material(material) for material in source.materials]
    for mesh in source.meshes:
        # glTF's axes are kept: Cycles knows no up.
        placed = bpy.data.objects.new(mesh.name, _mesh(mesh))
        placed.data.materials.append(materials[mesh.material])
        scene.collection.objects.link(placed)
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit = "VERTICAL"
    lens.angle = source.camera.y_fov
    lens.clip_start = 0.001
    camera = bpy.data.objects.new("camera", lens)
    camera.matrix_world = source.camera.to_world.T.tolist()
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = _world(job.environment)
    return scene, {material.name: made for material, made in zip(source.materials, materials, strict=True)}


def _world(environment):
    import bpy

    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*environment, 1.0)
    return world


def _mesh(mesh):
    import bpy

    made = bpy.data.meshes.new(mesh.name)
    corners = mesh.triangles.astype(np.int32).ravel()
    made.vertices.add(len(mesh.positions))
    made.vertices.foreach_set("co", mesh.positions.astype(np.float32).ravel())
    made.loops.add(len(corners))
    made.loops.foreach_set("vertex_index", corners)
    made.polygons.add(len(mesh.triangles))
    made.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
    # Blender's v points up.
    uvs = (mesh.uvs * [1.0, -1.0] + [0.0, 1.0]).astype(np.float32)
    made.uv_layers.new(name="uv").data.foreach_set("uv", uvs[corners].ravel())
    made.update(calc_edges=True)
    made.normals_split_custom_set_from_vertices(mesh.normals.astype(np.float32))
    return made


def _material(material):
    import bpy

    made = bpy.data.materials.new(material.name or "material")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    if material.emits:
        shader = tree.nodes.new("ShaderNodeEmission")
        shader.inputs["Color"].default_value = (*material.emission, 1.0)
        made.cycles.emission_sampling = "FRONT"
    else:
        shader = _surface(tree, material)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def _surface(tree, material):
    if material.metallic:
        shader = tree.nodes.new("ShaderNodeBsdfMetallic")
        shader.distribution, shader.fresnel_type = "GGX", "F82"
        shader.inputs["Base Color"].default_value = (*material.color, 1.0)
        # White at 82 degrees leaves Schlick's term as it is.
        shader.inputs["Edge Tint"].default_value = (1.0, 1.0, 1.0, 1.0)
        shader.inputs["Roughness"].default_value = material.roughness
        return shader
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*material.color, 1.0)
    if material.image is not None:
        import bpy

        image = tree.nodes.new("ShaderNodeTexImage")
        image.image = bpy.data.images.load(str(material.image), check_existing=True)
        # Else colours are multiplied by an alpha that nobody asks for.
        image.image.alpha_mode = "NONE"
        factor = tree.nodes.new("ShaderNodeVectorMath")
        factor.operation = "MULTIPLY"
        factor.inputs[1].default_value = material.color
        tree.links.new(image.outputs["Color"], factor.inputs[0])
        tree.links.new(factor.outputs["Vector"], shader.inputs["Color"])
    return shader


def _render(scene, path, spp):
    """Renders to an OpenEXR file; seconds of rendering alone, as Cycles writes them into it."""
    import bpy
    import OpenEXR

    scene.cycles.samples = spp
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    header = OpenEXR.File(str(path), header_only=True).header()
    key = next(key for key in header if re.fullmatch(r"cycles\..*\.render_time", key))
    return _seconds(header[key])


def _seconds(text):
    """Of `MM:SS.ss` or `HH:MM:SS.ss`."""
    total = 0.0
    for part in text.split(":"):
        total = 60.0 * total + float(part)
    return total


def _details(job):
    return f"CPU, {job.threads} threads, light tree off"


def render(job):
    def load():
        scene, _ = _load(job)
        _render(scene, job.picture("cycles-warm-up.exr"), 1)
        return scene

    scene, seconds = timed(load)
    result = Result(_details(job), seconds)
    for spp in job.spp:
        path = job.picture(f"cycles-{spp}-{job.seed}.exr")
        result.renders.append(Render(spp, _render(scene, path, spp), str(path)))
    return result


def textures(job):
    import cycles_textures

    (scene, materials), seconds = timed(lambda: _load(job))
    result = Result(_details(job), seconds)
    spp = job.spp[0]
    cases = [("gray", 0), ("scratches", 0), *(("rust", rays) for rays in job.ao_samples)]
    times = {case: [] for case in cases}
    pictures = {}
    graph = cycles_textures.Graph(materials[job.material])
    # The first run isn't counted.
    for number in range(job.runs + 1):
        for texture, rays in cases:
            graph.show(texture, rays)
            path = Path(job.picture(f"cycles-{texture}-{rays}.exr"))
            taken = _render(scene, path, spp)
            pictures[texture, rays] = str(path)
            if number > 0:
                times[texture, rays].append(taken)
    for rays in job.ao_samples:
        for case in cases:
            texture = case[0]
            if texture == "rust" and case[1] != rays:
                continue
            edit_ms, unedited_ms = _edits(scene, graph, texture, rays)
            result.cases.append(
                TextureCase(
                    "nodes", texture, rays, spread(times[case])["median"] * 1e3 / spp,
                    increase(times[case], times["gray", 0]), edit_ms, unedited_ms, pictures[case],
                )
            )  # fmt: skip
    return result


def _edits(scene, graph, texture, rays):
    """Medians of milliseconds to one sample of all pixels: after an edit, and without one."""
    import bpy

    graph.show(texture, rays)
    scene.render.use_persistent_data = True
    # With persistent data a later change of this number goes unheard.
    scene.cycles.samples = 1
    bpy.ops.render.render()
    edited, unedited = [], []
    for number in range(EDITS):
        unedited.append(timed(bpy.ops.render.render)[1] * 1e3)
        if texture != "gray":
            edited.append(timed(lambda number=number: (graph.edit(texture, number), bpy.ops.render.render()))[1] * 1e3)
    scene.render.use_persistent_data = False
    edit_ms = spread(edited)["median"] if edited else 0.0
    return edit_ms, spread(unedited)["median"]


if __name__ == "__main__":
    run(version, render, textures)
