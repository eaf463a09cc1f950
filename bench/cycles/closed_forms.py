#!/usr/bin/env python3
"""Both bakers against what geometry says: small scenes of rectangles whose visibility is known.

    closed_forms.py FOLDER [--conray PROGRAM] [--blender PROGRAM]

The floor is a square of side 1 in the plane y = 0, baked with 1024 rays a texel. Figures are of texels that lie inside it.
"""

import argparse
import base64
import json
import math
import pathlib
import subprocess

import numpy

import maps

HERE = pathlib.Path(__file__).resolve().parent
SIDE, FREE, RAYS = 64, 0.1, 1024
UP = (0, 1, 0)


def rectangle(corner, along_u, along_v, normal=None, scale=(1, 1, 1), material="floor"):
    """A rectangle whose front is on the side of `along_u` x `along_v`; its UVs leave a share of the map free all around."""
    corner, along_u, along_v = (numpy.array(it, float) for it in (corner, along_u, along_v))
    shares = numpy.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    front = numpy.cross(along_u, along_v)
    normal = front / numpy.linalg.norm(front) if normal is None else numpy.array(normal, float)
    return {
        "POSITION": corner + shares[:, :1] * along_u + shares[:, 1:] * along_v,
        "NORMAL": numpy.tile(normal, (4, 1)), "TEXCOORD_0": shares * (1 - 2 * FREE) + FREE,
        "scale": list(scale), "material": material,
    }


def floor(**more):
    """v goes along x from 0 to 1, u along z."""
    return rectangle((0, 0, -0.5), (0, 0, 1), (1, 0, 0), **more)


def wall(**more):
    """Of height 1, very long, at x = 0."""
    return rectangle((0, 0, -500), (0, 0, 1000), (0, 1, 0), material="other", **more)


def ceiling(height, half=500.0, faces_down=True, **more):
    sides = [(2 * half, 0, 0), (0, 0, 2 * half)]
    return rectangle((-half, height, -half), *(sides if faces_down else sides[::-1]), material="other", **more)


def beside_a_wall(away):
    return 0.5 + 0.5 * away / numpy.sqrt(away**2 + 1)


def tilted(angle):
    return (math.sin(angle), math.cos(angle), 0)


# Name, rectangles, AO distance , opacity of the material "other", visibility as a function of x.
CASES = [
    ("nothing above", [floor()], math.inf, 1, lambda x: 1 + 0 * x),
    ("wall", [floor(), wall()], math.inf, 1, beside_a_wall),
    ("wall, seen from behind", [floor(), rectangle((0, 0, -500), (0, 1, 0), (0, 0, 1000), material="other")], math.inf, 1,
     beside_a_wall),
    ("wall, both mirrored", [floor(scale=(-1, 1, 1)), wall(scale=(-1, 1, 1))], math.inf, 1, beside_a_wall),
    ("wall, floor alone mirrored along z", [floor(scale=(1, 1, -1)), wall()], math.inf, 1, beside_a_wall),
    ("ceiling at half the distance", [floor(), ceiling(0.5)], 1, 1, lambda x: 0.25 + 0 * x),
    ("ceiling just out of reach", [floor(), ceiling(1.001)], 1, 1, lambda x: 1 + 0 * x),
    ("ceiling seen from behind", [floor(), ceiling(0.5, faces_down=False)], 1, 1, lambda x: 0.25 + 0 * x),
    ("ceiling of opacity 0.5", [floor(), ceiling(0.5)], math.inf, 0.5, lambda x: 0.5 + 0 * x),
    ("ceiling of opacity 0.5, taken as opaque", [floor(), ceiling(0.5)], math.inf, "opaque", lambda x: 0 * x),
    ("floor turned over", [rectangle((0, 0, -0.5), (1, 0, 0), (0, 0, 1)), ceiling(0.5)], 1, 1, lambda x: 1 + 0 * x),
    # The share of the hemisphere about the normal that lies above the surface is (1 + cos t) / 2.
    ("normal tilted by 30 degrees", [floor(normal=tilted(math.pi / 6))], math.inf, 1, lambda x: 0.5 + math.sqrt(3) / 4 + 0 * x),
    ("normal tilted by 30 degrees, a floor below", [floor(normal=tilted(math.pi / 6)), ceiling(-0.1)], math.inf, 1,
     lambda x: 0.5 + math.sqrt(3) / 4 + 0 * x),
    ("normal tilted by 60 degrees", [floor(normal=tilted(math.pi / 3))], math.inf, 1, lambda x: 0.75 + 0 * x),
]


