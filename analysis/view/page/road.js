// The road from above: a ring as a ring, an open road as a strip that goes with the vehicles.
import { bend, drawFrames } from "./frames.js";
import { framesAt, painter } from "./scene.js";

export function drawRoad(surface, scene, view) {
  const g = surface.begin();
  const place = scene.about.ring ? ring(surface, scene) : strip(surface, scene);
  place.road(g);
  const frames = view.links ? framesAt(scene, view) : [];
  drawFrames(g, surface, place, scene, frames);
  const paint = painter(view.colour, scene, view.scale, surface.theme);
  drawVehicles(g, surface, place, scene, paint, view);
  return place;
}

function ring(surface, scene) {
  const { width, height, em, thin, theme } = surface;
  const length = scene.about.ring;
  const middle = [width / 2, height / 2];
  const road = Math.max(10, Math.min(1.7 * em, 0.05 * Math.min(width, height)));
  const radius = Math.max(30, Math.min(width, height) / 2 - 1.5 * em - road / 2);
  const angle = (p) => (p / length) * 2 * Math.PI - Math.PI / 2;
  return {
    perMetre: (2 * Math.PI * radius) / length,
    road_px: road,
    at(p, off = 0) {
      const a = angle(p);
      return [middle[0] + (radius + off) * Math.cos(a), middle[1] + (radius + off) * Math.sin(a), a + Math.PI / 2];
    },
    // Frames go inside the ring, deeper where they go farther.
    control(p, q) {
      let apart = ((q - p) % length + length) % length;
      if (apart > length / 2) apart -= length;
      const depth = 1 - Math.min(0.95, 0.25 + 1.5 * Math.abs(apart / length)) * bend(apart);
      const a = angle(p + apart / 2);
      return [middle[0] + radius * depth * Math.cos(a), middle[1] + radius * depth * Math.sin(a)];
    },
    road() {
      const g = surface.context;
      g.strokeStyle = theme.road;
      g.lineWidth = road;
      circle(g, middle, radius);
      g.strokeStyle = theme.edge;
      g.lineWidth = thin;
      circle(g, middle, radius - road / 2);
      circle(g, middle, radius + road / 2);
      g.lineWidth = 1.5 * thin;
      for (let n = 0; n < 8; n++) chevron(g, this.at((n / 8) * length), 0.18 * road);
    },
    labelOff: road / 2 + 0.75 * em,
  };
}

// An arrow head in the direction of travel.
function chevron(g, [x, y, angle], size) {
  g.save();
  g.translate(x, y);
  g.rotate(angle);
  g.beginPath();
  g.moveTo(-size, -size);
  g.lineTo(0, 0);
  g.lineTo(-size, size);
  g.stroke();
  g.restore();
}

function circle(g, [x, y], radius) {
  g.beginPath();
  g.arc(x, y, radius, 0, 2 * Math.PI);
  g.stroke();
}

function strip(surface, scene) {
  const { width, height, em, thin, theme } = surface;
  let low = Infinity;
  let high = -Infinity;
  for (const p of scene.positions) {
    low = Math.min(low, p);
    high = Math.max(high, p);
  }
  const room = Math.max(20, 0.04 * (high - low));
  low -= room + scene.about.length;
  high += room;
  const perMetre = width / (high - low);
  const y = height - 3.6 * em;
  const road = Math.max(12, 1.7 * em);
  return {
    perMetre,
    road_px: road,
    at: (p, off = 0) => [(p - low) * perMetre, y + off, 0],
    control(p, q) {
      const reach = Math.abs(q - p) * perMetre;
      return [(((p + q) / 2) - low) * perMetre, y - Math.min(1.85 * (y - em), 1.2 * em + 0.8 * reach) * bend(q - p)];
    },
    road() {
      const g = surface.context;
      g.fillStyle = theme.road;
      g.fillRect(0, y - road / 2, width, road);
      g.fillStyle = theme.edge;
      g.fillRect(0, y - road / 2, width, thin);
      g.fillRect(0, y + road / 2, width, thin);
      const grain = [10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000].find((m) => m * perMetre > 6 * em) ?? 20000;
      g.fillStyle = theme.quiet;
      g.textAlign = "center";
      g.textBaseline = "top";
      for (let m = Math.ceil(low / grain) * grain; m <= high; m += grain) {
        const x = (m - low) * perMetre;
        g.fillRect(x, y + road / 2, thin, 0.4 * em);
        if (x > 2.5 * em && x < width - 2.5 * em) g.fillText(`${m.toLocaleString("en")} m`, x, y + road / 2 + 1.9 * em);
      }
    },
    labelOff: road / 2 + 1.05 * em,
  };
}

