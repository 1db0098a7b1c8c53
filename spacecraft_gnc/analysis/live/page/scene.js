// The unit sphere in orthographic projection: body, trails of its axes, target, pointing zones.
// Drawn on a plain canvas. What lies on the far side of the sphere is drawn faint.

const AXES = ["x", "y", "z"];
const FAR = 0.22; // opacity of the far side
const RADIUS = 0.41; // of the sphere, in widths of the canvas
const TURN = 0.008; // [rad] for each pixel of a drag
const HALF = [0.17, 0.12, 0.12]; // half sides of the body
const PANELS = [[0, 0.36, 0], [0, -0.36, 0]]; // centers of the solar panels
const PANEL = [0.1, 0.2, 0.008];

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];

// Column i of a row-major rotation: body axis i in the inertial frame.
export const bodyAxis = (r, i) => [r[i], r[3 + i], r[6 + i]];
const rotate = (r, v) => [0, 1, 2].map((i) => r[3 * i] * v[0] + r[3 * i + 1] * v[1] + r[3 * i + 2] * v[2]);

// Body axis i of a quaternion x, y, z, w, body to inertial.
function quaternionAxis([x, y, z, w], i) {
  if (i === 0) return [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)];
  if (i === 1) return [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)];
  return [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)];
}

export class Scene {
  constructor(canvas, colors, redraw) {
    this.canvas = canvas;
    this.colors = colors;
    this.azimuth = 0.6;
    this.elevation = 0.42;
    this.tips = {}; // where the tips of the body axes were drawn [px], and their depth
    let from = null;
    canvas.addEventListener("pointerdown", (e) => {
      from = [e.clientX, e.clientY];
      canvas.setPointerCapture(e.pointerId);
    });
    canvas.addEventListener("pointermove", (e) => {
      if (!from) return;
      this.azimuth -= (e.clientX - from[0]) * TURN;
      this.elevation += (e.clientY - from[1]) * TURN;
      this.elevation = Math.max(-1.55, Math.min(1.55, this.elevation));
      from = [e.clientX, e.clientY];
      redraw();
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { from = null; });
  }

  draw(frame, setup, trail) {
    this.#begin();
    this.#sphere(setup?.graticule ?? []);
    setup?.zones.forEach((zone, i) => this.#cap(zone, setup.rims[i]));
    this.#trails(trail);
    if (frame?.target) this.#marks(frame.target, 7, [3, 3]);
    if (frame?.reference) this.#marks(frame.reference, 3.5, []);
    if (frame?.attitude) this.#body(frame.attitude, setup);
    if (frame?.attitude) this.#wheels(frame, setup?.wheels ?? []);
  }

  #begin() {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: w, clientHeight: h } = this.canvas;
    this.canvas.width = Math.round(w * ratio);
    this.canvas.height = Math.round(h * ratio);
    this.pen = this.canvas.getContext("2d");
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.lineCap = this.pen.lineJoin = "round";
    this.center = [w / 2, h / 2];
    this.radius = RADIUS * Math.min(w, h);
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    this.toward = [ce * ca, ce * sa, se];
    this.right = [-sa, ca, 0];
    this.up = cross(this.toward, this.right);
  }

  // Picture coordinates [px] and depth (positive: near) of an inertial vector.
  #project(v) {
    const [x, y] = [dot(v, this.right), dot(v, this.up)];
    return [this.center[0] + this.radius * x, this.center[1] - this.radius * y, dot(v, this.toward)];
  }

