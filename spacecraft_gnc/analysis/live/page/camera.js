// A picture in orthographic projection on a plain canvas that a drag turns.

const TURN = 0.008; // [rad] for each pixel of a drag

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];
export const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
// By a rotation, row-major.
export const rotate = (r, v) => [0, 1, 2].map((i) => r[3 * i] * v[0] + r[3 * i + 1] * v[1] + r[3 * i + 2] * v[2]);

export class Camera {
  constructor(canvas, colors, redraw) {
    this.canvas = canvas;
    this.colors = colors;
    this.azimuth = 0.6;
    this.elevation = 0.42;
    this.scale = 1; // [px] of a unit
    this.middle = [0, 0, 0]; // what is in the middle of the picture
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

  begin() {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: w, clientHeight: h } = this.canvas;
    this.canvas.width = Math.round(w * ratio);
    this.canvas.height = Math.round(h * ratio);
    this.pen = this.canvas.getContext("2d");
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.lineCap = this.pen.lineJoin = "round";
    this.center = [w / 2, h / 2];
    this.size = Math.min(w, h);
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    this.toward = [ce * ca, ce * sa, se];
    this.right = [-sa, ca, 0];
    this.up = cross(this.toward, this.right);
  }

  // Picture coordinates [px] and depth (positive: near) of a point.
  project(v) {
    const p = v.map((value, i) => value - this.middle[i]);
    const [x, y] = [dot(p, this.right), dot(p, this.up)];
    return [this.center[0] + this.scale * x, this.center[1] - this.scale * y, dot(p, this.toward)];
  }

  // The faces that are seen of boxes in a body with an attitude at a place, the far ones first.
  solid(faces, attitude, position) {
    const placed = faces.map(({ corners, normal, color }) => {
      const shown = corners.map((c) => this.project(plus(position, rotate(attitude, c))));
      const facing = dot(rotate(attitude, normal), this.toward);
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

  // Through points of the picture.
  path(points, color, width, fill = "") {
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

  line(from, to, color, width, dash = []) {
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

  dot(at, color, radius) {
    const { pen } = this;
    pen.beginPath();
    pen.arc(at[0], at[1], radius, 0, 2 * Math.PI);
    pen.fillStyle = color;
    pen.fill();
  }

  text(text, at, color) {
    this.pen.font = "600 13px system-ui, 'DejaVu Sans', sans-serif";
    this.pen.textAlign = "center";
    this.pen.textBaseline = "middle";
    this.pen.fillStyle = color;
    this.pen.fillText(text, at[0], at[1]);
  }
}

export function boxFaces(center, half, color) {
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
