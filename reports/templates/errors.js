// From the planes of two sides to colours: a side as it is, and how far the two are apart, on scales that do not move.
"use strict";

{
  const UNDECIDED = 2;
  const DECADES = { absolute: [-9, 0], signed: [-9, 0], relative: [-9, 0], limit: [-3, 3] }; // powers of ten at both ends

  // What may be shown of a plane's difference; the first stands for all others.
  raytruth.KINDS = { color: ["absolute", "signed", "relative", "limit"], t: ["relative", "absolute", "signed"],
                     normal: ["absolute"], index: ["absolute"] };
  raytruth.UNITS = { color: "of a linear channel", t: "of t", normal: "degrees", index: "" };

  raytruth.decades = (kind) => DECADES[kind];

  // The difference of pixel i: { value, mismatch, undecided }; value NaN: not finite, or without a number of its own.
  raytruth.difference = (a, b, i, plane, kind) => ({
    value: VALUES[plane](a, b, i, kind),
    mismatch: a.index[i] !== b.index[i],
    undecided: a.status[i] === UNDECIDED || b.status[i] === UNDECIDED,
  });

  const VALUES = {
    color: (a, b, i, kind) => {
      let most = 0, size = 0;
      for (let c = 3 * i; c < 3 * i + 3; c++) {
        const difference = b.color[c] - a.color[c];
        if (!Number.isFinite(difference)) return NaN;
        if (Math.abs(difference) > Math.abs(most)) most = difference;
        size = Math.max(size, Math.abs(a.color[c]));
      }
      return measured(most, size, kind, b.limit?.[i] ?? a.limit?.[i]);
    },
    t: (a, b, i, kind) => (a.index[i] < 0 || b.index[i] < 0 ? 0 : measured(b.t[i] - a.t[i], Math.abs(a.t[i]), kind)),
    normal: (a, b, i) => {
      if (a.index[i] < 0 || b.index[i] < 0) return 0;
      // the chord keeps its digits at small angles, where the arc cosine of a dot product has lost them
      const chord = Math.hypot(...[0, 1, 2].map((c) => b.normal[3 * i + c] - a.normal[3 * i + c]));
      return (2 * Math.asin(Math.min(chord / 2, 1)) * 180) / Math.PI;
    },
    index: () => 0,
  };

  function measured(difference, size, kind, limit) {
    if (kind === "signed" || difference === 0 || Number.isNaN(difference)) return difference;
    return Math.abs(difference) / (kind === "relative" ? size : kind === "limit" ? limit : 1);
  }

  // The place of an error on its scale, 0 to 1: `most` is 0 for the logarithmic one, else the end of a linear one.
  raytruth.place = (error, kind, most) => {
    const [low, high] = DECADES[kind], size = Math.abs(error);
    return Math.min(1, Math.max(0, most ? size / most : (Math.log10(size) - low) / (high - low)));
  };

  // The picture of the difference as RGBA bytes.
  raytruth.paintedError = (a, b, plane, kind, most, scale) => {
    const pixels = new Uint8ClampedArray(4 * a.width * a.height);
    for (let i = 0; i < a.width * a.height; i++) {
      const { value, mismatch, undecided } = raytruth.difference(a, b, i, plane, kind);
      // the order of figures/scale.py: what cannot be measured outranks what can
      const colour = Number.isNaN(value) ? scale.special.non_finite : undecided ? scale.special.undecided
        : mismatch ? scale.special.mismatch : value === 0 ? [0, 0, 0] : raytruth.shade(value, kind, most, scale);
      pixels.set(colour, 4 * i);
      pixels[4 * i + 3] = 255;
    }
    return pixels;
  };

  // The colour of a difference other than 0; below zero red and blue change places.
  raytruth.shade = (value, kind, most, scale) => {
    const colour = scale.table[Math.round(raytruth.place(value, kind, most) * (scale.table.length - 1))];
    return value < 0 ? [colour[2], colour[1], colour[0]] : colour;
  };

  // One side as RGBA bytes; `exposure` in stops, `range` of t over both sides, `objects` their colours.
  raytruth.painted = (side, plane, exposure, range, objects, special) => {
    const pixels = new Uint8ClampedArray(4 * side.width * side.height), gain = 2 ** exposure;
    const [near, far] = range.map(Math.log);
    for (let i = 0; i < side.width * side.height; i++) {
      let colour = [0, 0, 0];
      const of = (array, change) => [0, 1, 2].map((c) => change(array[3 * i + c]));
      if (plane === "color") colour = of(side.color, (v) => v * gain * 255);
      else if (plane === "index" && side.status[i] === UNDECIDED) colour = special.undecided;
      else if (side.index[i] < 0) colour = [0, 0, 0];
      else if (plane === "t") colour = Array(3).fill(242 - 190 * ((Math.log(side.t[i]) - near) / Math.max(far - near, 1e-12)));
      else if (plane === "normal") colour = of(side.normal, (v) => ((v + 1) / 2) * 255);
      else colour = objects[side.index[i]]?.rgb ?? special.non_finite;
      if (!colour.every(Number.isFinite)) colour = special.non_finite;
      pixels.set(colour.map((v) => Math.floor(v + 0.5)), 4 * i);
      pixels[4 * i + 3] = 255;
    }
    return pixels;
  };

  // Nearest and farthest hit of either side.
  raytruth.range = (...sides) => {
    let near = Infinity, far = 0;
    for (const side of sides) for (let i = 0; i < side.t.length; i++) {
      const t = side.t[i];
      if (side.index[i] >= 0 && Number.isFinite(t) && t > 0) [near, far] = [Math.min(near, t), Math.max(far, t)];
    }
    return far ? [near, far] : [1, 1];
  };

  // The pixels of largest difference of colour, one a cluster, as comparisons/verdicts/metrics.py picks them.
  raytruth.worst = (a, b, count, apart) => {
    const error = Float64Array.from({ length: a.width * a.height }, (_, i) => {
      const { value } = raytruth.difference(a, b, i, "color", "absolute");
      return Number.isNaN(value) ? Infinity : value;
    });
    const found = [];
    while (found.length < count) {
      let at = 0;
      for (let i = 1; i < error.length; i++) if (error[i] > error[at]) at = i;
      if (!(error[at] > 0)) break;
      const row = Math.floor(at / a.width), col = at % a.width;
      found.push({ row, col, error: error[at] });
      for (let r = Math.max(0, row - apart); r <= Math.min(a.height - 1, row + apart); r++)
        error.fill(0, r * a.width + Math.max(0, col - apart), r * a.width + Math.min(a.width - 1, col + apart) + 1);
    }
    return found;
  };
}
