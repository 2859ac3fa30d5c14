// Programs of the graphics card. Eye space: x to the right, y up, z towards the eye, which sits at the origin.

/** What all vertex shaders share: the camera. */
const CAMERA = `#version 300 es
precision highp float;
uniform mat3 turn;       // world to eye
uniform vec3 target;     // what the eye looks at
uniform vec4 lens;       // distance to the target, near, far, 1/tan of half the vertical angle
uniform float aspect;    // width over height
vec3 seen(vec3 p) { return turn * (p - target) - vec3(0.0, 0.0, lens.x); }
vec4 projected(vec3 p) {
  float n = lens.y, f = lens.z;
  return vec4(p.x * lens.w / aspect, p.y * lens.w, (p.z * (f + n) + 2.0 * f * n) / (n - f), -p.z);
}
`;

/** One instance a span between two nodes: a cubic tube whose direction turns evenly, as in the pictures. */
const TUBE_VERTEX = CAMERA + `
in vec2 corner;          // along the span 0 to 1, about it -1/2 to 1/2
in vec3 pointA, tangentA, directionA, valuesA, pointB, tangentB, directionB, valuesB;
in float radiusA, radiusB;
uniform vec3 pick;
uniform float pixel;
out vec3 at, normal;
out float value, angle;

vec3 carried(vec3 v, vec3 from, vec3 to) {
  float c = 1.0 + dot(from, to);
  return c < 1e-6 ? v : v - (from + to) * (dot(to, v) / c);
}

void main() {
  float u = corner.x, v = 1.0 - u, third = distance(pointA, pointB) / 3.0;
  vec3 b = pointA + tangentA * third, c = pointB - tangentB * third;
  vec3 p = pointA * (v * v * v) + b * (3.0 * v * v * u) + c * (3.0 * v * u * u) + pointB * (u * u * u);
  vec3 slope = (b - pointA) * (v * v) + (c - b) * (2.0 * u * v) + (pointB - c) * (u * u);
  vec3 t = length(slope) > 0.0 ? normalize(slope) : tangentA;
  vec3 end = carried(directionA, tangentA, tangentB);
  float twist = atan(dot(tangentB, cross(end, directionB)), dot(end, directionB));
  vec3 base = carried(directionA, tangentA, t);
  angle = 6.2831853 * corner.y;
  float phi = u * twist + angle;
  vec3 n = normalize(base * cos(phi) + cross(t, base) * sin(phi));
  vec3 axis = seen(p);
  // never thinner than can be seen
  float r = max(mix(radiusA, radiusB, u), -axis.z * pixel);
  at = axis + turn * n * r;
  normal = turn * n;
  value = mix(dot(pick, valuesA), dot(pick, valuesB), u);
  gl_Position = projected(at);
}
`;

/** The round end of an open rod. */
const BALL_VERTEX = CAMERA + `
in vec3 corner;          // on the unit sphere
in vec3 pointA, valuesA;
in float radiusA;
uniform vec3 pick;
uniform float pixel;
out vec3 at, normal;
out float value, angle;
void main() {
  vec3 center = seen(pointA);
  at = center + corner * max(radiusA, -center.z * pixel);
  normal = corner;
  value = dot(pick, valuesA);
  angle = 3.0;
  gl_Position = projected(at);
}
`;

/** Points of rods too long for tubes. */
const LINE_VERTEX = CAMERA + `
in vec3 pointA, tangentA, valuesA;
uniform vec3 pick;
out vec3 at, normal;
out float value, angle;
void main() {
  at = seen(pointA);
  vec3 t = turn * tangentA, eye = normalize(-at);
  vec3 n = eye - t * dot(t, eye);
  normal = length(n) > 1e-3 ? normalize(n) : eye;
  value = dot(pick, valuesA);
  angle = 3.0;
  gl_Position = projected(at);
}
`;

/** One instance an arrow. */
const ARROW_VERTEX = CAMERA + `
in vec4 corner;          // along 0 to 1, distance from the axis, slope of the normal, turn 0 to 1
in vec3 foot, force;
uniform float size, thick, off;
out vec3 at, normal;
out float value, angle;
void main() {
  vec3 t = normalize(force);
  vec3 e = normalize(abs(t.x) < 0.6 ? cross(t, vec3(1, 0, 0)) : cross(t, vec3(0, 1, 0)));
  float phi = 6.2831853 * corner.w;
  vec3 around = e * cos(phi) + cross(t, e) * sin(phi);
  // short arrows are all head, and smaller
  float whole = size * length(force), head = 3.0 * thick, fit = min(1.0, whole / head);
  float along = corner.x < 0.25 ? 0.0 : (corner.x < 0.75 ? max(whole - head, 0.0) : whole);
  at = seen(foot + t * (off + along) + around * corner.y * thick * fit);
  normal = turn * normalize(around + t * corner.z);
  value = 0.0;
  angle = 3.0;
  gl_Position = projected(at);
}
`;

