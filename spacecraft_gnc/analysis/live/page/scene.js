// The unit sphere in orthographic projection: body, trails of its axes, target, pointing zones.
// Drawn on a plain canvas. What lies on the far side of the sphere is drawn faint.

import { Camera, boxFaces, dot, rotate } from "./camera.js";

const AXES = ["x", "y", "z"];
const FAR = 0.22; // opacity of the far side
const RADIUS = 0.41; // of the sphere, in widths of the canvas
const HALF = [0.17, 0.12, 0.12]; // half sides of the body
const PANELS = [[0, 0.36, 0], [0, -0.36, 0]]; // centers of the solar panels
const PANEL = [0.1, 0.2, 0.008];

// Column i of a row-major rotation: body axis i in the inertial frame.
export const bodyAxis = (r, i) => [r[i], r[3 + i], r[6 + i]];

// Body axis i of a quaternion x, y, z, w, body to inertial.
function quaternionAxis([x, y, z, w], i) {
  if (i === 0) return [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)];
  if (i === 1) return [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)];
  return [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)];
}

export class Scene extends Camera {
  constructor(canvas, colors, redraw) {
    super(canvas, colors, redraw);
    this.tips = {}; // where the tips of the body axes were drawn [px], and their depth
  }

  draw(frame, setup, trail) {
    this.begin();
    this.radius = this.scale = RADIUS * this.size;
    this.#sphere(setup?.graticule ?? []);
    setup?.zones.forEach((zone, i) => this.#cap(zone, setup.rims[i]));
    this.#trails(trail);
    if (frame?.target) this.#marks(frame.target, 7, [3, 3]);
    if (frame?.reference) this.#marks(frame.reference, 3.5, []);
    if (frame?.attitude) this.#body(frame.attitude, setup);
    if (frame?.attitude) this.#wheels(frame, setup?.wheels ?? []);
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
      const [foot, tip, label] = [1, 1.09, 1.16].map((f) => this.project(axis.map((v) => f * v)));
      pen.globalAlpha = foot[2] >= 0 ? 1 : 0.45;
      this.line(foot, tip, "#93a1b1", 1.2);
      this.text(AXES[i].toUpperCase(), label, "#93a1b1");
      pen.globalAlpha = 1;
    });
  }

  // A curve on the sphere, its far side faint.
  #curve(points, color, width, dash = []) {
    const shown = points.map((p) => this.project(p));
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
    const rim = border.map((p) => this.project(p));
    for (const side of [-1, 1]) this.#fillCap(rim, angle > Math.PI / 2, side, color, zone);
    this.#curve(border, color, 1.5);
    const at = this.project(zone.inertial_axis);
    this.pen.globalAlpha = at[2] >= 0 ? 1 : FAR;
    this.text(zone.name, [at[0], at[1] - this.radius * Math.sin(angle) - 9], color);
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
      const [x, y, depth] = this.project(bodyAxis(rotation, i));
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
    const axes = AXES.map((name, i) => [name, this.project(bodyAxis(rotation, i))]);
    const arrow = ([name, tip]) => {
      this.pen.globalAlpha = tip[2] >= 0 ? 1 : 0.5;
      this.#arrow(tip, this.colors[name], name);
      this.tips[name] = tip;
    };
    axes.filter(([, tip]) => tip[2] < 0).forEach(arrow);
    this.#box(rotation);
    for (const zone of setup?.zones ?? []) {
      const tip = this.project(rotate(rotation, zone.body_axis));
      this.line(this.project([0, 0, 0]), tip, this.colors.warn, 1.2, [2, 3]);
    }
    axes.filter(([, tip]) => tip[2] >= 0).forEach(arrow);
    this.pen.globalAlpha = 1;
  }

  // The rim of each wheel, red where it is lost, an arc on it as long as the wheel is fast, from its
  // mark on, and a cross where it is excluded on board. The near ones are drawn last.
  #wheels({ attitude, turning, healthy, diagnosed }, rims) {
    const wheels = rims.map((rim, i) => ({ i, rim: rim.map((p) => this.project(rotate(attitude, p))) }));
    const depth = ({ rim }) => rim[0][2] + rim[rim.length >> 1][2];
    for (const { i, rim } of wheels.sort((a, b) => depth(a) - depth(b))) {
      const last = rim.length - 1, quarter = last / 4;
      const color = healthy?.[i] === false ? this.colors.bad : componentColor(this.colors, i);
      const share = Math.max(-1, Math.min(1, turning?.[i] ?? 0));
      const steps = Math.round(last * Math.abs(share));
      this.pen.globalAlpha = depth({ rim }) >= 0 ? 1 : 0.7;
      this.path(rim, color, 1.4, "rgba(16, 21, 28, 0.55)");
      this.path(share < 0 ? rim.slice(last - steps) : rim.slice(0, steps + 1), color, 5);
      if (diagnosed?.[i] === false) {
        this.line(rim[0], rim[2 * quarter], this.colors.bad, 2.5);
        this.line(rim[quarter], rim[3 * quarter], this.colors.bad, 2.5);
      }
      const middle = [0, 1].map((j) => (rim[0][j] + rim[2 * quarter][j]) / 2);
      const out = [middle[0] - this.center[0], middle[1] - this.center[1]];
      const length = Math.max(Math.hypot(...out), 1), beyond = this.radius * 0.13 + 12;
      this.text(`${i + 1}`, middle.map((m, j) => m + (beyond * out[j]) / length), color);
    }
    this.pen.globalAlpha = 1;
  }

  #box(rotation) {
    const faces = [[[0, 0, 0], HALF, "#c9d3df"], ...PANELS.map((c) => [c, PANEL, "#3d63a8"])]
      .flatMap(([center, half, color]) => boxFaces(center, half, color));
    this.solid(faces, rotation, [0, 0, 0]);
  }

  #arrow(tip, color, name) {
    const { pen } = this;
    this.line(this.center, tip, color, 2.2);
    pen.beginPath();
    pen.arc(tip[0], tip[1], 4, 0, 2 * Math.PI);
    pen.fillStyle = color;
    pen.fill();
    const out = [tip[0] - this.center[0], tip[1] - this.center[1]];
    const length = Math.max(Math.hypot(...out), 1);
    this.text(name, [tip[0] + (13 * out[0]) / length, tip[1] + (13 * out[1]) / length], color);
  }
}

// Of component i of a vector, and of wheel i.
export const componentColor = (colors, i) =>
  [colors.x, colors.y, colors.z, "#d58fd0", "#f2b134", "#c9d3df"][i % 6];
