#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the scenes of OSL's test suite with gnurt, and compares means with those of the suite's own pictures.

    bench/osl/scenes.py SUITE GNURT [--only NAME ...] [--spp N] [--keep FOLDER] [--as-is]

SUITE is a checkout of OpenShadingLanguage (its files stay where they are), GNURT the program. A scene's XML becomes an OBJ whose
materials are the scene's groups, in OSL's text form; `gnurt render` does the rest: path tracing, a tent filter, as many bounces.
Six things are put into copies of shaders: that values of pictures are as they are stored, the type `environment` in the background's, its direction, since skies have z up, the
light of its sun, which the suite's own table has too bright, that the sky which lights surfaces is of no kind of ray, as that table has it, and `"multiscatter", 3` for microfacets that
reflect, which is how the suite's own closures keep light between them; `--as-is` leaves the last two out. Printed, by colours: the mean of the picture over that of the reference, the best of ref/*.exr, whose own
noise is a tenth of a percent to one percent; and the mean difference of the pictures at a quarter of their size.

Means of each picture, of its quarters and differences are found by `oiiotool` (Debian: openimageio-tools).
"""
import argparse, glob, math, os, re, shutil, subprocess, sys, tempfile
import xml.etree.ElementTree as ElementTree

# What gnurt does not draw: scattering volumes, displacement, a closure of one studio's own.
WITHOUT = {"render-displacement": "displacement shaders", "render-mx-anisotropic-vdf": "volumes", "render-mx-medium-vdf": "volumes",
           "render-mx-medium-vdf-glass": "volumes", "render-spi-thinlayer": "a closure spi_thinlayer", "compstats": "statistics, no picture"}


def vector(text):
    return [float(x) for x in text.split(",")]


def add(a, b, k=1.0):
    return [x + k * y for x, y in zip(a, b)]


class Mesh:
    """Triangles: places, texture coordinates and normals, each a list of its own."""

    def __init__(self, group):
        self.group, self.places, self.coordinates, self.normals, self.faces = group, [], [], [], []


def quad(group, p, ex, ey, n):
    mesh = Mesh(group)
    for v in range(n + 1):
        for u in range(n + 1):
            s, t = u / n, v / n
            mesh.places.append(add(add(p, ex, s), ey, t))
            mesh.coordinates.append([s, t])
    for v in range(n):
        for u in range(n):
            a, b, c, d = (u + i + (v + j) * (n + 1) for i, j in [(0, 0), (1, 0), (1, 1), (0, 1)])
            mesh.faces += [[(a, a), (b, b), (c, c)], [(a, a), (c, c), (d, d)]]
    return mesh


def sphere(group, center, r, n):
    """Rings between poles, as the suite's renderer has them; each pole is many triangles."""
    mesh = Mesh(group)
    w = 2 * n
    mesh.normals.append([0, 1, 0])
    for y in range(n):
        z = math.cos((y + 0.5) / n * math.pi)
        q = math.sqrt(max(0.0, 1 - z * z))
        for x in range(w):
            a = 2 * math.pi * x / w
            mesh.normals.append([-q * math.sin(a), z, -q * math.cos(a)])
    mesh.normals.append([0, -1, 0])
    mesh.places = [add(center, normal, r) for normal in mesh.normals]
    for y in range(2):
        mesh.coordinates += [[(x + 0.5) / w, y] for x in range(w)]
    for y in range(n):
        mesh.coordinates += [[x / w, (y + 0.5) / n] for x in range(w + 1)]
    place = lambda x, y: 1 + x % w + w * y
    grid = lambda x, y: 2 * w + x + (w + 1) * y
    last = len(mesh.places) - 1
    for x in range(w):
        mesh.faces.append([(0, x), (place(x, 0), grid(x, 0)), (place(x + 1, 0), grid(x + 1, 0))])
        for y in range(n - 1):
            a, b, c, d = ((place(x + i, y + j), grid(x + i, y + j)) for i, j in [(1, 0), (0, 0), (0, 1), (1, 1)])
            mesh.faces += [[a, b, c], [a, c, d]]
        mesh.faces.append([(last, w + x), (place(x + 1, n - 1), grid(x + 1, n - 1)), (place(x, n - 1), grid(x, n - 1))])
    return mesh


def model(group, path):
    mesh = Mesh(group)
    for line in open(path):
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            mesh.places.append([float(x) for x in words[1:4]])
        elif words[0] == "vt":
            mesh.coordinates.append([float(x) for x in words[1:3]])
        elif words[0] == "vn":
            mesh.normals.append([float(x) for x in words[1:4]])
        elif words[0] == "f":
            corners = []
            for word in words[1:]:
                parts = [int(x) - 1 if x else None for x in word.split("/")]
                corners.append(tuple(parts + [None] * (3 - len(parts))))
            for k in range(2, len(corners)):
                mesh.faces.append([corners[0], corners[k - 1], corners[k]])
    return mesh


