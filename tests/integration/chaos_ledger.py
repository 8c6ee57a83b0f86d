"""Records what a service under chaos accepted and what was seen of it, and checks it against the promises. Reads only
the API."""
import hashlib
import json
import threading

from harness import PATIENCE, wait_for

ENDED = ("succeeded", "failed", "cancelled")
ENDINGS = ("succeeded", "cancelled", "refused", "crashed twice", "lost ten times")  # the categories of the figures
# The message in the log of a job for each retry.
CRASHED = "its process crashed, queued again"
LOST = ("its worker was lost, queued again", "its worker had an internal fault, queued again")


class Ledger:
    """Can be used from any thread. Raises AssertionError for a broken promise."""

    def __init__(self):
        self.wishes, self.ends, self.versions, self.attempts = {}, {}, {}, {}  # by the job's id
        self.lock = threading.Lock()

    def accept(self, job, wish):
        with self.lock:
            assert job not in self.wishes, f"two submissions have one job, {job}"
            self.wishes[job] = wish

    def see(self, api, job):
        """Whether the job has ended; False if the service does not answer. An end that was seen once must not change."""
        found = api.job(job)
        if not found:
            return False
        end = None
        if found["state"] in ENDED:
            end = (found["state"], found["ended"], tuple((a["name"], a["sha256"]) for a in found["artifacts"]))
        with self.lock:
            seen = self.ends.get(job)
            assert seen is None or seen == end, f"{job} had ended as {seen} and is {end or found['state']} now"
            assert found["version"] >= self.versions.get(job, 0), f"{job} went back in time"
            self.versions[job], self.attempts[job] = found["version"], found["attempt"]
            if end:
                self.ends[job] = end
        return end is not None

    def check(self, api):
        """Waits until all jobs have ended, then compares the promises with the API. Returns the figures."""
        jobs = list(self.wishes)
        wait_for(lambda: all([self.see(api, job) for job in jobs if job not in self.ends]), "the end of all jobs",
                 patience=PATIENCE + 5 * len(jobs), pause=0.5)
        listed = api.jobs()
        lost, made, twice = set(jobs) - set(listed), set(listed) - set(jobs), len(listed) - len(set(listed))
        assert not lost and not made and not twice, f"{len(lost)} jobs were lost, {len(made)} made of nothing, {twice} are listed twice"
        sort = {job: self.sort_of(api, job) for job in jobs}
        for job in jobs:
            self.see(api, job)
            again = self.wishes[job].submit(api)
            assert again == job, f"the key of {job} gives {again} now"
        self.check_results(api, [job for job in jobs if sort[job] == "succeeded"])
        figures = {"accepted": len(jobs), "lost": 0, "twice": 0}
        figures.update({name: list(sort.values()).count(name) for name in ENDINGS})
        figures.update({"attempts": sum(self.attempts.values()), "most attempts of one": max(self.attempts.values())})
        return figures

    def sort_of(self, api, job):
        """How the job ended; it must be one of the expected ends."""
        wish, (state, _, artifacts) = self.wishes[job], self.ends[job]
        names = [name for name, _ in artifacts]
        if state == "succeeded":
            assert wish.may("succeed") and set(names) >= wish.artifacts and len(names) == len(set(names)), (wish, job, names)
            return "succeeded"
        assert names == [], f"{job} is {state} and has {names}"
        if state == "cancelled":
            assert wish.may("be cancelled"), (wish, job)
            return "cancelled"
        problem = api.job(job)["problem"]
        if problem["type"] == "/problems/unusable-scan":
            assert wish.may("be refused"), (wish, job, problem)
            return "refused"
        # Everything else was killed from outside. Of these kills only the second death of the job's own process may end
        # it, or the tenth of a worker that ran it.
        log = [line["text"] for line in api.log(job)]
        crashed, lost = log.count(CRASHED) == 1, sum(map(log.count, LOST)) == 9
        assert problem["type"] == "/problems/internal" and (crashed or lost) or problem["type"] == "/problems/out-of-time" and crashed, (
            f"{job} failed without a fault of its own: {json.dumps(problem)}, {log}")
        return "lost ten times" if "workers were lost" in problem["what"] else "crashed twice"

    def check_results(self, api, jobs):
        """One request has one result, however often it was interrupted; and the bytes are those that the job names."""
        first = {}
        for job in jobs:
            results = self.ends[job][2]
            of = first.setdefault(self.wishes[job].same, (job, results))
            differ = [a[0] for a, b in zip(results, of[1]) if a != b]
            assert results == of[1], f"{job} and {of[0]} were asked for the same and differ in {differ}"
        for job in jobs[::10]:
            for name, digest in self.ends[job][2]:
                status, body = api.ask("GET", f"/api/v1/jobs/{job}/artifacts/{name}")
                assert status == 200 and hashlib.sha256(body).hexdigest() == digest, (job, name, status)
