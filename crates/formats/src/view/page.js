// What is pressed, dragged and pointed at; the flat views; the words beside them.

let space;
let eye;
// Null where there is no WebGL 2.
let cloud = null;
// The numbers of each map by its name, and the left image's pixels.
const maps = {};
// The pixel that was pointed at last.
let pixel = null;

const still = matchMedia("(prefers-reduced-motion: reduce)");
const short = (number, digits = 4) => String(Number(number.toPrecision(digits)));
const count = (number) => number.toLocaleString("en");

// ---- colours

// How far on the way from the start of a ramp to its end a value is, and what lies there. One value is at the start.
const partOf = ({ from, to, by_factor }) => {
  if (from === to) return () => 0;
  if (by_factor) return (value) => Math.log(value / from) / Math.log(to / from);
  return (value) => (value - from) / (to - from);
};
const valueAt = ({ from, to, by_factor }, part) =>
  by_factor ? from * (to / from) ** part : from + part * (to - from);

// Red, green, blue and 255 of each pixel in one of the colourings.
function coloursOf({ of, ramp, palette }) {
  if (!ramp && !palette) return maps[of];
  const table = ramp ? ramp.colours : palette.map(([colour]) => colour);
  const last = table.length - 1;
  const part = ramp && partOf(ramp);
  const entryOf = (value) => Math.round(last * Math.min(1, Math.max(0, part(value))));
  const black = [0, 0, 0];
  const colours = new Uint8ClampedArray(4 * columns * rows);
  maps[of].forEach((value, at) => {
    // No value has none in the table.
    const colour = table[ramp ? entryOf(value) : value] ?? black;
    [colours[4 * at], colours[4 * at + 1], colours[4 * at + 2]] = colour;
    colours[4 * at + 3] = 255;
  });
  return colours;
}

// A bar with numbers below it, or a list of colours.
function legendOf({ of, ramp, palette }) {
  const make = (name, text, style = "") =>
    Object.assign(document.createElement(name), { textContent: text, style });
  if (palette) {
    const list = make("ul", "");
    for (const [colour, words] of palette) {
      const entry = make("li", "");
      entry.append(make("span", "", `background: rgb(${colour.join(" ")})`), words);
      list.append(entry);
    }
    return [list];
  }
  const stops = [0, 0.25, 0.5, 0.75, 1];
  const values = stops.map((stop) => valueAt(ramp, stop));
  const colours = ramp.colours.map((colour) => `rgb(${colour.join(" ")})`).join(",");
  const row = (texts) => {
    const row = make("div", "");
    row.className = "ticks";
    row.append(...texts.map((text) => make("span", text)));
    return row;
  };
  const bar = make("div", "", `background: linear-gradient(90deg, ${colours})`);
  bar.className = "bar";
  // With as few digits as five of them have room for below the bar.
  const metres = (depth) => (Number.isNaN(depth) ? "\u2013" : `${short(depth, 3)} m`);
  const pixels = (disparity) => `${short(disparity, 3)} px`;
  if (of === "confidence") return [bar, row(values.map((value) => short(value)))];
  if (of === "depths") {
    return [bar, row(values.map(metres)), row(values.map((depth) => pixels(disparityOf(depth))))];
  }
  const rowsOfMetres = camera ? [row(values.map((disparity) => metres(depthOf(disparity))))] : [];
  return [bar, row(values.map(pixels)), ...rowsOfMetres];
}

function colour() {
  const chosen = facts.colourings[element("colouring").selectedIndex];
  cloud?.colour(new Uint8Array(coloursOf(chosen).buffer));
  // Beside the left image stands another picture.
  const flat = chosen.of === "image" ? facts.colourings[1] : chosen;
  element("map").getContext("2d").putImageData(new ImageData(coloursOf(flat), columns), 0, 0);
  const notes = {
    disparities: ", near is red",
    depths: ", near is red; the farthest have one colour",
    errors: ", in units of what KITTI's D1 calls wrong: 3 px and 5 % of the truth",
  };
  element("map-caption").textContent = flat.label + (notes[flat.of] ?? "");
  element("legend").replaceChildren(...legendOf(flat));
  draw();
}

// ---- the points

let waiting = false;
function draw() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    if (!cloud) return;
    const ground = getComputedStyle(element("cloud")).backgroundColor.match(/\d+/g);
    const size = Number(element("size").value);
    cloud.draw(eye, least(), size, ground.slice(0, 3).map((part) => part / 255));
    markPoint();
  });
}

const least = () => Math.fround(element("least").value);
const isShown = (at) => space.z[at] > 0 && (!maps.confidence || maps.confidence[at] >= least());

