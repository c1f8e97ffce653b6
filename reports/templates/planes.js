// The planes of a run, loaded on demand from a script file beside the report: no page may fetch a file from disk.
// Such a file calls raytruth.planes(key, file); figures/floats.py writes it and says how a plane is packed.
"use strict";

const raytruth = {};

{
  const waiting = new Map(); // key: what takes the file
  const loaded = new Map(); // key: a promise of the arrays
  const TYPES = { f8: Float64Array, f4: Float32Array, i4: Int32Array, i1: Int8Array, u1: Uint8Array };

  const arrived = new Map(); // key: the file of a side that nobody has asked for yet, where it stands in the page itself

  raytruth.planes = (key, file) => (waiting.has(key) ? waiting.get(key)(file) : arrived.set(key, file));

  // The arrays of a side { key, file }: { width, height, color, t, normal, index, status, limit? }, as it wrote them.
  raytruth.load = (side, sides) => {
    if (!loaded.has(side.key)) {
      const made = requested(side).then((file) => unpacked(file, sides));
      made.catch(() => loaded.delete(side.key)); // so that it can be tried again
      loaded.set(side.key, made);
    }
    return loaded.get(side.key);
  };

  function requested(side) {
    if (arrived.has(side.key)) return Promise.resolve(arrived.get(side.key));
    return new Promise((take, refuse) => {
      waiting.set(side.key, take);
      const script = document.createElement("script");
      script.src = side.file;
      script.onload = () => script.remove();
      script.onerror = () => refuse(new Error(`${side.file} is missing from the folder of the report`));
      document.head.append(script);
    });
  }

  async function unpacked(file, sides) {
    const base = file.base === null ? null : await raytruth.load(sides.find((side) => side.key === file.base), sides);
    const arrays = { width: file.width, height: file.height };
    for (const [name, plane] of Object.entries(file.planes)) arrays[name] = await unpack(plane, base && base[name]);
    return arrays;
  }

  async function unpack(plane, base) {
    const packed = new Uint8Array(plane.bytes);
    for (let i = 0, at = 0, held = 0, bits = 0; i < plane.data.length; i++) { // 15 bits a character
      held = ((held & ((1 << bits) - 1)) << 15) | (plane.data.charCodeAt(i) - 0x4000);
      for (bits += 15; bits >= 8 && at < packed.length; at++) packed[at] = (held >> (bits -= 8)) & 255;
    }
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const shuffled = new Uint8Array(await new Response(stream).arrayBuffer());
    const Type = TYPES[plane.type], wide = Type.BYTES_PER_ELEMENT, count = shuffled.length / wide;
    const bytes = new Uint8Array(shuffled.length);
    for (let k = 0; k < wide; k++) for (let i = 0, at = k * count; i < count; i++) bytes[i * wide + k] = shuffled[at + i];
    if (plane.xor) {
      const known = new Uint8Array(Type.from(base, (v) => (Number.isNaN(v) ? 0 : v)).buffer);
      for (let i = 0; i < bytes.length; i++) bytes[i] ^= known[i];
    }
    return new Type(bytes.buffer);
  }
}
