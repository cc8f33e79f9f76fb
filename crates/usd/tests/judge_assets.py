# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares `gnurt info --json` with OpenUSD on all stages of a folder, such as those of github.com/usd-wg/assets.

    pip install usd-core numpy
    git clone https://github.com/usd-wg/assets
    python3 crates/usd/tests/judge_assets.py target/debug/gnurt assets

Each stage is read at its first, middle and last moment. Meshes are checked for triangles, area, bounds, centroid and material,
skinned ones after OpenUSD's own skinning; spheres, cones and the like for all but triangles. A stage that OpenUSD cannot open
must give one line with an error. Exit status 0 if 97 % of the checks pass.
"""
import json
import os
import subprocess
import sys
import time as clock

from pxr import Usd

from oracle import compare, expected


def moments(stage):
    """Seconds at which a stage is compared."""
    rate = stage.GetTimeCodesPerSecond()
    if not stage.HasAuthoredTimeCodeRange() or rate <= 0:
        return [0.0]
    first, last = stage.GetStartTimeCode() / rate, stage.GetEndTimeCode() / rate
    return [first] if first == last else [first, (first + last) / 2, last]


def main():
    program, top = sys.argv[1:3]
    stages = sorted(
        os.path.join(folder, name)
        for folder, _, names in os.walk(top)
        for name in names
        if os.path.splitext(name)[1] in (".usd", ".usda", ".usdc", ".usdz")
    )
    total = good = meshes = broken = clear = 0
    report = []
    seconds_of_ours = 0.0
    for path in stages:
        label = os.path.relpath(path, top)
        try:
            stage = Usd.Stage.Open(path)
        except Exception:  # The binding raises its own kind and others.
            stage = None
        if stage is None:
            broken += 1
            run = subprocess.run([program, "info", path, "--json"], capture_output=True, text=True)
            errors = [line for line in run.stderr.splitlines() if line.startswith("error: ")]
            is_clear = run.returncode != 0 and len(errors) == 1
            clear += is_clear
            report += [] if is_clear else [f"{label}: status {run.returncode}, {run.stderr.strip()[:300]}"]
            continue
        for seconds in moments(stage):
            try:
                want = expected(stage, seconds)
            except Exception as error:
                report.append(f"{label} at {seconds}: the judge fails: {error!r}")
                continue
            begin = clock.monotonic()
            command = [program, "info", path, "--json", "--at", repr(seconds)]
            run = subprocess.run(command, capture_output=True, text=True)
            seconds_of_ours += clock.monotonic() - begin
            meshes += len(want)
            if run.returncode:
                total += 1 + 5 * len(want)
                report.append(f"{label} at {seconds}: {run.stderr.strip()[:300]}")
                continue
            info = json.loads(run.stdout)
            checks, passed = compare(f"{label} at {seconds}", want, info, report)
            total, good = total + checks, good + passed
    for line in report[:400]:
        print(line)
    print(f"{len(stages)} stages, {meshes} meshes, {good} of {total} checks pass: {100 * good / max(1, total):.2f} %")
    print(f"{clear} of {broken} broken stages give one error; {seconds_of_ours:.1f} s of reading")
    sys.exit(0 if good >= 0.97 * total and clear == broken else 1)


if __name__ == "__main__":
    main()
