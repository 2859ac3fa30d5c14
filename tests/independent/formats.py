#!/usr/bin/env python3
"""What `supercoil export` writes, read by programs that share nothing with it: mdna, topoly, oxDNA's analysis tools,
biopython, MDAnalysis.

    python3 tests/independent/formats.py [--supercoil PROGRAM]

makes a Python environment of its own in target/independent (needs the network the first time), runs a minicircle of 336 base
pairs to an excess link of -3, a trefoil and pUC19, exports them, and prints found against expected. Exit code 1 if one differs.
"""

import argparse
import json
import os
import random
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = ROOT / "target" / "independent"
PACKAGES = ["mdna==0.2.0", "topoly==1.2.1", "oxDNA-analysis-tools==2.0.5", "biopython==1.85", "MDAnalysis>=2.7"]
PAIRS = 336

MINICIRCLE = """
[[rods]]
closed = true
shape = { kind = "circle" }
dna = { base_pairs = 336 }
elements = 48
[contact]
electrostatics = { salt_mM = 150 }
[[stages]]
ramp = { excess_link = { to = -3.0 } }
steps = 15
[output]
vtk = false
picture = false
"""

TREFOIL = """
[[rods]]
closed = true
shape = { kind = "torus_knot", windings = [2, 3] }
dna = { base_pairs = 600, diameter = 4 }
elements = 60
[[stages]]
ramp = { excess_link = { to = 3.0 } }
steps = 2
[output]
vtk = false
picture = false
"""

failures = 0


def check(what, found, expected, tolerance=0.0):
    global failures
    good = abs(found - expected) <= tolerance if tolerance else found == expected
    failures += not good
    print(f"{'ok  ' if good else 'FAIL'} {what}: {found} (expected {expected})", flush=True)


def environment():
    """Runs this file again in an environment that has the packages."""
    python = HERE / "venv" / "bin" / "python"
    if not python.exists():
        venv.create(HERE / "venv", with_pip=True)
    subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    sys.exit(subprocess.run([python, __file__, *sys.argv[1:], "--inside"]).returncode)


def run(program, name, scene, pairs):
    """The folder of files of a molecule, and its summary."""
    folder = HERE / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.toml").write_text(scene)
    random.seed(1)
    (folder / "bases.fasta").write_text(">bases\n" + "".join(random.choice("ACGT") for _ in range(pairs)) + "\n")
    subprocess.run([program, "run", folder / "scene.toml", "--force", "--quiet", "--out", folder / "run"], check=True)
    files = ["--oxdna", "m", "--npy", "m.npy", "--xyz", "m.xyz", "--pdb", "m.pdb", "--par", "m.par"]
    subprocess.run([program, "export", "run", "--sequence", "bases.fasta", *files], check=True, cwd=folder)
    return folder, json.loads((folder / "run" / "summary.json").read_text())


READER = """
import sys
import numpy as np
from oxDNA_analysis_tools.UTILS.RyeReader import describe, get_confs, strand_describe
top, trajectory = describe("m.top", sys.argv[1])
system, _ = strand_describe("m.top")
conf = get_confs(trajectory.idxs, trajectory.path, 0, 1, top.nbases)[0]
np.savez("read.npz", strands=len(system.strands), positions=conf.positions, a1=conf.a1s, a3=conf.a3s)
"""


def oxdna(folder):
    """Nucleotides as oxDNA's analysis tools read them. Their reader (2.0.5) dies now and then of where memory happens to lie, on
    files that it reads the next time: tried again, each time under another name."""
    import numpy as np

    for attempt in range(10):
        name = "m" * (1 + 7 * attempt) + ".dat"
        (folder / name).write_bytes((folder / "m.dat").read_bytes() + b"\n" * (attempt % 2))
        done = subprocess.run([sys.executable, "-c", READER, name], cwd=folder, stderr=subprocess.DEVNULL)
        if done.returncode == 0:
            if attempt:
                print(f"     (oxDNA's reader died {attempt} times before)")
            return np.load(folder / "read.npz")
    sys.exit("FAIL oxDNA's reader died ten times")