def document(rectangles, opacity):
    """A glTF whose occlusion is read by its only UVs."""
    blend = {} if opacity in (1, "opaque") else {"alphaMode": "BLEND"}
    alpha = 0.5 if opacity == "opaque" else opacity
    material = {"doubleSided": True, "occlusionTexture": {"index": 0}}
    root = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(rectangles)))}], "nodes": [],
        "materials": [{"name": "floor"} | material,
                      {"name": "other", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, alpha]}} | material | blend],
        "meshes": [], "accessors": [], "bufferViews": [], "textures": [{"source": 0}],
        "images": [{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAG7buVgAA"
                           "AABJRU5ErkJggg=="}],
    }
    data = b""

    def accessor(rows, component, kind):
        nonlocal data
        root["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": rows.nbytes})
        data += rows.tobytes()
        bounds = {"min": rows.min(0).tolist(), "max": rows.max(0).tolist()} if kind == "VEC3" else {}
        root["accessors"].append({"bufferView": len(root["bufferViews"]) - 1, "componentType": component,
                                  "count": len(rows), "type": kind} | bounds)
        return len(root["accessors"]) - 1

    for at, item in enumerate(rectangles):
        attributes = {key: accessor(item[key].astype("f4"), 5126, "VEC2" if "TEX" in key else "VEC3")
                      for key in ("POSITION", "NORMAL", "TEXCOORD_0")}
        indices = accessor(numpy.array([0, 1, 2, 0, 2, 3], "u4"), 5125, "SCALAR")
        primitive = {"attributes": attributes, "indices": indices, "material": int(item["material"] == "other")}
        root["meshes"].append({"primitives": [primitive]})
        root["nodes"].append({"mesh": at, "scale": item["scale"]})
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    root["buffers"] = [{"byteLength": len(data), "uri": uri}]
    return json.dumps(root)


def baked(folder, model, case, options):
    """The floor's map by each of the bakers."""
    _, rectangles, distance, opacity, _ = case
    alpha = ["--alpha", "opaque" if opacity == "opaque" else "material"]
    two = any(it["material"] == "other" for it in rectangles)
    jobs = {
        "conray": [options.conray, "bake", model, "-o", folder / "conray.png", "--size", str(SIDE), "--bits", "16",
                   "--rays", str(RAYS), "--distance", str(distance), "--quiet", *alpha],
        "cycles": [options.blender, "-b", "--factory-startup", "-P", HERE / "bake.py", "--", model, folder / "cycles.exr",
                   "--size", str(SIDE), "--samples", str(RAYS), "--distance", str(distance), *alpha],
    }
    found = {}
    for tool, command in jobs.items():
        suffix = ".exr" if tool == "cycles" else ".png"
        path = folder / f"{tool}{'-floor' if two else ''}{suffix}"
        path.unlink(missing_ok=True)
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        if not path.exists():
            raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
        found[tool] = maps.read(path)[0]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--conray", default="conray")
    parser.add_argument("--blender", default="blender")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    places = ((numpy.arange(SIDE) + 0.5) / SIDE - FREE) / (1 - 2 * FREE)
    inside = (places > 1.5 / SIDE) & (places < 1 - 1.5 / SIDE)
    print(f"{'':42} {'truth':>7}   {'conray':>7} {'RMSE':>7}   {'Cycles':>7} {'RMSE':>7}    means over the floor")
    for case in CASES:
        model = options.folder / "model.gltf"
        model.write_text(document(case[1], case[3]))
        truth = numpy.repeat(case[4](places[inside])[:, None], inside.sum(), 1)
        line = f"{case[0]:42} {truth.mean():7.4f}"
        for values in baked(options.folder, model, case, options).values():
            values = values[numpy.ix_(inside, inside)]
            line += f"   {values.mean():7.4f} {numpy.sqrt(((values - truth)**2).mean()):7.4f}"
        print(line, flush=True)


if __name__ == "__main__":
    main()
