// A close view of the first chosen vehicle, with gaps and speeds of its neighbours.
import { bend, drawFrames } from "./frames.js";
import { framesAt, painter } from "./scene.js";

export function drawLens(surface, scene, view) {
  const g = surface.begin();
  const { width, height, em, thin, theme } = surface;
  const chosen = view.chosen[0];
  const sides = Math.max(1, Math.min(4, Math.floor(width / (12 * em))));
  const length = scene.about.ring;
  const middle = scene.positions[chosen - 1];
  const off = (i) => {
    let apart = scene.positions[i] - middle;
    if (length) apart -= Math.round(apart / length) * length;
    return apart;
  };
  const shown = [];
  for (let d = -sides - 1; d <= sides + 1; d++) {
    let i = chosen - 1 - d;
    if (length) i = ((i % scene.size) + scene.size) % scene.size;
    if (i >= 0 && i < scene.size && !shown.includes(i)) shown.push(i);
  }
  const gaps = scene.between("gap");
  const usual = shown.map((i) => gaps[i]).filter((gap) => gap > 0 && isFinite(gap)).sort((a, b) => a - b);
  const mean = usual[Math.floor(usual.length / 2)] ?? 30;
  view.lensGap = view.lensGap ? view.lensGap + 0.03 * (mean - view.lensGap) : mean; // so that it does not jump
  const perMetre = width / ((2 * sides + 0.6) * view.lensGap);
  const y = height - 3.1 * em;
  const road = 2 * em;
  g.fillStyle = theme.road;
  g.fillRect(0, y - road / 2, width, road);
  g.fillStyle = theme.edge;
  g.fillRect(0, y - road / 2, width, thin);
  g.fillRect(0, y + road / 2, width, thin);
  const at = (i) => width / 2 + off(i) * perMetre;
  const place = {
    at: (p) => {
      const i = scene.positions.indexOf(p);
      return [at(i) - 0.5 * Math.max(scene.about.length * perMetre, 1.3 * em), y - 0.5 * em];
    },
    control: (p, q) => {
      const [a] = place.at(p);
      const [b] = place.at(q);
      const rise = Math.min(1.9 * (y - 1.2 * em), 1.6 * em + 0.35 * Math.abs(b - a));
      return [(a + b) / 2, y - 0.5 * em - rise * bend(b - a)];
    },
  };
  if (view.links) {
    const near = framesAt(scene, view)
      .filter((frame) => shown.includes(frame.source - 1) && shown.includes(frame.destination - 1));
    drawFrames(g, surface, place, scene, near);
  }
  const paint = painter(view.colour, scene, view.scale, theme);
  const long = Math.max(scene.about.length * perMetre, 1.3 * em);
  g.textBaseline = "middle";
  for (const i of shown) {
    const x = at(i);
    const { fill, hollow } = paint(i);
    g.fillStyle = hollow ? theme.panel : fill;
    g.strokeStyle = hollow ? fill : theme.isDark ? "rgb(255 255 255 / 60%)" : "rgb(0 0 0 / 50%)";
    g.lineWidth = (hollow ? 2 : 1) * thin;
    g.beginPath();
    g.roundRect(x - long, y - 0.5 * em, long, em, 0.25 * em);
    g.fill();
    g.stroke();
    if (i + 1 === chosen) {
      g.strokeStyle = theme.accent;
      g.lineWidth = 2.5 * thin;
      const off = 3 * thin;
      g.strokeRect(x - long - off, y - 0.5 * em - off, long + 2 * off, em + 2 * off);
    }
    if (view.faulty.includes(i + 1)) {
      g.strokeStyle = theme.lost;
      g.lineWidth = 2 * thin;
      g.beginPath();
      g.arc(x - long / 2, y, 1.05 * em, 0, 7);
      g.stroke();
    }
    if (x - long / 2 < 1.2 * em || x - long / 2 > width - 1.2 * em) continue; // no room for words
    g.textAlign = "center";
    surface.font(0.85, i + 1 === chosen ? 700 : 400);
    g.fillStyle = i + 1 === chosen ? theme.accent : theme.text;
    g.fillText(`${i + 1}`, x - long / 2, y + road / 2 + 0.7 * em);
    surface.font(0.78);
    g.fillStyle = theme.quiet;
    if (x > 2.8 * em && x < width - 2 * em) g.fillText(`${scene.speeds[i].toFixed(1)} m/s`, x - long / 2, y + road / 2 + 1.75 * em);
    if (isFinite(gaps[i])) {
      const to = x + gaps[i] * perMetre - long;
      const text = `${gaps[i].toFixed(1)} m`;
      if (to - x > g.measureText(text).width + 0.6 * em) g.fillText(text, (x + to) / 2, y);
    }
  }
}