function tellCount() {
  let [points, shown] = [0, 0];
  const [sure, bound] = [maps.confidence, least()];
  space.z.forEach((z, at) => {
    if (!(z > 0)) return;
    points += 1;
    if (!sure || sure[at] >= bound) shown += 1;
  });
  element("least-text").textContent = bound.toFixed(2);
  element("size-text").textContent = `x ${Number(element("size").value).toFixed(1)}`;
  const hidden = points - shown;
  element("count").textContent =
    `${count(shown)} of ${count(points)} points are shown` +
    (hidden > 0 ? `, ${count(hidden)} are hidden because they are less sure than that.` : ".");
}

// To another place, in steps unless motion is unwanted. Whoever takes hold of the points counts on, and
// a trip that was begun ends.
let going = 0;
function go(to) {
  const from = { target: eye.target, distance: eye.distance, yaw: eye.yaw, pitch: eye.pitch };
  const mix = (a, b, part) => a + part * (b - a);
  const start = performance.now();
  going += 1;
  const trip = going;
  const step = (now) => {
    if (trip !== going) return;
    const time = still.matches ? 1 : Math.min(1, Math.max(0, (now - start) / 500));
    const part = time * time * (3 - 2 * time);
    eye.target = from.target.map((coordinate, at) => mix(coordinate, to.target[at], part));
    for (const name of ["distance", "yaw", "pitch"]) eye[name] = mix(from[name], to[name], part);
    // Sums of what is rounded do not quite arrive.
    if (time === 1) Object.assign(eye, to);
    else requestAnimationFrame(step);
    draw();
  };
  requestAnimationFrame(step);
}

// ---- the pixel that is pointed at

// Names and values of what is known of a pixel.
function known(at) {
  const [x, y] = [at % columns, Math.floor(at / columns)];
  const disparity = maps.disparities[at];
  const told = [["Pixel", `column ${x}, row ${y}`]];
  told.push(["Disparity", Number.isNaN(disparity) ? "none" : `${disparity.toFixed(3)} px`]);
  if (camera) {
    const [depth, error] = [space.z[at], facts.disparity_error];
    const [near, far] = [depthOf(disparity + error), depthOf(disparity - error)];
    const farthest = Number.isNaN(far) ? "any distance" : `${short(far)} m`;
    told.push(["Depth", Number.isNaN(depth) ? "none" : `${short(depth)} m`]);
    if (!Number.isNaN(depth)) {
      told.push([`\u00b1 ${error} px are`, `${short(near)} m to ${farthest}`]);
    }
  }
  if (maps.confidence) {
    const sure = maps.confidence[at];
    told.push(["Confidence", Number.isNaN(sure) ? "none" : sure.toFixed(2)]);
  }
  if (maps.reasons) told.push(["Reason", reasons()[maps.reasons[at]]]);
  if (maps.truth) {
    const truth = maps.truth[at];
    const off = disparity - truth;
    const error = Number.isNaN(off) ? "" : `, off by ${off.toFixed(3)} px`;
    told.push(["Truth", Number.isNaN(truth) ? "not known" : `${truth.toFixed(3)} px${error}`]);
  }
  return told;
}

// The words of each reason.
function reasons() {
  return facts.colourings.find(({ of }) => of === "reasons").palette.map(([, words]) => words);
}

function tell(told) {
  const make = ([name, value]) => ["dt", "dd"].map((kind, at) =>
    Object.assign(document.createElement(kind), { textContent: [name, value][at] }));
  element("pixel").replaceChildren(...told.flatMap(make));
}

// Keeps room for whatever may be told of a pixel: what stands below must not move while one points at it.
function reserve() {
  const list = element("pixel");
  const shown = [...list.childNodes];
  const isKnown = (disparity, at) =>
    !(Number.isNaN(disparity) || Number.isNaN(space.z[at]) || Number.isNaN(maps.truth?.[at]));
  const most = known(Math.max(0, maps.disparities.findIndex(isKnown)));
  const longest = (words, other) => (other.length > words.length ? other : words);
  const widest = { Truth: "100.000 px, off by -100.000 px" };
  if (maps.reasons) widest.Reason = reasons().reduce(longest);
  tell(most.map(([name, value]) => [name, [widest[name] ?? "", value].reduce(longest)]));
  list.style.minHeight = "";
  list.style.minHeight = `${list.offsetHeight}px`;
  list.replaceChildren(...shown);
}

function point(at) {
  if (at === null) return;
  pixel = at;
  const [x, y] = [at % columns, Math.floor(at / columns)];
  tell(known(at));
  for (const mark of document.querySelectorAll(".flat .mark")) {
    mark.hidden = false;
    mark.style.left = `${(100 * (x + 0.5)) / columns}%`;
    mark.style.top = `${(100 * (y + 0.5)) / rows}%`;
  }
  markPoint();
}

function markPoint() {
  const [mark, { clientWidth, clientHeight }] = [element("point-mark"), element("cloud")];
  const isSeen = cloud && pixel !== null && isShown(pixel);
  const place = isSeen ? eye.placeOf(space.pointOf(pixel), clientWidth, clientHeight) : null;
  mark.hidden = place === null;
  if (place) [mark.style.left, mark.style.top] = place.map((side) => `${side}px`);
}

