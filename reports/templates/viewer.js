// The viewer of a scene's page: two sides in one place, to the last digit of a pixel. What it shows is its state; the
// address's fragment holds the state, so that a link restores it. Keys, pointer and touch change the state and nothing else.
"use strict";

for (const root of document.querySelectorAll(".viewer")) { // one a scene: a file of several scenes puts a word before each id
  const name = root.id, before = name.slice(0, -"viewer".length);
  const scene = JSON.parse(root.querySelector("[type='application/json']").textContent);
  const { sides, objects, scale } = scene;
  const find = (name) => root.querySelector(`[data-part="${name}"]`);
  const canvas = find("canvas"), legend = find("legend"), context = canvas.getContext("2d");
  const MOST_ZOOM = 64, GRID_FROM = 12; // screen pixels of a picture's pixel: at most, and from when one is framed
  const ofId = (id) => sides.find((side) => side.id === id);

  const state = { a: scene.pair[0], b: scene.pair[1], view: "a", plane: "color", kind: "absolute", most: 0, exposure: 0,
                  split: 0.5, zoom: 1, x: scene.width / 2, y: scene.height / 2, row: null, col: null, pinned: false };
  let shown = null; // { a, b, range } arrays of the two sides that the picture is made of
  let layers = {}; // view: canvas of the picture in its own size
  let opened = false;

  // ---- state and address

  const CODED = { // name: [write, read]
    a: [String, (v) => (ofId(v) ? v : undefined)], b: [String, (v) => (ofId(v) ? v : undefined)],
    view: [String, one("a", "b", "split", "error")], plane: [String, one("color", "t", "normal", "index")],
    kind: [String, one("absolute", "signed", "relative", "limit")], most: [String, number(0, 1000)],
    exposure: [String, number(-20, 40)], split: [(v) => v.toFixed(3), number(0, 1)], zoom: [(v) => v.toFixed(3), number(1, 1e4)],
    x: [(v) => v.toFixed(2), number(0, scene.width)], y: [(v) => v.toFixed(2), number(0, scene.height)],
    row: [String, number(0, scene.height - 1)], col: [String, number(0, scene.width - 1)],
  };
  function one(...allowed) { return (v) => (allowed.includes(v) ? v : undefined); }
  function number(low, high) { return (v) => (v !== "" && Number(v) >= low && Number(v) <= high ? Number(v) : undefined); }

  function address() {
    const coded = new URLSearchParams();
    for (const [name, [write]] of Object.entries(CODED)) {
      if (state[name] === null || (!state.pinned && (name === "row" || name === "col"))) continue;
      coded.set(name, write(state[name]));
    }
    return `#${name}&${coded}`;
  }

  // Takes what a fragment says; true if it is one of ours. A link to a comparison chooses its two sides.
  function follow(fragment) {
    const text = fragment.replace(/^#/, ""), pair = scene.pairs.find((p) => before + p.anchor === text);
    if (pair) [state.a, state.b] = [pair.a, pair.b];
    if (!text.startsWith(`${name}&`)) return false;
    const coded = new URLSearchParams(text.slice(name.length + 1));
    for (const [name, [, read]] of Object.entries(CODED)) {
      const value = coded.has(name) ? read(coded.get(name)) : undefined;
      if (value !== undefined) state[name] = value;
    }
    state.pinned = coded.has("row") && coded.has("col") && state.row !== null && state.col !== null;
    if (state.pinned) {
      [state.row, state.col] = [Math.floor(state.row), Math.floor(state.col)];
      if (!coded.has("x")) [state.x, state.y] = [state.col + 0.5, state.row + 0.5];
    }
    return true;
  }

  let writing = 0;
  function remember() { // not more often than browsers allow
    clearTimeout(writing);
    writing = setTimeout(() => { if (opened) history.replaceState(null, "", address()); }, 120);
    find("link").href = address();
  }

  // ---- what is drawn

  async function open() {
    opened = true;
    const wanted = [ofId(state.a), ofId(state.b)];
    find("wait").hidden = false;
    find("open").hidden = true;
    find("wait-text").textContent = `Loading ${wanted.map((side) => side.title).join(" and ")} (${room()})…`;
    try {
      const [a, b] = await Promise.all(wanted.map((side) => raytruth.load(side, sides)));
      if (a.width !== b.width || a.height !== b.height) throw new Error("the two pictures differ in size");
      if (wanted[0].id !== state.a || wanted[1].id !== state.b) return; // chosen anew in the meantime
      shown = { a, b, range: raytruth.range(a, b), ids: [state.a, state.b] };
      layers = {};
      find("wait").hidden = true;
      root.dataset.ready = `${state.a} ${state.b}`;
      update();
      listWorst();
    } catch (error) {
      find("wait-text").textContent = `The numbers cannot be shown: ${error.message}.`;
    }
  }

  function layer(view) {
    const gain = view === "error" ? "" : state.exposure;
    const name = [view, state.plane, gain, ...(view === "error" ? [state.kind, state.most] : [])].join();
    if (!layers[name]) {
      const { a, b, range } = shown;
      const pixels = view === "error" ? raytruth.paintedError(a, b, state.plane, kind(), state.most, scale)
        : raytruth.painted(shown[view], state.plane, state.exposure, range, objects, scale.special);
      const made = document.createElement("canvas");
      [made.width, made.height] = [a.width, a.height];
      made.getContext("2d").putImageData(new ImageData(pixels, a.width, a.height), 0, 0);
      if (Object.keys(layers).length > 24) layers = {};
      layers[name] = made;
    }
    return layers[name];
  }

  // The kind of error that the plane has, the chosen one if it has that.
  function kind() {
    const possible = raytruth.KINDS[state.plane];
    return possible.includes(state.kind) && (state.kind !== "limit" || hasLimit()) ? state.kind : possible[0];
  }
  const truth = scene.truth;
  const hasLimit = () => (state.a === truth ? Boolean(shown?.b.limit) : state.b === truth && Boolean(shown?.a.limit));

  // Screen pixels of a picture's pixel, and where the picture's corner lies on the canvas.
  function frame() {
    const fit = canvas.width / scene.width, size = fit * state.zoom;
    return { size, left: canvas.width / 2 - state.x * size, top: canvas.height / 2 - state.y * size };
  }

  function draw() {
    const width = Math.round(canvas.clientWidth * devicePixelRatio);
    const height = Math.round((width * scene.height) / scene.width);
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    if (!shown || !width) return;
    clamp();
    const { size, left, top } = frame(), whole = [left, top, scene.width * size, scene.height * size];
    context.imageSmoothingEnabled = false;
    context.clearRect(0, 0, width, height);
    if (state.view === "split") {
      const at = state.split * width;
      for (const [view, from, to] of [["a", 0, at], ["b", at, width]]) {
        context.save();
        context.beginPath();
        context.rect(from, 0, to - from, height);
        context.clip();
        context.drawImage(layer(view), ...whole);
        context.restore();
      }
      context.fillStyle = "#fff";
      context.fillRect(at - 1, 0, 2, height);
    } else context.drawImage(layer(state.view), ...whole);
    if (state.row !== null) frameOf(state.row, state.col, size, left, top);
  }

  function frameOf(row, col, size, left, top) {
    const room = Math.max(0, (GRID_FROM - size) / 2); // a pixel too small to be seen is framed from further away
    for (const [colour, grow] of [["#000", 2], ["#fff", 1]]) {
      context.strokeStyle = colour;
      context.lineWidth = 1.5;
      context.strokeRect(left + col * size - room - grow, top + row * size - room - grow,
                         size + 2 * (room + grow), size + 2 * (room + grow));
    }
  }

  function clamp() {
    const most = Math.max(1, (MOST_ZOOM * devicePixelRatio * scene.width) / Math.max(1, canvas.width));
    state.zoom = Math.min(most, Math.max(1, state.zoom));
    const half = [scene.width, scene.height].map((n) => n / 2 / state.zoom);
    state.x = Math.min(scene.width - half[0], Math.max(half[0], state.x));
    state.y = Math.min(scene.height - half[1], Math.max(half[1], state.y));
    canvas.style.touchAction = state.zoom > 1 ? "none" : "pan-y"; // a whole picture lets the page scroll
  }

  // ---- what is written

  // The fewest digits that give the number back, in its own precision.
  function digits(value, array) {
    if (!Number.isFinite(value)) return Number.isNaN(value) ? "not a number" : value > 0 ? "∞" : "−∞";
    let text = String(value);
    if (array instanceof Float32Array)
      for (let n = 1; n <= 9; n++) if (Math.fround(Number(value.toPrecision(n))) === value) { text = String(Number(value.toPrecision(n))); break; }
    return text.replace(/-/g, "−");
  }
  raytruth.digits = digits;
  // Three digits, as text/numbers.py writes them everywhere else.
  function short(value) {
    if (!Number.isFinite(value) || value === 0) return digits(value, []);
    const [mantissa, exponent] = value.toExponential(2).split("e");
    if (Math.abs(value) >= 0.01 && Math.abs(value) < 1e5) return String(Number(value.toPrecision(3))).replace("-", "−");
    return `${mantissa}\u202f×\u202f${power(Number(exponent))}`.replace("-", "−");
  }
  const power = (exponent) => (exponent ? `10${String(exponent).replace(/./g, (c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)])}` : "1");
  // Of all files of the two sides: one may be written against another, which then has to be there.
  function room() {
    const needed = new Set();
    for (let side of [ofId(state.a), ofId(state.b)])
      for (; side; side = sides.find((other) => other.key === side.base)) needed.add(side);
    return megabytes([...needed].reduce((sum, side) => sum + side.bytes, 0));
  }
  const megabytes = (bytes) => `${(bytes / 1e6).toFixed(bytes < 1e5 ? 2 : 1)} MB`;

  function readout() {
    const { a, b } = shown ?? {}, { row, col } = state;
    find("where").textContent = row === null ? "Point at a pixel" : `Row ${row}, column ${col}${state.pinned ? "" : " (not held)"}`;
    if (!shown || row === null) return;
    const i = row * a.width + col, name = (side) => (side.index[i] < 0 ? "nothing" : objects[side.index[i]]?.name ?? `object ${side.index[i]}`);
    const number = (plane, k) => [a, b].map((side) => digits(side[plane][k], side[plane])).concat(short(b[plane][k] - a[plane][k]));
    const geometry = (values) => values.map((v, side) => ((side === 1 ? b : a).index[i] < 0 || (side === 2 && b.index[i] < 0) ? "–" : v));
    const rows = { red: number("color", 3 * i), green: number("color", 3 * i + 1), blue: number("color", 3 * i + 2),
                   object: [name(a), name(b), a.index[i] === b.index[i] ? "same" : "another"], t: geometry(number("t", i)),
                   "normal-x": geometry(number("normal", 3 * i)), "normal-y": geometry(number("normal", 3 * i + 1)),
                   "normal-z": geometry(number("normal", 3 * i + 2)),
                   status: [a, b].map((side) => (side.status[i] === 2 ? "undecided" : "decided")).concat("") };
    for (const [what, texts] of Object.entries(rows))
      root.querySelectorAll(`[data-row="${what}"] td`).forEach((cell, k) => { cell.textContent = texts[k]; });
    const error = raytruth.difference(a, b, i, "color", "absolute").value, limit = hasLimit() ? (b.limit ?? a.limit)[i] : null;
    find("held-to").textContent = limit === null ? "Neither side tells how far this pixel may be from the other."
      : `Colours differ by ${short(error)}; this pixel may be off by ${short(limit)}: ${short(error / limit)} of its limit.`;
    find("say").textContent = `Row ${row}, column ${col}: ${ofId(state.a).title} ${rows.red[0]}, ${rows.green[0]}, ${rows.blue[0]}; `
      + `${ofId(state.b).title} ${rows.red[1]}, ${rows.green[1]}, ${rows.blue[1]}; ${rows.object[0]}.`;
  }

  function drawLegend() {
    const error = state.view === "error" && state.plane !== "index", chosen = kind();
    legend.hidden = !error;
    find("legend-ends").hidden = !error;
    const what = { color: "Linear colour, clamped to 0–1 after exposure", t: "Distance t along the camera’s ray: near is light",
                   normal: "Normals: red, green, blue are x, y, z from −1 to 1", index: "The object hit first" }[state.plane];
    const side = { a: "A", b: "B", split: "A on the left, B on the right", error: "The difference B − A" }[state.view];
    find("caption").textContent = state.view === "error" ? state.plane === "index" ? "Cyan: another object, or a hit on one side only"
      : `${side}, ${chosen === "limit" ? "in units of the pixel’s limit" : `${chosen}, ${chosen === "relative" ? "in parts of A" : raytruth.UNITS[state.plane]}`}; cyan: another object, blue: undecided, white: not finite`
      : `${side}${state.view === "split" ? "" : `: ${ofId(state[state.view]).title}`}. ${what}`;
    if (!error) return;
    const ends = find("legend-ends").children, pen = legend.getContext("2d"), signed = chosen === "signed", [low, high] = raytruth.decades(chosen);
    for (let x = 0; x < legend.width; x++) {
      const at = signed ? (2 * x) / (legend.width - 1) - 1 : x / (legend.width - 1);
      const size = state.most ? Math.abs(at) * state.most : 10 ** (low + Math.abs(at) * (high - low));
      pen.fillStyle = `rgb(${raytruth.shade(at < 0 ? -size : size, chosen, state.most, scale)})`;
      pen.fillRect(x, 0, 1, legend.height);
    }
    const top = state.most ? String(state.most) : power(high), bottom = state.most ? "0" : power(low);
    [ends[0].textContent, ends[1].textContent, ends[2].textContent] = signed ? [`−${top}`, state.most ? "0" : `±${bottom}`, top]
      : [bottom, state.most ? String(state.most / 2) : Number.isInteger((low + high) / 2) ? power((low + high) / 2) : "", top];
  }

  function listWorst() {
    const list = find("worst"), { a, b } = shown;
    const found = raytruth.worst(a, b, scale.worst, scale.apart);
    find("worst-none").hidden = found.length > 0;
    list.replaceChildren(...found.map(({ row, col, error }) => {
      const item = document.createElement("li"), link = document.createElement("a");
      link.href = pixelLink(row, col);
      link.textContent = `${row}, ${col}`;
      const size = document.createElement("span");
      size.textContent = Number.isFinite(error) ? short(error) : "not finite";
      item.append(link, " ", size);
      const followed = scene.pairs.find((p) => p.a === state.a && p.b === state.b)?.histories.find((h) => h.row === row && h.col === col);
      if (followed) {
        const rays = document.createElement("a");
        [rays.href, rays.textContent] = [`#${before}${followed.anchor}`, "rays"];
        item.append(" ", rays);
      }
      return item;
    }));
  }
  const pixelLink = (row, col) => `#${name}&${new URLSearchParams({ a: state.a, b: state.b, row, col, zoom: 12 })}`;

  function controls() {
    for (const name of ["a", "b", "plane", "kind"]) find(name).value = name === "kind" ? kind() : state[name];
    find("most").value = String(state.most);
    find("exposure").value = state.exposure;
    find("exposure-value").textContent = `${state.exposure > 0 ? "+" : ""}${String(state.exposure).replace("-", "−")} stops`;
    find("split").value = state.split;
    find("split").disabled = state.view !== "split";
    root.querySelectorAll("[data-view]").forEach((button) => button.setAttribute("aria-pressed", button.dataset.view === state.view));
    for (const option of find("kind").options)
      option.disabled = !raytruth.KINDS[state.plane].includes(option.value) || (option.value === "limit" && !hasLimit());
    const pair = scene.pairs.find((p) => p.a === state.a && p.b === state.b);
    find("command").textContent = pair?.command ?? `${ofId(state.a).command}\n${ofId(state.b).command}`;
    for (const name of ["a", "b"]) {
      find(`title-${name}`).textContent = ofId(state[name]).title;
      find(`precision-${name}`).textContent = `${ofId(state[name]).bits} bits, ${megabytes(ofId(state[name]).bytes)}`;
    }
  }

  function update() {
    controls();
    draw();
    drawLegend();
    readout();
    remember();
  }

  function set(changes) {
    Object.assign(state, changes);
    if (!shown || shown.ids[0] !== state.a || shown.ids[1] !== state.b) open();
    update();
  }

  // ---- what changes it

  const place = (event) => {
    const box = canvas.getBoundingClientRect(), { size, left, top } = frame();
    const x = ((event.clientX - box.left) * devicePixelRatio - left) / size, y = ((event.clientY - box.top) * devicePixelRatio - top) / size;
    return { x, y, col: Math.min(scene.width - 1, Math.max(0, Math.floor(x))), row: Math.min(scene.height - 1, Math.max(0, Math.floor(y))) };
  };

  function zoomAt(factor, x = state.x, y = state.y) { // keeps the point (x, y) where it is
    const before = state.zoom;
    state.zoom *= factor;
    clamp();
    const kept = before / state.zoom;
    set({ x: x + (state.x - x) * kept, y: y + (state.y - y) * kept });
  }

  function move(row, col) {
    row = Math.min(scene.height - 1, Math.max(0, row));
    col = Math.min(scene.width - 1, Math.max(0, col));
    const half = [scene.width, scene.height].map((n) => n / 2 / state.zoom - 0.5);
    set({ row, col, pinned: true, x: Math.min(col + 0.5 + half[0], Math.max(col + 0.5 - half[0], state.x)),
          y: Math.min(row + 0.5 + half[1], Math.max(row + 0.5 - half[1], state.y)) });
  }

  const flip = () => set({ view: state.view === "a" ? "b" : "a" });
  function step(by) {
    const links = [...find("worst").querySelectorAll("li > a:first-child")];
    if (!links.length) return;
    const now = links.findIndex((link) => link.textContent === `${state.row}, ${state.col}`);
    arrive(links[(now + by + (now < 0 && by < 0 ? 1 : 0) + links.length) % links.length].getAttribute("href"));
  }

  const KEYS = {
    1: () => set({ view: "a" }), 2: () => set({ view: "b" }), 3: () => set({ view: "split" }), 4: () => set({ view: "error" }),
    " ": flip, f: flip, "+": () => zoomAt(1.5), "=": () => zoomAt(1.5), "-": () => zoomAt(1 / 1.5), 0: () => set({ zoom: 1 }),
    "[": () => set({ exposure: Math.max(-8, state.exposure - 0.5) }), "]": () => set({ exposure: Math.min(16, state.exposure + 0.5) }),
    ",": () => set({ view: "split", split: Math.max(0, state.split - 0.02) }), ".": () => set({ view: "split", split: Math.min(1, state.split + 0.02) }),
    n: () => step(1), p: () => step(-1), Escape: () => set({ pinned: false, row: null, col: null }),
    ArrowLeft: (by) => move(here()[0], here()[1] - by), ArrowRight: (by) => move(here()[0], here()[1] + by),
    ArrowUp: (by) => move(here()[0] - by, here()[1]), ArrowDown: (by) => move(here()[0] + by, here()[1]),
  };
  const here = () => (state.row === null ? [Math.floor(state.y), Math.floor(state.x)] : [state.row, state.col]);
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !KEYS[event.key]) return;
    event.preventDefault();
    KEYS[event.key](event.shiftKey ? 10 : 1);
  });

  const hover = ({ row, col }) => { if (row !== state.row || col !== state.col) { Object.assign(state, { row, col }); draw(); readout(); } };
  const fingers = new Map(); // pointer: where it is; a still one has not moved since it went down
  let still = false;
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button > 0) return;
    if (event.pointerType !== "touch") canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
    still = fingers.size === 1;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) {
      if (event.pointerType === "mouse" && !state.pinned && shown) hover(place(event));
      return;
    }
    const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
    if (still && Math.hypot(dx, dy) < 5) return;
    still = false;
    const scaleOf = (devicePixelRatio / frame().size);
    if (fingers.size === 1) set({ x: state.x - dx * scaleOf, y: state.y - dy * scaleOf });
    else {
      const other = [...fingers.values()].find((finger) => finger.pointerId !== event.pointerId);
      const apart = (finger) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY);
      const middle = place({ clientX: (event.clientX + other.clientX) / 2, clientY: (event.clientY + other.clientY) / 2 });
      zoomAt(apart(event) / Math.max(1, apart(before)), middle.x, middle.y);
    }
    fingers.set(event.pointerId, event);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (fingers.delete(event.pointerId) && still) {
      const { row, col } = place(event);
      set({ row, col, pinned: true });
    }
  });
  canvas.addEventListener("pointercancel", (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return; // a page that is scrolled past is not caught
    event.preventDefault();
    const { x, y } = place(event);
    zoomAt(1.2 ** -Math.sign(event.deltaY), x, y);
  }, { passive: false });

  for (const name of ["a", "b", "plane", "kind"]) find(name).addEventListener("change", (event) => set({ [name]: event.target.value }));
  for (const name of ["exposure", "split", "most"]) find(name).addEventListener("input", (event) => set({ [name]: Number(event.target.value) }));
  root.addEventListener("click", (event) => {
    const button = event.target.closest("button");
    if (!button) return;
    const { view, zoom, copy, save } = button.dataset;
    if (view) set({ view });
    else if (zoom) zoom === "fit" ? set({ zoom: 1 }) : zoomAt(Number(zoom));
    else if (copy) copied(button, copy === "link" ? new URL(address(), location.href).href : find("command").textContent);
    else if (save && shown) raytruth.save(shown[save[0]], save.slice(2), `${scene.name}-${state[save[0]]}`);
    else if (button.dataset.part === "open") open();
    else if (button.dataset.part === "flip") flip();
    else if (button.dataset.step) step(Number(button.dataset.step));
  });

  async function copied(button, text) {
    try { await navigator.clipboard.writeText(text); } catch { // not every browser lets a page from disk do that
      const field = document.createElement("textarea");
      field.value = text;
      button.append(field);
      field.select();
      document.execCommand("copy");
      field.remove();
    }
    find("copied").textContent = "Copied.";
    setTimeout(() => { find("copied").textContent = ""; }, 2000);
  }

  function arrive(fragment) {
    if (!follow(fragment)) return false;
    set({});
    if (opened && history.replaceState) history.replaceState(null, "", address());
    return true;
  }
  document.addEventListener("click", (event) => {
    const link = event.target.closest(`a[href^="#${name}&"]`);
    if (!link || event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    if (link !== find("link")) arrive(link.getAttribute("href"));
    root.scrollIntoView({ block: "start" });
    canvas.focus({ preventScroll: true });
  });
  addEventListener("hashchange", (event) => { // what is remembered of a viewer may stand in `location` by now
    if (follow(new URL(event.newURL).hash)) { set({}); root.scrollIntoView(); } else controls();
  });
  new ResizeObserver(draw).observe(canvas);

  find("tool").hidden = false;
  controls();
  drawLegend();
  find("size").textContent = room();
  if (follow(location.hash)) {
    set({});
    root.scrollIntoView();
  } else controls();
}