def group_text(node):
    if node.get("commands"):
        return node.get("commands")
    text, lines = node.text or "", []
    for child in node:
        if child.tag == "Parameter":
            for name, value in child.attrib.items():
                kind = value.split()[0]
                known = kind in ("int", "float", "vector", "point", "color")
                lines.append(f"param {kind} {name} {value[len(kind):]} ;" if known else f'param string {name} "{value}" ;')
        elif child.tag == "Shader":
            lines.append(f"shader {child.get('name')} {child.get('layer')} ;")
        elif child.tag == "ConnectShaders":
            lines.append("connect {srclayer}.{srcparam} {dstlayer}.{dstparam} ;".format(**child.attrib))
    return text + "\n".join(lines)


class Scene:
    def __init__(self, folder, work, common, as_is):
        self.folder, self.work, self.as_is = folder, work, as_is
        self.meshes, self.groups, self.background, self.bounces = [], [], None, None
        for path in glob.glob(os.path.join(folder, "*.osl")):
            shutil.copyfile(path, os.path.join(work, os.path.basename(path)))
        # Files name their shaders as they like: the name in the text is what groups say.
        self.files = {}
        for path in glob.glob(os.path.join(work, "*.osl")):
            text = open(path).read().replace("../common", common)
            # The suite's renderer takes pictures' values as they are.
            text = re.sub(r"(\btexture\s*\(\s*filename,[^;]*?)\)\s*;", r'\1, "colorspace", "raw");', text)
            if not as_is:
                text = re.sub(r"\b((?:conductor|generalized_schlick)_bsdf\s*\([^;]*\"ggx\")", r'\1, "multiscatter", 3', text)
            for name in re.findall(r"^\s*(?:surface|shader|displacement)\s+(\w+)", re.sub(r"//.*|/\*.*?\*/", "", text), re.M):
                self.files[name] = text
        xml = [p for p in glob.glob(os.path.join(folder, "*.xml"))]
        self.read(ElementTree.parse(xml[0]).getroot(), common)

    def read(self, root, common):
        for node in root:
            get = lambda name: vector(node.get(name))
            last = len(self.groups) - 1
            if node.tag == "Option" and node.get("max_bounces"):
                self.bounces = int(node.get("max_bounces").split()[-1])
            elif node.tag == "Camera":
                self.eye = get("eye")
                self.target = add(self.eye, get("dir")) if node.get("dir") else get("look_at")
                self.up = get("up") if node.get("up") else [0, 1, 0]
                self.fov = math.degrees(2 * math.atan(math.tan(math.radians(float(node.get("fov", 90))) / 2) / 2))
            elif node.tag == "Sphere":
                resolution = int(node.get("resolution", 64))
                self.meshes.append(sphere(last, get("center"), float(node.get("radius")), resolution))
            elif node.tag == "Quad":
                self.meshes.append(quad(last, get("corner"), get("edge_x"), get("edge_y"), int(node.get("resolution", 1))))
            elif node.tag == "Model":
                self.meshes.append(model(last, os.path.join(self.folder, re.sub("^data/", "", node.get("filename")))))
            elif node.tag == "Background":
                self.background = last
            elif node.tag == "ShaderGroup":
                self.groups.append(group_text(node).replace("../common", common))

    def write_shader(self, name, as_name, values=None):
        text = self.files[name]
        if values is not None:
            text = re.sub(rf"\b(surface|shader)(\s+{name}\b)", r"environment\2", text, count=1)
            for param, value in values:
                numbers = value.split()
                given = value if value.startswith('"') or len(numbers) == 1 else "color (" + ", ".join(numbers) + ")"
                text = re.sub(rf"\b({param}\s*=)[^,)]+", lambda found: f"{found[1]} {given}", text, count=1)
            # The suite's renderer sees a table of 1024 by 1024 cells in the sky's place, in which the sun of its scenes, 5 degrees
            # wide, is larger by this much (the share of cells whose middles lie in it).
            text = text.replace("sun / (1 - cos_ang)", "1.01402 * sun / (1 - cos_ang)")
            if not self.as_is:
                # The table is made for rays of no kind; only rays of the camera see the sky itself.
                text = re.sub(r'\braytype\s*\(\s*"(?!camera)\w+"\s*\)', "0", text)
            # Skies have z up, scenes of the suite y.
            text = "#define I vector (I[0], I[2], -I[1])\n" + text
        open(os.path.join(self.work, as_name + ".osl"), "w").write(text)

    def write(self):
        """Writes files; gives the options of gnurt."""
        lines, options, base = ["mtllib scene.mtl"], [], [1, 1, 1]
        materials = []
        for number, mesh in enumerate(self.meshes):
            material = f"m{number}"
            materials.append(f"newmtl {material}\nKd 1 1 1\n")
            lines.append(f"usemtl {material}")
            lines += ["v {} {} {}".format(*p) for p in mesh.places]
            lines += ["vt {} {}".format(*t) for t in mesh.coordinates]
            lines += ["vn {} {} {}".format(*n) for n in mesh.normals]
            for face in mesh.faces:
                words = []
                for corner in face:
                    p, t = corner[0], corner[1]
                    n = corner[2] if len(corner) > 2 else (p if mesh.normals else None)
                    words.append(f"{p + base[0]}/{'' if t is None else t + base[1]}" + ("" if n is None else f"/{n + base[2]}"))
                lines.append("f " + " ".join(words))
            for k, part in enumerate([mesh.places, mesh.coordinates, mesh.normals]):
                base[k] += len(part)
            text = self.groups[mesh.group]
            names = re.findall(r"\bshader\s+(\w+)", text)
            for name in set(names):
                self.write_shader(name, f"{material}_{name}")
            text = re.sub(r"\bshader\s+(\w+)", rf"shader {material}_\1", text).strip()
            text = text if text.endswith(";") else text + ";"
            # A value for a parameter that is not there is none, and the word `param` may be left out.
            source = "".join(self.files[name] for name in set(names))
            text = re.sub(r"(^|;)\s*(?:param\s+)?(?:color|float|int|string|vector|point|normal)\s+(\w+)[^;]*(?=;)",
                          lambda found: found[0] if re.search(rf"\b{found[2]}\b", source) else found[1], text)
            text = re.sub(r"(^|;)\s*(color|float|int|string|vector|point|normal)\b", r"\1 param \2", text)
            open(os.path.join(self.work, material + ".oslgroup"), "w").write(text)
            options += ["--shader", f"{material}={os.path.join(self.work, material)}.oslgroup"]
        open(os.path.join(self.work, "scene.obj"), "w").write("\n".join(lines) + "\n")
        open(os.path.join(self.work, "scene.mtl"), "w").write("".join(materials))
        sky = "0,0,0"
        if self.background is not None:
            text = self.groups[self.background]
            name = re.findall(r"\bshader\s+(\w+)", text)[-1]
            values = re.findall(r"(?:param\s+)?(?:color|float|string)\s+(\w+)\s+([^;]+?)\s*;", text)
            self.write_shader(name, "sky", values=values)
            sky = os.path.join(self.work, "sky.osl")
        options += ["--environment", sky]
        for name, value in [("eye", self.eye), ("target", self.target), ("up", self.up)]:
            options += [f"--{name}={','.join(map(str, value))}"]
        return options + ["--fov", repr(self.fov), "--max-depth", str(1000 if self.bounces is None else self.bounces + 1)]


