"""Maps of visibility out of the files that the two bakers write."""

import io
import pathlib

import numpy
import OpenEXR
from PIL import Image

from gltf import Gltf


def read(path):
    """The values of a map, 1 open, the upper row first, and which of its texels were baked."""
    path = pathlib.Path(path)
    if path.suffix == ".exr":
        return of_exr(path)
    return of_png(path.read_bytes())


def of_exr(path):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    name = next((it for it in ("V", "Y", "R") if it in channels), None)
    if name is None:
        raise SystemExit(f"{path}: no channel V, Y or R")
    values = channels[name].pixels.astype(numpy.float64)
    baked = channels["A"].pixels > 0.5 if "A" in channels else numpy.isfinite(values)
    return values, baked


def of_png(data):
    pixels = numpy.asarray(Image.open(io.BytesIO(data)))
    full = 255.0 if pixels.dtype == numpy.uint8 else 65535.0
    values = (pixels if pixels.ndim == 2 else pixels[..., 0]) / full
    return values, numpy.ones(values.shape, bool)


def of_model(path):
    """By the names of materials: the occlusion maps of a model."""
    return {name: of_png(data) for name, data in Gltf(path).map_bytes().items()}


def bilinear(values, uvs):
    """What a renderer reads at UVs (rows of u, v), clamped at the rim of the map."""
    height, width = values.shape
    x, y = uvs[:, 0] * width - 0.5, uvs[:, 1] * height - 0.5
    left, top = numpy.floor(x).astype(int), numpy.floor(y).astype(int)
    right_share, lower_share = x - left, y - top

    def at(row, column):
        return values[numpy.clip(row, 0, height - 1), numpy.clip(column, 0, width - 1)]

    upper = at(top, left) * (1 - right_share) + at(top, left + 1) * right_share
    lower = at(top + 1, left) * (1 - right_share) + at(top + 1, left + 1) * right_share
    return upper * (1 - lower_share) + lower * lower_share
