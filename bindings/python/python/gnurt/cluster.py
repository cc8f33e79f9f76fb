# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures on many machines: `python -m gnurt.cluster SCENE --dask ADDRESS -o OUT`, or `--local N` for N processes of this one.

Each frame is cut into pieces (`gnurt render --piece`), which workers of a Dask cluster render; what comes back is joined here to the
bytes of a single run. A worker that dies costs its pieces, which others render again. The scene travels to each worker once, as an
archive that is named by its content. Workers need this package.
"""

import argparse
import atexit
import contextlib
import functools
import hashlib
import io
import logging
import os
import re
import shutil
import stat
import subprocess
import sys
import tarfile
import tempfile

__all__ = ["Job", "main", "render"]

#: How often a piece may be lost before the job is given up.
_PATIENCE = 20


class Job:
    """A picture, or the frames of an animation, to be rendered in pieces.

    `options` are those of `gnurt render`, `look` those of `gnurt join`; `frames` is None or (first, last). `program` is one that
    stands in for the one that this package carries.
    """

    def __init__(self, scene, output, options=(), look=(), pieces=16, frames=None, program=None):
        if pieces < 1:
            raise ValueError(f"pieces: expected a number from 1 on, not {pieces}")
        if frames is not None and "#" not in os.path.basename(output):
            raise ValueError(f"output: frames need a place for their number, as in frame.####.png, not {output}")
        if "#" in scene:
            raise ValueError(f"scene: sequences of files are not spread, only animations of one scene, not {scene}")
        self.output, self.look, self.pieces, self.program = output, list(look), pieces, program
        self.frames = [None] if frames is None else list(range(frames[0], frames[1] + 1))
        self.words, self.archive = _packed(scene, list(options))
        self.name = hashlib.sha256(self.archive).hexdigest()

    def tasks(self):
        """What is to be done: frames and pieces from 1 on."""
        return [(frame, piece) for frame in self.frames for piece in range(1, self.pieces + 1)]

    def join(self, folder, frame):
        """Joins the pieces of a frame that lie in a folder."""
        files = [_piece_name(folder, frame, piece) for piece in range(1, self.pieces + 1)]
        output = self.output
        if frame is not None:
            last = list(re.finditer("#+", output))[-1]
            output = f"{output[: last.start()]}{frame:0{len(last.group())}}{output[last.end() :]}"
        _run([*_program(self.program), "join", "-q", *files, "-o", output, *self.look])
        return output


def render(job, client, progress=None, threads=None):
    """Does the job on the workers of a Dask client; returns the files. `progress` is called with pieces done and pieces in all."""
    from distributed import KilledWorker, as_completed
    from concurrent.futures import CancelledError

    client.register_plugin(_plugin(job))
    tasks, losses, outputs = job.tasks(), {}, []
    missing = {frame: job.pieces for frame in job.frames}
    pending = {}
    with tempfile.TemporaryDirectory(prefix="gnurt-") as folder:

        def submit(task):
            words = ["render", "-q", *job.words] + ([] if threads is None else ["-t", str(threads)])
            future = client.submit(_render_piece, job.name, job.program, words, *task, job.pieces, pure=False)
            pending[future.key] = task
            return future

        waiting = as_completed([submit(task) for task in tasks])
        done = 0
        for future in waiting:
            task = pending.pop(future.key)
            try:
                file = future.result()
            except (KilledWorker, CancelledError) as error:
                losses[task] = losses.get(task, 0) + 1
                if losses[task] > _PATIENCE:
                    raise RuntimeError(f"piece {task[1]}/{job.pieces} was lost {_PATIENCE} times: {error}") from None
                waiting.add(submit(task))
                continue
            with open(_piece_name(folder, *task), "wb") as to:
                to.write(file)
            done, frame = done + 1, task[0]
            missing[frame] -= 1
            if progress is not None:
                progress(done, len(tasks))
            if missing[frame] == 0:
                outputs.append(job.join(folder, frame))
                for piece in range(1, job.pieces + 1):
                    os.unlink(_piece_name(folder, frame, piece))
    return sorted(outputs)


def _piece_name(folder, frame, piece):
    return os.path.join(folder, f"{0 if frame is None else frame}.{piece}.exr")


def _packed(scene, options):
    """The words of a call in an unpacked archive, and the archive: the scene's files, and those that options name."""
    from ._gnurt import Scene

    files, words = [], []
    if scene.startswith("builtin:"):
        words.append(scene)
    else:
        files = [os.path.abspath(file) for file in [scene, *Scene._files(scene)] if os.path.isfile(file)]
        root = os.path.commonpath([os.path.dirname(file) for file in files])
        words.append(os.path.join("scene", os.path.relpath(os.path.abspath(scene), root)))
    named = {f"scene/{os.path.relpath(file, root)}": file for file in files}
    for word in options:
        option, between, value = word.partition("=") if word.startswith("--") else ("", "", word)
        if os.path.isfile(value):
            name = f"options/{len(named)}-{os.path.basename(value)}"
            named[name] = value
            value = name
        words.append(option + between + value)
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w") as archive:
        for name in sorted(named):
            # Nothing but names and contents, so that equal scenes have equal archives.
            about = tarfile.TarInfo(name)
            about.size = os.path.getsize(named[name])
            with open(named[name], "rb") as file:
                archive.addfile(about, file)
    return words, packed.getvalue()


