// The formed sheet on the graphics card. Colours are written as sRGB; textures are not converted.

// What is shown, for the shader.
export const kinds = {print: 0, contact: 1, heat: 2} as const;

export const vertexShader = /* glsl */ `
in vec2 pattern;   // mm
in vec2 marks;     // contact, chart
in float value;    // of the heat map; -1: none
uniform int kind;
uniform mat3 place;  // from the drawing to the pictures, for a preview of a moved drawing
out vec2 vSheet, vMoved, vValue, vAcross;  // vValue: what the map shows, and 1 where it has a value
out float vChart;
out vec3 vNormal, vEye, vUp;

void main() {
  vSheet = uv;
  vMoved = (place * vec3(pattern, 1.0)).xy;
  vChart = marks.y;
  // Contact has a value over the mold: not on the platform or in the clamp frame.
  vValue = kind == 1 ? vec2(marks.x == 1.0 ? 1.0 : 0.0, marks.x < 2.0 ? 1.0 : 0.0) : vec2(value, value < 0.0 ? 0.0 : 1.0);
  vec4 eye = modelViewMatrix * vec4(position, 1.0);
  vNormal = normalMatrix * normal;
  vEye = eye.xyz;
  vUp = viewMatrix[2].xyz;
  gl_Position = projectionMatrix * eye;
  vAcross = gl_Position.xw;
}`;

export const fragmentShader = /* glsl */ `
in vec2 vSheet, vMoved, vValue, vAcross;
in float vChart;
in vec3 vNormal, vEye, vUp;
uniform int kind;
uniform bool overInk;    // the ink stays visible
uniform float cut;       // left of this share of the width: printed as drawn
uniform bool onPrint;    // the overlay is shown on the print alone
uniform bool moved;      // the drawing at its new place instead of the print
uniform vec3 range;      // low, high, step of the isolines (0: none)
uniform vec3 outline, noValue, touches, touchesNot;
uniform sampler2D printed, drawn, ramp, overlay;
out vec4 colour;

float isoline(float v) {
  float w = length(vec2(dFdx(v), dFdy(v)));
  if (w < 1e-4) return 0.0;  // a plateau
  float e = abs(fract(v - 0.5) - 0.5) / w;
  return (1.0 - smoothstep(0.5, 1.5, e)) * (1.0 - smoothstep(0.3, 0.6, w));
}

void main() {
  vec3 normal = normalize(vNormal), eye = normalize(-vEye);
  float facing = dot(normal, eye);
  if (facing < 0.0) normal = -normal, facing = -facing;
  float light = 0.5 + 0.5 * dot(normal, normalize(eye + vUp));
  bool asDrawn = 0.5 + 0.5 * vAcross.x / vAcross.y < cut;
  vec3 ink = asDrawn ? texture(drawn, vSheet).rgb : texture(printed, vSheet).rgb;
  if (moved) ink = vChart > 0.99 ? texture(drawn, vMoved).rgb : vec3(1.0);

  vec3 c;
  if (kind == 0) {
    c = ink * mix(0.42, 0.98, light * light);
  } else {
    if (kind == 1) {
      float stripes = step(0.5, fract(50.0 * (vSheet.x + vSheet.y)));
      c = vValue.x > 0.5 ? touches : mix(touchesNot, touchesNot * 0.55, stripes);
    } else {
      float share = (vValue.x - range.x) / (range.y - range.x);
      c = texture(ramp, vec2(share, 0.5)).rgb;
      if (range.z > 0.0) {
        float line = isoline(vValue.x / range.z);
        c = mix(c, vec3(dot(c, vec3(0.299, 0.587, 0.114)) > 0.45 ? 0.0 : 1.0), 0.6 * line);
      }
    }
    if (vValue.y < 0.99) c = noValue;
    c *= mix(0.85, 1.0, light);
    if (overInk) c *= mix(0.25, 1.0, min(ink.r, min(ink.g, ink.b)));
  }
  c = mix(outline, c, smoothstep(0.02, 0.12, facing));
  vec4 over = texture(overlay, vSheet);
  if (!(onPrint && asDrawn)) c = c * (1.0 - over.a) + over.rgb;
  colour = vec4(c, 1.0);
}`;
