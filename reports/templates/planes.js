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

  // The arrays of a side { key, file, base }: { width, height, color, t, normal, index, status, limit? }, as it wrote them.
  raytruth.load = (side, sides) => {
    if (!loaded.has(side.key)) {
      const base = side.base && raytruth.load(sides.find((other) => other.key === side.base), sides);
      const made = Promise.all([requested(side), base]).then(([file, known]) => unpacked(file, known));
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

  async function unpacked(file, base) {
    const arrays = { width: file.width, height: file.height };
    for (const [name, plane] of Object.entries(file.planes)) arrays[name] = await unpack(plane, base && base[name], file);
    return arrays;
  }

  async function unpack(plane, base, { width, height }) {
    const packed = new Uint8Array(plane.bytes);
    for (let i = 0, at = 0, held = 0, bits = 0; i < plane.data.length; i++) { // 15 bits a character
      held = ((held & ((1 << bits) - 1)) << 15) | (plane.data.charCodeAt(i) - 0x4000);
      for (bits += 15; bits >= 8 && at < packed.length; at++) packed[at] = (held >> (bits -= 8)) & 255;
    }
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const coded = new Uint8Array(await new Response(stream).arrayBuffer());
    const Type = TYPES[plane.type], wide = Type.BYTES_PER_ELEMENT, count = coded.length / wide;
    const channels = count / width / height, line = width * channels;
    const bytes = new Uint8Array(coded.length), signed = plane.way !== "plain";
    for (let i = 0; i < count; i++) {
      const col = i % line, from = i - col + (col % channels) * width + Math.floor(col / channels);
      const sign = signed && coded[from] & 1 ? 255 : 0;
      for (let k = 0, at = from; k < wide; k++, at += count)
        bytes[i * wide + k] = signed ? ((coded[at] >> 1) | (k + 1 < wide ? coded[at + count] << 7 : 0)) ^ sign : coded[at];
    }
    const add = (to, numbers, from) => { // to number `to` number `from` of `numbers`, modulo 2^bits
      for (let k = 0, sum = 0; k < wide; k++, sum >>= 8) bytes[to * wide + k] = sum += bytes[to * wide + k] + numbers[from * wide + k];
    };
    if (plane.way === "near") {
      for (let i = 0; i < count; i++) if (i % line >= channels) add(i, bytes, i - channels);
      for (let i = line; i < count; i++) add(i, bytes, i - line);
    } else if (plane.way === "base") {
      const known = new Uint8Array(Type.from(base, (v) => (Number.isNaN(v) ? 0 : v)).buffer);
      for (let i = 0; i < count; i++) add(i, known, i);
    }
    return new Type(bytes.buffer);
  }
}
