// Points on the screen. They are drawn twice at once, in their colours and as their numbers, so that the
// one under the pointer is known without drawing again.

const VERTEX = `#version 300 es
in float depth;
in vec4 colour;
in float confidence;
uniform float least;
uniform int columns;
uniform vec2 principal;
// 1 / focal length, or 0 where a pixel is 1 wide at every depth.
uniform float narrowing;
uniform mat3 turn;
uniform vec3 target;
uniform vec3 offset;
// From slopes to the screen's half width and height, and by how much that is off its middle.
uniform vec2 stretch;
uniform vec2 shift;
uniform float nearest;
uniform float dot;
flat out vec4 shade;
flat out uint number;
void main() {
  vec2 pixel = vec2(float(gl_VertexID % columns), float(gl_VertexID / columns));
  float width = narrowing > 0.0 ? depth * narrowing : 1.0;
  vec3 eye = turn * (vec3((pixel - principal) * width, depth) - target) + offset;
  bool hidden = !(depth > 0.0) || !(confidence >= least);
  // What is hidden lies outside the screen.
  gl_Position = hidden ? vec4(2.0, 2.0, 2.0, 1.0)
    : vec4(vec2(1.0, -1.0) * (eye.xy * stretch + eye.z * shift), eye.z - 2.0 * nearest, eye.z);
  gl_PointSize = clamp(dot * width / eye.z, 1.0, 64.0);
  shade = colour;
  number = uint(gl_VertexID) + 1u;
}`;

const FRAGMENT = `#version 300 es
precision mediump float;
precision highp int;
flat in vec4 shade;
flat in uint number;
layout(location = 0) out vec4 colour;
layout(location = 1) out uint seen;
void main() {
  colour = vec4(shade.rgb, 1.0);
  seen = number;
}`;

// How far from the pointer a point may be, in pixels of the screen.
const REACH = 5;

class Cloud {
  // Throws where there is no WebGL 2.
  constructor(canvas, space, confidence) {
    const gl = canvas.getContext("webgl2", { antialias: false, depth: false });
    if (!gl) throw new Error("This browser has no WebGL 2, which the points in space need.");
    [this.canvas, this.gl, this.space] = [canvas, gl, space];
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      const why = gl.getProgramInfoLog(program);
      throw new Error(`This browser's WebGL 2 cannot draw the points: ${why}.`);
    }
    gl.useProgram(program);
    this.program = program;
    this.attribute("depth", space.z.map((z) => (z > 0 ? z : 0)), 1, gl.FLOAT);
    if (confidence) {
      // What is no number is never sure.
      this.attribute("confidence", confidence.map((sure) => (sure >= 0 ? sure : -1)), 1, gl.FLOAT);
    } else gl.vertexAttrib1f(gl.getAttribLocation(program, "confidence"), 1);
    gl.uniform1i(this.uniform("columns"), columns);
    gl.uniform2f(this.uniform("principal"), space.cx, space.cy);
    gl.uniform1f(this.uniform("narrowing"), camera ? 1 / space.focal : 0);
    gl.enable(gl.DEPTH_TEST);
    this.frame = gl.createFramebuffer();
    this.buffers = [0, 1, 2].map(() => gl.createRenderbuffer());
  }

  uniform(name) {
    return this.gl.getUniformLocation(this.program, name);
  }

  attribute(name, values, each, kind) {
    const gl = this.gl;
    const place = gl.getAttribLocation(this.program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, each, kind, kind === gl.UNSIGNED_BYTE, 0, 0);
    return gl.getParameter(gl.ARRAY_BUFFER_BINDING);
  }

  // Red, green, blue and anything for each pixel.
  colour(colours) {
    if (this.colours) this.gl.deleteBuffer(this.colours);
    this.colours = this.attribute("colour", colours, 4, this.gl.UNSIGNED_BYTE);
  }

  // The buffers of a screen of this size.
  resize(width, height) {
    const gl = this.gl;
    [this.canvas.width, this.canvas.height] = [width, height];
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    const places = [gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1, gl.DEPTH_ATTACHMENT];
    [gl.RGBA8, gl.R32UI, gl.DEPTH_COMPONENT24].forEach((format, at) => {
      gl.bindRenderbuffer(gl.RENDERBUFFER, this.buffers[at]);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, places[at], gl.RENDERBUFFER, this.buffers[at]);
    });
  }

  // As the eye sees the points (page.js), where the ground has this colour, each from 0 to 1.
  draw(eye, least, size, ground) {
    const gl = this.gl;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const sharp = [width, height].map((side) => Math.max(1, Math.round(side * devicePixelRatio)));
    if (sharp[0] !== this.canvas.width || sharp[1] !== this.canvas.height || !this.drawn) {
      this.resize(...sharp);
      this.drawn = true;
    }
    const { turn, target, offset, stretch, shift, zoom } = eye.seenOn(width, height);
    gl.uniformMatrix3fv(this.uniform("turn"), true, turn.flat());
    gl.uniform3fv(this.uniform("target"), target);
    gl.uniform3fv(this.uniform("offset"), offset);
    gl.uniform2fv(this.uniform("stretch"), stretch);
    gl.uniform2fv(this.uniform("shift"), shift);
    gl.uniform1f(this.uniform("nearest"), 0.01 * eye.distance);
    // More than a pixel is wide, so that surfaces close that are not seen as the left camera saw them.
    gl.uniform1f(this.uniform("dot"), 1.6 * size * zoom * this.space.focal * devicePixelRatio);
    gl.uniform1f(this.uniform("least"), least);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
    gl.viewport(0, 0, ...sharp);
    gl.clearBufferfv(gl.COLOR, 0, [...ground, 1]);
    gl.clearBufferuiv(gl.COLOR, 1, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    gl.drawArrays(gl.POINTS, 0, columns * rows);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.readBuffer(gl.COLOR_ATTACHMENT0);
    gl.blitFramebuffer(0, 0, ...sharp, 0, 0, ...sharp, gl.COLOR_BUFFER_BIT, gl.NEAREST);
  }

  // The pixel whose point lies nearest to a place on the canvas, null where there is none within reach.
  at(x, y) {
    const gl = this.gl;
    const reach = Math.round(REACH * devicePixelRatio);
    const side = 2 * reach + 1;
    const left = Math.floor(x * devicePixelRatio) - reach;
    const bottom = this.canvas.height - 1 - Math.floor(y * devicePixelRatio) - reach;
    const seen = new Uint32Array(4 * side * side);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.readBuffer(gl.COLOR_ATTACHMENT1);
    gl.readPixels(left, bottom, side, side, gl.RGBA_INTEGER, gl.UNSIGNED_INT, seen);
    let [best, least] = [null, Infinity];
    for (let place = 0; place < side * side; place += 1) {
      const away = Math.hypot((place % side) - reach, Math.floor(place / side) - reach);
      if (seen[4 * place] > 0 && away < least) [best, least] = [seen[4 * place] - 1, away];
    }
    return best;
  }
}