/** Surfaces: key light from the upper left, fill, sky and floor, a soft highlight, the back a little faded. */
const SURFACE = `#version 300 es
precision highp float;
in vec3 at, normal;
in float value, angle;
uniform sampler2D palette;
uniform vec2 range;
uniform vec3 plain, stripe;
uniform float usesPalette, stripeAngle;
out vec4 color;
void main() {
  vec3 n = normalize(normal), eye = normalize(-at);
  float x = clamp((value - range.x) / (range.y - range.x), 0.0, 1.0);
  vec3 albedo = mix(plain, texture(palette, vec2((x * 16.0 + 0.5) / 17.0, 0.5)).rgb, usesPalette);
  float width = max(fwidth(angle), 1e-3);
  albedo = mix(albedo, stripe, 1.0 - smoothstep(-width, width, abs(angle) - stripeAngle));
  albedo = pow(albedo, vec3(2.2));
  vec3 key = normalize(vec3(-0.45, 0.75, 0.65)), fill = normalize(vec3(0.8, -0.1, 0.5));
  float sky = 0.5 + 0.5 * n.y;
  vec3 light = vec3(0.95) * max(dot(n, key), 0.0) + vec3(0.16) * max(dot(n, fill), 0.0)
    + mix(vec3(0.22, 0.215, 0.21), vec3(0.36, 0.37, 0.39), sky);
  vec3 half_ = normalize(key + eye);
  float shine = 0.16 * pow(max(dot(n, half_), 0.0), 48.0) + 0.05 * pow(1.0 - max(dot(n, eye), 0.0), 3.0);
  color = vec4(pow(albedo * light + shine, vec3(1.0 / 2.2)), 1.0);
}
`;

const SCREEN_VERTEX = `#version 300 es
out vec2 place;
void main() {
  place = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
  gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}
`;

/** Background, the depth's fading, and the shade that surfaces near each other cast (from the depth buffer). */
const SCREEN = `#version 300 es
precision highp float;
in vec2 place;
uniform sampler2D drawn, depth;
uniform vec4 lens;
uniform float aspect, reach, strength, spread;
uniform vec3 above, below;
out vec4 color;

float away(vec2 uv) {
  float n = lens.y, f = lens.z;
  return 2.0 * n * f / (f + n - (2.0 * texture(depth, uv).r - 1.0) * (f - n));
}
vec3 point(vec2 uv) {
  float z = away(uv);
  return vec3((2.0 * uv - 1.0) * vec2(aspect, 1.0) / lens.w * z, -z);
}
vec3 nearer(vec3 a, vec3 b) { return abs(a.z) < abs(b.z) ? a : b; }

float open() {
  vec3 p = point(place);
  vec2 pixel = 1.0 / vec2(textureSize(depth, 0));
  vec3 dx = nearer(point(place + vec2(pixel.x, 0)) - p, p - point(place - vec2(pixel.x, 0)));
  vec3 dy = nearer(point(place + vec2(0, pixel.y)) - p, p - point(place - vec2(0, pixel.y)));
  vec3 n = normalize(cross(dx, dy));
  float radius = min(0.5 * reach * lens.w / -p.z, 0.25);
  float start = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  float shade = 0.0;
  const int COUNT = 32;
  for (int i = 0; i < COUNT; i++) {
    float k = (float(i) + 0.5) / float(COUNT), phi = 6.2831853 * (start + float(i) * 0.618034);
    vec3 v = point(place + radius * sqrt(k) * vec2(cos(phi) / aspect, sin(phi))) - p;
    float d = length(v);
    shade += max(dot(n, v) / max(d, 1e-9) - 0.08, 0.0) * max(1.0 - d / reach, 0.0);
  }
  return 1.0 - strength * min(3.2 * shade / float(COUNT), 1.0);
}

void main() {
  vec3 back = mix(below, above, smoothstep(0.0, 1.0, place.y));
  vec4 c = texture(drawn, place);
  if (texture(depth, place).r < 1.0) {
    float far = clamp((away(place) - lens.x) / spread, 0.0, 1.0);
    float o = strength > 0.0 ? open() : 1.0;
    c.rgb = mix(c.rgb * o, back * c.a, 0.38 * far);
  }
  color = vec4(c.rgb + back * (1.0 - c.a), 1.0);
}
`;
