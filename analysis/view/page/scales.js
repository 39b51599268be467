// From which to which value colours go.

// The scale of the road: of speeds over the whole run, or of the oldest data so far.
export function scaleOf(view, scene, overview) {
  if (view.colour !== "age") return speedScale(overview);
  const high = Math.max(0.1, scene ? scene.total("oldest") : 0.1);
  view.ageHigh = Math.max(view.ageHigh ?? 0, Math.ceil(high * 10) / 10);
  return { low: 0, high: view.ageHigh };
}

export function speedScale({ low, high }) {
  if (!(low <= high)) return { low: 0, high: 1 };
  const grain = high - low > 5 ? 1 : 0.1;
  return { low: Math.floor(low / grain) * grain, high: Math.max(Math.ceil(high / grain) * grain, low + 0.2) };
}
