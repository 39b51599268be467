// What is on the road at a time, between two cycles of the log.
import { shade, step } from "./colours.js";
import { NAMES } from "./outcomes.js";

export const FALLBACK = 6; // the mode of a vehicle that has fallen back to FM
export const HOLD = 0.1; // s for which a frame shows at least
export const SLOWEST = 4; // cycles that a late frame may take to show

export class Scene {
  // Modes and ages are those of the picture `decided`: the world moves on once after the last decisions.
  constructor(about, before, after, time, decided) {
    this.about = about;
    this.before = before;
    this.after = after;
    this.time = time;
    const period = about.period;
    const span = after ? (after.cycle - before.cycle) * period : period;
    this.part = Math.max(0, Math.min(1, (time - before.cycle * period) / span));
    this.size = before.position.length;
    this.modes = decided.column("mode");
    this.ages = decided.column("age");
    this.speeds = this.between("speed");
    this.positions = mix(before.position, after?.position, this.part, Float64Array);
  }

  between(name) {
    return mix(this.before.column(name), this.after?.column(name), this.part, Float32Array);
  }

  total(name) {
    return this.before.total(name);
  }
}

function mix(a, b, part, Type) {
  if (!b) return a;
  const made = new Type(a.length);
  for (let i = 0; i < a.length; i++) made[i] = a[i] + (b[i] - a[i]) * part;
  return made;
}

// The colours of vehicles: a function from index to { fill, hollow }.
export function painter(kind, scene, scale, theme) {
  if (kind === "mode") {
    return (i) => {
      const mode = scene.modes[i];
      const law = scene.about.modes[mode];
      return { fill: law ? theme.law(law[1]) : theme.edge, hollow: !law || mode === FALLBACK };
    };
  }
  const values = kind === "age" ? scene.ages : scene.speeds;
  return (i) => {
    const at = step(values[i], scale.low, scale.high);
    return { fill: at < 0 ? theme.edge : shade(at), hollow: at < 0 };
  };
}

// Whether any vehicle decides in a cycle.
export const hasDecisions = (picture) => picture.column("mode").some((mode) => mode > 0);

// Whether the colour of any vehicle is not known.
export function hasUnknown(kind, { modes, ages, speeds }) {
  return { mode: modes, age: ages, speed: speeds }[kind].some((value) => value !== value);
}

// The frames that show at a time: on their way, heard or lost, with how far they have come. Only a
// slow page shows them on their way; else they would be there too briefly.
export function framesAt(scene, { links, radio: choice, chosen, slow }) {
  const { period } = scene.about;
  const found = [];
  const cycle = Math.floor(scene.time / period + 1e-6);
  const hold = Math.max(period, HOLD) - 1e-6;
  for (let k = cycle - Math.ceil(HOLD / period) - SLOWEST; k <= cycle; k++) {
    for (const row of links.get(k)) {
      const name = NAMES[row.outcome];
      if (!name || row.sent > scene.time + 1e-9) continue;
      if (choice === "sends" && !chosen.includes(row.source)) continue;
      if (choice === "hears" && !chosen.includes(row.destination)) continue;
      const arrives = row.arrived >= 0;
      const gone = Math.max(row.sent + hold, arrives ? row.arrived : 0);
      if (scene.time >= gone) continue;
      const heard = name === "delivered" || name === "late";
      const travels = arrives ? row.arrived - row.sent : 0.1 * hold;
      const progress = slow ? Math.max(0, Math.min(1, (scene.time - row.sent) / Math.max(1e-6, travels))) : 1;
      found.push({ ...row, name, heard, progress });
    }
  }
  return found;
}
