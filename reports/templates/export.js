// The planes of a side as a file for other programs, made from what the page has loaded: NPZ with every number as it is, EXR
// in single precision.
"use strict";

{
  const CHANNELS = { color: 3, normal: 3 };
  const NPY = { Float64Array: "<f8", Float32Array: "<f4", Int32Array: "<i4", Int8Array: "|i1", Uint8Array: "|u1" };
  const text = (string) => Uint8Array.from(string, (c) => c.charCodeAt(0));

  raytruth.save = (side, format, name) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob(format === "npz" ? npz(side) : exr(side), { type: "application/octet-stream" }));
    link.download = `${name}.${format}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  };

  // Numbers of `spec`, pairs of bytes and value, little-endian.
  function packed(...spec) {
    const view = new DataView(new ArrayBuffer(spec.reduce((sum, [bytes]) => sum + bytes, 0)));
    let at = 0;
    for (const [bytes, value] of spec) {
      if (bytes === 8) view.setBigUint64(at, BigInt(value), true);
      else if (bytes === 4) view.setUint32(at, value, true);
      else if (bytes === 2) view.setUint16(at, value, true);
      else view.setUint8(at, value);
      at += bytes;
    }
    return new Uint8Array(view.buffer);
  }

  const bytesOf = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  const joined = (parts) => {
    const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
    parts.reduce((at, part) => (all.set(part, at), at + part.length), 0);
    return all;
  };

  function npy(array, shape) {
    const header = `{'descr': '${NPY[array.constructor.name]}', 'fortran_order': False, 'shape': (${shape.join(", ")}), }`;
    const room = Math.ceil((10 + header.length + 1) / 64) * 64 - 10;
    return joined([text("\x93NUMPY\x01\x00"), packed([2, room]), text(`${header.padEnd(room - 1)}\n`), bytesOf(array)]);
  }

  // A ZIP file whose members are stored as they are.
  function npz(side) {
    const members = [], index = [];
    let at = 0;
    for (const [name, array] of Object.entries(side).filter(([, value]) => ArrayBuffer.isView(value))) {
      const content = npy(array, [side.height, side.width, ...(CHANNELS[name] ? [CHANNELS[name]] : [])]), file = text(`${name}.npy`);
      const about = [[2, 20], [2, 0], [2, 0], [4, 0x00210000], [4, crc(content)], [4, content.length], [4, content.length], [2, file.length], [2, 0]];
      members.push(packed([4, 0x04034b50], ...about), file, content);
      index.push(packed([4, 0x02014b50], [2, 20], ...about, [2, 0], [2, 0], [2, 0], [4, 0], [4, at]), file);
      at += 30 + file.length + content.length;
    }
    const size = index.reduce((sum, part) => sum + part.length, 0), count = index.length / 2;
    return [...members, ...index, packed([4, 0x06054b50], [2, 0], [2, 0], [2, count], [2, count], [4, size], [4, at], [2, 0])];
  }

  function crc(bytes) {
    let value = ~0;
    for (const byte of bytes) {
      value ^= byte;
      for (let k = 0; k < 8; k++) value = (value >>> 1) ^ (0xedb88320 & -(value & 1));
    }
    return ~value >>> 0;
  }

  // Uncompressed scanlines of float channels, in the order of their names, as the format wants them.
  function exr(side) {
    const { width, height } = side;
    const channels = [["B", "color", 2], ["G", "color", 1], ["N.x", "normal", 0], ["N.y", "normal", 1], ["N.z", "normal", 2],
                      ["R", "color", 0], ["Z", "t", 0], ["id", "index", 0], ["status", "status", 0]];
    const attribute = (name, type, ...value) => joined([text(`${name}\0${type}\0`), packed([4, joined(value).length]), ...value]);
    const box = packed([4, 0], [4, 0], [4, width - 1], [4, height - 1]), float = (v) => bytesOf(Float32Array.of(v));
    const list = channels.map(([name]) => joined([text(`${name}\0`), packed([4, 2], [4, 0], [4, 1], [4, 1])]));
    const header = joined([packed([4, 20000630], [4, 2]), attribute("channels", "chlist", ...list, packed([1, 0])),
      attribute("compression", "compression", packed([1, 0])), attribute("dataWindow", "box2i", box),
      attribute("displayWindow", "box2i", box), attribute("lineOrder", "lineOrder", packed([1, 0])),
      attribute("pixelAspectRatio", "float", float(1)), attribute("screenWindowCenter", "v2f", float(0), float(0)),
      attribute("screenWindowWidth", "float", float(1)), packed([1, 0])]);
    const line = 4 * width * channels.length, first = header.length + 8 * height, parts = [header];
    parts.push(packed(...Array.from({ length: height }, (_, row) => [8, first + row * (8 + line)])));
    for (let row = 0; row < height; row++) {
      parts.push(packed([4, row], [4, line]));
      for (const [, plane, k] of channels) {
        const wide = CHANNELS[plane] ?? 1, values = new Float32Array(width);
        for (let col = 0; col < width; col++) values[col] = side[plane][(row * width + col) * wide + k];
        parts.push(bytesOf(values));
      }
    }
    return parts;
  }
}
