"""supercoil's contact detection beside FCL and ipctk on the same inputs: one core, CPU time, programs alternated, medians over rounds. See README.md.

    python compare.py [--rounds 5] [--segments 1000000] [--bench PROGRAM] [--python PYTHON] [--fcl PROGRAM] [--core 0]
"""

import argparse
import pathlib
import statistics
import subprocess

HERE = pathlib.Path(__file__).parent
INPUTS = ["plecto", "plectocoil", "wlc", "packed"]


def numbers(command, core):
    """Lines "who what number" of a program pinned to one core, as a dictionary."""
    text = subprocess.run(["taskset", "-c", str(core), *map(str, command)], check=True, capture_output=True, text=True).stdout
    rows = (line.split() for line in text.splitlines())
    return {(row[0], row[1]): float(row[2]) for row in rows if len(row) == 3 and row[0] in ("ours", "fcl", "ipctk")}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--segments", type=int, default=1_000_000)
    parser.add_argument("--input", choices=INPUTS)
    parser.add_argument("--core", type=int, default=0)
    parser.add_argument("--bench", required=True, help="the built benchmark, target/release/deps/scaling-…")
    parser.add_argument("--fcl", default=HERE / "fcl_round")
    parser.add_argument("--python", default="python3", help="a Python that has ipctk and numpy")
    parser.add_argument("--folder", default="target/rivals", help="for the points")
    arguments = parser.parse_args()
    folder = pathlib.Path(arguments.folder)
    folder.mkdir(parents=True, exist_ok=True)
    wanted = INPUTS if arguments.input is None else [arguments.input]
    print("input       | ours: boxes  candidates  whole | FCL   | ipctk: build+list  list | boxes/FCL  candidates/FCL  whole/(ipctk build+list)  whole/(ipctk list)")
    for name in wanted:
        points = folder / f"{name}_{arguments.segments}.f64"
        ours = [arguments.bench, "--round", name, "--segments", arguments.segments, "--repeat", arguments.repeat]
        first = subprocess.run([*map(str, ours), "--write", points], check=True, capture_output=True, text=True).stdout
        neighbours = next(line.split()[2] for line in first.splitlines() if line.startswith("ours neighbours"))
        rounds = []
        for _ in range(arguments.rounds):
            found = numbers(ours, arguments.core)
            found |= numbers([arguments.fcl, points, neighbours, arguments.repeat], arguments.core)
            found |= numbers([arguments.python, HERE / "ipctk_round.py", points, arguments.repeat], arguments.core)
            rounds.append(found)
        time = {key: statistics.median(r[key] for r in rounds) for key in rounds[0]}

        def ratio(top, bottom):
            each = [sum(r[k] for k in top) / sum(r[k] for k in bottom) for r in rounds]
            return f"{statistics.median(each):.2f} ({min(each):.2f}-{max(each):.2f})"

        boxes, candidates, whole = [("ours", "refit"), ("ours", "boxes")], [("ours", "refit+candidates")], [("ours", "whole")]
        fcl, listing = [("fcl", "refit"), ("fcl", "list")], [("ipctk", "list")]
        ipctk = [("ipctk", "build"), *listing]
        seconds = [f"{sum(time[k] for k in keys):.3f}" for keys in (boxes, candidates, whole, fcl, ipctk, listing)]
        ratios = [ratio(boxes, fcl), ratio(candidates, fcl), ratio(whole, ipctk), ratio(whole, listing)]
        print(f"{name:<11} |", *seconds, "|", *ratios, flush=True)
        pairs = {who: int(time[(who, "pairs")]) for who in ("ours", "fcl", "ipctk")}
        print(f"{name:<11} box pairs: {pairs}, near: {int(time[('ours', 'near')])}, sites: {int(time[('ours', 'sites')])}", flush=True)


main()