  #sphere(graticule) {
    const { pen } = this;
    pen.beginPath();
    pen.arc(...this.center, this.radius, 0, 2 * Math.PI);
    pen.fillStyle = "#141b25";
    pen.fill();
    for (const line of graticule) this.#curve(line, "#3a4858", 0.7);
    pen.beginPath();
    pen.arc(...this.center, this.radius, 0, 2 * Math.PI);
    pen.strokeStyle = "#6d7d8f";
    pen.lineWidth = 1;
    pen.stroke();
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis, i) => {
      const [foot, tip, label] = [1, 1.09, 1.16].map((f) => this.#project(axis.map((v) => f * v)));
      pen.globalAlpha = foot[2] >= 0 ? 1 : 0.45;
      this.#line(foot, tip, "#93a1b1", 1.2);
      this.#text(AXES[i].toUpperCase(), label, "#93a1b1");
      pen.globalAlpha = 1;
    });
  }

  // A curve on the sphere, its far side faint.
  #curve(points, color, width, dash = []) {
    const shown = points.map((p) => this.#project(p));
    const { pen } = this;
    pen.strokeStyle = color;
    pen.lineWidth = width;
    pen.setLineDash(dash);
    for (const near of [false, true]) {
      pen.globalAlpha = near ? 1 : FAR;
      pen.beginPath();
      for (let k = 1; k < shown.length; k += 1) {
        if ((shown[k][2] >= 0) !== near) continue;
        pen.moveTo(shown[k - 1][0], shown[k - 1][1]);
        pen.lineTo(shown[k][0], shown[k][1]);
      }
      pen.stroke();
    }
    pen.globalAlpha = 1;
    pen.setLineDash([]);
  }

  // A zone, and the circle (points) where its cone cuts the sphere.
  #cap(zone, border) {
    const color = zone.kind === "exclusion" ? this.colors.bad : this.colors.good;
    const angle = (zone.half_angle_deg * Math.PI) / 180;
    const rim = border.map((p) => this.#project(p));
    for (const side of [-1, 1]) this.#fillCap(rim, angle > Math.PI / 2, side, color, zone);
    this.#curve(border, color, 1.5);
    const at = this.#project(zone.inertial_axis);
    this.pen.globalAlpha = at[2] >= 0 ? 1 : FAR;
    this.#text(zone.name, [at[0], at[1] - this.radius * Math.sin(angle) - 9], color);
    this.pen.globalAlpha = 1;
  }

  // The part of a cap on one side of the limb. Points of its rim beyond the limb are put on it, so
  // that the outline runs along the limb between the two crossings.
  #fillCap(rim, isLarge, side, color, zone) {
    const inside = rim.some((p) => side * p[2] >= 0);
    const middle = side * dot(zone.inertial_axis, this.toward) > 0;
    if (!inside && !(isLarge && middle)) return;
    const { pen } = this;
    pen.beginPath();
    if (isLarge) pen.arc(...this.center, this.radius, 0, 2 * Math.PI);
    if (inside) {
      rim.forEach((p, k) => {
        const out = [p[0] - this.center[0], p[1] - this.center[1]];
        const scale = side * p[2] >= 0 ? 1 : this.radius / Math.max(Math.hypot(...out), 1e-9);
        pen[k ? "lineTo" : "moveTo"](this.center[0] + scale * out[0], this.center[1] + scale * out[1]);
      });
      pen.closePath();
    }
    pen.globalAlpha = side > 0 ? 0.35 : 0.35 * FAR;
    pen.fillStyle = color;
    pen.fill("evenodd");
    pen.globalAlpha = 1;
  }

  #trails(trail) {
    if (!trail.length) return;
    AXES.forEach((name, i) => {
      this.#curve(trail.map((q) => quaternionAxis(q, i)), this.colors[name], 1.6);
    });
  }

  // Rings where the axes of an attitude pierce the sphere.
  #marks(rotation, size, dash) {
    const { pen } = this;
    AXES.forEach((name, i) => {
      const [x, y, depth] = this.#project(bodyAxis(rotation, i));
      pen.globalAlpha = depth >= 0 ? 1 : 2 * FAR;
      pen.setLineDash(dash);
      pen.beginPath();
      pen.arc(x, y, size, 0, 2 * Math.PI);
      pen.strokeStyle = this.colors[name];
      pen.lineWidth = 1.6;
      pen.stroke();
    });
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }

  #body(rotation, setup) {
    const axes = AXES.map((name, i) => [name, this.#project(bodyAxis(rotation, i))]);
    const arrow = ([name, tip]) => {
      this.pen.globalAlpha = tip[2] >= 0 ? 1 : 0.5;
      this.#arrow(tip, this.colors[name], name);
      this.tips[name] = tip;
    };
    axes.filter(([, tip]) => tip[2] < 0).forEach(arrow);
    this.#box(rotation);
    for (const zone of setup?.zones ?? []) {
      const tip = this.#project(rotate(rotation, zone.body_axis));
      this.#line(this.#project([0, 0, 0]), tip, this.colors.warn, 1.2, [2, 3]);
    }
    axes.filter(([, tip]) => tip[2] >= 0).forEach(arrow);
    this.pen.globalAlpha = 1;
  }

  // The rim of each wheel, red where it is lost, an arc on it as long as the wheel is fast, from its
  // mark on, and a cross where it is excluded on board. The near ones are drawn last.
  #wheels({ attitude, turning, healthy, diagnosed }, rims) {
    const wheels = rims.map((rim, i) => ({ i, rim: rim.map((p) => this.#project(rotate(attitude, p))) }));
    const depth = ({ rim }) => rim[0][2] + rim[rim.length >> 1][2];
    for (const { i, rim } of wheels.sort((a, b) => depth(a) - depth(b))) {
      const last = rim.length - 1, quarter = last / 4;
      const color = healthy?.[i] === false ? this.colors.bad : componentColor(this.colors, i);
      const share = Math.max(-1, Math.min(1, turning?.[i] ?? 0));
      const steps = Math.round(last * Math.abs(share));
      this.pen.globalAlpha = depth({ rim }) >= 0 ? 1 : 0.7;
      this.#path(rim, color, 1.4, "rgba(16, 21, 28, 0.55)");
      this.#path(share < 0 ? rim.slice(last - steps) : rim.slice(0, steps + 1), color, 5);
      if (diagnosed?.[i] === false) {
        this.#line(rim[0], rim[2 * quarter], this.colors.bad, 2.5);
        this.#line(rim[quarter], rim[3 * quarter], this.colors.bad, 2.5);
      }
      const middle = [0, 1].map((j) => (rim[0][j] + rim[2 * quarter][j]) / 2);
      const out = [middle[0] - this.center[0], middle[1] - this.center[1]];
      const length = Math.max(Math.hypot(...out), 1), beyond = this.radius * 0.13 + 12;
      this.#text(`${i + 1}`, middle.map((m, j) => m + (beyond * out[j]) / length), color);
    }
    this.pen.globalAlpha = 1;
  }

  #path(points, color, width, fill = "") {
    const { pen } = this;
    pen.beginPath();
    points.forEach((p, k) => pen[k ? "lineTo" : "moveTo"](p[0], p[1]));
    if (fill) {
      pen.fillStyle = fill;
      pen.fill();
    }
    pen.strokeStyle = color;
    pen.lineWidth = width;
    if (points.length > 1) pen.stroke();
  }

  #box(rotation) {
    const faces = [[[0, 0, 0], HALF, "#c9d3df"], ...PANELS.map((c) => [c, PANEL, "#3d63a8"])]
      .flatMap(([center, half, color]) => boxFaces(center, half, color));
    const placed = faces.map(({ corners, normal, color }) => {
      const shown = corners.map((c) => this.#project(rotate(rotation, c)));
      const facing = dot(rotate(rotation, normal), this.toward);
      return { shown, facing, color, depth: shown.reduce((sum, p) => sum + p[2], 0) };
    });
    const { pen } = this;
    for (const face of placed.sort((a, b) => a.depth - b.depth)) {
      if (face.facing <= 0) continue;
      pen.beginPath();
      face.shown.forEach((p, k) => pen[k ? "lineTo" : "moveTo"](p[0], p[1]));
      pen.closePath();
      pen.fillStyle = face.color;
      pen.fill();
      pen.fillStyle = `rgba(8, 12, 18, ${0.65 * (1 - face.facing)})`; // shade
      pen.fill();
      pen.strokeStyle = "#10151c";
      pen.lineWidth = 0.8;
      pen.stroke();
    }
  }

  #arrow(tip, color, name) {
    const { pen } = this;
    this.#line(this.center, tip, color, 2.2);
    pen.beginPath();
    pen.arc(tip[0], tip[1], 4, 0, 2 * Math.PI);
    pen.fillStyle = color;
    pen.fill();
    const out = [tip[0] - this.center[0], tip[1] - this.center[1]];
    const length = Math.max(Math.hypot(...out), 1);
    this.#text(name, [tip[0] + (13 * out[0]) / length, tip[1] + (13 * out[1]) / length], color);
  }

  #line(from, to, color, width, dash = []) {
    const { pen } = this;
    pen.setLineDash(dash);
    pen.beginPath();
    pen.moveTo(from[0], from[1]);
    pen.lineTo(to[0], to[1]);
    pen.strokeStyle = color;
    pen.lineWidth = width;
    pen.stroke();
    pen.setLineDash([]);
  }

  #text(text, at, color) {
    this.pen.font = "600 13px system-ui, 'DejaVu Sans', sans-serif";
    this.pen.textAlign = "center";
    this.pen.textBaseline = "middle";
    this.pen.fillStyle = color;
    this.pen.fillText(text, at[0], at[1]);
  }
}

// Of component i of a vector, and of wheel i.
export const componentColor = (colors, i) =>
  [colors.x, colors.y, colors.z, "#d58fd0", "#f2b134", "#c9d3df"][i % 6];

function boxFaces(center, half, color) {
  const faces = [];
  for (const i of [0, 1, 2]) {
    for (const sign of [-1, 1]) {
      const normal = [0, 0, 0];
      normal[i] = sign;
      const [j, k] = [(i + 1) % 3, (i + 2) % 3];
      const corners = [[1, 1], [1, -1], [-1, -1], [-1, 1]].map(([a, b]) => {
        const corner = [...center];
        corner[i] += sign * half[i];
        corner[j] += a * half[j];
        corner[k] += b * half[k];
        return corner;
      });
      faces.push({ corners, normal, color });
    }
  }
  return faces;
}
