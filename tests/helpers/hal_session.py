"""HAL without hardware: components installed for a test, and halrun sessions that end."""

import fcntl
import os
import shutil
import signal
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from hfc_design.formats import FORMATS, connecting

MODULES = Path("/usr/lib/linuxcnc/modules")
REALTIME = "/usr/lib/linuxcnc/realtime"
NOBODY = 65534


class Unusable(Exception):
    """There is something here that no test may touch, or something is missing."""


class Session:
    """Where components come from and how halrun is called."""

    def __init__(self, environment):
        # A make above this one would have halcompile's make say where it is.
        own = {key: value for key, value in os.environ.items() if not key.startswith("MAKE")}
        self.environment = own | environment
        self.before = {}  # module -> what stood there, to be put back

    def call(self, *command, cwd, timeout=60):
        """Run a command in a process group that is ended after ``timeout`` [s]."""
        with subprocess.Popen(
            command,
            cwd=cwd,
            env=self.environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        ) as process:
            try:
                out, err = process.communicate(timeout=timeout)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                raise
        assert process.returncode == 0, out + err
        return out

    def install(self, folder):
        """Compile every component of ``folder`` and put it where LinuxCNC looks for it."""
        for source in sorted(folder.glob("*.comp")):
            self.about_to_install(source.stem)
            self.call("halcompile", "--compile", source.name, cwd=folder)
            shutil.copy(folder / f"{source.stem}.so", MODULES)

    def about_to_install(self, component):
        module = MODULES / f"{component}.so"
        self.before.setdefault(module, module.read_bytes() if module.exists() else None)

    def run(self, folder, file, timeout=60):
        """What ``file`` prints; HAL is taken down whatever happens."""
        try:
            return self.call("halrun", file, cwd=folder, timeout=timeout)
        except BaseException:
            down = ["halrun", "-U"]
            subprocess.run(down, env=self.environment, capture_output=True, timeout=60, check=False)
            raise

    def put_back(self):
        for module, content in self.before.items():
            module.unlink(missing_ok=True)
            if content is not None:
                module.write_bytes(content)


@contextmanager
def session():
    """One session at a time on this machine, and none beside a HAL that runs already."""
    if not os.access(MODULES, os.W_OK):
        raise Unusable(f"{MODULES} cannot be written, components are installed there as root")
    with open(Path(tempfile.gettempdir()) / "hfc-design-hal.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if subprocess.run([REALTIME, "status"], capture_output=True, check=False).returncode == 0:
            raise Unusable("HAL runs already on this machine")
        with tempfile.TemporaryDirectory() as folder:
            os.chown(folder, NOBODY, -1)
            found = Session({"RTAPI_UID": str(NOBODY), "RTAPI_FIFO_PATH": f"{folder}/fifo"})
            try:
                yield found
            finally:
                found.put_back()


def write_rows(path, kinds, columns):
    """Columns (n,) as halstreamer reads them, one of "f" a number and one of "b" a bit."""
    texts = [
        [repr(float(x)) if kind == "f" else str(int(x)) for x in column]
        for kind, column in zip(kinds, columns, strict=True)
    ]
    path.write_text("".join(" ".join(row) + "\n" for row in zip(*texts, strict=True)))


OPEN_LOOP = """
loadrt threads name1=servo-thread period1={period}
loadrt streamer depth=4000 cfg={kinds}
loadrt sampler depth=4000 cfg=ffb
addf streamer.0 servo-thread
source controller.hal
addf sampler.0 servo-thread
{nets}
net error => sampler.0.pin.0
net command => sampler.0.pin.1
net fault controller.fault => sampler.0.pin.2
loadusr -w halstreamer in.txt
start
loadusr -w halsampler -n {count} out.txt
{after}
"""


def open_loop(hal, folder, period, pins, *extra, kinds=None, after=""):
    """(n, 3) error, command, fault for the samples in ``pins``: pin -> (n,).

    ``after`` is done when they are over.
    """
    kinds = kinds or "f" * len(pins)
    write_rows(folder / "in.txt", kinds, pins.values())
    extra = extra if "enable" in pins else (*extra, "sets enable 1")
    nets = [f"net {pin} streamer.0.pin.{k} => controller.{pin}" for k, pin in enumerate(pins)]
    count = len(next(iter(pins.values())))
    text = OPEN_LOOP.format(
        period=period,
        kinds=kinds,
        nets="\n".join([*nets, *extra]),
        count=count,
        after=after,
    )
    (folder / "open.hal").write_text(text)
    hal.run(folder, "open.hal")
    return np.loadtxt(folder / "out.txt", ndmin=2)


def with_controller(design, **changes):
    return design.model_copy(update={"controller": design.controller.model_copy(update=changes)})


def exported(hal, design, folder, bare=True):
    """The folder with the component of a design, which ``hal`` has built."""
    FORMATS["linuxcnc"].write(design, folder, connecting(FORMATS["linuxcnc"], bare))
    hal.install(folder)
    return folder
