// Gap and speed of each chosen vehicle: truth, estimate and reading.
import { Surface } from "./canvas.js";
import { chart } from "./chart.js";
import { Pictures } from "./run.js";

const WINDOW = 20; // s
const AHEAD = 0.12; // share of the window that lies after the time shown

export class Charts {
  constructor(run, place, theme, { remove, seek }) {
    Object.assign(this, { run, place, theme, remove, seek });
    this.rows = [];
    this.near = null;
  }

  choose(chosen) {
    this.near = new Pictures(this.run, chosen);
    this.place.replaceChildren();
    this.rows = chosen.map((vehicle, index) => {
      const figure = document.createElement("figure");
      const caption = document.createElement("figcaption");
      const name = document.createElement("span");
      name.textContent = vehicle;
      caption.append(name);
      if (chosen.length > 1) {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = "×";
        button.setAttribute("aria-label", `Remove vehicle ${vehicle}`);
        button.addEventListener("click", () => this.remove(vehicle));
        caption.append(button);
      }
      figure.append(caption);
      const surfaces = ["gap", "speed"].map((what) => {
        const canvas = document.createElement("canvas");
        canvas.setAttribute("role", "img");
        canvas.setAttribute("aria-label", `${what} of vehicle ${vehicle} over time`);
        figure.append(canvas);
        return canvas;
      });
      this.place.append(figure);
      const row = { vehicle, index, surfaces: surfaces.map((canvas) => new Surface(canvas, this.theme)) };
      surfaces.forEach((canvas, i) => canvas.addEventListener("click", (event) => {
        if (row.charts) this.seek(row.charts[i].timeAt(event.offsetX));
      }));
      return row;
    });
  }

  // The cycles that the charts show: first, last and step.
  #window(time) {
    const { period } = this.run.about;
    const from = Math.max(0, time - WINDOW * (1 - AHEAD));
    const first = Math.floor(from / period);
    const step = Math.max(1, Math.floor(WINDOW / period / 800));
    return { from, first: Math.floor(first / step) * step, last: Math.ceil((from + WINDOW) / period), step };
  }

  want(time) {
    const { first, last, step } = this.#window(time);
    const soon = Math.ceil((time + 0.5) / this.run.about.period);
    return this.near?.want(first, Math.ceil(last / 20) * 20, step, soon);
  }

  draw(time, events) {
    if (!this.near) return;
    const { from, first, last, step } = this.#window(time);
    const pictures = [];
    for (let k = first; k <= last; k += step) {
      const picture = this.near.get(k);
      if (picture) pictures.push(picture);
    }
    const { period } = this.run.about;
    const x = pictures.map((picture) => picture.cycle * period);
    const marks = events.filter((event) => event.time >= from && event.time <= from + WINDOW).map((event) => event.time);
    for (const row of this.rows) {
      const y = (name) => {
        const at = this.near.names.indexOf(name) * this.near.size + row.index;
        return (i) => pictures[i].columns[at];
      };
      row.charts = [
        this.#chart(row.surfaces[0], "gap to the vehicle ahead, m", x, y, "gap", time, from, marks),
        this.#chart(row.surfaces[1], "speed, m/s", x, y, "speed", time, from, marks),
      ];
    }
  }

  #chart(surface, title, x, y, name, now, from, marks) {
    const { theme } = this;
    const series = [
      { x, y: y(`read_${name}`), colour: theme.reading, dots: true },
      ...(name === "gap" ? [{ x, y: y("estimated_gap"), band: y("gap_std"), colour: theme.estimate }] : []),
      { x, y: y(`estimated_${name}`), colour: theme.estimate, width: 1.6 },
      { x, y: y(name), colour: theme.truth, width: 1.8 },
    ];
    return chart(surface, { title, from, to: from + WINDOW, now, series, marks });
  }
}
