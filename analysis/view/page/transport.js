// The time line with its buttons and keys.
import { isBad } from "./events.js";
import { SPEEDS } from "./playhead.js";

export class Transport {
  constructor(run, playhead, marks, theme, actions) {
    Object.assign(this, { run, playhead, marks, theme, actions });
    const get = (id) => document.getElementById(id);
    this.play = get("play");
    this.live = get("live");
    this.scrubber = get("scrubber");
    this.time = get("time");
    this.speed = get("speed");
    this.speed.append(...SPEEDS.map((speed) => new Option(`${speed} ×`, speed)));
    this.play.addEventListener("click", () => this.toggle());
    this.live.addEventListener("click", () => this.follow());
    get("start").addEventListener("click", () => this.seek(0));
    get("back").addEventListener("click", () => this.#by(-run.about.period));
    get("on").addEventListener("click", () => this.#by(run.about.period));
    this.scrubber.addEventListener("input", () => this.seek(Number(this.scrubber.value) * run.about.period));
    this.speed.addEventListener("change", () => {
      playhead.speed = Number(this.speed.value);
      playhead.following = false;
    });
    addEventListener("keydown", (event) => this.#key(event));
    giveFocusBack();
  }

  toggle() {
    const { playhead } = this;
    if (playhead.following || playhead.playing) {
      playhead.playing = playhead.following = false;
      return;
    }
    if (!this.run.live && playhead.time >= playhead.end - 1e-9) playhead.time = 0;
    playhead.playing = true;
  }

  follow() {
    if (!this.run.live) return;
    this.playhead.following = !this.playhead.following;
    this.playhead.playing = this.playhead.following;
  }

  seek(time) {
    this.playhead.seek(time);
  }

  #by(seconds) {
    this.playhead.playing = false;
    this.seek(this.playhead.time + seconds);
  }

  draw() {
    const { run, playhead } = this;
    const moves = playhead.playing || playhead.following;
    this.play.classList.toggle("moves", moves);
    attribute(this.play, "aria-label", moves ? "Pause (Space)" : "Play (Space)");
    this.live.hidden = !run.live;
    attribute(this.live, "aria-pressed", String(playhead.following));
    const period = run.about.period;
    const cycle = Math.round(playhead.time / period);
    set(this.scrubber, "max", String(run.live ? Math.max(run.last, 1) : run.last));
    set(this.scrubber, "value", String(cycle));
    const of = run.live ? run.duration : run.lastTime;
    const text = `${playhead.time.toFixed(1)} / ${of.toFixed(1)} s`;
    set(this.time, "textContent", text);
    attribute(this.scrubber, "aria-valuetext", text);
    set(this.speed, "value", String(playhead.speed));
    this.#marks();
  }

  #marks() {
    const { run, marks, theme } = this;
    const g = marks.begin();
    const end = run.lastTime || 1;
    const room = 0.55 * marks.em; // half of the scrubber's thumb
    for (const event of run.events) {
      g.fillStyle = isBad(event) ? theme.lost : theme.quiet;
      const x = room + (event.time / end) * (marks.width - 2 * room);
      g.fillRect(x - 1, 0, 2, marks.height);
    }
  }

  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector("dialog[open]")) return;
    const { target, key } = event;
    const slides = target.matches?.("input[type=range]");
    const scrubs = target.id === "scrubber";
    if (target.matches?.("select, textarea, input:not([type=range])")) return;
    if (key === " " && target.matches?.("button, a")) return;
    if (slides && !scrubs && /^(Arrow|Page|Home$|End$)/.test(key)) return;
    const keys = {
      " ": () => this.toggle(),
      ArrowLeft: () => this.#by(event.shiftKey ? -10 : -1),
      ArrowRight: () => this.#by(event.shiftKey ? 10 : 1),
      ",": () => this.#by(-this.run.about.period),
      ".": () => this.#by(this.run.about.period),
      Home: () => this.seek(0),
      End: () => this.seek(this.playhead.end),
      "+": () => this.#faster(1),
      "=": () => this.#faster(1),
      "-": () => this.#faster(-1),
      l: () => this.follow(),
      ...this.actions,
    };
    const act = keys[key] ?? keys[key.toLowerCase()];
    const list = target.closest?.("#events");
    if (!act || (list && ["Home", "End", " "].includes(key)) || (scrubs && key.startsWith("Page"))) return;
    event.preventDefault();
    act();
  }

  #faster(by) {
    this.playhead.following = false;
    this.playhead.faster(by);
  }
}

// Whoever clicks with a mouse wants a key to do afterwards what it did before, so what was clicked does not
// keep the focus. A control that was reached with the keyboard keeps it.
function giveFocusBack() {
  let byMouse = false;
  addEventListener("pointerdown", () => (byMouse = true), true);
  addEventListener("keydown", () => (byMouse = false), true);
  const release = ({ target }) => {
    if (byMouse && !target.matches?.("input[type=number]")) target.closest?.("button, select, input, #events")?.blur();
  };
  // Before the click acts, because a dialog gives the focus back to what had it when the dialog opened.
  addEventListener("click", (event) => event.target.closest?.("button, #events") && release(event), true);
  addEventListener("change", release);
}

// Sets a property only if it changes, which spares the browser work.
function set(element, name, value) {
  if (element[name] !== value) element[name] = value;
}

function attribute(element, name, value) {
  if (element.getAttribute(name) !== value) element.setAttribute(name, value);
}
