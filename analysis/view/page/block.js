// Unpacks what analysis/view/block.py packs: a header, then arrays.
const TYPES = { uint32: Uint32Array, float32: Float32Array, float64: Float64Array };

export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const { arrays } = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const found = {};
  let at = 4 + length;
  for (const [name, type, shape] of arrays) {
    const count = shape.reduce((product, n) => product * n, 1);
    found[name] = new TYPES[type](buffer, at, count);
    at += Math.ceil((count * TYPES[type].BYTES_PER_ELEMENT) / 8) * 8;
  }
  return found;
}
