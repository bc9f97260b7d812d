// Where the points are looked at from: a place on a sphere around what is looked at. Without any turn
// that is where the left camera stood, and the points are its image.

const product = (matrix, vector) =>
  matrix.map((row) => row.reduce((sum, factor, at) => sum + factor * vector[at], 0));

// Radians a pixel that is dragged.
const TURN = 0.006;
// Looking straight down or up is allowed, further is upside down.
const STEEPEST = Math.PI / 2;

class Eye {
  constructor(space) {
    this.space = space;
    const depth = space.median();
    // Through the middle of the image. Without a camera one looks from where it fills the screen.
    const { centre, cx, cy, focal } = space;
    this.direction = [(centre[0] - cx) / focal, (centre[1] - cy) / focal, 1];
    this.left = {
      target: this.direction.map((slope) => slope * depth),
      distance: camera ? depth : focal,
      yaw: 0,
      pitch: 0,
    };
    // From the side and from above, where one sees what a picture does not show.
    this.first = { ...this.left, distance: 1.3 * this.left.distance, yaw: 0.45, pitch: 0.3 };
    Object.assign(this, this.first);
  }

  turn(right, down) {
    this.yaw += TURN * right;
    this.pitch = Math.min(STEEPEST, Math.max(-STEEPEST, this.pitch + TURN * down));
  }

  // By pixels of a canvas of this size.
  move(right, down, width, height) {
    const { turn, zoom } = this.seenOn(width, height);
    const each = this.distance / (this.space.focal * zoom);
    const back = [0, 1, 2].map((column) => turn.map((row) => row[column]));
    const way = product(back, [right * each, down * each, 0]);
    this.target = this.target.map((coordinate, at) => coordinate - way[at]);
  }

  approach(factor) {
    this.distance *= factor;
  }

  // What turns points to the eye and puts them on a screen of this size, which the whole image fits.
  seenOn(width, height) {
    const [sy, cy] = [Math.sin(this.yaw), Math.cos(this.yaw)];
    const [sp, cp] = [Math.sin(this.pitch), Math.cos(this.pitch)];
    const { centre, focal } = this.space;
    const zoom = Math.min(width / columns, height / rows);
    return {
      zoom,
      // About the vertical axis, then about the horizontal one.
      turn: [
        [cy, 0, -sy],
        [-sp * sy, cp, -sp * cy],
        [cp * sy, sp, cp * cy],
      ],
      target: this.target,
      offset: this.direction.map((slope) => slope * this.distance),
      stretch: [(2 * focal * zoom) / width, (2 * focal * zoom) / height],
      shift: [
        (2 * zoom * (this.space.cx - centre[0])) / width,
        (2 * zoom * (this.space.cy - centre[1])) / height,
      ],
    };
  }

  // Where on a canvas of this size a point is seen; null behind the eye.
  placeOf(point, width, height) {
    const { turn, target, offset, stretch, shift } = this.seenOn(width, height);
    const turned = product(turn, point.map((coordinate, at) => coordinate - target[at]));
    const [x, y, z] = turned.map((coordinate, at) => coordinate + offset[at]);
    if (!(z > 0)) return null;
    const half = (slope, at, side) => (side / 2) * (1 + slope * stretch[at] + shift[at]);
    return [half(x / z, 0, width), half(y / z, 1, height)];
  }
}
