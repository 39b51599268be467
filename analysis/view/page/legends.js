// Legends beside the pictures, never over their data.
import { cividis } from "./colours.js";
import { sample } from "./outcomes.js";

export function radioLegend(place) {
  place.replaceChildren(...["delivered", "late", "lost", "collided"].flatMap((name) => [sample(name), name]));
}

// `modes` are pairs of name and colour, that of `hollow` as an outline. `unknown`: some vehicles have no colour.
export function colourLegend(place, kind, scale, theme, { modes = [], hollow = "", unknown = false } = {}) {
  const said = `${kind} ${scale.low} ${scale.high} ${modes.map(([name]) => name)} ${theme.version} ${unknown}`;
  if (place.dataset.said === said) return;
  place.dataset.said = said;
  const noData = unknown ? [box(theme.edge, true), "no data"] : [];
  if (kind !== "mode") {
    const unit = kind === "age" ? "s" : "m/s";
    const places = scale.high - scale.low < 2 ? 2 : 1;
    place.replaceChildren(`${kind === "age" ? "age of data" : "speed"} ${scale.low.toFixed(places)}`, ramp(), `${scale.high.toFixed(places)} ${unit}`, ...noData);
    return;
  }
  place.replaceChildren(
    ...modes.flatMap(([name, colour]) => [box(theme.law(colour), name === hollow), name]), ...noData,
  );
}

function box(colour, hollow) {
  const made = document.createElement("i");
  made.className = "box";
  made.style.backgroundColor = hollow ? "transparent" : colour;
  made.style.borderColor = colour;
  return made;
}

function ramp() {
  const canvas = document.createElement("canvas");
  canvas.width = cividis.length;
  canvas.height = 1;
  const g = canvas.getContext("2d");
  cividis.forEach(([r, gr, b], i) => {
    g.fillStyle = `rgb(${r},${gr},${b})`;
    g.fillRect(i, 0, 1, 1);
  });
  return canvas;
}
