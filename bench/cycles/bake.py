"""Bakes a model's ambient occlusion with Cycles, into one image for each material.

    blender -b --factory-startup -P bake.py -- MODEL OUT.exr --size 2048 --samples 256 --distance 0.3

A model with several materials gives OUT-MATERIAL.exr for each. A map holds visibility, 1 open, in R, G and B; A is 1 where a
texel was baked and 0 elsewhere. Prints one line of JSON. Runs by `python bake.py -- ...` too, where the module bpy is there.

Adaptive sampling stays off: it watches the picture of all light, which is black here, and stops at once.
"""

import argparse
import json
import math
import os
import pathlib
import re
import resource
import sys
import time

import bpy
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from gltf import Gltf  # noqa: E402

UV = "bake"
# A distance of 0 would leave all open, and infinity is no number to Blender.
FARTHEST = 1e10
# The glTF reader of Blender 3.4 uses a name that numpy 1.24 no longer has.
vars(numpy).setdefault("bool", bool)


def arguments():
    parser = argparse.ArgumentParser(prog="bake.py", description=__doc__.splitlines()[0])
    parser.add_argument("model", help=".glb or .gltf")
    parser.add_argument("out", help="OUT.exr")
    parser.add_argument("--size", type=int, default=1024, help="texels on each side of a map")
    parser.add_argument("--samples", type=int, default=64, help="rays for each texel")
    parser.add_argument("--distance", type=float, default=math.inf, help="how far an occluder counts; inf: however far")
    parser.add_argument("--alpha", default="material", choices=["material", "opaque"], help="whether opacity counts")
    parser.add_argument("--uv", help="name or number of the UV map; without it the one that occlusion is read by")
    parser.add_argument("--margin", type=int, default=0, help="texels by which islands are extended")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])


def load(model, wanted_uv, margin):
    """The meshes of a model in an otherwise empty scene, each with the wanted UV map alone, called `UV`."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # A margin of adjacent faces goes on over edges, which must be joined for it. A few texels change by it.
    bpy.ops.import_scene.gltf(filepath=model, merge_vertices=margin > 0)
    sets = {} if wanted_uv else Gltf(model).uv_sets()
    objects = [it for it in bpy.context.scene.objects if it.type == "MESH"]
    for mesh in {it.data for it in objects}:
        names = [layer.name for layer in mesh.uv_layers]
        wanted = {wanted_uv} if wanted_uv else {sets[it.name] for it in mesh.materials}
        if len(wanted) > 1:
            raise SystemExit(f"{mesh.name}: its materials are read by different UVs")
        name = wanted.pop()
        name = name if name in names else names[int(name)]
        for other in names:
            if other != name:
                mesh.uv_layers.remove(mesh.uv_layers[other])
        mesh.uv_layers[0].name = UV
        into_first_tile(mesh.uv_layers[0].data)
    return objects


def into_first_tile(corners):
    """Moves triangles by whole tiles to where they are read from in a texture that repeats: Cycles bakes one tile."""
    uvs = numpy.empty(2 * len(corners), numpy.float32)
    corners.foreach_get("uv", uvs)
    triangles = uvs.reshape(-1, 3, 2)
    triangles -= numpy.floor(triangles.mean(axis=1, keepdims=True))
    corners.foreach_set("uv", uvs)


def plain(material, size, alpha):
    """Leaves of a material its opacity alone, and gives it the image that is baked into."""
    image = bpy.data.images.new(material.name, size, size, alpha=True, float_buffer=True, is_data=True)
    image.generated_color = (0.0, 0.0, 0.0, 0.0)
    material.use_nodes = True
    tree = material.node_tree
    alphas = [it.inputs["Alpha"] for it in tree.nodes if it.type == "BSDF_PRINCIPLED"]
    if alpha == "opaque" or all(it.default_value == 1.0 and not it.is_linked for it in alphas):
        # What reflects nothing is quickest: after the ray that counts Cycles would trace one more to gather light.
        tree.nodes.clear()
        surface = tree.nodes.new("ShaderNodeEmission")
        surface.inputs["Strength"].default_value = 0.0
        tree.links.new(surface.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    else:
        for link in [it for it in tree.links if it.to_socket.name == "Normal"]:
            tree.links.remove(link)
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    tree.nodes.active = node
    return image


def settings(scene, wanted):
    """One ray a sample, from a surface and no further: no light, no bounces, no denoiser, no tiles."""
    scene.world = bpy.data.worlds.new("black")
    scene.world.color = (0.0, 0.0, 0.0)
    scene.world.light_settings.distance = min(wanted.distance, FARTHEST)
    scene.render.engine = "CYCLES"
    scene.render.threads_mode = "FIXED"
    scene.render.threads = wanted.threads
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = wanted.samples
    cycles.seed = wanted.seed
    cycles.use_denoising = False
    cycles.use_adaptive_sampling = False
    cycles.max_bounces = 0
    cycles.use_auto_tile = False


def join(objects):
    """Makes one object of all: Cycles builds its structures anew for each object that it bakes."""
    bpy.ops.object.select_all(action="DESELECT")
    for item in objects:
        item.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]
    if len(objects) > 1:
        bpy.ops.object.make_single_user(object=True, obdata=True)
        bpy.ops.object.join()
    # By default rays of smooth surfaces start beside the surface.
    bpy.context.object.cycles.shadow_terminator_geometry_offset = 0.0
    bpy.context.object.cycles.shadow_terminator_offset = 0.0


def save(image, path, scene):
    form = scene.render.image_settings
    form.file_format, form.color_mode, form.color_depth, form.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
    image.save_render(os.path.abspath(path), scene=scene)


def main():
    start = time.perf_counter()
    wanted = arguments()
    objects = load(wanted.model, wanted.uv, wanted.margin)
    materials = list({slot.material.name: slot.material for it in objects for slot in it.material_slots}.values())
    images = [plain(it, wanted.size, wanted.alpha) for it in materials]
    settings(bpy.context.scene, wanted)
    join(objects)
    before = time.perf_counter()
    bpy.ops.object.bake(type="AO", margin=wanted.margin, margin_type="ADJACENT_FACES", use_clear=False)
    bake_secs = time.perf_counter() - before
    stem, maps = wanted.out.removesuffix(".exr"), {}
    for material, image in zip(materials, images):
        name = "" if len(images) == 1 else "-" + re.sub(r"[^\w.-]", "-", material.name)
        maps[material.name] = f"{stem}{name}.exr"
        save(image, maps[material.name], bpy.context.scene)
    print(json.dumps({
        "version": bpy.app.version_string, "size": wanted.size, "samples": wanted.samples, "distance": wanted.distance,
        "threads": wanted.threads, "bake_secs": bake_secs, "script_secs": time.perf_counter() - start,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, "maps": maps,
    }), flush=True)


if __name__ == "__main__":
    main()