// ---- what hands do

function followPointers(canvas) {
  const held = new Map();
  const place = (event) => [event.offsetX, event.offsetY];
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    going += 1;
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, place(event));
    point(cloud.at(...place(event)));
  });
  for (const kind of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(kind, (event) => held.delete(event.pointerId));
  }
  canvas.addEventListener("pointermove", (event) => {
    const before = held.get(event.pointerId);
    const now = place(event);
    if (!before) return point(cloud.at(...now));
    const [right, down] = [now[0] - before[0], now[1] - before[1]];
    const size = [canvas.clientWidth, canvas.clientHeight];
    if (held.size === 2) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const apart = (a) => Math.max(1, Math.hypot(a[0] - other[0], a[1] - other[1]));
      eye.approach(apart(before) / apart(now));
      eye.move(right / 2, down / 2, ...size);
    } else if (event.shiftKey || event.buttons === 2) eye.move(right, down, ...size);
    else eye.turn(right, down);
    held.set(event.pointerId, now);
    draw();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    going += 1;
    // Lines and pages are so many pixels.
    eye.approach(Math.exp(0.001 * event.deltaY * [1, 16, 400][event.deltaMode]));
    draw();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (isBrowsers(event)) return;
    going += 1;
    const arrow = arrowOf(event);
    const way = arrow?.map((part) => 24 * part);
    if (arrow && event.shiftKey) eye.move(...way, canvas.clientWidth, canvas.clientHeight);
    else if (arrow) eye.turn(...way);
    else if (event.key === "+" || event.key === "=") eye.approach(0.9);
    else if (event.key === "-") eye.approach(1 / 0.9);
    else if (event.key === "0") go(eye.first);
    else return;
    event.preventDefault();
    draw();
  });
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const arrowOf = (event) => ARROWS[event.key];
// With these the browser zooms, or goes back.
const isBrowsers = (event) => event.ctrlKey || event.altKey || event.metaKey;

function followFlat(canvas) {
  [canvas.width, canvas.height] = [columns, rows];
  const within = (value, count) => Math.min(count - 1, Math.max(0, Math.floor(value)));
  const pointAt = (x, y) => point(within(y, rows) * columns + within(x, columns));
  const follow = ({ offsetX, offsetY }) =>
    pointAt((offsetX / canvas.clientWidth) * columns, (offsetY / canvas.clientHeight) * rows);
  canvas.addEventListener("pointermove", follow);
  canvas.addEventListener("pointerdown", follow);
  canvas.addEventListener("keydown", (event) => {
    const arrow = arrowOf(event);
    if (!arrow || isBrowsers(event)) return;
    event.preventDefault();
    const [right, down] = arrow.map((part) => part * (event.shiftKey ? 10 : 1));
    const at = pixel ?? Math.floor(rows / 2) * columns + Math.floor(columns / 2);
    pointAt((at % columns) + right, Math.floor(at / columns) + down);
  });
}

function say(message) {
  element("message").textContent = message;
  element("message").hidden = false;
}

async function start() {
  for (const name of ["disparities", "confidence", "truth"]) maps[name] = await numbersOf(name);
  for (const name of ["reasons", "errors"]) maps[name] = await placesOf(name);
  maps.image = await pixelsOfImage();
  space = new Space(maps.disparities);
  if (camera) maps.depths = space.z;
  eye = new Eye(space);
  element("colouring").append(...facts.colourings.map(({ label }) => new Option(label)));
  element("least").value = facts.least_confidence;
  element("least-label").hidden = !maps.confidence;
  element("left-figure").hidden = !maps.image;
  element("message").hidden = true;
  reserve();
  window.addEventListener("resize", reserve);
  for (const name of ["left", "map"]) followFlat(element(name));
  if (maps.image) {
    element("left").getContext("2d").putImageData(new ImageData(maps.image, columns), 0, 0);
  }
  const canvas = element("cloud");
  try {
    cloud = new Cloud(canvas, space, maps.confidence);
    followPointers(canvas);
    canvas.addEventListener("webglcontextlost", () => {
      say("The graphics processor has let go of the points: load the page again.");
    });
    if (!space.z.some((z) => z > 0)) say("No pixel of this map has a point.");
  } catch (error) {
    say(`${error.message} The flat pictures and their numbers are here all the same.`);
    canvas.hidden = true;
    for (const name of ["size", "reset", "left-camera"]) element(name).disabled = true;
  }
  tellCount();
  colour();
  element("colouring").addEventListener("change", colour);
  for (const name of ["least", "size"]) {
    element(name).addEventListener("input", () => (tellCount(), draw()));
  }
  element("reset").addEventListener("click", () => go(eye.first));
  element("left-camera").addEventListener("click", () => go(eye.left));
  new ResizeObserver(draw).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  document.querySelector("main").removeAttribute("aria-busy");
}

start().catch((error) => say(`This page cannot be shown here: ${error.message}`));
