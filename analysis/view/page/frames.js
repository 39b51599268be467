// Frames between vehicles, as arcs.
import { DASHES } from "./outcomes.js";

// How far an arc bends, so that the two directions between a pair have arcs of their own: a frame to
// a vehicle ahead goes farther from the road than one to a vehicle behind.
export const bend = (ahead) => (ahead >= 0 ? 1 : 0.55);

export function drawFrames(g, surface, place, scene, frames) {
  const { theme, em, thin } = surface;
  for (const frame of frames) {
    const p = scene.positions[frame.source - 1];
    const q = scene.positions[frame.destination - 1];
    const a = place.at(p);
    const b = place.at(q);
    const c = place.control(p, q);
    const onItsWay = frame.heard && frame.progress < 1;
    g.strokeStyle = g.fillStyle = theme[frame.name];
    g.globalAlpha = onItsWay ? 0.35 : frame.heard ? 0.6 : 0.95;
    g.lineWidth = (frame.heard ? 1.2 : 1.8) * thin;
    g.setLineDash(DASHES[frame.name].map((length) => length * thin));
    g.beginPath();
    g.moveTo(a[0], a[1]);
    const until = frame.heard ? 1 : 0.5 * frame.progress;
    if (until === 1) g.quadraticCurveTo(c[0], c[1], b[0], b[1]);
    else for (let s = 0.05; s <= until + 1e-9; s += 0.05) g.lineTo(...along(a, c, b, s));
    g.stroke();
    g.setLineDash([]);
    g.globalAlpha = 1;
    if (onItsWay) {
      g.beginPath();
      g.arc(...along(a, c, b, frame.progress), 0.28 * em, 0, 7);
      g.fill();
    } else if (!frame.heard) {
      const [x, y] = along(a, c, b, until);
      const r = 0.26 * em;
      g.lineWidth = 2 * thin;
      g.beginPath();
      g.moveTo(x - r, y - r);
      g.lineTo(x + r, y + r);
      g.moveTo(x + r, y - r);
      g.lineTo(x - r, y + r);
      g.stroke();
    }
  }
}

function along([ax, ay], [cx, cy], [bx, by], s) {
  const r = 1 - s;
  return [r * r * ax + 2 * r * s * cx + s * s * bx, r * r * ay + 2 * r * s * cy + s * s * by];
}
