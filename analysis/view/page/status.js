// Whether the run goes on, and what is wrong, in words.
import { failure } from "./server.js";

const REFUSED = 10_000; // ms
const STILL = "The log has no end, and does not grow: it is cut, or its run stands still.";

export class Status {
  constructor(run) {
    this.run = run;
    this.refused = "";
    this.badge = document.getElementById("badge");
    this.line = document.getElementById("trouble");
  }

  // Shows for a while why the server refuses an act.
  refuse(text) {
    this.refused = text;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => (this.refused = ""), REFUSED);
  }

  show() {
    const { run } = this;
    const text = run.faults[0] || failure() || this.refused || (run.begun && run.still ? STILL : "");
    if (this.line.textContent !== text) {
      this.line.textContent = text;
      this.line.hidden = !text;
    }
    if (!run.begun) return;
    const said = run.live ? "live" : run.end ?? "unfinished";
    if (this.badge.textContent === said) return;
    this.badge.textContent = said;
    this.badge.className = `badge ${run.live ? "live" : said === "complete" ? "" : "bad"}`;
  }
}
