# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading of scene files beside other readers, as medians of runs in turning order.

    python3 bench/files/compare.py SCENES RIVALS [--rounds 7] [--reads 5] [--json OUT]

SCENES holds dragon/dragon.ply, breakfast-room/breakfast-room.obj and the others below; textures are left out, and each scene is
converted to other formats by our writers. RIVALS holds rapidobj.hpp, miniply.{h,cpp} and cgltf.h. usd-core and numpy
must be there for this Python. A run is a process that reads the file `--reads` times; its figure is the median.
"""

import argparse
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
SOURCES = ["breakfast-room/breakfast-room.obj", "white-room/white-room.obj", "conference/conference.obj", "dragon/dragon.ply"]


def run(command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


def without_textures(source, folder):
    """A copy whose library names no picture."""
    target = folder / source.name
    target.write_bytes(source.read_bytes())
    for library in source.parent.glob("*.mtl"):
        lines = library.read_text(errors="replace").splitlines()
        kept = [line for line in lines if not re.match(r"\s*(map_|bump|disp|decal|refl|norm)", line)]
        (folder / library.name).write_text("\n".join(kept) + "\n")
    return target


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", type=pathlib.Path)
    parser.add_argument("rivals", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--reads", type=int, default=5, help="readings in a process; 1: the first one, whose memory is new")
    parser.add_argument("--json", type=pathlib.Path)
    arguments = parser.parse_args()

    run(["cargo", "build", "--release", "--manifest-path", HERE / "Cargo.toml"])
    ours = HERE / "target/release/gnurt-bench-files"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        rivals = folder / "rivals"
        run(["c++", "-O3", "-march=native", "-std=c++17", "-pthread", f"-I{arguments.rivals}", HERE / "rivals.cpp",
             arguments.rivals / "miniply.cpp", "-o", rivals])
        rows = []
        for source in SOURCES:
            file = without_textures(arguments.scenes / source, folder)
            files = [file]
            for extension in ["obj", "ply", "glb", "usdc", "usda"]:
                other = file.with_name(f"{file.stem}-2.{extension}")
                if extension not in ("obj", "ply") or file.suffix == ".ply":
                    run([ours, "convert", file, other])
                    files.append(other)
            for file in files:
                readers = {"gnurt": [ours, "gnurt", file, arguments.reads]}
                match file.suffix:
                    case ".obj":
                        readers["tobj"] = [ours, "tobj", file, arguments.reads]
                        readers["rapidobj"] = [rivals, "rapidobj", file, arguments.reads]
                    case ".ply":
                        readers["miniply"] = [rivals, "miniply", file, arguments.reads]
                    case ".glb":
                        readers["cgltf"] = [rivals, "cgltf", file, arguments.reads]
                    case _:
                        readers["usd-core"] = [sys.executable, HERE / "usd.py", file, arguments.reads]
                seconds = {reader: [] for reader in readers}
                triangles = {}
                names = list(readers)
                for i in range(arguments.rounds):
                    for reader in names[i % len(names):] + names[:i % len(names)]:
                        lines = [line.split() for line in run(readers[reader]).splitlines()]
                        seconds[reader].append(statistics.median(float(line[0]) for line in lines))
                        triangles[reader] = int(lines[0][1])
                row = {"file": file.name, "bytes": file.stat().st_size, "triangles": triangles,
                       "seconds": {reader: statistics.median(all) for reader, all in seconds.items()}}
                rows.append(row)
                best = min(row["seconds"][reader] for reader in names[1:])
                print(f"{file.name:26} {row['bytes'] / 1e6:6.1f} MB  ", "  ".join(
                    f"{reader} {row['seconds'][reader] * 1e3:7.1f} ms" for reader in names),
                    f"  ratio {row['seconds']['gnurt'] / best:.2f}", triangles if len(set(triangles.values())) > 1 else "")
        if arguments.json:
            arguments.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
