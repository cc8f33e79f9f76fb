# SPDX-License-Identifier: GPL-3.0-or-later
"""Needs the program `gnurt` (GNURT names it) and Dask; without them it is skipped, but for what needs neither."""

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import pytest

import gnurt.cluster

GNURT = os.environ.get("GNURT") or shutil.which("gnurt")
OBJ = "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"


@pytest.fixture
def scene(tmp_path):
    folder = tmp_path / "scene"
    folder.mkdir()
    (folder / "a.obj").write_text(OBJ)
    (folder / "a.mtl").write_text("newmtl red\nKd 0.8 0.1 0.1\n")
    return folder / "a.obj"


def test_scenes_are_named_by_content(scene, tmp_path):
    def name(options=()):
        return gnurt.cluster.Job(str(scene), "out.png", options).name

    first = name()
    os.utime(scene, (1, 1))
    assert name() == first, "times do not count"
    job = gnurt.cluster.Job(str(scene), "out.png", ["--environment", str(scene), "--spp=3"])
    assert job.words == ["scene/a.obj", "--environment", "options/2-a.obj", "--spp=3"]
    gnurt.cluster._unpack(job.name, job.archive)
    gnurt.cluster._unpack(job.name, job.archive)
    there = gnurt.cluster._folder(job.name)
    assert open(os.path.join(there, "scene/a.mtl")).read().startswith("newmtl"), "what the scene names goes along"
    shutil.rmtree(there)
    scene.with_suffix(".mtl").write_text("newmtl red\nKd 0.8 0.1 0.2\n")
    assert name() != first, "all files count"