def strands(folder, bases):
    """Both strands of the PDB file, by readers of structures; the steps of the ring, chained by hand."""
    import MDAnalysis
    import numpy as np
    from Bio.PDB import PDBParser

    complement = {"A": "T", "C": "G", "G": "C", "T": "A"}
    expected = [list(bases), [complement[base] for base in reversed(bases)]]
    model = PDBParser(QUIET=True).get_structure("m", folder / "m.pdb")[0]
    check("biopython: chains", [chain.id for chain in model], ["A", "B"])
    names = [[residue.get_resname().strip()[1:] for residue in chain] for chain in model]
    check("biopython: bases of both strands", names == expected, True)
    atoms = MDAnalysis.Universe(str(folder / "m.pdb")).select_atoms("name P")
    check("MDAnalysis: atoms P", len(atoms), 2 * len(bases))
    check("MDAnalysis: all are of nucleic acid", len(atoms.select_atoms("nucleic")), 2 * len(bases))
    a, b = atoms.positions[: len(bases)], atoms.positions[len(bases) :][::-1]
    check("MDAnalysis: partners are as far apart as in B-DNA, Å", round(float(np.linalg.norm(a - b, axis=1).mean()), 1), 19.0, 0.3)

    rows = [line.split() for line in (folder / "m.par").read_text().splitlines()[3:]]
    names = [row[0] for row in rows]
    ring = bases + bases[0]
    check("par: bases, the first pair once more", names == [f"{base}-{complement[base]}" for base in ring], True)
    turn, place = np.eye(3), np.zeros(3)
    for shift, slide, rise, tilt, roll, twist in [[float(cell) for cell in row[7:13]] for row in rows[1:]]:
        # El Hassan and Calladine (1995): half the twist, the bend about the hinge, half the twist
        about = lambda axis, angle: rotation(np.eye(3)[axis], np.radians(angle))
        bend, phase = np.hypot(tilt, roll), np.degrees(np.arctan2(tilt, roll))
        middle = about(2, twist / 2 - phase) @ about(1, bend / 2) @ about(2, phase)
        place = place + turn @ middle @ np.array([shift, slide, rise])
        turn = turn @ about(2, twist / 2 - phase) @ about(1, bend) @ about(2, twist / 2 + phase)
    check("par: the steps lead round the ring, Å", round(float(np.linalg.norm(place)), 4), 0.0, 1e-3)
    check("par: and turn into the first frame", round(float(np.abs(turn - np.eye(3)).max()), 6), 0.0, 1e-4)


def rotation(axis, angle):
    """The rotation about a unit axis (Rodrigues)."""
    import numpy as np

    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def main(program):
    import warnings

    warnings.simplefilter("ignore")
    import mdna
    import numpy as np
    import topoly

    folder, summary = run(program, "minicircle", MINICIRCLE, PAIRS)
    last = summary["final"]["links"][0]
    # relaxed: 336 / 10.5 = 32 turns
    link = 29

    frames = np.load(folder / "m.npy")
    check("frames.npy: shape", frames.shape, (PAIRS, 4, 3))
    bases = (folder / "bases.fasta").read_text().split()[1]
    molecule = mdna.load(frames=frames, sequence=bases, circular=True)
    lk, writhe, twist = molecule.get_linking_number()
    check("mdna: link", round(float(lk), 6), link, 1e-3)
    check("mdna: writhe", round(float(writhe), 5), round(last["writhe"], 5), 5e-3)
    check("mdna: twist", round(float(twist), 5), round(32 + last["excess_link"] - last["writhe"], 5), 5e-3)
    chained = mdna.load(frames=frames, sequence=bases, circular=True).get_traj()
    check("mdna: atoms are built on the frames", chained.n_residues, 2 * PAIRS)

    strands(folder, bases)

    conf = oxdna(folder)
    check("oxDNA tools: strands", int(conf["strands"]), 2)
    check("oxDNA tools: nucleotides", len(conf["positions"]), 2 * PAIRS)
    check("oxDNA tools: a1 and a3 are unit and orthogonal", round(float(np.abs((conf["a1"] * conf["a3"]).sum(1)).max()), 9), 0.0, 1e-9)
    a, b = conf["positions"][:PAIRS], conf["positions"][PAIRS:][::-1]
    check("oxDNA: partners face each other", round(float((conf["a1"][:PAIRS] * conf["a1"][PAIRS:][::-1]).sum(1).max()), 6), -1.0, 1e-6)
    steps = np.linalg.norm(np.diff(a, axis=0), axis=1)
    check("oxDNA: backbone steps, units", round(float(steps.mean()), 3), 0.53, 0.05)
    # topoly's integral of closed polygons is off in proportion to their bonds (28.85 of 29 as they are): each is cut in eight
    parts = np.arange(8)[:, None] / 8

    def close(points):
        bonds = zip(points, np.roll(points, -1, axis=0))
        return np.vstack([p + parts * (q - p) for p, q in bonds] + [points[:1]]).tolist()

    gln = topoly.gln(close(a), close(b))
    check("topoly: link of the oxDNA strands", abs(round(float(gln["whole"] if isinstance(gln, dict) else gln), 2)), link, 0.05)

    knot = lambda path: topoly.alexander(np.loadtxt(path, skiprows=2, usecols=(1, 2, 3)).tolist(), closure=topoly.Closure.CLOSED)
    check("topoly: knot of the minicircle", str(knot(folder / "m.xyz")), "0_1")
    folder, _ = run(program, "trefoil", TREFOIL, 600)
    check("topoly: knot of the trefoil", str(knot(folder / "m.xyz")), "3_1")

    plasmid = (ROOT / "examples" / "puc19_to_oxdna.toml").read_text()
    folder, _ = run(program, "puc19_to_oxdna", plasmid, 2686)
    bases = (folder / "bases.fasta").read_text().split()[1]
    lk, _, _ = mdna.load(frames=np.load(folder / "m.npy"), sequence=bases, circular=True).get_linking_number()
    check("mdna: link of pUC19", round(float(lk), 3), 240, 1e-2)
    check("topoly: knot of pUC19", str(knot(folder / "m.xyz")), "0_1")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--supercoil", default=str(ROOT / "target" / "release" / "supercoil"), help="the program")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if not arguments.inside:
        HERE.mkdir(parents=True, exist_ok=True)
        environment()
    main(os.path.abspath(arguments.supercoil))
