"""LuxCoreRender, its path tracer on the CPU."""

import time

import numpy as np

from gltf import read
from jobs import Render, Result, run, timed


def version():
    import pyluxcore

    return pyluxcore.Version()


def _set(properties, prefix, values):
    import pyluxcore

    for key, value in values.items():
        properties.Set(pyluxcore.Property(f"{prefix}.{key}", list(value) if isinstance(value, tuple) else value))


def _scene(job):
    import pyluxcore

    source = read(job.scene)
    scene = pyluxcore.Scene()
    properties = pyluxcore.Properties()
    camera = source.camera
    # The field of view is that of the shorter side.
    y_fov = np.degrees(camera.y_fov)
    shorter = y_fov
    if job.width < job.height:
        shorter = np.degrees(2.0 * np.arctan(np.tan(0.5 * camera.y_fov) * job.width / job.height))
    # The picture comes out one row too low: the window on it is moved down by as much.
    half_width, half_height = max(job.width / job.height, 1.0), max(job.height / job.width, 1.0)
    row = 2.0 * half_height / job.height
    _set(properties, "scene.camera", {
        "type": "perspective",
        "lookat.orig": tuple(camera.position.tolist()),
        "lookat.target": tuple(camera.target.tolist()),
        "up": tuple(camera.up.tolist()),
        "fieldofview": float(shorter),
        "screenwindow": (-half_width, half_width, -half_height - row, half_height - row),
        "autovolume.enable": 0,
    })  # fmt: skip
    for number, material in enumerate(source.materials):
        _material(properties, number, material)
    if max(job.environment) > 0.0:
        sky = {"type": "constantinfinite", "color": tuple(float(e) for e in job.environment)}
        _set(properties, "scene.lights.sky", sky)
    scene.Parse(properties)
    shapes = pyluxcore.Properties()
    for number, mesh in enumerate(source.meshes):
        name = f"mesh{number}"
        scene.DefineMesh(
            name,
            [tuple(p) for p in mesh.positions.tolist()],
            [tuple(t) for t in mesh.triangles.tolist()],
            [tuple(n) for n in mesh.normals.tolist()],
            [tuple(uv) for uv in mesh.uvs.tolist()],
            None,
            None,
        )
        _set(shapes, f"scene.objects.object{number}", {"shape": name, "material": f"material{mesh.material}"})
    scene.Parse(shapes)
    return scene


def _material(properties, number, material):
    color = tuple(float(c) for c in material.color)
    if material.image is not None:
        image = f"scene.textures.image{number}"
        _set(properties, image, {
            "type": "imagemap",
            "file": str(material.image),
            # Images are sRGB; LuxCore takes a plain exponent.
            "gamma": 2.2,
            "mapping.type": "uvmapping2d",
        })  # fmt: skip
        color_name = f"scale{number}"
        factor = {"type": "scale", "texture1": f"image{number}", "texture2": color}
        _set(properties, f"scene.textures.{color_name}", factor)
        color = color_name
    prefix = f"scene.materials.material{number}"
    if material.metallic:
        _set(properties, prefix, {"type": "disney", "basecolor": color, "metallic": 1.0, "specular": 0.5,
                                  "roughness": material.roughness})  # fmt: skip
    else:
        _set(properties, prefix, {"type": "matte", "kd": color})
    if material.emits:
        _set(properties, prefix, {"emission": tuple(float(e) for e in material.emission)})


def _render(scene, job, spp):
    """The picture, and seconds of rendering."""
    import pyluxcore

    properties = pyluxcore.Properties()
    _set(properties, "renderengine", {"type": "PATHCPU", "seed": job.seed + 1})
    _set(properties, "sampler", {"type": "SOBOL"})
    _set(properties, "native", {"threads.count": job.threads})
    _set(properties, "path", {
        "pathdepth.total": job.max_depth,
        "pathdepth.diffuse": job.max_depth,
        "pathdepth.glossy": job.max_depth,
        "pathdepth.specular": job.max_depth,
        "clamping.variance.maxvalue": 0.0,
    })  # fmt: skip
    _set(properties, "film", {
        "width": job.width,
        "height": job.height,
        "filter.type": "BOX",
        "filter.width": 0.5,
        "noiseestimation.warmup": 1_000_000,
        "outputs.0.type": "RGB",
        "outputs.0.filename": "unused.exr",
    })  # fmt: skip
    _set(properties, "batch", {"haltspp": spp})
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties, scene))
    # Builds its hierarchy before the first sample.
    session.Start()
    start = time.perf_counter()
    while not session.HasDone():
        time.sleep(0.005)
        session.UpdateStats()
    seconds = time.perf_counter() - start
    session.Stop()
    pixels = np.zeros(job.width * job.height * 3, np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels)
    # Rows come from the bottom up.
    return pixels.reshape(job.height, job.width, 3)[::-1], seconds


def render(job):
    import pyluxcore

    # Without a function for its log: that would be called after the interpreter is gone.
    pyluxcore.Init()

    def load():
        scene = _scene(job)
        _render(scene, job, 1)
        return scene

    scene, seconds = timed(load)
    result = Result("PATHCPU, Sobol", seconds)
    for spp in job.spp:
        picture, taken = _render(scene, job, spp)
        path = job.picture(f"luxcore-{spp}-{job.seed}.npy")
        np.save(path, picture)
        result.renders.append(Render(spp, taken, str(path)))
    return result


if __name__ == "__main__":
    run(version, render)
