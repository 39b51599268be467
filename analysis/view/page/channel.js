// Frames lost, late and collided, and how busy the medium is, over the whole run.
import { chart } from "./chart.js";
import { DASHES, sample } from "./outcomes.js";

export class Channel {
  constructor(surface, legend, overview, theme) {
    Object.assign(this, { surface, legend, overview, theme });
    this.lines = [];
    this.bins = 0;
    this.made = "";
  }

  draw(to, now) {
    this.#collect(to);
    const shown = this.lines.filter((line) => line.any);
    const series = shown.map((line) => ({ x: line.x, y: (i) => line.values[i], colour: this.theme[line.colour], dash: DASHES[line.name], width: line.name === "busy" ? 1 : 1.8 }));
    const top = Math.max(5, ...shown.map((line) => Math.max(...line.values.filter(Number.isFinite))));
    return chart(this.surface, { title: this.title, from: 0, to, now, series, low: 0, high: Math.min(100, 1.1 * top) });
  }

  // Means over bins, so that the lines can be read.
  #collect(to) {
    const { overview } = this;
    const made = `${overview.times.length} ${to} ${this.surface.width}`;
    if (made === this.made) return;
    this.made = made;
    const grain = overview.times[1] ?? 1;
    const bins = Math.max(10, Math.min(160, Math.floor(this.surface.width / 5)));
    const each = Math.max(1, Math.ceil(to / grain / bins));
    const lines = [
      { name: "lost", colour: "lost" }, { name: "late", colour: "late" },
      { name: "collided", colour: "collided" }, { name: "busy", colour: "quiet" },
    ].map((line) => ({ ...line, x: [], values: [], any: line.name === "lost" }));
    for (let first = 0; first < overview.times.length; first += each) {
      const last = Math.min(overview.times.length, first + each);
      const sum = {};
      let busy = 0;
      let count = 0;
      for (let i = first; i < last; i++) {
        for (const name of ["delivered", "late", "lost", "collided"]) sum[name] = (sum[name] ?? 0) + (overview.total(i, name) || 0);
        const share = overview.total(i, "busy");
        if (share === share) {
          busy += share;
          count += 1;
        }
      }
      const all = sum.delivered + sum.late + sum.lost + sum.collided;
      for (const line of lines) {
        const value = line.name === "busy" ? (100 * busy) / count : (100 * sum[line.name]) / all;
        line.x.push((overview.times[first] + overview.times[last - 1]) / 2);
        line.values.push(value);
        if (value > 0) line.any = true;
      }
    }
    this.lines = lines;
    this.title = `% of frames${lines[3].any ? ", % of time busy" : ""}, means over ${+(each * grain).toPrecision(2)} s`;
    this.#label();
  }

  #label() {
    const shown = this.lines.filter((line) => line.any).map((line) => line.name);
    if (this.labelled === shown.join()) return;
    this.labelled = shown.join();
    this.legend.replaceChildren(...shown.flatMap((name) => [sample(name), name === "busy" ? "medium busy" : name]));
  }
}
