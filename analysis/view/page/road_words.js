// What the road shows, in words: its legend, and a description for those who cannot see it.
import { colourLegend } from "./legends.js";
import { FALLBACK, hasUnknown } from "./scene.js";

const EVERY = 2000; // ms between descriptions

export class RoadWords {
  constructor(about) {
    this.about = about;
    this.road = document.getElementById("road");
    this.place = document.getElementById("legend");
    this.faulty = document.getElementById("faulty");
    this.modes = new Set(); // in which vehicles have been seen
    this.described = 0;
  }

  legend({ colour, scale, faulty }, scene, theme) {
    const { modes } = this.about;
    const shown = colour === "mode" ? this.#seen(scene) : [];
    const unknown = hasUnknown(colour, scene);
    colourLegend(this.place, colour, scale, theme, { modes: shown, hollow: modes[FALLBACK]?.[0], unknown });
    this.faulty.hidden = faulty.length === 0;
  }

  describe(scene, now) {
    if (now - this.described < EVERY) return;
    this.described = now;
    const gap = scene.total("smallest_gap");
    this.road.setAttribute("aria-label", `The road from above at ${scene.time.toFixed(1)} s: ${scene.size} vehicles, `
      + `mean speed ${scene.total("mean_speed").toFixed(1)} m/s, smallest gap ${gap.toFixed(1)} m`);
  }

  // Names and colours of modes.
  #seen(scene) {
    for (const mode of scene.modes) if (mode === mode) this.modes.add(mode);
    return [...this.modes].sort((a, b) => a - b).map((mode) => this.about.modes[mode] ?? [`mode ${mode}`, "#999999"]);
  }
}
