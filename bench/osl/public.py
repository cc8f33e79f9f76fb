#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles, runs and renders shaders of public collections, as they are.

    bench/osl/public.py FOLDER GNURT OUT [--only WORD...] [--render WORD...] [--spp N] [--size N]

FOLDER holds checkouts, one a folder; all their .osl files are compiled (headers are looked for beside a file and in the folders of
--include), and those that compile are run by `testshade` on 32 x 32 points, by the interpreter and by machine code: what they print
and the outputs must be equal. With --render, those whose path has one of the words are put on a ball: what writes `Ci` as it is,
else its first output of a closure, a colour, a vector or a float, by one more layer. OUT gets `results.tsv` and the pictures.
The files stay where they are.
"""
import argparse, os, re, shutil, subprocess, sys

KINDS = ["closure color", "color", "vector", "normal", "point", "float", "int"]
SHOW = {
    "closure color": "surface show (closure color x = 0) { Ci = x; }",
    "color": "surface show (color x = 0) { Ci = x * diffuse (N); }",
    "float": "surface show (float x = 0) { Ci = color (x) * diffuse (N); }",
    "int": "surface show (int x = 0) { Ci = color (0.8 * x) * diffuse (N); }",
}
for triple in ["vector", "normal", "point"]:
    SHOW[triple] = "surface show (%s x = 0) { Ci = color (abs (x)) * diffuse (N); }" % triple


def run(command, seconds=60, **more):
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=seconds, **more)
        return done.returncode, done.stdout + done.stderr
    except subprocess.TimeoutExpired:
        return -1, "more than %d s" % seconds


def outputs(gnurt, oso):
    """Names and types of outputs."""
    _, text = run([gnurt, "oslinfo", oso])
    found = re.findall(r"^output (closure color|color|vector|normal|point|float|int) (\S+)", text, re.M)
    return [(name, kind) for kind, name in found]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("gnurt")
    parser.add_argument("out")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--include", action="append", default=[])
    parser.add_argument("--render", nargs="*", default=None)
    parser.add_argument("--spp", default="16")
    parser.add_argument("--size", default="96")
    options = parser.parse_args()
    gnurt, out = os.path.abspath(options.gnurt), os.path.abspath(options.out)
    os.makedirs(out, exist_ok=True)
    root = os.path.abspath(options.folder)
    files = sorted(os.path.join(at, name) for at, _, names in os.walk(root) for name in names if name.lower().endswith(".osl"))
    rows = []
    for path in files:
        short = os.path.relpath(path, root)
        if options.only and not any(word in short for word in options.only):
            continue
        stem = re.sub(r"[^A-Za-z0-9]+", "_", short[:-4])
        oso = os.path.join(out, stem + ".oso")
        includes = ["-I" + folder for folder in options.include]
        status, said = run([gnurt, "oslc", "--strict-osl", "-q", *includes, "-o", oso, path])
        if status:
            errors = [line for line in said.splitlines() if "error:" in line] or ["status %d" % status]
            state = "no shader" if "No shader function defined" in said else "does not compile"
            rows.append((short, state, errors[0].replace(root + "/", "")[:200]))
            continue
        found = outputs(gnurt, oso)
        flat = [name for name, kind in found if kind != "closure color" and kind in KINDS][:3]
        wanted = [word for name in flat for word in ("-o", name, os.path.join(out, "%s.exr" % name))]
        texts = []
        for engine in ["interpreter", "machine"]:
            environment = dict(os.environ, TESTSHADE_ENGINE=engine)
            status, said = run([gnurt, "testshade", "-g", "32", "32", *wanted, oso], env=environment, cwd=out)
            pixels = [open(p, "rb").read() for p in wanted[2::3] if os.path.exists(p)]
            texts.append((status, said, pixels))
            for p in wanted[2::3]:
                if os.path.exists(p):
                    os.remove(p)
        state = "runs" if texts[0][0] == 0 else "fails"
        if texts[0] != texts[1]:
            state = "engines differ"
        errors = [line for line in texts[0][1].splitlines() if "ERROR" in line or "WARNING" in line]
        note = errors[0][:160] if errors else ""
        if options.render is not None and any(word in short for word in options.render):
            text = open(oso, errors="replace").read()
            best = min((k for k in found if k[1] in KINDS), key=lambda k: KINDS.index(k[1]), default=None)
            if re.search(r"^global\s+closure color\s+Ci", text, re.M) or best is None:
                shader = oso
            else:
                shader = os.path.join(out, stem + ".oslgroup")
                show = os.path.join(out, "show_%s.osl" % best[1].replace(" ", "_"))
                with open(show, "w") as file:
                    file.write(SHOW[best[1]])
                with open(shader, "w") as file:
                    file.write("shader %s a ; shader %s b ; connect a.%s b.x ;" % (os.path.basename(oso), os.path.basename(show), best[0]))
            picture = os.path.join(out, stem + ".png")
            ball = "builtin:spheres --eye 0.4,1.5,2.6 --target -0.1,0.98,-1.3 --fov 34 --exposure -0.8".split()
            status, said = run([gnurt, "render", "-q", *ball, "-o", picture, "-r", "%sx%s" % (options.size, options.size), "--spp", options.spp,
                                "--clamp", "8", "--shader", "mirror=" + shader.replace(":", "\\:")], 120)
            state += ", rendered" if status == 0 else ", not rendered"
            if said.strip():
                note = said.strip().splitlines()[0][:200]
        rows.append((short, state, note))
    with open(os.path.join(out, "results.tsv"), "w") as file:
        for row in rows:
            file.write("\t".join(row) + "\n")
    states = {}
    for _, state, _ in rows:
        states[state] = states.get(state, 0) + 1
    print(len(rows), "shaders:", ", ".join("%d %s" % (n, s) for s, n in sorted(states.items(), key=lambda x: -x[1])))


if __name__ == "__main__":
    sys.exit(main())