def test_folders_of_others_are_not_trusted(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    job = gnurt.cluster.Job(str(scene), "out.png")
    shared, elsewhere = tmp_path / f"gnurt-{os.getuid()}", tmp_path / "elsewhere"

    def forge(folder, mode):
        (folder / job.name / "scene").mkdir(parents=True)
        (folder / job.name / "scene" / "a.mtl").write_text("newmtl forged")
        folder.chmod(mode)

    def link():
        forge(elsewhere, 0o700)
        shared.symlink_to(elsewhere)

    def of_another():
        forge(shared, 0o700)
        if os.getuid() == 0:
            os.chown(shared, 12345, 12345)
        else:
            shared.chmod(0o770)

    for make in (lambda: forge(shared, 0o777), link, of_another):
        make()
        gnurt.cluster._unpack(job.name, job.archive)
        there = gnurt.cluster._folder(job.name)
        assert open(os.path.join(there, "scene/a.mtl")).read().startswith("newmtl red"), "what the job brought"
        parent = os.lstat(os.path.dirname(there))
        assert parent.st_uid == os.getuid() and parent.st_mode & 0o777 == 0o700
        assert gnurt.cluster._folder(job.name) == there, "this process finds it again"
        shared.unlink() if shared.is_symlink() else shutil.rmtree(shared)
    gnurt.cluster._unpack(job.name, job.archive)
    assert gnurt.cluster._folder(job.name) == str(shared / job.name), "our own is shared"
    assert os.stat(shared).st_mode & 0o777 == 0o700


def test_programs_die_with_their_worker(tmp_path):
    file = tmp_path / "pid"
    words = ["sh", "-c", f"echo $$ > {file}.new; mv {file}.new {file}; exec sleep 60"]
    worker = subprocess.Popen([sys.executable, "-c", f"import gnurt.cluster; gnurt.cluster._run({words!r})"])
    end = time.monotonic() + 30
    while not file.exists() and time.monotonic() < end:
        time.sleep(0.02)
    pid = int(file.read_text())
    worker.kill()
    worker.wait()

    def is_there():
        try:
            return open(f"/proc/{pid}/stat").read().rpartition(")")[2].split()[0] != "Z"
        except FileNotFoundError:
            return False

    while is_there() and time.monotonic() < end:
        time.sleep(0.02)
    assert not is_there()
    with pytest.raises(RuntimeError, match="error: no/such/program: No such file"):
        gnurt.cluster._run(["no/such/program"])
    with pytest.raises(RuntimeError, match="sh ended with 3: words"):
        gnurt.cluster._run(["sh", "-c", "echo words >&2; exit 3"])


def test_wrong_jobs(scene):
    for words, message in (
        ({"pieces": 0}, "pieces"),
        ({"frames": (1, 2)}, "####"),
        ({"scene": "a.####.ply"}, "sequences"),
    ):
        with pytest.raises(ValueError, match=message):
            gnurt.cluster.Job(**{"scene": str(scene), "output": "a.png", **words})


needs_program = pytest.mark.skipif(GNURT is None, reason="needs the program gnurt; GNURT names it")
EXAMPLES = os.path.join(os.path.dirname(__file__), "../../../examples/cluster")


@needs_program
def test_templates_of_farms(tmp_path):
    options = ["-q", "-r", "48x32", "--spp", "2"]
    one = tmp_path / "one.png"
    subprocess.run([GNURT, "render", "builtin:cornell", *options, "-o", one], check=True)
    for task in ("3", "1", "2", "2"):
        slurm = {"JOB_ID": "7", "TASK_ID": task, "TASK_MIN": "1", "TASK_COUNT": "3"}
        variables = {f"SLURM_ARRAY_{name}": value for name, value in slurm.items()}
        asked = {"SCENE": "builtin:cornell", "PICTURE": "slurm.png", "GNURT": GNURT}
        script = ["bash", os.path.abspath(os.path.join(EXAMPLES, "gnurt.sbatch")), *options]
        subprocess.run(script, check=True, cwd=tmp_path, env={**os.environ, **variables, **asked})
    assert (tmp_path / "slurm.png").read_bytes() == one.read_bytes()
    openjd = os.path.join(os.path.dirname(sys.executable), "openjd")
    if not os.path.exists(openjd):
        pytest.skip("openjd-cli is not there")
    template = os.path.join(EXAMPLES, "gnurt.openjd.yaml")
    subprocess.run([openjd, "check", template], check=True)
    given = {"Picture": tmp_path / "openjd.png", "Pieces": tmp_path / "pieces", "Program": GNURT}
    given |= {"Resolution": "48x32", "Samples": 2}
    words = [word for name, value in given.items() for word in ("-p", f"{name}={value}")]
    subprocess.run([openjd, "run", template, "--step", "Join", "--run-dependencies", *words], check=True)
    assert (tmp_path / "openjd.png").read_bytes() == one.read_bytes()


@needs_program
def test_the_command(tmp_path, capsys):
    pytest.importorskip("distributed")
    options = ["-r", "48x32", "--spp", "2"]
    subprocess.run([GNURT, "render", "-q", "builtin:cornell", *options, "-o", tmp_path / "one.png"], check=True)
    words = ["builtin:cornell", "--local", "1", "--pieces", "2", "--gnurt", GNURT, *options]
    assert gnurt.cluster.main([*words, "-o", str(tmp_path / "many.png")]) == 0
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "many.png").read_bytes()
    assert gnurt.cluster.main([*words, "-o", "a.png", "--frames", "1..2"]) == 1
    assert "error: output: frames need a place for their number" in capsys.readouterr().err


@needs_program
def test_killed_workers_change_nothing(scene, tmp_path):
    distributed = pytest.importorskip("distributed")
    options = ["-r", "96x64", "--spp", "16", "--seed", "5"]
    subprocess.run([GNURT, "render", "-q", str(scene), *options, "-o", str(tmp_path / "one.png")], check=True)
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=60)
    killed, over = [], threading.Event()

    def kill():
        while not over.wait(random.uniform(0.2, 0.8)) and len(killed) < 3:
            pids = [nanny.pid for nanny in cluster.workers.values() if nanny.pid]
            if pids:
                killed.append(random.choice(pids))
                os.kill(killed[-1], signal.SIGKILL)

    with cluster, distributed.Client(cluster) as client:
        killer = threading.Thread(target=kill)
        killer.start()
        output = str(tmp_path / "many.png")
        job = gnurt.cluster.Job(str(scene), output, options, pieces=8, program=GNURT)
        told = []
        assert gnurt.cluster.render(job, client, lambda *done: told.append(done), threads=1) == [output]
        over.set()
        killer.join()
        assert told[-1] == (8, 8)
        assert (tmp_path / "one.png").read_bytes() == (tmp_path / "many.png").read_bytes(), f"{len(killed)} were killed"
        bad = gnurt.cluster.Job(str(scene), output, ["--spp", "0"], pieces=1, program=GNURT)
        with pytest.raises(RuntimeError, match="--spp"):
            gnurt.cluster.render(bad, client)
    shutil.rmtree(gnurt.cluster._folder(job.name))
