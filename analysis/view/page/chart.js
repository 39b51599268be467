// A chart of lines over time: axes, grid, and the time that the page is at.
import { label, ticks } from "./canvas.js";

// series: [{ x, y, colour, width, dots, band, dash }], each with y as a function of the index.
export function chart(surface, { title, from, to, now, series, low, high, marks = [] }) {
  const g = surface.begin();
  const { theme, em, width, height } = surface;
  if (low === undefined) [low, high] = range(series);
  const fit = Math.max(2, Math.floor((height - 2.6 * em) / (1.9 * em)));
  const yTicks = atLeastTwo(low, high, fit);
  const yLabels = label(yTicks);
  const left = Math.max(...yLabels.map((text) => g.measureText(text).width), em) + 0.6 * em;
  const box = { left, top: 1.35 * em, right: width - 0.5 * em, bottom: height - 1.35 * em };
  const x = (t) => box.left + ((t - from) / (to - from || 1)) * (box.right - box.left);
  const y = (v) => box.bottom - ((v - low) / (high - low || 1)) * (box.bottom - box.top);
  g.fillStyle = theme.quiet;
  g.textBaseline = "middle";
  g.textAlign = "right";
  g.strokeStyle = theme.grid;
  g.beginPath();
  yTicks.forEach((value, i) => {
    const at = Math.round(y(value)) + 0.5;
    g.moveTo(box.left, at);
    g.lineTo(box.right, at);
    g.fillText(yLabels[i], box.left - 0.4 * em, at);
  });
  g.stroke();
  axis(g, surface, box, from, to, x);
  g.textAlign = "left";
  g.textBaseline = "alphabetic";
  g.fillStyle = theme.text;
  g.fillText(title, box.left, 0.85 * em);
  g.save();
  g.beginPath();
  g.rect(box.left, box.top - 2, box.right - box.left, box.bottom - box.top + 4);
  g.clip();
  for (const at of marks) line(g, surface, x(at), box, theme.edge, [2, 3]);
  for (const one of series) draw(g, surface, one, x, y);
  g.restore();
  if (now >= from && now <= to) line(g, surface, x(now), box, theme.accent, []);
  return { box, x, y, timeAt: (px) => from + ((px - box.left) / (box.right - box.left)) * (to - from) };
}

export function axis(g, surface, box, from, to, x) {
  const { theme, em } = surface;
  const values = ticks(from, to, Math.max(2, Math.floor((box.right - box.left) / (5 * em))));
  const labels = label(values);
  g.fillStyle = theme.quiet;
  g.strokeStyle = theme.edge;
  g.textBaseline = "top";
  g.beginPath();
  g.moveTo(box.left, Math.round(box.bottom) + 0.5);
  g.lineTo(box.right, Math.round(box.bottom) + 0.5);
  values.forEach((value, i) => {
    const at = Math.round(x(value)) + 0.5;
    g.moveTo(at, box.bottom);
    g.lineTo(at, box.bottom + 0.25 * em);
    const text = i === values.length - 1 ? `${labels[i]} s` : labels[i];
    const half = g.measureText(text).width / 2;
    g.textAlign = "left";
    g.fillText(text, Math.min(at - half, surface.width - 2 * half - 1), box.bottom + 0.35 * em);
  });
  g.stroke();
}

// Round numbers for an axis; one alone would give no scale.
function atLeastTwo(low, high, count) {
  const found = ticks(low, high, count);
  return found.length > 1 ? found : ticks(low, high, 2 * count);
}

export function line(g, { thin }, at, box, colour, dash) {
  g.save();
  g.strokeStyle = colour;
  g.lineWidth = 1.5 * thin;
  g.setLineDash(dash.map((length) => length * thin));
  g.beginPath();
  g.moveTo(at, box.top);
  g.lineTo(at, box.bottom);
  g.stroke();
  g.restore();
}

// Limits that hold all values, with some room, and at least `least` apart.
export function range(series, least = 0.5) {
  let low = Infinity;
  let high = -Infinity;
  for (const one of series) {
    if (one.band) continue;
    for (let i = 0; i < one.x.length; i++) {
      const v = one.y(i);
      if (v < low) low = v;
      if (v > high) high = v;
    }
  }
  if (!(low <= high)) return [0, 1];
  const room = Math.max(0.06 * (high - low), (least - (high - low)) / 2, 0);
  const [a, b] = [low - room, high + room];
  const step = ticks(a, b, 8);
  const grain = step.length > 1 ? step[1] - step[0] : 1;
  return [Math.floor(a / grain) * grain, Math.ceil(b / grain) * grain]; // so that it seldom moves
}

function draw(g, { thin }, one, x, y) {
  g.strokeStyle = g.fillStyle = one.colour;
  g.lineWidth = (one.width ?? 1.6) * thin;
  g.setLineDash((one.dash ?? []).map((length) => length * thin));
  if (one.dots) {
    for (let i = 0; i < one.x.length; i++) {
      const v = one.y(i);
      if (v === v) g.fillRect(x(one.x[i]) - 1.2 * thin, y(v) - 1.2 * thin, 2.4 * thin, 2.4 * thin);
    }
    return;
  }
  if (one.band) {
    g.globalAlpha = 0.18;
    g.beginPath();
    let begun = false;
    for (let i = 0; i < one.x.length; i++) {
      const v = one.y(i) + one.band(i);
      if (v === v) begun ? g.lineTo(x(one.x[i]), y(v)) : (g.moveTo(x(one.x[i]), y(v)), (begun = true));
    }
    for (let i = one.x.length - 1; i >= 0; i--) {
      const v = one.y(i) - one.band(i);
      if (v === v) g.lineTo(x(one.x[i]), y(v));
    }
    g.fill();
    g.globalAlpha = 1;
    return;
  }
  g.beginPath();
  let on = false;
  for (let i = 0; i < one.x.length; i++) {
    const v = one.y(i);
    if (v !== v) {
      on = false;
      continue;
    }
    on ? g.lineTo(x(one.x[i]), y(v)) : g.moveTo(x(one.x[i]), y(v));
    on = true;
  }
  g.lineJoin = "round";
  g.stroke();
  g.setLineDash([]);
}
