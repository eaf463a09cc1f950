#!/usr/bin/env python3
"""Compares the maps of conray and Cycles that `run` left in a folder.

    compare.py FOLDER

Errors are RMSE over the texels that count: whose centre and whose eight neighbours' centres lie on the surface, and whose
visibility by the long runs of both tools differs by at most 0.1. The second leaves out what the tools mean differently, such as
surfaces inside others, where conray goes on with the values beside them and Cycles says closed.
"""

import json
import pathlib
import statistics
import sys

import numpy
from PIL import Image

import maps
import seams
from gltf import Gltf

MOST_APART = 0.1
WANTED = (0.02, 0.01)
# What is timed of conray, and what of Cycles.
TIMES = {
    "whole program": ("whole", "whole"),
    "bake alone": ("alone", "alone"),
    "whole conray, bake of Cycles": ("whole", "alone"),
    "CPU, whole program": ("cpu", "cpu"),
}
RIVAL = "cycles --samples"


def inside(baked):
    """Texels that have only baked ones around them."""
    wide = numpy.pad(baked, 1)
    rows, columns = baked.shape
    return numpy.all([wide[y:y + rows, x:x + columns] for y in range(3) for x in range(3)], axis=0)


class References:
    """The long run of each tool, and the texels that count."""

    def __init__(self, runs):
        self.values = {it["tool"]: read(it) for it in runs if it["role"] == "reference"}
        ours, theirs = self.values["conray"], self.values["cycles"]
        self.baked = {name: baked for name, (_, baked) in theirs.items()}
        self.inside = {name: inside(baked) for name, baked in self.baked.items()}
        self.counts = {name: self.inside[name] & (abs(ours[name][0] - theirs[name][0]) <= MOST_APART) for name in theirs}
        if not any(it.any() for it in self.counts.values()):
            raise SystemExit("no texel on which the tools agree: are these maps of one model?")

    def rmse(self, run, tool):
        """Of a run's maps to a tool's long run."""
        apart = [(values - self.values[tool][name][0])[self.counts[name]] for name, (values, _) in read(run).items()]
        return float(numpy.sqrt((numpy.concatenate(apart)**2).mean()))

    def shares(self):
        baked, inner, counted = (sum(it.sum() for it in of.values()) for of in (self.baked, self.inside, self.counts))
        return (f"{baked} texels have their centre on the surface; left out: {1 - inner / baked:.1%} at rims, "
                f"{(inner - counted) / baked:.1%} on which the tools differ by more than {MOST_APART}; {counted} count")

    def pictures(self, folder):
        """Conray's map, Cycles' and the difference: lighter than the middle where conray is."""
        for name in self.baked:
            ours, theirs, baked = self.values["conray"][name][0], self.values["cycles"][name][0], self.baked[name]
            apart = numpy.where(baked, 0.5 + (ours - theirs) / 2, 0.5)
            row = numpy.concatenate([numpy.where(baked, ours, 0), numpy.where(baked, theirs, 0), apart], axis=1)
            Image.fromarray((row.clip(0, 1) * 255 + 0.5).astype(numpy.uint8)).save(folder / f"difference-{name}.png")


def read(run):
    return {name: maps.read(path) for name, path in run["maps"].items()}


def middle(runs, key):
    return statistics.median(it[key] for it in runs)


def rows(runs, references):
    """One a setting, repeats taken together: their median times, and errors of the first, since all have the same bits."""
    found = {}
    for run in runs:
        if run["role"] == "run":
            found.setdefault((run["tool"], run["option"], run["amount"]), []).append(run)
    for (tool, option, amount), of in sorted(found.items(), key=lambda it: (it[0][:2], float(it[0][2]))):
        other = "cycles" if tool == "conray" else "conray"
        whole = [it["whole_secs"] for it in of]
        yield {
            "series": f"{tool} {option}", "amount": amount, "whole": middle(of, "whole_secs"), "least": min(whole),
            "most": max(whole), "alone": middle(of, "alone_secs"), "cpu": middle(of, "cpu_secs"),
            "peak_mb": middle(of, "peak_mb"), "own": references.rmse(of[0], tool), "other": references.rmse(of[0], other),
        }


def time_for(series, wanted, error, time):
    """Seconds for an error, by a straight line in logarithms between the runs around it; without such runs None."""
    points = sorted((numpy.log(it[error]), numpy.log(it[time])) for it in series)
    for (low, slow), (high, fast) in zip(points, points[1:]):
        if low <= numpy.log(wanted) <= high:
            return float(numpy.exp(slow + (fast - slow) * (numpy.log(wanted) - low) / (high - low)))
    return None


def print_runs(table):
    print(f"\n{'':18} {'':>7} {'whole s':>8} {'(range)':>15} {'alone s':>8} {'CPU s':>8} {'MB':>6} "
          f"{'RMSE own':>9} {'RMSE other':>10}")
    for it in table:
        spread = f"({it['least']:.2f}-{it['most']:.2f})"
        print(f"{it['series']:18} {it['amount']:>7} {it['whole']:8.2f} {spread:>15} {it['alone']:8.2f} {it['cpu']:8.2f} "
              f"{it['peak_mb']:6.0f} {it['own']:9.4f} {it['other']:10.4f}")


def print_times(table):
    names = [it for it in dict.fromkeys(it["series"] for it in table) if it != RIVAL]
    of = {name: [it for it in table if it["series"] == name] for name in [*names, RIVAL]}
    for error, meaning in (("own", "to its own long run"), ("other", "to the other's long run")):
        for wanted in WANTED:
            print(f"\nseconds for an RMSE of {wanted} {meaning} (Cycles' time by conray's)")
            for label, (ours, theirs) in TIMES.items():
                rival = time_for(of[RIVAL], wanted, error, theirs)
                cells = [f"cycles {shown(rival)}"]
                for name in names:
                    secs = time_for(of[name], wanted, error, ours)
                    cells.append(f"{name} {shown(secs)}" + (f" ({rival / secs:.1f} x)" if rival and secs else ""))
                print(f"  {label:29} {';  '.join(cells)}")


def shown(secs):
    return "(no runs around it)" if secs is None else f"{secs:.2f}"


def print_seams(runs, found):
    print("\nseams: places, share within 0.02, worst")
    for run in runs:
        if run["role"] == "seams":
            values = {name: map_[0] for name, map_ in read(run).items()}
            it = seams.report(seams.differences(found, values))
            print(f"  {run['tool']:7} {run['option']} {run['amount']:>6} {run['note']:24} {it['places']:8} "
                  f"{it['within']:8.2%} {it['worst']:6.3f}")


def main():
    folder = pathlib.Path(sys.argv[1])
    job = json.loads((folder / "runs.json").read_text())
    runs = job["runs"]
    references = References(runs)
    print(f"{job['model']}, {job['size']} x {job['size']} texels, AO distance {job['distance']}, {job['threads']} threads, "
          f"Blender {job['blender']}")
    print(references.shares())
    long_run = next(it for it in runs if it["role"] == "reference" and it["tool"] == "conray")
    print(f"the long runs, of {long_run['amount']}, differ by an RMSE of {references.rmse(long_run, 'cycles'):.4f}")
    table = list(rows(runs, references))
    print_runs(table)
    print_times(table)
    print_seams(runs, seams.find(Gltf(job["model"]).triangles()))
    references.pictures(folder)


if __name__ == "__main__":
    main()
