"""Workers on a real Slurm cluster: an array leases jobs, drains, and is queued again before its time limit."""
import os
import pathlib
import unittest

import hostile
from harness import BIN, Case, Server, curl, wait_for
from slurm import Slurm

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "slurm" / "workers.sbatch"
COARSE = {"sheet": {"resolution_mm": 6}, "print": {"dpi": 72}}
SLOW = {"sheet": {"resolution_mm": 1.5}, "print": {"dpi": 72}}


class OnSlurm(Case):
    def setUp(self):
        self.scan, self.pattern = self.folder / "a.stl", self.folder / "p.svg"
        self.scan.write_bytes(hostile.stl(hostile.dome_triangles()))
        self.pattern.write_bytes(hostile.GOOD_SVG)

    def start_workers(self, cluster, server, count):
        """The id of an array of so many workers, all of which run."""
        array = cluster.answer("sbatch", "--parsable", f"--array=1-{count}", "--cpus-per-task=1", "--mem=100", f"--output={cluster.folder}/%A-%a.out",
                               SCRIPT, VACUFORM_WORKER=str(BIN / "vacuform-worker"), VACUFORM_WORKER_SERVER=server.url,
                               VACUFORM_WORKER_SANDBOX="best-effort", VACUFORM_TOKEN_FILE=str(server.data / "worker-token"))
        self.assertRegex(array, r"^[0-9]+$")
        wait_for(lambda: list(cluster.states(array).values()) == ["RUNNING"] * count, "the workers")
        return array

    def busy(self, server):
        """Names of the workers that hold a job."""
        return [w["worker"] for w in curl(server.api + "/service").json["workers"] if w["job"]]

    def test_an_array_of_workers_drains_and_is_queued_again(self):
        cores = min(2, os.cpu_count())
        with Server(self.folder, workers=0) as server, Slurm() as cluster:
            array = self.start_workers(cluster, server, cores)
            jobs = [server.submit(self.scan, self.pattern, COARSE) for _ in range(4)]
            self.assertEqual({server.wait(job)["state"] for job in jobs}, {"succeeded"})
            members = set(cluster.states(array))
            self.assertEqual({w["worker"].rsplit("-", 1)[1] for w in curl(server.api + "/service").json["workers"]}, members)

            # Its time is nearly up: the running job ends, and the worker is queued again with what it has.
            job = server.submit(self.scan, self.pattern, SLOW)
            (name,) = wait_for(lambda: self.busy(server), "a worker with the job")
            member = name.rsplit("-", 1)[1]
            cluster.answer("scancel", "--batch", "--signal=USR1", member)
            self.assertEqual(server.wait(job)["state"], "succeeded")
            self.assertEqual(server.job(job)["attempt"], 1)
            wait_for(lambda: "Restarts=1" in cluster.answer("scontrol", "show", "job", member), "the worker in the queue again")

            # Asked to end, the others drain and are not queued again.
            for other in members - {member}:
                cluster.answer("scancel", "--batch", "--signal=TERM", other)
                wait_for(lambda other=other: "JobState=COMPLETED" in cluster.answer("scontrol", "show", "job", other), "the worker's end")


if __name__ == "__main__":
    unittest.main()
