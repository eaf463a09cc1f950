"""How far the two sides of a model's seams are apart in finished maps.

A seam is an edge of a smooth surface that is cut in the map: two triangles meet in it, with the same positions, normals less
than 11 degrees apart and other UVs. Both sides are read at places a texel apart, both ends among them.
"""

import numpy

from maps import bilinear

SMOOTH_COSINE = 0.98
SAME_UV = 1e-6


def find(triangles):
    """Pairs of sides, each the name of a map and the UVs of both ends; the ends in the same order."""
    open_edges, seams = {}, []
    for name, positions, normals, uvs in triangles:
        for triangle in range(len(positions)):
            for k in range(3):
                ends = [k, (k + 1) % 3]
                keys = [tuple(positions[triangle, end].astype(numpy.float32) + 0.0) for end in ends]
                if keys[0] > keys[1]:
                    keys, ends = keys[::-1], ends[::-1]
                edge = (name, uvs[triangle, ends], normals[triangle, ends])
                met = open_edges.setdefault(tuple(keys), [])
                other = next((it for it in met if ((it[2] * edge[2]).sum(-1) >= SMOOTH_COSINE).all()), None)
                if other is None:
                    met.append(edge)
                    continue
                met[:] = [it for it in met if it is not other]
                if other[0] != name or abs(other[1] - edge[1]).max() > SAME_UV:
                    seams.append((other[:2], edge[:2]))
    return seams


def differences(seams, values):
    """Differences between both sides of seams; `values` are maps by their names."""
    reads = []
    for one, other in seams:
        lengths = [numpy.hypot(*((uvs[1] - uvs[0]) * values[name].shape[::-1])) for name, uvs in (one, other)]
        shares = numpy.linspace(0, 1, max(1, int(numpy.ceil(max(lengths)))) + 1)[:, None]
        sides = [bilinear(values[name], uvs[0] * (1 - shares) + uvs[1] * shares) for name, uvs in (one, other)]
        reads.append(abs(sides[0] - sides[1]))
    return numpy.concatenate(reads) if reads else numpy.zeros(0)


def report(found):
    """Places, the share within 0.02, and the worst."""
    if not len(found):
        return {"places": 0, "within": 1.0, "worst": 0.0}
    return {"places": len(found), "within": float((found <= 0.02).mean()), "worst": float(found.max())}
