"""A Slurm cluster of this one machine, from Debian's packages, for one test: munged, slurmctld and slurmd on loopback."""
import os
import pathlib
import pwd
import shutil
import subprocess
import tempfile

from harness import free_port, wait_for

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel")


class Slurm:
    def __init__(self):
        for program in PROGRAMS:
            assert shutil.which(program, path="/usr/sbin:/usr/bin"), f"{program} is not installed; deploy/packages --tests installs it"
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="vacuform-slurm-"))
        self.processes = []
        self.environment = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf"), "PATH": "/usr/sbin:" + os.environ["PATH"]}

    def __enter__(self):
        user = pwd.getpwuid(os.geteuid()).pw_name
        (self.folder / "munge.key").write_bytes(os.urandom(1024))
        (self.folder / "munge.key").chmod(0o400)
        self.folder.chmod(0o755)  # munged wants the folder of its socket open
        for name in "state", "spool":
            (self.folder / name).mkdir()
        first = free_port(2)
        cores = os.cpu_count()
        (self.folder / "slurm.conf").write_text(f"""
ClusterName=test
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={first}
SlurmdPort={first + 1}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={self.folder}/munge.socket
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/spool
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SwitchType=switch/none
MpiDefault=none
SchedulerParameters=batch_sched_delay=1
ReturnToService=2
NodeName=localhost NodeAddr=127.0.0.1 CPUs={cores} RealMemory=8000
PartitionName=main Nodes=localhost Default=YES MaxTime=INFINITE State=UP
""")
        self.run_beside("munged", "--foreground", "--force", f"--key-file={self.folder}/munge.key", f"--socket={self.folder}/munge.socket",
                        f"--pid-file={self.folder}/munged.pid", f"--log-file={self.folder}/munged.log",
                        f"--seed-file={self.folder}/munged.seed")
        wait_for((self.folder / "munge.socket").exists, "munged")
        self.run_beside("slurmctld", "-D")
        self.run_beside("slurmd", "-D", "-N", "localhost")
        wait_for(self.is_idle, "an idle machine")
        return self

    def is_idle(self):
        for process in self.processes:
            assert process.poll() is None, (self.folder / (process.args[0] + ".out")).read_text(errors="replace")[-2000:]
        return "idle" in self.answer("sinfo", "--noheader", "--format=%t")

    def __exit__(self, *_):
        self.answer("scancel", "--user", pwd.getpwuid(os.geteuid()).pw_name)
        self.answer("scancel", "--full", "--signal=KILL", "--user", pwd.getpwuid(os.geteuid()).pw_name)
        for process in reversed(self.processes):
            process.terminate()
            process.wait(timeout=60)
        shutil.rmtree(self.folder)

    def run_beside(self, program, *words):
        with open(self.folder / (program + ".out"), "wb") as out:
            self.processes.append(subprocess.Popen([program, *words], env=self.environment, cwd=self.folder, stdin=subprocess.DEVNULL,
                                                   stdout=out, stderr=out))

    def answer(self, *words, **more):
        """What a command of Slurm prints."""
        done = subprocess.run([str(w) for w in words], capture_output=True, text=True, env={**self.environment, **more}, cwd=self.folder)
        return done.stdout.strip()

    def states(self, job):
        """The members of an array that are still known, as {id: state} in Slurm's words."""
        lines = self.answer("squeue", "--noheader", "--array", "--jobs", job, "--states=all", "--format=%F_%K %T").splitlines()
        return dict(line.split() for line in lines)
