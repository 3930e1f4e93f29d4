"""A Slurm of one node, with accounting, in a folder of its own: for Debian.

Five daemons: munged, mariadbd, slurmdbd, slurmctld, slurmd. They belong to whoever starts them, lie
in one folder and listen on ports that were free; those of the machine, if it has any, go on.
"""

import getpass
import os
import secrets
import shutil
import socket
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Self

import psutil

PACKAGES = ("slurmctld", "slurmd", "slurmdbd", "slurm-client", "munge", "mariadb-server-core")
PROGRAMS = ("slurmctld", "slurmd", "slurmdbd", "sbatch", "munged", "mariadbd")

#: Where daemons are that the path of a user leaves out.
PATH = f"{os.environ['PATH']}:/usr/sbin:/sbin"

#: Names of the cluster, of the account that its user has, and of the partition for jobs of any
#: length. The default partition takes none that may last longer than a minute.
NAME, ACCOUNT, PARTITION = "talus", "granular", "day"

#: What Debian's packages hold to make the tables that a database needs for stored procedures.
TABLES = Path("/usr/share/mysql/mysql_system_tables.sql")

#: Last characters of what a daemon has said, for an error.
SAID = 2000


def lacking() -> str:
    """Return why this machine cannot have the cluster; nothing if it has or can install it."""
    if all(shutil.which(program, path=PATH) for program in PROGRAMS):
        return ""
    if not shutil.which("apt-get"):
        return f"no Slurm, and no apt-get to install {' '.join(PACKAGES)}"
    if os.geteuid() != 0:
        return f"no Slurm; as root, or after: apt-get install {' '.join(PACKAGES)}"
    return ""


def install() -> None:
    """Install what is lacking, as root; services of the packages are not started."""
    if all(shutil.which(program, path=PATH) for program in PROGRAMS):
        return
    policy = Path("/usr/sbin/policy-rc.d")
    made = not policy.exists()
    if made:
        policy.write_text("#!/bin/sh\nexit 101\n")
        policy.chmod(0o755)
    environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    try:
        for words in (["update"], ["install", "-y", "--no-install-recommends", *PACKAGES]):
            subprocess.run(["apt-get", "-qq", *words], check=True, env=environment)
    finally:
        if made:
            policy.unlink()


