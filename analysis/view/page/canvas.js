// Canvases as large as the page shows them, on screens of any density.
export class Surface {
  static resized = 0; // how often any canvas has changed its size

  constructor(canvas, theme) {
    this.canvas = canvas;
    this.theme = theme;
    this.context = canvas.getContext("2d");
    this.width = this.height = 0;
    this.em = 14;
    this.thin = 1; // width of a thin line, which grows with the type on large screens
    new ResizeObserver(() => this.#resize()).observe(canvas);
    this.#resize();
  }

  // Clears the canvas and returns its context, in units of CSS pixels.
  begin() {
    const { context } = this;
    context.setTransform(this.density, 0, 0, this.density, 0, 0);
    context.clearRect(0, 0, this.width, this.height);
    this.font();
    context.lineWidth = this.thin;
    context.globalAlpha = 1;
    context.setLineDash([]);
    return context;
  }

  font(size = 0.82, weight = 400) {
    this.context.font = `${weight} ${(size * this.em).toFixed(1)}px ${this.family}`;
  }

  #resize() {
    const { canvas } = this;
    const style = getComputedStyle(canvas);
    this.density = Math.min(2, devicePixelRatio || 1);
    this.width = canvas.clientWidth;
    this.height = canvas.clientHeight;
    this.em = parseFloat(style.fontSize);
    this.thin = Math.max(1, this.em / 14);
    this.family = style.fontFamily;
    const width = Math.max(1, Math.round(this.width * this.density));
    const height = Math.max(1, Math.round(this.height * this.density));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
      Surface.resized += 1;
    }
  }
}

// Round numbers for the ticks of an axis, about `count` of them.
export function ticks(low, high, count) {
  const rough = (high - low) / Math.max(1, count);
  if (!(rough > 0) || !isFinite(rough)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((n) => n * power >= rough) * power;
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i++) found.push(i * step);
  return found;
}

export function digits(step) {
  return Math.max(0, Math.min(6, -Math.floor(Math.log10(step) + 1e-9)));
}

export function label(values) {
  const step = values.length > 1 ? values[1] - values[0] : Math.abs(values[0]) || 1;
  return values.map((value) => value.toFixed(digits(step)).replace("-", "−"));
}
