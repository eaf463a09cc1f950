"""What the comparison needs of a glTF file: triangles in the world, and by which UVs each material's occlusion is read."""

import base64
import json
import pathlib
import struct
import urllib.parse

import numpy

TYPES = {5121: numpy.uint8, 5123: numpy.uint16, 5125: numpy.uint32, 5126: numpy.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Gltf:
    """A .glb or .gltf and its buffers."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        data, self.binary = self.path.read_bytes(), b""
        if data[:4] == b"glTF":
            length = struct.unpack_from("<I", data, 12)[0]
            data, self.binary = data[20:20 + length], data[28 + length:]
        self.root = json.loads(data)
        self.buffers = [self.bytes_of(it) for it in self.root.get("buffers", [])]

    def bytes_of(self, item):
        """The bytes of a buffer or an image."""
        if "bufferView" in item:
            view = self.root["bufferViews"][item["bufferView"]]
            start = view.get("byteOffset", 0)
            return self.buffers[view["buffer"]][start:start + view["byteLength"]]
        uri = item.get("uri")
        if uri is None:
            return self.binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (self.path.parent / urllib.parse.unquote(uri)).read_bytes()

    def numbers(self, index):
        """An accessor as rows."""
        accessor = self.root["accessors"][index]
        view = self.root["bufferViews"][accessor["bufferView"]]
        kind, width = numpy.dtype(TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        rows = numpy.ndarray((accessor["count"], width), kind, self.buffers[view["buffer"]], start,
                             (stride, kind.itemsize))
        return rows / numpy.iinfo(kind).max if accessor.get("normalized") else rows

    def occlusion(self, material):
        """The occlusion texture of a material, by its number."""
        found = self.root["materials"][material].get("occlusionTexture")
        if found is None:
            raise SystemExit(f"{self.path}: material {material} has no occlusion texture: is it a baked model?")
        return found

    def uv_sets(self):
        """By the names of materials: which set of UVs their occlusion is read by."""
        materials = self.root["materials"]
        names = [it.get("name", "") for it in materials]
        if len(set(names)) < len(names):
            raise SystemExit(f"{self.path}: materials need names of their own")
        return {name: self.occlusion(at).get("texCoord", 0) for at, name in enumerate(names)
                if "occlusionTexture" in materials[at]}

    def map_bytes(self):
        """By the names of materials: the image of their occlusion."""
        images = {}
        for at, material in enumerate(self.root["materials"]):
            if "occlusionTexture" in material:
                source = self.root["textures"][self.occlusion(at)["index"]]["source"]
                images[material["name"]] = self.bytes_of(self.root["images"][source])
        return images

    def nodes(self):
        """Nodes of the scene with their matrices."""
        queue = [(it, numpy.eye(4)) for it in self.root["scenes"][self.root.get("scene", 0)]["nodes"]]
        while queue:
            index, parent = queue.pop()
            node = self.root["nodes"][index]
            world = parent @ matrix(node)
            queue += [(it, world) for it in node.get("children", [])]
            yield node, world

    def triangles(self):
        """Material's name, positions, normals and UVs (triangles x 3 corners x ...) of each primitive in the world.

        Triangles are moved into the first tile of the texture.
        """
        sets = self.uv_sets()
        for node, world in self.nodes():
            if "mesh" not in node:
                continue
            turn = numpy.linalg.inv(world[:3, :3]).T
            for primitive in self.root["meshes"][node["mesh"]]["primitives"]:
                name = self.root["materials"][primitive["material"]]["name"]
                corners = self.numbers(primitive["indices"]).reshape(-1, 3)
                of = {key: self.numbers(it)[corners].astype(numpy.float64) for key, it in primitive["attributes"].items()}
                normals = of["NORMAL"] @ turn.T
                normals /= numpy.maximum(numpy.linalg.norm(normals, axis=-1, keepdims=True), 1e-30)
                uvs = of[f"TEXCOORD_{sets[name]}"]
                uvs -= numpy.floor(uvs.mean(axis=1, keepdims=True))
                yield name, of["POSITION"] @ world[:3, :3].T + world[:3, 3], normals, uvs


def matrix(node):
    """Parent from node."""
    if "matrix" in node:
        return numpy.array(node["matrix"]).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    result = numpy.eye(4)
    result[:3, :3] = turn * numpy.array(node.get("scale", [1, 1, 1]))
    result[:3, 3] = node.get("translation", [0, 0, 0])
    return result