def _is_private(folder):
    """Whether a folder is this user's and nobody else can have put anything in it."""
    try:
        found = os.lstat(folder)
    except OSError:
        return False
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o077


@functools.lru_cache(maxsize=None)
def _fresh_parent(process):
    """A folder of this process alone, which goes with it."""
    folder = tempfile.mkdtemp(prefix=f"gnurt-{process}-")

    def remove():
        # A fork of this process may end first.
        if os.getpid() == process:
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    return folder


def _parent():
    """Where archives are unpacked: a folder that all processes of this user share; or, where somebody else may have made that, one of
    this process, for what lies there decides which code runs."""
    shared = os.path.join(tempfile.gettempdir(), f"gnurt-{os.getuid()}")
    with contextlib.suppress(OSError):
        os.mkdir(shared, mode=0o700)
    return shared if _is_private(shared) else _fresh_parent(os.getpid())


def _folder(name):
    """Where an archive of this name is unpacked on this machine."""
    return os.path.join(_parent(), name)


def _unpack(name, archive):
    """Puts a scene in its folder, unless it is there: whole or not at all, however many do so at once."""
    folder = _folder(name)
    if os.path.isdir(folder):
        return
    unfinished = tempfile.mkdtemp(dir=os.path.dirname(folder))
    with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
        tar.extractall(unfinished, filter="data")
    try:
        os.rename(unfinished, folder)
    except OSError:
        shutil.rmtree(unfinished)
        if not os.path.isdir(folder):
            raise


def _plugin(job):
    """What brings the scene to each worker, those included that come later."""
    from distributed import WorkerPlugin

    class Scene(WorkerPlugin):
        name = f"gnurt-{job.name}"

        def __init__(self):
            self.archive = (job.name, job.archive)

        def setup(self, worker):
            from gnurt.cluster import _unpack

            _unpack(*self.archive)

    return Scene()


def _render_piece(name, program, words, frame, piece, pieces):
    """On a worker: the bytes of a piece's file."""
    with tempfile.TemporaryDirectory(prefix="gnurt-") as folder:
        file = os.path.join(folder, "p.exr")
        more = ["--piece", f"{piece}/{pieces}"]
        if frame is not None:
            more += ["--frames", f"{frame}..{frame}"]
            file = os.path.join(folder, "p.####.exr")
        _run([*_program(program), *words, *more, "-o", file], cwd=_folder(name))
        (found,) = os.listdir(folder)
        with open(os.path.join(folder, found), "rb") as rendered:
            return rendered.read()


def _program(path):
    """How the program is called on this machine."""
    return [sys.executable, "-m", "gnurt"] if path is None else [path]


