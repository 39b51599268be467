// Where the page is in the run: a time that runs on by itself, or follows a run that goes on.
export const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const LAG = 0.6; // wall time behind the newest cycle when following: the log grows in steps of 0.35 s

export class Playhead {
  constructor() {
    this.time = 0;
    this.end = 0;
    this.playing = false;
    this.following = false;
    this.speed = 1;
    this.pace = 1; // simulated over wall time of a run that is followed
    this.seen = null;
    this.resumes = false; // whether to follow again, if the run goes on
  }

  // Notes that at this wall time (s) the run has come to this time.
  reach(wall, end) {
    if (this.seen && end > this.end) {
      const pace = (end - this.end) / Math.max(0.05, wall - this.seen);
      this.pace += Math.min(1, 0.35 * (wall - this.seen) / 0.35) * 0.3 * (pace - this.pace);
    }
    if (end > this.end || !this.seen) this.seen = wall;
    this.end = end;
  }

  // Moves on by some wall time. `isThere` says whether the page can show a time.
  advance(elapsed, isThere) {
    if (this.following) {
      const target = this.end - this.pace * LAG;
      const off = target - this.time;
      const jump = Math.abs(off) > Math.max(2, 3 * this.pace);
      this.time = jump ? Math.max(0, target) : this.time + Math.max(0, this.pace * elapsed + off * Math.min(1, elapsed));
      this.time = Math.min(this.time, this.end);
    } else if (this.playing) {
      const next = Math.min(this.end, this.time + this.speed * elapsed);
      if (isThere(next)) this.time = next;
    }
  }

  // Stops following a run that has ended or stands still, and follows on when it goes on. `goesOn`:
  // the run has not ended; `live`: its log grows, too.
  attend(live, goesOn) {
    if (live && this.resumes) this.following = this.playing = true;
    if (live) this.resumes = false;
    if (live || !this.following) return;
    this.resumes = goesOn;
    this.following = false;
    this.playing = this.time < this.end;
  }

  seek(time) {
    this.resumes = false;
    this.following = false;
    this.time = Math.max(0, Math.min(this.end, time));
  }

  faster(by) {
    const at = SPEEDS.findIndex((speed) => speed >= this.speed);
    this.speed = SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, at + by))];
  }
}
