// Legends beside the pictures, never over their data.
import { cividis } from "./colours.js";

const RADIO = [["line", "delivered", "delivered"], ["line dashed", "lost", "lost"], ["line", "late", "late"], ["line dashed", "collided", "collided"]];

export function radioLegend(place) {
  place.replaceChildren(...RADIO.flatMap(([kind, colour, text]) => [mark(`${kind} ${colour}`), text]));
}

export function colourLegend(place, kind, scale, modes, theme, hollow) {
  const said = `${kind} ${scale.low} ${scale.high} ${modes.map(([name]) => name)} ${theme.version}`;
  if (place.dataset.said === said) return;
  place.dataset.said = said;
  if (kind !== "mode") {
    const unit = kind === "age" ? "s" : "m/s";
    const places = scale.high - scale.low < 2 ? 2 : 1;
    place.replaceChildren(`${kind === "age" ? "age of data" : "speed"} ${scale.low.toFixed(places)}`, ramp(), `${scale.high.toFixed(places)} ${unit}`);
    return;
  }
  place.replaceChildren(...modes.flatMap(([name, colour]) => {
    const box = mark("box");
    box.style.backgroundColor = name === hollow ? "transparent" : theme.law(colour);
    box.style.borderColor = theme.law(colour);
    return [box, name];
  }));
}

function mark(name) {
  const made = document.createElement("i");
  made.className = name;
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
