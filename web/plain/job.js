// Updates the page of the job from its events. Without scripts the page reloads at intervals instead.
"use strict";

const progress = document.querySelector("progress[data-events]");
if (progress) {
  const text = document.getElementById("progress-text");
  const events = new EventSource(progress.dataset.events);
  events.addEventListener("job", (event) => {
    const job = JSON.parse(event.data);
    if (["succeeded", "failed", "cancelled"].includes(job.state)) {
      events.close();
      location.reload(); // the server knows how the rest looks
      return;
    }
    const percent = Math.floor(100 * job.progress);
    progress.value = percent;
    const running = job.stage ? `Stage: ${job.stage}.` : "A worker has taken the job.";
    const doing = { queued: "Waiting for a worker.", cancelling: "The worker is told to stop." }[job.state] ?? running;
    text.textContent = `${doing}${job.attempt > 1 ? ` Attempt ${job.attempt}.` : ""} ${percent} % done. This page updates automatically.`;
  });
  events.addEventListener("error", () => {
    // Closed: refused, for example because too many clients listen already. Otherwise the browser reconnects
    // automatically.
    if (events.readyState === EventSource.CLOSED) setTimeout(() => location.reload(), 5000);
  });
}