def means(*arguments):
    done = subprocess.run(["oiiotool", *arguments, "--ch", "R,G,B", "--printstats"], capture_output=True, text=True)
    found = re.search(r"Stats Avg:\s*([\d.e+-]+) ([\d.e+-]+) ([\d.e+-]+)", done.stdout)
    return [float(x) for x in found.groups()] if found else None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("suite")
    parser.add_argument("gnurt")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--keep")
    parser.add_argument("--as-is", action="store_true")
    options = parser.parse_args()
    suite, gnurt = os.path.abspath(options.suite), os.path.abspath(options.gnurt)
    folder = os.path.join(suite, "testsuite")
    good = tried = 0
    for name in sorted(n for n in os.listdir(folder) if n.startswith("render-") and os.path.exists(os.path.join(folder, n, "run.py"))):
        if options.only and name not in options.only:
            continue
        if name in WITHOUT:
            print(f"---- {name}: not drawn: {WITHOUT[name]}", flush=True)
            continue
        tried += 1
        work = tempfile.mkdtemp(prefix=name + "-")
        size = re.search(r"-r (\d+) (\d+)", open(os.path.join(folder, name, "run.py")).read()).groups()
        out = os.path.join(options.keep or work, name + ".exr")
        try:
            scene = Scene(os.path.join(folder, name), work, os.path.join(folder, "common"), options.as_is)
            command = [gnurt, "render", os.path.join(work, "scene.obj"), *scene.write(), "--integrator", "path", "--spp", str(options.spp),
                       "--filter", "triangle", "--denoise=none", "-r", "x".join(size), "-o", out, "-q"]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                print(f"FAIL {name}: {done.stderr.strip().splitlines()[:3]}", flush=True)
                continue
            # What lies behind everything is a layer of its own.
            behind = ["--ch", ",".join("background." + c for c in "RGB"), "--chnames", "R,G,B"]
            subprocess.run(["oiiotool", out, "--ch", "R,G,B", out, *behind, "--add", "-o", out], check=True)
            ours, found = means(out), []
            for reference in glob.glob(os.path.join(folder, name, "ref", "*.exr")):
                theirs = means(reference)
                ratios = [a / b if b else 1.0 for a, b in zip(ours, theirs)]
                small = ["--resize", "25%"]
                difference = means(out, "--ch", "R,G,B", *small, reference, "--ch", "R,G,B", *small, "--absdiff")
                found.append((max(abs(r - 1) for r in ratios), ratios, sum(difference or [0]) / sum(theirs)))
            off, ratios, difference = min(found)
            good += off <= 0.01
            print(f"{'good' if off <= 0.01 else 'FAIL'} {name}: {' '.join(f'{r:.4f}' for r in ratios)}; differs {100 * difference:.1f} %", flush=True)
        finally:
            if not options.keep:
                shutil.rmtree(work, ignore_errors=True)
    print(f"{good} of {tried} scenes have means within 1 %")
    return 0 if good == tried else 1


if __name__ == "__main__":
    sys.exit(main())
