// What may become of a frame, and its line: the same in every picture and legend.
export const DASHES = { delivered: [], late: [8, 3], lost: [4, 3], collided: [1.5, 2.5], busy: [] };

export const NAMES = { 1: "delivered", 2: "late", 3: "lost", 5: "lost", 7: "collided" };

// A piece of the line, for a legend.
export function sample(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
  svg.setAttribute("viewBox", "0 0 22 4");
  svg.setAttribute("class", `line ${name}`);
  for (const [key, value] of Object.entries({ x1: 0, x2: 22, y1: 2, y2: 2, "stroke-dasharray": DASHES[name].join(" ") || "none" })) line.setAttribute(key, value);
  svg.append(line);
  return svg;
}