function drawVehicles(g, surface, place, scene, paint, { chosen, faulty }) {
  const { theme, em, thin } = surface;
  const spacing = place.perMetre * (scene.about.ring ?? spread(scene)) / scene.size;
  const long = Math.max(2, Math.min(Math.max(scene.about.length * place.perMetre, 0.62 * em), 0.85 * spacing));
  const wide = Math.max(3, 0.42 * place.road_px);
  const fine = spacing < 4;
  const outline = theme.isDark ? "rgb(255 255 255 / 55%)" : "rgb(0 0 0 / 45%)";
  // One path for all vehicles of a colour, because a thousand paths would take too long.
  const colours = new Map();
  for (let i = 0; i < scene.size; i++) {
    const { fill, hollow } = paint(i);
    const name = hollow ? `hollow ${fill}` : fill;
    if (!colours.has(name)) colours.set(name, []);
    colours.get(name).push(i);
  }
  for (const [name, members] of colours) {
    const hollow = name.startsWith("hollow");
    const fill = hollow ? name.slice(7) : name;
    g.beginPath();
    if (fine) {
      for (const i of members) dash(g, place.at(scene.positions[i]), long);
      g.lineWidth = wide;
      g.strokeStyle = fill;
      g.stroke();
      continue;
    }
    for (const i of members) box(g, place.at(scene.positions[i]), long, wide);
    g.fillStyle = hollow ? theme.panel : fill;
    g.fill();
    g.lineWidth = (hollow ? 2 : 1) * thin;
    g.strokeStyle = hollow ? fill : outline;
    g.stroke();
  }
  g.strokeStyle = theme.lost;
  g.lineWidth = 2 * thin;
  for (const v of faulty) {
    const [x, y] = place.at(scene.positions[v - 1] - long / 2 / place.perMetre);
    g.beginPath();
    g.arc(x, y, 0.6 * place.road_px, 0, 7);
    g.stroke();
  }
  g.textAlign = "center";
  g.textBaseline = "middle";
  const every = [1, 2, 5, 10, 20, 50, 100, 200, 500].find((n) => n * spacing > 1.9 * em) ?? 1000;
  surface.font(0.8);
  for (let v = 1; v <= scene.size; v++) {
    const isChosen = chosen.includes(v);
    if (!isChosen && (v % every || chosen.some((one) => near(one - v, scene) * spacing < 1.9 * em))) continue;
    const at = scene.positions[v - 1] - long / 2 / place.perMetre;
    const [x, y, angle] = place.at(at, place.labelOff);
    if (isChosen) {
      const [cx, cy] = place.at(at);
      g.save();
      g.translate(cx, cy);
      g.rotate(angle);
      g.strokeStyle = theme.accent;
      g.lineWidth = 2.5 * thin;
      const out = 3 * thin;
      g.strokeRect(-long / 2 - out, -wide / 2 - out, long + 2 * out, wide + 2 * out);
      g.restore();
    }
    if (isChosen) surface.font(0.8, 700);
    g.fillStyle = isChosen ? theme.accent : theme.quiet;
    g.fillText(v, x, y);
    if (isChosen) surface.font(0.8);
  }
}

// How many vehicles apart two are, on a ring the shorter way.
function near(apart, scene) {
  const far = Math.abs(apart);
  return scene.about.ring ? Math.min(far, scene.size - far) : far;
}

// Adds a vehicle to the path: a box whose front is at a point of the road.
function box(g, [x, y, angle], long, wide) {
  const [c, n] = [Math.cos(angle), Math.sin(angle)];
  const [dx, dy] = [-c * long, -n * long];
  const [sx, sy] = [(-n * wide) / 2, (c * wide) / 2];
  g.moveTo(x + sx, y + sy);
  g.lineTo(x - sx, y - sy);
  g.lineTo(x + dx - sx, y + dy - sy);
  g.lineTo(x + dx + sx, y + dy + sy);
  g.closePath();
}

// Adds a vehicle to the path as a line, where there is no room for more.
function dash(g, [x, y, angle], long) {
  g.moveTo(x, y);
  g.lineTo(x - Math.cos(angle) * long, y - Math.sin(angle) * long);
}

function spread(scene) {
  return Math.max(1, Math.abs(scene.positions[0] - scene.positions[scene.size - 1]));
}

// The number of the vehicle nearest to a point of the canvas; 0 if none is near.
export function vehicleAt(place, scene, x, y, within) {
  let best = within * within;
  let found = 0;
  for (let i = 0; i < scene.size; i++) {
    const [vx, vy] = place.at(scene.positions[i]);
    const apart = (vx - x) ** 2 + (vy - y) ** 2;
    if (apart < best) {
      best = apart;
      found = i + 1;
    }
  }
  return found;
}