class Cluster:
    """The cluster, as a context: started on entry, and nothing left of it on exit.

    Parameters
    ----------
    folder : Path
        An empty folder for configuration, state and logs.

    Attributes
    ----------
    environment : dict
        What Slurm's commands need in their environment to find it.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self.environment = os.environ | {
            "PATH": f"{folder / 'bin'}:{PATH}",
            "SLURM_CONF": str(folder / "slurm.conf"),
            "MYSQL_UNIX_PORT": str(folder / "database.socket"),
        }
        self._daemons: list[subprocess.Popen] = []

    def __enter__(self) -> Self:
        try:
            self._configure()
            self._start_accounting()
            self._start_slurm()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def ask(self, *words: str) -> str:
        """Run a command of Slurm and return what it printed."""
        return self._call(*words, check=True).stdout

    def stop(self) -> None:
        """End the jobs, the daemons, and whatever else lives on in the cluster."""
        self._call("scancel", f"--user={getpass.getuser()}")
        # The process that looks after a job outlives the daemons.
        while self._call("squeue", "-h").stdout:
            time.sleep(0.5)
        for daemon in reversed(self._daemons):
            daemon.terminate()
            daemon.wait()
        for process in psutil.process_iter():
            with suppress(psutil.NoSuchProcess, psutil.AccessDenied):
                if process.environ().get("SLURM_CONF") == self.environment["SLURM_CONF"]:
                    process.kill()

    def _call(self, *words: str, **options) -> subprocess.CompletedProcess:
        options = {"capture_output": True, "text": True, "env": self.environment} | options
        return subprocess.run(words, **options)

    def _configure(self) -> None:
        """Write both configurations, and the key of munge."""
        for name in ("state", "spool", "database", "bin"):
            (self.folder / name).mkdir()
        # A job of the executor plugin loses SLURM_CONF before it calls this.
        srun = self.folder / "bin" / "srun"
        conf = self.environment["SLURM_CONF"]
        srun.write_text(f'#!/bin/sh\nSLURM_CONF={conf} exec {shutil.which("srun")} "$@"\n')
        srun.chmod(0o755)
        ports = _free_ports(3)
        fields = {
            "cluster": NAME,
            "partition": PARTITION,
            "folder": self.folder,
            "user": getpass.getuser(),
            "host": socket.gethostname().partition(".")[0],
            "cpus": max(2, os.cpu_count() or 1),
            "memory": psutil.virtual_memory().total // 2**21,
            **dict(zip(("controller_port", "node_port", "accounting_port"), ports, strict=True)),
        }
        for name in ("slurm.conf", "slurmdbd.conf"):
            template = Path(__file__).with_name(name).read_text(encoding="utf-8")
            (self.folder / name).write_text(template.format_map(fields), encoding="utf-8")
        (self.folder / "slurmdbd.conf").chmod(0o600)
        key = self.folder / "munge.key"
        key.write_bytes(secrets.token_bytes(64))
        key.chmod(0o400)

    def _start_accounting(self) -> None:
        files = {name: self.folder / f"munge.{name}" for name in ("socket", "key", "log", "pid")}
        self._start(
            files["socket"].exists,
            *("munged", "--foreground", "--force", f"--socket={files['socket']}"),
            *(f"--{name}-file={files[name]}" for name in ("key", "log", "pid")),
            f"--seed-file={self.folder / 'munge.seed'}",
        )
        database = self.folder / "database"
        common = (f"--datadir={database}", f"--user={getpass.getuser()}", "--skip-grant-tables")
        tables = f"create database mysql;\nuse mysql;\n{TABLES.read_text(encoding='utf-8')}"
        bootstrap = ("mariadbd", "--no-defaults", *common, "--bootstrap")
        self._call(*bootstrap, input=tables, check=True)
        # Who may open the folder of the socket may do all; nobody else gets at it.
        self._start(
            Path(self.environment["MYSQL_UNIX_PORT"]).exists,
            *("mariadbd", "--no-defaults", *common, "--skip-networking"),
            *(f"--socket={self.environment['MYSQL_UNIX_PORT']}", f"--pid-file={database}.pid"),
        )
        self._start(lambda: self._answers("sacctmgr", "-n", "list", "cluster"), "slurmdbd", "-D")
        user = f"user {getpass.getuser()} account={ACCOUNT}"
        for what in (f"cluster {NAME}", f"account {ACCOUNT}", user):
            self.ask("sacctmgr", "-i", "add", *what.split())

    def _start_slurm(self) -> None:
        self._start(lambda: self._answers("scontrol", "show", "partition"), "slurmctld", "-D")
        self._start(lambda: "idle" in self._call("sinfo", "-h", "-o", "%T").stdout, "slurmd", "-D")

    def _answers(self, *words: str) -> bool:
        return self._call(*words).returncode == 0

    def _start(self, ready: Callable[[], bool], *words: str) -> None:
        """Start a daemon and wait until it is ready; `RuntimeError` if it ends instead."""
        said = self.folder / f"{words[0]}.out"
        with said.open("w") as output:
            # A Ctrl-C is for whoever uses the cluster, not for its daemons.
            daemon = subprocess.Popen(
                words, env=self.environment, stdout=output, stderr=output, start_new_session=True
            )
        self._daemons.append(daemon)
        while not ready():
            if daemon.poll() is not None:
                raise RuntimeError(f"{words[0]} has ended: {said.read_text()[-SAID:]}")
            time.sleep(0.1)


def _free_ports(count: int) -> list[int]:
    """Return ports on which nobody listens."""
    sockets = [socket.socket() for _ in range(count)]
    try:
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]
    finally:
        for one in sockets:
            one.close()
