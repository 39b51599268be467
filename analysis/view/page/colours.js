// Colours of the page and of its data. matplotlib's cividis looks the same to colour-blind readers.
const CIVIDIS = [0x00224e, 0x002e6a, 0x1a386f, 0x32436d, 0x434e6c, 0x535a6d, 0x61656f, 0x6f7073, 0x7d7c78,
  0x8c8878, 0x9b9476, 0xaba072, 0xbcae6c, 0xcdbb63, 0xdec958, 0xf0d846, 0xfee838];
const STEPS = 64;

export const cividis = Array.from({ length: STEPS }, (_, i) => {
  const x = (i / (STEPS - 1)) * (CIVIDIS.length - 1);
  const low = Math.min(CIVIDIS.length - 2, Math.floor(x));
  return [16, 8, 0].map((shift) => {
    const a = (CIVIDIS[low] >> shift) & 255;
    const b = (CIVIDIS[low + 1] >> shift) & 255;
    return Math.round(a + (b - a) * (x - low));
  });
});
const CSS = cividis.map(([r, g, b]) => `rgb(${r},${g},${b})`);

export function step(value, low, high) {
  if (!(value === value)) return -1;
  return Math.max(0, Math.min(STEPS - 1, Math.round(((value - low) / (high - low || 1)) * (STEPS - 1))));
}

export const shade = (index) => CSS[index];

const NAMES = ["back", "panel", "text", "quiet", "line", "grid", "road", "edge", "accent", "truth", "estimate",
  "reading", "delivered", "late", "lost", "collided"];

export class Theme {
  constructor() {
    this.wanted = localStorage.getItem("theme");
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.apply());
    this.system = dark;
    this.apply();
  }

  get isDark() {
    return this.wanted ? this.wanted === "dark" : this.system.matches;
  }

  toggle() {
    this.wanted = this.isDark ? "light" : "dark";
    localStorage.setItem("theme", this.wanted);
    this.apply();
  }

  apply() {
    document.documentElement.dataset.theme = this.isDark ? "dark" : "light";
    const style = getComputedStyle(document.documentElement);
    for (const name of NAMES) this[name] = style.getPropertyValue(`--${name}`).trim();
    this.version = (this.version ?? 0) + 1;
  }

  // The colour of a law; black and white change places in the dark.
  law(colour) {
    return this.isDark ? { "#000000": "#f2f4f7", "#332288": "#8f7fe0", "#661100": "#d98a6b", "#882255": "#d46aa5", "#117733": "#4fb873", "#0072B2": "#3d9bd6" }[colour] ?? colour : colour;
  }
}
