// Speeds of all vehicles over the whole run, upwards by vehicle or by place.
import { label, ticks } from "./canvas.js";
import { axis, line } from "./chart.js";
import { cividis, shade, step } from "./colours.js";
import { isBad } from "./events.js";

export class SpaceTime {
  constructor(surface, overview, about) {
    this.surface = surface;
    this.overview = overview;
    this.about = about;
    this.picture = document.createElement("canvas");
    this.drawn = "";
  }

  // Draws the diagram from time 0 to `to`; returns what turns a pixel into a time.
  draw({ to, now, upwards, scale, chosen, events }) {
    const { surface, about } = this;
    const g = surface.begin();
    const { theme, em, width, height } = surface;
    const byPlace = upwards === "place";
    const [low, high] = byPlace ? this.#places() : [0.5, about.vehicles + 0.5];
    const yTicks = byPlace ? ticks(low, high, height / (2.2 * em)) : numbers(about.vehicles, height / (1.7 * em));
    const yLabels = byPlace ? label(yTicks).map((text) => `${text}`) : yTicks.map(String);
    const left = Math.max(...yLabels.map((text) => g.measureText(text).width)) + 0.7 * em;
    const box = { left, top: 1.4 * em, right: width - 0.5 * em, bottom: height - 1.4 * em };
    const x = (t) => box.left + (t / (to || 1)) * (box.right - box.left);
    const y = (v) => byPlace
      ? box.bottom - ((v - low) / (high - low)) * (box.bottom - box.top)
      : box.top + ((v - low) / (high - low)) * (box.bottom - box.top);
    if (byPlace) this.#paths(g, box, x, y, scale);
    else this.#map(g, box, x, scale);
    g.fillStyle = theme.quiet;
    g.textAlign = "right";
    g.textBaseline = "middle";
    yTicks.forEach((value, i) => g.fillText(yLabels[i], box.left - 0.4 * em, Math.max(box.top + 0.3 * em, Math.min(box.bottom - 0.3 * em, y(value)))));
    g.textAlign = "left";
    g.textBaseline = "alphabetic";
    g.fillStyle = theme.text;
    g.fillText(byPlace ? (about.ring ? "place on the ring, m" : "place, m") : "vehicle", box.left, 0.9 * em);
    axis(g, surface, box, 0, to, x);
    if (!byPlace) {
      g.fillStyle = theme.accent;
      for (const v of chosen) {
        g.beginPath();
        g.moveTo(box.left - 1, y(v));
        g.lineTo(box.left - 0.38 * em, y(v) - 0.3 * em);
        g.lineTo(box.left - 0.38 * em, y(v) + 0.3 * em);
        g.fill();
      }
    }
    for (const event of events) {
      g.fillStyle = isBad(event) ? theme.lost : theme.quiet;
      g.fillRect(x(event.time) - surface.thin, box.top - 0.35 * em, 2 * surface.thin, 0.3 * em);
    }
    line(g, surface, x(now), { ...box, top: box.top - 3 }, theme.panel, []);
    g.globalAlpha = 0.95;
    line(g, surface, x(now) + surface.thin, { ...box, top: box.top - 3 }, theme.accent, []);
    g.globalAlpha = 1;
    return {
      timeAt: (px) => ((px - box.left) / (box.right - box.left)) * to,
      vehicleAt: (py) => (byPlace ? 0 : Math.round(low + ((py - box.top) / (box.bottom - box.top)) * (high - low))),
    };
  }

  #places() {
    if (this.about.ring) return [0, this.about.ring];
    const { positions } = this.overview;
    const last = positions[positions.length - 1] ?? [1];
    return [Math.min(...positions[0] ?? [0]), Math.max(...last, 1)];
  }

  // A pixel for each sample, which is drawn again only if there are more samples or another scale.
  #map(g, box, x, scale) {
    const { overview, picture } = this;
    const columns = overview.times.length;
    const rows = overview.vehicles.length;
    const drawn = `${columns} ${scale.low} ${scale.high}`;
    if (columns === 0) return;
    if (this.drawn !== drawn) {
      this.drawn = drawn;
      picture.width = columns;
      picture.height = rows;
      const image = new ImageData(columns, rows);
      const words = new Uint32Array(image.data.buffer);
      const colours = cividis.map(([r, gr, b]) => (255 << 24) | (b << 16) | (gr << 8) | r);
      for (let i = 0; i < columns; i++) {
        const speeds = overview.speeds[i];
        for (let j = 0; j < rows; j++) {
          const at = step(speeds[j], scale.low, scale.high);
          if (at >= 0) words[j * columns + i] = colours[at];
        }
      }
      picture.getContext("2d").putImageData(image, 0, 0);
    }
    g.imageSmoothingEnabled = false;
    const grain = columns > 1 ? overview.times[1] : 1;
    const end = x(overview.times[columns - 1] + grain);
    g.save();
    g.beginPath();
    g.rect(box.left, box.top, box.right - box.left, box.bottom - box.top);
    g.clip();
    g.drawImage(picture, box.left, box.top, end - box.left, box.bottom - box.top);
    g.restore();
  }

  // A path for each vehicle, at most 60 of them, in pieces of one colour.
  #paths(g, box, x, y, scale) {
    const { overview, picture, surface } = this;
    const { times, positions, speeds } = overview;
    const wide = Math.round((box.right - box.left) * surface.density);
    const high = Math.round((box.bottom - box.top) * surface.density);
    const drawn = `paths ${times.length} ${scale.low} ${scale.high} ${wide} ${high} ${x(1)}`;
    if (this.drawn !== drawn && wide > 0 && high > 0) {
      this.drawn = drawn;
      picture.width = wide;
      picture.height = high;
      const p = picture.getContext("2d");
      p.scale(surface.density, surface.density);
      p.translate(-box.left, -box.top);
      p.lineWidth = 1.5 * surface.thin;
      const length = this.about.ring;
      const every = Math.ceil(overview.vehicles.length / 60);
      const skip = Math.max(1, Math.floor(times.length / (box.right - box.left)));
      for (let j = 0; j < overview.vehicles.length; j += every) {
        let colour = -2;
        for (let i = skip; i < times.length; i += skip) {
          let a = positions[i - skip][j];
          let b = positions[i][j];
          if (length) {
            const laps = Math.floor(a / length) * length;
            a -= laps;
            b -= laps;
          }
          const at = step(speeds[i][j], scale.low, scale.high);
          if (at < 0) continue;
          if (at !== colour) {
            if (colour >= 0) p.stroke();
            p.beginPath();
            p.strokeStyle = shade(at);
            colour = at;
          }
          p.moveTo(x(times[i - skip]), y(a));
          p.lineTo(x(times[i]), y(b));
          if (length && b > length) {
            p.moveTo(x(times[i - skip]), y(a - length));
            p.lineTo(x(times[i]), y(b - length));
          }
        }
        if (colour >= 0) p.stroke();
      }
    }
    if (picture.width && picture.height) g.drawImage(picture, box.left, box.top, box.right - box.left, box.bottom - box.top);
  }
}

// Numbers of vehicles for an axis, the first and the last among them.
function numbers(vehicles, most) {
  const found = ticks(0, vehicles, most).filter((n) => n >= 1 && Number.isInteger(n));
  if (found[0] !== 1) found.unshift(1);
  const grain = found.length > 2 ? found[2] - found[1] : 1;
  if (found[1] - 1 < 0.5 * grain) found.splice(1, 1);
  if (found[found.length - 1] !== vehicles) {
    if (vehicles - found[found.length - 1] < 0.6 * grain && found.length > 1) found.pop();
    found.push(vehicles);
  }
  return found;
}
