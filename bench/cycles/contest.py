#!/usr/bin/env python3
"""Bakes a model with conray and with Cycles, in turn, and compares the maps. Start it by `run`."""

import argparse
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
MARGIN = 16


def amounts(text):
    return text.split(",")


def arguments():
    parser = argparse.ArgumentParser(prog="run", description=__doc__)
    parser.add_argument("model", help=".glb or .gltf")
    parser.add_argument("folder", type=pathlib.Path, help="where maps and figures go")
    parser.add_argument("--size", type=int, default=2048, help="texels on each side of a map")
    parser.add_argument("--distance", default="auto", help="AO distance, as conray takes it")
    parser.add_argument("--samples", type=amounts, default=amounts("16,32,64,128,256"), help="of Cycles")
    parser.add_argument("--rays", type=amounts, default=amounts("4,8,16,32,64,128"), help="of conray")
    parser.add_argument("--errors", type=amounts, default=amounts("0.08,0.04,0.02,0.01"), help="asked of conray")
    parser.add_argument("--reference", type=int, default=2048, help="samples or rays of the long runs")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--maps", default="png", choices=["png", "exr"], help="how conray writes its maps")
    parser.add_argument("--conray", default="conray", help="the program")
    parser.add_argument("--blender", default="blender", help="the program")
    return parser.parse_args()


def measured(command):
    """Runs a command: what it printed, seconds, CPU seconds and peak memory of the whole process."""
    command = [str(it) for it in command]
    print("$", shlex.join(command), flush=True)
    start = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    printed = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    secs = time.perf_counter() - start
    if child.returncode:
        raise SystemExit(f"{printed}\nended with {child.returncode}")
    return printed, {"whole_secs": secs, "cpu_secs": usage.ru_utime + usage.ru_stime, "peak_mb": usage.ru_maxrss / 1024}


def summary(printed):
    """The last line of JSON among what a program printed."""
    lines = [it for it in printed.splitlines() if it.startswith("{")]
    if not lines:
        raise SystemExit(f"no figures in:\n{printed}")
    return json.loads(lines[-1])


class Contest:
    def __init__(self, options):
        self.options = options
        self.runs = []
        options.folder.mkdir(parents=True, exist_ok=True)
        self.model = options.folder / f"model{pathlib.Path(options.model).suffix}"
        # UVs that lie over each other are laid out by conray; both tools bake what comes of it.
        printed, _ = measured([options.conray, "bake", options.model, "-o", self.model, "--size", options.size,
                               "--rays", 1, "--distance", options.distance, "--alpha", "opaque"])
        print(printed, end="")
        self.distance = re.search(r"AO distance ([^\s,]+)", printed).group(1)
        self.blender = "?"

    def keep(self, tool, role, option, amount, figures, maps, note=""):
        run = {"tool": tool, "role": role, "option": option, "amount": str(amount), "maps": maps, "note": note}
        self.runs.append(run | figures)
        self.write()
        shown = ", ".join(f"{key} {value:.2f}" for key, value in figures.items())
        print(f"  {shown}", flush=True)

    def conray(self, role, option, amount, more=()):
        """Alone is the building of the BVH and the estimation."""
        options = self.options
        out = options.folder / f"conray-{role}{option}-{amount}.{options.maps}"
        depth = ["--bits", 16] if options.maps == "png" else []
        printed, figures = measured([
            options.conray, "bake", self.model, "-o", out, "--size", options.size, option, amount, "--distance",
            self.distance, "--threads", options.threads, "--alpha", "opaque", "--json", *depth, *more])
        told = summary(printed)
        figures["alone_secs"] = told["bvh"]["seconds"] + told["seconds"]
        self.keep("conray", role, option, amount, figures, dict(zip(told["maps"], told["files"])),
                  "islands until they meet")

    def cycles(self, role, amount, more=(), note=""):
        """Alone is the call that bakes: texels, BVH and rays."""
        options = self.options
        out = options.folder / f"cycles-{role}-{amount}{note.replace(' ', '-')}.exr"
        printed, figures = measured([
            options.blender, "-b", "--factory-startup", "-t", options.threads, "-P", HERE / "bake.py", "--", self.model, out,
            "--size", options.size, "--samples", amount, "--distance", self.distance, "--threads", options.threads,
            "--alpha", "opaque", *more])
        told = summary(printed)
        figures["alone_secs"] = told["bake_secs"]
        self.blender = told["version"]
        self.keep("cycles", role, "--samples", amount, figures, told["maps"], note)

    def all(self):
        options = self.options
        # Seeds of their own: a long run must not begin with the rays of a short one.
        self.conray("reference", "--rays", options.reference, ["--method", "rays", "--seed", 1])
        self.cycles("reference", options.reference, ["--seed", 1])
        for _ in range(options.repeats):
            # In turn, so that what else the machine does meets both.
            for at in range(max(len(options.samples), len(options.rays), len(options.errors))):
                for amount in options.rays[at:at + 1]:
                    self.conray("run", "--rays", amount)
                for amount in options.samples[at:at + 1]:
                    self.cycles("run", amount)
                for amount in options.errors[at:at + 1]:
                    self.conray("run", "--error", amount)
        # A map is read beside its islands too: for seams both need them extended.
        self.conray("seams", "--rays", options.rays[-1])
        self.cycles("seams", options.samples[-1], ["--margin", MARGIN], f"margin {MARGIN}")

    def write(self):
        job = {"model": str(self.model), "size": self.options.size, "distance": self.distance,
               "threads": self.options.threads, "blender": self.blender, "runs": self.runs}
        (self.options.folder / "runs.json").write_text(json.dumps(job, indent=1))


def main():
    options = arguments()
    contest = Contest(options)
    contest.all()
    command = [sys.executable, HERE / "compare.py", options.folder]
    print("$", shlex.join(map(str, command)), flush=True)
    subprocess.run(command, check=True)


if __name__ == "__main__":
    main()
