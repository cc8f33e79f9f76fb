#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs OSL's own test suite with our tools and says which tests pass.

    bench/osl/run.py SUITE PROGRAM [--tier T1|T2|all] [--only NAME ...] [-j N] [-v]
    bench/osl/run.py SUITE PROGRAM --tier T4 --engines interpreter,avx2,avx512 [-j N]

SUITE is a checkout of OpenShadingLanguage (its files stay where they are), PROGRAM a program that is one of the tools
when it is called by a link of that name (`gnurt`, or the example `osl` of gnurt-sl-shading).

Rules: text is equal to ref/out.txt or to any other ref/*.txt; pictures are compared by failthresh, failpercent and hardfail,
by `oiiotool` (Debian: openimageio-tools), of the same extension; a status other than 0 fails unless the test says failureok; 30 s a command.
The variable TESTSHADE_ENGINE chooses what runs shaders. With --engines there are no references: each command is done by each
of these, on 13 x 11 points, and pictures of floats and texts must be equal byte for byte.
"""
import argparse, filecmp, glob, os, re, shutil, subprocess, sys, tempfile
from concurrent.futures import ThreadPoolExecutor

HOST = ["texture", "environment", "pointcloud", "dict_", "gettextureinfo"]
UNREGISTERED = ["lazyglobals", "oslc-empty", "oslc-err-initlist", "spline-nonuniformknots", "test-fmt-journalbuffercapacity"]
# Need more than the tools: OCIO, a file format plugin, the C++ back end, a simulated lack of memory.
INTERNAL = ["ocio", "osl-imageio", "backend-cpp", "bug-peep", "groupdata-opt", "compile-buffer", "getsymbol-nonheap"]


def tier(suite, name):
    """T1, T2, T3, T4, T5 or X, as docs class them."""
    folder = os.path.join(suite, "testsuite", name)
    text = open(os.path.join(folder, "run.py")).read()
    refs = [os.path.basename(p) for p in glob.glob(os.path.join(folder, "ref", "*"))]
    code = "".join(open(p, errors="replace").read() for p in glob.glob(os.path.join(folder, "*.osl")))
    code = re.sub(r"//.*", "", code)
    if name in UNREGISTERED or name in INTERNAL or re.search("optix|python|cuda", name):
        return "X"
    if name.startswith("example-"):
        return "X"
    if name.endswith("-reg"):
        return "T4"
    if "testrender" in text:
        return "T5"
    if any(word in code for word in HOST):
        return "T3"
    return "T2" if any(r.endswith((".tif", ".exr")) for r in refs) else "T1"


class Test:
    def __init__(self, suite, program, name, keep, engines=()):
        self.suite, self.program, self.name, self.keep, self.engines = suite, program, name, keep, engines

    def run(self):
        source = os.path.join(self.suite, "testsuite", self.name)
        work = tempfile.mkdtemp(prefix=self.name + "-")
        try:
            return self.inside(source, work)
        finally:
            if self.keep:
                print("kept", work)
            else:
                shutil.rmtree(work, ignore_errors=True)

    def inside(self, source, work):
        bin = os.path.join(work, ".bin")
        os.mkdir(bin)
        for tool in ["oslc", "oslinfo", "testshade"]:
            os.symlink(self.program, os.path.join(bin, tool))
        common = os.path.join(self.suite, "testsuite", "common")
        # Tests look for ../common and data/.
        place = os.path.join(work, self.name)
        os.mkdir(place)
        if os.path.isdir(common):
            os.symlink(common, os.path.join(work, "common"))
        os.symlink(source, os.path.join(place, "data"))
        for part in ["ref", "src"]:
            if os.path.isdir(os.path.join(source, part)):
                os.symlink(os.path.join(source, part), os.path.join(place, part))
        for pattern in ["*.osl", "*.h", "*.oslgroup", "*.xml"]:
            for path in glob.glob(os.path.join(source, pattern)):
                shutil.copyfile(path, os.path.join(place, os.path.basename(path)))
        redirect = " >> out.txt 2>>out.txt "

        def app(tool):
            return os.path.join(bin, tool) + " "

        names = dict(
            command="", outputs=["out.txt"], failthresh=0.004, hardfail=0.01, failpercent=0.02, failrelative=0.001,
            allowfailures=0, failureok=0, filter_re=None, oslcargs="-Wall", compile_osl_files=True, splitsymbol=";",
            redirect=redirect, os=os, sys=sys, glob=glob, re=re, shutil=shutil, OSL_TESTSUITE_ROOT="..", refdir="ref/",
            OSL_TESTSUITE_DIR=os.path.join(self.suite, "testsuite"), OSL_BUILD_DIR=work, idiff_program="oiiotool",
            idiff_postfilecmd="", OSL_SOURCE_DIR=self.suite, test_source_dir=source, pythonbin=sys.executable,
            make_relpath=os.path.relpath, platform=__import__("platform"),
        )
        names["osl_app"] = app
        names["oiio_app"] = lambda tool: tool + " "
        names["oslc"] = lambda args: app("oslc") + names["oslcargs"] + " " + args + redirect + " ;\n"
        names["oslinfo"] = lambda args: app("oslinfo") + args + redirect + " ;\n"
        names["testshade"] = lambda args: app("testshade") + args + redirect + " ;\n"
        names["testrender"] = lambda args: "false ;\n"
        names["oiiotool"] = lambda args, silent=False: "oiiotool " + args + ("" if silent else redirect) + " ;\n"
        names["maketx"] = lambda args: "maketx " + args + redirect + " ;\n"
        names["run_app"] = lambda a, silent=False, concat=True: a + ("" if silent else redirect) + (" ;\n" if concat else "")
        why = []

        def runtest(commands, outputs=["out.txt"], *_, **__):
            found = self.commands(place, bin, commands, outputs, names)
            why.extend(found)
            return 1 if found else 0

        names["runtest"] = runtest
        try:
            exec(compile(open(os.path.join(source, "run.py")).read(), "run.py", "exec"), names)
        except (Exception, SystemExit) as e:
            return [f"run.py: {e}"]
        commands = names["command"]
        if names["compile_osl_files"]:
            files = sorted(os.path.basename(p) for p in glob.glob(os.path.join(place, "*.osl")))
            commands = "".join(names["oslc"](f) for f in files) + commands
        outputs = list(names["outputs"])
        for extension in ["exr", "tif"]:
            if os.path.exists(os.path.join(place, "ref", "out." + extension)) and "out." + extension not in outputs:
                outputs.append("out." + extension)
        try:
            names["runtest"](commands, outputs)
        except (Exception, SystemExit) as e:
            why.append(f"run.py: {e}")
        return why

    def commands(self, place, bin, commands, outputs, names):
        source = os.path.join(self.suite, "testsuite", self.name)
        level = "2" if os.path.exists(os.path.join(source, "OPTIMIZEONLY")) else "0"
        environment = dict(os.environ, OSLHOME=os.path.join(self.suite, "src"), TESTSHADE_OPT=level)
        open(os.path.join(place, "out.txt"), "w").close()
        why = []
        if self.engines:
            return self.among_engines(place, bin, commands, outputs, names, environment)
        for command in commands.split(names["splitsymbol"]):
            command = command.strip()
            if not command:
                continue
            try:
                status = subprocess.run(command, shell=True, cwd=place, env=environment, timeout=30).returncode
            except subprocess.TimeoutExpired:
                why.append("more than 30 s: " + command)
                continue
            if status != 0 and not names["failureok"]:
                why.append(f"status {status}: " + command.replace(bin + "/", ""))
        for output in outputs:
            reason = self.compare(place, output, names)
            if reason:
                why.append(reason)
        return why

    def among_engines(self, place, bin, commands, outputs, names, environment):
        """What differs between engines."""
        why, first = [], {}
        text = os.path.join(place, "out.txt")
        for command in filter(None, (c.strip() for c in commands.split(names["splitsymbol"]))):
            if "testshade" not in command:
                subprocess.run(command, shell=True, cwd=place, env=environment, timeout=60)
                continue
            command = command.replace("-od uint8", "-od float").replace("-g 32 32", "-g 13 11")
            files = re.findall(r"-o \S+ (\S+\.(?:tif|exr))", command)
            first = None
            for engine in self.engines:
                open(text, "w").close()
                for name in files:
                    if os.path.exists(os.path.join(place, name)):
                        os.remove(os.path.join(place, name))
                try:
                    done = subprocess.run(command, shell=True, cwd=place, env=dict(environment, TESTSHADE_ENGINE=engine), timeout=60)
                except subprocess.TimeoutExpired:
                    why.append(f"{engine}: more than 60 s: {command}")
                    continue
                paths = [os.path.join(place, name) for name in files + ["out.txt"]]
                found = [done.returncode] + [open(p, "rb").read() if os.path.exists(p) else None for p in paths]
                if first is None:
                    first = found
                elif found != first:
                    which = [n for n, a, b in zip(["status"] + files + ["out.txt"], first, found) if a != b]
                    why.append(f"{engine}: {' '.join(which)}: {command.replace(bin + '/', '')}")
                self.count = getattr(self, "count", 0) + 1
        return why

    def compare(self, place, output, names):
        path = os.path.join(place, output)
        if not os.path.exists(path):
            return output + " is missing"
        extension = os.path.splitext(output)[1]
        refs = [os.path.join(place, "ref", output)] + sorted(glob.glob(os.path.join(place, "ref", "*" + extension)))
        refs = [r for r in refs if os.path.exists(r)]
        said = f"{output}: no reference"
        for ref in refs:
            if extension == ".txt":
                lines = [open(p, errors="replace").readlines() for p in (path, ref)]
                if names["filter_re"]:
                    keep = re.compile(names["filter_re"])
                    lines = [[l for l in part if keep.match(l)] for part in lines]
                if lines[0] == lines[1]:
                    return None
                if ref == refs[0]:
                    first = next((i for i, (a, b) in enumerate(zip(*lines)) if a != b), min(map(len, lines)))
                    show = [part[first].rstrip("\n") if first < len(part) else "(end)" for part in lines]
                    said = f"{output} line {first + 1}: {show[0]!r} should be {show[1]!r}"
            elif extension in (".tif", ".exr"):
                limits = []
                for option, key in [("-fail", "failthresh"), ("-failpercent", "failpercent"), ("-hardfail", "hardfail")]:
                    limits += [option, str(names[key])]
                done = subprocess.run(["oiiotool", "-a", *limits, path, ref, "--diff"], capture_output=True, text=True)
                if done.returncode == 0:
                    return None
                if ref == refs[0]:
                    said = f"{output}: {done.stdout.strip()} {done.stderr.strip()}"
            elif filecmp.cmp(path, ref, shallow=False):
                return None
            else:
                said = f"{output} differs from {os.path.basename(ref)}"
        return said


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("suite")
    parser.add_argument("program")
    parser.add_argument("--tier", default="T1")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("-j", type=int, default=1)
    parser.add_argument("-v", action="store_true")
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--engines", default="")
    options = parser.parse_args()
    suite, program = os.path.abspath(options.suite), os.path.abspath(options.program)
    folder = os.path.join(suite, "testsuite")
    tests = sorted(n for n in os.listdir(folder) if os.path.exists(os.path.join(folder, n, "run.py")))
    if options.only:
        tests = [n for n in tests if n in options.only]
    elif options.tier != "all":
        tests = [n for n in tests if tier(suite, n) == options.tier]
    good, runs = 0, 0
    engines = [e for e in options.engines.split(",") if e]

    def one(name):
        test = Test(suite, program, name, options.keep, engines)
        return name, test.run(), getattr(test, "count", 0)

    with ThreadPoolExecutor(options.j) as pool:
        for name, why, count in pool.map(one, tests):
            good += not why
            runs += count
            if why:
                print(f"FAIL {name}: " + " | ".join(why[: 9 if options.v else 1]), flush=True)
    print(f"{good} of {len(tests)} tests of tier {options.tier} pass" + (f", {runs} runs" if engines else ""))
    return 0 if good == len(tests) else 1


if __name__ == "__main__":
    sys.exit(main())