def _run(words, cwd=None):
    program = words[0]
    if sys.platform == "linux":
        # A worker that is killed takes its program with it. An interpreter of its own asks for that and becomes the program: code of
        # ours cannot run between fork and exec of a process with threads.
        words = [sys.executable, "-I", "-S", "-c", _DYING_WITH_PARENT, str(os.getpid()), *words]
    done = subprocess.run(words, cwd=cwd, capture_output=True, text=True)
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
        raise RuntimeError(said[0] if said else f"{program} ended with {done.returncode}: {done.stderr.strip()}")


#: PR_SET_PDEATHSIG is 1. A parent that is gone before that sends nothing any more.
_DYING_WITH_PARENT = """
import ctypes, os, signal, sys
ctypes.CDLL(None).prctl(1, signal.SIGKILL)
if os.getppid() != int(sys.argv[1]):
    sys.exit("the worker is gone")
try:
    os.execvp(sys.argv[2], sys.argv[2:])
except OSError as error:
    sys.exit(f"error: {sys.argv[2]}: {error.strerror}")
"""


def _frames(text):
    first, _, last = text.partition("..")
    return int(first), int(last or first)


def _parsed(words):
    parser = argparse.ArgumentParser(
        prog="python -m gnurt.cluster",
        allow_abbrev=False,
        description="Renders a picture, or the frames of an animation, in pieces on the workers of a Dask cluster.",
        epilog="All other options are those of `gnurt render`.",
    )
    parser.add_argument("scene", help="scene file, or builtin:NAME")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--dask", metavar="ADDRESS", help="the cluster's scheduler, such as tcp://10.0.0.1:8786")
    where.add_argument("--local", metavar="N", type=int, help="N worker processes on this machine")
    parser.add_argument("-o", "--output", required=True, help="picture to write; frame.####.png for frames")
    parser.add_argument("--pieces", metavar="N", type=int, default=16, help="pieces of each frame [default: 16]")
    parser.add_argument("--frames", metavar="FIRST..LAST", type=_frames, help="frames, both ends included")
    parser.add_argument("--gnurt", metavar="PROGRAM", help="the program, here and there [default: this package's]")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress")
    for option in ("--denoise", "--tone", "--exposure"):
        parser.add_argument(option, nargs="?", const="", help="as of `gnurt join`")
    return parser, *parser.parse_known_args(words)


def main(words=None):
    """The command."""
    parser, known, options = _parsed(words)
    try:
        import distributed
    except ImportError:
        parser.error("Dask is missing; pip install 'gnurt[cluster]'")
    if known.gnurt is not None and shutil.which(known.gnurt) is None:
        parser.error(f"--gnurt: there is no program {known.gnurt}; give its path")
    look = [
        f"--{name}={value}" if value else f"--{name}"
        for name in ("denoise", "tone", "exposure")
        if (value := getattr(known, name)) is not None
    ]
    threads = None
    try:
        job = Job(known.scene, known.output, options, look, known.pieces, known.frames, known.gnurt)
        if known.local is not None:
            threads = max(1, (os.cpu_count() or 1) // max(known.local, 1))
            cluster = distributed.LocalCluster(
                n_workers=known.local, threads_per_worker=1, dashboard_address=None, silence_logs=logging.CRITICAL
            )
            # Workers that died while they started are replaced, too.
            cluster.adapt(minimum=known.local, maximum=known.local)
        else:
            cluster = known.dask
        with distributed.Client(cluster) as client:
            for output in render(job, client, None if known.quiet else _tell, threads):
                if not known.quiet:
                    print(f"wrote {output}", file=sys.stderr)
        if known.local is not None:
            cluster.close()
    except (RuntimeError, ValueError, OSError) as error:
        print(f"error: {str(error).removeprefix('error: ')}", file=sys.stderr)
        return 1
    return 0


def _tell(done, count):
    end = "\n" if done == count else ""
    print(f"\r{done} of {count} pieces", end=end, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
